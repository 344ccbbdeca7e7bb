//! How far a table's interpolated emission is from the samples', measured while building.
//!
//! A table bounds the emission from both sides and uses the middle. Where the emission is smooth
//! the middle is far better than the bounds; where it has kinks (few samples, flat emitters) it
//! may lie on either. So every node keeps the largest distance found from the middle: relative to
//! half the distance of the bounds there, which finds a flat emitter's one kink, and by itself,
//! which is small where many samples' kinks are spread over all directions.

use std::f64::consts::TAU;

use glam::DVec3;

use super::eight::{Eight, Vectors};
use super::moments::{Channels, EMISSION, GRADIENT};
use super::octahedron::OctahedronGrid;
use crate::light::sum::block::{LANES, SampleGroup};

/// Directions compared.
const DIRECTIONS: usize = 128;

/// The largest of a hundred is not the largest of all, and less so where few samples make a kink.
const SAFETY: f64 = 1.5;
const SAFETY_OF_BEAMS: f64 = 2.0;

/// How far a table's middle may lie from the samples' emission: both bound it.
#[derive(Debug, Clone, Copy)]
pub(super) struct TableError {
    /// Part of half the bounds' distance, at most 1.
    pub share: f64,
    /// In the unit of the samples' flux.
    pub largest: f64,
    /// Whether all samples face about the same way, so that kinks lie side by side: the errors of
    /// such nodes may have one sign.
    pub is_beam: bool,
}

impl TableError {
    pub fn measure(
        groups: &[&[SampleGroup]],
        flux: f64,
        table: &[Channels],
        grid: OctahedronGrid,
    ) -> TableError {
        let (mut share, mut largest) = (0.0f64, 0.0f64);
        let rim = at_the_rim(groups, flux);
        let is_beam = !rim.is_empty();
        let safety = if is_beam { SAFETY_OF_BEAMS } else { SAFETY };
        let even =
            (0..DIRECTIONS).step_by(8).map(|first| std::array::from_fn(|i| direction(first + i)));
        for directions in even.chain(rim) {
            let bounds = emission_bounds(&directions, table, grid);
            for (direction, (low, high)) in directions.iter().zip(bounds) {
                let exact = emission(groups, *direction);
                let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
                // f32 rounds both sides by about 1e-7.
                let excess = ((exact - middle).abs() - 1e-6 * flux).max(0.0);
                share = share.max(excess / half.max(1e-7 * flux));
                largest = largest.max((exact - middle).abs());
            }
        }
        TableError { share: (safety * share + 0.05).min(1.0), largest: safety * largest, is_beam }
    }
}

const GOLDEN: f64 = 0.618_033_988_749_895;

/// Evenly over the sphere.
fn direction(i: usize) -> [f32; 3] {
    let z = 1.0 - (2 * i + 1) as f64 / DIRECTIONS as f64;
    let (sin, cos) = (TAU * GOLDEN * i as f64).sin_cos();
    let across = (1.0 - z * z).sqrt();
    [(across * cos) as f32, (across * sin) as f32, z as f32]
}

/// Directions from which samples that all face about the same way are seen from their side: there
/// alone a beam's table has kinks, and few of the even directions are among them. None for samples
/// that face many ways.
fn at_the_rim(groups: &[&[SampleGroup]], flux: f64) -> Vec<[[f32; 3]; 8]> {
    /// Mean direction's length, 1 for parallel samples: a Lambert emitter's is 2/3.
    const NARROW: f64 = 0.9;
    let samples = || groups.iter().flat_map(|block| block.iter()).flat_map(|group| group.fluxes());
    let axis = samples().sum::<DVec3>();
    if axis.length() <= NARROW * flux {
        return Vec::new();
    }
    let axis = axis.normalize_or(DVec3::Z);
    let farthest = samples().map(|q| q.normalize_or(axis).dot(axis)).fold(1.0, f64::min);
    let width = (1.0 - farthest * farthest).max(0.0).sqrt();
    let (across, aside) = axis.any_orthonormal_pair();
    let count = 2 * DIRECTIONS;
    let at = |i: usize| {
        let along = width * (1.0 - (2 * i + 1) as f64 / count as f64);
        let (sin, cos) = (TAU * GOLDEN * i as f64).sin_cos();
        let x = along * axis + (1.0 - along * along).sqrt() * (cos * across + sin * aside);
        x.as_vec3().to_array()
    };
    (0..count).step_by(8).map(|first| std::array::from_fn(|i| at(first + i))).collect()
}

fn emission(groups: &[&[SampleGroup]], x: [f32; 3]) -> f64 {
    let mut sum = 0.0;
    for block in groups {
        let mut lanes = [0.0f32; LANES];
        for group in *block {
            let [qx, qy, qz] = &group.flux;
            for i in 0..LANES {
                let toward = x[0] * qx[i] + x[1] * qy[i] + x[2] * qz[i];
                lanes[i] += if toward > 0.0 { toward } else { 0.0 };
            }
        }
        sum += lanes.iter().map(|lane| f64::from(*lane)).sum::<f64>();
    }
    sum
}

/// (tangents, interpolated) of one node in eight directions.
fn emission_bounds(
    directions: &[[f32; 3]; 8],
    table: &[Channels],
    grid: OctahedronGrid,
) -> [(f64, f64); 8] {
    let l1 = directions.map(|d| d[0].abs() + d[1].abs() + d[2].abs());
    let at: Vectors =
        [0, 1, 2].map(|axis| Eight(std::array::from_fn(|i| directions[i][axis] / l1[i])));
    let triangles = grid.triangles(&at);
    std::array::from_fn(|lane| {
        let interpolated = |channel: usize| -> f64 {
            let corner = |k: usize| {
                let vertex = triangles.corners[k].0[lane] as usize;
                f64::from(table[vertex].0[channel] * triangles.weights[k].0[lane])
            };
            corner(0) + corner(1) + corner(2)
        };
        let high = interpolated(EMISSION) * f64::from(l1[lane]);
        let tangent = (0..3)
            .map(|axis| interpolated(GRADIENT + axis) * f64::from(directions[lane][axis]))
            .sum::<f64>();
        (tangent.min(high), high)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn group(directions: [DVec3; LANES]) -> SampleGroup {
        let flux = std::array::from_fn(|axis| directions.map(|q| q[axis] as f32));
        SampleGroup { flux, ..SampleGroup::EMPTY }
    }

    /// Beams are looked at from where some of their samples face away and others do not.
    #[test]
    fn beams_are_seen_from_their_rim() {
        let around = |tilt: f64| {
            std::array::from_fn(|i| {
                let (sin, cos) = (TAU * i as f64 / LANES as f64).sin_cos();
                DVec3::new(tilt.sin() * cos, tilt.sin() * sin, tilt.cos())
            })
        };
        let rim = |groups: &[SampleGroup]| at_the_rim(&[groups], LANES as f64);
        let beam = group(around(0.2));
        let directions: Vec<[f32; 3]> = rim(&[beam]).into_iter().flatten().collect();
        assert_eq!(directions.len(), 2 * DIRECTIONS);
        let slopes = directions.iter().map(|x| f64::from(x[2]));
        let [low, high] = slopes.fold([1.0f64, -1.0], |[a, b], z| [a.min(z), b.max(z)]);
        // From −sin 0.2 to sin 0.2, but for half a step of 1/256.
        assert!((low + 0.1987).abs() < 2e-3 && (high - 0.1987).abs() < 2e-3, "{low} {high}");
        // cos 0.5 is 0.88.
        assert!(rim(&[group(around(0.5))]).is_empty(), "faces too many ways");
    }
}
