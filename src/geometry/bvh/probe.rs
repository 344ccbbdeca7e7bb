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

use super::super::DVec3;
use super::wide::{CORNERS, Packet};

/// Below this share of its products an edge function is evaluated again without rounding them:
/// it keeps the weights of slivers and of triangles seen edge-on good to 2⁻⁴¹.
pub(super) const CANCELLATION: f64 = 1.0 / 4096.0;

/// A ray made ready for many exact tests.
#[derive(Debug, Clone, Copy)]
pub(super) struct Probe {
    pub origin: [f64; 3],
    /// How far `origin` was moved along the ray of the caller, mm.
    pub advance_mm: f64,
    /// Axis order: the last is that in which the direction is longest.
    pub axes: [usize; 3],
    /// What the first two axes move per unit of the third, and the ray's length per unit of it.
    pub shear: [f64; 3],
}

/// Axis orders by which of |x| > |y|, |y| > |z| and |x| > |z| (bits from 0) hold.
const AXES: [[usize; 3]; 8] = {
    let (x, y, z) = ([1, 2, 0], [2, 0, 1], [0, 1, 2]);
    [z, z, y, y, z, x, y, x]
};

/// Where a probe crosses a triangle: distance from the probe's origin, weights of corners 1 and 2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Crossing {
    pub t_mm: f64,
    pub u: f64,
    pub v: f64,
}

impl Probe {
    /// `origin` lies on the ray, `advance_mm` from its own origin.
    #[inline(always)]
    pub fn new(origin: DVec3, direction: &DVec3, advance_mm: f64) -> Probe {
        let d: &[f64; 3] = direction.as_ref();
        let [x, y, z] = [d[0].abs(), d[1].abs(), d[2].abs()];
        let order = usize::from(x > y) | usize::from(y > z) << 1 | usize::from(x > z) << 2;
        let axes = AXES[order];
        let per_depth = 1.0 / d[axes[2]];
        let shear = [d[axes[0]] * per_depth, d[axes[1]] * per_depth, per_depth];
        Probe { origin: origin.to_array(), advance_mm, axes, shear }
    }

    /// Both sides of a triangle count; one seen exactly edge-on is never met.
    #[cfg(test)]
    pub fn cross(&self, corners: [DVec3; 3]) -> Option<Crossing> {
        let [kx, ky, kz] = self.axes;
        cross(corners.map(|corner| self.sheared(corner[kx], corner[ky], corner[kz])))
    }

    /// The same for a triangle of a packet.
    #[inline(always)]
    pub fn cross_lane(&self, packet: &Packet, lane: usize) -> Option<Crossing> {
        let [kx, ky, kz] = self.axes;
        let (xs, ys, zs) = (&packet.positions[kx], &packet.positions[ky], &packet.positions[kz]);
        let [a, b, c] = &packet.corners;
        let (a, b, c) = (
            usize::from(a[lane]) % CORNERS,
            usize::from(b[lane]) % CORNERS,
            usize::from(c[lane]) % CORNERS,
        );
        cross([
            self.sheared(xs[a], ys[a], zs[a]),
            self.sheared(xs[b], ys[b], zs[b]),
            self.sheared(xs[c], ys[c], zs[c]),
        ])
    }

    /// 2D position about the ray, and distance along it.
    #[inline(always)]
    fn sheared(&self, x: f64, y: f64, z: f64) -> [f64; 3] {
        let [kx, ky, kz] = self.axes;
        let depth = z - self.origin[kz];
        [
            x - self.origin[kx] - self.shear[0] * depth,
            y - self.origin[ky] - self.shear[1] * depth,
            self.shear[2] * depth,
        ]
    }
}

/// Where the third axis crosses a triangle of sheared corners.
#[inline(always)]
fn cross([a, b, c]: [[f64; 3]; 3]) -> Option<Crossing> {
    let (wa, wb, wc) = (edge(c, b), edge(a, c), edge(b, a));
    if (wa < 0.0) | (wb < 0.0) | (wc < 0.0) && (wa > 0.0) | (wb > 0.0) | (wc > 0.0) {
        return None;
    }
    crossing([wa, wb, wc], wa * a[2] + wb * b[2] + wc * c[2])
}

/// From the edge functions, none of them negative or none of them positive, and the sum of the
/// corners' distances weighed by them.
#[inline(always)]
pub(super) fn crossing([wa, wb, wc]: [f64; 3], distances: f64) -> Option<Crossing> {
    let area = wa + wb + wc;
    if area == 0.0 {
        return None;
    }
    let per_area = 1.0 / area;
    let t_mm = distances * per_area;
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
