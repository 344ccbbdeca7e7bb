//! `lampyris.fit_lobe`.

use mlua::{Lua, Table, Value};

use super::figure::LuaFigure;
use super::options::{self, Arguments, Options, Range};
use super::{fault, host};
use crate::columns;
use crate::error::Error;
use crate::material::{LobeCount, LobeFit, LobeSpace, LobeTable, fit_lobe};
use crate::program::figure::{Axis, Chart, Panel, Series};

const KEYS: [&str; 7] = ["column", "file", "lobes", "points", "range", "space", "weights"];

pub(super) fn register(lua: &Lua, module: &Table) -> mlua::Result<()> {
    module.set(
        "fit_lobe",
        fault::function(lua, |lua, a| fit(lua, Arguments::new("fit_lobe", a, 1)?))?,
    )
}

fn fit(lua: &Lua, mut arguments: Arguments) -> mlua::Result<Table> {
    let options = arguments.options(&KEYS)?;
    let points = points(lua, &options)?;
    let weights = match options.list("weights", "a list of numbers")? {
        None => None,
        Some(list) => Some(numbers(&options, "weights", &list, Range::NOT_NEGATIVE)?),
    };
    let range_deg = match options.list("range", "{from, to} in degrees")? {
        None => [0.0, 90.0],
        Some(list) => {
            let ends = numbers(&options, "range", &list, Range::new(0.0, 90.0, "degrees"))?;
            <[f64; 2]>::try_from(ends).map_err(|ends| {
                let problem =
                    format!("\"range\" has {} entries, expected {{from, to}}", ends.len());
                Error::inconsistent(options.object(), problem)
            })?
        }
    };
    let count = match options.count("lobes", 1, 2)? {
        Some(2) => LobeCount::Two,
        _ => LobeCount::One,
    };
    let spaces = [("linear", LobeSpace::Linear), ("log", LobeSpace::Log)];
    let space = options.choice("space", &spaces)?.unwrap_or_default();
    let table = LobeTable { points: &points, weights: weights.as_deref(), range_deg };
    let fit = fit_lobe(&table, count, space)?;
    let plot = LuaFigure::of_panel(Panel::Chart(chart(&points, &fit, space)));
    result(lua, fit, plot)
}

/// `points = {{angle, value}, …}`, or two columns of `file`.
fn points(lua: &Lua, options: &Options) -> mlua::Result<Vec<(f64, f64)>> {
    const EXPECTED: &str = "a list of {angle, value}, or \"file\"";
    if let Some(path) = options.text("file")? {
        let column = options.count("column", 2, 1000)?.unwrap_or(2) as usize;
        return Ok(columns::read(&host::of(lua)?.input(&path)?, column)?.rows);
    }
    let rows = options.required_list("points", EXPECTED)?;
    let point = |(at, row): (usize, &Value)| {
        let what = format!("\"points\" row {}", at + 1);
        let cells = options::list(options.object(), &what, row, "{angle, value}")?;
        let [angle, value] = cells.as_slice() else {
            let problem = format!("{what} has {} entries, expected {{angle, value}}", cells.len());
            return Err(Error::inconsistent(options.object(), problem).into());
        };
        let number = |value: &Value| options::number(options.object(), &what, value, Range::ANY);
        Ok((number(angle)?, number(value)?))
    };
    rows.iter().enumerate().map(point).collect()
}

fn numbers(options: &Options, key: &str, list: &[Value], range: Range) -> mlua::Result<Vec<f64>> {
    let what = format!("\"{key}\"");
    list.iter().map(|value| options::number(options.object(), &what, value, range)).collect()
}

/// The first lobe's figures at the top, all of them under `lobes`, `eval` of the sum, and `plot`.
fn result(lua: &Lua, fit: LobeFit, plot: LuaFigure) -> mlua::Result<Table> {
    let mut lobes = Vec::new();
    for lobe in &fit.lobes {
        let row = lua.create_table()?;
        row.set("n", lobe.n)?;
        row.set("n_error", lobe.n_error)?;
        row.set("amplitude", lobe.amplitude)?;
        row.set("amplitude_error", lobe.amplitude_error)?;
        lobes.push(row);
    }
    let table = lua.create_table()?;
    for (first, key) in lobes
        .iter()
        .take(1)
        .flat_map(|lobe| ["n", "n_error", "amplitude", "amplitude_error"].map(|key| (lobe, key)))
    {
        table.set(key, first.get::<f64>(key)?)?;
    }
    table.set("lobes", lobes)?;
    table.set("rms", fit.rms)?;
    table.set("rms_decades", fit.rms_decades)?;
    table.set("points", fit.points)?;
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
        x: Axis::linear("angle from the lobe's direction (degrees)"),
        y: match space {
            LobeSpace::Linear => Axis::linear("measured value"),
            LobeSpace::Log => Axis::log("measured value"),
        },
        series: vec![
            Series::scatter("measured", points.iter().map(|&(x, y)| [x, y]).collect()),
            Series::line(&format!("fit, {}", name.join(" and ")), curve),
        ],
    }
}
