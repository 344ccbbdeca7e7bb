//! The script that `lampyris new` writes.

use std::path::{Path, PathBuf};

use crate::error::{Error, Result};
use crate::output;

pub(super) const STARTER: &str = include_str!("starter.lua");

/// Writes `NAME.lua`, and returns its path.
///
/// Errors: a file of that name that is there already; [`Error::Io`].
pub fn write_starter(name: &str) -> Result<PathBuf> {
    let name = name.strip_suffix(".lua").unwrap_or(name);
    let path = Path::new(&format!("{name}.lua")).to_owned();
    if path.exists() {
        let found = format!("\"{}\"", path.display());
        return Err(Error::out_of_range("new", "name", found, "names that are not taken"));
    }
    output::write_text(&path, STARTER)?;
    Ok(path)
}
