//! Radiance by place and direction from measured rays: a 4-D table in coordinates of equal étendue.
//!
//! Two coordinates lie on the surface (equal area), two say the direction: sin² of the polar angle,
//! and the azimuth. Every cell then has the same étendue, and its radiance is its flux over that.
//! The table is read quadrilinearly between the cells' middles, and samples are drawn from just that.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::shape::{Shape, SurfacePlace};
use crate::error::{Error, Result};
use crate::light::RaySample;
use crate::source::sequence::random;

/// Coordinates: u, v on the surface, sin²θ, azimuth; each 0 to 1.
type Phase = [f64; 4];

/// L(x, ω) of a set, for a flux of 1.
#[derive(Debug, Clone)]
pub struct RadianceTable {
    shape: Shape,
    /// Cells along each coordinate.
    cells: [usize; 4],
    /// Share of the flux, by cell.
    share: Vec<f64>,
    /// Its variance, from the rays that are counted in the cell.
    variance: Vec<f64>,
    /// Share of the flux whose rays do not leave the surface outward, 0 to 1.
    lost: f64,
}

/// What a table says about a place and direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TableRadiance {
    /// L for a flux of 1, mm⁻² sr⁻¹.
    pub radiance: f64,
    /// Its standard error from the number of rays.
    pub sigma: f64,
}

/// A table has at most one cell for this many rays.
const FEWEST_RAYS_PER_CELL: usize = 4;

/// Cells along a coordinate.
const MOST_CELLS: usize = 256;

impl RadianceTable {
    /// Moves the rays back along themselves onto `shape`, and counts them in cells.
    ///
    /// Errors: no flux that leaves the surface outward.
    pub fn new(rays: &[RaySample], shape: Shape) -> Result<Self> {
        let mut phases: Vec<(Phase, f64)> = Vec::with_capacity(rays.len());
        let mut lost = 0.0;
        for ray in rays {
            let (direction, flux) = (ray.unit_direction(), f64::from(ray.flux));
            let place = shape.place_of(shape.exit_of(ray.origin(), direction));
            match phase(&place, direction) {
                Some(phase) => phases.push((phase, flux)),
                None => lost += flux,
            }
        }
        let kept: f64 = phases.iter().map(|(_, flux)| flux).sum();
        if kept <= 0.0 {
            let problem = "no ray leaves the surface outward: is it turned or misplaced?";
            return Err(Error::inconsistent("rayset: emitter", problem));
        }
        phases.iter_mut().for_each(|(_, flux)| *flux /= kept);
        let cells = best_cells(&phases);
        let (share, squares) = histogram(&phases, cells);
        let mean_square =
            phases.iter().map(|(_, flux)| flux * flux).sum::<f64>() / phases.len() as f64;
        // One ray more than counted, so that an empty cell is not taken for surely dark.
        let variance = squares.iter().map(|square| square + mean_square).collect();
        Ok(Self { shape, cells, share, variance, lost: lost / (lost + kept) })
    }

    /// Cells along u, v, sin²θ and azimuth.
    pub fn cells(&self) -> [usize; 4] {
        self.cells
    }

    /// Share of the flux whose rays do not leave the surface outward, 0 to 1.
    pub fn lost(&self) -> f64 {
        self.lost
    }

    /// The surface.
    pub fn shape(&self) -> &Shape {
        &self.shape
    }

    /// Radiance from a point of the surface into a unit direction; 0 behind it.
    pub fn at(&self, point: DVec3, direction: DVec3) -> TableRadiance {
        match phase(&self.shape.place_of(point), direction) {
            Some(phase) => self.read(phase),
            None => TableRadiance { radiance: 0.0, sigma: 0.0 },
        }
    }

    /// Mean of all cells' relative errors, weighted by flux: how noisy the set is.
    pub fn noise(&self) -> f64 {
        self.variance.iter().map(|variance| variance.sqrt()).sum::<f64>()
            / self.share.iter().sum::<f64>()
    }

