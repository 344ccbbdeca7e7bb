//! The light of a hot tungsten wire.

use std::sync::LazyLock;

use crate::columns::built_in_rows;
use crate::spectrum::Spectrum;

const EMISSIVITY_CSV: &str =
    include_str!("../../data/materials/tungsten_emissivity_pon_hessler_coeffs.csv");

/// One wavelength interval of the fit.
struct EmissivityInterval {
    last_nm: f64,
    /// λ₀, a₀, a₁, b₀, b₁, b₂, c₀, c₁.
    coefficients: [f64; 8],
}

static INTERVALS: LazyLock<Vec<EmissivityInterval>> = LazyLock::new(|| {
    let interval = |(_, row): (&str, Vec<f64>)| EmissivityInterval {
        last_nm: row[1],
        coefficients: std::array::from_fn(|k| row[k + 2]),
    };
    built_in_rows(EMISSIVITY_CSV).map(interval).collect()
});

/// Normal spectral emissivity of tungsten, for 340 to 940 nm; the ends are held outside of that.
///
/// Source: R. M. Pon and J. P. Hessler, "Spectral emissivity of tungsten: analytic expressions for
/// the 340-nm to 2.6-µm spectral region", Appl. Opt. 23, 975 (1984).
pub fn emissivity(lambda_nm: f64, temperature_k: f64) -> f64 {
    let lambda_nm = lambda_nm.clamp(340.0, 940.0);
    let interval = INTERVALS.iter().find(|i| lambda_nm <= i.last_nm);
    let Some(EmissivityInterval { coefficients: [l0, a0, a1, b0, b1, b2, c0, c1], .. }) = interval
    else {
        return 0.0;
    };
    let t = (temperature_k - 2200.0) / 1000.0;
    let l = lambda_nm / 1000.0 - l0;
    a0 + a1 * t + (b0 + b1 * t + b2 * t * t) * l + (c0 + c1 * t) * l * l
}

/// Planck × emissivity at the wire's true temperature, 1 at 560 nm.
///
/// Unit: relative. The color temperature is higher, by 59 K at 2750 K.
pub fn spectrum(temperature_k: f64) -> Spectrum {
    Spectrum::blackbody(temperature_k)
        .mapped(|lambda_nm, planck| planck * emissivity(lambda_nm, temperature_k))
        .normalized_at(560.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::columns::TableChoice;
    use std::path::Path;

    /// NASA TN D-1088 (1961), Table III, interpolated between 2000 and 4000 K; another laboratory's
    /// measurement (de Vos, corrected by Larrabee): the two agree within 0.013.
    #[test]
    fn emissivity_agrees_with_de_vos() {
        for (lambda_nm, at_2000_k, at_4000_k) in [
            (400.0, 0.4628, 0.4344),
            (500.0, 0.4518, 0.4221),
            (600.0, 0.4398, 0.4100),
            (700.0, 0.4296, 0.3916),
            (800.0, 0.4153, 0.3745),
        ] {
            for temperature_k in [2000.0, 2400.0, 2800.0] {
                let share = (temperature_k - 2000.0) / 2000.0;
                let expected = at_2000_k + share * (at_4000_k - at_2000_k);
                let got = emissivity(lambda_nm, temperature_k);
                assert!((got - expected).abs() < 0.013, "{lambda_nm}, {temperature_k}: {got}");
            }
        }
    }

    /// The intervals of the fit were made one by one: they meet to 0.003.
    #[test]
    fn emissivity_has_no_jumps() {
        for edge_nm in [420.0, 480.0, 580.0, 640.0, 760.0] {
            let jump = emissivity(edge_nm + 1e-6, 2800.0) - emissivity(edge_nm, 2800.0);
            assert!(jump.abs() < 0.003, "{edge_nm}: {jump}");
        }
    }

    /// A measured lamp of 2812 K color temperature, which a wire of 2750 K has: rms 2.1 %, 12 %
    /// at 400 nm, where the measurement holds 0.12 of its value at 560 nm.
    #[test]
    fn spectrum_is_that_of_a_measured_lamp() {
        let path =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("data/lamps/incandescent_nist_cqs_5nm.csv");
        let measured = Spectrum::load(&path, &TableChoice::default()).unwrap();
        let model = spectrum(2750.0);
        let errors: Vec<f64> = (80..=156)
            .map(|k| f64::from(k) * 5.0)
            .map(|lambda_nm| model.at(lambda_nm) / measured.at(lambda_nm) - 1.0)
            .collect();
        let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
        assert!(rms < 0.025 && errors.iter().all(|e| e.abs() < 0.13), "{rms}");
    }
}
