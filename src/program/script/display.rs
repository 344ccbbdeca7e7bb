//! `lampyris.display`.

use std::io::Write;
use std::sync::Arc;

use mlua::{Lua, Table, UserData, UserDataRegistry};

use super::kinds::{Kind, List, Naming, Number, Numbers, Text};
use super::look::BITS;
use super::members::{Members, functions};
use super::options::{Arguments, Ends, Range};
use super::record::options;
use super::{display_fit, host};
use crate::color::Xyz;
use crate::display::{
    self, CHANNELS, ChannelFit, Curve, Display, DisplayParameters, PQ_MAX_CD_M2, ProfiledDisplay,
};
use crate::error::Error;
use crate::output;
use crate::program::fields::Cell;
use crate::program::results::CHANNEL;

/// Handle of a display.
#[derive(Debug, Clone)]
pub struct LuaDisplay {
    pub display: Arc<Display>,
    /// How a display was fitted; `None` for others.
    pub fitted: Option<Arc<Fitted>>,
}

/// How a display was fitted, and to what.
#[derive(Debug)]
pub struct Fitted {
    pub channels: [ChannelFit; 3],
    /// Digits, and light relative to full, black subtracted.
    pub ramps: [Vec<[f64; 2]>; 3],
    /// Whether eq. 5 describes them, and where it fails.
    pub verdict: String,
}

impl From<Display> for LuaDisplay {
    fn from(display: Display) -> Self {
        Self { display: Arc::new(display), fitted: None }
    }
}

pub(super) fn register(lua: &Lua, module: &Table) -> mlua::Result<()> {
    functions(lua, module, "display", |functions| {
        functions.add_value("eizo_t766", LuaDisplay::from(Display::eizo_t766()))?;
        functions.add_value("srgb", LuaDisplay::from(Display::srgb()))?;
        functions.add_value("p3", LuaDisplay::from(Display::p3()))?;
        functions.add_value("rec2020", LuaDisplay::from(Display::rec2020()))?;
        functions.add("p3_pq", 1, |_, a| pq(a, Display::p3_pq))?;
        functions.add("rec2020_pq", 1, |_, a| pq(a, Display::rec2020_pq))?;
        functions.add("new", 1, |_, a| new(a))?;
        functions.add("fit", 1, display_fit::fit)?;
        functions.add("load", 2, load)?;
        functions.add("ramps", 2, display_fit::ramps)
    })
}

options! {
    struct PqOptions {
        peak: f64 = Number(Range {
            ends: Ends::MinExcluded,
            ..Range::new(0.0, PQ_MAX_CD_M2, "cd/m²")
        }).or(Display::PEAK_CD_M2),
        /// of a channel
        bits: u32 = BITS.or(16),
    }
}

options! {
    struct DisplayLoadOptions {
        /// of white
        luminance: Option<f64> = Number(Range::above_zero("cd/m²"))
            .optional("the profile's, else 80"),
    }
}

/// A monitor's ICC profile.
fn load(lua: &Lua, mut arguments: Arguments) -> mlua::Result<LuaDisplay> {
    let path = arguments.text("path")?;
    let DisplayLoadOptions { luminance } = arguments.record()?;
    let host = host::of(lua)?;
    let ProfiledDisplay { display, notes } = display::read_profile(&host.input(&path)?, luminance)?;
    notes.iter().for_each(|note| host.warn(format!("{path}: {note}")));
    Ok(display.into())
}

fn pq(
    mut arguments: Arguments,
    display: fn(f64) -> crate::Result<Display>,
) -> mlua::Result<LuaDisplay> {
    let PqOptions { peak, bits } = arguments.record()?;
    Ok(display(peak)?.with_bits(bits)?.into())
}

options! {
    struct DisplayNewOptions {
        /// k_g of red, green, blue
        gain: [f64; 3] = triple(Range::above_zero("")).or([1.0; 3]),
        /// k_o
        offset: [f64; 3] = triple(Range::ANY).or([0.0; 3]),
        gamma: [f64; 3] = triple(Range::above_zero("")).or([2.2; 3]),
        /// {X, Y, Z}
        black: [f64; 3] = BLACK.or([0.0; 3]),
        /// cd/m²
        matrix: Vec<[f64; 3]> = MATRIX,
        ..common: DisplayCommonOptions,
    }
}

options! {
    /// Options of every display that a script makes.
    struct DisplayCommonOptions {
        /// of a channel
        bits: u32 = BITS.or(8),
        name: String = Text("a name").or("display".to_owned()),
    }
}

pub(super) const BLACK: Numbers<3> = triple(Range::new(0.0, f64::INFINITY, "cd/m²"));

