//! What a hit asks of a light source, the answer (eq. 2 and 9), and the plain f64 sum.

pub(crate) mod block;
pub(crate) mod lanes;
pub(crate) mod power;
mod reference;
mod side;
mod visibility;

pub use reference::reference_sum;
pub(crate) use side::Side;
pub use visibility::{Sight, Visibility};

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
    /// What the surface does with light.
    pub lobes: &'a Lobes,
    /// Whether distance and normalization count.
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
    /// Over the samples on the viewer's side.
    pub reflected: f64,
    /// Over the samples on the far side.
    pub transmitted: f64,
    /// Estimate of |approximate − exact| of the reflected sum; 0 for the exact sum.
    pub reflected_error: f64,
    /// Estimate of |approximate − exact| of the transmitted sum; 0 for the exact sum.
    pub transmitted_error: f64,
    /// Nodes of the tree evaluated for this hit.
    pub nodes: u32,
    /// Samples evaluated for this hit.
    pub samples: u32,
}

impl LightSum {
    /// Both added, with their errors and costs.
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            reflected: self.reflected + other.reflected,
            transmitted: self.transmitted + other.transmitted,
            reflected_error: self.reflected_error + other.reflected_error,
            transmitted_error: self.transmitted_error + other.transmitted_error,
            nodes: self.nodes + other.nodes,
            samples: self.samples + other.samples,
        }
    }
}
