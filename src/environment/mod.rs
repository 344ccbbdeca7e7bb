//! Surroundings: what a ray sees that leaves the scene, and the light that comes from there.
//!
//! Everything is far away: only directions count, and nothing falls off. Luminance by direction (a
//! picture, a sky, a room) is a mix of at most three spectra, so that a lobe's integral is at most
//! three numbers and no noise: the sphere is halved again and again, each part has the moments of
//! its light, and a sum takes the coarsest parts that keep its error ([`FarSum`]). The sun is a
//! disc beside that.
//!
//! +Y is up; azimuths are a view's, so that what stands at azimuth 0 and elevation 0 lies behind
//! the viewer of a lamp's front.

mod daylight;
mod dome;
mod far;
mod node;
mod patch;
mod picture;
mod room;
mod sky;
mod sun;
mod table;

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DQuat, DVec3};

pub use daylight::{Daylight, SunPlace};
pub use dome::{CHANNELS, Dome, Luminances};
pub use far::FarSum;
pub use picture::Picture;
pub use room::{CeilingPanel, Room};
pub use sky::{Sky, SkyKind, StandardSky};
pub use sun::{SUN_RADIUS_RAD, Sun, air_mass, sun_through_air};

use crate::color::Photometry;
use crate::error::{Error, Result};
use crate::light::sum::power::specular_powers;
use crate::light::sum::{HitQuery, Side};
use crate::spectrum::{Spectrum, WavelengthGrid};
use far::FarTree;
use node::FarLobe;

/// Unit direction of a view's azimuth and elevation: (sin a cos e, sin e, cos a cos e).
pub fn toward(azimuth_deg: f64, elevation_deg: f64) -> DVec3 {
    let (sin_a, cos_a) = azimuth_deg.to_radians().sin_cos();
    let (sin_e, cos_e) = elevation_deg.to_radians().sin_cos();
    DVec3::new(sin_a * cos_e, sin_e, cos_a * cos_e)
}

/// Far surroundings, prepared for rays and for lobes.
#[derive(Debug, Clone)]
pub struct Environment {
    dome: Arc<Dome>,
    tree: Arc<FarTree>,
    /// Spectra of the dome's luminances, relative; at most [`CHANNELS`].
    spectra: Vec<Spectrum>,
    /// Times the dome's luminances.
    scale: f64,
    /// From the dome's coordinates to the world's.
    turn: DQuat,
    sun: Option<Sun>,
}

/// What arrives at a hit from the surroundings, without spectra and reflectances.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FarLight {
    /// Through the lobes on the viewer's side.
    pub reflected: FarSide,
    /// Through the lobes on the far side.
    pub transmitted: FarSide,
    /// Tree nodes that were evaluated.
    pub nodes: u32,
}

/// One side of a hit; cd/m².
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FarSide {
    /// Sums for the surroundings' spectra.
    pub dome: Luminances,
    /// Sum for the sun's spectrum.
    pub sun: f64,
    /// Estimate of how wrong the sum of `dome` is.
    pub error: f64,
}

impl Environment {
    /// Errors: no spectrum, or more than [`CHANNELS`]; one without luminous flux.
    pub fn new(dome: Dome, spectra: Vec<Spectrum>) -> Result<Environment> {
        if !(1..=CHANNELS).contains(&spectra.len()) {
            let problem = format!("{} spectra, allowed: 1 to {CHANNELS}", spectra.len());
            return Err(Error::inconsistent("environment", problem));
        }
        for spectrum in &spectra {
            per_lumen(spectrum, WavelengthGrid::Step5)?;
        }
        let tree = Arc::new(FarTree::build(&dome));
        let dome = Arc::new(dome);
        Ok(Environment { dome, tree, spectra, scale: 1.0, turn: DQuat::IDENTITY, sun: None })
    }

    /// With a sun, which no turn and no scale changes.
    pub fn with_sun(self, sun: Sun) -> Environment {
        Environment { sun: Some(sun), ..self }
    }

