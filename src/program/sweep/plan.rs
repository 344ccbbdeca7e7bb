//! Runs a sweep: each view is kept or rendered and measured; then all are developed.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use serde_json::{Map, Value, json};

use super::again::{cause, sentences};
use super::digest::{Digest, Hasher};
use super::folder::Folder;
use super::manifest::{Entry, FileDigest, Source};
use super::page::luminance_name;
use super::pictures::{Pictures, rows};
use super::shard::Shard;
use super::{executable, program};
use crate::display::GamutReport;
use crate::error::{Error, Result};
use crate::image::{Region, SpectralImage};
use crate::output;
use crate::program::progress::Progress;
use crate::program::results::{ASKED, STATS, VIEW};
use crate::program::screen::{self, Screen};
use crate::program::stage::Stage;
use crate::render::{Asked, RenderStats, why_black};
use crate::scene::plausibility;
use crate::shading::TraceCounts;
use crate::view::View;

/// One view of a sweep, and what it shows.
#[derive(Debug, Clone)]
pub struct Shot {
    /// Names the files; see [`check_name`].
    pub name: String,
    /// From where.
    pub view: View,
    /// What is seen.
    pub stage: Arc<Stage>,
}

/// What all views of a sweep share.
pub struct Plan<'a> {
    /// Quality of the images.
    pub asked: Asked,
    /// How they are shown.
    pub pictures: Pictures,
    /// Parts of the images to read, by name.
    pub regions: Vec<(String, Region)>,
    /// The views that are this run's; `None` for all.
    pub shard: Option<Shard>,
    /// Name of the script, for the images' metadata.
    pub script: String,
    /// Tells what has been read so far; asked again and again, since a script reads as it goes on.
    pub source: &'a dyn Fn() -> Result<Source>,
    /// Told of pixels and views.
    pub progress: &'a Progress,
    /// Takes what silently changes a picture.
    pub warn: &'a dyn Fn(String),
    /// Where views are shown while they come.
    pub screen: Option<&'a Screen>,
    /// Render and write nothing, and only tell what would be.
    pub is_dry_run: bool,
}

/// What a sweep did.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SweepOutcome {
    /// Views that were rendered, or would be.
    pub rendered: usize,
    /// Each of them with the reason; `None` for one that was not there.
    pub causes: Vec<(String, Option<&'static str>)>,
    /// Views of earlier runs that this one has not: of a dry run.
    pub left_over: Vec<String>,
    /// Views that were there already.
    pub kept: usize,
    /// What the display cannot show of the pictures that were developed.
    pub gamut: GamutReport,
    /// Rays and sums of the views that were rendered.
    pub counts: TraceCounts,
}

