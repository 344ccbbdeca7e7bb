//! Joins the shards of a sweep.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use super::folder::{Folder, MANIFEST, manifest_names};
use super::manifest::{Entry, FileDigest, Manifest};
use super::pictures;
use super::shard::Shard;
use super::timings;
use crate::error::{Error, Result};
use crate::output;

/// What [`merge`] did, or that of a study.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Merged {
    /// What stood in the folder and was moved, and where to.
    pub moved: Option<String>,
    /// Parts that were joined.
    pub shards: usize,
    /// Views, or draws, of all of them.
    pub views: usize,
}

/// Makes one whole sweep in `into` from the shards whose manifests lie in `folders`, and develops
/// its pictures.
///
/// Errors: shards that are missing, unfinished or of different sweeps; outputs that are not what
/// their manifest says; [`Error::Io`].
pub fn merge(folders: &[PathBuf], into: &Path) -> Result<Merged> {
    let mut shards = BTreeMap::new();
    for folder in folders {
        for name in manifest_names(folder)? {
            let Some(shard) = Shard::of_manifest_name(&name) else {
                continue;
            };
            let manifest = Manifest::read(&folder.join(&name))?;
            shards.entry(shard).or_insert((folder.as_path(), manifest));
        }
    }
    if let (true, Some(merged)) = (shards.is_empty(), merged_before(folders, into)) {
        return Ok(merged);
    }
    check(&shards)?;
    let (_, (_, first)) = shards.first_key_value().ok_or_else(no_shards)?;
    let mut target = Folder::open(into, None, first.source.clone())?;
    let pictures = pictures::from_manifest(&first.pictures)?;
    target.set_pictures(first.pictures.clone());
    let mut merged = Merged {
        moved: None,
        shards: shards.len(),
        views: shards.values().map(|(_, manifest)| manifest.views.len()).sum(),
    };
    for (shard, (folder, manifest)) in &shards {
        target.add_seconds(timings::read(folder, Some(*shard)));
        for entry in &manifest.views {
            take(entry, folder, &mut target)?;
        }
    }
    merged.moved = target.finish(&pictures)?.moved;
    Ok(merged)
}

/// What is there where all shards have been merged already.
fn merged_before(folders: &[PathBuf], into: &Path) -> Option<Merged> {
    let manifest = Manifest::read(&into.join(MANIFEST)).ok()?;
    let is_meant = manifest.is_complete && folders.iter().all(|folder| folder == into);
    is_meant.then_some(Merged { moved: None, shards: 0, views: manifest.views.len() })
}

/// What keeps shards apart.
pub(in crate::program) fn fault(problem: impl Into<String>) -> Error {
    Error::inconsistent("merge", problem)
}

fn no_shards() -> Error {
    fault("no shards: expected folders with files such as manifest.03-of-40.json")
}

type Shards<'a> = BTreeMap<Shard, (&'a Path, Manifest)>;

/// Every shard once, all finished, all of one sweep, all views there.
fn check(shards: &Shards) -> Result<()> {
    let (first, (_, model)) = shards.first_key_value().ok_or_else(no_shards)?;
    if let Some(other) = shards.keys().find(|shard| shard.count != first.count) {
        return Err(fault(format!("shards {first} and {other} are not of one sweep")));
    }
    let missing: Vec<String> = (1..=first.count)
        .map(|number| Shard { number, ..*first })
        .filter(|shard| shards.get(shard).is_none_or(|(_, manifest)| !manifest.is_complete))
        .map(|shard| shard.to_string())
        .collect();
    if !missing.is_empty() {
        return Err(fault(format!("missing or unfinished shards: {}", missing.join(", "))));
    }
    for (shard, (_, manifest)) in shards {
        let mut differences = model.source.differences(&manifest.source);
        if manifest.pictures != model.pictures {
            differences.push("look");
        }
        if !differences.is_empty() {
            let differences = differences.join(", ");
            return Err(fault(format!("shards {first} and {shard} differ in {differences}")));
        }
    }
    let views = shards.values().flat_map(|(_, manifest)| &manifest.views);
    let indices: BTreeSet<usize> = views.map(|entry| entry.index).collect();
    match (1..).zip(&indices).find(|(expected, index)| expected != *index) {
        Some((expected, _)) => Err(fault(format!("view {expected} is in no shard"))),
        None => Ok(()),
    }
}

/// Copies what the target does not have yet.
fn take(entry: &Entry, folder: &Path, target: &mut Folder) -> Result<()> {
    for output in &entry.outputs {
        if !output.is_in(target.path()) {
            copy(output, folder, target.path())?;
        }
    }
    target.put(entry.clone());
    Ok(())
}

fn copy(file: &FileDigest, from: &Path, to: &Path) -> Result<()> {
    let source = from.join(&file.path);
    if !file.is_in(from) {
        return Err(fault(format!("{} is not what its manifest says", source.display())));
    }
    let mut input = File::open(&source).map_err(|e| Error::io(&source, e))?;
    output::write_atomically(&to.join(&file.path), |file| io::copy(&mut input, file).map(|_| ()))
}
