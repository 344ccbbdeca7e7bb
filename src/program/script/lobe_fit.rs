//! `lampyris.fit_lobe`.

use mlua::{Lua, Table, Value};

use super::figure::LuaFigure;
use super::kinds::{Choice, Count, Kind, List, Naming, Number, Numbers, Text, missing, numbers};
use super::members::Functions;
use super::options::{self, Arguments, Range};
use super::record::options;
use super::spectrum::COLUMN;
use super::{fault, host};
use crate::material::{self, LobeCount, LobeFit, LobeSpace, LobeTable, Peak, about_peak, fit_lobe};
use crate::program::figure::{Chart, ChartAxis, Panel, Series};
use crate::program::results::{LOBE, LOBE_FIT};

options! {
    struct LobeFitOptions {
        /// {{angle, value}, …}, degrees from the lobe's direction
        points: Option<Vec<[f64; 2]>> = List {
            entry: Numbers { range: Range::ANY, expected: "{angle, value}" },
            expected: "a list of {angle, value}, or \"file\"",
            naming: Naming::Row,
        }.optional(""),
        /// instead of points: a CSV file of angle and value
        file: Option<String> = Text("a file").optional(""),
        /// of the values in the file
        column: usize = COLUMN,
        /// of a file of scatter: the measured one nearest to this
        incidence: Option<f64> = Number(Range::new(0.0, 90.0, "degrees")).optional("the first"),
        /// where the lobe is, for angles from elsewhere; "auto" finds it
        peak: Peak = PeakKind.or(Peak::AtZero),
        /// {from, to}
        range: [f64; 2] = Numbers {
            range: Range::new(0.0, 90.0, "degrees"),
            expected: "{from, to} in degrees",
        }.or([0.0, 90.0]),
        /// one for each point
        weights: Option<Vec<f64>> = numbers(Range::NOT_NEGATIVE).optional("1"),
        lobes: u32 = Count::new(1, 2).or(1),
        /// what least squares are taken of
        space: LobeSpace = Choice(&[("linear", LobeSpace::Linear), ("log", LobeSpace::Log)])
            .or(LobeSpace::Linear),
    }
}

/// An angle, or "auto".
struct PeakKind;

impl Kind for PeakKind {
    type Read = Peak;

    fn read(&self, object: &str, what: &str, value: &Value) -> mlua::Result<Peak> {
        match value {
            Value::String(_) => {
                let word = options::text(object, what, value)?;
                options::choice(object, what, &word, &[("auto", Peak::Found)])
            }
            _ => options::number(object, what, value, PEAKS).map(Peak::At),
        }
    }

    fn lua_type(&self) -> String {
        "number|\"auto\"".to_owned()
    }

    fn expected(&self) -> String {
        format!("a number, {PEAKS}, or \"auto\"")
    }

    fn allowed(&self) -> String {
        PEAKS.to_string()
    }

    fn shown(&self, _: &Peak) -> String {
        "0".to_owned()
    }
}

const PEAKS: Range = Range::new(-180.0, 180.0, "degrees");

pub(super) fn register(lua: &Lua, module: &Table) -> mlua::Result<()> {
    Functions::of_module(lua, module).add("fit_lobe", 1, fit)
}

fn fit(lua: &Lua, mut arguments: Arguments) -> mlua::Result<Table> {
    let given: LobeFitOptions = arguments.record()?;
    let points = about_peak(&points(lua, &given)?, given.peak)?;
    let count = if given.lobes == 2 { LobeCount::Two } else { LobeCount::One };
    let weights = given.weights.as_deref();
    let table = LobeTable { points: &points, weights, range_deg: given.range };
    let fit = fit_lobe(&table, count, given.space)?;
    let plot = LuaFigure::of_panel(Panel::Chart(chart(&points, &fit, given.space)));
    result(lua, fit, plot)
}

/// `points = {{angle, value}, …}`, or two columns of `file`.
fn points(lua: &Lua, given: &LobeFitOptions) -> mlua::Result<Vec<(f64, f64)>> {
    if let Some(path) = &given.file {
        return Ok(material::read_lobe(
            &host::of(lua)?.input(path)?,
            given.column,
            given.incidence,
        )?
        .points);
    }
    let expected = "a list of {angle, value}, or \"file\"";
    let points = given.points.as_ref().ok_or_else(|| missing("fit_lobe", "points", expected))?;
    Ok(points.iter().map(|&[angle, value]| (angle, value)).collect())
}

/// The first lobe's figures at the top, all of them under `lobes`, `eval` of the sum, and `plot`.
fn result(lua: &Lua, fit: LobeFit, plot: LuaFigure) -> mlua::Result<Table> {
    let first = fit.lobes.iter().take(1).flat_map(|lobe| LOBE.cells(lobe));
    let table = lua.create_table_from(first.chain(LOBE_FIT.cells(&fit)))?;
    table.set("plot", plot)?;
    let eval = fault::function(lua, move |_, a| {
        let angles = Range::between(-90.0, 90.0, "degrees");
        Ok(fit.eval(Arguments::new("fit_lobe: eval", a, 1)?.number("angle", angles)?))
    })?;
    table.set("eval", eval)?;
    Ok(table)
}

/// The measured points and the sum of lobes, as Fig. 3 shows them, in the space of the fit.
fn chart(points: &[(f64, f64)], fit: &LobeFit, space: LobeSpace) -> Chart {
    /// As many as a figure has pixels across.
    const STEPS: usize = 800;
    let ends = points.iter().map(|point| point.0);
    let (first, last) =
        ends.fold((0.0, 0.0), |(low, high): (f64, f64), x| (low.min(x), high.max(x)));
    let angle = |step: usize| first + (last - first) * step as f64 / STEPS as f64;
    let curve = (0..=STEPS).map(|step| [angle(step), fit.eval(angle(step))]).collect();
    let name: Vec<String> = fit.lobes.iter().map(|lobe| format!("n = {:.0}", lobe.n)).collect();
    Chart {
        title: String::new(),
        x: ChartAxis::linear("angle from the lobe's direction (degrees)"),
        y: match space {
            LobeSpace::Linear => ChartAxis::linear("measured value"),
            LobeSpace::Log => ChartAxis::log("measured value"),
        },
        series: vec![
            Series::scatter("measured", points.iter().map(|&(x, y)| [x, y]).collect()),
            Series::line(&format!("fit, {}", name.join(" and ")), curve),
        ],
    }
}