impl Plan<'_> {
    /// Sweeps `shots` into `folder`; `count` is how many there are, if that is known.
    ///
    /// Errors: the first of `shots`; two of one name; those of rendering, developing and writing.
    pub fn run<E: From<Error>>(
        &self,
        folder: &Path,
        shots: impl Iterator<Item = std::result::Result<Shot, E>>,
        count: Option<usize>,
    ) -> std::result::Result<SweepOutcome, E> {
        let mut folder = match self.is_dry_run {
            true => Folder::look(folder, self.shard)?,
            false => Folder::open(folder, self.shard, (self.source)()?)?,
        };
        folder.set_pictures(self.pictures.record());
        let mut done = SweepOutcome::default();
        let mut names = BTreeSet::new();
        let mut files = BTreeSet::new();
        for (index, shot) in (1..).zip(shots) {
            let shot = shot?;
            if !names.insert(shot.name.clone()) {
                let problem = format!("two views are named \"{}\"", shot.name);
                return Err(Error::inconsistent("sweep: views", problem).into());
            }
            if let Some(file) =
                outputs_of(&shot.name).into_iter().find(|f| !files.insert(f.clone()))
            {
                let problem = format!("\"{}\" and another view both write {file}", shot.name);
                return Err(Error::inconsistent("sweep: views", problem).into());
            }
            if folder.is_ours(index) {
                self.take(&mut folder, index, &shot, count, &mut done)?;
            }
        }
        let again: Vec<_> = done
            .causes
            .iter()
            .filter_map(|(view, cause)| Some((view.clone(), (*cause)?)))
            .collect();
        if self.is_dry_run {
            let left = folder.left_over(|name| names.contains(name));
            done.left_over = left.into_iter().map(str::to_owned).collect();
            return Ok(done);
        }
        folder.set_source((self.source)()?);
        let finished = folder.finish(&self.pictures)?;
        let moved = finished.moved.map(|moved| format!("sweep: {moved}"));
        sentences(&again).into_iter().chain(moved).for_each(self.warn);
        done.gamut = finished.gamut;
        done.counts.warnings().into_iter().for_each(self.warn);
        Ok(done)
    }

    /// Keeps the view if it is there, and makes it if not.
    fn take(
        &self,
        folder: &mut Folder,
        index: usize,
        shot: &Shot,
        count: Option<usize>,
        done: &mut SweepOutcome,
    ) -> Result<()> {
        let key = self.key(shot);
        if let Some(entry) = folder.kept(index, &shot.name, &key) {
            done.kept += 1;
            if count.is_some() {
                self.progress.pixels_kept(shot.view.pixels());
            }
            if !self.is_dry_run {
                folder.put(self.measured(folder.path(), entry)?);
            }
            return Ok(());
        }
        let known = folder.known(&shot.name);
        let cause = known.map(|entry| cause(entry, folder.path(), &self.asked_of(shot)));
        done.causes.push((shot.name.clone(), cause));
        done.rendered += 1;
        if self.is_dry_run {
            return Ok(());
        }
        if count.is_none() {
            self.progress.more_pixels(shot.view.pixels());
        }
        folder.remove_unfinished_of(&shot.name)?;
        self.progress.begin_view(index, count);
        let start = Instant::now();
        let (image, stats) = self.render(shot)?;
        let exr = format!("{}.exr", shot.name);
        output::write_exr(&folder.path().join(&exr), &image)?;
        let mut details = self.details(shot, &image, &stats);
        details.extend(self.pictures.measure(&image, &self.regions)?);
        folder.set_source((self.source)()?);
        let outputs = vec![FileDigest::of(folder.path(), &exr)?];
        let entry = Entry { index, name: shot.name.clone(), key, outputs, details, ..Entry::new() };
        folder.add(entry, start.elapsed().as_secs_f64())?;
        done.counts = done.counts + stats.counts;
        Ok(())
    }

    /// Digest of everything that a view's image depends on, and nothing that only its picture does.
    fn key(&self, shot: &Shot) -> Digest {
        let mut hasher = Hasher::new();
        hasher.text(&program());
        hasher.text(executable().map_or("", Digest::as_str));
        hasher.text(&self.script);
        hasher.text(shot.stage.fingerprint().as_str());
        hasher.text(&format!("{:?} {:?}", shot.view, self.asked));
        hasher.finish()
    }

    /// An entry with what picture and page need, measured again if that is of another look.
    fn measured(&self, folder: &Path, mut entry: Entry) -> Result<Entry> {
        let key = self.pictures.measure_key(&self.regions);
        if entry.details.get("measured").and_then(Value::as_str) != Some(key.as_str()) {
            let image = output::read_exr(&folder.join(format!("{}.exr", entry.name)))?;
            entry.details.extend(self.pictures.measure(&image, &self.regions)?);
        }
        Ok(entry)
    }

    fn render(&self, shot: &Shot) -> Result<(SpectralImage, RenderStats)> {
        let prepared = shot.stage.prepared(self.warn)?;
        self.progress.starts_rendering();
        plausibility::of_view(&prepared, &shot.view).into_iter().for_each(self.warn);
        let (mut image, stats, _) =
            screen::render(self.screen, &self.asked, &prepared, &shot.view, self.progress)?;
        if let Some(report) = stats.target.filter(|report| !report.is_reached()) {
            (self.warn)(report.to_string());
        }
        let reason = why_black(&image, &prepared, &shot.view, self.asked.limits())?;
        reason.into_iter().for_each(self.warn);
        image.metadata.insert("script".to_owned(), self.script.clone());
        Ok((image, stats))
    }

    fn details(
        &self,
        shot: &Shot,
        image: &SpectralImage,
        stats: &RenderStats,
    ) -> Map<String, Value> {
        let mut details = self.asked_of(shot);
        details.extend(rows([
            ("stats", STATS.record(stats).to_json()),
            ("photometry", json!(format!("{:?}", image.photometry).to_lowercase())),
        ]));
        details
    }

    /// What decides on a view's image.
    fn asked_of(&self, shot: &Shot) -> Map<String, Value> {
        rows([
            ("view", VIEW.record(&shot.view).to_json()),
            ("quality", ASKED.record(&self.asked).to_json()),
            ("scene", json!(shot.stage.fingerprint().as_str())),
        ])
    }
}

/// The files that a view of this name has.
fn outputs_of(name: &str) -> [String; 3] {
    [format!("{name}.exr"), format!("{name}.png"), luminance_name(name)]
}

/// Names of views become names of files.
///
/// Errors: [`Error::OutOfRange`] for a name that is no plain file name, or that of a file that
/// every sweep has.
pub fn check_name(object: &str, name: &str) -> Result<()> {
    let plain = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-' | '.' | '+');
    let reserved = ["manifest", "index", "contact_sheet", "timings"];
    if !name.is_empty()
        && name.len() <= 200
        && !name.starts_with('.')
        && name.chars().all(plain)
        && !reserved.contains(&name)
    {
        return Ok(());
    }
    let allowed = "letters, digits and _ - + ., not a dot first, no name of the sweep's own files";
    Err(Error::out_of_range(object, "\"name\"", format!("\"{name}\""), allowed))
}
