//! From a folder and what it was made from to one file.

use std::fs::File;
use std::io::{BufWriter, Read, Write};
use std::path::{Path, PathBuf};

use serde_json::{Map, Value};

use super::experiment::{EXPECTED, Experiment, Layout, Listed, NAME};
use crate::error::{Error, Place, Result};
use crate::output;
use crate::program::study;
use crate::program::sweep::{self, Digest, FileDigest, Manifest};

/// Writes the archive of the sweep or study in `folder`, and tells how many files it holds.
///
/// `script` is where its script lies now; without it, it is looked for in the working directory, in
/// `scripts/` there, and around `folder`. Errors: an unfinished sweep; a script, input or output that
/// is not what the folder was made from; an input that is named from a root; [`Error::Io`].
pub fn pack(folder: &Path, script: Option<&Path>, into: &Path) -> Result<usize> {
    let record = Recorded::read(folder)?;
    for output in &record.outputs {
        check(output, &folder.join(&output.path))?;
    }
    let script_path = match script {
        Some(path) => path.to_owned(),
        None => find_script(folder, &record.script)?,
    };
    check(&record.script, &script_path)?;
    let names = || std::iter::once(&record.script).chain(&record.inputs);
    let layout = Layout::of(names().map(|file| file.path.as_str()))?;
    let mut files = vec![(layout.place(&record.script.path)?, script_path.clone())];
    let beside = script_path.parent().unwrap_or(Path::new(""));
    for input in &record.inputs {
        let near = beside.join(&input.path);
        let path = if near.exists() { near } else { PathBuf::from(&input.path) };
        check(input, &path)?;
        files.push((layout.place(&input.path)?, path));
    }
    for name in record.kept {
        files.push((format!("{EXPECTED}/{name}"), folder.join(name)));
    }
    files.sort();
    files.dedup_by(|a, b| a.0 == b.0);
    let mut entries = vec![listed_lock()];
    for (path, file) in &files {
        let size = file.metadata().map_err(|e| Error::io(file, e))?.len();
        entries.push(Listed { path: path.clone(), size, digest: Digest::of_file(file)? });
    }
    let name = folder.canonicalize().map_err(|e| Error::io(folder, e))?;
    let experiment = Experiment {
        made_by: record.made_by,
        script: layout.place(&record.script.path)?,
        arguments: record.arguments,
        folder: name.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        entries,
        outputs: record.outputs,
    };
    write(into, &experiment, &files)?;
    Ok(files.len() + 2)
}

const LOCK: &str = "Cargo.lock";

/// Exact versions of the crates that this program was built from.
fn listed_lock() -> Listed {
    let text = sweep::LOCK_FILE.as_bytes();
    Listed { path: LOCK.to_owned(), size: text.len() as u64, digest: Digest::of_bytes(text) }
}

/// What a folder's record says.
struct Recorded {
    script: FileDigest,
    inputs: Vec<FileDigest>,
    outputs: Vec<FileDigest>,
    arguments: Vec<String>,
    made_by: Map<String, Value>,
    /// Files with which a replay is compared by number.
    kept: &'static [&'static str],
}

impl Recorded {
    fn read(folder: &Path) -> Result<Self> {
        if study::is_study(folder) { Self::of_study(folder) } else { Self::of_sweep(folder) }
    }

    fn of_sweep(folder: &Path) -> Result<Self> {
        let path = folder.join(sweep::MANIFEST);
        let manifest = Manifest::read(&path)?;
        if !manifest.is_complete {
            let problem = "the sweep is not finished: run its script again, or merge its shards";
            return Err(Error::inconsistent("pack", problem));
        }
        let views = manifest.views.iter().flat_map(|view| view.files());
        let outputs = views.chain(&manifest.pages).cloned().collect();
        let source = manifest.source;
        Ok(Self {
            script: source.script.ok_or_else(|| no_script(&path))?,
            inputs: source.inputs,
            outputs,
            arguments: source.arguments,
            made_by: made_by(&path)?,
            kept: &[sweep::MANIFEST],
        })
    }

