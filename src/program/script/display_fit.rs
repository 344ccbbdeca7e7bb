//! `lampyris.display.fit` and `display:verify`: a display from measurements, and how good it is.

use std::sync::Arc;

use mlua::{Lua, Table, Value};

use super::display::{Fitted, LuaDisplay, black, matrix};
use super::figure::LuaFigure;
use super::host;
use super::options::{self, Arguments, Options, Range};
use crate::color::Xyz;
use crate::display::{
    self, CHANNELS, Display, DisplayMeasurement, Light, Patch, RampPatch, Verification,
};
use crate::error::Error;
use crate::program::figure::{Axis, Chart, Panel, Series};

/// `display.fit { red =, green =, blue = or file =, matrix =, black =, bits = }`.
pub(super) fn fit(lua: &Lua, mut arguments: Arguments) -> mlua::Result<LuaDisplay> {
    let keys = ["bits", "black", "blue", "file", "green", "matrix", "name", "red"];
    let options = arguments.options(&keys)?;
    let bits = options.count("bits", 1, 16)?.unwrap_or(8) as u32;
    let ramps = match options.text("file")? {
        Some(path) => display::read_ramps(&host::of(lua)?.input(&path)?, bits)?,
        None => {
            let [red, green, blue] = CHANNELS.map(|channel| ramp(&options, channel));
            [red?, green?, blue?]
        }
    };
    let measurement = DisplayMeasurement {
        name: options.text("name")?.unwrap_or_else(|| "display".to_owned()),
        ramps,
        matrix: if options.has("matrix")? { Some(matrix(&options)?) } else { None },
        black: black(&options)?,
        bits,
    };
    let fit = display::fit_display(&measurement)?;
    let fitted = Fitted { channels: fit.channels, ramps: relative_ramps(&measurement) };
    Ok(LuaDisplay { display: Arc::new(fit.display), fitted: Some(Arc::new(fitted)) })
}

/// What the curves were fitted to: black subtracted, the last patch being 1.
fn relative_ramps(measurement: &DisplayMeasurement) -> [Vec<[f64; 2]>; 3] {
    let black = measurement.black.y;
    measurement.ramps.each_ref().map(|ramp| {
        let full = ramp.last().map_or(1.0, |patch| patch.light.luminance() - black);
        ramp.iter().map(|patch| [patch.digit, (patch.light.luminance() - black) / full]).collect()
    })
}

/// The tone curves, as Fig. 6 shows them, and the measured points if there are any.
pub(super) fn plot(display: &LuaDisplay) -> LuaFigure {
    /// Curves are smooth beyond.
    const STEPS: u32 = 255;
    const RGB: [[u8; 3]; 3] = [[213, 40, 20], [0, 140, 60], [0, 90, 190]];
    let full = f64::from(display.display.full_digit());
    let mut series = Vec::new();
    for (c, name) in CHANNELS.into_iter().enumerate() {
        let curve = &display.display.curves()[c];
        let signals = (0..=STEPS).map(|step| f64::from(step) / f64::from(STEPS));
        let points = signals.map(|signal| [full * signal, curve.light(signal)]).collect();
        series.push(Series { color: Some(RGB[c]), ..Series::line(name, points) });
        if let Some(fitted) = &display.fitted {
            let points = fitted.ramps[c].clone();
            series.push(Series { color: Some(RGB[c]), ..Series::scatter("", points) });
        }
    }
    let (x, y) = (Axis::linear("digital value"), Axis::linear("light relative to full"));
    LuaFigure::of_panel(Panel::Chart(Chart { title: String::new(), x, y, series }))
}

/// `{ {d, luminance}, … }` or `{ {d, X, Y, Z}, … }`.
fn ramp(options: &Options, channel: &str) -> mlua::Result<Vec<RampPatch>> {
    const EXPECTED: &str = "a list of {d, luminance} or {d, X, Y, Z}";
    let patch = |(at, row): (usize, &Value)| {
        let what = format!("\"{channel}\" row {}", at + 1);
        let cells = numbers(options.object(), &what, row)?;
        let light = match cells[1..] {
            [luminance] => Light::Luminance(luminance),
            [x, y, z] => Light::Xyz(Xyz::new(x, y, z)),
            _ => {
                let problem = format!("{what} has {} entries, expected {EXPECTED}", cells.len());
                return Err(Error::inconsistent(options.object(), problem).into());
            }
        };
        Ok(RampPatch { digit: cells[0], light })
    };
    options.required_list(channel, EXPECTED)?.iter().enumerate().map(patch).collect()
}

