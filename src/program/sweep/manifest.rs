//! `manifest.json`: what a sweep was made from and what came out, by SHA-256.

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

use serde_json::{Map, Value, json};

use super::digest::Digest;
use crate::error::{Error, Place, Result};
use crate::output;

/// The only format so far; a reader refuses others.
const FORMAT: &str = "lampyris sweep 2";

/// Everything about a sweep that does not change from run to run.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Manifest {
    /// What the sweep was made from.
    pub source: Source,
    /// How the PNG files are made, see `Pictures`.
    pub pictures: Value,
    /// The finished views, by their place.
    pub views: Vec<Entry>,
    /// Contact sheet and page; empty until all views are there.
    pub pages: Vec<FileDigest>,
    /// Whether all views are there.
    pub is_complete: bool,
}

/// What must be equal for two sweeps to be the same experiment.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Source {
    /// Program and version.
    pub program: String,
    /// Digest of the program's file; `None` where the system does not show it.
    pub executable: Option<Digest>,
    /// Sources, lock file and compiler of the program; null in records of old.
    pub build: Value,
    /// The script that made the sweep.
    pub script: Option<FileDigest>,
    /// What the script got from the command line.
    pub arguments: Vec<String>,
    /// Everything that the script read, by the names that it used, in their order.
    pub inputs: Vec<FileDigest>,
    /// `[{"object": …, "seed": …}]` of all sampled lights.
    pub seeds: Value,
}

/// A file and its content.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FileDigest {
    /// As it was written or read.
    pub path: String,
    /// Digest of its bytes.
    pub digest: Digest,
}

/// A finished view.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// Its place in the sweep, 1-based.
    pub index: usize,
    /// Names its files.
    pub name: String,
    /// Digest of all that the image depends on.
    pub key: Digest,
    /// The image, beside the manifest.
    pub outputs: Vec<FileDigest>,
    /// Digest of all that the pictures depend on; `None` as long as there are none.
    pub picture_key: Option<Digest>,
    /// What was developed from the image, beside the manifest.
    pub pictures: Vec<FileDigest>,
    /// View, quality, statistics, regions: for people and the page.
    pub details: Map<String, Value>,
}

impl FileDigest {
    /// Digests `name` in `folder`. Errors: [`Error::Io`].
    pub fn of(folder: &Path, name: &str) -> Result<Self> {
        Ok(Self { path: name.to_owned(), digest: Digest::of_file(&folder.join(name))? })
    }

    /// Whether `folder` holds the file with this content.
    pub fn is_in(&self, folder: &Path) -> bool {
        Digest::of_file(&folder.join(&self.path)).is_ok_and(|digest| digest == self.digest)
    }

    fn to_json(&self) -> Value {
        json!({ "path": self.path, "sha256": self.digest.as_str() })
    }

    pub(in crate::program) fn from_json(value: &Value) -> Option<Self> {
        let digest = Digest::parse(value.get("sha256")?.as_str()?)?;
        Some(Self { path: value.get("path")?.as_str()?.to_owned(), digest })
    }

    /// Only files right beside the manifest are a sweep's own.
    fn beside_from_json(value: &Value) -> Option<Self> {
        let file = Self::from_json(value)?;
        let mut parts = Path::new(&file.path).components();
        let plain = matches!(parts.next(), Some(Component::Normal(_))) && parts.next().is_none();
        plain.then_some(file)
    }
}

fn list<T>(value: Option<&Value>, item: impl Fn(&Value) -> Option<T>) -> Option<Vec<T>> {
    value?.as_array()?.iter().map(item).collect()
}

fn to_list<'a, T: 'a>(items: impl IntoIterator<Item = &'a T>, item: impl Fn(&T) -> Value) -> Value {
    items.into_iter().map(item).collect::<Vec<_>>().into()
}

impl Entry {
    /// Nothing yet.
    pub(super) fn new() -> Self {
        Self {
            index: 0,
            name: String::new(),
            key: Digest::of_bytes(b""),
            outputs: Vec::new(),
            picture_key: None,
            pictures: Vec::new(),
            details: Map::new(),
        }
    }

    /// All its files.
    pub fn files(&self) -> impl Iterator<Item = &FileDigest> {
        self.outputs.iter().chain(&self.pictures)
    }

    fn to_json(&self) -> Value {
        json!({
            "index": self.index,
            "name": self.name,
            "key": self.key.as_str(),
            "outputs": to_list(&self.outputs, FileDigest::to_json),
            "picture_key": self.picture_key.as_ref().map(Digest::as_str),
            "pictures": to_list(&self.pictures, FileDigest::to_json),
            "details": self.details,
        })
    }

    fn from_json(value: &Value) -> Option<Self> {
        Some(Self {
            index: usize::try_from(value.get("index")?.as_u64()?).ok()?,
            name: value.get("name")?.as_str()?.to_owned(),
            key: Digest::parse(value.get("key")?.as_str()?)?,
            outputs: list(value.get("outputs"), FileDigest::beside_from_json)?,
            picture_key: value.get("picture_key").and_then(Value::as_str).and_then(Digest::parse),
            pictures: match value.get("pictures") {
                None => Vec::new(),
                pictures => list(pictures, FileDigest::beside_from_json)?,
            },
            details: value.get("details")?.as_object()?.clone(),
        })
    }

