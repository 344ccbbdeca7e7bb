//! `lampyris.cylinder`, `lampyris.filament`, `lampyris.bulb`: light sources made from geometry.

use std::sync::Arc;

use mlua::{Lua, Table};

use super::light::{FLUX, LuaLight, MAX_SAMPLES, required_spectrum, seed};
use super::options::{Arguments, Options, Range};
use super::{fault, host};
use crate::geometry::DVec3;
use crate::light::RaySet;
use crate::source::bulb::{Bulb, Function, Socket};
use crate::source::{Coil, Cylinder, Filament};

pub(super) fn register(lua: &Lua, module: &Table) -> mlua::Result<()> {
    module.set("bulb", fault::function(lua, |lua, a| bulb(lua, Arguments::new("bulb", a, 2)?))?)?;
    module.set(
        "cylinder",
        fault::function(lua, |lua, a| cylinder(lua, Arguments::new("cylinder", a, 1)?))?,
    )?;
    module.set(
        "filament",
        fault::function(lua, |lua, a| filament(lua, Arguments::new("filament", a, 1)?))?,
    )
}

fn samples(options: &Options, default: u64) -> mlua::Result<usize> {
    Ok(options.count("samples", 1, MAX_SAMPLES)?.unwrap_or(default) as usize)
}

fn cylinder(lua: &Lua, mut arguments: Arguments) -> mlua::Result<LuaLight> {
    let keys = ["axis", "center", "flux", "length", "radius", "samples", "seed", "spectrum"];
    let options = arguments.options(&keys)?;
    let cylinder = Cylinder {
        center: options.vector("center")?.unwrap_or(DVec3::ZERO),
        axis: options.vector("axis")?.unwrap_or(DVec3::X),
        radius_mm: options.required_number("radius", Range::above_zero("mm"))?,
        length_mm: options.required_number("length", Range::above_zero("mm"))?,
        flux_lm: options.required_number("flux", FLUX)?,
        samples: samples(&options, 10_000)?,
        seed: seed(&host::of(lua)?, &options)?,
    };
    let spectrum = Arc::new(required_spectrum(&options)?);
    Ok(LuaLight { rays: cylinder.rayset()?, spectrum })
}

fn filament(lua: &Lua, mut arguments: Arguments) -> mlua::Result<LuaLight> {
    let keys = [
        "axis",
        "center",
        "coil_radius",
        "flux",
        "pitch",
        "samples",
        "seed",
        "spectrum",
        "turns",
        "wire_radius",
    ];
    let options = arguments.options(&keys)?;
    let mm = Range::above_zero("mm");
    let filament = Filament {
        coil: Coil {
            wire_radius_mm: options.required_number("wire_radius", mm)?,
            turns: options.required_number("turns", Range::above_zero(""))?,
            pitch_mm: options.required_number("pitch", mm)?,
            coil_radius_mm: options.required_number("coil_radius", mm)?,
        },
        center: options.vector("center")?.unwrap_or(DVec3::ZERO),
        axis: options.vector("axis")?.unwrap_or(DVec3::X),
        flux_lm: options.required_number("flux", FLUX)?,
        samples: samples(&options, 100_000)?,
        seed: seed(&host::of(lua)?, &options)?,
    };
    let spectrum = Arc::new(required_spectrum(&options)?);
    Ok(LuaLight { rays: filament.rayset()?, spectrum })
}

/// A bulb by its UN R37 category; the light center is at the origin unless placed.
fn bulb(lua: &Lua, mut arguments: Arguments) -> mlua::Result<LuaLight> {
    let category = arguments.text("category")?;
    let keys =
        ["axis", "center", "filament", "filament_axis", "flux", "samples", "seed", "spectrum"];
    let options = arguments.options(&keys)?;
    let functions = [("major", Function::Major), ("minor", Function::Minor)];
    let function = options.choice("filament", &functions)?.unwrap_or(Function::Major);
    let bulb = Bulb::find(&category, function)?;
    let socket = Socket {
        center: options.vector("center")?.unwrap_or(DVec3::ZERO),
        axis: options.vector("axis")?.unwrap_or(DVec3::Z),
        filament_axis: options.vector("filament_axis")?.unwrap_or(DVec3::X),
    };
    let rays =
        bulb.rayset(&socket, samples(&options, 100_000)?, seed(&host::of(lua)?, &options)?)?;
    let flux_lm = options.number_or("flux", FLUX, rays.flux_lm)?;
    let spectrum = options.spectrum("spectrum")?.unwrap_or_else(|| bulb.spectrum());
    Ok(LuaLight { rays: RaySet { flux_lm, ..rays }, spectrum: Arc::new(spectrum) })
}
