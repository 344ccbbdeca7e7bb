//! `lampyris.photometry`.

use std::sync::Arc;

use mlua::{Lua, MetaMethod, Table, UserData, UserDataFields, UserDataMethods};

use super::options::{self, Arguments, Options, Range};
use super::quality::{ASKED_KEYS, asked, warn_of_target};
use super::scene::LuaScene;
use super::view::MAX_SIDE;
use super::{fault, grid_check, host, image};
use crate::error::Error;
use crate::geometry::DVec3;
use crate::output;
use crate::program::intensity::{self, Direction, Grid};
use crate::view::View;

/// Handle of a measured grid.
#[derive(Debug, Clone)]
pub struct LuaGrid(pub Arc<Grid>);

const NAMES: [&str; 6] = ["at", "check", "flux", "h", "save", "v"];
const KEYS: [&str; 9] =
    ["distance", "fov", "h", "height", "quality", "scene", "target", "v", "width"];

/// Where UN R148 has its points.
const H_DEG: [f64; 7] = [-20.0, -10.0, -5.0, 0.0, 5.0, 10.0, 20.0];
const V_DEG: [f64; 5] = [-10.0, -5.0, 0.0, 5.0, 10.0];

pub(super) fn register(lua: &Lua, module: &Table) -> mlua::Result<()> {
    let table = lua.create_table()?;
    table.set(
        "grid",
        fault::function(lua, |lua, a| grid(lua, Arguments::new("photometry.grid", a, 1)?))?,
    )?;
    fault::refuse_unknown_names(lua, &table, "lampyris.photometry")?;
    module.set("photometry", table)
}

fn grid(lua: &Lua, mut arguments: Arguments) -> mlua::Result<LuaGrid> {
    let options = arguments.options(&KEYS)?;
    let host = host::of(lua)?;
    let scene: LuaScene = options.required_handle("scene", "a scene")?;
    let quality_options =
        Options::new("photometry.grid: quality", options.value("quality")?, &ASKED_KEYS)?;
    let asked = asked(quality_options)?;
    let h_deg = angles(&options, "h", Range::new(-360.0, 360.0, "degrees"), &H_DEG)?;
    let v_deg = angles(&options, "v", Range::new(-90.0, 90.0, "degrees"), &V_DEG)?;
    let model = view(&options)?;
    let prepared = scene.prepared(&host)?;
    let progress = host.progress(model.pixels() * h_deg.len() * v_deg.len());
    let measure = |direction: Direction| -> crate::Result<_> {
        let Direction { h_deg, v_deg } = direction;
        let view = View { azimuth_deg: h_deg, elevation_deg: v_deg, ..model };
        let (rendered, stats) = asked.render(&prepared, &view, &progress)?;
        warn_of_target(&host, &stats);
        image::warn_of_cut_off(&host, &rendered, &view);
        intensity::intensity(&rendered, &view)
    };
    Ok(LuaGrid(Arc::new(Grid::sweep(h_deg, v_deg, scene.flux_lm(), measure)?)))
}

/// The view toward 0°, 0°.
fn view(options: &Options) -> mlua::Result<View> {
    Ok(View {
        azimuth_deg: 0.0,
        elevation_deg: 0.0,
        distance_mm: options.number_or("distance", Range::above_zero("mm"), 3000.0)?,
        target: options.vector("target")?.unwrap_or(DVec3::ZERO),
        fov_deg: options.number_or("fov", Range::between(0.0, 180.0, "degrees"), 6.0)?,
        width: options.count("width", 1, MAX_SIDE)?.unwrap_or(320) as usize,
        height: options.count("height", 1, MAX_SIDE)?.unwrap_or(240) as usize,
    })
}

fn angles(options: &Options, key: &str, range: Range, default: &[f64]) -> mlua::Result<Vec<f64>> {
    let Some(list) = options.list(key, "a list of angles in degrees")? else {
        return Ok(default.to_vec());
    };
    let what = format!("\"{key}\"");
    list.iter().map(|value| options::number(options.object(), &what, value, range)).collect()
}

impl LuaGrid {
    fn save(&self, lua: &Lua, mut arguments: Arguments) -> mlua::Result<()> {
        let path = arguments.text("path")?;
        let options = arguments.options(&["name"])?;
        let name = options.text("name")?.unwrap_or_else(|| "lamp".to_owned());
        let target = host::of(lua)?.output(&path)?;
        match target.extension().and_then(|e| e.to_str()) {
            Some("csv") => {
                let (header, rows) = self.0.table();
                Ok(output::write_csv(&target, header, rows)?)
            }
            Some("ies") => Ok(output::write_text(&target, &self.0.to_ies(&name))?),
            Some("ldt") => Ok(output::write_text(&target, &self.0.to_eulumdat(&name)?)?),
            _ => {
                let allowed = "names ending in .csv, .ies or .ldt";
                let found = format!("\"{path}\"");
                Err(Error::out_of_range("grid:save", "path", found, allowed).into())
            }
        }
    }
}

impl UserData for LuaGrid {
    fn add_fields<F: UserDataFields<Self>>(fields: &mut F) {
        fields.add_field_method_get("h", |_, this| Ok(this.0.h_deg().to_vec()));
        fields.add_field_method_get("v", |_, this| Ok(this.0.v_deg().to_vec()));
        fields.add_field_method_get("flux", |_, this| Ok(this.0.flux_lm));
    }

    fn add_methods<M: UserDataMethods<Self>>(methods: &mut M) {
        fault::method(methods, "at", |_, this: &Self, a| {
            let mut arguments = Arguments::new("grid:at", a, 2)?;
            let h_deg = arguments.number("h", Range::ANY)?;
            let v_deg = arguments.number("v", Range::ANY)?;
            let xyz = this.0.at(Direction { h_deg, v_deg }).ok_or_else(|| {
                let found = format!("({h_deg}, {v_deg})");
                Error::out_of_range("grid:at", "direction", found, "angles inside the grid")
            })?;
            Ok(xyz.y)
        });
        fault::method(methods, "check", |lua, this: &Self, a| {
            grid_check::check(lua, &this.0, Arguments::new("grid:check", a, 1)?.value())
        });
        fault::method(methods, "save", |lua, this: &Self, a| {
            this.save(lua, Arguments::new("grid:save", a, 2)?)
        });
        methods.add_meta_method(MetaMethod::ToString, |_, this, ()| {
            let (h, v) = (this.0.h_deg().len(), this.0.v_deg().len());
            let most = this.0.rows().map(|(_, xyz)| xyz.y).fold(0.0, f64::max);
            Ok(format!("photometric grid: {h} × {v} directions, up to {most:.4} cd"))
        });
        fault::refuse_unknown_fields(methods, "grid", &NAMES);
    }
}
