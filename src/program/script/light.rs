//! `lampyris.rayset`: ray files, and ray sets from tables.

use std::sync::Arc;

use mlua::{Function, Lua, Table, UserData, UserDataRegistry};

use super::host::Host;
use super::image::LuaImage;
use super::kinds::{Callback, Count, Custom, Kind, Number, Or, SpectrumOrNumber, Vector, vectors};
use super::measured::{
    DIRECTIONS, Directions, EMITTER, EXPONENT, EmitterOption, plot_luminance, table_of,
};
use super::members::{Members, functions};
use super::mesh::{LuaMesh, Transform};
use super::options::{self, Arguments, Range};
use super::record::{Record, options};
use super::scene::SceneObject;
use super::spectrum::LuaSpectrum;
use super::{far_field, host};
use crate::error::Error;
use crate::geometry::DVec3;
use crate::light::{RaySample, RaySet};
use crate::output;
use crate::program::fields::Cell;
use crate::program::results::{RAY, START_SURFACE, WorldRay};
use crate::source::rayfile::{self, LightOptions, SaveFormat};
use crate::source::{Emitter, StartSurface, Starts, noise, thinning};
use crate::spectrum::Spectrum;

/// Handle of a light source: its samples and its spectrum.
#[derive(Debug, Clone)]
pub struct LuaLight {
    pub rays: RaySet,
    pub spectrum: Arc<Spectrum>,
    /// What rays see of it.
    pub surface: Option<Emitter>,
    /// What it brings besides: a bulb's glass.
    pub parts: Vec<SceneObject>,
}

impl LuaLight {
    /// A source without a body.
    pub(super) fn new(rays: RaySet, spectrum: Spectrum) -> Self {
        Self { rays, spectrum: Arc::new(spectrum), surface: None, parts: Vec::new() }
    }
}

pub(super) const FLUX: Range = Range::above_zero("lm");
pub(super) const MAX_SAMPLES: u64 = 100_000_000;

pub(super) fn register(lua: &Lua, module: &Table) -> mlua::Result<()> {
    functions(lua, module, "rayset", |functions| {
        functions.add_kept("load", 2, load)?;
        functions.add("new", 1, from_tables)
    })
}

options! {
    struct RaysetLoadOptions {
        spectrum: Option<Spectrum> = SpectrumOrNumber::of_light().optional("the file's"),
        flux: Option<f64> =
            Number(FLUX).optional("the header's, else the sum of the rays"),
        /// of the disc on which the rays of a photometric file start
        radius: Option<f64> = Number(Range::new(0.0, f64::INFINITY, "mm")).optional("0: a point"),
        /// keep this many rays, drawn evenly; of a photometric file, make as many
        samples: Option<usize> = Count::new(1, MAX_SAMPLES).optional("all"),
        /// of the draw
        seed: u64 = SEED,
        /// moves the rays' starts along the rays
        start: Option<StartOptions> = START.optional("as they are"),
        /// how narrow the rays' own lobes are; 1 is Lambert's
        directions: Option<Directions> = DIRECTIONS.optional("\"lambert\""),
        /// the surface that the rays come from
        emitter: Option<EmitterOption> = EMITTER.optional("none"),
        transform: Option<Transform> = TRANSFORM.optional(""),
    }
}

const TRANSFORM: Custom<Transform> = Custom {
    lua_type: "Transform",
    allowed: "",
    read: |_, _, value| Transform::read("rayset: transform", value.clone()),
    shown: |_| String::new(),
};