/// One number or more.
fn numbers(object: &str, what: &str, row: &Value) -> mlua::Result<Vec<f64>> {
    let cells = options::list(object, what, row, "a list of numbers")?;
    let cell = |value: &Value| options::number(object, what, value, Range::ANY);
    let numbers: Vec<f64> = cells.iter().map(cell).collect::<mlua::Result<_>>()?;
    if numbers.is_empty() {
        return Err(Error::inconsistent(object, format!("{what} is empty")).into());
    }
    Ok(numbers)
}

/// `display.ramps(path, { bits = 8 })`: a file's rows, as `display.fit` takes them.
pub(super) fn ramps(lua: &Lua, mut arguments: Arguments) -> mlua::Result<Table> {
    let path = arguments.text("path")?;
    let options = arguments.options(&["bits"])?;
    let bits = options.count("bits", 1, 16)?.unwrap_or(8) as u32;
    let ramps = display::read_ramps(&host::of(lua)?.input(&path)?, bits)?;
    let table = lua.create_table()?;
    for (channel, patches) in CHANNELS.into_iter().zip(&ramps) {
        let rows = patches.iter().map(|patch| match patch.light {
            Light::Luminance(luminance) => vec![patch.digit, luminance],
            Light::Xyz(color) => vec![patch.digit, color.x, color.y, color.z],
        });
        table.set(channel, rows.collect::<Vec<_>>())?;
    }
    Ok(table)
}

/// `display:verify(patches or file)`, patches being `{ {r, g, b, X, Y, Z}, … }`.
pub(super) fn verify(
    lua: &Lua,
    display: &Display,
    mut arguments: Arguments,
) -> mlua::Result<Table> {
    const OBJECT: &str = "display:verify";
    let patches = match arguments.value() {
        Value::String(path) => {
            let path = host::of(lua)?.input(&path.to_string_lossy())?;
            display::read_patches(&path, display.bits())?
        }
        value => {
            let rows = options::list(OBJECT, "argument", &value, "a file or a list of patches")?;
            rows.iter().enumerate().map(|(at, row)| patch(at, row)).collect::<mlua::Result<_>>()?
        }
    };
    verification_table(lua, &display::verify(display, &patches)?)
}

fn patch(at: usize, row: &Value) -> mlua::Result<Patch> {
    const OBJECT: &str = "display:verify";
    let what = format!("patch {}", at + 1);
    let [r, g, b, x, y, z] = numbers(OBJECT, &what, row)?[..] else {
        let problem = format!("{what} is no {{r, g, b, X, Y, Z}}");
        return Err(Error::inconsistent(OBJECT, problem).into());
    };
    Ok(Patch { digits: [r, g, b], measured: Xyz::new(x, y, z) })
}

fn verification_table(lua: &Lua, verification: &Verification) -> mlua::Result<Table> {
    /// As many as a person looks at.
    const WORST: usize = 10;
    let rows = |patches: &[display::PatchError]| -> mlua::Result<Vec<Table>> {
        let row = |p: &display::PatchError| {
            let row = lua.create_table()?;
            row.set("digits", p.patch.digits)?;
            row.set("measured", <[f64; 3]>::from(p.patch.measured))?;
            row.set("predicted", <[f64; 3]>::from(p.predicted))?;
            row.set("delta_e", p.delta_e_ab)?;
            row.set("delta_e_2000", p.delta_e_2000)?;
            Ok(row)
        };
        patches.iter().map(row).collect()
    };
    let table = lua.create_table()?;
    table.set("mean", verification.mean)?;
    table.set("max", verification.max)?;
    table.set("mean_2000", verification.mean_2000)?;
    table.set("max_2000", verification.max_2000)?;
    table.set("patches", rows(&verification.patches)?)?;
    table.set("worst", rows(&verification.worst(WORST))?)?;
    table.set("verdict", verification.verdict.to_string())?;
    Ok(table)
}
