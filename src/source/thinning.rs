//! Fewer rays for the same light.
//!
//! A ray is kept with a probability proportional to its flux, and what is kept carries equal flux:
//! for a given number of rays this leaves the least noise. Rays that alone carry more than an equal
//! share are kept as they are. The draw is the pivotal method (Deville & Tillé, "Unequal
//! probability sampling without replacement through a splitting method", Biometrika 85, 1998):
//! neighbors in the file's order duel for a place, so that every stretch of the file keeps its
//! share, exactly the wanted number is kept, and no ray is kept twice. A fixed stride would do so
//! too, but picks one residue class of the low-discrepancy sequences that ray files are made of,
//! and with it one part of space.

use std::sync::Arc;

use super::sequence::random;
use crate::light::{RaySample, RaySet};

/// The seed where a script gives none.
pub const DEFAULT_SEED: u64 = 1;

/// Keeps the duels apart from other draws with the same seed, such as those that made the set.
const DIMENSION: u64 = u64::from_be_bytes(*b"thinning");

impl RaySet {
    /// At most `count` rays (at least 1) with the flux of all, in the order of the file.
    ///
    /// Rays without flux are never kept. The same seed gives the same rays.
    pub fn thinned(&self, count: usize, seed: u64) -> Self {
        let count = count.max(1);
        let lit = self.samples.iter().filter(|sample| sample.flux > 0.0).count();
        if count >= self.samples.len() {
            return self.clone();
        }
        let samples = if count >= lit {
            self.samples.iter().filter(|sample| sample.flux > 0.0).copied().collect()
        } else {
            Draw::new(&self.samples, count).keep(&self.samples, seed)
        };
        Self { samples, ..self.clone() }
    }
}

/// Which rays are kept for certain, and the flux of the others once kept.
struct Draw {
    /// Rays with at least this flux are kept as they are.
    certain_flux: f64,
    /// What a drawn ray carries; ∞ if all are certain.
    kept_flux: f64,
}

impl Draw {
    fn new(samples: &[RaySample], count: usize) -> Self {
        let mut certain_flux = f64::INFINITY;
        loop {
            let mut certain = 0;
            let mut rest = 0.0;
            for flux in samples.iter().map(|sample| f64::from(sample.flux)) {
                if flux >= certain_flux {
                    certain += 1;
                } else {
                    rest += flux;
                }
            }
            let kept_flux = rest / (count - certain.min(count)) as f64;
            // Each round can only lower the share, so that this ends.
            if samples.iter().all(|s| {
                let flux = f64::from(s.flux);
                flux >= certain_flux || flux < kept_flux
            }) {
                return Self { certain_flux, kept_flux };
            }
            certain_flux = kept_flux;
        }
    }

    fn keep(&self, samples: &[RaySample], seed: u64) -> Arc<[RaySample]> {
        let kept = self.draw(samples, seed);
        let kept = samples.iter().zip(kept).filter(|(_, kept)| *kept);
        kept.map(|(sample, _)| {
            let is_certain = f64::from(sample.flux) >= self.certain_flux;
            let flux = if is_certain { sample.flux } else { self.kept_flux as f32 };
            RaySample { flux, ..*sample }
        })
        .collect()
    }

