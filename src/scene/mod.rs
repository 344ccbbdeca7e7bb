//! The plain scene, and its preparation for rendering.

mod bodies;
mod emitters;
mod overlap;
pub mod plausibility;
mod reuse;
mod tables;

use std::sync::{Arc, OnceLock};
use std::time::Instant;

use rayon::prelude::*;

use crate::color::Photometry;
use crate::environment::Environment;
use crate::error::{Error, Result};
use crate::geometry::Mesh;
use crate::geometry::bvh::Bvh;
use crate::light::RaySet;
use crate::light::tree::LightTree;
use crate::material::{Lobes, Material};
use crate::source::Emitter;
use crate::spectrum::{Spectrum, WavelengthGrid};

pub use bodies::{Surface, SurfaceKind, Surfaces};
pub use emitters::PreparedEmitter;
use reuse::Earlier;
pub use tables::{Index, MaterialTables, SpectralTables, SurroundingsTables};

/// Index into [`Scene::materials`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MaterialId(pub usize);

/// A mesh and what it is made of.
#[derive(Debug, Clone)]
pub struct Object {
    /// In the world's coordinates, mm.
    pub mesh: Arc<Mesh>,
    /// One of the scene's materials.
    pub material: MaterialId,
}

/// A RAYSET and its spectrum.
#[derive(Debug, Clone)]
pub struct Light {
    /// Where its light starts, and the way it goes.
    pub rays: RaySet,
    /// I_norm(λ), ≥ 0, relative: its luminous integral is scaled to the set's flux (eq. 12).
    pub spectrum: Spectrum,
    /// What camera, mirrored and transmitted rays see of it; `None` is a source without a body.
    pub surface: Option<Emitter>,
}

/// Whether light samples can be hidden by opaque surfaces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shadows {
    /// Every sample lights every surface that faces it, as in the paper.
    Off,
    /// Opaque surfaces hide samples.
    On,
}

/// What a ray sees that hits nothing.
#[derive(Debug, Clone)]
pub enum Background {
    /// The same everywhere, in the unit of the image; no light for lobes.
    Even(Spectrum),
    /// Seen by rays, and light for lobes; absolute photometry only.
    Environment(Arc<Environment>),
}

impl Background {
    /// Errors: values below 0; an environment in a scene whose radiance has no unit.
    fn check(&self, photometry: Photometry) -> Result<()> {
        match (self, photometry) {
            (Background::Even(spectrum), _) => check_not_negative("scene: background", spectrum),
            (Background::Environment(_), Photometry::Absolute) => Ok(()),
            (Background::Environment(_), Photometry::Relative) => Err(Error::inconsistent(
                "scene: background",
                "an environment is in cd/m²: it needs photometry = \"absolute\"",
            )),
        }
    }

    /// None for an even background.
    pub fn environment(&self) -> Option<&Environment> {
        match self {
            Background::Even(_) => None,
            Background::Environment(environment) => Some(environment),
        }
    }
}

/// How light that surfaces return diffusely is passed on: `shading::prepare`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interreflection {
    /// Diffuse returns that a ray from a light may go through, 1 or more.
    pub bounces: u32,
    /// About this many light samples come of them.
    pub samples: usize,
    /// The same seed gives the same samples.
    pub seed: u64,
    /// Keeps what comes of each light apart, for layers; else lights of one spectrum share samples.
    pub by_light: bool,
}

/// What interreflection added to a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InterreflectionReport {
    /// Index of the first of the lights that were added.
    pub first_light: usize,
    /// Light samples added.
    pub samples: usize,
    /// Relative standard error of the light that they send to each other, from halves; `None` for
    /// fewer than two samples.
    pub relative_error: Option<f64>,
}

/// Everything that a script describes, before anything is built from it.
#[derive(Debug, Clone)]
pub struct Scene {
    /// All meshes, in the script's order.
    pub objects: Vec<Object>,
    /// What objects refer to.
    pub materials: Vec<Material>,
    /// What illuminates them.
    pub lights: Vec<Light>,
    /// What a ray sees that hits nothing.
    pub background: Background,
    /// I_a(λ), in the unit of the image.
    pub ambient: Spectrum,
    /// Whether pictures are in cd/m² or in a unit of their own.
    pub photometry: Photometry,
    /// Whether objects hide light.
    pub shadows: Shadows,
    /// `None` leaves out light that surfaces send to each other diffusely.
    pub interreflection: Option<Interreflection>,
    /// Surfaces of different objects that are this near, mm, are one interface; ≥ 0.
    pub contact_mm: f64,
}

