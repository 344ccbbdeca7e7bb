//! The pictures of a sweep, developed from its EXR files: no view is rendered for them.

use std::path::Path;

use serde_json::{Map, Value, json};

use super::digest::{Digest, Hasher};
use super::look_record::{look_from_record, look_record};
use super::luminance::{LuminanceScale, luminance_raster};
use super::manifest::{Entry, FileDigest};
use super::page::luminance_name;
use super::record::RegionReading;
use crate::display::{Exposure, GamutReport, Look};
use crate::error::{Error, Result};
use crate::image::{Region, SpectralImage};
use crate::output;
use crate::program::intensity;
use crate::program::results::READING;

/// Whether the views of a sweep are shown alike.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Share {
    /// One for all views: they can be compared.
    #[default]
    One,
    /// Each view has its own.
    Each,
}

/// How the pictures of a sweep are made.
#[derive(Debug, Clone)]
pub struct Pictures {
    /// How light is shown.
    pub look: Look,
    /// Automatic exposure: that of the brightest view, or each view's own.
    pub exposure: Share,
    /// Range of the false colors of luminance.
    pub false_color: Share,
    /// What decides on the look besides its own values: what a function of it reads.
    pub read_by_look: String,
}

impl Pictures {
    /// For a manifest.
    pub(super) fn record(&self) -> Value {
        json!({
            "look": look_record(&self.look),
            "exposure": share_name(self.exposure),
            "false_color": share_name(self.false_color),
        })
    }

    /// What [`Pictures::record`] was made from; `None` for a look that is a script's function, or no record.
    pub(super) fn from_record(record: &Value) -> Option<Self> {
        Some(Self {
            look: look_from_record(record.get("look")?)?,
            exposure: share_from_name(record.get("exposure")?)?,
            false_color: share_from_name(record.get("false_color")?)?,
            read_by_look: String::new(),
        })
    }

    fn look_text(&self) -> String {
        format!("{} {}", look_record(&self.look), self.read_by_look)
    }

    /// Digest of all that [`Pictures::measure`] depends on, besides the image.
    pub(super) fn measure_key(&self, regions: &[(String, Region)]) -> Digest {
        let mut hasher = Hasher::new();
        hasher.text(&self.look_text());
        hasher.text(&format!("{regions:?}"));
        hasher.finish()
    }

    /// What a view's picture and page need to know of its image.
    ///
    /// Errors: a region that leaves the image; as [`Look::latent`].
    pub(super) fn measure(
        &self,
        image: &SpectralImage,
        regions: &[(String, Region)],
    ) -> Result<Map<String, Value>> {
        let mut readings = Map::new();
        for (name, region) in regions {
            readings.insert(
                name.clone(),
                READING.record(&RegionReading::of(image, *region)?).to_json(),
            );
        }
        let xyz = image.to_xyz();
        let scale = LuminanceScale::of(&xyz);
        let mean = xyz.pixels.iter().map(|c| c.y).sum::<f64>() / xyz.pixels.len().max(1) as f64;
        let intensity = image.view.and_then(|view| intensity::intensity(image, &view).ok());
        let automatic = self.look.factor(&self.look.latent(image)?)?;
        Ok(rows([
            ("regions", readings.into()),
            ("luminance", json!({ "max": scale.max, "mean": mean, "range": scale.range })),
            ("intensity", json!(intensity.map(|xyz| xyz.y))),
            ("automatic_exposure", json!(automatic)),
            ("measured", json!(self.measure_key(regions).as_str())),
        ]))
    }

