//! Which program makes a sweep.

use std::sync::OnceLock;

use super::digest::Digest;

/// Name and version.
pub fn program() -> String {
    format!("lampyris {}", env!("CARGO_PKG_VERSION"))
}

/// Digest of the running executable: of two builds of a version, even from the same sources, none
/// can know that they compute the same bits. `None` where the system does not show it.
pub fn executable() -> Option<&'static Digest> {
    static EXECUTABLE: OnceLock<Option<Digest>> = OnceLock::new();
    let digest = || Digest::of_file(&std::env::current_exe().ok()?).ok();
    EXECUTABLE.get_or_init(digest).as_ref()
}
