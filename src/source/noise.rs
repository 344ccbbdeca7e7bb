//! The error that a RAYSET of N rays has of its own, whatever the rendering spends.
//!
//! Two disjoint halves of a set are two independent pictures with N/2 rays. Half their difference
//! has the variance of their mean, which is the picture with N rays: its size is the error.

use std::sync::Arc;

use super::sequence::random;
use crate::light::{RaySample, RaySet};

/// Keeps the split apart from other draws with the same seed, such as those that made the set.
const DIMENSION: u64 = u64::from_be_bytes(*b"  halves");

impl RaySet {
    /// Two halves drawn at random, each with the flux of all; with an odd number of rays the first
    /// has one less. The same seed gives the same halves.
    pub fn halves(&self, seed: u64) -> [Self; 2] {
        let n = self.samples.len();
        // Selection sampling (Knuth, TAOCP 2, 3.4.2 S): every half is equally likely.
        let mut wanted = n / 2;
        let in_first: Vec<bool> = (0..n)
            .map(|index| {
                let chosen =
                    random(seed, index as u64, DIMENSION) * ((n - index) as f64) < wanted as f64;
                wanted -= usize::from(chosen);
                chosen
            })
            .collect();
        let half = |first: bool| {
            let of_half = self.samples.iter().zip(&in_first).filter(|(_, f)| **f == first);
            let samples: Arc<[RaySample]> = of_half.map(|(sample, _)| *sample).collect();
            Self { samples, ..self.clone() }
        };
        [half(true), half(false)]
    }
}

/// The relative standard error of the values that a whole set gives, from pairs of values that the
/// halves of one or more splits give; `None` without pairs or light.
///
/// √(Σ ((a − b)/2)² / Σ ((a + b)/2)²): bright values weigh most, as highlights do in a picture.
pub fn relative_error(pairs: impl IntoIterator<Item = [f64; 2]>) -> Option<f64> {
    let (mut difference, mut mean) = (0.0, 0.0);
    for [a, b] in pairs {
        difference += (0.5 * (a - b)).powi(2);
        mean += (0.5 * (a + b)).powi(2);
    }
    (mean > 0.0 && difference.is_finite()).then(|| (difference / mean).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(n: u32) -> RaySet {
        let sample = |i: u32| RaySample {
            position: [i as f32, 0.0, 0.0],
            direction: [0.0, 0.0, 1.0],
            flux: 1.0,
        };
        RaySet::new((0..n).map(sample).collect(), 460.0)
    }

    #[test]
    fn halves_are_disjoint_and_complete() {
        for n in [0, 1, 2, 101, 1000] {
            let halves = set(n).halves(3);
            assert_eq!(halves[0].samples.len(), n as usize / 2);
            let mut all: Vec<f32> =
                halves.iter().flat_map(|h| h.samples.iter().map(|s| s.position[0])).collect();
            all.sort_by(f32::total_cmp);
            assert_eq!(all, (0..n).map(|i| i as f32).collect::<Vec<_>>());
            assert!(halves.iter().all(|h| h.flux_lm == 460.0));
        }
    }

    /// The share of rays that fall into an interval of probability p has the relative error
    /// √((1 − p)/(p N)).
    #[test]
    fn error_of_a_binomial_share() {
        let (n, p) = (10_000_u64, 0.1);
        let samples = (0..n).map(|i| RaySample {
            position: [random(8, i, 0) as f32, 0.0, 0.0],
            direction: [0.0, 0.0, 1.0],
            flux: 1.0,
        });
        let all = RaySet::new(samples.collect(), 1.0);
        let share = |set: &RaySet| {
            let inside = set.samples.iter().filter(|s| s.position[0] < p as f32).count();
            inside as f64 / set.samples.len() as f64
        };
        let pairs = (0..200).map(|seed| all.halves(seed).map(|half| share(&half)));
        let found = relative_error(pairs).unwrap();
        let expected = ((1.0 - p) / (p * n as f64)).sqrt();
        // 200 splits give a standard deviation of 1/√400 = 5 %; four of them.
        assert!((found / expected - 1.0).abs() < 0.2, "{found} {expected}");
    }

    #[test]
    fn nothing_to_compare_is_none() {
        assert_eq!(relative_error([]), None);
        assert_eq!(relative_error([[0.0, 0.0]]), None);
        assert_eq!(relative_error([[1.0, 3.0]]), Some(0.5));
    }
}
