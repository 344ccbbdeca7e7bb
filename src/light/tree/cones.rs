//! The sum over samples that shine in narrow lobes: far from most of them nothing arrives, and what
//! does is summed sample by sample.
//!
//! A binary tree over the blocks keeps, for each node, a sphere around its samples and a cone
//! around their directions. From both follows the most that the node can send to a hit. Blocks are
//! summed from the brightest bound on, until all bounds that are left together are within the error.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use glam::DVec3;

use super::SideSum;
use super::blocks::{Blocks, Summing};
use crate::light::sum::block::{BlockQuery, Scratch};
use crate::light::{RaySample, Visibility};

/// Rounding of angles from f64 cosines near 1.
const ANGLE_ROUNDING_RAD: f64 = 1e-7;

/// Sums under this fraction of what the set could send straight at the hit (from its radius, if the
/// hit is nearer) count as dark: their error is absolute.
const DARK: f64 = 1e-15;

/// A node's samples lie in a sphere and point into a cone.
#[derive(Debug, Clone, Copy)]
struct Cone {
    center: DVec3,
    radius: f64,
    axis: DVec3,
    half_angle_rad: f64,
    flux: f64,
}

/// A complete binary tree: node i has the children 2 i and 2 i + 1, the last half are the blocks.
#[derive(Debug, Clone)]
pub(super) struct Cones {
    nodes: Vec<Cone>,
}

impl Cones {
    pub fn build(blocks: &Blocks) -> Cones {
        let leaves = blocks.blocks.len();
        debug_assert!(leaves.is_power_of_two());
        let empty = Cone {
            center: DVec3::ZERO,
            radius: 0.0,
            axis: DVec3::Z,
            half_angle_rad: 0.0,
            flux: 0.0,
        };
        let mut nodes = vec![empty; 2 * leaves];
        for (index, block) in blocks.blocks.iter().enumerate() {
            let samples = || blocks.samples_of(block);
            nodes[leaves + index] = Cone::around(block.center, block.radius, samples);
        }
        for node in (1..leaves).rev() {
            nodes[node] = Cone::merged(&nodes[2 * node], &nodes[2 * node + 1]);
        }
        Cones { nodes }
    }

    pub fn memory_bytes(&self) -> usize {
        size_of_val(&*self.nodes)
    }

    /// Within `light_error` of the exact sum, which it is at most.
    pub fn sum(
        &self,
        blocks: &Blocks,
        query: &BlockQuery,
        (visible, light_error): (Option<Visibility>, f64),
    ) -> SideSum {
        let leaves = self.nodes.len() / 2;
        let mut total = SideSum { nodes: 1, ..SideSum::default() };
        let mut scratch = Scratch::new();
        let mut open = BinaryHeap::from([Open { bound: self.nodes[1].bound(query), node: 1 }]);
        let dark = self.dark_sum(query);
        let mut left = f64::INFINITY;
        for round in 0.. {
            // Anew now and then: differences of large bounds would leave their rounding.
            if round % 16 == 0 || left <= light_error * total.sum.max(dark) {
                left = open.iter().map(|open| open.bound).sum();
            }
            if left <= light_error * total.sum.max(dark) {
                break;
            }
            let Some(Open { bound, node }) = open.pop() else {
                left = 0.0;
                break;
            };
            left -= bound;
            if node < leaves {
                for node in [2 * node, 2 * node + 1] {
                    let bound = self.nodes[node].bound(query);
                    left += bound;
                    open.push(Open { bound, node });
                }
                total.nodes += 2;
            } else {
                let how = Summing { visible, few_questions: light_error > 0.0 };
                let (sum, samples) = blocks.sum(node - leaves, query, &how, &mut scratch);
                total.sum += sum;
                total.samples += samples;
            }
        }
        total.error = left.max(0.0);
        total
    }