    fn draw(&self, samples: &[RaySample], seed: u64) -> Vec<bool> {
        let mut kept = vec![false; samples.len()];
        // The ray that still duels, with its probability.
        let mut champion: Option<(usize, f64)> = None;
        for (index, flux) in samples.iter().map(|sample| f64::from(sample.flux)).enumerate() {
            if flux >= self.certain_flux {
                kept[index] = true;
                continue;
            }
            let p = flux / self.kept_flux;
            let Some((rival, q)) = champion else {
                champion = Some((index, p));
                continue;
            };
            let sum = p + q;
            if sum < 1.0 {
                let rival_wins = random(seed, index as u64, DIMENSION) * sum < q;
                champion = Some((if rival_wins { rival } else { index }, sum));
            } else {
                let rival_is_kept = random(seed, index as u64, DIMENSION) * (2.0 - sum) < 1.0 - p;
                let (winner, next) = if rival_is_kept { (rival, index) } else { (index, rival) };
                kept[winner] = true;
                champion = Some((next, sum - 1.0));
            }
        }
        // The probabilities sum to a whole number but for rounding, so that the last one is 0 or 1.
        if let Some((last, p)) = champion {
            kept[last] = p > 0.5;
        }
        kept
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(flux: impl Iterator<Item = f32>) -> RaySet {
        let samples: Arc<[RaySample]> = (0..)
            .zip(flux)
            .map(|(i, flux)| {
                // Lambert about +Z, starts on a 4 mm square.
                let (u, v) = (random(9, i, 0), random(9, i, 1));
                let (s, phi) = (u.sqrt(), std::f64::consts::TAU * v);
                let direction = [s * phi.cos(), s * phi.sin(), (1.0 - u).sqrt()];
                let position = [4.0 * random(9, i, 2) - 2.0, 4.0 * random(9, i, 3) - 2.0, 0.0];
                RaySample {
                    position: position.map(|x| x as f32),
                    direction: direction.map(|x| x as f32),
                    flux,
                }
            })
            .collect();
        let flux_lm = total(&samples);
        RaySet::new(samples, flux_lm)
    }

    fn total(samples: &[RaySample]) -> f64 {
        samples.iter().map(|s| f64::from(s.flux)).sum()
    }

    fn heavy_tail(n: u64) -> RaySet {
        set((0..n).map(|i| (1.0 / (random(3, i, 0) + 1e-3)) as f32))
    }

    #[test]
    fn number_and_flux_are_kept_exactly() {
        for all in [set((0..20_000).map(|_| 0.25)), heavy_tail(20_000)] {
            for count in [1, 2, 7, 100, 9_999, 10_000, 19_999] {
                let thin = all.thinned(count, 5);
                assert_eq!(thin.samples.len(), count);
                // f32 rounding of the kept flux.
                assert!((total(&thin.samples) / total(&all.samples) - 1.0).abs() < 1e-6);
                assert_eq!(thin.flux_lm, all.flux_lm);
            }
            assert_eq!(all.thinned(20_000, 5).samples, all.samples);
        }
    }

    /// Flux through bins of angle and place, against the full set, for several seeds.
    #[test]
    fn angles_and_places_keep_their_flux_for_any_seed() {
        let all = heavy_tail(50_000);
        let count = 5_000;
        for seed in [0, 1, 2, 77, u64::MAX] {
            let thin = all.thinned(count, seed);
            for bin in 0..16 {
                let share = |set: &RaySet| {
                    let inside = set.samples.iter().filter(|s| bin_of(s) == bin);
                    inside.map(|s| f64::from(s.flux)).sum::<f64>() / total(&set.samples)
                };
                let (expected, found) = (share(&all), share(&thin));
                // Equal flux a ray: binomial, five standard deviations.
                let sigma = (expected * (1.0 - expected) / count as f64).sqrt();
                assert!((found - expected).abs() < 5.0 * sigma, "seed {seed} bin {bin}");
            }
        }
    }

    fn bin_of(s: &RaySample) -> usize {
        let bit = |positive: bool, place: usize| usize::from(positive) << place;
        bit(s.direction[0] > 0.0, 0)
            + bit(s.direction[2] > 0.7, 1)
            + bit(s.position[0] > 0.0, 2)
            + bit(s.position[1] > 1.0, 3)
    }

    /// A file in the order of a van der Corput sequence: a stride of 8 would keep one eighth of the
    /// interval.
    #[test]
    fn low_discrepancy_order_does_not_alias() {
        let n = 1u32 << 14;
        let samples: Arc<[RaySample]> = (0..n)
            .map(|i| RaySample {
                position: [(f64::from(i.reverse_bits()) * 0.5f64.powi(32)) as f32, 0.0, 0.0],
                direction: [0.0, 0.0, 1.0],
                flux: 1.0,
            })
            .collect();
        let thin = RaySet::new(samples, 1.0).thinned(n as usize / 8, 1);
        for eighth in 0..8 {
            let inside = |s: &&RaySample| (s.position[0] * 8.0) as i32 == eighth;
            let share =
                thin.samples.iter().filter(inside).count() as f64 / thin.samples.len() as f64;
            // Binomial with 2048 rays: σ = 0.0073; five of them.
            assert!((share - 0.125).abs() < 0.037, "{eighth}: {share}");
        }
    }

    #[test]
    fn every_ray_is_kept_in_proportion_to_its_flux() {
        let all = set([1.0, 2.0, 0.0, 3.0, 4.0, 30.0].into_iter());
        let draws = 20_000;
        let mut hits = [0; 6];
        for seed in 0..draws {
            // Three of six: the brightest for certain, two in proportion to 1 : 2 : 0 : 3 : 4.
            for sample in all.thinned(3, seed).samples.iter() {
                let at = all.samples.iter().position(|s| s.position == sample.position);
                hits[at.unwrap()] += 1;
            }
        }
        for (hits, expected) in hits.into_iter().zip([0.2, 0.4, 0.0, 0.6, 0.8, 1.0]) {
            // σ ≤ 0.0035; five of them.
            assert!((f64::from(hits) / draws as f64 - expected).abs() < 0.018);
        }
    }

    #[test]
    fn the_seed_decides() {
        let all = heavy_tail(1000);
        assert_eq!(all.thinned(100, 4).samples, all.thinned(100, 4).samples);
        assert_ne!(all.thinned(100, 4).samples, all.thinned(100, 5).samples);
    }
}
