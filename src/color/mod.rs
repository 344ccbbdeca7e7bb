//! Tristimulus values, chromaticity, CIELAB and color differences, linear Rec. 709 and sRGB,
//! signal colors.

mod difference;
mod lab;
mod photometry;
mod rec709;
pub mod signal;
pub mod upsampling;

pub use difference::{delta_e_2000, delta_e_ab};
pub use lab::Lab;
pub use photometry::Photometry;
pub use rec709::{
    D65_XY, P3_XY, REC709_XY, rec709_from_xyz, srgb_decode, srgb_encode, xyz_from_rec709,
};

use std::ops::{Add, Mul, Sub};

use glam::{DMat3, DVec3};

use crate::spectrum::{Spectrum, WavelengthGrid, cie};

/// CIE 1931 XYZ; Y is photometric (eq. 4).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Xyz {
    /// X, in the unit of Y.
    pub x: f64,
    /// Y: luminance (cd/m²), illuminance (lx) or whatever the spectrum weighs.
    pub y: f64,
    /// Z, in the unit of Y.
    pub z: f64,
}

impl Xyz {
    /// A color from its three values.
    pub const fn new(x: f64, y: f64, z: f64) -> Self {
        Self { x, y, z }
    }

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

    /// The color of chromaticity (x, y) and luminance `y_lum`.
    pub fn from_xy([x, y]: [f64; 2], y_lum: f64) -> Self {
        Self::new(x / y * y_lum, y_lum, (1.0 - x - y) / y * y_lum)
    }

    /// (x, y), or `None` for black.
    pub fn chromaticity(self) -> Option<[f64; 2]> {
        let sum = self.x + self.y + self.z;
        (sum > 0.0).then(|| [self.x / sum, self.y / sum])
    }

    /// CIE 1976 (u′, v′), or `None` for black.
    pub fn uv_prime(self) -> Option<[f64; 2]> {
        let sum = self.x + 15.0 * self.y + 3.0 * self.z;
        (sum > 0.0).then(|| [4.0 * self.x / sum, 9.0 * self.y / sum])
    }

    /// Whether no value is infinite or NaN.
    pub fn is_finite(self) -> bool {
        self.x.is_finite() && self.y.is_finite() && self.z.is_finite()
    }
}

impl Spectrum {
    /// Tristimulus values (eq. 4) on the 5 nm grid.
    pub fn xyz(&self) -> Xyz {
        let grid = WavelengthGrid::Step5;
        Xyz::from_bands(grid, &self.light_on_grid(grid))
    }
}

impl Add for Xyz {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::new(self.x + other.x, self.y + other.y, self.z + other.z)
    }
}

impl Sub for Xyz {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self::new(self.x - other.x, self.y - other.y, self.z - other.z)
    }
}

impl Mul<f64> for Xyz {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        Self::new(self.x * factor, self.y * factor, self.z * factor)
    }
}

impl From<[f64; 3]> for Xyz {
    fn from([x, y, z]: [f64; 3]) -> Self {
        Self::new(x, y, z)
    }
}

impl From<Xyz> for [f64; 3] {
    fn from(c: Xyz) -> Self {
        [c.x, c.y, c.z]
    }
}

impl From<DVec3> for Xyz {
    fn from(v: DVec3) -> Self {
        Self::new(v.x, v.y, v.z)
    }
}

impl From<Xyz> for DVec3 {
    fn from(c: Xyz) -> Self {
        DVec3::new(c.x, c.y, c.z)
    }
}

/// Linear RGB to XYZ for primaries and white of these chromaticities; RGB (1, 1, 1) has Y = 1.
///
/// Shape: columns are the primaries. Source: CIE 15; the primaries' luminances are those whose
/// sum is the white.
pub fn xyz_from_primaries(primaries: [[f64; 2]; 3], white: [f64; 2]) -> DMat3 {
    let [r, g, b] = primaries.map(|xy| DVec3::from(Xyz::from_xy(xy, 1.0)));
    let unit_luminance = DMat3::from_cols(r, g, b);
    let luminances = unit_luminance.inverse() * DVec3::from(Xyz::from_xy(white, 1.0));
    unit_luminance * DMat3::from_diagonal(luminances)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_energy_has_equal_tristimulus_values() {
        let bands = vec![1.0; 81];
        let [x, y] = Xyz::from_bands(WavelengthGrid::Step5, &bands).chromaticity().unwrap();
        // The CMFs are normalized to this at 1 nm; their 5 nm sums differ by less than 1e-5.
        assert!((x - 1.0 / 3.0).abs() < 2e-5 && (y - 1.0 / 3.0).abs() < 2e-5, "{x} {y}");
    }

    #[test]
    fn one_watt_at_555_nm_is_683_lm() {
        for (grid, band, v_lambda) in [
            (WavelengthGrid::Step5, 35, 1.0),
            (WavelengthGrid::Step10, 18, 0.995),
            (WavelengthGrid::Step20, 9, 0.995),
        ] {
            let mut bands = vec![0.0; grid.bands()];
            bands[band] = 1.0 / grid.step_nm();
            let y = Xyz::from_bands(grid, &bands).y;
            assert!((y - 683.0 * v_lambda).abs() < 1e-9, "{grid:?}: {y}");
        }
    }

    #[test]
    fn uv_prime_of_d65() {
        // CIE 15: D65 has u′ = 0.1978, v′ = 0.4683.
        let [u, v] = Xyz::from_xy([0.31272, 0.32903], 100.0).uv_prime().unwrap();
        assert!((u - 0.1978).abs() < 5e-5 && (v - 0.4683).abs() < 5e-5, "{u} {v}");
    }

    #[test]
    fn black_has_no_chromaticity() {
        assert_eq!(Xyz::default().chromaticity(), None);
        assert_eq!(Xyz::default().uv_prime(), None);
    }
}
