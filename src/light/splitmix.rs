//! A small generator of our own, so that a seed gives the same rays in every version.

/// SplitMix64: Steele, Lea & Flood, "Fast splittable pseudorandom number generators", 2014.
#[derive(Debug, Clone)]
pub struct SplitMix64 {
    state: u64,
}

impl SplitMix64 {
    pub fn new(seed: u64) -> Self {
        Self { state: seed }
    }

    pub fn next_u64(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// In [0, 1), a multiple of 2⁻⁵³.
    pub fn next_f64(&mut self) -> f64 {
        (self.next_u64() >> 11) as f64 * (0.5f64).powi(53)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first outputs of the published generator for the seed 1234567.
    #[test]
    fn published_sequence() {
        let mut random = SplitMix64::new(1_234_567);
        let found = [random.next_u64(), random.next_u64(), random.next_u64()];
        let expected =
            [6_457_827_717_110_365_317, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423];
        assert_eq!(found, expected);
    }

    #[test]
    fn floats_are_even_over_the_unit_interval() {
        let mut random = SplitMix64::new(0);
        let n = 100_000;
        let mean = (0..n).map(|_| random.next_f64()).sum::<f64>() / f64::from(n);
        // Standard error 1/√(12 n) = 9e-4; five of them.
        assert!((mean - 0.5).abs() < 5e-3);
    }
}