    /// Radiance of every cell with its error: the middle's place, its direction, the reading.
    pub fn cell_readings(&self) -> impl Iterator<Item = (DVec3, DVec3, TableRadiance)> + '_ {
        (0..self.share.len()).map(|index| {
            let phase = self.middle(index);
            let (point, direction) = self.place_and_direction(phase);
            let unit = self.per_share();
            let sigma = self.variance[index].sqrt() * unit;
            (point, direction, TableRadiance { radiance: self.share[index] * unit, sigma })
        })
    }

    /// Mean radiance over directions at side² places, v from the top down.
    pub fn by_place(&self, side: usize) -> Vec<f64> {
        self.means(side, |[u, v], [a, b]| Some([u, 1.0 - v, a, b]))
    }

    /// Mean radiance over places in side² directions: the hemisphere seen from the front, its rim at
    /// the circle that fills the square. 0 outside.
    pub fn by_direction(&self, side: usize) -> Vec<f64> {
        self.means(side, |[x, y], [a, b]| {
            let [x, y] = [2.0 * x - 1.0, 1.0 - 2.0 * y];
            let sine2 = x * x + y * y;
            (sine2 < 1.0).then(|| [a, b, sine2, (y.atan2(x) / TAU).rem_euclid(1.0)])
        })
    }

    /// Radiance by a pixel's two coordinates: the mean over the other two.
    fn means(&self, side: usize, phase: impl Fn([f64; 2], [f64; 2]) -> Option<Phase>) -> Vec<f64> {
        const MEANS: usize = 12;
        let at = |i: usize, of: usize| (i as f64 + 0.5) / of as f64;
        let pixel = |index: usize| {
            let here = [at(index % side, side), at(index / side, side)];
            let others = (0..MEANS * MEANS).map(|k| [at(k % MEANS, MEANS), at(k / MEANS, MEANS)]);
            let readings = others.filter_map(|other| phase(here, other));
            readings.map(|phase| self.read(phase).radiance).sum::<f64>() / (MEANS * MEANS) as f64
        };
        (0..side * side).map(pixel).collect()
    }

    /// Share of flux to radiance: one over a cell's étendue, π A over the number of cells.
    fn per_share(&self) -> f64 {
        self.share.len() as f64 / (PI * self.shape.area_mm2())
    }

    fn is_periodic(&self, axis: usize) -> bool {
        axis == 3 || (axis == 0 && self.shape.is_round())
    }

    fn read(&self, phase: Phase) -> TableRadiance {
        let sides: [[(usize, f64); 2]; 4] =
            std::array::from_fn(|axis| self.neighbors(axis, phase[axis]));
        let (mut share, mut variance) = (0.0, 0.0);
        for corner in 0..16usize {
            let picked: [(usize, f64); 4] =
                std::array::from_fn(|axis| sides[axis][corner >> axis & 1]);
            let weight: f64 = picked.iter().map(|(_, weight)| weight).product();
            let index = self.index(picked.map(|(cell, _)| cell));
            share += weight * self.share[index];
            variance += weight * weight * self.variance[index];
        }
        let unit = self.per_share();
        TableRadiance { radiance: share * unit, sigma: variance.sqrt() * unit }
    }

    /// The two cells whose middles a coordinate lies between, with weights.
    fn neighbors(&self, axis: usize, at: f64) -> [(usize, f64); 2] {
        let count = self.cells[axis];
        let place = at * count as f64 - 0.5;
        let below = place.floor();
        let weight = place - below;
        let cell = |index: f64| match self.is_periodic(axis) {
            true => index.rem_euclid(count as f64) as usize % count,
            false => index.clamp(0.0, (count - 1) as f64) as usize,
        };
        match (cell(below), cell(below + 1.0)) {
            // One cell counts once, so that its error is not taken for two independent ones.
            (one, other) if one == other => [(one, 1.0), (one, 0.0)],
            (one, other) => [(one, 1.0 - weight), (other, weight)],
        }
    }

    fn index(&self, cell: [usize; 4]) -> usize {
        flat_index(cell, self.cells)
    }

    fn middle(&self, mut index: usize) -> Phase {
        let mut phase = [0.0; 4];
        for axis in (0..4).rev() {
            phase[axis] = ((index % self.cells[axis]) as f64 + 0.5) / self.cells[axis] as f64;
            index /= self.cells[axis];
        }
        phase
    }

    fn place_and_direction(&self, phase: Phase) -> (DVec3, DVec3) {
        let place = self.shape.place(phase[0], phase[1]);
        let sine = phase[2].clamp(0.0, 1.0).sqrt();
        let (sin, cos) = (TAU * phase[3]).sin_cos();
        let bitangent = place.normal.cross(place.tangent);
        let direction = place.normal * (1.0 - phase[2]).max(0.0).sqrt()
            + (place.tangent * cos + bitangent * sin) * sine;
        (self.shape.point(&place), direction.normalize())
    }

    /// `count` samples of equal flux drawn from the table as it is read, and their exponent.
    ///
    /// A table without direction gives Lambert samples about the normals.
    pub fn samples(&self, count: usize, seed: u64) -> (Vec<RaySample>, f64) {
        let is_lambert = self.cells[2] == 1 && self.cells[3] == 1;
        let mut until = 0.0;
        let mut drawn = Vec::with_capacity(count);
        for (index, share) in self.share.iter().enumerate() {
            until += share;
            let last = ((until * count as f64).round() as usize).min(count);
            for number in drawn.len()..last {
                let (position, direction) =
                    self.place_and_direction(self.draw(index, seed, number));
                let direction = match is_lambert {
                    true => self.shape.place_of(position).normal,
                    false => direction,
                };
                drawn.push(super::sample(position, direction));
            }
        }
        let exponent = match is_lambert {
            true => 1.0,
            false => crate::source::directions::measured_exponent(&drawn),
        };
        (drawn, exponent)
    }

    /// A cell's share spread over its neighbors as the reading does: a triangle along each axis,
    /// which folds back at an end.
    fn draw(&self, index: usize, seed: u64, number: usize) -> Phase {
        let middle = self.middle(index);
        std::array::from_fn(|axis| {
            let chance = |k: u64| random(seed, number as u64, 2 * axis as u64 + k);
            let at = middle[axis] + (chance(0) + chance(1) - 1.0) / self.cells[axis] as f64;
            match (self.is_periodic(axis), at) {
                (true, _) => at.rem_euclid(1.0),
                (false, _) if at < 0.0 => -at,
                (false, _) if at > 1.0 => 2.0 - at,
                _ => at,
            }
        })
    }
}

