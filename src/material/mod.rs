//! The paper's material (Table 4) and the fitting of its lobes to measured curves.

mod lobe_file;
mod lobe_fit;

pub use lobe_file::{LobeFile, read_lobe};
pub use lobe_fit::{
    FittedLobe, LobeCount, LobeFit, LobeSpace, LobeTable, Peak, about_peak, fit_lobe,
};

use crate::error::{Error, Result};
use crate::spectrum::Spectrum;

/// What a surface does with light: eq. 1 and 2.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Names the material in messages.
    pub name: String,
    /// F_r, 0 to 1.
    pub reflectance: Spectrum,
    /// F_t, 0 to 1; `None` is opaque.
    pub transmittance: Option<Spectrum>,
    /// F_t is the internal transmittance of this thickness, > 0; `None` applies F_t at every
    /// interface crossed.
    pub thickness_mm: Option<f64>,
    /// 1 to 4; `None` lets rays go straight on.
    pub ior: Option<f64>,
    pub lobes: Lobes,
    /// Proportions of the mirrored and the transmitted ray and of the ambient light, 0 to 1.
    pub k_rg: f64,
    pub k_tg: f64,
    pub k_a: f64,
}

/// The scalar part of eq. 2: a diffuse lobe and any number of specular ones.
#[derive(Debug, Clone, PartialEq)]
pub struct Lobes {
    /// Proportion of the diffuse lobe, 0 to 1.
    pub k_d: f64,
    /// Exponent n of (L·N)ⁿ, 1 to 10⁶.
    pub n_d: f64,
    /// Only lobes with k_s > 0.
    pub specular: Vec<SpecularLobe>,
}

/// k_s (R·V)^n_s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpecularLobe {
    /// 0 to 1.
    pub k_s: f64,
    /// 1 to 10⁶.
    pub n_s: f64,
}

impl Lobes {
    /// Whether local shading is zero whatever the light.
    pub fn is_black(&self) -> bool {
        self.k_d == 0.0 && self.specular.is_empty()
    }

    /// k_d + Σ k_s: what the lobes return at most.
    pub fn total(&self) -> f64 {
        self.k_d + self.specular.iter().map(|lobe| lobe.k_s).sum::<f64>()
    }
}

/// Allowed range of the lobe exponents.
pub const EXPONENT_RANGE: [f64; 2] = [1.0, 1e6];

impl Material {
    /// Whether light passes: such surfaces neither block nor attenuate shadow segments.
    pub fn transmits(&self) -> bool {
        self.k_tg > 0.0 && self.transmittance.is_some()
    }

    /// Errors: a spectrum with values outside of 0 to 1, named with its wavelength.
    pub fn check(&self) -> Result<()> {
        check_ratio(&self.name, "reflectance", &self.reflectance)?;
        match &self.transmittance {
            Some(transmittance) => check_ratio(&self.name, "transmittance", transmittance),
            None => Ok(()),
        }
    }

    /// How an `absolute` scene would get more light from this material than arrives there, if it
    /// would (model.md, "Two photometries").
    pub fn gain_warning(&self) -> Option<String> {
        let f_r = &self.reflectance;
        let f_t = self.transmittance.as_ref().filter(|_| self.k_tg > 0.0);
        let none = Spectrum::constant(0.0);
        let f_t = f_t.unwrap_or(&none);
        let local = f_r.sum(f_t).max() * self.lobes.total();
        let global = f_r.scaled(self.k_rg).sum(&f_t.scaled(self.k_tg)).max();
        // 1e-9: a sum of proportions such as 0.08 + 0.92 may round above 1.
        let limit = 1.0 + 1e-9;
        if local > limit {
            Some(format!(
                "{}: returns {local:.3} times the light that arrives: (F_r + F_t)(k_d + k_s) \
                 should be at most 1 in an absolute scene",
                self.name
            ))
        } else if global > limit {
            Some(format!(
                "{}: passes on {global:.3} times the light that arrives: k_rg F_r + k_tg F_t \
                 should be at most 1 in an absolute scene",
                self.name
            ))
        } else {
            None
        }
    }
}

fn check_ratio(material: &str, what: &str, spectrum: &Spectrum) -> Result<()> {
    for (lambda_nm, &value) in spectrum.wavelengths_nm().iter().zip(spectrum.values()) {
        if !(0.0..=1.0).contains(&value) {
            let what = format!("{what} at {lambda_nm} nm");
            let allowed = format!("0 to 1{}", ratio_hint(spectrum));
            return Err(Error::out_of_range(material, &what, value, allowed));
        }
    }
    Ok(())
}

/// What was likely meant by values outside of 0 to 1.
fn ratio_hint(spectrum: &Spectrum) -> &'static str {
    const NOISE: f64 = 0.01;
    let (low, high) = (spectrum.min(), spectrum.max());
    if low >= -NOISE && high <= 1.0 + NOISE {
        ": noise? then load it with clamp = true, or take s:clamped(0, 1)"
    } else if low >= -1.0 && (2.0..=101.0).contains(&high) {
        ": percent? then say so in the file's header (\"%\"), or take s * 0.01"
    } else {
        ""
    }
}
