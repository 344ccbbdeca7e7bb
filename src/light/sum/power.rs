//! The lobes of a material as the kernels take them.

use std::f64::consts::PI;

use super::Photometry;
use crate::material::Lobes;

/// weight · cosⁿ.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Power {
    pub weight: f32,
    pub exponent: f32,
    /// The exponent where it is a small integer: squarings are cheaper than exp and ln.
    pub integer: Option<u32>,
}

impl Power {
    fn new(weight: f64, exponent: f64) -> Power {
        let is_small_integer = exponent.fract() == 0.0 && (1.0..=64.0).contains(&exponent);
        let integer = is_small_integer.then_some(exponent as u32);
        Power { weight: weight as f32, exponent: exponent as f32, integer }
    }
}

/// A material's lobes with the photometry's normalization folded into the weights.
#[derive(Debug, Clone)]
pub(crate) struct LobeSet {
    pub diffuse: Power,
    /// Those with k_s > 0.
    pub specular: Vec<Power>,
    pub largest_exponent: f64,
    /// Infinite without specular lobes.
    pub smallest_specular: f64,
    /// The same in f64: (weight, exponent).
    pub exact_diffuse: (f64, f64),
    pub exact_specular: Vec<(f64, f64)>,
}

/// Diffuse exponents whose cosines f32 cannot hold to 1e-3.
const LARGEST_F32_DIFFUSE: f64 = 1000.0;

impl LobeSet {
    pub fn new(lobes: &Lobes, photometry: Photometry) -> LobeSet {
        let absolute = photometry == Photometry::Absolute;
        let k_d = if absolute { lobes.k_d / PI } else { lobes.k_d };
        let normalized = |k: f64, n: f64| if absolute { k * (n + 2.0) / (2.0 * PI) } else { k };
        let exact_specular: Vec<(f64, f64)> = lobes
            .specular
            .iter()
            .filter(|lobe| lobe.k_s > 0.0)
            .map(|lobe| (normalized(lobe.k_s, lobe.n_s), lobe.n_s))
            .collect();
        let exponents = exact_specular.iter().map(|lobe| lobe.1);
        LobeSet {
            diffuse: Power::new(k_d, lobes.n_d),
            specular: exact_specular.iter().map(|&(k, n)| Power::new(k, n)).collect(),
            largest_exponent: exponents.clone().fold(1.0, f64::max),
            smallest_specular: exponents.fold(f64::INFINITY, f64::min),
            exact_diffuse: (k_d, lobes.n_d),
            exact_specular,
        }
    }

    pub fn diffuse_needs_f64(&self) -> bool {
        self.exact_diffuse.0 > 0.0 && self.exact_diffuse.1 > LARGEST_F32_DIFFUSE
    }

    /// Σ k of all lobes: the most that a sample of unit emission can add.
    pub fn total_weight(&self) -> f64 {
        self.exact_diffuse.0 + self.exact_specular.iter().map(|lobe| lobe.0).sum::<f64>()
    }
}
