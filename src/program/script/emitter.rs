//! `lampyris.cylinder`, `lampyris.filament`, `lampyris.bulb`: light sources made from geometry.

use std::sync::Arc;

use mlua::{Lua, Table};

use super::kinds::{Choice, Kind, Number, SpectrumOrNumber, Vector};
use super::light::{FLUX, LuaLight, SEED, samples};
use super::options::{Arguments, Range};
use super::record::options;
use super::{fault, host};
use crate::geometry::DVec3;
use crate::light::RaySet;
use crate::source::bulb::{Bulb, Function, Socket};
use crate::source::{Coil, Cylinder, Filament};
use crate::spectrum::Spectrum;

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
    }
}

const MM: Number = Number(Range::above_zero("mm"));

fn cylinder(lua: &Lua, mut arguments: Arguments) -> mlua::Result<LuaLight> {
    let given: CylinderOptions = arguments.record()?;
    host::of(lua)?.note_seed("cylinder", given.seed);
    let cylinder = Cylinder {
        center: given.center,
        axis: given.axis,
        radius_mm: given.radius,
        length_mm: given.length,
        flux_lm: given.flux,
        samples: given.samples,
        seed: given.seed,
    };
    Ok(LuaLight { rays: cylinder.rayset()?, spectrum: Arc::new(given.spectrum) })
}

fn filament(lua: &Lua, mut arguments: Arguments) -> mlua::Result<LuaLight> {
    let given: FilamentOptions = arguments.record()?;
    host::of(lua)?.note_seed("filament", given.seed);
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
    Ok(LuaLight { rays: filament.rayset()?, spectrum: Arc::new(given.spectrum) })
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
    }
}

/// A bulb by its UN R37 category; the light center is at the origin unless placed.
fn bulb(lua: &Lua, mut arguments: Arguments) -> mlua::Result<LuaLight> {
    let category = arguments.text("category")?;
    let given: BulbOptions = arguments.record()?;
    let bulb = Bulb::find(&category, given.filament)?;
    host::of(lua)?.note_seed("bulb", given.seed);
    let BulbOptions { center, axis, filament_axis, .. } = given;
    let rays = bulb.rayset(&Socket { center, axis, filament_axis }, given.samples, given.seed)?;
    let flux_lm = given.flux.unwrap_or(rays.flux_lm);
    let spectrum = given.spectrum.unwrap_or_else(|| bulb.spectrum());
    Ok(LuaLight { rays: RaySet { flux_lm, ..rays }, spectrum: Arc::new(spectrum) })
}