    /// As a line of a log, after a digest of it.
    pub(super) fn to_line(&self) -> String {
        let text = self.to_json().to_string();
        format!("{} {text}\n", Digest::of_bytes(text.as_bytes()))
    }

    /// `None` for a line that is torn or changed.
    fn from_line(line: &str) -> Option<Self> {
        let (digest, text) = line.split_once(' ')?;
        let is_whole = Digest::of_bytes(text.as_bytes()).as_str() == digest;
        Self::from_json(&serde_json::from_str(text).ok().filter(|_| is_whole)?)
    }

    /// Whether `file` has a name that the view's own files have.
    pub(super) fn is_named_for(&self, file: &str) -> bool {
        let rest = file.strip_prefix(&self.name).unwrap_or_default();
        rest.starts_with(['.', '_']) && (rest.ends_with(".exr") || rest.ends_with(".png"))
    }

    /// Whether the image lies in `folder` as it was written.
    pub fn is_whole(&self, folder: &Path) -> bool {
        self.outputs.iter().all(|output| output.is_in(folder))
    }
}

impl Source {
    /// What two sources differ in, by the names that records have for it.
    pub(super) fn differences(&self, other: &Self) -> Vec<&'static str> {
        let is_other = [
            ("program", self.program != other.program),
            ("build of the program", self.executable != other.executable),
            ("sources, Cargo.lock or compiler of the program", self.build != other.build),
            ("script", self.script != other.script),
            ("arguments", self.arguments != other.arguments),
            ("inputs", self.inputs != other.inputs),
            ("seeds", self.seeds != other.seeds),
        ];
        is_other.into_iter().filter(|(_, differs)| *differs).map(|(name, _)| name).collect()
    }

    /// The program, as records name it.
    pub(super) fn made_by(&self) -> Map<String, Value> {
        let executable = self.executable.as_ref().map(Digest::as_str);
        let fields = [
            ("program", json!(self.program)),
            ("executable", json!(executable)),
            ("build", self.build.clone()),
        ];
        fields.map(|(key, value)| (key.to_owned(), value)).into_iter().collect()
    }

    fn from_json(value: &Value) -> Option<Self> {
        let script = value.get("script")?;
        Some(Self {
            program: value.get("program")?.as_str()?.to_owned(),
            executable: value.get("executable").and_then(Value::as_str).and_then(Digest::parse),
            build: value.get("build").cloned().unwrap_or_default(),
            script: if script.is_null() { None } else { Some(FileDigest::from_json(script)?) },
            arguments: list(value.get("arguments"), |a| a.as_str().map(str::to_owned))?,
            inputs: list(value.get("inputs"), FileDigest::from_json)?,
            seeds: value.get("seeds")?.clone(),
        })
    }
}

/// Views that are added while a sweep runs, a line each: a manifest of thousands is not written
/// anew for each of them.
pub(super) fn log_path(manifest: &Path) -> PathBuf {
    manifest.with_extension("log")
}

/// The text of a manifest, which holds a digest of all the rest of it.
fn sealed(mut value: Value) -> String {
    value["sha256"] = json!(Digest::of_bytes(value.to_string().as_bytes()).as_str());
    format!("{value:#}\n")
}

impl Manifest {
    /// Keys are sorted, so that equal manifests are equal texts.
    pub fn to_text(&self) -> String {
        let Source { program, executable, build, script, arguments, inputs, seeds } = &self.source;
        let mut value = json!({
            "format": FORMAT,
            "program": program,
            "executable": executable.as_ref().map(Digest::as_str),
            "script": script.as_ref().map(FileDigest::to_json),
            "arguments": arguments,
            "inputs": to_list(inputs, FileDigest::to_json),
            "seeds": seeds,
            "pictures": self.pictures,
            "views": to_list(&self.views, Entry::to_json),
            "pages": to_list(&self.pages, FileDigest::to_json),
            "complete": self.is_complete,
        });
        if !build.is_null() {
            value["build"] = build.clone();
        }
        sealed(value)
    }

    fn from_json(value: &Value) -> Option<Self> {
        Some(Self {
            source: Source::from_json(value)?,
            pictures: value.get("pictures").cloned().unwrap_or_default(),
            views: list(value.get("views"), Entry::from_json)?,
            pages: list(value.get("pages"), FileDigest::beside_from_json)?,
            is_complete: value.get("complete")?.as_bool()?,
        })
    }

