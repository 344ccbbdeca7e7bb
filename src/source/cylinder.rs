//! The comparison source of Fig. 8.

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use super::emitter::{Emitter, Radiance, Shape};
use super::filament::{check_emitter, placement};
use super::sequence::random;
use crate::error::{Error, Result};
use crate::light::{RaySample, RaySet};

/// A cylinder that emits evenly from its side, every place a Lambert emitter about its outward
/// normal; the two ends are dark.
///
/// Integrated by Monte Carlo: the samples are independent random points, whose noise Fig. 8 shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cylinder {
    /// Center of the body, mm.
    pub center: DVec3,
    /// Any length but 0.
    pub axis: DVec3,
    /// 1e-9 to 1e9.
    pub radius_mm: f64,
    /// 1e-9 to 1e9.
    pub length_mm: f64,
    /// lm.
    pub flux_lm: f64,
    /// How many points are drawn, 1 to 1e8.
    pub samples: usize,
    /// The same seed gives the same samples.
    pub seed: u64,
}

impl Cylinder {
    /// The same for any number of threads; samples lie in the cylinder's own coordinates.
    ///
    /// Errors: [`Error::OutOfRange`].
    pub fn rayset(&self) -> Result<RaySet> {
        for (what, mm) in [("radius", self.radius_mm), ("length", self.length_mm)] {
            if !(1e-9..=1e9).contains(&mm) {
                return Err(Error::out_of_range("cylinder", what, mm, "1e-9 to 1e9 mm"));
            }
        }
        check_emitter("cylinder", self.flux_lm, self.samples)?;
        let world_from_local = placement("cylinder", self.center, self.axis)?;
        let samples: Vec<RaySample> =
            (0..self.samples).into_par_iter().map(|index| self.sample(index as u64)).collect();
        Ok(RaySet { world_from_local, ..RaySet::new(samples.into(), self.flux_lm) })
    }

    /// The side as rays see it, in the cylinder's own coordinates.
    ///
    /// Errors: a size that f32 cannot hold.
    pub fn surface(&self) -> Result<Emitter> {
        let shape = Shape::Cylinder {
            center: DVec3::ZERO,
            axis: DVec3::Z,
            radius_mm: self.radius_mm,
            length_mm: self.length_mm,
        };
        let radiance = Radiance::Lambert { area_mm2: shape.area_mm2() };
        Ok(Emitter { mesh: Arc::new(shape.mesh()?), radiance })
    }

    fn sample(&self, index: u64) -> RaySample {
        let (sin, cos) = (TAU * random(self.seed, index, 0)).sin_cos();
        let z = self.length_mm * (random(self.seed, index, 1) - 0.5);
        let position = DVec3::new(self.radius_mm * cos, self.radius_mm * sin, z);
        let direction = DVec3::new(cos, sin, 0.0);
        RaySample {
            position: position.as_vec3().to_array(),
            direction: direction.as_vec3().to_array(),
            flux: 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn cylinder(samples: usize) -> Cylinder {
        Cylinder {
            center: DVec3::new(1.0, 2.0, 3.0),
            axis: DVec3::new(0.0, 1.0, 1.0),
            radius_mm: 0.65,
            length_mm: 4.1,
            flux_lm: 1.0,
            samples,
            seed: 4,
        }
    }

    /// Eq. 9 gives I(θ) = Φ/π² sin θ, of which the share 0.608997781 has |cos θ| < 0.5. The sum
    /// over n independent samples scatters by 0.22/√n (var |cos φ| = 1/2 − 4/π²).
    #[test]
    fn far_field_is_that_of_a_lambert_cylinder() {
        let set = cylinder(100_000).rayset().unwrap();
        let axis = cylinder(1).axis.normalize();
        let across = axis.any_orthonormal_vector();
        for mu in [0.0f64, 0.3, 0.5, 0.9] {
            let toward = axis * mu + across * (1.0 - mu * mu).sqrt();
            let sum: f64 =
                set.samples.iter().map(|s| set.world_direction(s).dot(toward).max(0.0)).sum();
            let intensity = sum / (PI * set.samples.len() as f64);
            let expected = (1.0 - mu * mu).sqrt() / (PI * PI);
            assert!((intensity / expected - 1.0).abs() < 0.02, "{mu}: {intensity} {expected}");
        }
    }

    #[test]
    fn samples_lie_on_the_side_and_fill_it() {
        let set = cylinder(10_000).rayset().unwrap();
        let z: Vec<f32> = set.samples.iter().map(|s| s.position[2]).collect();
        let (low, high) = z.iter().fold((0f32, 0f32), |(l, h), &z| (l.min(z), h.max(z)));
        assert!((-2.05..-2.04).contains(&low) && (2.04..2.0501).contains(&high));
        for s in set.samples.iter() {
            assert!((s.position[0].hypot(s.position[1]) - 0.65).abs() < 1e-6);
            assert_eq!(s.direction[2], 0.0);
        }
    }

    #[test]
    fn sizes_outside_of_the_range_are_refused() {
        let error = Cylinder { radius_mm: 0.0, ..cylinder(1) }.rayset().unwrap_err();
        assert_eq!(error.to_string(), "cylinder: radius is 0, allowed: 1e-9 to 1e9 mm");
    }
}
