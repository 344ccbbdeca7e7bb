//! CIE skies: luminance over the upper half of the directions.

use glam::DVec3;

use super::dome::Luminances;
use crate::error::{Error, Result};

/// How luminance is spread over the sky, relative to the zenith's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SkyKind {
    /// (1 + 2 sin γ)/3: Moon & Spencer's, CIE S 011's sixteenth.
    Overcast,
    /// One of the 15 types of CIE S 011/E:2003; 12 is the CIE clear sky.
    Standard(StandardSky),
}

/// Gradation φ(Z) = 1 + a exp(b / cos Z) and indicatrix
/// f(χ) = 1 + c (exp(d χ) − exp(d π/2)) + e cos² χ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StandardSky {
    /// 1 to 15.
    pub number: usize,
    gradation: [f64; 2],
    indicatrix: [f64; 3],
}

/// (a, b), (c, d, e) by type. Source: CIE S 011/E:2003, table 1.
const TYPES: [([f64; 2], [f64; 3]); 15] = [
    ([4.0, -0.70], [0.0, -1.0, 0.0]),
    ([4.0, -0.70], [2.0, -1.5, 0.15]),
    ([1.1, -0.80], [0.0, -1.0, 0.0]),
    ([1.1, -0.80], [2.0, -1.5, 0.15]),
    ([0.0, -1.00], [0.0, -1.0, 0.0]),
    ([0.0, -1.00], [2.0, -1.5, 0.15]),
    ([0.0, -1.00], [5.0, -2.5, 0.30]),
    ([0.0, -1.00], [10.0, -3.0, 0.45]),
    ([-1.0, -0.55], [2.0, -1.5, 0.15]),
    ([-1.0, -0.55], [5.0, -2.5, 0.30]),
    ([-1.0, -0.55], [10.0, -3.0, 0.45]),
    ([-1.0, -0.32], [10.0, -3.0, 0.45]),
    ([-1.0, -0.32], [16.0, -3.0, 0.30]),
    ([-1.0, -0.15], [16.0, -3.0, 0.30]),
    ([-1.0, -0.15], [24.0, -2.8, 0.15]),
];

impl SkyKind {
    /// A type of CIE S 011 by its number, 1 to 15.
    pub fn standard(number: usize) -> Option<SkyKind> {
        let (gradation, indicatrix) = *TYPES.get(number.checked_sub(1)?)?;
        Some(SkyKind::Standard(StandardSky { number, gradation, indicatrix }))
    }

    /// Whether clouds hide the sun: types 1 to 6 have no direct sunlight.
    pub fn hides_sun(self) -> bool {
        match self {
            SkyKind::Overcast => true,
            SkyKind::Standard(sky) => sky.number <= 6,
        }
    }

    /// Whether luminance depends on where the sun stands.
    pub fn needs_sun(self) -> bool {
        match self {
            SkyKind::Overcast => false,
            SkyKind::Standard(sky) => sky.indicatrix[0] != 0.0 || sky.indicatrix[2] != 0.0,
        }
    }
}

impl StandardSky {
    fn gradation(&self, cos_zenith: f64) -> f64 {
        let [a, b] = self.gradation;
        // At the horizon exp(b/0) is 0, since b < 0.
        1.0 + a * (b / cos_zenith.max(1e-300)).exp()
    }

    fn indicatrix(&self, angle: f64) -> f64 {
        let [c, d, e] = self.indicatrix;
        let right_angle = std::f64::consts::FRAC_PI_2;
        1.0 + c * ((d * angle).exp() - (d * right_angle).exp()) + e * angle.cos().powi(2)
    }
}

/// A sky above, and below the horizon an even ground.
#[derive(Debug, Clone, PartialEq)]
pub struct Sky {
    /// Which distribution of luminance.
    pub kind: SkyKind,
    /// Unit, toward the sun.
    pub sun: DVec3,
    /// cd/m².
    pub zenith: f64,
    /// cd/m² of the ground, in the second spectrum.
    pub ground: f64,
}

