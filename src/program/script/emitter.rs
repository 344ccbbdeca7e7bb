//! `lampyris.cylinder`, `lampyris.filament`, `lampyris.bulb`: light sources made from geometry.

use mlua::{Lua, Table};

use super::host;
use super::kinds::{Choice, Flag, Handle, Kind, Nested, Number, SpectrumOrNumber, Vector};
use super::light::{FLUX, LuaLight, SEED, reserve_samples, samples};
use super::material::LuaMaterial;
use super::members::Functions;
use super::mesh::LuaMesh;
use super::options::{Arguments, Range};
use super::record::options;
use super::scene::SceneObject;
use crate::error::Error;
use crate::geometry::{DVec3, Mesh};
use crate::light::RaySet;
use crate::source::bulb::{Bulb, Function, Socket};
use crate::source::emitter::{Radiance, Shape, mesh_area, mesh_rayset};
use crate::source::{Coil, Cylinder, Emitter, Filament};
use crate::spectrum::Spectrum;

pub(super) fn register(lua: &Lua, module: &Table) -> mlua::Result<()> {
    let functions = Functions::of_module(lua, module);
    functions.add_kept("bulb", 2, bulb)?;
    functions.add_kept("cylinder", 1, cylinder)?;
    functions.add_kept("emitter", 1, emitter)?;
    functions.add_kept("filament", 1, filament)
}

options! {
    /// The comparison source of Fig. 8.
    struct CylinderOptions {
        radius: f64 = MM,
        length: f64 = MM,
        flux: f64 = Number(FLUX),
        spectrum: Spectrum = SpectrumOrNumber::of_light(),
        center: DVec3 = Vector("mm").or(DVec3::ZERO),
        axis: DVec3 = Vector("").or(DVec3::X),
        /// rays
        samples: usize = samples(10_000),
        /// of the samples
        seed: u64 = SEED,
        /// its surface is seen by camera, mirrored and transmitted rays
        visible: bool = Flag.or(false),
    }
}

options! {
    /// A surface that shines evenly: every place a Lambert emitter about its normal.
    struct EmitterOptions {
        /// counter-clockwise triangles shine; their backs are black
        mesh: LuaMesh = Handle::new("Mesh", "a mesh"),
        flux: Option<f64> = Number(FLUX).optional("from the radiance"),
        /// instead of the flux
        radiance: Option<f64> = Number(Range::above_zero("cd/m²")).optional("from the flux"),
        spectrum: Spectrum = SpectrumOrNumber::of_light(),
        /// for the lobes of other surfaces
        samples: usize = samples(10_000),
        /// of the samples
        seed: u64 = SEED,
        /// its surface is seen by camera, mirrored and transmitted rays
        visible: bool = Flag.or(true),
    }
}

options! {
    /// A coiled filament.
    struct FilamentOptions {
        wire_radius: f64 = MM,
        coil_radius: f64 = MM,
        /// of one turn
        pitch: f64 = MM,
        turns: f64 = Number(Range::above_zero("")),
        flux: f64 = Number(FLUX),
        spectrum: Spectrum = SpectrumOrNumber::of_light(),
        center: DVec3 = Vector("mm").or(DVec3::ZERO),
        axis: DVec3 = Vector("").or(DVec3::X),
        /// rays
        samples: usize = samples(100_000),
        /// of the samples
        seed: u64 = SEED,
        /// its coil is seen by camera, mirrored and transmitted rays
        visible: bool = Flag.or(false),
    }
}

const MM: Number = Number(Range::above_zero("mm"));

fn cylinder(lua: &Lua, mut arguments: Arguments) -> mlua::Result<LuaLight> {
    let given: CylinderOptions = arguments.record()?;
    host::of(lua)?.note_seed("cylinder", given.seed);
    reserve_samples(lua, "cylinder", given.samples)?;
    let cylinder = Cylinder {
        center: given.center,
        axis: given.axis,
        radius_mm: given.radius,
        length_mm: given.length,
        flux_lm: given.flux,
        samples: given.samples,
        seed: given.seed,
    };
    let surface = given.visible.then(|| cylinder.surface()).transpose()?;
    Ok(LuaLight { surface, ..LuaLight::new(cylinder.rayset()?, given.spectrum) })
}

