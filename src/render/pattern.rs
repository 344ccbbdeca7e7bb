//! Where in its pixel a sample lies.
//!
//! Points of Sobol's first two dimensions, scrambled as Owen does, each pixel by numbers of its own:
//! every 2ᵐ points from a multiple of 2ᵐ on have one in each box of area 2⁻ᵐ, however it is shaped,
//! and pixels have nothing in common. The docs' page on accuracy compares them with others.

use crate::source::sequence::mix;

/// The places of one pixel's samples in the unit square.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pattern {
    seeds: [u32; 2],
}

impl Pattern {
    pub fn of_pixel(x: usize, y: usize) -> Self {
        let bits = mix(mix(x as u64).wrapping_add(y as u64));
        Self { seeds: [bits as u32, (bits >> 32) as u32] }
    }

    /// Place of sample `i` where their number is not known beforehand.
    pub fn place(&self, i: u32) -> [f64; 2] {
        let bits = [scrambled(i, self.seeds[0]), scrambled(sobol_reversed(i), self.seeds[1])];
        bits.map(|reversed| (f64::from(reversed.reverse_bits()) + 0.5) * 2f64.powi(-32))
    }

    /// Places of exactly `count` samples, one in each of `count` columns and rows, in their middle:
    /// so the mean place is the pixel's center, and a single one lies there.
    pub fn set(&self, count: u32) -> Vec<[f64; 2]> {
        let mut places: Vec<[f64; 2]> = (0..count).map(|i| self.place(i)).collect();
        let mut order: Vec<usize> = (0..places.len()).collect();
        for axis in [0, 1] {
            order.sort_unstable_by(|&a, &b| places[a][axis].total_cmp(&places[b][axis]));
            for (rank, &at) in order.iter().enumerate() {
                places[at][axis] = (rank as f64 + 0.5) / f64::from(count);
            }
        }
        places
    }
}

/// Point i of Sobol's second dimension, its bits from the last to the first; those of the first
/// dimension are i itself.
fn sobol_reversed(i: u32) -> u32 {
    let mut direction = 1u32;
    let mut bits = 0;
    for bit in 0..32 {
        if i >> bit & 1 == 1 {
            bits ^= direction;
        }
        direction ^= direction << 1;
    }
    bits
}

/// Flips each bit by what a hash makes of those below it: Owen's scrambling of reversed bits.
///
/// Source: S. Laine and T. Karras, "Stratified sampling for stochastic transparency", EGSR 2011;
/// the constants are N. Vegdahl's (2021).
fn scrambled(mut reversed: u32, seed: u32) -> u32 {
    reversed ^= reversed.wrapping_mul(0x3d20_adea);
    reversed = reversed.wrapping_add(seed);
    reversed = reversed.wrapping_mul(seed >> 16 | 1);
    reversed ^= reversed.wrapping_mul(0x0552_6c56);
    reversed ^ reversed.wrapping_mul(0x53a2_2864)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Boxes of every shape of area 1/64: each holds one of 64 consecutive points.
    #[test]
    fn every_box_has_its_point() {
        for (x, y, first) in [(0, 0, 0), (17, 3, 64), (639, 479, 4096)] {
            let pattern = Pattern::of_pixel(x, y);
            for columns in [1u32, 2, 4, 8, 16, 32, 64] {
                let rows = 64 / columns;
                let mut met = [false; 64];
                for i in first..first + 64 {
                    let [u, v] = pattern.place(i);
                    let [column, row] = [(u, columns), (v, rows)].map(|(t, of)| t * f64::from(of));
                    met[column as usize * rows as usize + row as usize] = true;
                }
                assert_eq!(met, [true; 64], "{columns} columns of pixel {x}, {y}");
            }
        }
    }

    #[test]
    fn sets_of_any_size_lie_about_the_center() {
        for count in [1, 2, 3, 4, 7, 16, 100] {
            let places = Pattern::of_pixel(5, 6).set(count);
            for axis in [0, 1] {
                let sum: f64 = places.iter().map(|place| place[axis]).sum();
                // A sum of `count` numbers below 1.
                assert!((sum / f64::from(count) - 0.5).abs() < 1e-15, "{count}");
                let mut columns: Vec<u32> =
                    places.iter().map(|place| (place[axis] * f64::from(count)) as u32).collect();
                columns.sort_unstable();
                assert!(columns.into_iter().eq(0..count), "one a column");
            }
        }
        assert_eq!(Pattern::of_pixel(5, 6).set(1), [[0.5, 0.5]]);
    }

    /// First places of 64 × 64 pixels: each neighbor's difference is as that of random numbers,
    /// whose products with the next pixel's have a mean of 0 ± 1/12/64.
    #[test]
    fn pixels_have_nothing_in_common() {
        let first = |x, y| Pattern::of_pixel(x, y).place(0).map(|t| t - 0.5);
        for (dx, dy) in [(1, 0), (0, 1), (1, 1)] {
            let products = (0..64 * 64).map(|at| {
                let (x, y) = (at % 64, at / 64);
                let (here, there) = (first(x, y), first(x + dx, y + dy));
                here[0] * there[0] + here[1] * there[1]
            });
            let mean = products.sum::<f64>() / 4096.0;
            // Four standard deviations of √2/12/64.
            assert!(mean.abs() < 4.0 * 2f64.sqrt() / 12.0 / 64.0, "{mean}");
        }
    }
}
