//! `lampyris.view`.

use mlua::{Lua, MetaMethod, Table, UserData, UserDataFields, UserDataMethods};

use super::fault;
use super::options::{Arguments, Range};
use crate::geometry::DVec3;
use crate::view::View;

/// Handle of a view.
#[derive(Debug, Clone, Copy)]
pub struct LuaView(pub View);

const KEYS: [&str; 7] = ["azimuth", "elevation", "distance", "target", "fov", "width", "height"];

/// Pixels a side: beyond this an image of 81 bands does not fit any machine.
pub(super) const MAX_SIDE: u64 = 65_536;

pub(super) fn register(lua: &Lua, module: &Table) -> mlua::Result<()> {
    module.set("view", fault::function(lua, |_, a| view(Arguments::new("view", a, 1)?))?)
}

fn view(mut arguments: Arguments) -> mlua::Result<LuaView> {
    let options = arguments.options(&KEYS)?;
    Ok(LuaView(View {
        azimuth_deg: options.number_or("azimuth", Range::new(-360.0, 360.0, "degrees"), 0.0)?,
        elevation_deg: options.number_or("elevation", Range::new(-90.0, 90.0, "degrees"), 0.0)?,
        distance_mm: options.number_or("distance", Range::above_zero("mm"), 3000.0)?,
        target: options.vector("target")?.unwrap_or(DVec3::ZERO),
        fov_deg: options.number_or("fov", Range::between(0.0, 180.0, "degrees"), 6.0)?,
        width: options.count("width", 1, MAX_SIDE)?.unwrap_or(640) as usize,
        height: options.count("height", 1, MAX_SIDE)?.unwrap_or(480) as usize,
    }))
}

impl UserData for LuaView {
    fn add_fields<F: UserDataFields<Self>>(fields: &mut F) {
        fields.add_field_method_get("azimuth", |_, this| Ok(this.0.azimuth_deg));
        fields.add_field_method_get("elevation", |_, this| Ok(this.0.elevation_deg));
        fields.add_field_method_get("distance", |_, this| Ok(this.0.distance_mm));
        fields.add_field_method_get("target", |_, this| Ok(this.0.target.to_array()));
        fields.add_field_method_get("fov", |_, this| Ok(this.0.fov_deg));
        fields.add_field_method_get("width", |_, this| Ok(this.0.width));
        fields.add_field_method_get("height", |_, this| Ok(this.0.height));
    }

    fn add_methods<M: UserDataMethods<Self>>(methods: &mut M) {
        methods
            .add_meta_method(MetaMethod::ToString, |_, this, ()| Ok(format!("view: {}", this.0)));
        fault::refuse_unknown_fields(methods, "view", &KEYS);
    }
}
