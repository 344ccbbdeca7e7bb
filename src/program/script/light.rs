//! `lampyris.rayset`: ray files, and ray sets from tables.

use std::sync::Arc;

use mlua::{Lua, MetaMethod, Table, UserData, UserDataFields, UserDataMethods, Value};

use super::host::Host;
use super::image::LuaImage;
use super::kinds::{Count, Kind, Or};
use super::mesh::placement;
use super::options::{self, Arguments, Options, Range};
use super::spectrum::LuaSpectrum;
use super::{fault, host};
use crate::error::Error;
use crate::geometry::DVec3;
use crate::light::{RaySample, RaySet};
use crate::source::rayfile::{self, LightOptions, SaveFormat};
use crate::source::surface_fit::{FittedSurface, SurfaceFit};
use crate::source::{StartSurface, Starts, noise, thinning};
use crate::spectrum::Spectrum;

/// Handle of a light source: its samples and its spectrum.
#[derive(Debug, Clone)]
pub struct LuaLight {
    pub rays: RaySet,
    pub spectrum: Arc<Spectrum>,
}

const NAMES: [&str; 10] = [
    "count",
    "flux",
    "halves",
    "noise",
    "rays",
    "save",
    "spectrum",
    "start_surface",
    "starting_at",
    "transform",
];

pub(super) const FLUX: Range = Range::above_zero("lm");
pub(super) const MAX_SAMPLES: u64 = 100_000_000;

pub(super) fn register(lua: &Lua, module: &Table) -> mlua::Result<()> {
    let table = lua.create_table()?;
    table.set(
        "load",
        fault::function(lua, |lua, a| load(lua, Arguments::new("rayset.load", a, 2)?))?,
    )?;
    table.set(
        "new",
        fault::function(lua, |_, a| from_tables(Arguments::new("rayset.new", a, 1)?))?,
    )?;
    fault::refuse_unknown_names(lua, &table, "lampyris.rayset")?;
    module.set("rayset", table)
}

fn load(lua: &Lua, mut arguments: Arguments) -> mlua::Result<LuaLight> {
    let path = arguments.text("path")?;
    let keys = ["flux", "samples", "seed", "spectrum", "start", "transform"];
    let options = arguments.options(&keys)?;
    let host = host::of(lua)?;
    let file = rayfile::read(&host.input(&path)?)?;
    for warning in &file.warnings {
        host.warn(format!("{path}: {warning}"));
    }
    let given = LightOptions {
        spectrum: options.spectrum("spectrum")?,
        flux_lm: options.number("flux", FLUX)?,
    };
    let (mut rays, spectrum) = file.into_light(given)?;
    if let Some(count) = options.count("samples", 1, MAX_SAMPLES)? {
        rays = rays.thinned(count as usize, seed(&host, &options)?);
    }
    if options.has("start")? {
        rays = rays.starting_at(&start_surface(options.value("start")?)?)?;
    } else if let Some(warning) = Starts::of(&rays.samples).warning() {
        host.warn(format!("{path}: {warning}"));
    }
    placed(LuaLight { rays, spectrum: Arc::new(spectrum) }, options.value("transform")?)
}

/// Every whole number up to here is a number of Lua's.
const LAST: u64 = 1 << 53;
/// Draws repeat: the same seed gives the same samples. Manifests name it.
pub(super) const SEED: Or<Count<u64>> =
    Or { kind: Count::new(0, LAST), default: thinning::DEFAULT_SEED };

/// How many rays a source is sampled by.
pub(super) fn samples(default: usize) -> Or<Count<usize>> {
    Count::new(1, MAX_SAMPLES).or(default)
}

/// Draws repeat: the same seed gives the same samples. Manifests name it.
pub(super) fn seed(host: &Host, options: &Options) -> mlua::Result<u64> {
    let seed = options.count("seed", 0, LAST)?.unwrap_or(thinning::DEFAULT_SEED);
    host.note_seed(options.object(), seed);
    Ok(seed)
}

/// `{axis =, through =}` or `{point =}`, with an optional `radius`.
fn start_surface(value: Value) -> mlua::Result<StartSurface> {
    const OBJECT: &str = "rayset: start";
    let options = Options::new(OBJECT, value, &["axis", "point", "radius", "through"])?;
    let core = match (options.vector("axis")?, options.vector("point")?) {
        (Some(axis), None) => {
            StartSurface::axis(options.vector("through")?.unwrap_or(DVec3::ZERO), axis)?
        }
        (None, Some(point)) => StartSurface::point(point)?,
        _ => {
            let problem = "expected either \"axis\" (with \"through\") or \"point\"";
            return Err(Error::inconsistent(OBJECT, problem).into());
        }
    };
    Ok(core.with_radius(options.number_or("radius", Range::NOT_NEGATIVE, 0.0)?)?)
}