    /// Turned right-handed about +Y: what stood at azimuth 0 then stands at `angle_deg`.
    pub fn turned(self, angle_deg: f64) -> Environment {
        let turn = DQuat::from_rotation_y(angle_deg.to_radians()) * self.turn;
        Environment { turn, ..self }
    }

    /// Everything but the sun `factor` times as bright.
    pub fn scaled(self, factor: f64) -> Environment {
        Environment { scale: self.scale * factor, ..self }
    }

    /// Luminance by direction, before scale and turn.
    pub fn dome(&self) -> &Dome {
        &self.dome
    }

    /// Relative spectra of the dome's luminances; one to [`CHANNELS`].
    pub fn spectra(&self) -> &[Spectrum] {
        &self.spectra
    }

    /// The sun, if there is one.
    pub fn sun(&self) -> Option<&Sun> {
        self.sun.as_ref()
    }

    /// Everything that a picture depends on.
    pub fn parts(&self) -> (&Dome, &[Spectrum], f64, DQuat, Option<&Sun>) {
        (&self.dome, &self.spectra, self.scale, self.turn, self.sun.as_ref())
    }

    /// lx on a plane with this normal, from all but the sun, within 1e-4.
    pub fn illuminance_lx(&self, normal: DVec3) -> f64 {
        let axis = self.turn.inverse() * normal;
        let lobe = FarLobe { axis, exponent: 1.0, weight: self.scale, horizon: None, half: None };
        self.tree.sum(&self.dome, &[lobe], 1e-4, None).values.iter().sum()
    }

    /// What a ray in `direction` sees: luminances of the spectra, and of the sun's.
    pub fn seen(&self, direction: DVec3) -> (Luminances, f64) {
        let local = self.turn.inverse() * direction;
        let dome = self.dome.luminances(patch::place(local), local).map(|l| l * self.scale);
        let sun = self.sun.as_ref().filter(|sun| sun.is_met_by(direction));
        (dome, sun.map_or(0.0, Sun::luminance))
    }

    /// What the lobes of a hit get: eq. 9 with far samples, absolute photometry.
    ///
    /// `largest_error` is relative to each side's sum; `sight` tells whether the surroundings are
    /// seen in a direction of the world.
    ///
    /// A ray that leaves the surface sees the surroundings, too: what `shares` leaves of the
    /// specular lobes keeps both together from returning more than arrives.
    pub fn light(
        &self,
        query: &HitQuery,
        shares: SpecularShares,
        largest_error: f64,
        sight: Option<&dyn Fn(DVec3) -> bool>,
    ) -> FarLight {
        let mut light = FarLight::default();
        let side_of = |side: Side, share: f64| {
            let lobes = self.lobes(query, &side, share);
            self.side(&lobes, &side, largest_error, sight)
        };
        let mut nodes = [0, 0];
        if query.reflects {
            (light.reflected, nodes[0]) = side_of(Side::reflected(query), shares.reflected);
        }
        if query.transmits {
            (light.transmitted, nodes[1]) = side_of(Side::transmitted(query), shares.transmitted);
        }
        FarLight { nodes: nodes[0] + nodes[1], ..light }
    }

    fn lobes(&self, query: &HitQuery, side: &Side, share: f64) -> Vec<FarLobe> {
        let given = query.lobes;
        let diffuse = FarLobe {
            axis: side.normal,
            exponent: given.n_d,
            weight: given.k_d / PI,
            horizon: None,
            half: None,
        };
        let powers = specular_powers(given, Photometry::Absolute, (side, share));
        let specular = powers.into_iter().map(|(weight, exponent)| FarLobe {
            axis: if side.is_half { side.normal } else { side.axis },
            exponent,
            weight,
            horizon: Some(side.normal),
            half: side.is_half.then(|| side.view()),
        });
        let all = std::iter::once(diffuse).chain(specular);
        all.filter(|lobe| lobe.weight > 0.0).collect()
    }

