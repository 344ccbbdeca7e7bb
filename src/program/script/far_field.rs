//! Photometric files in `lampyris.rayset.load`: far-field sources.

use std::path::Path;

use super::host::Host;
use super::light::{LuaLight, RaysetLoadOptions, placed};
use crate::error::{Error, Place};
use crate::input;
use crate::light::RaySet;
use crate::source::directions::measured_exponent;
use crate::source::photometric::{self, FarField};

const DEFAULT_SAMPLES: usize = 100_000;

/// A point, or a disc of `radius`, with the distribution of an IES LM-63 or EULUMDAT file.
pub(super) fn load(host: &Host, path: &Path, given: RaysetLoadOptions) -> mlua::Result<LuaLight> {
    let file = photometric::read(path)?;
    for warning in &file.warnings {
        host.warn(format!("{}: {warning}", path.display()));
    }
    let refuse = |problem: &str| mlua::Error::from(Error::bad_file(path, Place::File, problem));
    if given.emitter.is_some() {
        return Err(refuse("a photometric file says nothing of surfaces, give \"radius\""));
    }
    if given.start.is_some() {
        return Err(refuse("a photometric file has no start points to move, give \"radius\""));
    }
    let Some(spectrum) = given.spectrum else {
        return Err(refuse("the file has no spectrum, give \"spectrum\""));
    };
    let rays = file.rays(FarField {
        radius_mm: given.radius.unwrap_or(0.0),
        samples: given.samples.unwrap_or(DEFAULT_SAMPLES),
        seed: given.seed,
    })?;
    host.note_seed("rayset.load", given.seed);
    let flux_lm = given.flux.unwrap_or(rays.flux_lm);
    // The file's directions were measured: eq. 9's lobe would blur them by a cosine.
    let rays = match given.directions {
        Some(directions) => directions.of(rays)?,
        None => {
            let exponent = measured_exponent(&rays.samples);
            rays.with_exponent(exponent)?
        }
    };
    let light =
        LuaLight::new(RaySet { flux_lm, good_beyond_mm: file.good_beyond_mm(), ..rays }, spectrum);
    match given.transform {
        None => Ok(light),
        Some(transform) => placed(light, &transform),
    }
}

/// Whether the file is one of these, by its first bytes.
pub(super) fn is_far_field(path: &Path) -> bool {
    input::head(path, 4096).is_ok_and(|head| photometric::is_photometric(&head))
}
