//! What a hit asks of a light source, the answer (eq. 2 and 9), and the plain f64 sum.

mod reference;
mod side;

pub use reference::reference_sum;
pub(crate) use side::Side;

use glam::DVec3;

use crate::material::Lobes;

/// Which of model.md's two photometries a scene uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Photometry {
    /// Eq. 2 and 9 as they stand: Σ Φ_i c_i (k_d g_d + k_s g_s).
    Relative,
    /// Σ Φ_i c_i / (π r²) (k_d/π g_d + k_s (n_s + 2)/(2π) g_s), r in metres.
    Absolute,
}

/// The side of eq. 2 that does not depend on the light sample.
#[derive(Debug, Clone, Copy)]
pub struct HitQuery<'a> {
    /// P, mm.
    pub point: DVec3,
    /// N of eq. 3, unit, on V's side.
    pub normal: DVec3,
    /// V, unit, from P to where the ray came from.
    pub view: DVec3,
    pub lobes: &'a Lobes,
    pub photometry: Photometry,
    /// Sum the samples on the viewer's side (L·N > 0), lobe about the mirror direction.
    pub reflects: bool,
    /// Sum the samples on the far side (L·N < 0), lobe about −V.
    pub transmits: bool,
}

/// The sums of eq. 9 without spectra: multiply by I_norm(λ) F(λ) / (K Σ I_norm V Δλ).
///
/// Unit: lm (relative), lm m⁻² sr⁻¹ (absolute).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct LightSum {
    pub reflected: f64,
    pub transmitted: f64,
    /// Estimates of |approximate − exact| of the two; 0 for the exact sum.
    pub reflected_error: f64,
    pub transmitted_error: f64,
    /// Evaluated for this hit.
    pub nodes: u32,
    pub samples: u32,
}

/// Whether the segment from the hit to a light position is free.
pub type Visibility<'a> = &'a dyn Fn(DVec3) -> bool;

/// Stand-in until the real tree lands: the exact sum in f64.
#[derive(Debug)]
pub struct LightTree {
    set: crate::light::RaySet,
    scale: f64,
}

impl LightTree {
    pub fn build(set: &crate::light::RaySet) -> Self {
        let total: f64 = set.samples.iter().map(|s| f64::from(s.flux)).sum();
        Self { set: set.clone(), scale: set.flux_lm / total }
    }

    pub fn sum(&self, query: &HitQuery, _: f64, visible: Option<Visibility>) -> LightSum {
        let mut sum = LightSum::default();
        let mirror = 2.0 * query.normal.dot(query.view) * query.normal - query.view;
        let lobes = query.lobes;
        for sample in self.set.samples.iter() {
            let s = DVec3::from_array(sample.position.map(f64::from));
            let q = DVec3::from_array(sample.direction.map(f64::from)).normalize();
            let s = self.set.world_from_local.transform_point3(s);
            let q = self.set.world_from_local.transform_vector3(q).normalize();
            let r = (s - query.point).length();
            let l = (s - query.point) / r;
            let c = (-l.dot(q)).max(0.0);
            let cos = l.dot(query.normal);
            let (axis, out) = if cos > 0.0 && query.reflects {
                (mirror, &mut sum.reflected)
            } else if cos < 0.0 && query.transmits {
                (-query.view, &mut sum.transmitted)
            } else {
                continue;
            };
            if visible.is_some_and(|visible| !visible(s)) {
                continue;
            }
            let absolute = query.photometry == Photometry::Absolute;
            let pi = std::f64::consts::PI;
            let mut value = cos.abs().powf(lobes.n_d) * lobes.k_d;
            if absolute {
                value /= pi;
            }
            for lobe in &lobes.specular {
                let g = l.dot(axis).max(0.0).powf(lobe.n_s) * lobe.k_s;
                value += if absolute { g * (lobe.n_s + 2.0) / (2.0 * pi) } else { g };
            }
            let falloff = if absolute { 1.0 / (pi * (r / 1000.0).powi(2)) } else { 1.0 };
            *out += f64::from(sample.flux) * self.scale * c * falloff * value;
        }
        sum.samples = self.set.samples.len() as u32;
        sum
    }
}