fn load(lua: &Lua, mut arguments: Arguments) -> mlua::Result<LuaLight> {
    let path = arguments.text("path")?;
    let given: RaysetLoadOptions = arguments.record()?;
    let host = host::of(lua)?;
    let input = host.input(&path)?;
    host::reserve_for_file(lua, "rayset.load", &input)?;
    if far_field::is_far_field(&input) {
        return far_field::load(&host, &input, given);
    }
    if given.radius.is_some() {
        let problem = "\"radius\" is for photometric files, ray files have their start points";
        return Err(Error::inconsistent("rayset.load", problem).into());
    }
    let file = rayfile::read(&input)?;
    for warning in &file.warnings {
        host.warn(format!("{path}: {warning}"));
    }
    let light = LightOptions { spectrum: given.spectrum, flux_lm: given.flux };
    let (mut rays, spectrum) = file.into_light(light)?;
    if let Some(count) = given.samples {
        host.note_seed("rayset.load", given.seed);
        rays = rays.thinned(count, given.seed);
    }
    if let Some(start) = given.start {
        rays = rays.starting_at(&start.surface()?)?;
    } else if given.emitter.is_none()
        && let Some(warning) = Starts::of(&rays.samples).warning()
    {
        host.warn(format!("{path}: {warning}"));
    }
    let light = LuaLight::new(rays, spectrum);
    let light = match (given.directions, given.emitter) {
        (None, None) => light,
        (Some(directions), None) => LuaLight { rays: directions.of(light.rays)?, ..light },
        (None, Some(emitter)) => emitter.of(light, given.seed, &host)?,
        (Some(_), Some(_)) => return Err(emitter_and_directions()),
    };
    match given.transform {
        None => Ok(light),
        Some(transform) => placed(light, &transform),
    }
}

fn emitter_and_directions() -> mlua::Error {
    let problem = "give \"emitter\" or \"directions\", not both: an emitter's samples have the \
                   directions of its table";
    Error::inconsistent("rayset.load", problem).into()
}

/// Every whole number up to here is a number of Lua's.
const LAST: u64 = 1 << 53;
/// Draws repeat: the same seed gives the same samples. Manifests name it.
pub(super) const SEED: Or<Count<u64>> =
    Or { kind: Count::new(0, LAST), default: thinning::DEFAULT_SEED };

/// Room for the samples of a source.
pub(super) fn reserve_samples(lua: &Lua, object: &str, count: usize) -> mlua::Result<()> {
    let bytes = count.saturating_mul(size_of::<RaySample>());
    host::reserve(lua, object, bytes, "fewer samples would fit")
}

/// How many rays a source is sampled by.
pub(super) fn samples(default: usize) -> Or<Count<usize>> {
    Count::new(1, MAX_SAMPLES).or(default)
}

options! {
    /// What rays start nearest to: a line or a point.
    struct StartOptions {
        /// of a line
        axis: Option<DVec3> = Vector("").optional(""),
        /// a point of the line
        through: DVec3 = Vector("mm").or(DVec3::ZERO),
        /// instead of a line
        point: Option<DVec3> = Vector("mm").optional(""),
        radius: f64 = Number(Range::new(0.0, f64::INFINITY, "mm")).or(0.0),
    }
}

const START: Custom<StartOptions> = Custom {
    lua_type: "StartOptions",
    allowed: "",
    read: |_, _, value| StartOptions::read(START_OBJECT, value.clone()),
    shown: |_| String::new(),
};

const START_OBJECT: &str = "rayset: start";

impl StartOptions {
    fn surface(&self) -> mlua::Result<StartSurface> {
        let core = match (self.axis, self.point) {
            (Some(axis), None) => StartSurface::axis(self.through, axis)?,
            (None, Some(point)) => StartSurface::point(point)?,
            _ => {
                let problem = "expected either \"axis\" (with \"through\") or \"point\"";
                return Err(Error::inconsistent(START_OBJECT, problem).into());
            }
        };
        Ok(core.with_radius(self.radius)?)
    }
}

pub(super) fn placed(light: LuaLight, transform: &Transform) -> mlua::Result<LuaLight> {
    let placement = transform.placement("rayset: transform")?;
    let world_from_local = placement.affine() * light.rays.world_from_local;
    let moved = |part: &SceneObject| -> mlua::Result<SceneObject> {
        let mesh = part.mesh.0.mesh.transformed(&placement);
        mesh.check_positions("rayset: transform")?;
        Ok(SceneObject { mesh: LuaMesh::made(mesh), material: part.material.clone() })
    };
    let parts = light.parts.iter().map(moved).collect::<mlua::Result<_>>()?;
    Ok(LuaLight { rays: RaySet { world_from_local, ..light.rays }, parts, ..light })
}

