//! From one file to the same folder again, and whether it is the same.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufReader, Read, Write};
use std::path::{Path, PathBuf};

use serde_json::Value;

use super::experiment::{EXPECTED, Experiment, Listed, NAME};
use crate::error::{Error, Place, Result};
use crate::program::study;
use crate::program::sweep::{self, Digest, Hasher};

/// Bytes of the largest table of contents: of a hundred thousand files.
const MOST_CONTENTS: u64 = 32 << 20;

/// Unpacks an archive into the folder `root`, which must be new or empty.
///
/// Nothing of an archive is trusted: entries are regular files below `root`, listed once, of the
/// listed size and digest; what is read stays small in memory.
/// Errors: [`Error::BadFile`] for anything else; a folder that holds something; [`Error::Io`].
pub fn unpack(archive: &Path, root: &Path) -> Result<Experiment> {
    make_empty(root)?;
    let io = |e| Error::io(archive, e);
    let bad = |problem: String| Error::bad_file(archive, Place::File, problem);
    let file = BufReader::new(File::open(archive).map_err(io)?);
    let mut reader = tar::Archive::new(file);
    let mut entries = reader.entries().map_err(io)?;
    let mut first = entries.next().ok_or_else(|| bad("holds nothing".to_owned()))?.map_err(io)?;
    let is_contents = first.path_bytes().as_ref() == NAME.as_bytes()
        && is_regular(&first)
        && first.size() <= MOST_CONTENTS;
    let no_contents = || bad(format!("no archive of lampyris: expected {NAME} first"));
    if !is_contents {
        return Err(no_contents());
    }
    let mut text = Vec::new();
    first.by_ref().take(MOST_CONTENTS).read_to_end(&mut text).map_err(io)?;
    let experiment = Experiment::from_text(&text).ok_or_else(no_contents)?;
    let listed = |entry: &Listed| (entry.path.clone(), entry.clone());
    let mut missing: BTreeMap<String, Listed> = experiment.entries.iter().map(listed).collect();
    for entry in entries {
        let mut entry = entry.map_err(io)?;
        let path = String::from_utf8_lossy(&entry.path_bytes()).into_owned();
        let listed = missing.remove(&path).filter(|listed| listed.size == entry.size());
        let listed = listed.filter(|_| is_regular(&entry)).ok_or_else(|| {
            bad(format!("entry \"{path}\" is not what {NAME} lists: it has been tampered with"))
        })?;
        let digest = copy(&mut entry, &root.join(&path))?;
        if digest != listed.digest {
            return Err(bad(format!("entry \"{path}\" has been changed")));
        }
    }
    match missing.into_keys().next() {
        Some(path) => Err(bad(format!("entry \"{path}\" is missing"))),
        None => Ok(experiment),
    }
}

fn is_regular<R: Read>(entry: &tar::Entry<R>) -> bool {
    entry.header().entry_type() == tar::EntryType::Regular
}

fn make_empty(root: &Path) -> Result<()> {
    std::fs::create_dir_all(root).map_err(|e| Error::io(root, e))?;
    let mut found = std::fs::read_dir(root).map_err(|e| Error::io(root, e))?;
    match found.next() {
        None => Ok(()),
        Some(_) => {
            let path = format!("\"{}\"", root.display());
            Err(Error::out_of_range("replay", "--out", path, "a folder that is new or empty"))
        }
    }
}

/// Writes a new file, and tells its digest.
fn copy(from: &mut impl Read, path: &Path) -> Result<Digest> {
    let mut copy = || -> io::Result<Digest> {
        std::fs::create_dir_all(path.parent().unwrap_or(path))?;
        let mut file = File::create_new(path)?;
        let (mut hasher, mut buffer) = (Hasher::new(), vec![0; 1 << 16]);
        loop {
            let count = from.read(&mut buffer)?;
            if count == 0 {
                return Ok(hasher.finish());
            }
            hasher.bytes(&buffer[..count]);
            file.write_all(&buffer[..count])?;
        }
    };
    copy().map_err(|e| Error::io(path, e))
}

/// What came of a replay.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Replayed {
    /// Files that are the same to the byte.
    pub same: usize,
    /// Files that are not, or are not there.
    pub differing: Vec<String>,
    /// The largest relative difference of the numbers on record, and where it is; `None` where all
    /// files are the same, or records do not match.
    pub largest: Option<(f64, String)>,
    /// What the two programs differ in.
    pub program: Vec<String>,
}

impl Replayed {
    /// Whether it is the same: to the byte, or in all numbers within `tolerance`.
    pub fn is_same(&self, tolerance: Option<f64>) -> bool {
        let is_within =
            |most: f64| self.largest.as_ref().is_some_and(|(largest, _)| *largest <= most);
        self.differing.is_empty() || tolerance.is_some_and(is_within)
    }
}