    fn side(
        &self,
        lobes: &[FarLobe],
        side: &Side,
        largest_error: f64,
        sight: Option<&dyn Fn(DVec3) -> bool>,
    ) -> (FarSide, u32) {
        if lobes.is_empty() {
            return (FarSide::default(), 0);
        }
        let back = self.turn.inverse();
        let local: Vec<FarLobe> = lobes
            .iter()
            .map(|lobe| FarLobe {
                axis: back * lobe.axis,
                horizon: lobe.horizon.map(|horizon| back * horizon),
                half: lobe.half.map(|view| back * view),
                ..*lobe
            })
            .collect();
        let local_sight = |direction: DVec3| sight.is_none_or(|seen| seen(self.turn * direction));
        let local_sight = sight.map(|_| &local_sight as &dyn Fn(DVec3) -> bool);
        let sum = self.tree.sum(&self.dome, &local, largest_error, local_sight);
        let far = FarSide {
            dome: sum.values.map(|value| value * self.scale),
            sun: self.sun.as_ref().map_or(0.0, |sun| sun_side(sun, lobes, side, sight)),
            error: sum.error * self.scale,
        };
        (far, sum.nodes)
    }
}

/// Parts of the specular lobes that count, 0 to 1, on the viewer's and on the far side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpecularShares {
    /// On the viewer's side.
    pub reflected: f64,
    /// On the far side.
    pub transmitted: f64,
}

/// What the sun sends through lobes; each of its points is seen or hidden.
fn sun_side(
    sun: &Sun,
    lobes: &[FarLobe],
    side: &Side,
    sight: Option<&dyn Fn(DVec3) -> bool>,
) -> f64 {
    if sun.direction.dot(side.normal) < -SUN_RADIUS_RAD {
        return 0.0;
    }
    /// Enough for lobes wider than the disc.
    const FEW: usize = 32;
    /// With those, enough to find an edge that crosses the disc: it hides less than 1 % of it else.
    const AT_RIM: usize = 16;
    /// Enough for exponents up to 10⁶, and for half shadows in steps of 0.1 %.
    const MANY: usize = 1024;
    let through = |direction: DVec3| -> f64 {
        let above = direction.dot(side.normal) > 0.0;
        if above { lobes.iter().map(|lobe| lobe.toward(direction)).sum() } else { 0.0 }
    };
    let is_seen = |direction: DVec3| sight.is_none_or(|seen| seen(direction));
    let sharpest = lobes.iter().map(FarLobe::sharpness).fold(1.0, f64::max);
    let probes = sun.spread(FEW).chain(sun.rim(AT_RIM));
    let visible = probes.filter(|point| is_seen(*point)).count();
    const ALL: usize = FEW + AT_RIM;
    let is_wide = sharpest * SUN_RADIUS_RAD * SUN_RADIUS_RAD < 0.1;
    let mean = |count: usize, counts: &dyn Fn(DVec3) -> bool| {
        let points = sun.spread(count).filter(|point| counts(*point));
        points.map(through).sum::<f64>() / count as f64
    };
    let each = match (visible, is_wide) {
        (0, _) => 0.0,
        (ALL, true) => mean(FEW, &|_| true),
        (ALL, false) => mean(MANY, &|_| true),
        _ => mean(MANY, &is_seen),
    };
    sun.illuminance_lx * each
}

/// A spectrum in W/nm a lm, at the bands of `grid`.
pub fn per_lumen(spectrum: &Spectrum, grid: WavelengthGrid) -> Result<Vec<f64>> {
    let luminous = spectrum.luminous_flux(grid);
    if luminous > 0.0 && luminous.is_finite() {
        return Ok(spectrum.scaled(luminous.recip()).on_grid(grid));
    }
    let problem = format!("a spectrum has no luminous flux at the bands of {} nm", grid.step_nm());
    Err(Error::inconsistent("environment", problem))
}

#[cfg(test)]
mod tests;
