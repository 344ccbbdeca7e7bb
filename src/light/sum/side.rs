//! One side of a hit: eq. 2's reflected and transmitted sums have the same form.

use glam::DVec3;

use super::HitQuery;

/// The half space that a sum runs over, and the axis of its specular lobes.
///
/// Reflection: N and M = 2(N·V)N − V. Transmission: −N and −V. Then eq. 2's
/// g_d = (L·normal)^n_d and g_s = max(0, L·axis)^n_s, over samples with L·normal > 0.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Side {
    pub normal: DVec3,
    pub axis: DVec3,
}

impl Side {
    pub fn reflected(query: &HitQuery) -> Side {
        let (n, v) = (query.normal, query.view);
        // R·V with R = 2(N·L)N − L equals L·M.
        Side { normal: n, axis: (2.0 * n.dot(v) * n - v).normalize_or_zero() }
    }

    pub fn transmitted(query: &HitQuery) -> Side {
        Side { normal: -query.normal, axis: -query.view }
    }
}