    /// Develops what is not there yet; says what the display cannot show of that.
    ///
    /// Errors: [`Error::Io`]; an EXR file that does not read; as [`Look::show`].
    pub(super) fn write_all(&self, folder: &Path, entries: &mut [Entry]) -> Result<GamutReport> {
        let factors: Vec<f64> =
            entries.iter().map(|e| number(e, &["automatic_exposure"])).collect();
        let brightest = factors.iter().copied().fold(f64::INFINITY, f64::min);
        let ranges: Vec<[f64; 2]> = entries.iter().map(range_of).collect();
        let all = LuminanceScale::range_of_all(&ranges);
        let mut gamut = GamutReport::default();
        for ((entry, factor), range) in entries.iter_mut().zip(factors).zip(ranges) {
            let shown = Shown {
                factor: if self.exposure == Share::One { brightest } else { factor },
                range: if self.false_color == Share::One { all } else { range },
            };
            let key = self.picture_key(entry, &shown);
            let is_there = entry.pictures.iter().all(|picture| picture.is_in(folder));
            if entry.picture_key.as_ref() != Some(&key) || !is_there {
                gamut = gamut.merge(self.write(folder, entry, &shown)?);
                entry.picture_key = Some(key);
            }
        }
        Ok(gamut)
    }

    fn picture_key(&self, entry: &Entry, shown: &Shown) -> Digest {
        let mut hasher = Hasher::new();
        hasher.text(&self.look_text());
        hasher.text(&format!("{:?} {shown:?}", entry.outputs));
        hasher.finish()
    }

    fn write(&self, folder: &Path, entry: &mut Entry, shown: &Shown) -> Result<GamutReport> {
        let name = &entry.name;
        let names = [format!("{name}.png"), luminance_name(name)];
        let [png, luminance] = names.each_ref().map(|name| folder.join(name));
        let image = output::read_exr(&folder.join(format!("{name}.exr")))?;
        let look = Look { exposure: Exposure::Factor(shown.factor), ..self.look.clone() };
        let picture = output::develop_png(&png, &image, &look)?.picture;
        let scale =
            LuminanceScale { range: shown.range, max: number(entry, &["luminance", "max"]) };
        output::write_png(&luminance, &luminance_raster(&image.to_xyz(), scale)?)?;
        entry.details.insert("exposure".to_owned(), json!(shown.factor));
        entry.details.insert("false_color".to_owned(), json!(shown.range));
        let pictures = names.iter().map(|name| FileDigest::of(folder, name));
        entry.pictures = pictures.collect::<Result<_>>()?;
        Ok(picture.gamut)
    }
}

/// What differs from view to view, unless all share it.
#[derive(Debug)]
struct Shown {
    factor: f64,
    /// Ends of the false colors, in the unit of the image.
    range: [f64; 2],
}

fn share_name(share: Share) -> &'static str {
    match share {
        Share::One => "one",
        Share::Each => "each",
    }
}

fn share_from_name(name: &Value) -> Option<Share> {
    match name.as_str()? {
        "one" => Some(Share::One),
        "each" => Some(Share::Each),
        _ => None,
    }
}

fn number(entry: &Entry, keys: &[&str]) -> f64 {
    let first = entry.details.get(keys[0]);
    let found = keys[1..].iter().try_fold(first, |value, key| Some(value?.get(key)));
    found.flatten().and_then(Value::as_f64).unwrap_or(1.0)
}

fn range_of(entry: &Entry) -> [f64; 2] {
    let range = entry.details.get("luminance").and_then(|l| l.get("range"));
    let end = |at: usize| range.and_then(|r| r.get(at)?.as_f64());
    end(0).zip(end(1)).map_or(LuminanceScale::BLACK, |(low, high)| [low, high])
}

/// Rows of a manifest.
pub(super) fn rows<const N: usize>(rows: [(&str, Value); N]) -> Map<String, Value> {
    rows.map(|(key, value)| (key.to_owned(), value)).into_iter().collect()
}

/// The pictures that a manifest asks for.
///
/// Errors: a look that only its script knows.
pub(super) fn from_manifest(record: &Value) -> Result<Pictures> {
    Pictures::from_record(record).ok_or_else(|| {
        let problem = "the tone curve is a function of the script: run the script without --shard \
                       into the folder of the shards, which keeps their views";
        Error::inconsistent("merge", problem)
    })
}
