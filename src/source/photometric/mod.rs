//! Photometric files as far-field sources: IES LM-63 and EULUMDAT.
//!
//! What such a file holds is the intensity of a whole lamp by direction, as from a point: it says
//! nothing of where on the lamp the light starts, so that surfaces nearer than ten times the
//! luminous opening see a wrong light.

mod eulumdat;
mod lm63;
mod solid;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;

pub use self::solid::{AngleType, Solid};

use super::sequence::EvenSequence;
use crate::columns;
use crate::error::{Error, Place, Result};
use crate::input;
use crate::light::{RaySample, RaySet};

/// The kind of a photometric file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PhotometricFormat {
    /// IES LM-63 of any year.
    Lm63,
    /// EULUMDAT.
    Eulumdat,
}

impl std::fmt::Display for PhotometricFormat {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Lm63 => "IES LM-63",
            Self::Eulumdat => "EULUMDAT",
        })
    }
}

/// What a photometric file holds.
#[derive(Debug, Clone, PartialEq)]
pub struct PhotometricFile {
    /// Where it was read from.
    pub path: PathBuf,
    /// Its kind.
    pub format: PhotometricFormat,
    /// Intensity by direction.
    pub solid: Solid,
    /// Luminous flux of the lamps that the header states, lm.
    pub lamp_flux_lm: Option<f64>,
    /// Largest side or diameter of the luminous opening, mm; 0 for a point.
    pub opening_mm: f64,
    /// Name and text of the header's descriptions.
    pub description: Vec<(String, String)>,
    /// What was left aside, a sentence each.
    pub warnings: Vec<String>,
}

/// More is no photometric file.
const MOST_BYTES: usize = 1 << 28;

/// Whether a file's first bytes are those of a photometric file.
///
/// EULUMDAT has no mark: its third to seventh lines are numbers, the first is not.
pub fn is_photometric(head: &[u8]) -> bool {
    let text = String::from_utf8_lossy(head);
    let text = text.trim_start_matches('\u{feff}');
    lm63::is_lm63(text) || eulumdat::is_eulumdat(text)
}

/// Reads a photometric file, told by its content.
///
/// Errors: [`Error::Io`]; [`Error::BadFile`] with the line, where there is one.
pub fn read(path: &Path) -> Result<PhotometricFile> {
    from_bytes(path, input::bytes(path)?)
}

/// As [`read`]; `path` only names the bytes in messages.
pub fn from_bytes(path: &Path, bytes: Vec<u8>) -> Result<PhotometricFile> {
    let bad = |line: u64, what: String| {
        let place = if line == 0 { Place::File } else { Place::Line(line) };
        Error::bad_file(path, place, what)
    };
    if bytes.len() > MOST_BYTES {
        return Err(bad(0, format!("is larger than {} MiB", MOST_BYTES >> 20)));
    }
    let text = columns::text_of(path, bytes)?;
    let read = if lm63::is_lm63(&text) { lm63::read(&text) } else { eulumdat::read(&text) };
    let PhotometricParts { format, solid, lamp_flux_lm, opening_mm, description, warnings } =
        read.map_err(|(line, what)| bad(line, what))?;
    if solid.flux_lm() <= 0.0 {
        return Err(bad(0, "the lamp gives no light in any direction".to_owned()));
    }
    let path = path.to_owned();
    Ok(PhotometricFile { path, format, solid, lamp_flux_lm, opening_mm, description, warnings })
}

/// What a reader finds.
struct PhotometricParts {
    format: PhotometricFormat,
    solid: Solid,
    lamp_flux_lm: Option<f64>,
    opening_mm: f64,
    description: Vec<(String, String)>,
    warnings: Vec<String>,
}

/// Line (0 for the file) and what is wrong.
type PhotometricFault = (u64, String);

/// How a far-field source is sampled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FarField {
    /// Radius of the disc about the origin on which rays start, facing +Z, mm; 0 is a point.
    pub radius_mm: f64,
    /// How many rays.
    pub samples: usize,
    /// The same seed gives the same rays.
    pub seed: u64,
}

/// A source seen from ten times its size looks like a point within 1 % or so.
const TIMES_THE_OPENING: f64 = 10.0;

impl PhotometricFile {
    /// Nearer surfaces see a wrong light, mm; 0 for a point.
    pub fn good_beyond_mm(&self) -> f64 {
        TIMES_THE_OPENING * self.opening_mm
    }

    /// Rays from a point or a disc with the file's distribution of directions: +Z is its axis (C
    /// and γ: γ = 0°; types A and B: 0°, 0°), +Y its 90° plane or its upward angle.
    ///
    /// Each ray carries nearly the same flux; their sum is the solid's.
    /// Errors: [`Error::OutOfRange`] for no samples, or a radius that is negative or not finite.
    pub fn rays(&self, far_field: FarField) -> Result<RaySet> {
        let FarField { radius_mm, samples, seed } = far_field;
        if samples == 0 {
            return Err(Error::out_of_range("far field", "samples", samples, "1 or more"));
        }
        if !(radius_mm >= 0.0 && radius_mm.is_finite()) {
            return Err(Error::out_of_range("far field", "radius", radius_mm, "0 mm or more"));
        }
        let sequence = EvenSequence::new(seed);
        let turns = EvenSequence::new(!seed);
        let sampler = self.solid.sampler();
        let ray = |index: usize| {
            let [u, v, w, r] = sequence.point(index as u32);
            let (direction, flux) = sampler.sample([u, v, w]);
            let (sin, cos) = (std::f64::consts::TAU * turns.point(index as u32)[0]).sin_cos();
            let position = DVec3::new(cos, sin, 0.0) * (radius_mm * r.sqrt());
            RaySample {
                position: position.as_vec3().to_array(),
                direction: direction.as_vec3().to_array(),
                flux: flux as f32,
            }
        };
        let rays: Arc<[RaySample]> = (0..samples).map(ray).collect();
        Ok(RaySet::new(rays, self.solid.flux_lm()))
    }
}

#[cfg(test)]
mod tests;