options! {
    struct RaysetNewOptions {
        positions: Vec<DVec3> = vectors("mm"),
        directions: Vec<DVec3> = vectors(""),
        /// in all, or one for each ray
        flux: Fluxes = FLUXES,
        spectrum: Spectrum = SpectrumOrNumber::of_light(),
        /// how narrow the rays' own lobes are; 1 is Lambert's
        exponent: f64 = Number(EXPONENT).or(1.0),
    }
}

fn from_tables(lua: &Lua, mut arguments: Arguments) -> mlua::Result<LuaLight> {
    const OBJECT: &str = "rayset.new";
    let RaysetNewOptions { positions, directions, flux, spectrum, exponent } =
        arguments.record()?;
    if positions.len() != directions.len() || positions.is_empty() {
        let problem = format!(
            "{} positions and {} directions, expected as many of each, and one or more",
            positions.len(),
            directions.len()
        );
        return Err(Error::inconsistent(OBJECT, problem).into());
    }
    reserve_samples(lua, OBJECT, positions.len())?;
    let relative = flux.relative(OBJECT, positions.len())?;
    let mut samples = Vec::with_capacity(positions.len());
    for (at, (position, direction)) in positions.iter().zip(&directions).enumerate() {
        let Some(unit) = direction.try_normalize() else {
            let what = format!("\"directions\" entry {}", at + 1);
            return Err(Error::out_of_range(OBJECT, &what, direction, "any direction").into());
        };
        samples.push(RaySample {
            position: position.as_vec3().to_array(),
            direction: unit.as_vec3().to_array(),
            flux: relative[at] as f32,
        });
    }
    let rays = RaySet::new(samples.into(), flux.total_lm()).with_exponent(exponent)?;
    Ok(LuaLight::new(rays, spectrum))
}

/// lm of a set of rays.
pub(super) enum Fluxes {
    Total(f64),
    Each(Vec<f64>),
}

const FLUXES: Custom<Fluxes> = Custom {
    lua_type: "number|number[]",
    allowed: "above 0 lm",
    read: |object, what, value| {
        if !value.is_table() {
            return options::number(object, what, value, FLUX).map(Fluxes::Total);
        }
        let list =
            options::each(object, what, value, "a number of lm, or a list of them", |at, v| {
                options::number(object, &format!("{what} entry {at}"), v, Range::NOT_NEGATIVE)
            });
        list.map(Fluxes::Each)
    },
    shown: |_| String::new(),
};

impl Fluxes {
    fn total_lm(&self) -> f64 {
        match self {
            Self::Total(total) => *total,
            Self::Each(list) => list.iter().sum(),
        }
    }

    /// Relative to the largest, so that f32 holds them whatever their unit.
    fn relative(&self, object: &str, count: usize) -> mlua::Result<Vec<f64>> {
        let list = match self {
            Self::Total(_) => return Ok(vec![1.0; count]),
            Self::Each(list) => list,
        };
        if list.len() != count {
            let problem = format!("{} fluxes for {count} positions, expected one each", list.len());
            return Err(Error::inconsistent(object, problem).into());
        }
        let largest = list.iter().copied().fold(0.0, f64::max);
        if largest == 0.0 {
            return Err(Error::inconsistent(object, "\"flux\" is 0 throughout").into());
        }
        Ok(list.iter().map(|flux| flux / largest).collect())
    }
}

impl LuaLight {
    fn halves(&self, seed: u64) -> [Self; 2] {
        self.rays.halves(seed).map(|rays| Self { rays, ..self.clone() })
    }
}

options! {
    struct RaysetNoiseOptions {
        image: Function = Callback {
            lua_type: "fun(rays: Rayset): Image",
            expected: "a function that renders an image with the ray set that it is given",
        },
        /// of the first split
        seed: u64 = SEED,
        splits: u64 = Count::new(1, 1000).or(1),
    }
}

