//! The paper's material (Table 4) and the fitting of its lobes to measured curves.

mod fresnel;
mod lobe_file;
mod lobe_fit;
mod optical;

pub use fresnel::{Fresnel, dielectric_reflectance, metal_reflectance};
pub use lobe_file::{LobeFile, read_lobe};
pub use lobe_fit::{
    FittedLobe, LobeCount, LobeFit, LobeSpace, LobeTable, Peak, about_peak, fit_lobe,
};
pub use optical::OpticalConstants;

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
    /// n(λ), 1 to 4; `None` lets rays go straight on.
    pub ior: Option<Spectrum>,
    /// What decides how much is mirrored, and how much goes on.
    pub fresnel: Fresnel,
    /// Where bodies overlap, the one with the higher priority is there.
    pub priority: i32,
    /// How light is spread: eq. 2's scalar part.
    pub lobes: Lobes,
    /// Proportions of the mirrored and the transmitted ray and of the ambient light, 0 to 1.
    pub k_rg: f64,
    /// Proportion of the transmitted ray, 0 to 1.
    pub k_tg: f64,
    /// Proportion of the ambient light, 0 to 1.
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
    /// What the specular lobes are about.
    pub shape: LobeShape,
}

/// What the specular lobes of light from the viewer's side are about; light from the far side keeps
/// its lobe about the undeviated direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LobeShape {
    /// The mirror direction: (R·V)^n_s (eq. 2).
    #[default]
    Mirror,
    /// The normal, by the half vector of L and V: (N·H)^(4 n_s), over 4 N·V in absolute photometry.
    /// It is the microfacet lobe of the same width. Source: model.md, "Half-vector lobe".
    Half,
}

/// k_s (R·V)^n_s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpecularLobe {
    /// 0 to 1.
    pub k_s: f64,
    /// 1 to 10⁶.
    pub n_s: f64,
}

/// Black.
impl Default for Lobes {
    fn default() -> Self {
        Self { k_d: 0.0, n_d: 1.0, specular: Vec::new(), shape: LobeShape::Mirror }
    }
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

/// Opaque, without lobes, mirroring nothing; its F_r is 1.
impl Default for Material {
    fn default() -> Self {
        Self {
            name: "material".to_owned(),
            reflectance: Spectrum::constant(1.0),
            transmittance: None,
            thickness_mm: None,
            ior: None,
            fresnel: Fresnel::Off,
            priority: 0,
            lobes: Lobes::default(),
            k_rg: 0.0,
            k_tg: 0.0,
            k_a: 0.0,
        }
    }
}

/// Allowed range of the lobe exponents.
pub const EXPONENT_RANGE: [f64; 2] = [1.0, 1e6];

impl Material {
    /// Whether light passes: such surfaces never block shadow segments.
    pub fn transmits(&self) -> bool {
        self.k_tg > 0.0 && self.transmittance.is_some()
    }

    /// Whether a closed mesh of it is a body that rays run in.
    pub fn is_body(&self) -> bool {
        self.transmits() && (self.ior.is_some() || self.thickness_mm.is_some())
    }

    /// Errors: a spectrum with values out of range, named with its wavelength; Fresnel's law
    /// without the indices that it takes.
    pub fn check(&self) -> Result<()> {
        self.check_range("reflectance", Some(&self.reflectance), RATIO)?;
        self.check_range("transmittance", self.transmittance.as_ref(), RATIO)?;
        self.check_range("ior", self.ior.as_ref(), IOR)?;
        match &self.fresnel {
            Fresnel::Off => Ok(()),
            Fresnel::Dielectric if self.ior.is_some() => Ok(()),
            Fresnel::Dielectric => {
                let problem = "\"fresnel\" asks for \"ior\", or for a metal's \"n\" and \"k\"";
                Err(Error::inconsistent(&self.name, problem))
            }
            Fresnel::Metal { n, k } => {
                self.check_range("n", Some(n), METAL)?;
                self.check_range("k", Some(k), METAL)
            }
        }
    }

    fn check_range(
        &self,
        what: &str,
        spectrum: Option<&Spectrum>,
        ([low, high], allowed): Allowed,
    ) -> Result<()> {
        let Some(spectrum) = spectrum else { return Ok(()) };
        for (lambda_nm, &value) in spectrum.wavelengths_nm().iter().zip(spectrum.values()) {
            if !(low..=high).contains(&value) {
                // A number that stands for all wavelengths has none of its own.
                let is_number = spectrum.values().len() == 1 && high != 1.0;
                let what = if is_number {
                    format!("\"{what}\"")
                } else {
                    format!("{what} at {lambda_nm} nm")
                };
                let hint = if high == 1.0 { ratio_hint(spectrum) } else { "" };
                return Err(Error::out_of_range(
                    &self.name,
                    &what,
                    value,
                    format!("{allowed}{hint}"),
                ));
            }
        }
        Ok(())
    }

    /// How an `absolute` scene would get more light from this material than arrives there, if it
    /// would (model.md, "Two photometries").
    pub fn gain_warning(&self) -> Option<String> {
        let f_r = &self.reflectance;
        let f_t = self.transmittance.as_ref().filter(|_| self.k_tg > 0.0);
        let none = Spectrum::constant(0.0);
        let f_t = f_t.unwrap_or(&none);
        let lobes = match self.fresnel {
            Fresnel::Off => f_r.sum(f_t).max(),
            Fresnel::Dielectric | Fresnel::Metal { .. } => f_r.max().max(f_t.max()),
        };
        let local = lobes * self.lobes.total();
        let global = match self.fresnel {
            Fresnel::Off => f_r.scaled(self.k_rg).sum(&f_t.scaled(self.k_tg)).max(),
            // R and 1 − R share what arrives.
            Fresnel::Dielectric | Fresnel::Metal { .. } => 0.0,
        };
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
/// Allowed range of refractive indices.
pub const IOR_RANGE: [f64; 2] = [1.0, 4.0];

/// Ranges of spectra, and how messages name them.
type Allowed = ([f64; 2], &'static str);
const IOR: Allowed = (IOR_RANGE, "1 to 4");
const RATIO: Allowed = ([0.0, 1.0], "0 to 1");
const METAL: Allowed = ([0.0, 100.0], "0 to 100");
