//! How narrow a lobe the samples of a measured set should have.

use super::sequence::random;
use crate::light::RaySample;
use crate::light::rayset::EXPONENT_RANGE;

/// Rays looked at, besides those that say where.
const MOST_RAYS: usize = 20_000;

/// Directions in which the set's two halves are compared.
const DIRECTIONS: usize = 256;

/// Blur counts this many times as much as noise: it is the same at every hit, while noise differs
/// from hit to hit and averages out over a mirror or a lens.
const BLUR_WEIGHT: f64 = 5.0;

/// log₂ of the largest exponent tried.
const OCTAVES: usize = 15;

/// The exponent at which blur and noise of the set's intensity balance.
///
/// Both are measured at directions of the set's own rays. Noise is half the difference of two
/// halves of the set. Blur falls as 1/m, so that it is twice what the intensity still changes by as
/// m doubles; the product of that change in both halves has no part of the noise in it.
pub fn measured_exponent(rays: &[RaySample]) -> f64 {
    let stride = rays.len().div_ceil(MOST_RAYS + DIRECTIONS).max(1);
    let taken: Vec<&RaySample> = rays.iter().step_by(stride).collect();
    let probes = DIRECTIONS.min(taken.len() / 4);
    if probes == 0 {
        return EXPONENT_RANGE[0];
    }
    let spacing = taken.len() / probes;
    let mut halves = [vec![[0.0; OCTAVES + 1]; probes], vec![[0.0; OCTAVES + 1]; probes]];
    for (index, ray) in taken.iter().enumerate().filter(|(index, _)| index % spacing != 0) {
        let half = usize::from(random(1, index as u64, 0) < 0.5);
        let (direction, flux) = (ray.unit_direction(), f64::from(ray.flux));
        for (probe, sums) in halves[half].iter_mut().enumerate() {
            let toward = taken[probe * spacing].unit_direction();
            let mut power = direction.dot(toward).max(0.0);
            for (octave, sum) in sums.iter_mut().enumerate() {
                // (m + 1)/2 cosᵐ at m = 2^octave.
                *sum += flux * 0.5 * ((1u32 << octave) as f64 + 1.0) * power;
                power *= power;
            }
        }
    }
    let share = taken.len() as f64 / rays.len() as f64;
    let costs = (0..OCTAVES).map(|octave| cost(&halves, octave, share));
    let best = costs.enumerate().min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(at, _)| at);
    f64::from(1u32 << best).clamp(EXPONENT_RANGE[0], EXPONENT_RANGE[1])
}

/// Square of noise and weighted blur, relative to the intensity.
fn cost(halves: &[Vec<[f64; OCTAVES + 1]>; 2], octave: usize, share: f64) -> f64 {
    let (mut noise, mut change, mut mean) = (0.0, 0.0, 0.0);
    for (a, b) in halves[0].iter().zip(&halves[1]) {
        noise += (0.5 * (a[octave] - b[octave])).powi(2) * 4.0;
        change += 4.0 * (a[octave + 1] - a[octave]) * (b[octave + 1] - b[octave]);
        mean += (a[octave] + b[octave]).powi(2);
    }
    let blur2 = 4.0 * change.max(0.0);
    (noise * share + BLUR_WEIGHT.powi(2) * blur2) / mean.max(f64::MIN_POSITIVE)
}
