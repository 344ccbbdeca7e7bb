//! `scene:paths`: the rays of one pixel.

use mlua::Lua;

use super::kinds::{Kind, Number};
use super::options::{self, Arguments, Range};
use super::quality::TraceOptions;
use super::record::options;
use super::scene::LuaScene;
use super::view::LuaView;
use crate::program::fields::Cell;
use crate::program::results::PATH;
use crate::render::{self, Quality};

options! {
    struct PathOptions {
        /// image position in pixels, pixel 0's center being 0.5
        x: Option<f64> = Number(Range::ANY).optional("the middle"),
        y: Option<f64> = Number(Range::ANY).optional("the middle"),
        ..trace: TraceOptions,
    }
}

/// `scene:paths(view, {x =, y =})`.
pub(super) fn paths(scene: &LuaScene, lua: &Lua, mut arguments: Arguments) -> mlua::Result<Cell> {
    const OBJECT: &str = "scene:paths";
    let view: LuaView = arguments.handle("argument 1", "a view")?;
    let PathOptions { x, y, trace } = arguments.record()?;
    let place = |key: &str, given: Option<f64>, side: usize| {
        let place = given.unwrap_or(0.5 * side as f64);
        options::in_range(OBJECT, key, place, Range::new(0.0, side as f64, "pixels"))
    };
    let place = [place("\"x\"", x, view.0.width)?, place("\"y\"", y, view.0.height)?];
    let prepared = scene.prepared(lua)?;
    let quality = trace.quality(Quality::default().limits.light_error);
    Ok(PATH.list(&render::trace_paths(&prepared, &view.0, &quality, place)?))
}