pub(super) fn placed(light: LuaLight, transform: Value) -> mlua::Result<LuaLight> {
    let placement = placement("rayset: transform", transform)?;
    let world_from_local = placement.affine() * light.rays.world_from_local;
    Ok(LuaLight { rays: RaySet { world_from_local, ..light.rays }, ..light })
}

fn from_tables(mut arguments: Arguments) -> mlua::Result<LuaLight> {
    let options = arguments.options(&["directions", "flux", "positions", "spectrum"])?;
    let object = options.object();
    let positions = options.required_vectors("positions")?;
    let directions = options.required_vectors("directions")?;
    if positions.len() != directions.len() || positions.is_empty() {
        let problem = format!(
            "{} positions and {} directions, expected as many of each, and one or more",
            positions.len(),
            directions.len()
        );
        return Err(Error::inconsistent(object, problem).into());
    }
    let fluxes = fluxes(&options, positions.len())?;
    let mut samples = Vec::with_capacity(positions.len());
    for (at, (position, direction)) in positions.iter().zip(&directions).enumerate() {
        let Some(unit) = direction.try_normalize() else {
            let what = format!("\"directions\" entry {}", at + 1);
            return Err(Error::out_of_range(object, &what, direction, "any direction").into());
        };
        samples.push(RaySample {
            position: position.as_vec3().to_array(),
            direction: unit.as_vec3().to_array(),
            flux: fluxes.relative[at] as f32,
        });
    }
    let spectrum = required_spectrum(&options)?;
    let rays = RaySet::new(samples.into(), fluxes.total_lm);
    Ok(LuaLight { rays, spectrum: Arc::new(spectrum) })
}

struct Fluxes {
    /// Relative to the largest, so that f32 holds them whatever their unit.
    relative: Vec<f64>,
    total_lm: f64,
}

/// `flux` as the total of even samples, or one number a sample.
fn fluxes(options: &Options, count: usize) -> mlua::Result<Fluxes> {
    if !matches!(options.value("flux")?, Value::Table(_)) {
        let total_lm = options.required_number("flux", FLUX)?;
        return Ok(Fluxes { relative: vec![1.0; count], total_lm });
    }
    let list = options.required_list("flux", "a number of lm, or a list of them")?;
    if list.len() != count {
        let problem = format!("{} fluxes for {count} positions, expected one each", list.len());
        return Err(Error::inconsistent(options.object(), problem).into());
    }
    let entry = |(at, value): (usize, &Value)| {
        let what = format!("\"flux\" entry {}", at + 1);
        options::number(options.object(), &what, value, Range::NOT_NEGATIVE)
    };
    let fluxes: Vec<f64> = list.iter().enumerate().map(entry).collect::<mlua::Result<_>>()?;
    let largest = fluxes.iter().copied().fold(0.0, f64::max);
    if largest == 0.0 {
        return Err(Error::inconsistent(options.object(), "\"flux\" is 0 throughout").into());
    }
    let relative = fluxes.iter().map(|flux| flux / largest).collect();
    Ok(Fluxes { relative, total_lm: fluxes.iter().sum() })
}

pub(super) fn required_spectrum(options: &Options) -> mlua::Result<Spectrum> {
    options.spectrum("spectrum")?.ok_or_else(|| {
        Error::MissingKey {
            object: options.object().to_owned(),
            key: "spectrum".to_owned(),
            expected: "expected a spectrum, such as lampyris.spectrum.blackbody(2856)".to_owned(),
        }
        .into()
    })
}

impl LuaLight {
    fn halves(&self, seed: u64) -> [Self; 2] {
        self.rays.halves(seed).map(|rays| Self { rays, ..self.clone() })
    }
}

/// The relative error that a picture has from the number of rays alone: that of its luminance, from
/// pictures with disjoint halves of the set, which the script's `image` function takes.
fn noise(host: &Host, light: &LuaLight, options: &Options) -> mlua::Result<f64> {
    const EXPECTED: &str = "a function that renders an image with the ray set that it is given";
    let object = options.object();
    if light.rays.samples.len() < 2 {
        return Err(Error::inconsistent(object, "a set of one ray has no halves").into());
    }
    let take = options.required_function("image", EXPECTED)?;
    let splits = options.count("splits", 1, 1000)?.unwrap_or(1);
    let first_seed = seed(host, options)?;
    let mut pairs: Vec<[f64; 2]> = Vec::new();
    for split in 0..splits {
        let pictures = light.halves(first_seed + split).map(|half| {
            let image: LuaImage =
                options::handle(object, "\"image\"'s result", &take.call(half)?, "an image")?;
            Ok::<_, mlua::Error>(image.luminances())
        });
        let [a, b] = pictures;
        pairs.extend(a?.into_iter().zip(b?).map(|(a, b)| [a, b]));
    }
    let error = noise::relative_error(pairs);
    error.ok_or_else(|| Error::inconsistent(object, "the pictures are black").into())
}

