//! `lampyris.spectrum`.

use std::sync::Arc;

use mlua::{Lua, MetaMethod, Table, UserData, UserDataRegistry, Value};

use super::host;
use super::kinds::{Count, Custom, Flag, Kind, Name, Numbers, Or};
use super::members::{Members, functions};
use super::options::{self, Arguments, Range};
use super::record::options;
use crate::columns::TableChoice;
use crate::error::Error;
use crate::spectrum::{Spectrum, WavelengthGrid, cie};

/// Handle of a spectrum.
#[derive(Debug, Clone)]
pub struct LuaSpectrum(pub Arc<Spectrum>);

pub(super) fn register(lua: &Lua, module: &Table) -> mlua::Result<()> {
    functions(lua, module, "spectrum", |functions| {
        functions.add("load", 2, load)?;
        functions.add("new", 1, |_, a| from_pairs(a))?;
        functions.add("constant", 1, |_, mut arguments| {
            Ok(new_handle(Spectrum::constant(arguments.number("value", Range::ANY)?)))
        })?;
        functions.add("blackbody", 1, |_, mut arguments| {
            let kelvin = arguments.number("temperature", Range::new(100.0, 1e9, "K"))?;
            Ok(new_handle(Spectrum::blackbody(kelvin)))
        })?;
        functions.add("illuminant", 1, |_, mut arguments| {
            let name = arguments.text("name")?;
            let known = cie::ILLUMINANTS.map(|n| (n, n));
            let name = options::choice("spectrum.illuminant", "name", &name, &known)?;
            Ok(cie::illuminant(name).map(new_handle))
        })
    })
}

fn new_handle(spectrum: Spectrum) -> LuaSpectrum {
    LuaSpectrum(Arc::new(spectrum))
}

options! {
    struct SpectrumLoadOptions {
        /// of the values, 1-based
        column: Option<usize> = COLUMN.kind.optional("the one after the wavelengths"),
        /// where each sample is a row: which, by number or name
        row: Option<String> = Name.optional("the only one"),
        /// values outside of 0 to 1 become 0 and 1
        clamp: bool = Flag.or(false),
    }
}

/// A table's column of values: the first is the wavelength or angle.
pub(super) const COLUMN: Or<Count<usize>> = Or { kind: Count::new(2, 1000), default: 2 };

fn load(lua: &Lua, mut arguments: Arguments) -> mlua::Result<LuaSpectrum> {
    let path = arguments.text("path")?;
    let SpectrumLoadOptions { column, row, clamp } = arguments.record()?;
    let host = host::of(lua)?;
    let spectrum = Spectrum::load(&host.input(&path)?, &TableChoice { column, row })?;
    let spectrum = if clamp { spectrum.clamped(0.0, 1.0) } else { spectrum };
    if let Some([first, last]) = spectrum.partial_range_nm() {
        host.warn(format!(
            "{path}: covers {first} to {last} nm only: beyond, a light is 0 and a material constant"
        ));
    }
    Ok(new_handle(spectrum))
}

fn from_pairs(mut arguments: Arguments) -> mlua::Result<LuaSpectrum> {
    const OBJECT: &str = "spectrum.new";
    let pair = Numbers { range: Range::ANY, expected: "{nm, value}" };
    let rows = arguments.value();
    let pairs = options::each(OBJECT, "argument", &rows, "a list of {nm, value}", |at, row| {
        pair.read(OBJECT, &format!("row {at}"), row).map(|[lambda_nm, value]| (lambda_nm, value))
    })?;
    Ok(new_handle(Spectrum::from_pairs(OBJECT, pairs)?))
}

/// Between the bands of a picture.
pub(super) const STEP: Custom<WavelengthGrid> = Custom {
    lua_type: "5|10|20",
    allowed: "nm",
    read: grid_from_step,
    shown: |grid| grid.step_nm().to_string(),
};

/// 5, 10 or 20 nm.
pub(super) fn grid_from_step(
    object: &str,
    what: &str,
    value: &Value,
) -> mlua::Result<WavelengthGrid> {
    let step = options::number(object, what, value, Range::ANY)?;
    let grids = [WavelengthGrid::Step5, WavelengthGrid::Step10, WavelengthGrid::Step20];
    let grid = grids.into_iter().find(|grid| grid.step_nm() == step);
    grid.ok_or_else(|| Error::out_of_range(object, what, step, "5, 10 or 20 nm").into())
}

impl UserData for LuaSpectrum {
    fn register(registry: &mut UserDataRegistry<Self>) {
        let mut members = Members::new(registry, "spectrum");
        // First and last wavelength of the table; nil of a constant.
        members.field("range", |_, this| Ok(this.0.range_nm()));
        members.method("at", 1, |_, this, mut a| {
            let lambda = Range::above_zero("nm");
            Ok(this.0.at(a.number("wavelength", lambda)?))
        });
        members.method("clamped", 2, |_, this, mut arguments| {
            let low = arguments.number("low", Range::ANY)?;
            let above = Range::new(low, f64::INFINITY, "");
            Ok(new_handle(this.0.clamped(low, arguments.number("high", above)?)))
        });
        members.method("values", 1, |_, this, mut a| {
            let grid = match a.value() {
                Value::Nil => WavelengthGrid::Step5,
                step => grid_from_step("spectrum:values", "step", &step)?,
            };
            Ok(this.0.on_grid(grid))
        });
        members.method("xyz", 0, |_, this, _| {
            let xyz = this.0.xyz();
            Ok((xyz.x, xyz.y, xyz.z))
        });
        members.method("xy", 0, |_, this, _| {
            let [x, y] = this.0.xyz().chromaticity().ok_or_else(|| {
                Error::inconsistent("spectrum:xy", "spectrum is black, which has no chromaticity")
            })?;
            Ok((x, y))
        });
        members.method("luminous_flux", 0, |_, this, _| {
            Ok(this.0.luminous_flux(WavelengthGrid::Step5))
        });
        members.operator(MetaMethod::Mul, |_, [a, b]| {
            combine("spectrum *", &a, &b, Spectrum::product)
        });
        members.operator(MetaMethod::Add, |_, [a, b]| combine("spectrum +", &a, &b, Spectrum::sum));
        members.text(|this| Ok(summary(&this.0)));
        members.no_others();
    }
}

fn combine(
    object: &str,
    a: &Value,
    b: &Value,
    f: impl Fn(&Spectrum, &Spectrum) -> Spectrum,
) -> mlua::Result<LuaSpectrum> {
    let operand = |value: &Value| options::spectrum(object, "operand", value);
    let combined = f(&operand(a)?, &operand(b)?);
    combined.check(object)?;
    Ok(new_handle(combined))
}

fn summary(spectrum: &Spectrum) -> String {
    let lambda_nm = spectrum.wavelengths_nm();
    match lambda_nm {
        [_] => format!("spectrum: constant {}", spectrum.values()[0]),
        [first, .., last] => format!(
            "spectrum: {first} to {last} nm, {} rows, {} to {}",
            lambda_nm.len(),
            spectrum.min(),
            spectrum.max()
        ),
        [] => "spectrum: empty".to_owned(),
    }
}
