//! Linear Rec. 709 from XYZ, and the sRGB curve.

use std::sync::LazyLock;

use glam::{DMat3, DVec3};

use super::{Xyz, xyz_from_primaries};

/// White of Rec. 709 and sRGB.
pub const D65_XY: [f64; 2] = [0.3127, 0.3290];

/// ITU-R BT.709-6, item 1.3.
pub const REC709_XY: [[f64; 2]; 3] = [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]];

/// The primaries of Display P3. Source: SMPTE EG 432-1.
pub const P3_XY: [[f64; 2]; 3] = [[0.68, 0.32], [0.265, 0.69], [0.15, 0.06]];

static XYZ_FROM_RGB: LazyLock<DMat3> = LazyLock::new(|| xyz_from_primaries(REC709_XY, D65_XY));
static RGB_FROM_XYZ: LazyLock<DMat3> = LazyLock::new(|| XYZ_FROM_RGB.inverse());

/// Linear Rec. 709, unclipped; D65 of Y = 1 is (1, 1, 1).
pub fn rec709_from_xyz(color: Xyz) -> [f64; 3] {
    (*RGB_FROM_XYZ * DVec3::from(color)).to_array()
}

/// The color of linear Rec. 709 values; (1, 1, 1) is D65 of Y = 1.
pub fn xyz_from_rec709(rgb: [f64; 3]) -> Xyz {
    (*XYZ_FROM_RGB * DVec3::from_array(rgb)).into()
}

/// The sRGB signal, 0 to 1, of a linear value, 0 to 1. Source: IEC 61966-2-1.
pub fn srgb_encode(linear: f64) -> f64 {
    if linear <= 0.0031308 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// Inverse of [`srgb_encode`].
pub fn srgb_decode(signal: f64) -> f64 {
    if signal <= 0.04045 { signal / 12.92 } else { ((signal + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matrix_is_the_published_one() {
        // IEC 61966-2-1 prints four decimals.
        let published =
            [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]];
        for (r, row) in published.iter().enumerate() {
            for (c, value) in row.iter().enumerate() {
                // Its matrix comes from rounded forward values, hence 4e-4 and not 5e-5.
                assert!((RGB_FROM_XYZ.row(r)[c] - value).abs() < 4e-4);
            }
        }
    }

    #[test]
    fn white_is_one_and_back() {
        let white = xyz_from_rec709([1.0; 3]);
        assert!((white.y - 1.0).abs() < 1e-15);
        let [x, y] = white.chromaticity().unwrap();
        assert!((x - 0.3127).abs() < 1e-15 && (y - 0.3290).abs() < 1e-15);
        assert!(rec709_from_xyz(white).iter().all(|v| (v - 1.0).abs() < 1e-14));
    }

    #[test]
    fn encode_inverts_decode_for_every_digit() {
        for digit in 0..=255 {
            let signal = f64::from(digit) / 255.0;
            assert!((srgb_encode(srgb_decode(signal)) - signal).abs() < 1e-6);
        }
        assert!((srgb_encode(0.18) - 0.461356).abs() < 1e-6);
    }
}
