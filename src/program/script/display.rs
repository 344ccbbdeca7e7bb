//! `lampyris.display`.

use std::io::Write;
use std::sync::Arc;

use mlua::{Lua, MetaMethod, MultiValue, Table, UserData, UserDataFields, UserDataMethods, Value};

use super::options::{self, Arguments, Ends, Options, Range};
use super::{display_fit, fault, host};
use crate::color::Xyz;
use crate::display::{CHANNELS, ChannelFit, Curve, Display, DisplayParameters, PQ_MAX_CD_M2};
use crate::error::Error;
use crate::output;

/// Handle of a display.
#[derive(Debug, Clone)]
pub struct LuaDisplay {
    pub display: Arc<Display>,
    /// Of a display that was fitted.
    pub fitted: Option<Arc<Fitted>>,
}

/// How a display was fitted, and to what.
#[derive(Debug)]
pub struct Fitted {
    pub channels: [ChannelFit; 3],
    /// Digits, and light relative to full, black subtracted.
    pub ramps: [Vec<[f64; 2]>; 3],
}

impl From<Display> for LuaDisplay {
    fn from(display: Display) -> Self {
        Self { display: Arc::new(display), fitted: None }
    }
}

const NAMES: [&str; 10] =
    ["bits", "channels", "digital", "gain", "gamma", "offset", "plot", "save", "verify", "xyz"];

pub(super) fn register(lua: &Lua, module: &Table) -> mlua::Result<()> {
    let table = lua.create_table()?;
    table.set("eizo_t766", LuaDisplay::from(Display::eizo_t766()))?;
    table.set("srgb", LuaDisplay::from(Display::srgb()))?;
    table.set("p3", LuaDisplay::from(Display::p3()))?;
    table.set("rec2020", LuaDisplay::from(Display::rec2020()))?;
    table.set("p3_pq", fault::function(lua, |_, a| pq("display.p3_pq", a, Display::p3_pq))?)?;
    let rec2020_pq = |_: &Lua, a| pq("display.rec2020_pq", a, Display::rec2020_pq);
    table.set("rec2020_pq", fault::function(lua, rec2020_pq)?)?;
    table.set("new", fault::function(lua, |_, a| new(Arguments::new("display.new", a, 1)?))?)?;
    table.set(
        "fit",
        fault::function(lua, |lua, a| display_fit::fit(lua, Arguments::new("display.fit", a, 1)?))?,
    )?;
    table.set(
        "ramps",
        fault::function(lua, |lua, a| {
            display_fit::ramps(lua, Arguments::new("display.ramps", a, 2)?)
        })?,
    )?;
    fault::refuse_unknown_names(lua, &table, "lampyris.display")?;
    module.set("display", table)
}

/// `{ peak = 1000, bits = 16 }`.
fn pq(
    object: &'static str,
    arguments: MultiValue,
    display: fn(f64) -> crate::Result<Display>,
) -> mlua::Result<LuaDisplay> {
    let options = Arguments::new(object, arguments, 1)?.options(&["bits", "peak"])?;
    let peaks = Range { ends: Ends::MinExcluded, ..Range::new(0.0, PQ_MAX_CD_M2, "cd/m²") };
    let peak_cd_m2 = options.number_or("peak", peaks, Display::PEAK_CD_M2)?;
    let bits = options.count("bits", 1, 16)?.unwrap_or(16) as u32;
    Ok(display(peak_cd_m2)?.with_bits(bits)?.into())
}

fn new(mut arguments: Arguments) -> mlua::Result<LuaDisplay> {
    let options =
        arguments.options(&["bits", "black", "gain", "gamma", "matrix", "name", "offset"])?;
    let channels = |key, range, default| match options.value(key)? {
        Value::Nil => Ok([default; 3]),
        value => triple(&options, key, &value, range),
    };
    let gains = channels("gain", Range::above_zero(""), 1.0)?;
    let offsets = channels("offset", Range::ANY, 0.0)?;
    let gammas = channels("gamma", Range::above_zero(""), 2.2)?;
    let parameters = DisplayParameters {
        name: options.text("name")?.unwrap_or_else(|| "display".to_owned()),
        curves: [0, 1, 2].map(|c| Curve {
            gain: gains[c],
            offset: offsets[c],
            gamma: gammas[c],
            toe: None,
            pq_peak_cd_m2: None,
        }),
        matrix: matrix(&options)?,
        black: black(&options)?,
        bits: options.count("bits", 1, 16)?.unwrap_or(8) as u32,
    };
    Ok(Display::new(parameters)?.into())
}

fn triple(options: &Options, key: &str, value: &Value, range: Range) -> mlua::Result<[f64; 3]> {
    let what = format!("\"{key}\"");
    let entries = options::list(options.object(), &what, value, "a list of 3 numbers")?;
    let [a, b, c] = entries.as_slice() else {
        let problem = format!("{what} has {} entries, expected 3", entries.len());
        return Err(Error::inconsistent(options.object(), problem).into());
    };
    let part = |value: &Value| options::number(options.object(), &what, value, range);
    Ok([part(a)?, part(b)?, part(c)?])
}

