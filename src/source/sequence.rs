//! Points in the unit cube that fill it evenly or at random, each from its index alone, so that
//! any thread may draw any of them.

/// The first four dimensions of Sobol's sequence, xored with random bits of a seed.
///
/// Every 2^m points from a multiple of 2^m on are even in all boxes of a power of two, in each
/// dimension, and nearly so in each pair of them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct EvenSequence {
    shift: [u32; 4],
}

/// What each bit of an index adds to a coordinate, in 32-bit fractions.
static DIRECTIONS: [[u32; 32]; 4] = [
    directions(1, 0, [1, 1, 1]),
    directions(1, 1, [1, 1, 1]),
    directions(2, 0b11, [1, 3, 3]),
    directions(3, 0b110, [1, 3, 1]),
];

/// Bratley and Fox's recurrence. Bit k − 1 of `taps` is set if m_i takes part of m_{i−k}, as the
/// coefficients of a primitive polynomial of `degree` say; `first` are the starting numbers m_1 …
///
/// Source of the polynomials and numbers: S. Joe and F. Y. Kuo, "Constructing Sobol sequences with
/// better two-dimensional projections", SIAM J. Sci. Comput. 30 (2008). No taps: the plain
/// bit-reversed index.
const fn directions(degree: usize, taps: u32, first: [u32; 3]) -> [u32; 32] {
    let mut v = [0u32; 32];
    let mut i = 0;
    while i < 32 {
        if taps == 0 {
            v[i] = 1 << (31 - i);
        } else if i < degree {
            v[i] = first[i] << (31 - i);
        } else {
            let mut bits = v[i - degree] ^ (v[i - degree] >> degree);
            let mut k = 1;
            while k < degree {
                if taps >> (k - 1) & 1 == 1 {
                    bits ^= v[i - k];
                }
                k += 1;
            }
            v[i] = bits;
        }
        i += 1;
    }
    v
}

impl EvenSequence {
    pub fn new(seed: u64) -> Self {
        let bits = |k: usize| (mix(mix(seed).wrapping_add(k as u64)) >> 32) as u32;
        Self { shift: std::array::from_fn(bits) }
    }

    /// Each coordinate in [0, 1), never nearer than 2⁻³³ to its ends. It repeats after 2³² points.
    pub fn point(&self, index: u32) -> [f64; 4] {
        std::array::from_fn(|k| {
            let set_bits = (0..32).filter(|bit| index >> bit & 1 == 1);
            let bits = set_bits.fold(self.shift[k], |bits, bit| bits ^ DIRECTIONS[k][bit]);
            (f64::from(bits) + 0.5) * 2f64.powi(-32)
        })
    }
}

/// Independent random numbers in [0, 1): one for each seed, index and dimension.
pub(crate) fn random(seed: u64, index: u64, dimension: u64) -> f64 {
    unit(mix(mix(mix(seed).wrapping_add(index)).wrapping_add(dimension)))
}

/// The top 53 bits as a fraction: never 1.
fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 * 2f64.powi(-53)
}

/// One step of SplitMix64 (Steele, Lea & Flood 2014), which spreads every bit over all others.
pub(crate) fn mix(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 4096 points in 16 × 16 boxes of every two dimensions: 16 a box, from which random points
    /// would deviate by 4 rms, and a Sobol pair of these dimensions does not at all.
    #[test]
    fn every_pair_of_dimensions_is_even() {
        let sequence = EvenSequence::new(7);
        for (a, b) in [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)] {
            let mut boxes = [0.0f64; 256];
            for index in 0..4096 {
                let p = sequence.point(index);
                boxes[(p[a] * 16.0) as usize * 16 + (p[b] * 16.0) as usize] += 1.0;
            }
            let squares: f64 = boxes.iter().map(|count| (count - 16.0).powi(2)).sum();
            let rms = (squares / 256.0).sqrt();
            assert!(rms == 0.0, "dimensions {a}, {b}: {rms}");
        }
    }

    #[test]
    fn seeds_and_dimensions_differ() {
        assert_ne!(EvenSequence::new(1).point(0), EvenSequence::new(2).point(0));
        assert_ne!(random(1, 2, 3), random(1, 3, 2));
        let mean = (0..10_000).map(|i| random(5, i, 0)).sum::<f64>() / 1e4;
        // standard deviation 0.0029
        assert!((mean - 0.5).abs() < 0.012, "{mean}");
    }
}
