//! Eq. 9 as it stands, sample by sample in f64: what the kernels and the tree are tested against.

use std::f64::consts::PI;

use glam::DVec3;

use super::power::half_lobe_return;
use super::{HitQuery, LightSum, Photometry, Side};
use crate::light::RaySet;
use crate::material::Lobes;

/// The sum over all samples of `set`, exact but for f64 rounding.
///
/// A sample at the hit point itself has no direction and contributes nothing.
/// Source: model.md, eq. 2 and 9, "Two photometries".
pub fn reference_sum(
    set: &RaySet,
    query: &HitQuery,
    visible: Option<&dyn Fn(DVec3) -> bool>,
) -> LightSum {
    let mut sum = LightSum::default();
    let sides = (Side::reflected(query), Side::transmitted(query));
    for sample in set.samples.iter() {
        let (position, direction) = (set.world_origin(sample), set.world_direction(sample));
        let to_light = position - query.point;
        let (l, r) = (to_light.normalize_or_zero(), to_light.length());
        let emission = match set.exponent {
            1.0 => (-l.dot(direction)).max(0.0),
            exponent => cos_pow(direction, -l, exponent),
        };
        let emitted = f64::from(sample.flux) * emission;
        let cos = l.dot(query.normal);
        let asked = (cos > 0.0 && query.reflects) || (cos < 0.0 && query.transmits);
        if emitted == 0.0 || !asked || visible.is_some_and(|free| !free(position)) {
            continue;
        }
        let side = if cos > 0.0 { &sides.0 } else { &sides.1 };
        let value = emitted * scattered(side, query.lobes, query.photometry, l)
            / distance_factor(query.photometry, r);
        let target = if cos > 0.0 { &mut sum.reflected } else { &mut sum.transmitted };
        *target += value;
    }
    let lm_per_flux = set.lm_per_flux() * 0.5 * (set.exponent + 1.0);
    sum.reflected *= lm_per_flux;
    sum.transmitted *= lm_per_flux;
    sum.samples = u32::try_from(set.samples.len()).unwrap_or(u32::MAX);
    sum
}

fn scattered(side: &Side, lobes: &Lobes, photometry: Photometry, l: DVec3) -> f64 {
    let mut sum = 0.0;
    if lobes.k_d > 0.0 {
        let norm = if photometry == Photometry::Absolute { 1.0 / PI } else { 1.0 };
        sum += lobes.k_d * norm * cos_pow(side.normal, l, lobes.n_d);
    }
    for lobe in &lobes.specular {
        let absolute = photometry == Photometry::Absolute;
        if side.is_half {
            let (n, cos_view) = (4.0 * lobe.n_s, side.cos_view().max(1e-6));
            let share = cos_view * half_lobe_return(cos_view, n).max(1.0);
            let norm = if absolute { (n + 2.0) / (8.0 * PI * share) } else { 1.0 };
            sum += lobe.k_s * norm * cos_pow(side.normal, (l + side.view()).normalize(), n);
            continue;
        }
        let norm = if absolute { (lobe.n_s + 2.0) / (2.0 * PI) } else { 1.0 };
        sum += lobe.k_s * norm * cos_pow(side.axis, l, lobe.n_s);
    }
    sum
}

/// max(0, a·b)ⁿ of unit vectors, by 1 − cos, which keeps its digits near 1 (model.md, "Accuracy").
fn cos_pow(a: DVec3, b: DVec3, n: f64) -> f64 {
    let versine = 0.5 * (a - b).length_squared();
    if versine >= 1.0 { 0.0 } else { (n * (-versine).ln_1p()).exp() }
}

fn distance_factor(photometry: Photometry, r_mm: f64) -> f64 {
    match photometry {
        Photometry::Relative => 1.0,
        Photometry::Absolute => PI * (r_mm * 1e-3).powi(2),
    }
}
