//! The table of contents of an archive.

use std::path::{Component, Path, PathBuf};

use serde_json::{Map, Value, json};

use crate::error::{Error, Result};
use crate::program::sweep::{Digest, FileDigest};

/// Name of the first entry.
pub(super) const NAME: &str = "experiment.json";

const FORMAT: &str = "lampyris archive 1";

/// Folder of what the script reads, and of the script.
pub(super) const FILES: &str = "files";

/// Folder of records and tables, with which a replay is compared.
pub(super) const EXPECTED: &str = "expected";

/// What an archive holds, and what comes out of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Experiment {
    /// The record of the sweep or study: program, arguments.
    pub made_by: Map<String, Value>,
    /// The script, below the archive's root.
    pub script: String,
    /// What the script got from the command line.
    pub arguments: Vec<String>,
    /// Name of the folder that the script wrote.
    pub folder: String,
    /// The other entries.
    pub entries: Vec<Listed>,
    /// Files of the folder.
    pub outputs: Vec<FileDigest>,
}

/// An entry of an archive.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Listed {
    /// Below the archive's root, of plain names joined by `/`.
    pub path: String,
    /// Bytes.
    pub size: u64,
    /// Of its bytes.
    pub digest: Digest,
}

impl Experiment {
    pub fn to_text(&self) -> String {
        let listed =
            |e: &Listed| json!({ "path": e.path, "size": e.size, "sha256": e.digest.as_str() });
        let output = |f: &FileDigest| json!({ "path": f.path, "sha256": f.digest.as_str() });
        let value = json!({
            "format": FORMAT,
            "made_by": self.made_by,
            "script": self.script,
            "arguments": self.arguments,
            "folder": self.folder,
            "entries": self.entries.iter().map(listed).collect::<Vec<_>>(),
            "outputs": self.outputs.iter().map(output).collect::<Vec<_>>(),
        });
        format!("{value:#}\n")
    }

    /// `None` for anything but a table of contents whose paths stay below the root.
    pub fn from_text(text: &[u8]) -> Option<Self> {
        let value: Value = serde_json::from_slice(text).ok()?;
        if value.get("format")?.as_str()? != FORMAT {
            return None;
        }
        let text = |key: &str| Some(value.get(key)?.as_str()?.to_owned());
        let list = |key: &str| value.get(key)?.as_array();
        let digest = |entry: &Value| Digest::parse(entry.get("sha256")?.as_str()?);
        let path = |entry: &Value| plain_path(entry.get("path")?.as_str()?);
        let listed = |entry: &Value| {
            let size = entry.get("size")?.as_u64()?;
            Some(Listed { path: path(entry)?, size, digest: digest(entry)? })
        };
        let output =
            |entry: &Value| Some(FileDigest { path: path(entry)?, digest: digest(entry)? });
        Some(Self {
            made_by: value.get("made_by")?.as_object()?.clone(),
            script: plain_path(&text("script")?)?,
            arguments: list("arguments")?
                .iter()
                .map(|a| a.as_str().map(str::to_owned))
                .collect::<Option<_>>()?,
            folder: plain_path(&text("folder")?)?,
            entries: list("entries")?.iter().map(listed).collect::<Option<_>>()?,
            outputs: list("outputs")?.iter().map(output).collect::<Option<_>>()?,
        })
    }
}

/// A path of plain names only: none that leads up, to a root or to another drive.
fn plain_path(path: &str) -> Option<String> {
    let is_plain = |part: Component| matches!(part, Component::Normal(_));
    let good = !path.is_empty() && !path.contains(['\\', ':', '\0']) && !path.ends_with('/');
    (good && Path::new(path).components().all(is_plain)).then(|| path.to_owned())
}

/// Where files lie in the archive, so that the script finds each by the name that it uses.
///
/// Names lead from the script's folder to the files; the script's folder lies as deep as they lead
/// up. Errors: a name that begins at a root.
pub(super) struct Layout(usize);

impl Layout {
    pub fn of<'a>(names: impl Iterator<Item = &'a str>) -> Result<Self> {
        let mut deepest = 0;
        for name in names {
            let (up, _) = steps(name)?;
            deepest = deepest.max(up);
        }
        Ok(Self(deepest))
    }

    /// `files/up/up/lamp.lua`, `files/data/red.csv`.
    pub fn place(&self, name: &str) -> Result<String> {
        let (up, rest) = steps(name)?;
        let below = std::iter::repeat_n("up", self.0 - up);
        let parts = std::iter::once(FILES).chain(below);
        let path: PathBuf = parts.map(str::to_owned).chain(rest).collect();
        Ok(path.to_string_lossy().replace('\\', "/"))
    }
}

/// How far a name leads up, and the names from there.
fn steps(name: &str) -> Result<(usize, Vec<String>)> {
    let (mut up, mut rest) = (0, Vec::new());
    for part in Path::new(name).components() {
        match part {
            Component::CurDir => {}
            Component::Normal(part) => rest.push(part.to_string_lossy().into_owned()),
            Component::ParentDir if rest.pop().is_some() => {}
            Component::ParentDir => up += 1,
            Component::RootDir | Component::Prefix(_) => {
                let problem = format!(
                    "the script reads \"{name}\", which is elsewhere on another machine: name it from \
                     the script's folder, run the script again, and pack"
                );
                return Err(Error::inconsistent("pack", problem));
            }
        }
    }
    Ok((up, rest))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scripts_find_their_files_where_they_looked_for_them() {
        let names = ["lamp.lua", "../data/./red.csv", "parts/../lens.obj", "../../a.csv"];
        let layout = Layout::of(names.into_iter()).unwrap();
        let places: Vec<String> = names.iter().map(|name| layout.place(name).unwrap()).collect();
        let expected = [
            "files/up/up/lamp.lua",
            "files/up/data/red.csv",
            "files/up/up/lens.obj",
            "files/a.csv",
        ];
        assert_eq!(places, expected);
        assert!(Layout::of(["/etc/passwd"].into_iter()).is_err());
    }

    #[test]
    fn paths_that_leave_the_root_are_none() {
        for bad in ["", "/a", "../a", "a/../b", "a/..", "./a", "a\\b", "c:a", "a/", "a\0"] {
            assert_eq!(plain_path(bad), None, "{bad}");
        }
        assert_eq!(plain_path("files/렌즈.obj").as_deref(), Some("files/렌즈.obj"));
    }
}
