//! `grid:check`: a measured grid against what a regulation asks of a lamp.

use mlua::{Lua, Table, Value};

use super::host;
use super::kinds::{Choice, Flag, Handle, Kind, Text};
use super::options;
use super::photometry::LuaGrid;
use super::record::{Record, options};
use crate::error::Error;
use crate::program::intensity::{
    IntensityGrid, LampRules, Limits, RoadSide, StopRatio, VisibilityField, Weakest,
};
use crate::program::results::POINT;

const OBJECT: &str = "grid:check";

options! {
    struct GridCheckOptions {
        /// a lamp of the file
        lamp: String = Text("the name of a lamp in the limits"),
        /// CSV: lamp, color, h, v, min, max
        file: Option<String> = Text("a file").optional("UN R148"),
        /// the maximum of lamps marked "D"
        marked_d: bool = Flag.or(false),
        /// of the vehicle as seen from behind: checks the field of visibility
        side: Option<RoadSide> = Choice(&[("left", RoadSide::Left), ("right", RoadSide::Right)]).optional(""),
        /// of the position lamp combined with this stop lamp: checks their ratio
        position: Option<LuaGrid> = Handle::new("Grid", "the grid of the position lamp").optional(""),
    }
}

/// `"S1"` of UN R148, or `{lamp =, file =, marked_d =, side =, position =}`.
pub(super) fn check(lua: &Lua, grid: &IntensityGrid, value: Value) -> mlua::Result<Table> {
    let value = match value {
        Value::Table(_) => value,
        name => {
            let options = lua.create_table()?;
            options.set("lamp", options::text(OBJECT, "lamp", &name)?)?;
            Value::Table(options)
        }
    };
    let rules = Rules::new(lua, Record::read(OBJECT, value)?)?;
    let table = lua.create_table()?;
    let checks = rules.limits.check(grid);
    let mut passes = checks.iter().all(|check| check.passes);
    table.set("color", rules.limits.color.name())?;
    table.set("points", POINT.list(&checks))?;
    if let Some((field, side)) = rules.field {
        let weakest = field.weakest(grid, side)?;
        passes &= weakest.value >= field.min_cd;
        table.set("field", weakest_table(lua, "intensity", weakest, field.min_cd)?)?;
    }
    if let Some((ratio, position)) = &rules.ratio {
        let weakest = ratio.weakest(grid, &position.0)?;
        passes &= weakest.value >= ratio.min;
        table.set("ratio", weakest_table(lua, "ratio", weakest, ratio.min)?)?;
    }
    table.set("pass", passes)?;
    Ok(table)
}

/// What a grid is checked against.
struct Rules {
    limits: Limits,
    field: Option<(VisibilityField, RoadSide)>,
    ratio: Option<(StopRatio, LuaGrid)>,
}

impl Rules {
    fn new(lua: &Lua, given: GridCheckOptions) -> mlua::Result<Self> {
        let lamp = given.lamp;
        let (limits, known) = match given.file {
            None => (Limits::un_r148(&lamp)?, LampRules::un_r148(&lamp)),
            // Files of one's own hold points only.
            Some(path) => (Limits::load(&host::of(lua)?.input(&path)?, &lamp)?, None),
        };
        let unknown = |key: &str, what: &str| {
            let problem =
                format!("\"{key}\": UN R148, as far as it is known here, has no {what} for {lamp}");
            Error::inconsistent(OBJECT, problem)
        };
        let limits = if given.marked_d {
            let max_cd = known.and_then(|rules| rules.max_d_cd);
            limits.with_max(max_cd.ok_or_else(|| unknown("marked_d", "maximum"))?)
        } else {
            limits
        };
        let field = |side| {
            let rules = known.ok_or_else(|| unknown("side", "field of visibility"))?;
            Ok::<_, Error>((rules.field, side))
        };
        let ratio = |position| {
            let ratio = known.and_then(|rules| rules.ratio);
            Ok::<_, Error>((ratio.ok_or_else(|| unknown("position", "ratio"))?, position))
        };
        Ok(Self {
            limits,
            field: given.side.map(field).transpose()?,
            ratio: given.position.map(ratio).transpose()?,
        })
    }
}

fn weakest_table(lua: &Lua, what: &str, weakest: Weakest, min: f64) -> mlua::Result<Table> {
    let table = lua.create_table()?;
    table.set("h", weakest.direction.h_deg)?;
    table.set("v", weakest.direction.v_deg)?;
    table.set(what, weakest.value)?;
    table.set("min", min)?;
    table.set("pass", weakest.value >= min)?;
    Ok(table)
}
