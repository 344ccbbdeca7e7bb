//! Planck's law.

use super::{Spectrum, WavelengthGrid};

/// Second radiation constant c₂ = hc/k, m K (CODATA 2018, exact).
const C2_M_K: f64 = 1.438_776_877e-2;

impl Spectrum {
    /// Planck radiator at `temperature_k` (100 to 10⁹), normalized to 1 at 560 nm, at the 5 nm bands.
    pub fn blackbody(temperature_k: f64) -> Self {
        let rows = WavelengthGrid::Step5
            .wavelengths_nm()
            .map(|lambda_nm| (lambda_nm, planck_relative(lambda_nm, temperature_k)));
        let (lambda_nm, values) = rows.unzip();
        Self::from_sorted(lambda_nm, values).into_light()
    }
}

/// B(λ, T) / B(560 nm, T), formed so that neither radiance nor its exponent can overflow.
fn planck_relative(lambda_nm: f64, temperature_k: f64) -> f64 {
    let exponent = |nm: f64| C2_M_K / (nm * 1e-9 * temperature_k);
    let (x, x0) = (exponent(lambda_nm), exponent(560.0));
    // (e^x0 − 1)/(e^x − 1) = e^(x0 − x) (1 − e^−x0)/(1 − e^−x)
    (560.0 / lambda_nm).powi(5) * (x0 - x).exp() * (-x0).exp_m1() / (-x).exp_m1()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::cie;

    /// CIE 15 defines A by Planck's formula with c₂ = 1.435e-2 at 2848 K, which is 2855.5 K with
    /// today's c₂; the table has six digits.
    #[test]
    fn illuminant_a_is_a_blackbody() {
        let a = cie::illuminant("A").unwrap();
        let planck = Spectrum::blackbody(2848.0 * 1.438_776_877 / 1.435);
        for lambda_nm in WavelengthGrid::Step5.wavelengths_nm() {
            let ratio = planck.at(lambda_nm) / a.at(lambda_nm);
            assert!((ratio - 1.0).abs() < 1e-4, "{lambda_nm} nm: {ratio}");
        }
    }

    #[test]
    fn extreme_temperatures_stay_finite() {
        for temperature_k in [100.0, 1e3, 1e6, 1e9] {
            assert!(Spectrum::blackbody(temperature_k).values().iter().all(|v| v.is_finite()));
        }
    }
}