/// Nothing, in the dark: relative photometry without shadows.
impl Default for Scene {
    fn default() -> Self {
        Self {
            objects: Vec::new(),
            materials: Vec::new(),
            lights: Vec::new(),
            background: Background::Even(Spectrum::constant(0.0)),
            ambient: Spectrum::constant(0.0),
            photometry: Photometry::Relative,
            shadows: Shadows::Off,
            interreflection: None,
            contact_mm: 0.0,
        }
    }
}

/// A scene with what rendering needs: built once, used by every view.
#[derive(Debug)]
pub struct Prepared {
    /// What it was built from.
    pub scene: Scene,
    /// Triangles of all objects, then of the emitters.
    pub bvh: Arc<Bvh>,
    /// One a light.
    pub light_trees: Vec<Arc<LightTree>>,
    /// Whether light ends at an object, or at an emitter behind these.
    pub opaque: Arc<[bool]>,
    /// From any object this far on is outside of all of them, mm.
    pub beyond_mm: f64,
    /// Lights with a surface, in the order of their meshes behind the objects'.
    pub emitters: Vec<PreparedEmitter>,
    /// Per light, whether its shadow segments end at an object or emitter; most share one list.
    blocks: Vec<Arc<[bool]>>,
    /// Per material, the lobes for light from its far side where they differ.
    far_lobes: Vec<Option<Lobes>>,
    /// What the objects' surfaces are to rays.
    pub surfaces: Surfaces,
    /// How long building took.
    pub seconds: BuildSeconds,
    /// What `shading::prepare` added for the scene's interreflection.
    pub interreflection: Option<InterreflectionReport>,
    /// Per light that interreflection added, the light of the scene that it came of; `None`: of several.
    pub came_of: Vec<Option<usize>>,
    /// Per wavelength grid, resampled when it is first asked for.
    tables: [OnceLock<SpectralTables>; WavelengthGrid::ALL.len()],
}

/// How long the parts of a scene took to build, s of the wall clock.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct BuildSeconds {
    /// The BVH.
    pub bvh: f64,
    /// The trees of all lights.
    pub light_trees: f64,
}

impl Scene {
    /// Errors: a material's spectrum outside of 0 to 1; a light whose spectrum has negative values
    /// or no luminous flux.
    pub fn check(&self) -> Result<()> {
        self.materials.iter().try_for_each(Material::check)?;
        for light in &self.lights {
            check_not_negative("light: spectrum", &light.spectrum)?;
            light.power_per_lumen(WavelengthGrid::Step5)?;
        }
        self.background.check(self.photometry)?;
        if self.has_emitters() && self.photometry == Photometry::Relative {
            let problem = "a visible light has a radiance, which has no unit in relative \
                           photometry: set photometry = \"absolute\"";
            return Err(Error::inconsistent("scene", problem));
        }
        check_not_negative("scene: ambient", &self.ambient)
    }

    /// Builds BVH and light trees. Errors: as [`Scene::check`].
    pub fn prepare(self) -> Result<Prepared> {
        self.prepare_from(&[])
    }

    /// The same, to the bit; what an `earlier` scene has of the same meshes or rays is taken from it.
    /// Errors: as [`Scene::check`].
    pub fn prepare_from(self, earlier: &[Arc<Prepared>]) -> Result<Prepared> {
        self.check()?;
        let earlier = Earlier(earlier);
        let start = Instant::now();
        let mut meshes: Vec<Arc<Mesh>> = self.objects.iter().map(|o| Arc::clone(&o.mesh)).collect();
        let emitters = PreparedEmitter::all(&self.lights);
        meshes.extend(emitters.iter().map(|emitter| Arc::clone(&emitter.mesh)));
        let bvh = earlier.bvh(&meshes).unwrap_or_else(|| Arc::new(Bvh::build(&meshes)));
        let bvh_seconds = start.elapsed().as_secs_f64();
        let start = Instant::now();
        let tree = |rays| earlier.light_tree(rays).unwrap_or_else(|| LightTree::build(rays).into());
        let light_trees = self.lights.iter().map(|light| tree(&light.rays)).collect();
        let seconds = BuildSeconds { bvh: bvh_seconds, light_trees: start.elapsed().as_secs_f64() };
        let opaque = self.opaque(&emitters);
        let blocks = self.blocks(&opaque, &emitters);
        let beyond_mm = bvh.bounds().map_or(1.0, |(low, high)| 1.0 + 2.0 * low.distance(high));
        let far_lobes = self.materials.iter().map(|material| self.far_lobes(material)).collect();
        let surfaces = Surfaces::new(&self, &bvh, earlier);
        let tables = Default::default();
        let scene = self;
        Ok(Prepared {
            bvh,
            light_trees,
            opaque,
            beyond_mm,
            emitters,
            blocks,
            far_lobes,
            surfaces,
            seconds,
            interreflection: None,
            came_of: Vec::new(),
            tables,
            scene,
        })
    }

