//! `lampyris.photometry`.

use std::sync::Arc;

use mlua::{Lua, Table, UserData, UserDataRegistry};

use super::kinds::{Handle, Kind, List, Naming, Number, Text, Vector};
use super::members::{Members, functions};
use super::options::{Arguments, Range};
use super::quality::{QUALITY, warn_of_target};
use super::record::options;
use super::scene::LuaScene;
use super::view::{DISTANCE, FOV, pixels};
use super::{grid_check, host, image};
use crate::error::Error;
use crate::geometry::DVec3;
use crate::output;
use crate::program::intensity::{self, Direction, IntensityGrid};
use crate::render::{Asked, Quality};
use crate::view::View;

/// Handle of a measured grid.
#[derive(Debug, Clone)]
pub struct LuaGrid(pub Arc<IntensityGrid>);

options! {
    struct GridOptions {
        /// with photometry = "absolute"
        scene: LuaScene = Handle::new("Scene", "a scene"),
        /// to the right, ascending
        h: Vec<f64> = angles(360.0).or(H_DEG.to_vec()),
        /// up, ascending
        v: Vec<f64> = angles(90.0).or(V_DEG.to_vec()),
        distance: f64 = DISTANCE,
        target: DVec3 = Vector("mm").or(DVec3::ZERO),
        /// the whole lamp has to fit
        fov: f64 = FOV,
        width: usize = pixels(320),
        height: usize = pixels(240),
        quality: Asked = QUALITY.or(Asked::Quality(Quality::default())),
    }
}

/// Angles up to `end` on both sides.
fn angles(end: f64) -> List<Number> {
    let entry = Number(Range::new(-end, end, "degrees"));
    List { entry, expected: "a list of angles in degrees", naming: Naming::Key }
}

/// Where UN R148 has its points.
const H_DEG: [f64; 7] = [-20.0, -10.0, -5.0, 0.0, 5.0, 10.0, 20.0];
const V_DEG: [f64; 5] = [-10.0, -5.0, 0.0, 5.0, 10.0];

pub(super) fn register(lua: &Lua, module: &Table) -> mlua::Result<()> {
    functions(lua, module, "photometry", |functions| functions.add("grid", 1, grid))
}

fn grid(lua: &Lua, mut arguments: Arguments) -> mlua::Result<LuaGrid> {
    let given: GridOptions = arguments.record()?;
    let host = host::of(lua)?;
    let prepared = given.scene.prepared(lua)?;
    let directions = given.h.len() * given.v.len();
    let progress = host.progress(given.width * given.height * directions);
    let measure = |direction: Direction| -> crate::Result<_> {
        let view = given.view(direction);
        let (rendered, stats) = given.quality.render(&prepared, &view, &progress)?;
        warn_of_target(&host, &stats);
        image::warn_of_cut_off(&host, &rendered, &view);
        intensity::intensity(&rendered, &view)
    };
    let flux_lm = given.scene.flux_lm();
    Ok(LuaGrid(Arc::new(IntensityGrid::sweep(given.h.clone(), given.v.clone(), flux_lm, measure)?)))
}

impl GridOptions {
    fn view(&self, Direction { h_deg, v_deg }: Direction) -> View {
        View {
            azimuth_deg: h_deg,
            elevation_deg: v_deg,
            distance_mm: self.distance,
            target: self.target,
            fov_deg: self.fov,
            width: self.width,
            height: self.height,
        }
    }
}

options! {
    struct GridSaveOptions {
        /// of the lamp
        name: String = Text("a name").or("lamp".to_owned()),
        /// .ies: the file's date of issue
        issued: Option<String> = Text("a date").optional("none"),
    }
}

impl LuaGrid {
    fn save(&self, lua: &Lua, mut arguments: Arguments) -> mlua::Result<()> {
        let path = arguments.text("path")?;
        let GridSaveOptions { name, issued } = arguments.record()?;
        let target = host::of(lua)?.output(&path)?;
        match target.extension().and_then(|e| e.to_str()) {
            Some("csv") => {
                let (header, rows) = self.0.table();
                Ok(output::write_csv(&target, header, rows)?)
            }
            Some("ies") => {
                Ok(output::write_text(&target, &self.0.to_ies(&name, issued.as_deref())?)?)
            }
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
    fn register(registry: &mut UserDataRegistry<Self>) {
        let mut members = Members::new(registry, "grid");
        members.field("h", |_, this| Ok(this.0.h_deg().to_vec()));
        members.field("v", |_, this| Ok(this.0.v_deg().to_vec()));
        members.field("flux", |_, this| Ok(this.0.flux_lm));
        members.method("at", 2, |_, this, mut arguments| {
            let h_deg = arguments.number("h", Range::ANY)?;
            let v_deg = arguments.number("v", Range::ANY)?;
            let xyz = this.0.at(Direction { h_deg, v_deg }).ok_or_else(|| {
                let found = format!("({h_deg}, {v_deg})");
                Error::out_of_range("grid:at", "direction", found, "angles inside the grid")
            })?;
            Ok(xyz.y)
        });
        members.method("check", 1, |lua, this, mut a| grid_check::check(lua, &this.0, a.value()));
        members.method("save", 2, |lua, this, a| this.save(lua, a));
        members.text(|this| {
            let (h, v) = (this.0.h_deg().len(), this.0.v_deg().len());
            let most = this.0.rows().map(|(_, xyz)| xyz.y).fold(0.0, f64::max);
            Ok(format!("photometric grid: {h} × {v} directions, up to {most:.4} cd"))
        });
        members.no_others();
    }
}