/// Rows X, Y, Z of eq. 6.
pub(super) fn matrix(options: &Options) -> mlua::Result<[[f64; 3]; 3]> {
    const EXPECTED: &str = "{{Xr, Xg, Xb}, {Yr, Yg, Yb}, {Zr, Zg, Zb}} in cd/m²";
    let rows = options.required_list("matrix", EXPECTED)?;
    let [x, y, z] = rows.as_slice() else {
        let problem = format!("\"matrix\" has {} rows, expected {EXPECTED}", rows.len());
        return Err(Error::inconsistent(options.object(), problem).into());
    };
    let row = |value: &Value| triple(options, "matrix", value, Range::ANY);
    Ok([row(x)?, row(y)?, row(z)?])
}

pub(super) fn black(options: &Options) -> mlua::Result<Xyz> {
    match options.value("black")? {
        Value::Nil => Ok(Xyz::default()),
        value => triple(options, "black", &value, Range::NOT_NEGATIVE).map(Xyz::from),
    }
}

/// `{red = {gain =, offset =, gamma =}, …}`; of a fitted display with standard errors and rms.
fn channels(lua: &Lua, display: &LuaDisplay) -> mlua::Result<Table> {
    let table = lua.create_table()?;
    for (c, name) in CHANNELS.into_iter().enumerate() {
        let curve = &display.display.curves()[c];
        let channel = lua.create_table()?;
        channel.set("gain", curve.gain)?;
        channel.set("offset", curve.offset)?;
        channel.set("gamma", curve.gamma)?;
        if let Some(fitted) = &display.fitted {
            let fit = &fitted.channels[c];
            channel.set("gain_error", fit.gain_error)?;
            channel.set("gamma_error", fit.gamma_error)?;
            channel.set("rms", fit.rms)?;
        }
        table.set(name, channel)?;
    }
    Ok(table)
}

impl UserData for LuaDisplay {
    fn add_fields<F: UserDataFields<Self>>(fields: &mut F) {
        fields.add_field_method_get("gain", |_, this| Ok(this.display.curves().map(|c| c.gain)));
        fields
            .add_field_method_get("offset", |_, this| Ok(this.display.curves().map(|c| c.offset)));
        fields.add_field_method_get("gamma", |_, this| Ok(this.display.curves().map(|c| c.gamma)));
        fields.add_field_method_get("bits", |_, this| Ok(this.display.bits()));
        fields.add_field_method_get("channels", channels);
        fields.add_field_method_get("plot", |_, this| Ok(display_fit::plot(this)));
    }

    fn add_methods<M: UserDataMethods<Self>>(methods: &mut M) {
        fault::method(methods, "xyz", |_, this: &Self, a| {
            let mut arguments = Arguments::new("display:xyz", a, 3)?;
            let digits = Range::new(0.0, f64::from(this.display.full_digit()), "");
            let mut digit = |what| arguments.number(what, digits);
            let color = this.display.xyz_from_digits([digit("r")?, digit("g")?, digit("b")?]);
            Ok((color.x, color.y, color.z))
        });
        fault::method(methods, "digital", |_, this: &Self, a| {
            let mut arguments = Arguments::new("display:digital", a, 3)?;
            let mut part = |what| arguments.number(what, Range::ANY);
            let color = Xyz::new(part("X")?, part("Y")?, part("Z")?);
            let digits = this.display.digits_from_xyz(color);
            let [r, g, b] = digits.ok_or_else(|| {
                Error::inconsistent("display:digital", "the color is too large to be shown")
            })?;
            Ok((r, g, b))
        });
        fault::method(methods, "verify", |lua, this: &Self, a| {
            display_fit::verify(lua, &this.display, Arguments::new("display:verify", a, 1)?)
        });
        fault::method(methods, "save", |lua, this: &Self, a| {
            let path = Arguments::new("display:save", a, 1)?.text("path")?;
            let target = host::of(lua)?.output(&path)?;
            if target.extension().is_none_or(|extension| extension != "icc") {
                let found = format!("\"{path}\"");
                let allowed = "names ending in .icc";
                return Err(Error::out_of_range("display:save", "path", found, allowed).into());
            }
            let profile = this.display.icc_profile()?;
            Ok(output::write_atomically(&target, |file| file.write_all(&profile))?)
        });
        methods.add_meta_method(MetaMethod::ToString, |_, this, ()| {
            let white = this.display.white();
            let [x, y] = white.chromaticity().unwrap_or_default();
            let (name, bits) = (this.display.name(), this.display.bits());
            Ok(format!(
                "display: {name}, {bits} bits, white {:.1} cd/m² at ({x:.4}, {y:.4})",
                white.y
            ))
        });
        fault::refuse_unknown_fields(methods, "display", &NAMES);
    }
}
