//! Convolution of an image plane by FFT.

use std::sync::Arc;

use rayon::prelude::*;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlanner};

/// Weights by distance, even in x and y.
pub struct Kernel {
    /// Offsets in x, from 0 on.
    pub width: usize,
    /// Offsets in y, from 0 on.
    pub height: usize,
    /// For offsets 0 … width − 1 and 0 … height − 1, rows of x.
    pub quadrant: Vec<f64>,
}

impl Kernel {
    /// Asks `weight` for each offset, on all threads.
    pub fn from_fn(
        width: usize,
        height: usize,
        weight: impl Fn(usize, usize) -> f64 + Sync,
    ) -> Self {
        let weights = (0..width * height).into_par_iter();
        let quadrant = weights.map(|at| weight(at % width, at / width)).collect();
        Self { width, height, quadrant }
    }
}

/// A kernel made ready for planes of its own size.
///
/// Planes are padded to twice their size, so that nothing wraps around. The crate's SIMD is
/// switched off in `Cargo.toml`: its sums would round differently on different machines.
pub struct Convolver {
    width: usize,
    height: usize,
    padded_width: usize,
    padded_height: usize,
    row_forward: Arc<dyn RealToComplex<f64>>,
    row_inverse: Arc<dyn ComplexToReal<f64>>,
    column_forward: Arc<dyn Fft<f64>>,
    column_inverse: Arc<dyn Fft<f64>>,
    /// The kernel's spectrum, scaled for the round trip; laid out as [`Self::forward`] returns it.
    spectrum: Vec<Complex<f64>>,
}

impl Convolver {
    /// Transforms the kernel.
    pub fn new(kernel: &Kernel) -> Self {
        let (width, height) = (kernel.width, kernel.height);
        let [padded_width, padded_height] = [width, height].map(|n| fast_length(2 * n - 1));
        let (mut rows, mut columns) = (RealFftPlanner::new(), FftPlanner::new());
        let mut convolver = Self {
            width,
            height,
            padded_width,
            padded_height,
            row_forward: rows.plan_fft_forward(padded_width),
            row_inverse: rows.plan_fft_inverse(padded_width),
            column_forward: columns.plan_fft_forward(padded_height),
            column_inverse: columns.plan_fft_inverse(padded_height),
            spectrum: Vec::new(),
        };
        let scale = 1.0 / (padded_width * padded_height) as f64;
        convolver.spectrum = convolver.forward(padded_height, |x, y| {
            // Negative offsets are at the far end.
            let (dx, dy) = (x.min(padded_width - x), y.min(padded_height - y));
            let inside = dx < width && dy < height;
            if inside { kernel.quadrant[dy * width + dx] * scale } else { 0.0 }
        });
        convolver
    }

    /// The plane (rows of x) with each value spread by the kernel; light that leaves is gone.
    ///
    /// Values ≥ 0 stay so: what rounding makes negative is 0.
    pub fn apply(&self, plane: &[f64]) -> Vec<f64> {
        let mut spectrum =
            self.forward(
                self.height,
                |x, y| {
                    if x < self.width { plane[y * self.width + x] } else { 0.0 }
                },
            );
        spectrum.par_iter_mut().zip(&self.spectrum).for_each(|(value, weight)| *value *= weight);
        self.inverse(spectrum)
    }

    /// Spectrum of the values at the first `rows` rows, all others 0: one run of
    /// `padded_height` a frequency in x.
    fn forward(
        &self,
        rows: usize,
        value: impl Fn(usize, usize) -> f64 + Sync,
    ) -> Vec<Complex<f64>> {
        let bins = self.padded_width / 2 + 1;
        let mut by_row = vec![Complex::default(); bins * rows];
        by_row.par_chunks_mut(bins).enumerate().for_each(|(y, out)| {
            let mut row: Vec<f64> = (0..self.padded_width).map(|x| value(x, y)).collect();
            self.row_forward.process(&mut row, out).expect("lengths are those of the plan");
        });
        let mut columns = vec![Complex::default(); bins * self.padded_height];
        columns.par_chunks_mut(self.padded_height).enumerate().for_each(|(bin, column)| {
            for (y, place) in column.iter_mut().take(rows).enumerate() {
                *place = by_row[y * bins + bin];
            }
            self.column_forward.process(column);
        });
        columns
    }

    fn inverse(&self, mut columns: Vec<Complex<f64>>) -> Vec<f64> {
        columns
            .par_chunks_mut(self.padded_height)
            .for_each(|column| self.column_inverse.process(column));
        let bins = self.padded_width / 2 + 1;
        let mut plane = vec![0.0; self.width * self.height];
        plane.par_chunks_mut(self.width).enumerate().for_each(|(y, out)| {
            let mut row: Vec<Complex<f64>> =
                (0..bins).map(|bin| columns[bin * self.padded_height + y]).collect();
            // Real by symmetry, but for rounding, and the plan insists.
            row[0].im = 0.0;
            if self.padded_width.is_multiple_of(2) {
                row[bins - 1].im = 0.0;
            }
            let mut values = vec![0.0; self.padded_width];
            self.row_inverse.process(&mut row, &mut values).expect("lengths are those of the plan");
            for (place, value) in out.iter_mut().zip(values) {
                *place = f64::max(value, 0.0);
            }
        });
        plane
    }
}

/// The smallest number from `at_least` on without factors above 5.
fn fast_length(at_least: usize) -> usize {
    let is_fast = |&n: &usize| {
        let rest = [2, 3, 5].into_iter().fold(n, |mut rest, factor| {
            while rest.is_multiple_of(factor) {
                rest /= factor;
            }
            rest
        });
        rest == 1
    };
    (at_least.max(1)..).find(is_fast).unwrap_or(at_least)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equals_the_sum_over_all_pairs() {
        for (width, height) in [(1, 1), (7, 1), (1, 6), (5, 9), (16, 3)] {
            let kernel =
                Kernel::from_fn(width, height, |x, y| 1.0 / (1.0 + (x * x + 3 * y) as f64));
            let plane: Vec<f64> = (0..width * height).map(|i| ((i * 37) % 11) as f64).collect();
            let found = Convolver::new(&kernel).apply(&plane);
            for (at, value) in found.iter().enumerate() {
                let (x, y) = (at % width, at / width);
                let term = |(from, value): (usize, &f64)| {
                    let (dx, dy) = (x.abs_diff(from % width), y.abs_diff(from / width));
                    kernel.quadrant[dy * width + dx] * value
                };
                let sum: f64 = plane.iter().enumerate().map(term).sum();
                // Rounding of the transform, relative to the largest value.
                assert!((value - sum).abs() < 1e-13 * 100.0, "{width} × {height}: {value} {sum}");
            }
        }
    }

    #[test]
    fn lengths_have_small_factors() {
        for (at_least, expected) in [(0, 1), (1, 1), (7, 8), (1279, 1280), (961, 972)] {
            assert_eq!(fast_length(at_least), expected);
        }
    }
}
