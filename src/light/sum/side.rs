//! One side of a hit: eq. 2's reflected and transmitted sums have the same form.

use glam::DVec3;

use super::HitQuery;
use crate::material::LobeShape;

/// The half space that a sum runs over, and the axis of its specular lobes.
///
/// Reflection: N and M = 2(N·V)N − V. Transmission: −N and −V. Then eq. 2's
/// g_d = (L·normal)^n_d and g_s = max(0, L·axis)^n_s, over samples with L·normal > 0. Half-vector
/// lobes have g_s = (H·normal)^(4 n_s) instead.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Side {
    pub normal: DVec3,
    pub axis: DVec3,
    /// Whether the specular lobes are half-vector lobes.
    pub is_half: bool,
}

impl Side {
    pub fn reflected(query: &HitQuery) -> Side {
        let (n, v) = (query.normal, query.view);
        // R·V with R = 2(N·L)N − L equals L·M.
        let is_half = query.lobes.shape == LobeShape::Half;
        Side { normal: n, axis: (2.0 * n.dot(v) * n - v).normalize_or_zero(), is_half }
    }

    pub fn transmitted(query: &HitQuery) -> Side {
        Side { normal: -query.normal, axis: -query.view, is_half: false }
    }

    /// V of the viewer's side.
    pub fn view(&self) -> DVec3 {
        2.0 * self.cos_view() * self.normal - self.axis
    }

    /// N·V of the viewer's side.
    pub fn cos_view(&self) -> f64 {
        self.normal.dot(self.axis)
    }

    /// A specular lobe of (weight, exponent) in the direction `l` of a sample on this side.
    pub fn specular(&self, l: DVec3, (weight, exponent): (f64, f64)) -> f64 {
        let off = l - self.axis;
        if !self.is_half {
            let versine = 0.5 * off.length_squared();
            return if versine < 1.0 {
                weight * (exponent * (-versine).ln_1p()).exp()
            } else {
                0.0
            };
        }
        // L + V lies across N as L − M does, which has its digits where the lobe is.
        let across = off - off.dot(self.normal) * self.normal;
        let tan2 = across.length_squared() / (l.dot(self.normal) + self.cos_view()).powi(2);
        weight * (-0.5 * exponent * tan2.ln_1p()).exp()
    }
}
