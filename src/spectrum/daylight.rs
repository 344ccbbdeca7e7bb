//! Daylight by its color temperature, and the sun's spectrum through the air.

use super::{Spectrum, WavelengthGrid};

/// S₀, S₁, S₂ from 380 nm in steps of 10 nm. Source: CIE 15:2004, table T.2.
const COMPONENTS: [[f64; 3]; 41] = [
    [63.4, 38.5, 3.0],
    [65.8, 35.0, 1.2],
    [94.8, 43.4, -1.1],
    [104.8, 46.3, -0.5],
    [105.9, 43.9, -0.7],
    [96.8, 37.1, -1.2],
    [113.9, 36.7, -2.6],
    [125.6, 35.9, -2.9],
    [125.5, 32.6, -2.8],
    [121.3, 27.9, -2.6],
    [121.3, 24.3, -2.6],
    [113.5, 20.1, -1.8],
    [113.1, 16.2, -1.5],
    [110.8, 13.2, -1.3],
    [106.5, 8.6, -1.2],
    [108.8, 6.1, -1.0],
    [105.3, 4.2, -0.5],
    [104.4, 1.9, -0.3],
    [100.0, 0.0, 0.0],
    [96.0, -1.6, 0.2],
    [95.1, -3.5, 0.5],
    [89.1, -3.5, 2.1],
    [90.5, -5.8, 3.2],
    [90.3, -7.2, 4.1],
    [88.4, -8.6, 4.7],
    [84.0, -9.5, 5.1],
    [85.1, -10.9, 6.7],
    [81.9, -10.7, 7.3],
    [82.6, -12.0, 8.6],
    [84.9, -14.0, 9.8],
    [81.3, -13.6, 10.2],
    [71.9, -12.0, 8.3],
    [74.3, -13.3, 9.6],
    [76.4, -12.9, 8.5],
    [63.3, -10.6, 7.0],
    [71.7, -11.6, 7.6],
    [77.0, -12.2, 8.0],
    [65.2, -10.2, 6.7],
    [47.7, -7.8, 5.2],
    [68.6, -11.2, 7.4],
    [65.0, -10.4, 6.8],
];

/// Correlated color temperatures that the D series is defined for, K.
pub const DAYLIGHT_RANGE_K: [f64; 2] = [4000.0, 25_000.0];

impl Spectrum {
    /// CIE daylight of correlated color temperature `cct_k` ([`DAYLIGHT_RANGE_K`]), 1 at 560 nm.
    ///
    /// Source: CIE 15:2004, 3.1.3. D65 is at 6504 K: its name is from before c₂ was revised.
    pub fn daylight(cct_k: f64) -> Self {
        let [x, y] = daylight_chromaticity(cct_k);
        let m = 0.0241 + 0.2562 * x - 0.7341 * y;
        let m1 = (-1.3515 - 1.7703 * x + 5.9114 * y) / m;
        let m2 = (0.0300 - 31.4424 * x + 30.0717 * y) / m;
        let row = |(step, [s0, s1, s2]): (usize, &[f64; 3])| {
            (WavelengthGrid::FIRST_NM + 10.0 * step as f64, (s0 + m1 * s1 + m2 * s2) / 100.0)
        };
        let (lambda_nm, values) = COMPONENTS.iter().enumerate().map(row).unzip();
        Self::from_sorted(lambda_nm, values)
    }

    /// The sun's, relative, 1 at 560 nm, through `air_mass` of clear air and haze of optical depth
    /// `haze_550` at 550 nm.
    ///
    /// A black body of 5772 K (IAU 2015), Rayleigh's optical depth 0.008735 λ^−4.08 (λ in μm;
    /// Leckner 1978), and Ångström's, with the exponent 1.3 of an average haze.
    pub fn sunlight(air_mass: f64, haze_550: f64) -> Self {
        let outside = Self::blackbody(5772.0);
        let optical_depth = |lambda_nm: f64| {
            let rayleigh = 0.008735 * (lambda_nm * 1e-3).powf(-4.08);
            rayleigh + haze_550 * (lambda_nm / 550.0).powf(-1.3)
        };
        outside
            .mapped(|lambda_nm, value| {
                let excess = optical_depth(lambda_nm) - optical_depth(560.0);
                value * (-air_mass * excess).exp()
            })
            .normalized_at(560.0)
    }
}

/// (x, y) on the daylight locus.
fn daylight_chromaticity(cct_k: f64) -> [f64; 2] {
    let t = 1e3 / cct_k;
    let x = if cct_k <= 7000.0 {
        0.244063 + t * (0.09911 + t * (2.9678 - t * 4.6070))
    } else {
        0.237040 + t * (0.24748 + t * (1.9018 - t * 2.0064))
    };
    [x, -3.000 * x * x + 2.870 * x - 0.275]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::cie;

    /// The published D65 is this at 6500 K · 1.4388/1.4380, with M₁ and M₂ rounded to three
    /// decimals, hence 2e-3 of its largest value.
    #[test]
    fn d65_is_the_published_one() {
        let d65 = cie::illuminant("D65").unwrap();
        let here = Spectrum::daylight(6500.0 * 1.4388 / 1.4380);
        for lambda_nm in WavelengthGrid::Step5.wavelengths_nm() {
            let difference = here.at(lambda_nm) - d65.at(lambda_nm);
            assert!(difference.abs() < 2e-3, "{lambda_nm} nm: {difference}");
        }
    }

    /// What a spectrum's name says is where it lies: CIE 15 gives D50, D55 and D75.
    #[test]
    fn chromaticities_are_the_published_ones() {
        for (cct_k, x, y) in
            [(5003.0, 0.34567, 0.35851), (5503.0, 0.33243, 0.34744), (7504.0, 0.29903, 0.31488)]
        {
            let [cx, cy] = Spectrum::daylight(cct_k).xyz().chromaticity().unwrap();
            assert!((cx - x).abs() < 3e-4 && (cy - y).abs() < 3e-4, "{cct_k}: {cx} {cy}");
        }
    }

    /// A swapped digit shows as a kink.
    #[test]
    fn components_are_within_their_range() {
        for (column, bound) in [(0, 75.0), (1, 18.0), (2, 7.0)] {
            for w in COMPONENTS.windows(4) {
                let d = w[3][column] - 3.0 * w[2][column] + 3.0 * w[1][column] - w[0][column];
                assert!(d.abs() < bound, "S{column}: {d}");
            }
        }
    }

    #[test]
    fn a_low_sun_is_red() {
        let x = |air_mass| Spectrum::sunlight(air_mass, 0.2).xyz().chromaticity().unwrap()[0];
        assert!((0.32..0.36).contains(&x(1.0)), "{}", x(1.0));
        assert!(x(10.0) > 0.45 && x(38.0) > 0.6, "{} {}", x(10.0), x(38.0));
    }
}
