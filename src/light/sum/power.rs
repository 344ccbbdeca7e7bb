//! The lobes of a material as the kernels take them.

use std::f64::consts::PI;

use super::{Photometry, Side};
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

/// (weight, exponent) of `share` of a side's specular lobes, normalized; the exponent is the cosine's
/// that [`Side::specular`] takes to it.
pub(crate) fn specular_powers(
    lobes: &Lobes,
    photometry: Photometry,
    (side, share): (&Side, f64),
) -> Vec<(f64, f64)> {
    let absolute = photometry == Photometry::Absolute;
    let cos_view = side.cos_view().max(GRAZING);
    let power = |k: f64, n: f64| match (side.is_half, absolute) {
        (false, false) => (k, n),
        (false, true) => (k * (n + 2.0) / (2.0 * PI), n),
        (true, false) => (k, 4.0 * n),
        (true, true) => {
            let returned = half_lobe_return(cos_view, 4.0 * n).max(1.0);
            (k * (4.0 * n + 2.0) / (2.0 * PI) / (4.0 * cos_view * returned), 4.0 * n)
        }
    };
    let shining = lobes.specular.iter().filter(|lobe| lobe.k_s > 0.0);
    shining.map(|lobe| power(share * lobe.k_s, lobe.n_s)).collect()
}

/// Nearer to grazing, N·V is taken for this, so that weights stay finite.
const GRAZING: f64 = 1e-6;

/// What a half-vector lobe of k_s = 1 returns of an even light all around.
///
/// It has no masking, so that wide lobes would return more than arrives at grazing angles: n = 20
/// does from 82° on, n = 1500 from 89° on. There the lobe is divided by this. It is
/// ∫ D(H) (V·H)/(N·V) over the H whose L is above the horizon: closed in the azimuth of H, and the
/// midpoint rule in the root of cos^(exponent + 2) of its other angle.
pub(crate) fn half_lobe_return(cos_view: f64, exponent: f64) -> f64 {
    const STEPS: usize = 64;
    let sin_view = (1.0 - cos_view * cos_view).max(0.0).sqrt();
    // Four widths of the lobe above the horizon.
    if sin_view * sin_view <= 0.06 * exponent * cos_view * cos_view {
        return 1.0;
    }
    let at = |step: usize| {
        let x = (step as f64 + 0.5) / STEPS as f64;
        let cos = (x * x).powf(1.0 / (exponent + 2.0));
        let (height, width) = (cos_view * cos, sin_view * (1.0 - cos * cos).sqrt());
        let edge = (0.5 * cos_view / cos - height) / width.max(f64::MIN_POSITIVE);
        let azimuth = edge.clamp(-1.0, 1.0).acos();
        2.0 * x * (width * azimuth.sin() + height * azimuth) / (PI * cos * cos_view)
    };
    (0..STEPS).map(at).sum::<f64>() / STEPS as f64
}

/// A material's lobes with the photometry's normalization folded into the weights.
#[derive(Debug, Clone)]
pub(crate) struct LobeSet {
    pub diffuse: Power,
    /// Those with k_s > 0.
    pub specular: Vec<Power>,
    /// Exponent of the sharpest lobe in any direction, as that of a lobe about its axis.
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
    pub fn new(lobes: &Lobes, photometry: Photometry, side: &Side) -> LobeSet {
        let absolute = photometry == Photometry::Absolute;
        let k_d = if absolute { lobes.k_d / PI } else { lobes.k_d };
        let exact_specular = specular_powers(lobes, photometry, (side, 1.0));
        let exponents = exact_specular.iter().map(|lobe| lobe.1);
        // H turns by up to 1/(N·V) of L.
        let sharpening = if side.is_half { side.cos_view().max(GRAZING).powi(-2) } else { 1.0 };
        LobeSet {
            diffuse: Power::new(k_d, lobes.n_d),
            specular: exact_specular.iter().map(|&(k, n)| Power::new(k, n)).collect(),
            largest_exponent: exponents.clone().map(|n| n * sharpening).fold(1.0, f64::max),
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