impl Replayed {
    /// The verdict, and the reasons for it.
    pub fn in_words(&self, tolerance: Option<f64>) -> String {
        let Self { same, differing, largest, program } = self;
        let all = same + differing.len();
        let mut lines = vec![match (differing.len(), tolerance) {
            (0, _) => format!("the same to the byte: {all} files"),
            (count, Some(most)) if self.is_same(tolerance) => {
                format!("the same within {most}: {count} of {all} files differ in their bytes")
            }
            (count, _) => format!("not the same: {count} of {all} files differ"),
        }];
        lines.extend(differing.iter().map(|path| format!("{path}: differs")));
        match largest {
            Some((share, place)) if *share > 0.0 => {
                lines.push(format!(
                    "largest relative difference of numbers on record: {share:.1e}, {place}"
                ));
            }
            Some(_) => lines.push("all numbers on record are the same".to_owned()),
            None if !differing.is_empty() => {
                lines.push("the records have different parts".to_owned());
            }
            None => {}
        }
        lines.extend(program.iter().map(|difference| format!("program: {difference}")));
        lines.join("\n")
    }
}

/// Compares what the script wrote below `out` with what the archive expects.
///
/// Errors: the script has not written the folder; records that do not read.
pub fn compare(experiment: &Experiment, root: &Path, out: &Path) -> Result<Replayed> {
    let folder = find(out, &experiment.folder, 4).ok_or_else(|| {
        let problem = format!("the script wrote no sweep or study \"{}\"", experiment.folder);
        Error::inconsistent("replay", problem)
    })?;
    let is_same = |path: &str, digest: &Digest| {
        Digest::of_file(&folder.join(path)).is_ok_and(|found| found == *digest)
    };
    let (same, differing): (Vec<_>, Vec<_>) =
        experiment.outputs.iter().partition(|file| is_same(&file.path, &file.digest));
    let differing: Vec<String> = differing.into_iter().map(|file| file.path.clone()).collect();
    let largest = match differing.is_empty() {
        true => None,
        false => largest_difference(&root.join(EXPECTED), &folder)?,
    };
    let program = sweep::build_differences(&experiment.made_by);
    Ok(Replayed { same: same.len(), differing, largest, program })
}

/// A folder of this name with a record, at most so deep below another.
fn find(place: &Path, name: &str, depth: usize) -> Option<PathBuf> {
    let here = place.join(name);
    if here.join(sweep::MANIFEST).is_file() || here.join(study::RECORD).is_file() {
        return Some(here);
    }
    let mut folders: Vec<PathBuf> = std::fs::read_dir(place)
        .ok()?
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| depth > 0 && path.is_dir())
        .collect();
    folders.sort();
    folders.iter().find_map(|folder| find(folder, name, depth - 1))
}

fn largest_difference(expected: &Path, found: &Path) -> Result<Option<(f64, String)>> {
    let (name, read): (_, fn(&Path) -> Result<Value>) = match expected.join(study::RECORD).is_file()
    {
        true => (study::DRAWS, read_table),
        false => (sweep::MANIFEST, read_views),
    };
    let [a, b] = [read(&expected.join(name))?, read(&found.join(name))?];
    let mut largest = (0.0, String::new());
    let is_alike = collect_differences("", &a, &b, &mut largest);
    Ok(is_alike.then_some(largest))
}

fn read_text(path: &Path) -> Result<String> {
    std::fs::read_to_string(path).map_err(|e| Error::io(path, e))
}

/// What a manifest says of each view, by its name.
fn read_views(path: &Path) -> Result<Value> {
    let manifest = sweep::Manifest::read(path)?;
    let views = manifest.views.into_iter().map(|view| (view.name, view.details.into()));
    Ok(Value::Object(views.collect()))
}

/// Rows of cells, which are numbers where they read as such.
fn read_table(path: &Path) -> Result<Value> {
    let cell = |text: &str| text.parse::<f64>().map_or_else(|_| text.into(), Value::from);
    let row = |line: &str| line.split(',').map(cell).collect::<Vec<_>>().into();
    Ok(read_text(path)?.lines().map(row).collect::<Vec<Value>>().into())
}

