//! `grid:check`: a measured grid against what a regulation asks of a lamp.

use mlua::{Lua, Table, Value};

use super::host;
use super::options::{self, Options};
use super::photometry::LuaGrid;
use crate::error::Error;
use crate::program::intensity::{
    Grid, LampRules, Limits, PointCheck, Side, StopRatio, VisibilityField, Weakest,
};

const OBJECT: &str = "grid:check";
const KEYS: [&str; 5] = ["file", "lamp", "marked_d", "position", "side"];

/// `"S1"` of UN R148, or `{lamp =, file =, marked_d =, side =, position =}`.
pub(super) fn check(lua: &Lua, grid: &Grid, value: Value) -> mlua::Result<Table> {
    let value = match value {
        Value::Table(_) => value,
        name => {
            let options = lua.create_table()?;
            options.set("lamp", options::text(OBJECT, "lamp", &name)?)?;
            Value::Table(options)
        }
    };
    let rules = Rules::new(lua, &Options::new(OBJECT, value, &KEYS)?)?;
    let table = lua.create_table()?;
    let checks = rules.limits.check(grid);
    let mut passes = checks.iter().all(|check| check.passes);
    table.set("color", rules.limits.color.name())?;
    let rows = checks.iter().map(|check| point(lua, check));
    table.set("points", rows.collect::<mlua::Result<Vec<_>>>()?)?;
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
    field: Option<(VisibilityField, Side)>,
    ratio: Option<(StopRatio, LuaGrid)>,
}

impl Rules {
    fn new(lua: &Lua, options: &Options) -> mlua::Result<Self> {
        let lamp = options.required_text("lamp", "the name of a lamp in the limits")?;
        let (limits, known) = match options.text("file")? {
            None => (Limits::un_r148(&lamp)?, LampRules::un_r148(&lamp)),
            // Files of one's own hold points only.
            Some(path) => (Limits::load(&host::of(lua)?.input(&path)?, &lamp)?, None),
        };
        let unknown = |key: &str, what: &str| {
            let problem =
                format!("\"{key}\": UN R148, as far as it is known here, has no {what} for {lamp}");
            Error::inconsistent(OBJECT, problem)
        };
        let limits = if options.flag("marked_d", false)? {
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
        let sides = [("left", Side::Left), ("right", Side::Right)];
        let position = options.handle::<LuaGrid>("position", "the grid of the position lamp")?;
        Ok(Self {
            limits,
            field: options.choice("side", &sides)?.map(field).transpose()?,
            ratio: position.map(ratio).transpose()?,
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

fn point(lua: &Lua, check: &PointCheck) -> mlua::Result<Table> {
    let table = lua.create_table()?;
    table.set("h", check.requirement.direction.h_deg)?;
    table.set("v", check.requirement.direction.v_deg)?;
    table.set("min", check.requirement.min_cd)?;
    table.set("max", check.requirement.max_cd)?;
    table.set("intensity", check.intensity_cd)?;
    table.set("color", check.color.map(|color| color.name()))?;
    table.set("pass", check.passes)?;
    Ok(table)
}