impl Sky {
    /// A sky of zenith luminance 1 over a black ground.
    ///
    /// Errors: a sun below the horizon of a sky that depends on it.
    pub fn new(kind: SkyKind, sun: DVec3) -> Result<Sky> {
        if kind.needs_sun() && sun.y < 0.0 {
            let elevation_deg = sun.y.clamp(-1.0, 1.0).asin().to_degrees();
            let what = "sun's \"elevation\"";
            return Err(Error::out_of_range("environment.sky", what, elevation_deg, "0 to 90°"));
        }
        Ok(Sky { kind, sun, zenith: 1.0, ground: 0.0 })
    }

    pub(super) fn luminances(&self, direction: DVec3) -> Luminances {
        if direction.y <= 0.0 {
            return [0.0, self.ground, 0.0];
        }
        [self.zenith * self.relative(direction), 0.0, 0.0]
    }

    /// Luminance over the zenith's, for directions above the horizon.
    fn relative(&self, direction: DVec3) -> f64 {
        match self.kind {
            SkyKind::Overcast => (1.0 + 2.0 * direction.y) / 3.0,
            SkyKind::Standard(sky) => {
                let from_sun = angle_between(direction, self.sun);
                let sun_from_zenith = angle_between(self.sun, DVec3::Y);
                let here = sky.gradation(direction.y) * sky.indicatrix(from_sun);
                here / (sky.gradation(1.0) * sky.indicatrix(sun_from_zenith))
            }
        }
    }
}

/// Keeps its digits where the angle is small, unlike the arc cosine.
fn angle_between(a: DVec3, b: DVec3) -> f64 {
    2.0 * (a - b).length().atan2((a + b).length())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment::toward;

    /// CIE S 011's clear sky is the CIE clear sky of 1973 (Kittler), whose formula reads
    /// (0.91 + 10 e^−3χ + 0.45 cos² χ)(1 − e^(−0.32/cos Z)) over the same at the zenith.
    #[test]
    fn type_12_is_the_clear_sky() {
        let sun = toward(30.0, 40.0);
        let sky = Sky::new(SkyKind::standard(12).unwrap(), sun).unwrap();
        let f = |chi: f64| 0.91 + 10.0 * (-3.0 * chi).exp() + 0.45 * chi.cos().powi(2);
        let phi = |cos_z: f64| 1.0 - (-0.32 / cos_z).exp();
        for (azimuth, elevation) in [(30.0, 40.0), (100.0, 5.0), (-150.0, 70.0), (30.0, 39.0)] {
            let here = toward(azimuth, elevation);
            let chi = here.dot(sun).acos();
            let expected = f(chi) * phi(here.y) / (f(50f64.to_radians()) * phi(1.0));
            let ratio = sky.luminances(here)[0] / expected;
            assert!((ratio - 1.0).abs() < 1e-3, "{azimuth} {elevation}: {ratio}");
        }
    }

    #[test]
    fn zenith_is_one_for_every_kind() {
        let sun = toward(0.0, 33.0);
        let kinds = (1..=15).filter_map(SkyKind::standard).chain([SkyKind::Overcast]);
        for kind in kinds {
            let sky = Sky::new(kind, sun).unwrap();
            assert!((sky.luminances(DVec3::Y)[0] - 1.0).abs() < 1e-12, "{kind:?}");
            assert_eq!(sky.luminances(DVec3::NEG_Y)[0], 0.0);
        }
        assert_eq!(SkyKind::standard(0), None);
        assert_eq!(SkyKind::standard(16), None);
    }

    #[test]
    fn horizon_is_a_third_of_an_overcast_zenith() {
        let sky = Sky::new(SkyKind::Overcast, DVec3::Y).unwrap();
        assert!((sky.luminances(toward(0.0, 1e-9))[0] - 1.0 / 3.0).abs() < 1e-10);
        let type_5 = Sky::new(SkyKind::standard(5).unwrap(), DVec3::Y).unwrap();
        assert_eq!(type_5.luminances(toward(70.0, 10.0))[0], 1.0, "type 5 is even");
    }

    #[test]
    fn night_is_refused() {
        let problem = Sky::new(SkyKind::standard(12).unwrap(), toward(0.0, -10.0));
        assert_eq!(
            problem.unwrap_err().to_string(),
            "environment.sky: sun's \"elevation\" is -10, allowed: 0 to 90°"
        );
    }
}
