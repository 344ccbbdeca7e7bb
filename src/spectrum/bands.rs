//! One value per band of a wavelength grid.

use super::WavelengthGrid;

/// Spectral values at the bands of the working grid.
///
/// Fixed storage, so that a ray carries its spectrum without an allocation.
#[derive(Debug, Clone)]
pub struct Bands {
    len: usize,
    values: [f64; WavelengthGrid::MAX_BANDS],
}

impl Bands {
    /// 0 in `len` bands, at most [`WavelengthGrid::MAX_BANDS`].
    pub fn zero(len: usize) -> Self {
        Self { len, values: [0.0; WavelengthGrid::MAX_BANDS] }
    }

    /// 1 in `len` bands.
    pub fn one(len: usize) -> Self {
        let mut bands = Self::zero(len);
        bands.as_mut_slice().fill(1.0);
        bands
    }

    /// The same values; at most [`WavelengthGrid::MAX_BANDS`].
    pub fn from_slice(values: &[f64]) -> Self {
        let mut bands = Self::zero(values.len());
        bands.as_mut_slice().copy_from_slice(values);
        bands
    }

    /// Values from the shortest wavelength to the longest.
    pub fn as_slice(&self) -> &[f64] {
        &self.values[..self.len]
    }

    /// Values from the shortest wavelength to the longest, to be changed.
    pub fn as_mut_slice(&mut self) -> &mut [f64] {
        &mut self.values[..self.len]
    }

    /// Adds `other`, band by band.
    pub fn add(&mut self, other: &Self) {
        for (sum, value) in self.as_mut_slice().iter_mut().zip(other.as_slice()) {
            *sum += value;
        }
    }

    /// Σ self b over all bands, in four sums side by side: one alone would wait for each addition.
    pub fn dot(&self, b: &Self) -> f64 {
        let (fours, rest) = self.as_slice().as_chunks::<4>();
        let (b_fours, b_rest) = b.as_slice().as_chunks::<4>();
        let mut sums = [0.0; 4];
        for (a, b) in fours.iter().zip(b_fours) {
            for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
                *sum += a * b;
            }
        }
        let rest: f64 = rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
        (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
    }

    /// Adds the product a b, band by band.
    pub fn add_product(&mut self, a: &Self, b: &Self) {
        for ((sum, a), b) in self.as_mut_slice().iter_mut().zip(a.as_slice()).zip(b.as_slice()) {
            *sum += a * b;
        }
    }

    /// Multiplies by `factor` b, band by band.
    pub fn scale_by(&mut self, factor: f64, b: &Self) {
        for (value, b) in self.as_mut_slice().iter_mut().zip(b.as_slice()) {
            *value *= factor * b;
        }
    }

    /// Multiplies by exp(−absorption · distance), Beer–Lambert.
    pub fn attenuate(&mut self, absorption_per_mm: &Self, distance_mm: f64) {
        let absorption = absorption_per_mm.as_slice();
        for (value, absorption) in self.as_mut_slice().iter_mut().zip(absorption) {
            *value *= (-absorption * distance_mm).exp();
        }
    }

    /// Whether every band is below `limit`, or all are 0.
    pub fn is_below(&self, limit: f64) -> bool {
        let max = self.as_slice().iter().copied().fold(0.0, f64::max);
        max < limit || max == 0.0
    }

    /// Whether every band is 0.
    pub fn is_zero(&self) -> bool {
        self.as_slice().iter().all(|&v| v == 0.0)
    }
}