    fn of_study(folder: &Path) -> Result<Self> {
        let path = folder.join(study::RECORD);
        let value = read_record(&path)?;
        let bad = || Error::bad_file(&path, Place::File, "not the record of a study");
        let list = |key: &str| value.get(key).and_then(Value::as_array).ok_or_else(bad);
        let mut read: Vec<FileDigest> = list("read")?
            .iter()
            .map(FileDigest::from_json)
            .collect::<Option<_>>()
            .ok_or_else(bad)?;
        if read.is_empty() {
            return Err(no_script(&path));
        }
        let arguments = list("arguments")?.iter().map(|a| a.as_str().map(str::to_owned));
        Ok(Self {
            script: read.remove(0),
            inputs: read,
            outputs: vec![FileDigest::of(folder, study::DRAWS)?],
            arguments: arguments.collect::<Option<_>>().ok_or_else(bad)?,
            made_by: made_by(&path)?,
            kept: &[study::RECORD, study::DRAWS],
        })
    }
}

fn no_script(record: &Path) -> Error {
    Error::bad_file(record, Place::File, "names no script: what was typed cannot be made again")
}

fn read_record(path: &Path) -> Result<Value> {
    let text = std::fs::read_to_string(path).map_err(|e| Error::io(path, e))?;
    serde_json::from_str(&text).map_err(|e| Error::bad_file(path, Place::File, e.to_string()))
}

fn made_by(record: &Path) -> Result<Map<String, Value>> {
    let value = read_record(record)?;
    let field = |key: &str| Some((key.to_owned(), value.get(key)?.clone()));
    Ok(["program", "executable", "build"].into_iter().filter_map(field).collect())
}

/// Errors: a file that is not what the record says.
fn check(expected: &FileDigest, path: &Path) -> Result<()> {
    if Digest::of_file(path)? == expected.digest {
        return Ok(());
    }
    let problem = format!("{} has changed since the folder was made", path.display());
    Err(Error::inconsistent("pack", problem))
}

fn find_script(folder: &Path, script: &FileDigest) -> Result<PathBuf> {
    let real = folder.canonicalize().map_err(|e| Error::io(folder, e))?;
    let around = real.ancestors().skip(1).take(3).map(Path::to_owned);
    let near = ["", "scripts"].map(PathBuf::from).into_iter();
    let places = near.chain(around).map(|place| place.join(&script.path));
    let mut found = places.filter(|path| {
        path.is_file() && Digest::of_file(path).is_ok_and(|digest| digest == script.digest)
    });
    found.next().ok_or_else(|| {
        let problem = format!("{} is not near: --script says where it lies", script.path);
        Error::inconsistent("pack", problem)
    })
}

fn write(into: &Path, experiment: &Experiment, files: &[(String, PathBuf)]) -> Result<()> {
    output::write_atomically(into, |file| {
        let mut archive = tar::Builder::new(BufWriter::new(file));
        let mut add = |path: &str, size: u64, content: &mut dyn Read| {
            archive.append_data(&mut header(size), path, content)
        };
        let text = experiment.to_text();
        add(NAME, text.len() as u64, &mut text.as_bytes())?;
        let lock = sweep::LOCK_FILE.as_bytes();
        add(LOCK, lock.len() as u64, &mut &*lock)?;
        for ((path, file), listed) in files.iter().zip(&experiment.entries[1..]) {
            // A file that grows meanwhile would run into the next entry.
            add(path, listed.size, &mut File::open(file)?.take(listed.size))?;
        }
        archive.into_inner()?.flush()
    })
}

/// The same for every file: no times, owners or rights.
fn header(size: u64) -> tar::Header {
    let mut header = tar::Header::new_gnu();
    header.set_size(size);
    header.set_mode(0o644);
    header.set_mtime(0);
    header.set_uid(0);
    header.set_gid(0);
    header
}
