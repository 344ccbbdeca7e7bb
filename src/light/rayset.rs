//! Samples of a light source (eq. 10–12).

use std::sync::Arc;

use glam::DAffine3;

/// One ray of a RAYSET: a Lambert emitter about `direction` at `position`.
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

/// The geometry and flux of a light source; its spectrum is the scene's business.
///
/// Cheap to clone and to move: samples are shared, placement and scale lie beside them.
#[derive(Debug, Clone)]
pub struct RaySet {
    pub samples: Arc<[RaySample]>,
    /// Rotation, uniform scale and translation.
    pub world_from_local: DAffine3,
    /// Σ Φ_i, lm: `samples[i].flux` is scaled so that they sum to it.
    pub flux_lm: f64,
}

impl RaySet {
    /// A set where it was made, in its own coordinates.
    pub fn new(samples: Arc<[RaySample]>, flux_lm: f64) -> Self {
        Self { samples, world_from_local: DAffine3::IDENTITY, flux_lm }
    }
}
