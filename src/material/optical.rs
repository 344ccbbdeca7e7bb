//! Measured optical constants that come with the program.

use crate::spectrum::Spectrum;

/// The complex index n + ik of a material, by wavelength.
#[derive(Debug, Clone, PartialEq)]
pub struct OpticalConstants {
    /// The index.
    pub n: Spectrum,
    /// The extinction coefficient: an internal transmittance of exp(−4π k d/λ) over a path d.
    pub k: Spectrum,
}

impl OpticalConstants {
    /// Evaporated aluminium, as in lamp reflectors (McPeak et al. 2015); origin in
    /// `data/README.md`.
    pub fn aluminium() -> Self {
        let text = include_str!("../../data/materials/aluminium_mcpeak2015.csv");
        Self { n: Spectrum::built_in(text, 2), k: Spectrum::built_in(text, 3) }
    }

    /// Clear PMMA at 20 °C (n: Beadie et al. 2015, k: Zhang et al. 2020); origin in
    /// `data/README.md`.
    pub fn pmma() -> Self {
        let text = include_str!("../../data/materials/pmma_beadie2015_zhang2020.csv");
        Self { n: Spectrum::built_in(text, 1), k: Spectrum::built_in(text, 2) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::metal_reflectance;

    /// The reflectance that the table gives beside n and k; 0.9157 at 550 nm.
    #[test]
    fn aluminium_is_its_table() {
        let OpticalConstants { n, k } = OpticalConstants::aluminium();
        let table =
            Spectrum::built_in(include_str!("../../data/materials/aluminium_mcpeak2015.csv"), 1);
        assert_eq!((n.values().len(), k.values().len(), table.values().len()), (81, 81, 81));
        for lambda_nm in (380..=780).step_by(5).map(f64::from) {
            let r = metal_reflectance(1.0, 1.0, [n.at(lambda_nm), k.at(lambda_nm)]);
            assert!((r - table.at(lambda_nm)).abs() < 1e-6, "{lambda_nm}: {r}");
        }
        assert!((table.at(550.0) - 0.9157).abs() < 1e-4);
    }

    /// Beadie's formula at the C, d and F lines.
    #[test]
    fn pmma_follows_its_formula() {
        let OpticalConstants { n, k } = OpticalConstants::pmma();
        let formula = |lambda_nm: f64| {
            let l2 = (lambda_nm * 1e-3).powi(2);
            let up = 2.1778 + 6.1209e-3 * l2 - 1.5004e-3 * l2 * l2;
            let down = 2.3678e-2 / l2 - 4.2137e-3 / (l2 * l2);
            (up + down + 7.3417e-4 / l2.powi(3) - 4.5042e-5 / l2.powi(4)).sqrt()
        };
        for lambda_nm in [656.27, 587.56, 486.13] {
            let found = n.at(lambda_nm);
            assert!((found - formula(lambda_nm)).abs() < 1e-5, "{lambda_nm}: {found}");
        }
        assert_eq!(k.values().len(), 81);
        assert!(k.min() > 1e-7 && k.max() < 1e-6);
    }
}
