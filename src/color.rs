//! Tristimulus values and chromaticity.

use crate::spectrum::{WavelengthGrid, cie};

/// CIE 1931 XYZ; Y is photometric (eq. 4).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Xyz {
    pub x: f64,
    pub y: f64,
    pub z: f64,
}

impl Xyz {
    /// 683 Σ I(λ) (x̄, ȳ, z̄)(λ) Δλ (eq. 4); `bands` are values at the bands of `grid`.
    pub fn from_bands(grid: WavelengthGrid, bands: &[f64]) -> Self {
        let mut sum = [0.0; 3];
        for (band, value) in bands.iter().enumerate() {
            for (s, cmf) in sum.iter_mut().zip(cie::cmf(grid, band)) {
                *s += value * cmf;
            }
        }
        let [x, y, z] = sum.map(|s| s * cie::K_LM_PER_W * grid.step_nm());
        Self { x, y, z }
    }

    /// (x, y), or `None` for black.
    pub fn chromaticity(self) -> Option<[f64; 2]> {
        let sum = self.x + self.y + self.z;
        (sum > 0.0).then(|| [self.x / sum, self.y / sum])
    }
}
