//! Runs a sweep: each view is kept or rendered, developed, read and entered in the manifest.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use serde_json::{Map, Value, json};

use super::digest::{Digest, Hasher};
use super::folder::Folder;
use super::luminance::{LuminanceScale, luminance_raster};
use super::manifest::{Entry, FileDigest, Source};
use super::page::luminance_name;
use super::record::{Reading, display_record};
use super::shard::Shard;
use super::{executable, program};
use crate::display::{GamutReport, Look, Tone};
use crate::error::{Error, Result};
use crate::image::{Region, SpectralImage};
use crate::output;
use crate::program::progress::Progress;
use crate::program::results::{ASKED, READING, STATS, VIEW};
use crate::program::stage::Stage;
use crate::render::{Asked, RenderStats, Watch, why_black};
use crate::scene::plausibility;
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
    /// Quality of the pictures.
    pub asked: Asked,
    /// How they are shown.
    pub look: Look,
    /// Parts of the pictures to read, by name.
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
}

/// What a sweep did.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Done {
    /// Views that were rendered.
    pub rendered: usize,
    /// Views that were there already.
    pub kept: usize,
    /// What the display cannot show of the rendered ones.
    pub gamut: GamutReport,
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
    ) -> std::result::Result<Done, E> {
        let mut folder = Folder::open(folder, self.shard, (self.source)()?)?;
        folder.set_display(display_record(&self.look.display));
        let mut done = Done::default();
        let mut names = BTreeSet::new();
        for (index, shot) in (1..).zip(shots) {
            let shot = shot?;
            if !names.insert(shot.name.clone()) {
                let problem = format!("two views are named \"{}\"", shot.name);
                return Err(Error::inconsistent("sweep: views", problem).into());
            }
            if folder.is_ours(index) {
                self.take(&mut folder, index, &shot, count, &mut done)?;
            }
        }
        folder.set_source((self.source)()?);
        folder.finish()?;
        Ok(done)
    }

    /// Keeps the view if it is there, and makes it if not.
    fn take(
        &self,
        folder: &mut Folder,
        index: usize,
        shot: &Shot,
        count: Option<usize>,
        done: &mut Done,
    ) -> Result<()> {
        let key = self.key(shot)?;
        if folder.keep(index, &shot.name, &key) {
            done.kept += 1;
            self.progress.pixels_done(shot.view.pixels());
            return Ok(());
        }
        if count.is_none() {
            self.progress.more_pixels(shot.view.pixels());
        }
        folder.remove_unfinished_of(&shot.name)?;
        self.progress.begin_view(index, count);
        let start = Instant::now();
        let (image, stats) = self.render(shot)?;
        let (outputs, mut details) = self.write(folder.path(), shot, &image, done)?;
        details.extend(self.details(shot, &image, &stats)?);
        folder.set_source((self.source)()?);
        let entry = Entry { index, name: shot.name.clone(), key, outputs, details };
        folder.add(entry, start.elapsed().as_secs_f64())?;
        done.rendered += 1;
        Ok(())
    }

    /// Digest of everything that the files of a view depend on.
    fn key(&self, shot: &Shot) -> Result<Digest> {
        let mut hasher = Hasher::new();
        hasher.text(&program());
        hasher.text(executable().map_or("", Digest::as_str));
        hasher.text(&self.script);
        hasher.text(shot.stage.fingerprint().as_str());
        let (view, asked, regions) = (&shot.view, &self.asked, &self.regions);
        hasher.text(&format!("{view:?} {asked:?} {regions:?} {:?}", self.look));
        if matches!(self.look.tone, Tone::Curve(_)) {
            // What a function does is in the script and in what it reads.
            hasher.text(&format!("{:?}", (self.source)()?));
        }
        Ok(hasher.finish())
    }

    fn render(&self, shot: &Shot) -> Result<(SpectralImage, RenderStats)> {
        let prepared = shot.stage.prepared(self.warn)?;
        plausibility::of_view(&prepared, &shot.view).into_iter().for_each(self.warn);
        let (mut image, stats) = self.asked.render(&prepared, &shot.view, self.progress)?;
        if let Some(report) = stats.target.filter(|report| !report.is_reached()) {
            (self.warn)(report.to_string());
        }
        let reason = why_black(&image, &prepared, &shot.view, self.asked.limits())?;
        reason.into_iter().for_each(self.warn);
        image.metadata.insert("script".to_owned(), self.script.clone());
        Ok((image, stats))
    }

    /// The view's files, and what its pictures were made with.
    fn write(
        &self,
        folder: &Path,
        shot: &Shot,
        image: &SpectralImage,
        done: &mut Done,
    ) -> Result<(Vec<FileDigest>, Map<String, Value>)> {
        let name = &shot.name;
        let names = [format!("{name}.exr"), format!("{name}.png"), luminance_name(name)];
        let [exr, png, luminance] = names.each_ref().map(|name| folder.join(name));
        output::write_exr(&exr, image)?;
        let picture = output::develop_png(&png, image, &self.look)?.picture;
        done.gamut = done.gamut.merge(picture.gamut);
        let xyz = image.to_xyz();
        let scale = LuminanceScale::of(&xyz);
        output::write_png(&luminance, &luminance_raster(&xyz, scale)?)?;
        let details = [
            ("exposure", json!(picture.exposure_factor)),
            ("luminance", json!({ "top": scale.top, "max": scale.max })),
        ];
        let outputs = names.iter().map(|name| FileDigest::of(folder, name));
        Ok((outputs.collect::<Result<_>>()?, rows(details)))
    }

    fn details(
        &self,
        shot: &Shot,
        image: &SpectralImage,
        stats: &RenderStats,
    ) -> Result<Map<String, Value>> {
        let mut readings = Map::new();
        for (name, region) in &self.regions {
            readings.insert(name.clone(), READING.record(&Reading::of(image, *region)?).to_json());
        }
        Ok(rows([
            ("view", VIEW.record(&shot.view).to_json()),
            ("quality", ASKED.record(&self.asked).to_json()),
            ("stats", STATS.record(stats).to_json()),
            ("scene", json!(shot.stage.fingerprint().as_str())),
            ("photometry", json!(format!("{:?}", image.photometry).to_lowercase())),
            ("regions", readings.into()),
        ]))
    }
}

fn rows<const N: usize>(rows: [(&str, Value); N]) -> Map<String, Value> {
    rows.map(|(key, value)| (key.to_owned(), value)).into_iter().collect()
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
