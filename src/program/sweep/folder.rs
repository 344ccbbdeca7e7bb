//! The folder of a sweep: what is there already, what is added, what is left over.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File, TryLockError};
use std::io::Write;
use std::path::{Path, PathBuf};

use super::again::some_of;
use super::manifest::{Entry, FileDigest, Manifest, Source, log_path};
use super::pictures::Pictures;
use super::shard::Shard;
use super::{page, timings};
use crate::display::GamutReport;
use crate::error::{Error, Result};
use crate::output;
use crate::program::run_crate::{RUN_CRATE, RunCrate};

/// Name of a whole sweep's manifest.
pub const MANIFEST: &str = "manifest.json";

/// A sweep's folder while views are added to it.
pub struct Folder {
    path: PathBuf,
    shard: Option<Shard>,
    /// What all manifests in the folder name, by the views' names.
    known: BTreeMap<String, Entry>,
    /// Entries of the manifest that this run replaces, as long as it has not come to them.
    earlier: BTreeMap<String, Entry>,
    manifest: Manifest,
    seconds: BTreeMap<String, f64>,
    /// Open once a view has been added.
    log: Option<File>,
    /// Files that processes had begun when this one came; some may still be at work.
    unfinished: Vec<String>,
    /// Held as long as the folder is in use.
    _lock: Option<File>,
}

impl Folder {
    /// Opens or makes the folder, and removes what killed processes left unfinished: all of it for a
    /// whole sweep, which has the folder alone, and what is its own for a shard.
    ///
    /// Errors: [`Error::Io`]; a `manifest.json` that is none of ours; a folder that another
    /// process sweeps into.
    pub fn open(path: &Path, shard: Option<Shard>, source: Source) -> Result<Self> {
        output::make_folder(path)?;
        let lock = lock(path, shard)?;
        let own = manifest_name(shard);
        let unfinished = unfinished(path)?;
        let is_ours = |file: &&String| {
            shard.is_none() || is_of(file, &own) || is_of(file, &timings::name(shard))
        };
        unfinished.iter().filter(is_ours).try_for_each(|file| remove(&path.join(file)))?;
        Ok(Self {
            manifest: Manifest { source, ..Manifest::default() },
            seconds: timings::read(path, shard),
            unfinished,
            _lock: lock,
            ..Self::look(path, shard)?
        })
    }