fn emitter(lua: &Lua, mut arguments: Arguments) -> mlua::Result<LuaLight> {
    let given: EmitterOptions = arguments.record()?;
    host::of(lua)?.note_seed("emitter", given.seed);
    let mesh = given.mesh.0.mesh;
    let area_mm2 = mesh_area(&mesh);
    let flux_lm = match (given.flux, given.radiance) {
        (Some(flux_lm), None) => flux_lm,
        // Φ = π L A of a Lambert emitter.
        (None, Some(radiance)) => std::f64::consts::PI * radiance * area_mm2 * 1e-6,
        _ => {
            let problem = "expected either \"flux\" or \"radiance\"";
            return Err(Error::inconsistent("emitter", problem).into());
        }
    };
    let rays = mesh_rayset(&mesh, flux_lm, (given.samples, given.seed))?;
    let surface = Emitter { mesh, radiance: Radiance::Lambert { area_mm2 } };
    Ok(LuaLight {
        surface: given.visible.then_some(surface),
        ..LuaLight::new(rays, given.spectrum)
    })
}

fn filament(lua: &Lua, mut arguments: Arguments) -> mlua::Result<LuaLight> {
    let given: FilamentOptions = arguments.record()?;
    let host = host::of(lua)?;
    host.note_seed("filament", given.seed);
    reserve_samples(lua, "filament", given.samples)?;
    let filament = Filament {
        coil: Coil {
            wire_radius_mm: given.wire_radius,
            turns: given.turns,
            pitch_mm: given.pitch,
            coil_radius_mm: given.coil_radius,
        },
        center: given.center,
        axis: given.axis,
        flux_lm: given.flux,
        samples: given.samples,
        seed: given.seed,
    };
    let surface = given.visible.then(|| filament.surface()).transpose()?;
    Ok(LuaLight {
        surface,
        ..LuaLight::new(host.settings.cache.rayset(&filament)?, given.spectrum)
    })
}

options! {
    /// A bulb by its UN R37 category.
    struct BulbOptions {
        /// of the light
        center: DVec3 = Vector("mm").or(DVec3::ZERO),
        /// of the cap, pointing to the filament
        axis: DVec3 = Vector("").or(DVec3::Z),
        filament_axis: DVec3 = Vector("").or(DVec3::X),
        filament: Function = Choice(&[("major", Function::Major), ("minor", Function::Minor)])
            .or(Function::Major),
        flux: Option<f64> = Number(FLUX).optional("the category's"),
        spectrum: Option<Spectrum> = SpectrumOrNumber::of_light().optional("the category's"),
        /// rays
        samples: usize = samples(100_000),
        /// of the samples
        seed: u64 = SEED,
        /// its filament is seen by camera, mirrored and transmitted rays
        visible: bool = Flag.or(false),
        /// a hollow sphere about the light
        glass: Option<Glass> = Nested::new().optional("none"),
    }
}

options! {
    /// A bulb's glass: a hollow sphere about its light.
    struct Glass {
        /// outer
        radius: f64 = MM,
        thickness: f64 = MM,
        /// with ior, k_tg and transmittance
        material: LuaMaterial = Handle::new("Material", "a material"),
    }
}

impl Glass {
    fn part(&self, center: DVec3) -> mlua::Result<SceneObject> {
        if self.thickness >= self.radius {
            let allowed = format!("below the radius, {} mm", self.radius);
            let what = "\"thickness\"";
            return Err(Error::out_of_range("bulb: glass", what, self.thickness, allowed).into());
        }
        let sphere = |radius_mm| Shape::Sphere { center, radius_mm }.smooth_mesh();
        let outside = sphere(self.radius)?;
        let inside = sphere(self.radius - self.thickness)?.turned_inside_out();
        let mesh = Mesh::merged("bulb: glass", &[&outside, &inside])?;
        Ok(SceneObject { mesh: LuaMesh::made(mesh), material: self.material.clone() })
    }
}

/// A bulb by its UN R37 category; the light center is at the origin unless placed.
fn bulb(lua: &Lua, mut arguments: Arguments) -> mlua::Result<LuaLight> {
    let category = arguments.text("category")?;
    let given: BulbOptions = arguments.record()?;
    let bulb = Bulb::find(&category, given.filament)?;
    let host = host::of(lua)?;
    host.note_seed("bulb", given.seed);
    reserve_samples(lua, "bulb", given.samples)?;
    let BulbOptions { center, axis, filament_axis, .. } = given;
    let socket = Socket { center, axis, filament_axis };
    let filament = bulb.filament(&socket, given.samples, given.seed)?;
    let rays = host.settings.cache.rayset(&filament)?;
    let surface = given.visible.then(|| filament.surface()).transpose()?;
    let glass = given.glass.map(|glass| glass.part(center)).transpose()?;
    let flux_lm = given.flux.unwrap_or(rays.flux_lm);
    let spectrum = given.spectrum.unwrap_or_else(|| bulb.spectrum());
    let rays = RaySet { flux_lm, ..rays };
    let parts = glass.into_iter().collect();
    Ok(LuaLight { surface, parts, ..LuaLight::new(rays, spectrum) })
}