const fn triple(range: Range) -> Numbers<3> {
    Numbers { range, expected: "a list of 3 numbers" }
}

/// Rows X, Y, Z of eq. 6.
pub(super) const MATRIX: List<Numbers<3>> = List {
    entry: triple(Range::ANY),
    expected: "{{Xr, Xg, Xb}, {Yr, Yg, Yb}, {Zr, Zg, Zb}} in cd/m²",
    naming: Naming::Key,
};

pub(super) fn matrix(object: &str, rows: Vec<[f64; 3]>) -> mlua::Result<[[f64; 3]; 3]> {
    <[[f64; 3]; 3]>::try_from(rows).map_err(|rows| {
        let problem = format!("\"matrix\" has {} rows, expected {}", rows.len(), MATRIX.expected);
        Error::inconsistent(object, problem).into()
    })
}

fn new(mut arguments: Arguments) -> mlua::Result<LuaDisplay> {
    let DisplayNewOptions { matrix: rows, gain, offset, gamma, black, common } =
        arguments.record()?;
    let curve = |c: usize| Curve {
        gain: gain[c],
        offset: offset[c],
        gamma: gamma[c],
        toe: None,
        pq_peak_cd_m2: None,
    };
    let parameters = DisplayParameters {
        name: common.name,
        curves: [0, 1, 2].map(curve),
        matrix: matrix("display.new", rows)?,
        black: black.into(),
        bits: common.bits,
    };
    Ok(Display::new(parameters)?.into())
}

/// The curves by their channels' names; of a fitted display with standard errors and rms.
fn channels(display: &LuaDisplay) -> Cell {
    let channel = |(c, name): (usize, &'static str)| {
        let fit = display.fitted.as_ref().map(|fitted| fitted.channels[c]);
        (name, CHANNEL.record(&(display.display.curves()[c], fit)))
    };
    Cell::Record(CHANNELS.into_iter().enumerate().map(channel).collect())
}

/// Writes an ICC profile.
fn save(lua: &Lua, display: &Display, path: &str) -> mlua::Result<()> {
    let target = host::of(lua)?.output(path)?;
    if target.extension().is_none_or(|extension| extension != "icc") {
        let found = format!("\"{path}\"");
        let allowed = "names ending in .icc";
        return Err(Error::out_of_range("display:save", "path", found, allowed).into());
    }
    let profile = display.icc_profile()?;
    Ok(output::write_atomically(&target, |file| file.write_all(&profile))?)
}

impl UserData for LuaDisplay {
    fn register(registry: &mut UserDataRegistry<Self>) {
        let mut members = Members::new(registry, "display");
        members.field("gain", |_, this| Ok(this.display.curves().map(|c| c.gain)));
        members.field("offset", |_, this| Ok(this.display.curves().map(|c| c.offset)));
        members.field("gamma", |_, this| Ok(this.display.curves().map(|c| c.gamma)));
        members.field("bits", |_, this| Ok(this.display.bits()));
        members.field("channels", |_, this| Ok(channels(this)));
        // Of a fitted display; nil of others.
        members.field("verdict", |_, this| {
            Ok(this.fitted.as_ref().map(|fitted| fitted.verdict.clone()))
        });
        members.field("plot", |_, this| Ok(display_fit::plot(this)));
        members.method("xyz", 3, |_, this, mut arguments| {
            let digits = Range::new(0.0, f64::from(this.display.full_digit()), "");
            let mut digit = |what| arguments.number(what, digits);
            let color = this.display.xyz_from_digits([digit("r")?, digit("g")?, digit("b")?]);
            Ok((color.x, color.y, color.z))
        });
        members.method("digital", 3, |_, this, mut arguments| {
            let mut part = |what| arguments.number(what, Range::ANY);
            let color = Xyz::new(part("X")?, part("Y")?, part("Z")?);
            let digits = this.display.digits_from_xyz(color);
            let [r, g, b] = digits.ok_or_else(|| {
                Error::inconsistent("display:digital", "the color is too large to be shown")
            })?;
            Ok((r, g, b))
        });
        members.method("verify", 1, |lua, this, a| display_fit::verify(lua, &this.display, a));
        members.method("save", 1, |lua, this, mut a| save(lua, &this.display, &a.text("path")?));
        members.text(|this| {
            let white = this.display.white();
            let [x, y] = white.chromaticity().unwrap_or_default();
            let (name, bits) = (this.display.name(), this.display.bits());
            Ok(format!(
                "display: {name}, {bits} bits, white {:.1} cd/m² at ({x:.4}, {y:.4})",
                white.y
            ))
        });
        members.no_others();
    }
}