fn phase(place: &SurfacePlace, direction: DVec3) -> Option<Phase> {
    let cos = direction.dot(place.normal);
    if cos <= 0.0 {
        return None;
    }
    let bitangent = place.normal.cross(place.tangent);
    let azimuth = direction.dot(bitangent).atan2(direction.dot(place.tangent)) / TAU;
    let [u, v] = place.coordinates;
    Some([u, v, (1.0 - cos * cos).max(0.0), azimuth.rem_euclid(1.0)])
}

fn flat_index(cell: [usize; 4], cells: [usize; 4]) -> usize {
    cell.iter().zip(cells).fold(0, |index, (&at, count)| index * count + at.min(count - 1))
}

/// Σ flux and Σ flux² by cell.
fn histogram(phases: &[(Phase, f64)], cells: [usize; 4]) -> (Vec<f64>, Vec<f64>) {
    let count = cells.iter().product();
    let (mut share, mut squares) = (vec![0.0; count], vec![0.0; count]);
    for (phase, flux) in phases {
        let cell = std::array::from_fn(|axis| (phase[axis] * cells[axis] as f64) as usize);
        let index = flat_index(cell, cells);
        share[index] += flux;
        squares[index] += flux * flux;
    }
    (share, squares)
}

/// As many cells as the rays allow: doubled along one coordinate after the other, while
/// cross-validation (Rudemo 1982; Bowman 1984) says that the table comes nearer to the light that
/// the rays were drawn from.
fn best_cells(phases: &[(Phase, f64)]) -> [usize; 4] {
    let most = (phases.len() / FEWEST_RAYS_PER_CELL).max(1);
    let mut cells = [1; 4];
    let mut best = leave_one_out(phases, cells);
    loop {
        let finer = (0..4).flat_map(|axis| [2, 4].map(|times| (axis, times))).filter_map(
            |(axis, times)| {
                let mut finer = cells;
                finer[axis] *= times;
                let fits = finer[axis] <= MOST_CELLS && finer.iter().product::<usize>() <= most;
                fits.then(|| (leave_one_out(phases, finer), finer))
            },
        );
        match finer.min_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((score, finer)) if score < best - 1e-12 * best.abs() => {
                (best, cells) = (score, finer)
            }
            _ => return cells,
        }
    }
}

/// The integral of (L̂ − L)² but for a constant, estimated without bias from the rays themselves.
fn leave_one_out(phases: &[(Phase, f64)], cells: [usize; 4]) -> f64 {
    let (share, squares) = histogram(phases, cells);
    let together: f64 = share.iter().map(|share| share * share).sum();
    let alone: f64 = squares.iter().sum();
    // Σ_i w_i L̂₋ᵢ(i) = Σ_c (p_c² − Σ w²) / (1 − Σ w²), in units of one cell.
    share.len() as f64 * (together - 2.0 * (together - alone) / (1.0 - alone).max(1e-12))
}
