//! The scene's spectra at the bands of a wavelength grid.

use super::{Background, Scene};
use crate::environment::{Environment, Luminances, per_lumen};
use crate::error::Result;
use crate::material::{Fresnel, Material};
use crate::spectrum::{Bands, Spectrum, WavelengthGrid, cie};

/// Every spectrum of a scene at the bands of one grid; [`super::Prepared::tables`] keeps them.
#[derive(Debug)]
pub struct SpectralTables {
    /// How many there are.
    pub bands: usize,
    /// In the order of [`Scene::materials`].
    pub materials: Vec<MaterialTables>,
    /// I_norm(λ) of each light, in W/nm per lm (eq. 12).
    pub lights: Vec<Bands>,
    /// An even background, in the unit of the image.
    pub background: Bands,
    /// Spectra of the surroundings, if the scene has any.
    pub surroundings: Option<SurroundingsTables>,
    /// I_a(λ), in the unit of the image.
    pub ambient: Bands,
    /// Whether any band of it is above 0.
    pub has_ambient: bool,
    /// 683 ȳ(λ) Δλ: Y of a spectrum is its product with this.
    pub luminance_weights: Bands,
}

/// The surroundings' spectra at the bands of one grid, in W/nm per lm.
#[derive(Debug)]
pub struct SurroundingsTables {
    /// One a channel.
    pub dome: Vec<Bands>,
    /// Zero without a sun.
    pub sun: Bands,
}

impl SurroundingsTables {
    fn new(environment: &Environment, grid: WavelengthGrid) -> Result<Self> {
        let bands = |spectrum| per_lumen(spectrum, grid).map(|values| Bands::from_slice(&values));
        let sun = environment.sun().map(|sun| bands(&sun.spectrum));
        Ok(Self {
            dome: environment.spectra().iter().map(bands).collect::<Result<_>>()?,
            sun: sun.unwrap_or_else(|| Ok(Bands::zero(grid.bands())))?,
        })
    }

    /// Spectral radiance of these luminances.
    pub fn mixed(&self, dome: &Luminances, sun: f64) -> Bands {
        let mut mix = Bands::zero(self.sun.as_slice().len());
        let parts = self.dome.iter().zip(dome).chain([(&self.sun, &sun)]);
        for (bands, &luminance) in parts.filter(|(_, luminance)| **luminance > 0.0) {
            for (sum, value) in mix.as_mut_slice().iter_mut().zip(bands.as_slice()) {
                *sum += luminance * value;
            }
        }
        mix
    }
}

/// A material's spectra at the bands of one grid.
#[derive(Debug, Clone)]
pub struct MaterialTables {
    /// F_r(λ).
    pub reflectance: Bands,
    /// F_t(λ); zero for opaque materials.
    pub transmittance: Bands,
    /// −ln F_t / thickness; zero without `thickness`. Where F_t = 0 it is large enough that any
    /// path leaves nothing, and finite so that a path of length 0 leaves everything.
    pub absorption_per_mm: Bands,
    /// `ior`.
    pub index: Option<Index>,
    /// n and k of a metal.
    pub metal: Option<[Bands; 2]>,
    /// Whether it transmits, and not all of it.
    pub attenuates: bool,
    /// Whether lobes on the viewer's side can return light.
    pub reflects: bool,
    /// Whether lobes on the far side can.
    pub transmits: bool,
}

/// An index of refraction at the bands of one grid.
#[derive(Debug, Clone)]
pub struct Index {
    /// At 587.6 nm, helium's d line, which directions follow.
    pub at_d: f64,
    /// At every band.
    pub bands: Bands,
    /// Whether all wavelengths have the same.
    pub is_constant: bool,
}

/// Helium's d line.
pub const DIRECTIONS_NM: f64 = 587.6;

impl Index {
    fn new(ior: &Spectrum, grid: WavelengthGrid) -> Self {
        Self {
            at_d: ior.at(DIRECTIONS_NM),
            bands: Bands::from_slice(&ior.on_grid(grid)),
            is_constant: ior.min() == ior.max(),
        }
    }
}

/// exp(−this · d) is 0 for every distance above 1e-290 mm.
const OPAQUE_PER_MM: f64 = 1e300;

impl SpectralTables {
    /// Resamples all spectra of `scene`. Errors: a light without luminous flux on this grid.
    pub fn new(scene: &Scene, grid: WavelengthGrid) -> Result<Self> {
        let on_grid = |spectrum: &Spectrum| Bands::from_slice(&spectrum.light_on_grid(grid));
        let weights: Vec<f64> = (0..grid.bands())
            .map(|band| cie::K_LM_PER_W * cie::cmf(grid, band)[1] * grid.step_nm())
            .collect();
        let lights = scene
            .lights
            .iter()
            .map(|light| light.power_per_lumen(grid).map(|power| Bands::from_slice(&power)));
        let ambient = on_grid(&scene.ambient);
        let surroundings = scene.background.environment().map(|e| SurroundingsTables::new(e, grid));
        Ok(Self {
            bands: grid.bands(),
            materials: scene.materials.iter().map(|m| MaterialTables::new(m, grid)).collect(),
            lights: lights.collect::<Result<_>>()?,
            background: match &scene.background {
                Background::Even(spectrum) => on_grid(spectrum),
                Background::Environment(_) => Bands::zero(grid.bands()),
            },
            surroundings: surroundings.transpose()?,
            has_ambient: !ambient.is_zero(),
            ambient,
            luminance_weights: Bands::from_slice(&weights),
        })
    }
}

impl MaterialTables {
    fn new(material: &Material, grid: WavelengthGrid) -> Self {
        let reflectance = Bands::from_slice(&material.reflectance.on_grid(grid));
        let transmittance = match &material.transmittance {
            Some(spectrum) => Bands::from_slice(&spectrum.on_grid(grid)),
            None => Bands::zero(grid.bands()),
        };
        let mut absorption_per_mm = Bands::zero(grid.bands());
        if let Some(thickness_mm) = material.thickness_mm {
            let pairs = absorption_per_mm.as_mut_slice().iter_mut().zip(transmittance.as_slice());
            for (absorption, f_t) in pairs {
                *absorption = (-f_t.ln() / thickness_mm).min(OPAQUE_PER_MM);
            }
        }
        let metal = match &material.fresnel {
            Fresnel::Metal { n, k } => Some([n, k].map(|s| Bands::from_slice(&s.on_grid(grid)))),
            Fresnel::Off | Fresnel::Dielectric => None,
        };
        let shines = !material.lobes.is_black();
        let is_clear = transmittance.as_slice().iter().all(|&f_t| f_t == 1.0);
        Self {
            attenuates: material.transmits() && !is_clear,
            reflects: shines && !reflectance.is_zero(),
            transmits: shines && material.transmits() && !transmittance.is_zero(),
            reflectance,
            transmittance,
            absorption_per_mm,
            index: material.ior.as_ref().map(|ior| Index::new(ior, grid)),
            metal,
        }
    }
}
