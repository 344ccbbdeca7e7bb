//! The f64 decision whether and where a ray meets a triangle.
//!
//! The test is that of Woop, Benthin and Wald ("Watertight Ray/Triangle Intersection", JCGT 2013),
//! carried out in f64: corners are taken relative to the origin and sheared so that the ray becomes
//! the third axis; three 2D edge functions then say whether the axis passes inside. Its weights are
//! the u, v of Möller–Trumbore, with the error of a short 2D product instead of a long 3D one.
//!
//! Why no ray slips through: a sheared corner depends on nothing but corner and ray, so that
//! triangles which share a corner see the same 2D point, and [`edge`] has the sign of the exact 2D
//! area of these points or is zero, never the opposite sign. Zero counts as inside. Hence a point
//! which the exact projection covers is covered by a triangle that accepts it, on edges and at
//! corners too.

use super::super::{DVec3, Ray};

/// Below this share of its products an edge function is evaluated again without rounding them:
/// it keeps the weights of slivers and of triangles seen edge-on good to 2⁻⁴¹.
const CANCELLATION: f64 = 1.0 / 4096.0;

/// A ray made ready for many exact tests.
#[derive(Debug, Clone, Copy)]
pub(super) struct Probe {
    pub origin: [f64; 3],
    pub direction: [f64; 3],
    /// How far `origin` was moved along the ray of the caller, mm.
    pub advance_mm: f64,
    /// Axis order: the last is that in which the direction is longest.
    pub axes: [usize; 3],
    /// What the first two axes move per unit of the third, and the ray's length per unit of it.
    pub shear: [f64; 3],
}

/// Where a probe crosses a triangle: distance from the probe's origin, weights of corners 1 and 2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Crossing {
    pub t_mm: f64,
    pub u: f64,
    pub v: f64,
}

impl Probe {
    /// `advance_mm` moves the origin toward the scene, which keeps the digits of far cameras.
    #[inline(always)]
    pub fn new(ray: &Ray, advance_mm: f64) -> Probe {
        let d = ray.direction.to_array();
        let [x, y, z] = [d[0].abs(), d[1].abs(), d[2].abs()];
        let axes = if x > y && x > z {
            [1, 2, 0]
        } else if y > z {
            [2, 0, 1]
        } else {
            [0, 1, 2]
        };
        let per_depth = 1.0 / d[axes[2]];
        let shear = [d[axes[0]] * per_depth, d[axes[1]] * per_depth, per_depth];
        let origin =
            if advance_mm > 0.0 { ray.origin + ray.direction * advance_mm } else { ray.origin };
        Probe { origin: origin.to_array(), direction: d, advance_mm, axes, shear }
    }

    /// Both sides of a triangle count; one seen exactly edge-on is never met.
    #[cfg(test)]
    pub fn cross(&self, corners: [DVec3; 3]) -> Option<Crossing> {
        cross(corners.map(|corner| self.to_sheared(corner.to_array())))
    }

    /// 2D position about the ray, and distance along it: what each kernel computes for a packet.
    #[cfg(test)]
    fn to_sheared(self, corner: [f64; 3]) -> [f64; 3] {
        let depth = corner[self.axes[2]] - self.origin[self.axes[2]];
        [
            corner[self.axes[0]] - self.origin[self.axes[0]] - self.shear[0] * depth,
            corner[self.axes[1]] - self.origin[self.axes[1]] - self.shear[1] * depth,
            self.shear[2] * depth,
        ]
    }
}

/// Where the third axis crosses a triangle of sheared corners.
#[inline(always)]
pub(super) fn cross([a, b, c]: [[f64; 3]; 3]) -> Option<Crossing> {
    let (wa, wb, wc) = (edge(c, b), edge(a, c), edge(b, a));
    if (wa < 0.0) | (wb < 0.0) | (wc < 0.0) && (wa > 0.0) | (wb > 0.0) | (wc > 0.0) {
        return None;
    }
    let area = wa + wb + wc;
    if area == 0.0 {
        return None;
    }
    let per_area = 1.0 / area;
    let t_mm = (wa * a[2] + wb * b[2] + wc * c[2]) * per_area;
    // False for NaN too.
    (t_mm > 0.0).then_some(Crossing { t_mm, u: wb * per_area, v: wc * per_area })
}

/// Twice the signed area of (0, p, q); exactly `-edge(q, p)`.
///
/// Rounding is monotonic, so that the difference of two rounded products never has the wrong sign.
#[inline(always)]
fn edge(p: [f64; 3], q: [f64; 3]) -> f64 {
    let (left, right) = (p[0] * q[1], p[1] * q[0]);
    let area = left - right;
    if area.abs() <= CANCELLATION * (left.abs() + right.abs()) {
        return edge_without_rounding(p, q);
    }
    area
}

/// Adds what rounding took from both products. `mul_add` gives the same bits on every machine,
/// with or without an instruction for it.
#[cold]
#[inline(never)]
fn edge_without_rounding(p: [f64; 3], q: [f64; 3]) -> f64 {
    let (left, right) = (p[0] * q[1], p[1] * q[0]);
    let left_lost = p[0].mul_add(q[1], -left);
    let right_lost = p[1].mul_add(q[0], -right);
    (left - right) + (left_lost - right_lost)
}

/// Whether a triangle has no normal: corners on one line up to the rounding of their differences,
/// or not finite. Such triangles are never met.
pub(super) fn is_degenerate([a, b, c]: [DVec3; 3]) -> bool {
    let (ab, ac) = (b - a, c - a);
    // The cross product's rounding error is at most about 2ε |ab| |ac|, ε = 2⁻⁵³; twice that.
    let noise = 2.0 * f64::EPSILON * ab.length() * ac.length();
    let twice_area = ab.cross(ac).length();
    !(twice_area > noise && twice_area.is_finite())
}
