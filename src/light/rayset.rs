//! Samples of a light source (eq. 10–12).

use std::sync::Arc;

use glam::{DAffine3, DVec3};

use crate::error::{Error, Result};

/// One ray of a RAYSET: it shines from `position` in a lobe about `direction`.
///
/// f32, as ray files store it: writing and reading back gives the same bits.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RaySample {
    /// mm, in the set's own coordinates.
    pub position: [f32; 3],
    /// Unit.
    pub direction: [f32; 3],
    /// Relative to the other samples of the set, ≥ 0; `RaySet::flux_lm` gives the unit.
    pub flux: f32,
}

impl RaySample {
    /// Where the ray starts, mm, in the set's own coordinates.
    pub fn origin(&self) -> DVec3 {
        DVec3::from_array(self.position.map(f64::from))
    }

    /// Where the ray goes: unit to f64, or zero for a direction that is none.
    pub fn unit_direction(&self) -> DVec3 {
        DVec3::from_array(self.direction.map(f64::from)).normalize_or_zero()
    }
}

/// The geometry and flux of a light source; its spectrum is the scene's business.
///
/// Cheap to clone and to move: samples are shared, placement and scale lie beside them.
#[derive(Debug, Clone)]
pub struct RaySet {
    /// The rays, in the set's own coordinates.
    pub samples: Arc<[RaySample]>,
    /// Rotation, uniform scale and translation.
    pub world_from_local: DAffine3,
    /// Σ Φ_i, lm: `samples[i].flux` is scaled so that they sum to it.
    pub flux_lm: f64,
    /// m of the samples' intensity Φ (m + 1)/(2π) cosᵐ about their directions: 1 is Lambert's, eq. 9.
    pub exponent: f64,
    /// Nearer surfaces see a wrong light, mm in the set's own coordinates; 0 unless the rays are those
    /// of a far field.
    pub good_beyond_mm: f64,
}

/// Allowed exponents of samples: up to a lobe of half a degree.
pub const EXPONENT_RANGE: [f64; 2] = [1.0, 3e4];

impl RaySet {
    /// A set where it was made, in its own coordinates.
    pub fn new(samples: Arc<[RaySample]>, flux_lm: f64) -> Self {
        Self {
            samples,
            world_from_local: DAffine3::IDENTITY,
            flux_lm,
            exponent: 1.0,
            good_beyond_mm: 0.0,
        }
    }

    /// The same rays, each shining in a lobe of exponent m.
    ///
    /// Errors: an exponent outside of [`EXPONENT_RANGE`].
    pub fn with_exponent(self, exponent: f64) -> Result<Self> {
        let [low, high] = EXPONENT_RANGE;
        if (low..=high).contains(&exponent) {
            return Ok(Self { exponent, ..self });
        }
        Err(Error::out_of_range("rayset", "directions", exponent, "1 to 30000"))
    }

    /// Factor of lengths from the set's own coordinates to the world's.
    pub fn scale(&self) -> f64 {
        self.world_from_local.matrix3.determinant().abs().cbrt()
    }

    /// Where a sample lies in the world, mm.
    pub fn world_origin(&self, sample: &RaySample) -> DVec3 {
        self.world_from_local.transform_point3(sample.origin())
    }

    /// Where a sample points in the world: unit, or zero for a direction that is none.
    pub fn world_direction(&self, sample: &RaySample) -> DVec3 {
        let direction = DVec3::from_array(sample.direction.map(f64::from));
        self.world_from_local.transform_vector3(direction).normalize_or_zero()
    }

    /// Φ_i of a sample whose `flux` is 1, lm; 0 for a set that emits nothing.
    pub fn lm_per_flux(&self) -> f64 {
        let total: f64 = self.samples.iter().map(|sample| f64::from(sample.flux)).sum();
        if total > 0.0 { self.flux_lm / total } else { 0.0 }
    }
}
