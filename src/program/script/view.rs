//! `lampyris.view`.

use mlua::{Lua, Table, UserData, UserDataRegistry};

use super::kinds::{Count, Kind, Number, Or, Vector};
use super::members::{Functions, Members};
use super::options::{Arguments, Range};
use super::record::options;
use crate::geometry::DVec3;
use crate::program::results::VIEW;
use crate::view::View;

/// Handle of a view.
#[derive(Debug, Clone, Copy)]
pub struct LuaView(pub View);

/// Pixels a side: beyond this an image of 81 bands does not fit any machine.
pub(super) const MAX_SIDE: u64 = 65_536;

pub(super) fn register(lua: &Lua, module: &Table) -> mlua::Result<()> {
    Functions::of_module(lua, module).add("view", 1, |_, a| view(a))
}

options! {
    /// Where a picture is taken from.
    struct ViewOptions {
        /// to the right
        azimuth: f64 = Number(Range::new(-360.0, 360.0, "degrees")).or(View::FRONT.azimuth_deg),
        /// up
        elevation: f64 = Number(Range::new(-90.0, 90.0, "degrees")).or(View::FRONT.elevation_deg),
        /// from eye to target
        distance: f64 = DISTANCE,
        target: DVec3 = Vector("mm").or(View::FRONT.target),
        /// full vertical angle
        fov: f64 = FOV,
        width: usize = pixels(View::FRONT.width),
        height: usize = pixels(View::FRONT.height),
    }
}

pub(super) const DISTANCE: Or<Number> =
    Or { kind: Number(Range::above_zero("mm")), default: View::FRONT.distance_mm };
pub(super) const FOV: Or<Number> =
    Or { kind: Number(Range::between(0.0, 180.0, "degrees")), default: View::FRONT.fov_deg };

/// A side of a picture.
pub(super) fn pixels(default: usize) -> Or<Count<usize>> {
    Count::new(1, MAX_SIDE).of("pixels").or(default)
}

fn view(mut arguments: Arguments) -> mlua::Result<LuaView> {
    let ViewOptions { azimuth, elevation, distance, target, fov, width, height } =
        arguments.record()?;
    Ok(LuaView(View {
        azimuth_deg: azimuth,
        elevation_deg: elevation,
        distance_mm: distance,
        target,
        fov_deg: fov,
        width,
        height,
    }))
}

impl UserData for LuaView {
    fn register(registry: &mut UserDataRegistry<Self>) {
        let mut members = Members::new(registry, "view");
        members.record(&VIEW, |this| &this.0);
        members.text(|this| Ok(format!("view: {}", this.0)));
        members.no_others();
    }
}
