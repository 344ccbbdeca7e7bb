//! The sun: a disc of half a degree, and the light that comes through the air.

use std::f64::consts::PI;

use glam::DVec3;

use crate::spectrum::Spectrum;

/// Radius of the sun's disc as seen from the earth, mean over the year (32′ across), rad.
pub const SUN_RADIUS_RAD: f64 = 4.6542e-3;

/// An even disc in the sky.
#[derive(Debug, Clone, PartialEq)]
pub struct Sun {
    /// Unit, toward its center.
    pub direction: DVec3,
    /// lx on a plane that faces it.
    pub illuminance_lx: f64,
    /// Relative.
    pub spectrum: Spectrum,
}

impl Sun {
    /// cd/m² of the disc: ∫ L cos dω over it is the illuminance.
    pub fn luminance(&self) -> f64 {
        self.illuminance_lx / (PI * SUN_RADIUS_RAD.sin().powi(2))
    }

    /// Whether a ray in `direction` meets the disc.
    pub(super) fn is_met_by(&self, direction: DVec3) -> bool {
        let chord = 2.0 * (0.5 * SUN_RADIUS_RAD).sin();
        (direction - self.direction).length_squared() <= chord * chord
    }

    /// lx on a level plane above the horizon.
    pub fn level_illuminance_lx(&self) -> f64 {
        self.illuminance_lx * self.direction.y.max(0.0)
    }

    /// `count` directions that share the disc evenly: a spiral of golden angles.
    pub(super) fn spread(&self, count: usize) -> impl Iterator<Item = DVec3> {
        const GOLDEN_RAD: f64 = 2.399_963_229_728_653;
        // Equal shares of sin² are equal shares of ∫ cos dω.
        let radius = move |i: usize| ((i as f64 + 0.5) / count as f64).sqrt();
        (0..count).map(move |i| self.point(radius(i), GOLDEN_RAD * i as f64))
    }

    /// `count` directions just inside of the disc's rim.
    pub(super) fn rim(&self, count: usize) -> impl Iterator<Item = DVec3> {
        (0..count).map(move |i| self.point(0.999, 2.0 * PI * i as f64 / count as f64))
    }

    /// `radius` in those of the disc.
    fn point(&self, radius: f64, angle_rad: f64) -> DVec3 {
        let (right, up) = self.direction.any_orthonormal_pair();
        let sine = radius * SUN_RADIUS_RAD.sin();
        let (sin, cos) = angle_rad.sin_cos();
        (right * cos + up * sin) * sine + self.direction * (1.0 - sine * sine).sqrt()
    }
}

/// Relative optical air mass at an elevation of 0 to 90°. Source: Kasten & Young 1989.
pub fn air_mass(elevation_deg: f64) -> f64 {
    let sine = elevation_deg.to_radians().sin();
    1.0 / (sine + 0.50572 * (elevation_deg + 6.07995).powf(-1.6364))
}

/// The sun's light behind air of luminous turbidity `turbidity`: (lx facing it, spectrum).
///
/// 133,334 lx outside of the atmosphere (Darula, Kittler & Gueymard 2005), times exp(−a m T) with
/// the clean air's luminous extinction a = 0.1/(1 + 0.0045 m) (Navvab, Karayel, Ne'eman & Selkowitz
/// 1984). What exceeds clean air, T − 1, is haze and reddens as such.
pub fn sun_through_air(elevation_deg: f64, turbidity: f64) -> (f64, Spectrum) {
    const OUTSIDE_LX: f64 = 133_334.0;
    let mass = air_mass(elevation_deg);
    let extinction = 0.1 / (1.0 + 0.0045 * mass);
    let illuminance_lx = OUTSIDE_LX * (-extinction * mass * turbidity).exp();
    (illuminance_lx, Spectrum::sunlight(mass, extinction * (turbidity - 1.0)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment::toward;

    /// Kasten & Young's own table: 1 at 90°, 5.5841 at 10°, 38.0868 at 0.
    #[test]
    fn air_mass_is_the_published_one() {
        for (elevation, mass) in [(90.0, 1.0), (10.0, 5.5841), (0.0, 38.0868)] {
            assert!((air_mass(elevation) / mass - 1.0).abs() < 5e-3, "{}", air_mass(elevation));
        }
    }

    /// A clear day: about 100 klx facing a high sun, and a tenth of it as it sets.
    #[test]
    fn sunlight_is_as_bright_as_known() {
        let (noon, _) = sun_through_air(60.0, 2.5);
        let (evening, _) = sun_through_air(5.0, 2.5);
        assert!((90e3..110e3).contains(&noon) && (5e3..20e3).contains(&evening));
    }

    #[test]
    fn disc_is_shared_evenly() {
        let direction = toward(20.0, 30.0);
        let sun = Sun { direction, illuminance_lx: 1e5, spectrum: Spectrum::constant(1.0) };
        let points: Vec<DVec3> = sun.spread(1024).collect();
        assert!(points.iter().all(|p| sun.is_met_by(*p) && (p.length() - 1.0).abs() < 1e-12));
        let mean = points.iter().sum::<DVec3>() / 1024.0;
        assert!((mean - direction).length() < 2e-5, "{}", (mean - direction).length());
        let square = points.iter().map(|p| (*p - direction).length_squared()).sum::<f64>() / 1024.0;
        assert!((square / (0.5 * SUN_RADIUS_RAD.powi(2)) - 1.0).abs() < 1e-3);
        assert!(!sun.is_met_by(toward(20.0, 30.27)) && sun.is_met_by(toward(20.0, 30.26)));
        assert!((sun.luminance() * PI * SUN_RADIUS_RAD.powi(2) / 1e5 - 1.0).abs() < 1e-4);
    }
}
