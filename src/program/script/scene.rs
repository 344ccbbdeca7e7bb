//! `lampyris.scene` and `scene:render`.

use std::sync::Arc;

use mlua::{Lua, Table, UserData, UserDataRegistry, Value};

use super::environment::BackgroundKind;
use super::host::{Host, Settings};
use super::image::LuaImage;
use super::kinds::{
    Choice, Count, Flag, Handle, Kind, List, Naming, Nested, Number, SpectrumOrNumber, any,
};
use super::light::{LuaLight, SEED, samples};
use super::material::LuaMaterial;
use super::members::{Functions, Members};
use super::mesh::LuaMesh;
use super::options::{Arguments, Range};
use super::quality::{TraceOptions, asked, light_error, warn_of_target};
use super::record::{Record, options};
use super::view::LuaView;
use super::{host, paths};
use crate::color::Photometry;
use crate::error::Error;
use crate::material::Material;
use crate::program::fields::Cell;
use crate::program::results::LIGHT_CHECK;
use crate::program::screen;
use crate::program::stage::Stage;
use crate::render;
use crate::render::Asked;
use crate::scene::{
    self, Background, Interreflection, Light, MaterialId, Prepared, Scene, Shadows,
};
use crate::spectrum::{Spectrum, WavelengthGrid};
use crate::view::View;

/// Handle of a scene; prepared at its first render and then kept.
#[derive(Debug, Clone)]
pub struct LuaScene(pub Arc<Stage>);

options! {
    struct SceneOptions {
        objects: Vec<Value> = List {
            entry: any("SceneObject"),
            expected: "a list of {mesh =, material =}",
            naming: Naming::Key,
        },
        lights: Vec<LuaLight> = List {
            entry: Handle::new("Rayset", "a list of raysets"),
            expected: "a list of raysets",
            naming: Naming::Key,
        }.or(Vec::new()),
        background: Background = BackgroundKind
            .or(Background::Even(Spectrum::constant(0.0))),
        ambient: Spectrum = SpectrumOrNumber::new("0 or more").or(Spectrum::constant(0.0)),
        photometry: Photometry = Choice(&[
            ("relative", Photometry::Relative),
            ("absolute", Photometry::Absolute),
        ]).or(Photometry::Relative),
        /// whether opaque surfaces hide light samples
        shadows: Option<bool> = Flag.optional("false, or true in absolute photometry"),
        /// surfaces of different objects that are this near are one interface
        contact: f64 = Number(Range::new(0.0, 1000.0, "mm")).or(0.0),
        /// light that surfaces return diffusely lights others; absolute photometry only
        interreflection: Option<InterreflectionOptions> = Nested::new().optional("none"),
    }
}

options! {
    /// Light that surfaces return diffusely becomes light samples.
    struct InterreflectionOptions {
        /// diffuse returns that light may go through
        bounces: u32 = Count::new(1, 1000).or(4),
        /// light samples, about
        samples: usize = samples(100_000),
        /// of the samples
        seed: u64 = SEED,
        /// samples for each light, so that layers of lights hold what surfaces pass on of them; else lights of one spectrum share them
        by_light: bool = Flag.or(false),
    }
}

options! {
    #[derive(Debug, Clone)]
    struct SceneObject {
        mesh: LuaMesh = Handle::new("Mesh", "a mesh"),
        material: LuaMaterial = Handle::new("Material", "a material"),
    }
}

pub(super) fn register(lua: &Lua, module: &Table) -> mlua::Result<()> {
    Functions::of_module(lua, module).add("scene", 1, new)
}

fn new(lua: &Lua, mut arguments: Arguments) -> mlua::Result<LuaScene> {
    let given: SceneOptions = arguments.record()?;
    let mut parts = SceneParts::default();
    for (at, value) in (1..).zip(given.objects) {
        parts.add(SceneObject::read(&format!("scene: object {at}"), value)?);
    }
    let mut light = |LuaLight { rays, spectrum, surface, parts: own }| {
        own.iter().for_each(|part| parts.add(part.clone()));
        Light { rays, spectrum: Arc::unwrap_or_clone(spectrum), surface }
    };
    let lights = given.lights.into_iter().map(&mut light).collect();
    let shadows = given.shadows.unwrap_or(given.photometry == Photometry::Absolute);
    let scene = Scene {
        lights,
        background: given.background,
        ambient: given.ambient,
        photometry: given.photometry,
        shadows: if shadows { Shadows::On } else { Shadows::Off },
        contact_mm: given.contact,
        interreflection: given.interreflection.map(|asked| {
            let InterreflectionOptions { bounces, samples, seed, by_light } = asked;
            Interreflection { bounces, samples, seed, by_light }
        }),
        objects: parts.objects,
        materials: parts.materials.iter().map(|m| Material::clone(m)).collect(),
    };
    scene.check()?;
    let host = host::of(lua)?;
    scene.warnings().into_iter().for_each(|warning| host.warn(warning));
    let Settings { in_use, cache, .. } = &host.settings;
    Ok(LuaScene(Arc::new(Stage::new(scene, in_use.clone(), cache.clone()))))
}

#[derive(Default)]
struct SceneParts {
    objects: Vec<scene::Object>,
    materials: Vec<Arc<Material>>,
}