    /// The folder as it is, which need not exist: nothing is made, removed or locked.
    ///
    /// Errors: as [`Self::open`].
    pub fn look(path: &Path, shard: Option<Shard>) -> Result<Self> {
        let none = || Ok([BTreeMap::new(), BTreeMap::new()]);
        let [known, earlier] =
            if path.exists() { known(path, &manifest_name(shard)) } else { none() }?;
        let path = path.to_owned();
        Ok(Self {
            path,
            shard,
            known,
            earlier,
            manifest: Manifest::default(),
            seconds: BTreeMap::new(),
            log: None,
            unfinished: Vec::new(),
            _lock: None,
        })
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether the view is this run's to render.
    pub fn is_ours(&self, index: usize) -> bool {
        self.shard.is_none_or(|shard| shard.has(index))
    }

    /// How the pictures are made.
    pub fn set_pictures(&mut self, record: serde_json::Value) {
        self.manifest.pictures = record;
    }

    /// Inputs and seeds grow while a script runs.
    pub fn set_source(&mut self, source: Source) {
        self.manifest.source = source;
    }

    /// The view if it is there already, made from the same things, its image untouched.
    pub fn kept(&self, index: usize, name: &str, key: &super::Digest) -> Option<Entry> {
        let entry = self.known.get(name)?;
        let is_good = entry.key == *key && entry.is_whole(&self.path);
        is_good.then(|| Entry { index, ..entry.clone() })
    }

    /// What an earlier run made of the view.
    pub fn known(&self, name: &str) -> Option<&Entry> {
        self.known.get(name)
    }

    /// Views of earlier runs that `is_current` does not know, of a whole sweep.
    pub fn left_over(&self, is_current: impl Fn(&str) -> bool) -> Vec<&str> {
        let names = self.known.keys().map(String::as_str);
        names.filter(|name| self.shard.is_none() && !is_current(name)).collect()
    }

    /// What a killed process left of a view, which is this run's alone to write.
    ///
    /// Errors: [`Error::Io`].
    pub fn remove_unfinished_of(&self, view: &str) -> Result<()> {
        let luminance = page::luminance_name(view);
        let outputs = [format!("{view}.exr"), format!("{view}.png"), luminance];
        let files = self.unfinished.iter();
        files
            .filter(|file| outputs.iter().any(|output| is_of(file, output)))
            .try_for_each(|file| remove(&self.path.join(file)))
    }

    pub(super) fn add_seconds(&mut self, seconds: BTreeMap<String, f64>) {
        self.seconds.extend(seconds);
    }

    /// A view whose image is there, to be named by the final manifest.
    pub(super) fn put(&mut self, entry: Entry) {
        self.earlier.remove(&entry.name);
        self.manifest.views.push(entry);
    }

    /// A view whose image has been written: a line in the log, whatever is there already.
    ///
    /// Errors: [`Error::Io`].
    pub fn add(&mut self, entry: Entry, seconds: f64) -> Result<()> {
        self.seconds.insert(entry.name.clone(), seconds);
        let log = log_path(&self.manifest_path());
        let mut file = match self.log.take() {
            Some(file) => file,
            None => self.begin_log(&log)?,
        };
        let written = file.write_all(entry.to_line().as_bytes()).and_then(|()| file.sync_data());
        written.map_err(|e| Error::io(&log, e))?;
        self.log = Some(file);
        self.put(entry);
        Ok(())
    }

    /// The manifest so far, and a new log of what comes.
    fn begin_log(&self, log: &Path) -> Result<File> {
        let mut so_far = self.manifest.clone();
        so_far.views.extend(self.earlier.values().cloned());
        so_far.views.sort_by_key(|entry| entry.index);
        so_far.write(&self.manifest_path())?;
        remove(log)?;
        output::create(log)
    }

    fn manifest_path(&self) -> PathBuf {
        self.path.join(manifest_name(self.shard))
    }

    /// All views are there: pictures, contact sheet, page, and the final manifest. A shard leaves
    /// pictures and pages to [`super::merge`].
    ///
    /// Errors: [`Error::Io`]; an EXR or PNG file that does not read back.
    pub fn finish(mut self, pictures: &Pictures) -> Result<Finished> {
        let mut gamut = GamutReport::default();
        let mut moved = None;
        self.manifest.views.sort_by_key(|entry| entry.index);
        self.manifest.is_complete = true;
        timings::write(&self.path, self.shard, &self.timings_of_views())?;
        if self.shard.is_none() {
            gamut = pictures.write_all(&self.path, &mut self.manifest.views)?;
            self.manifest.pages = page::write(&self.path, &self.manifest)?;
            self.write_run_crate()?;
        }
        self.manifest.write(&self.manifest_path())?;
        remove(&log_path(&self.manifest_path()))?;
        if self.shard.is_none() {
            moved = self.set_left_over_aside()?;
            self.remove_shards()?;
        }
        Ok(Finished { gamut, moved })
    }

    /// The same for other programs.
    fn write_run_crate(&mut self) -> Result<()> {
        let views = self.manifest.views.iter().flat_map(Entry::files);
        let results = views.chain(&self.manifest.pages).map(|file| file.path.clone());
        let record = RunCrate {
            kind: "Sweep",
            source: &self.manifest.source,
            results: results.collect(),
            others: vec![MANIFEST.to_owned(), timings::name(None)],
        };
        record.write(&self.path)?;
        self.manifest.pages.push(FileDigest::of(&self.path, RUN_CRATE)?);
        Ok(())
    }

    fn timings_of_views(&self) -> BTreeMap<String, f64> {
        let views = self.manifest.views.iter();
        let seconds = |entry: &Entry| Some((entry.name.clone(), *self.seconds.get(&entry.name)?));
        views.filter_map(seconds).collect()
    }

    /// Moves files that earlier manifests name and this one does not, if their views made them, into
    /// a folder of their own.
    fn set_left_over_aside(&self) -> Result<Option<String>> {
        let outputs = self.manifest.views.iter().flat_map(Entry::files);
        let current: BTreeSet<&str> = outputs.map(|file| file.path.as_str()).collect();
        let mut left = Vec::new();
        for entry in self.known.values() {
            let is_left = |file: &&FileDigest| {
                !current.contains(file.path.as_str())
                    && entry.is_named_for(&file.path)
                    && file.is_in(&self.path)
            };
            left.extend(entry.files().filter(is_left));
        }
        if left.is_empty() {
            return Ok(None);
        }
        let aside = self.path.join(aside_name(&left));
        output::make_folder(&aside)?;
        for file in &left {
            let from = self.path.join(&file.path);
            fs::rename(&from, aside.join(&file.path)).map_err(|e| Error::io(&from, e))?;
        }
        let names = self.left_over(|name| self.manifest.views.iter().any(|v| v.name == name));
        let (views, aside) = (some_of(&names), aside.display());
        Ok(Some(format!("views of an earlier sweep into this folder are now in {aside}: {views}")))
    }

    fn remove_shards(&self) -> Result<()> {
        for name in manifest_names(&self.path)?.iter().filter(|name| *name != MANIFEST) {
            let manifest = self.path.join(name);
            remove(&manifest)?;
            remove(&log_path(&manifest))?;
        }
        timings::remove_of_shards(&self.path)
    }
}

/// What a whole sweep's end tells.
pub struct Finished {
    /// What the display cannot show.
    pub gamut: GamutReport,
    /// Which views of earlier sweeps were moved, and where to.
    pub moved: Option<String>,
}

/// A folder's name that tells files of other contents apart.
fn aside_name(files: &[&FileDigest]) -> String {
    let digests: Vec<&str> = files.iter().map(|file| file.digest.as_str()).collect();
    let digest = super::Digest::of_bytes(digests.concat().as_bytes());
    format!("earlier-{}", &digest.as_str()[..12])
}

/// Entries of all manifests in a folder by the views' names, and those of `own` alone.
fn known(path: &Path, own: &str) -> Result<[BTreeMap<String, Entry>; 2]> {
    let mut known = BTreeMap::new();
    let mut earlier = BTreeMap::new();
    for name in manifest_names(path)? {
        let views = Manifest::read(&path.join(&name))?.views;
        let named = views.into_iter().map(|entry| (entry.name.clone(), entry));
        if name == own {
            earlier.extend(named.clone());
        }
        known.extend(named);
    }
    Ok([known, earlier])
}

fn manifest_name(shard: Option<Shard>) -> String {
    shard.map_or_else(|| MANIFEST.to_owned(), Shard::manifest_name)
}

/// Names of a sweep's and its shards' manifests, sorted; the sweep's comes last and wins.
pub(super) fn manifest_names(folder: &Path) -> Result<Vec<String>> {
    let mut names = file_names(folder)?;
    names.retain(|name| name == MANIFEST || Shard::of_manifest_name(name).is_some());
    names.sort();
    Ok(names)
}

pub(super) fn file_names(folder: &Path) -> Result<Vec<String>> {
    let io = |e| Error::io(folder, e);
    let mut names = Vec::new();
    for item in fs::read_dir(folder).map_err(io)? {
        names.extend(item.map_err(io)?.file_name().into_string());
    }
    Ok(names)
}

/// Files that processes have begun and not ended: `output::atomic` names them so.
fn unfinished(folder: &Path) -> Result<Vec<String>> {
    let mut names = file_names(folder)?;
    names.retain(|name| name.starts_with('.') && name.ends_with(".partial"));
    Ok(names)
}

/// Whether an unfinished file was to become `output`.
fn is_of(unfinished: &str, output: &str) -> bool {
    let rest = unfinished.strip_prefix('.').and_then(|name| name.strip_prefix(output));
    let number = |part: &str| !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit());
    let mut parts = rest.unwrap_or_default().split('.');
    // Process and count follow, as in ".view_0001.exr.4711.0.partial".
    parts.next() == Some("")
        && parts.next().is_some_and(number)
        && parts.next().is_some_and(number)
        && parts.eq(["partial"])
}

