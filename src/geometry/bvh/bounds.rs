//! Boxes of the scene in f64 and of the tree in f32.

use super::super::DVec3;

/// Widens every box of the tree, which lives in a frame where the scene's radius is at most 1.
///
/// A slab test in f32 misplaces the planes by, in units of 2⁻²⁴: rounding the origin 1.5, the plane
/// 1, the direction and its inverse 2 · 2.5, their products and difference 5. The pad is 16.
pub(super) const PAD: f32 = 1.0 / (1 << 20) as f32;

/// Farther than any hit in that frame: origins are at most 1.5 from the center.
pub(super) const FARTHEST: f64 = 8.0;

/// An axis-aligned box of the tree's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Box3 {
    pub low: [f32; 3],
    pub high: [f32; 3],
}

impl Box3 {
    pub const EMPTY: Box3 = Box3 { low: [f32::INFINITY; 3], high: [f32::NEG_INFINITY; 3] };

    #[inline(always)]
    pub fn grow(&mut self, other: &Box3) {
        for axis in 0..3 {
            self.low[axis] =
                if other.low[axis] < self.low[axis] { other.low[axis] } else { self.low[axis] };
            self.high[axis] =
                if other.high[axis] > self.high[axis] { other.high[axis] } else { self.high[axis] };
        }
    }

    #[inline(always)]
    pub fn half_area(&self) -> f32 {
        let [x, y, z] = [0, 1, 2].map(|axis| self.high[axis] - self.low[axis]);
        if x < 0.0 { 0.0 } else { x * y + y * z + z * x }
    }
}

/// The frame of the tree: the scene's center is its origin and the scene's radius at most 1, so
/// that f32 has the same relative precision from 1 µm to 1 km and far from the origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Frame {
    pub center: DVec3,
    /// Radius of a sphere around all triangles, mm.
    pub radius_mm: f64,
    /// Frame units a mm, a power of two.
    pub per_mm: f64,
    /// A ray's origin may be this far before the center, mm.
    pub reach_mm: f64,
    /// Square of 1.5 radii: no way through the sphere from `reach_mm` before its center begins
    /// farther from it than √2 radii.
    pub limit_mm2: f64,
}

impl Frame {
    pub fn new(low: DVec3, high: DVec3) -> Frame {
        let center = 0.5 * low + 0.5 * high;
        // 2⁻²⁰ more than half the diagonal covers every rounding in f64 of what is inside.
        let half = (high - center).max(center - low);
        let radius_mm = half.length() * (1.0 + f64::from(PAD));
        let per_mm = if radius_mm > 0.0 { (-radius_mm.log2().ceil()).exp2() } else { 1.0 };
        let reach_mm = radius_mm * (1.0 + 1e-6) + 8.0 * f64::EPSILON * center.abs().max_element();
        Frame { center, radius_mm, per_mm, reach_mm, limit_mm2: (1.5 * radius_mm).powi(2) }
    }

    #[inline(always)]
    pub fn to_frame(self, point: DVec3) -> [f32; 3] {
        ((point - self.center) * self.per_mm).to_array().map(|x| x as f32)
    }

    /// A distance as the walk compares it: at least the true one, and finite. Rounding to f32 takes
    /// 2⁻²⁴ of it.
    #[inline(always)]
    pub fn to_end(self, t_mm: f64) -> f32 {
        (t_mm * (self.per_mm * (1.0 + 1.0 / (1 << 22) as f64))).min(FARTHEST) as f32
    }

    /// The box of three corners, widened by the pad.
    pub fn box_of(self, corners: [DVec3; 3]) -> Box3 {
        let [a, b, c] = corners.map(|corner| self.to_frame(corner));
        Box3 {
            low: std::array::from_fn(|i| a[i].min(b[i]).min(c[i]) - PAD),
            high: std::array::from_fn(|i| a[i].max(b[i]).max(c[i]) + PAD),
        }
    }
}
