//! Which program makes a sweep.

use std::sync::OnceLock;

use serde_json::{Map, Value, json};

use super::digest::Digest;

/// `Cargo.lock` of this build: the exact crates.
pub const LOCK_FILE: &str = include_str!("../../../Cargo.lock");

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

/// What this build is made from: digests of sources and lock file, and the compiler.
pub fn build() -> Value {
    json!({
        "sources": env!("LAMPYRIS_SOURCES"),
        "lock": Digest::of_bytes(LOCK_FILE.as_bytes()).as_str(),
        "compiler": env!("LAMPYRIS_COMPILER"),
    })
}

/// What this program differs in from the one that made something, in words; empty for the same
/// executable.
///
/// `made_by` holds `program`, `executable` and `build` as records do.
pub fn build_differences(made_by: &Map<String, Value>) -> Vec<String> {
    let executable = made_by.get("executable").and_then(Value::as_str);
    if executable.is_some() && executable == self::executable().map(Digest::as_str) {
        return Vec::new();
    }
    let text =
        |value: Option<&Value>| value.and_then(Value::as_str).unwrap_or("unknown").to_owned();
    let (build, made_by_build) = (build(), made_by.get("build").unwrap_or(&Value::Null));
    let rows = [("sources", "sources"), ("lock", "Cargo.lock"), ("compiler", "compiler")];
    let mut differences = Vec::new();
    let made_by = text(made_by.get("program"));
    if made_by != program() {
        differences.push(format!("made by {made_by}, this is {}", program()));
    }
    for (key, name) in rows {
        let [theirs, ours] = [made_by_build, &build].map(|build| text(build.get(key)));
        if theirs != ours {
            differences.push(format!("{name}: made from {theirs}, this program from {ours}"));
        }
    }
    if differences.is_empty() {
        differences.push(
            "another build of the same sources, Cargo.lock and compiler: with other flags, or with \
             folders of the machine that it was built on in it, which .ci/release leaves out"
                .to_owned(),
        );
    }
    differences
}