/// The relative error that a picture has from the number of rays alone: that of its luminance, from
/// pictures with disjoint halves of the set, which the script's `image` function takes.
fn noise(host: &Host, light: &LuaLight, mut arguments: Arguments) -> mlua::Result<f64> {
    const OBJECT: &str = "rayset:noise";
    let RaysetNoiseOptions { image: take, seed, splits } = arguments.record()?;
    if light.rays.samples.len() < 2 {
        return Err(Error::inconsistent(OBJECT, "a set of one ray has no halves").into());
    }
    host.note_seed(OBJECT, seed);
    let mut pairs: Vec<[f64; 2]> = Vec::new();
    for split in 0..splits {
        let pictures = light.halves(seed + split).map(|half| {
            let image: LuaImage =
                options::handle(OBJECT, "\"image\"'s result", &take.call(half)?, "an image")?;
            Ok::<_, mlua::Error>(image.luminances())
        });
        let [a, b] = pictures;
        pairs.extend(a?.into_iter().zip(b?).map(|(a, b)| [a, b]));
    }
    let error = noise::relative_error(pairs);
    error.ok_or_else(|| Error::inconsistent(OBJECT, "the pictures are black").into())
}

options! {
    struct RaysetHalvesOptions {
        seed: u64 = SEED,
    }
}

impl LuaLight {
    /// What the start points lie on; nothing for a cloud of them.
    fn start_surface(&self) -> Cell {
        let starts = Starts::of(&self.rays.samples);
        let is_source = starts.inner_source.is_none();
        starts.surface.map(|fit| START_SURFACE.record(&(fit, is_source))).into()
    }

    /// Every ray where it is in the scene.
    fn records(&self) -> Vec<Cell> {
        let lm_per_flux = self.rays.lm_per_flux();
        let ray = |sample: &RaySample| WorldRay {
            position: self.rays.world_origin(sample),
            direction: self.rays.world_direction(sample),
            flux_lm: f64::from(sample.flux) * lm_per_flux,
        };
        self.rays.samples.iter().map(|sample| RAY.record(&ray(sample))).collect()
    }
}

impl UserData for LuaLight {
    fn register(registry: &mut UserDataRegistry<Self>) {
        let mut members = Members::new(registry, "rayset");
        members.field("count", |_, this| Ok(this.rays.samples.len()));
        members.field("directions", |_, this| Ok(this.rays.exponent));
        members.field("flux", |_, this| Ok(this.rays.flux_lm));
        members.field("start_surface", |_, this| Ok(this.start_surface()));
        members.field("spectrum", |_, this| Ok(LuaSpectrum(Arc::clone(&this.spectrum))));
        members.method("transform", 1, |_, this, mut a| placed(this.clone(), &a.record()?));
        members.method("save", 1, |lua, this, mut a| {
            let path = a.text("path")?;
            let target = host::of(lua)?.output(&path)?;
            let format = SaveFormat::of(&target)?;
            Ok(output::save_rays(&target, &this.rays, &this.spectrum, format)?)
        });
        members.method("rays", 0, |_, this, _| Ok(this.records()));
        members.method("starting_at", 1, |_, this, mut a| {
            let start = a.value();
            let surface = StartOptions::read(START_OBJECT, start)?.surface()?;
            Ok(Self { rays: this.rays.clone().starting_at(&surface)?, ..this.clone() })
        });
        members.method("halves", 1, |lua, this, mut a| {
            let RaysetHalvesOptions { seed } = a.record()?;
            host::of(lua)?.note_seed("rayset:halves", seed);
            let [first, second] = this.halves(seed);
            Ok((first, second))
        });
        members.method("noise", 1, |lua, this, arguments| {
            let asks_for_nothing = arguments.is_empty();
            match table_of(this).filter(|_| asks_for_nothing) {
                Some(table) => Ok(table.noise()),
                None => noise(&host::of(lua)?, this, arguments),
            }
        });
        members.method("plot_luminance", 0, |_, this, _| plot_luminance(this));
        members.text(|this| {
            let (count, flux_lm) = (this.rays.samples.len(), this.rays.flux_lm);
            Ok(format!("rayset: {count} samples, {flux_lm} lm"))
        });
        members.no_others();
    }
}
