//! What a hit asks of a light source, the answer (eq. 2 and 9), and the plain f64 sum.

pub(crate) mod block;
pub(crate) mod lanes;
pub(crate) mod power;
mod reference;
mod side;

pub use reference::reference_sum;
pub(crate) use side::Side;

use glam::DVec3;

use crate::color::Photometry;
use crate::material::Lobes;

/// The side of eq. 2 that does not depend on the light sample.
#[derive(Debug, Clone, Copy)]
pub struct HitQuery<'a> {
    /// P, mm.
    pub point: DVec3,
    /// N of eq. 3, unit, on V's side.
    pub normal: DVec3,
    /// V, unit, from P to where the ray came from.
    pub view: DVec3,
    pub lobes: &'a Lobes,
    pub photometry: Photometry,
    /// Sum the samples on the viewer's side (L·N > 0), lobe about the mirror direction.
    pub reflects: bool,
    /// Sum the samples on the far side (L·N < 0), lobe about −V.
    pub transmits: bool,
}

/// The sums of eq. 9 without spectra: multiply by I_norm(λ) F(λ) / (K Σ I_norm V Δλ).
///
/// Unit: lm (relative), lm m⁻² sr⁻¹ (absolute).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct LightSum {
    pub reflected: f64,
    pub transmitted: f64,
    /// Estimates of |approximate − exact| of the two; 0 for the exact sum.
    pub reflected_error: f64,
    pub transmitted_error: f64,
    /// Evaluated for this hit.
    pub nodes: u32,
    pub samples: u32,
}

/// Whether the segment from the hit to a light position is free.
pub type Visibility<'a> = &'a dyn Fn(DVec3) -> bool;
