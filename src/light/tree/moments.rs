//! Moments of a cell's emission into one direction, about a place that can be moved.
//!
//! For a direction x, with w_i = Φ_i max(0, x·Q_i), δ_i a sample's place in the cell, H_i = 1 where
//! x·Q_i > 0, and τ_i = δ_i·Q_i.

/// Σ w.
pub(super) const EMISSION: usize = 0;
/// Σ w δ.
pub(super) const MEAN: usize = 1;
/// Σ w δ δᵀ, in the order of [`PAIRS`].
pub(super) const SPREAD: usize = 4;
/// Σ Φ H Q, the gradient of Σ w.
pub(super) const GRADIENT: usize = 10;
/// Σ Φ H τ: how Σ w changes as the hit comes near.
pub(super) const PARALLAX: usize = 13;
/// Σ Φ τ² where x·Q > −[`WIDE`]: of all samples that a near hit may find turned to it.
pub(super) const PARALLAX2: usize = 14;
/// Σ Φ of the same samples; only while building.
pub(super) const LIT: usize = 15;
/// Σ w δ δ δ, in the order of [`TRIPLES`]; only while building.
pub(super) const SKEW: usize = 16;
pub(super) const MOMENTS: usize = 26;

/// Sine of the angle by which a sample may be turned away and still count in [`PARALLAX2`]: more
/// than a node's radius over its distance from any hit that uses its table.
pub(super) const WIDE: f32 = 0.35;

/// What a finished table has instead of `LIT` and `SKEW`: the norm of the third central moment.
pub(super) const SKEWNESS: usize = 15;
pub(super) const CHANNELS: usize = 16;

/// A vertex of a finished table: one cache line.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Channels(pub [f32; CHANNELS]);

pub(super) const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
pub(super) const TRIPLES: [(usize, usize, usize); 10] = [
    (0, 0, 0),
    (1, 1, 1),
    (2, 2, 2),
    (0, 0, 1),
    (0, 0, 2),
    (1, 1, 0),
    (1, 1, 2),
    (2, 2, 0),
    (2, 2, 1),
    (0, 1, 2),
];
/// How often each triple stands in the full tensor.
const TRIPLE_COUNTS: [f64; 10] = [1.0, 1.0, 1.0, 3.0, 3.0, 3.0, 3.0, 3.0, 3.0, 6.0];

/// One direction's moments.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moments(pub [f64; MOMENTS]);

impl Moments {
    pub const ZERO: Moments = Moments([0.0; MOMENTS]);

    pub fn from_f32(values: &[f32]) -> Moments {
        Moments(std::array::from_fn(|i| values.get(i).copied().map_or(0.0, f64::from)))
    }

    pub fn add(&mut self, other: &Moments) {
        for (sum, value) in self.0.iter_mut().zip(other.0) {
            *sum += value;
        }
    }

    /// About a place that lies at −`by` of the present one: every δ grows by `by`.
    ///
    /// `PARALLAX2` becomes an upper bound, since Σ Φ Q Qᵀ is not kept.
    pub fn shifted(&self, by: [f64; 3]) -> Moments {
        let old = &self.0;
        let mut new = *old;
        let e = old[EMISSION];
        for (a, shift) in by.iter().enumerate() {
            new[MEAN + a] += e * shift;
        }
        for (i, (a, b)) in PAIRS.into_iter().enumerate() {
            new[SPREAD + i] += old[MEAN + a] * by[b] + old[MEAN + b] * by[a] + e * by[a] * by[b];
        }
        for (i, (a, b, c)) in TRIPLES.into_iter().enumerate() {
            let first = |a, b, c| old[MEAN + a] * by[b] * by[c];
            let second = |a, b, c| old[SPREAD + pair(a, b)] * by[c];
            new[SKEW + i] += second(a, b, c)
                + second(a, c, b)
                + second(b, c, a)
                + first(a, b, c)
                + first(b, a, c)
                + first(c, a, b)
                + e * by[a] * by[b] * by[c];
        }
        new[PARALLAX] += (0..3).map(|a| by[a] * old[GRADIENT + a]).sum::<f64>();
        let distance = by.iter().map(|v| v * v).sum::<f64>().sqrt();
        new[PARALLAX2] = (old[PARALLAX2].max(0.0).sqrt() + distance * old[LIT].sqrt()).powi(2);
        Moments(new)
    }

    /// A vertex of a finished table.
    pub fn channels(&self) -> Channels {
        let mut channels: [f32; CHANNELS] = std::array::from_fn(|i| self.0[i] as f32);
        channels[SKEWNESS] = self.skewness() as f32;
        Channels(channels)
    }

    /// Frobenius norm of Σ w (δ − mean)³.
    fn skewness(&self) -> f64 {
        if self.0[EMISSION] <= 0.0 {
            return 0.0;
        }
        let to_mean = std::array::from_fn(|a| -self.0[MEAN + a] / self.0[EMISSION]);
        let central = self.shifted(to_mean).0;
        let squares = TRIPLE_COUNTS.iter().zip(&central[SKEW..]).map(|(n, m)| n * m * m);
        squares.sum::<f64>().sqrt()
    }
}

/// Index of (a, b) in [`PAIRS`].
fn pair(a: usize, b: usize) -> usize {
    if a == b { a } else { a + b + 2 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three weighted places, directly.
    fn direct(shift: [f64; 3]) -> Moments {
        let samples = [(0.5, [1.0, -2.0, 0.5]), (1.5, [-0.3, 0.7, 2.0]), (0.7, [0.1, 1.1, -0.9])];
        let mut moments = Moments::ZERO;
        for (w, place) in samples {
            let d: [f64; 3] = std::array::from_fn(|a| place[a] + shift[a]);
            moments.0[EMISSION] += w;
            for (a, place) in d.iter().enumerate() {
                moments.0[MEAN + a] += w * place;
            }
            for (i, (a, b)) in PAIRS.into_iter().enumerate() {
                moments.0[SPREAD + i] += w * d[a] * d[b];
            }
            for (i, (a, b, c)) in TRIPLES.into_iter().enumerate() {
                moments.0[SKEW + i] += w * d[a] * d[b] * d[c];
            }
        }
        moments
    }

    #[test]
    fn shifted_moments_are_those_of_shifted_samples() {
        let shift = [0.4, -1.3, 2.2];
        let (moved, expected) = (direct([0.0; 3]).shifted(shift), direct(shift));
        for (i, (a, b)) in moved.0.iter().zip(expected.0).enumerate() {
            assert!((a - b).abs() < 1e-12, "moment {i}: {a}, expected {b}");
        }
    }

    #[test]
    fn a_symmetric_cell_has_no_skewness() {
        let mut moments = Moments::ZERO;
        for sign in [-1.0, 1.0] {
            let mut one = Moments::ZERO;
            one.0[EMISSION] = 1.0;
            moments.add(&one.shifted([sign * 0.3, sign * 2.0, sign * -0.7]));
        }
        assert!(moments.channels().0[SKEWNESS] < 1e-6);
        assert!(direct([0.0; 3]).channels().0[SKEWNESS] > 0.1);
    }
}