    fn dark_sum(&self, query: &BlockQuery) -> f64 {
        let root = &self.nodes[1];
        let most = DARK * query.lobes.total_weight() * root.flux;
        let distance = query.point.distance(root.center).max(root.radius).max(1e-9);
        if query.inverse_square { most / distance.powi(2) } else { most }
    }
}

/// A node that was not looked into.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Open {
    bound: f64,
    node: usize,
}

impl Eq for Open {}

impl Ord for Open {
    fn cmp(&self, other: &Self) -> Ordering {
        self.bound.total_cmp(&other.bound).then(other.node.cmp(&self.node))
    }
}

impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Cone {
    fn around<'a, I: Iterator<Item = &'a RaySample>>(
        center: DVec3,
        radius: f64,
        samples: impl Fn() -> I,
    ) -> Cone {
        let sum: DVec3 = samples().map(RaySample::unit_direction).sum();
        let axis = sum.try_normalize().unwrap_or(DVec3::Z);
        let off_axis = samples().map(|s| angle(axis, s.unit_direction()));
        let half_angle_rad = off_axis.fold(0.0, f64::max) + ANGLE_ROUNDING_RAD;
        let flux = samples().map(|s| f64::from(s.flux)).sum();
        Cone { center, radius, axis, half_angle_rad, flux }
    }

    fn merged(a: &Cone, b: &Cone) -> Cone {
        if a.flux == 0.0 || b.flux == 0.0 {
            return if a.flux == 0.0 { *b } else { *a };
        }
        let center = 0.5 * (a.center + b.center);
        let reach = |c: &Cone| c.center.distance(center) + c.radius;
        let axis = (a.axis + b.axis).try_normalize().unwrap_or(a.axis);
        let opening = |c: &Cone| angle(axis, c.axis) + c.half_angle_rad;
        Cone {
            center,
            radius: reach(a).max(reach(b)) * (1.0 + 1e-12),
            axis,
            half_angle_rad: opening(a).max(opening(b)),
            flux: a.flux + b.flux,
        }
    }

    /// The most that the node's samples can add to the sum.
    fn bound(&self, query: &BlockQuery) -> f64 {
        let to_center = self.center - query.point;
        let distance = to_center.length();
        if to_center.dot(query.side.normal) <= -self.radius || self.flux == 0.0 {
            return 0.0;
        }
        let toward = to_center / distance.max(f64::MIN_POSITIVE);
        let seen_rad = match self.radius < distance {
            true => (self.radius / distance).asin() + ANGLE_ROUNDING_RAD,
            false => std::f64::consts::PI,
        };
        // 1 % over the blocks' f32 and the series below.
        let power_at = |least_rad: f64, n: f64| {
            let cos = least_rad.cos();
            if cos > 1e-9 { (n * cos.ln()).exp() } else { 1e-9f64.powf(n) }
        };
        let power = |a: DVec3, b: DVec3, slack_rad: f64, n: f64| {
            power_at((angle(a, b) - slack_rad).max(0.0), n)
        };
        let opening = seen_rad + self.half_angle_rad;
        let emitted = self.flux * power(-toward, self.axis, opening, query.exponent);
        let (weight, n_d) = query.lobes.exact_diffuse;
        let mut scattered = weight * power(query.side.normal, toward, seen_rad, n_d);
        // β of a half-vector lobe is at least half the angle from the axis.
        let halved = if query.side.is_half { 0.5 } else { 1.0 };
        let off_axis = (angle(query.side.axis, toward) - seen_rad).max(0.0);
        for (weight, exponent) in &query.lobes.exact_specular {
            scattered += weight * power_at(halved * off_axis, *exponent);
        }
        let nearest = (distance - self.radius).max(1e-9);
        let falloff = if query.inverse_square { nearest.powi(-2) } else { 1.0 };
        1.01 * emitted * scattered * falloff
    }
}

/// Between unit vectors, with its digits near 0 and π.
fn angle(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}