pub(super) fn remove(path: &Path) -> Result<()> {
    match fs::remove_file(path) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(Error::io(path, e)),
        _ => Ok(()),
    }
}

/// Shards share a folder; a whole sweep has it alone. Where folders cannot be locked there is no
/// lock: files are whole all the same.
fn lock(path: &Path, shard: Option<Shard>) -> Result<Option<File>> {
    let Ok(file) = File::open(path) else {
        return Ok(None);
    };
    let locked = match shard {
        Some(_) => file.try_lock_shared(),
        None => file.try_lock(),
    };
    match locked {
        Ok(()) => Ok(Some(file)),
        Err(TryLockError::WouldBlock) => {
            let problem = format!("another process sweeps into {}", path.display());
            Err(Error::inconsistent("sweep", problem))
        }
        Err(TryLockError::Error(_)) => Ok(None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::scratch::ScratchFolder;

    fn files(scratch: &ScratchFolder) -> Vec<String> {
        let mut names = file_names(&scratch.path("")).unwrap();
        names.sort();
        names
    }

    fn open(scratch: &ScratchFolder, shard: Option<&str>) -> Folder {
        let shard = shard.map(|text| text.parse().unwrap());
        Folder::open(&scratch.path(""), shard, Source::default()).unwrap()
    }

    /// A sweep of thousands costs no more a view than one of a hundred.
    #[test]
    fn a_view_adds_one_line_and_nothing_else() {
        let scratch = ScratchFolder::new();
        let mut folder = open(&scratch, None);
        let (manifest, log) = (scratch.path(MANIFEST), log_path(&scratch.path(MANIFEST)));
        let (mut first, mut length) = (None, 0);
        for index in 1..=100 {
            let entry = Entry { index, name: format!("view_{index:04}"), ..Entry::new() };
            length += entry.to_line().len() as u64;
            folder.add(entry, 1.0).unwrap();
            let now =
                (fs::read(&manifest).unwrap(), manifest.metadata().unwrap().modified().unwrap());
            assert_eq!(first.get_or_insert_with(|| now.clone()), &now);
            assert_eq!(log.metadata().unwrap().len(), length);
            assert_eq!(files(&scratch).len(), 2);
        }
    }

    #[test]
    fn shards_remove_what_is_their_own_alone() {
        let scratch = ScratchFolder::new();
        let left = [
            ".manifest.1-of-2.json.7.0.partial",
            ".manifest.2-of-2.json.8.0.partial",
            ".timings.1-of-2.js.7.1.partial",
            ".view_0001.exr.7.2.partial",
            ".view_0001_luminance.png.7.3.partial",
            ".view_0001.exr.bak.7.2.partial",
            ".view_0002.exr.8.1.partial",
        ];
        for name in left {
            std::fs::write(scratch.path(name), "half").unwrap();
        }
        let folder = open(&scratch, Some("1/2"));
        assert_eq!(files(&scratch), [left[1], left[3], left[5], left[4], left[6]]);
        // What another begins after that is not touched.
        std::fs::write(scratch.path(".view_0001.png.9.0.partial"), "half").unwrap();
        folder.remove_unfinished_of("view_0001").unwrap();
        let kept = [left[1], left[5], ".view_0001.png.9.0.partial", left[6]];
        assert_eq!(files(&scratch), kept);
        drop(folder);
        drop(open(&scratch, None));
        assert!(files(&scratch).is_empty());
    }
}