impl SceneParts {
    /// A material handle used twice is one material of the scene.
    fn add(&mut self, object: SceneObject) {
        let material = object.material.0;
        let known = self.materials.iter().position(|m| Arc::ptr_eq(m, &material));
        let material = known.unwrap_or_else(|| {
            self.materials.push(material);
            self.materials.len() - 1
        });
        self.objects
            .push(scene::Object { mesh: object.mesh.0.mesh, material: MaterialId(material) });
    }
}

impl LuaScene {
    /// Built at the first call, which warns of what looks unintended.
    pub(super) fn prepared(&self, lua: &Lua) -> mlua::Result<Arc<Prepared>> {
        self.reserve(lua)?;
        let host = host::of(lua)?;
        Ok(self.0.prepared(&|warning| host.warn(warning))?)
    }

    /// Room for the trees, as long as they are not there yet.
    pub(super) fn reserve(&self, lua: &Lua) -> mlua::Result<()> {
        /// As measured, with what building takes.
        const BYTES_A_TRIANGLE: usize = 400;
        const BYTES_A_SAMPLE: usize = 200;
        if self.0.is_prepared() {
            return Ok(());
        }
        let Scene { objects, lights, interreflection, .. } = &self.0.scene;
        let triangles: usize = objects.iter().map(|object| object.mesh.triangles.len()).sum();
        let bounced = interreflection.map_or(0, |asked| asked.samples);
        let samples = lights.iter().map(|l| l.rays.samples.len()).sum::<usize>() + bounced;
        let bytes = triangles * BYTES_A_TRIANGLE + samples * BYTES_A_SAMPLE;
        host::reserve(lua, "scene: its trees", bytes, "fewer triangles or light samples would fit")
    }

    pub(super) fn flux_lm(&self) -> f64 {
        self.0.scene.lights.iter().map(|light| light.rays.flux_lm).sum()
    }

    fn render(&self, lua: &Lua, mut arguments: Arguments) -> mlua::Result<LuaImage> {
        let view: LuaView = arguments.handle("argument 1", "a view")?;
        let asked = asked("scene:render", arguments.value())?;
        let host = host::of(lua)?;
        reserve_picture(lua, "scene:render", &view.0, &asked)?;
        let prepared = self.prepared(lua)?;
        warn_of_view(&host, &prepared, &view.0);
        let progress = host.progress(view.0.pixels());
        let screen = host.settings.screen.as_deref();
        let (mut image, stats, number) =
            screen::render(screen, &asked, &prepared, &view.0, &progress)?;
        warn_of_target(&host, &stats);
        let reason = render::why_black(&image, &prepared, &view.0, asked.limits())?;
        reason.into_iter().for_each(|reason| host.warn(reason));
        image.metadata.insert("script".to_owned(), host.script_name());
        Ok(LuaImage::new(image, stats, &prepared, number))
    }
}

options! {
    struct LightErrorOptions {
        hits: usize = Count::new(1, 1_000_000).or(300),
        light_error: f64 = light_error(),
        ..trace: TraceOptions,
    }
}

impl LuaScene {
    /// Relative errors of the light sums at some hits, and how much faster they are than exact ones.
    fn check_light_error(&self, lua: &Lua, mut arguments: Arguments) -> mlua::Result<Cell> {
        let view: LuaView = arguments.handle("argument 1", "a view")?;
        let LightErrorOptions { hits, light_error, trace } = arguments.record()?;
        let quality = trace.quality(light_error);
        let prepared = self.prepared(lua)?;
        let check = render::check_light_error(&prepared, &view.0, &quality, hits)?;
        let check = check.ok_or_else(|| {
            let problem = "no light arrives at what the view shows";
            Error::inconsistent("scene:check_light_error", problem)
        })?;
        Ok(LIGHT_CHECK.record(&check))
    }
}

/// Room for a picture and the film that becomes it.
pub(super) fn reserve_picture(
    lua: &Lua,
    object: &str,
    view: &View,
    asked: &Asked,
) -> mlua::Result<()> {
    let grid = match asked {
        Asked::Quality(quality) => quality.grid,
        Asked::TargetError(_) => WavelengthGrid::Step5,
    };
    /// Memory of the film's statistics.
    const BYTES_A_PIXEL: usize = 64;
    let bytes_a_pixel = 2 * size_of::<f32>() * grid.bands() + BYTES_A_PIXEL;
    let bytes = view.pixels().saturating_mul(bytes_a_pixel);
    let object = format!("{object}: a picture of {} × {} pixels", view.width, view.height);
    host::reserve(lua, &object, bytes, "fewer pixels, or a larger wavelength_step, would fit")
}

pub(super) fn warn_of_view(host: &Host, prepared: &Prepared, view: &View) {
    scene::plausibility::of_view(prepared, view).into_iter().for_each(|warning| host.warn(warning));
}

impl UserData for LuaScene {
    fn register(registry: &mut UserDataRegistry<Self>) {
        let mut members = Members::new(registry, "scene");
        members.method("render", 2, |lua, this, a| this.render(lua, a));
        members.method("check_light_error", 2, |lua, this, a| this.check_light_error(lua, a));
        members.method("paths", 2, |lua, this, a| paths::paths(this, lua, a));
        members.text(|this| {
            let scene = &this.0.scene;
            let triangles: usize = scene.objects.iter().map(|o| o.mesh.triangles.len()).sum();
            Ok(format!(
                "scene: {} objects, {triangles} triangles, {} lights",
                scene.objects.len(),
                scene.lights.len()
            ))
        });
        members.no_others();
    }
}
