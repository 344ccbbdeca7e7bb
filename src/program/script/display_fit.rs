//! `lampyris.display.fit` and `display:verify`: a display from measurements, and how good it is.

use std::sync::Arc;

use mlua::{Lua, Table, Value};

use super::display::{BLACK, DisplayCommonOptions, Fitted, LuaDisplay, MATRIX, matrix};
use super::figure::LuaFigure;
use super::host;
use super::kinds::{Choice, Custom, Kind, List, Naming, Text, missing, numbers};
use super::look::BITS;
use super::options::{self, Arguments, Range};
use super::record::options;
use crate::color::Xyz;
use crate::display::{
    self, CHANNELS, ColorPatch, CurveKind, Display, DisplayMeasurement, RampLight, RampPatch,
};
use crate::error::Error;
use crate::program::fields::Cell;
use crate::program::figure::{Chart, ChartAxis, Panel, Series};
use crate::program::results::VERIFICATION;

options! {
    struct DisplayFitOptions {
        /// {{d, luminance}, …} or {{d, X, Y, Z}, …}
        red: Option<Vec<RampPatch>> = RAMP.optional(""),
        green: Option<Vec<RampPatch>> = RAMP.optional(""),
        blue: Option<Vec<RampPatch>> = RAMP.optional(""),
        /// instead of red, green and blue
        file: Option<String> = Text("a file").optional(""),
        /// cd/m²
        matrix: Option<Vec<[f64; 3]>> = MATRIX.optional("from the ramps' XYZ"),
        /// {X, Y, Z}
        black: Option<[f64; 3]> = BLACK.optional("what the ramps show at digit 0, else 0"),
        /// eq. 5, or curves through the measured levels
        curves: CurveKind =
            Choice(&[("gog", CurveKind::Gog), ("measured", CurveKind::Measured)])
                .or(CurveKind::Gog),
        ..common: DisplayCommonOptions,
    }
}

const RAMP: List<Custom<RampPatch>> = List {
    entry: Custom { lua_type: "number[]", allowed: "", read: ramp_patch, shown: |_| String::new() },
    expected: "a list of {d, luminance} or {d, X, Y, Z}",
    naming: Naming::Row,
};

pub(super) fn fit(lua: &Lua, mut arguments: Arguments) -> mlua::Result<LuaDisplay> {
    const OBJECT: &str = "display.fit";
    let DisplayFitOptions { red, green, blue, file, matrix: rows, black, curves, common } =
        arguments.record()?;
    let ramps = match file {
        Some(path) => display::read_ramps(&host::of(lua)?.input(&path)?, common.bits)?,
        None => {
            let given = |ramp: Option<Vec<RampPatch>>, channel| {
                ramp.ok_or_else(|| missing(OBJECT, channel, RAMP.expected))
            };
            [given(red, "red")?, given(green, "green")?, given(blue, "blue")?]
        }
    };
    let measurement = DisplayMeasurement {
        name: common.name,
        ramps,
        matrix: rows.map(|rows| matrix(OBJECT, rows)).transpose()?,
        black: black.map(Xyz::from),
        bits: common.bits,
    };
    let fit = display::fit_display(&measurement, curves)?;
    if curves == CurveKind::Gog && !fit.worst.is_described() {
        host::of(lua)?.warn(format!("display.fit: {} is {}", measurement.name, fit.worst));
    }
    let (channels, verdict) = (fit.channels, fit.worst.to_string());
    let fitted = Fitted { channels, ramps: relative_ramps(&measurement, fit.black.y), verdict };
    Ok(LuaDisplay { display: Arc::new(fit.display), fitted: Some(Arc::new(fitted)) })
}

/// What the curves were fitted to: black subtracted, the last patch being 1.
fn relative_ramps(measurement: &DisplayMeasurement, black: f64) -> [Vec<[f64; 2]>; 3] {
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
        let signals = (0..=STEPS).map(|step| f64::from(step) / f64::from(STEPS));
        let points =
            signals.map(|signal| [full * signal, display.display.light(c, signal)]).collect();
        series.push(Series { color: Some(RGB[c]), ..Series::line(name, points) });
        if let Some(fitted) = &display.fitted {
            let points = fitted.ramps[c].clone();
            series.push(Series { color: Some(RGB[c]), ..Series::scatter("", points) });
        }
    }
    let (x, y) = (ChartAxis::linear("digital value"), ChartAxis::linear("light relative to full"));
    LuaFigure::of_panel(Panel::Chart(Chart { title: String::new(), x, y, series }))
}

/// `{d, luminance}` or `{d, X, Y, Z}`.
fn ramp_patch(object: &str, what: &str, value: &Value) -> mlua::Result<RampPatch> {
    let (digit, light) = match numbers(Range::ANY).read(object, what, value)?[..] {
        [digit, luminance] => (digit, RampLight::Luminance(luminance)),
        [digit, x, y, z] => (digit, RampLight::Xyz(Xyz::new(x, y, z))),
        ref cells => {
            let problem = format!("{what} has {} entries, expected {}", cells.len(), RAMP.expected);
            return Err(Error::inconsistent(object, problem).into());
        }
    };
    Ok(RampPatch { digit, light })
}

options! {
    struct DisplayRampsOptions {
        bits: u32 = BITS.or(8),
    }
}

/// `display.ramps(path, { bits = 8 })`: a file's rows, as `display.fit` takes them.
pub(super) fn ramps(lua: &Lua, mut arguments: Arguments) -> mlua::Result<Table> {
    let path = arguments.text("path")?;
    let DisplayRampsOptions { bits } = arguments.record()?;
    let ramps = display::read_ramps(&host::of(lua)?.input(&path)?, bits)?;
    let table = lua.create_table()?;
    for (channel, patches) in CHANNELS.into_iter().zip(&ramps) {
        let rows = patches.iter().map(|patch| match patch.light {
            RampLight::Luminance(luminance) => vec![patch.digit, luminance],
            RampLight::Xyz(color) => vec![patch.digit, color.x, color.y, color.z],
        });
        table.set(channel, rows.collect::<Vec<_>>())?;
    }
    Ok(table)
}

/// `display:verify(patches or file)`, patches being `{ {r, g, b, X, Y, Z}, … }`.
pub(super) fn verify(lua: &Lua, display: &Display, mut arguments: Arguments) -> mlua::Result<Cell> {
    const OBJECT: &str = "display:verify";
    let patches = match arguments.value() {
        Value::String(path) => {
            let path = host::of(lua)?.input(&path.to_string_lossy())?;
            display::read_patches(&path, display.bits())?
        }
        value => options::each(OBJECT, "argument", &value, "a file or a list of patches", patch)?,
    };
    Ok(VERIFICATION.record(&display::verify(display, &patches)?))
}

fn patch(number: usize, row: &Value) -> mlua::Result<ColorPatch> {
    const OBJECT: &str = "display:verify";
    let what = format!("patch {number}");
    let [r, g, b, x, y, z] = numbers(Range::ANY).read(OBJECT, &what, row)?[..] else {
        let problem = format!("{what} is no {{r, g, b, X, Y, Z}}");
        return Err(Error::inconsistent(OBJECT, problem).into());
    };
    Ok(ColorPatch { digits: [r, g, b], measured: Xyz::new(x, y, z) })
}