    /// With the views that have been added to an unfinished one since it was written.
    ///
    /// Errors: [`Error::Io`]; [`Error::BadFile`] if it is not JSON, not such a manifest, or not as
    /// it was written.
    pub fn read(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path).map_err(|e| Error::io(path, e))?;
        let value: Value = serde_json::from_str(&text).map_err(|e| {
            Error::bad_file(path, Place::Line(e.line() as u64), format!("not JSON: {e}"))
        })?;
        let bad = |problem: &str| Error::bad_file(path, Place::File, problem);
        if value.get("format").and_then(Value::as_str) != Some(FORMAT) {
            return Err(bad(&format!("not a manifest: expected \"format\": \"{FORMAT}\"")));
        }
        let manifest = Self::from_json(&value);
        let manifest =
            manifest.ok_or_else(|| bad("not a manifest: a field is missing or wrong"))?;
        if manifest.to_text() != text {
            return Err(bad("is not as it was written: remove it, and all views are made again"));
        }
        let log = std::fs::read_to_string(log_path(path)).unwrap_or_default();
        Ok(if manifest.is_complete { manifest } else { manifest.with_log(&log) })
    }

    fn with_log(mut self, log: &str) -> Self {
        let of_name = |entry: Entry| (entry.name.clone(), entry);
        let mut views: BTreeMap<_, _> = self.views.drain(..).map(of_name).collect();
        views.extend(log.lines().filter_map(Entry::from_line).map(of_name));
        self.views.extend(views.into_values());
        self.views.sort_by_key(|entry| entry.index);
        self
    }

    /// Whole or not at all. Errors: [`Error::Io`].
    pub fn write(&self, path: &Path) -> Result<()> {
        output::write_text(path, &self.to_text())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::scratch::ScratchFolder;

    fn file(path: &str) -> FileDigest {
        FileDigest { path: path.to_owned(), digest: Digest::of_bytes(path.as_bytes()) }
    }

    fn manifest(output: &str) -> Manifest {
        let mut details = Map::new();
        details.insert("light_error".to_owned(), json!(0.1 + 0.2));
        Manifest {
            source: Source {
                program: "lampyris 0".to_owned(),
                executable: Some(Digest::of_bytes(b"build")),
                build: json!({ "sources": "00", "compiler": "rustc" }),
                script: Some(file("전조등.lua")),
                arguments: vec!["320".to_owned()],
                inputs: vec![file("../data/a.csv")],
                seeds: json!([]),
            },
            pictures: json!({ "exposure": "one" }),
            views: vec![Entry {
                index: 1,
                name: "view_0001".to_owned(),
                key: Digest::of_bytes(b"key"),
                outputs: vec![file(output)],
                picture_key: Some(Digest::of_bytes(b"look")),
                pictures: vec![file("view_0001.png")],
                details,
            }],
            pages: vec![file("index.html")],
            is_complete: true,
        }
    }

    #[test]
    fn reads_what_it_wrote() {
        let scratch = ScratchFolder::new();
        let path = scratch.path("manifest.json");
        manifest("view_0001.exr").write(&path).unwrap();
        assert_eq!(Manifest::read(&path).unwrap(), manifest("view_0001.exr"));
    }

    #[test]
    fn any_change_of_a_manifest_is_found() {
        let scratch = ScratchFolder::new();
        let path = scratch.path("manifest.json");
        let text = manifest("view_0001.exr").to_text();
        for at in 0..text.len() {
            let mut changed = text.clone().into_bytes();
            changed[at] ^= 1;
            std::fs::write(&path, changed).unwrap();
            assert!(Manifest::read(&path).is_err(), "byte {at}");
        }
    }

    #[test]
    fn an_unfinished_manifest_has_the_views_of_its_log() {
        let scratch = ScratchFolder::new();
        let path = scratch.path("manifest.json");
        let unfinished = Manifest { is_complete: false, ..manifest("view_0001.exr") };
        unfinished.write(&path).unwrap();
        let second = Entry { index: 2, name: "b".to_owned(), ..unfinished.views[0].clone() };
        let line = second.to_line();
        let torn = &line[..line.len() / 2];
        let changed = line.replace("\"b\"", "\"c\"");
        std::fs::write(log_path(&path), format!("{line}{changed}{torn}")).unwrap();
        let views = Manifest::read(&path).unwrap().views;
        assert_eq!(views, [unfinished.views[0].clone(), second]);
        manifest("view_0001.exr").write(&path).unwrap();
        assert_eq!(Manifest::read(&path).unwrap().views.len(), 1);
    }

    #[test]
    fn refuses_other_files_and_outputs_elsewhere() {
        let scratch = ScratchFolder::new();
        let path = scratch.path("manifest.json");
        let message = || Manifest::read(&path).unwrap_err().to_string();
        std::fs::write(&path, "{\n\"format\": 3\n").unwrap();
        assert!(message().contains("manifest.json:3: not JSON"), "{}", message());
        std::fs::write(&path, "{}").unwrap();
        assert!(message().contains("expected \"format\": \"lampyris sweep 2\""));
        for outside in ["../view.exr", "/etc/passwd", "a/b.exr", "..", ""] {
            manifest(outside).write(&path).unwrap();
            assert!(message().ends_with("a field is missing or wrong"), "{outside}");
        }
    }
}