    /// What silently changes the picture, in words.
    pub fn warnings(&self) -> Vec<String> {
        let lights = (1..).zip(&self.lights);
        let mut warnings: Vec<String> =
            lights.filter_map(|(number, light)| light.cut_warning(number)).collect();
        if self.photometry == Photometry::Absolute {
            warnings.extend(self.materials.iter().filter_map(Material::gain_warning));
            warnings.extend(self.double_count_warnings());
        }
        warnings
    }
}

/// A table that ends above this share of its peak leaves light out.
const CUT_SHARE: f64 = 0.01;

impl Prepared {
    /// Adds lights that came of the scene's own, each with the one that it came of, if that is one.
    pub fn add_bounced(
        &mut self,
        bounced: Vec<(Light, Option<usize>)>,
        report: InterreflectionReport,
    ) {
        let (lights, came_of): (Vec<_>, Vec<_>) = bounced.into_iter().unzip();
        let start = Instant::now();
        self.light_trees
            .par_extend(lights.par_iter().map(|light| Arc::new(LightTree::build(&light.rays))));
        self.scene.lights.extend(lights);
        self.blocks = self.scene.blocks(&self.opaque, &self.emitters);
        self.came_of = came_of;
        self.interreflection = Some(report);
        self.tables = Default::default();
        self.seconds.light_trees += start.elapsed().as_secs_f64();
    }

    /// How many of the lights are the scene's own: those before the ones that interreflection added.
    pub fn own_lights(&self) -> usize {
        self.scene.lights.len() - self.came_of.len()
    }

    /// Whether a light's shadow segments end at an object, or at an emitter behind these.
    pub fn blocks(&self, light: usize) -> &[bool] {
        &self.blocks[light]
    }

    /// The lobes for light from a surface's far side, where they are not the material's own.
    pub fn far_lobes(&self, material: MaterialId) -> Option<&Lobes> {
        self.far_lobes[material.0].as_ref()
    }

    /// All spectra of the scene at the bands of `grid`: resampled at the first call, then kept.
    ///
    /// Errors: a light without luminous flux at these bands.
    pub fn tables(&self, grid: WavelengthGrid) -> Result<&SpectralTables> {
        let kept = &self.tables[grid as usize];
        if let Some(tables) = kept.get() {
            return Ok(tables);
        }
        let tables = SpectralTables::new(&self.scene, grid)?;
        Ok(kept.get_or_init(|| tables))
    }
}

impl Light {
    /// A light is 0 outside of its spectrum's table.
    fn cut_warning(&self, number: usize) -> Option<String> {
        let [first, last] = self.spectrum.partial_range_nm()?;
        let share = self.spectrum.cut_share();
        (share > CUT_SHARE).then(|| {
            format!(
                "light {number}: its spectrum covers {first} to {last} nm only, and ends at {:.0} % \
                 of its peak: it is 0 beyond",
                100.0 * share
            )
        })
    }

    /// A source without a body.
    pub fn new(rays: RaySet, spectrum: Spectrum) -> Self {
        Self { rays, spectrum, surface: None }
    }

    /// I_norm(λ) in W/nm a lm, at the bands of `grid` (eq. 12).
    ///
    /// Errors: a spectrum without luminous flux on this grid.
    pub fn power_per_lumen(&self, grid: WavelengthGrid) -> Result<Vec<f64>> {
        let luminous = self.spectrum.luminous_flux(grid);
        if luminous > 0.0 && luminous.is_finite() {
            let per_lumen = self.spectrum.scaled(luminous.recip());
            return Ok(per_lumen.light_on_grid(grid));
        }
        let problem = format!(
            "spectrum has no luminous flux at the bands of {} nm, so that {} lm cannot be shared out",
            grid.step_nm(),
            self.rays.flux_lm
        );
        Err(Error::inconsistent("light", problem))
    }
}

fn check_not_negative(what: &str, spectrum: &Spectrum) -> Result<()> {
    let rows = spectrum.wavelengths_nm().iter().zip(spectrum.values());
    for (lambda_nm, &value) in rows {
        if value < 0.0 {
            return Err(Error::out_of_range(
                what,
                &format!("value at {lambda_nm} nm"),
                value,
                "≥ 0",
            ));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spectra_are_resampled_once_for_each_grid() {
        let empty =
            Scene { background: Background::Even(Spectrum::constant(0.5)), ..Scene::default() };
        let prepared = empty.prepare().unwrap();
        for grid in WavelengthGrid::ALL {
            let tables = prepared.tables(grid).unwrap();
            assert_eq!(tables.background.as_slice(), vec![0.5; grid.bands()]);
            assert!(std::ptr::eq(tables, prepared.tables(grid).unwrap()));
        }
    }
}
