//! `scene:paths`: the rays of one pixel.

use mlua::{Lua, Table};

use super::host;
use super::options::{self, Arguments, Range};
use super::quality::quality;
use super::scene::LuaScene;
use super::view::LuaView;
use crate::render;
use crate::shading::{PathSegment, RayKind};

const KEYS: [&str; 5] = ["max_depth", "min_throughput", "wavelength_step", "x", "y"];

/// `scene:paths(view, {x =, y =})`: image position in pixels, pixel 0's center being 0.5.
pub(super) fn paths(
    lua: &Lua,
    scene: &LuaScene,
    mut arguments: Arguments,
) -> mlua::Result<Vec<Table>> {
    let value = arguments.value();
    let view: LuaView = options::handle("scene:paths", "argument 1", &value, "a view")?;
    let options = arguments.options(&KEYS)?;
    let (width, height) = (view.0.width as f64, view.0.height as f64);
    let x = options.number_or("x", Range::new(0.0, width, "pixels"), 0.5 * width)?;
    let y = options.number_or("y", Range::new(0.0, height, "pixels"), 0.5 * height)?;
    let prepared = scene.prepared(&host::of(lua)?)?;
    let segments = render::trace_paths(&prepared, &view.0, &quality(options)?, [x, y])?;
    segments.iter().map(|segment| segment_table(lua, segment)).collect()
}

fn segment_table(lua: &Lua, segment: &PathSegment) -> mlua::Result<Table> {
    let table = lua.create_table()?;
    let kind = match segment.kind {
        RayKind::Camera => "camera",
        RayKind::Mirrored => "mirrored",
        RayKind::Transmitted => "transmitted",
    };
    table.set("kind", kind)?;
    table.set("depth", segment.depth)?;
    table.set("start", segment.start.to_array())?;
    table.set("direction", segment.direction.to_array())?;
    table.set("throughput", segment.throughput)?;
    if let Some(end) = segment.end {
        table.set("finish", end.point.to_array())?;
        table.set("normal", end.normal.to_array())?;
        table.set("object", end.object + 1)?;
    }
    Ok(table)
}