/// What start points lie on, in the set's own coordinates.
fn surface_table(lua: &Lua, fit: SurfaceFit, is_source: bool) -> mlua::Result<Table> {
    let table = lua.create_table()?;
    let (kind, center) = match fit.surface {
        FittedSurface::Point { at } => ("point", at),
        FittedSurface::Sphere { center, radius_mm } => {
            table.set("radius", radius_mm)?;
            ("sphere", center)
        }
        FittedSurface::Cylinder { through, axis, radius_mm, length_mm } => {
            table.set("radius", radius_mm)?;
            table.set("length", length_mm)?;
            table.set("axis", axis.to_array())?;
            ("cylinder", through)
        }
        FittedSurface::Plane { through, normal, radius_mm } => {
            table.set("radius", radius_mm)?;
            table.set("normal", normal.to_array())?;
            ("plane", through)
        }
    };
    table.set("kind", kind)?;
    table.set("center", center.to_array())?;
    table.set("rms", fit.rms_mm)?;
    table.set("share", fit.share)?;
    table.set("is_source", is_source)?;
    Ok(table)
}

/// Each ray as `{position =, direction =, flux =}`, in the scene's place, mm and lm.
fn rays(lua: &Lua, rays: &RaySet) -> mlua::Result<Vec<Table>> {
    let lm_per_flux = rays.lm_per_flux();
    let ray = |sample: &RaySample| {
        let table = lua.create_table()?;
        table.set("position", rays.world_origin(sample).to_array())?;
        table.set("direction", rays.world_direction(sample).to_array())?;
        table.set("flux", f64::from(sample.flux) * lm_per_flux)?;
        Ok(table)
    };
    rays.samples.iter().map(ray).collect()
}

impl UserData for LuaLight {
    fn add_fields<F: UserDataFields<Self>>(fields: &mut F) {
        fields.add_field_method_get("count", |_, this| Ok(this.rays.samples.len()));
        fields.add_field_method_get("flux", |_, this| Ok(this.rays.flux_lm));
        fields.add_field_method_get("start_surface", |lua, this| {
            let starts = Starts::of(&this.rays.samples);
            let surface = |fit: SurfaceFit| surface_table(lua, fit, starts.inner_source.is_none());
            starts.surface.map(surface).transpose()
        });
        fields.add_field_method_get("spectrum", |_, this| {
            Ok(LuaSpectrum(Arc::clone(&this.spectrum)))
        });
    }

    fn add_methods<M: UserDataMethods<Self>>(methods: &mut M) {
        fault::method(methods, "transform", |_, this: &Self, a| {
            placed(this.clone(), Arguments::new("rayset:transform", a, 1)?.value())
        });
        fault::method(methods, "save", |lua, this: &Self, a| {
            let path = Arguments::new("rayset:save", a, 1)?.text("path")?;
            let target = host::of(lua)?.output(&path)?;
            let format = SaveFormat::of(&target)?;
            Ok(rayfile::save(&target, &this.rays, &this.spectrum, format)?)
        });
        fault::method(methods, "rays", |lua, this: &Self, _| rays(lua, &this.rays));
        fault::method(methods, "starting_at", |_, this: &Self, a| {
            let surface = start_surface(Arguments::new("rayset:starting_at", a, 1)?.value())?;
            Ok(Self { rays: this.rays.clone().starting_at(&surface)?, ..this.clone() })
        });
        fault::method(methods, "halves", |lua, this: &Self, a| {
            let options = Arguments::new("rayset:halves", a, 1)?.options(&["seed"])?;
            let [first, second] = this.halves(seed(&host::of(lua)?, &options)?);
            Ok((first, second))
        });
        fault::method(methods, "noise", |lua, this: &Self, a| {
            noise(
                &host::of(lua)?,
                this,
                &Arguments::new("rayset:noise", a, 1)?.options(&["image", "seed", "splits"])?,
            )
        });
        methods.add_meta_method(MetaMethod::ToString, |_, this, ()| {
            let (count, flux_lm) = (this.rays.samples.len(), this.rays.flux_lm);
            Ok(format!("rayset: {count} samples, {flux_lm} lm"))
        });
        fault::refuse_unknown_fields(methods, "rayset", &NAMES);
    }
}
