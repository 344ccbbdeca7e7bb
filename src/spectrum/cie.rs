//! CIE 1931 2° color-matching functions and standard illuminants, embedded from `data/cie`.
//!
//! V(λ) of eq. 12 is ȳ(λ): the two tables agree in every digit at 5 nm.

use std::sync::LazyLock;

use super::{Spectrum, WavelengthGrid};
use crate::columns::built_in_rows;

/// Maximum luminous efficacy K of eq. 4 and 12, lm/W.
pub const K_LM_PER_W: f64 = 683.0;

const CMF_CSV: &str = include_str!("../../data/cie/cie1931_2deg_cmf_5nm_380_780.csv");
const ILLUMINANT_A_CSV: &str = include_str!("../../data/cie/cie_illuminant_A_5nm_380_780.csv");
const ILLUMINANT_D65_CSV: &str = include_str!("../../data/cie/cie_illuminant_D65_5nm_380_780.csv");

/// x̄, ȳ, z̄ at the 81 bands of the 5 nm grid.
static CMF: LazyLock<Vec<[f64; 3]>> =
    LazyLock::new(|| built_in_rows(CMF_CSV).map(|(_, row)| [row[1], row[2], row[3]]).collect());

/// x̄, ȳ, z̄ at a band of `grid`; every grid's bands are bands of the 5 nm grid.
pub fn cmf(grid: WavelengthGrid, band: usize) -> [f64; 3] {
    let stride = (grid.step_nm() / WavelengthGrid::Step5.step_nm()) as usize;
    CMF[band * stride]
}

/// 683 Σ S V Δλ of values at the bands of `grid`.
pub fn luminous(grid: WavelengthGrid, bands: &[f64]) -> f64 {
    let sum: f64 = bands.iter().enumerate().map(|(b, value)| value * cmf(grid, b)[1]).sum();
    K_LM_PER_W * sum * grid.step_nm()
}

/// V(λ) as a spectrum, linear between the 5 nm rows, and 0 outside of 380 to 780 nm.
pub fn v_lambda(lambda_nm: f64) -> f64 {
    let grid = WavelengthGrid::Step5;
    let place = (lambda_nm - WavelengthGrid::FIRST_NM) / grid.step_nm();
    if !(0.0..=(grid.bands() - 1) as f64).contains(&place) {
        return 0.0;
    }
    let band = (place as usize).min(grid.bands() - 2);
    let t = place - band as f64;
    CMF[band][1] * (1.0 - t) + CMF[band + 1][1] * t
}

/// A standard illuminant by its name, relative, 1 at 560 nm.
pub fn illuminant(name: &str) -> Option<Spectrum> {
    let csv = match name {
        "A" => ILLUMINANT_A_CSV,
        "D65" => ILLUMINANT_D65_CSV,
        "E" => return Some(Spectrum::constant(1.0).into_light()),
        _ => return None,
    };
    let rows = built_in_rows(csv).map(|(_, row)| (row[0], row[1]));
    Spectrum::from_pairs(name, rows).ok().map(|s| s.normalized_at(560.0).into_light())
}

/// Names that [`illuminant`] knows.
pub const ILLUMINANTS: [&str; 3] = ["A", "D65", "E"];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_have_every_band() {
        assert_eq!(CMF.len(), 81);
        for name in ILLUMINANTS {
            assert_eq!(illuminant(name).unwrap().at(560.0), 1.0);
        }
        assert_eq!(cmf(WavelengthGrid::Step20, 20), CMF[80]);
    }

    /// A swapped digit shows as a kink. The true table's largest third differences are x̄ 0.0349,
    /// ȳ 0.0152, z̄ 0.1661.
    #[test]
    fn third_differences_are_smooth() {
        for (component, bound) in [(0, 0.036), (1, 0.016), (2, 0.17)] {
            for w in CMF.windows(4) {
                let d = w[3][component] - 3.0 * w[2][component] + 3.0 * w[1][component]
                    - w[0][component];
                assert!(d.abs() < bound, "component {component}: {d}");
            }
        }
    }

    #[test]
    fn illuminants_have_their_published_chromaticity() {
        // CIE 15: A (0.44758, 0.40745), D65 (0.31272, 0.32903) to the rounding of 5 nm sums.
        for (name, x, y) in [("A", 0.44758, 0.40745), ("D65", 0.31272, 0.32903)] {
            let [cx, cy] = illuminant(name).unwrap().xyz().chromaticity().unwrap();
            assert!((cx - x).abs() < 5e-5 && (cy - y).abs() < 5e-5, "{name}: {cx} {cy}");
        }
    }
}