/// Whether two records have the same parts; texts, such as digests, may differ.
fn collect_differences(place: &str, a: &Value, b: &Value, largest: &mut (f64, String)) -> bool {
    match (a, b) {
        (Value::Object(a), Value::Object(b)) => {
            let mut parts = a.iter().zip(b);
            a.len() == b.len()
                && parts.all(|((key, a), (other, b))| {
                    key == other && collect_differences(&format!("{place} {key}"), a, b, largest)
                })
        }
        (Value::Array(a), Value::Array(b)) => {
            let mut parts = (1..).zip(a.iter().zip(b));
            a.len() == b.len()
                && parts.all(|(at, (a, b))| {
                    collect_differences(&format!("{place} {at}"), a, b, largest)
                })
        }
        (Value::Number(_), Value::Number(_)) => {
            let [a, b] = [a, b].map(|value| value.as_f64().unwrap_or(f64::NAN));
            let relative = if a == b { 0.0 } else { (a - b).abs() / a.abs().max(b.abs()) };
            if relative > largest.0 || relative.is_nan() {
                *largest = (relative, place.trim_start().to_owned());
            }
            true
        }
        (Value::String(_), Value::String(_)) => true,
        (a, b) => a == b,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::scratch::ScratchFolder;
    use serde_json::json;

    /// An archive whose table lists `listed`, and which holds `held`.
    fn archive(path: &Path, listed: &[(&str, &str)], held: &[(&str, &str, tar::EntryType)]) {
        let entry = |(path, text): &(&str, &str)| {
            let digest = Digest::of_bytes(text.as_bytes());
            json!({ "path": path, "size": text.len(), "sha256": digest.as_str() })
        };
        let contents = json!({
            "format": "lampyris archive 1", "made_by": {}, "script": "files/a.lua", "arguments": [],
            "folder": "s", "entries": listed.iter().map(entry).collect::<Vec<_>>(), "outputs": [],
        });
        let contents = contents.to_string();
        let mut builder = tar::Builder::new(File::create(path).unwrap());
        let first = (NAME, contents.as_str(), tar::EntryType::Regular);
        for (name, text, kind) in std::iter::once(&first).chain(held) {
            let mut header = tar::Header::new_gnu();
            header.as_gnu_mut().unwrap().name[..name.len()].copy_from_slice(name.as_bytes());
            header.set_size(text.len() as u64);
            header.set_entry_type(*kind);
            if *kind == tar::EntryType::Symlink {
                header.set_link_name("/etc").unwrap();
            }
            header.set_cksum();
            builder.append(&header, text.as_bytes()).unwrap();
        }
        builder.into_inner().unwrap();
    }

    #[test]
    fn hostile_archives_are_refused_and_write_nothing_elsewhere() {
        use tar::EntryType::{Link, Regular, Symlink};
        let scratch = ScratchFolder::new();
        let path = scratch.path("x.tar");
        let unpacked = |name: &str, listed: &[(&str, &str)], held: &[_]| {
            archive(&path, listed, held);
            unpack(&path, &scratch.path(name)).map_err(|error| error.to_string())
        };
        assert!(
            unpacked("good", &[("files/a.lua", "a")], &[("files/a.lua", "a", Regular)]).is_ok()
        );
        type Listed<'a> = &'a [(&'a str, &'a str)];
        type Held<'a> = &'a [(&'a str, &'a str, tar::EntryType)];
        let cases: [(&str, Listed, Held); 9] = [
            ("up", &[("../evil", "a")], &[("../evil", "a", Regular)]),
            ("root", &[("/tmp/evil", "a")], &[("/tmp/evil", "a", Regular)]),
            ("unlisted", &[], &[("../evil", "a", Regular)]),
            ("symlink", &[("files/a.lua", "")], &[("files/a.lua", "", Symlink)]),
            ("link", &[("files/a.lua", "")], &[("files/a.lua", "", Link)]),
            ("size", &[("files/a.lua", "a")], &[("files/a.lua", "ab", Regular)]),
            ("changed", &[("files/a.lua", "a")], &[("files/a.lua", "b", Regular)]),
            ("missing", &[("files/a.lua", "a")], &[]),
            ("twice", &[("files/a", "a")], &[("files/a", "a", Regular), ("files/a", "a", Regular)]),
        ];
        for (name, listed, held) in cases {
            assert!(unpacked(name, listed, held).is_err(), "{name}");
        }
        assert!(!scratch.path("evil").exists());
        assert!(unpack(&path, &scratch.path("good")).is_err(), "a folder that holds something");
        std::fs::write(&path, [7; 2000]).unwrap();
        assert!(unpack(&path, &scratch.path("noise")).is_err());
    }

    #[test]
    fn the_largest_difference_is_named() {
        let (a, b) = (json!({ "v": { "y": [1.0, 2.0] } }), json!({ "v": { "y": [1.0, 2.1] } }));
        let mut largest = (0.0, String::new());
        assert!(collect_differences("", &a, &b, &mut largest));
        assert!((largest.0 - 0.1 / 2.1).abs() < 1e-12 && largest.1 == "v y 2", "{largest:?}");
        assert!(!collect_differences("", &a, &json!({ "v": { "y": [1.0] } }), &mut largest));
    }
}
