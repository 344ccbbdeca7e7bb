//! `lampyris.material`.

use std::sync::Arc;

use mlua::{IntoLua, Lua, MetaMethod, Table, UserData, UserDataFields, UserDataMethods, Value};

use super::fault;
use super::options::{self, Arguments, Options, Range};
use crate::error::Error;
use crate::material::{EXPONENT_RANGE, Lobes, Material, SpecularLobe};
use crate::spectrum::Spectrum;

/// Handle of a material.
#[derive(Debug, Clone)]
pub struct LuaMaterial(pub Arc<Material>);

const KEYS: [&str; 12] = [
    "name",
    "reflectance",
    "transmittance",
    "thickness",
    "ior",
    "k_d",
    "k_s",
    "n_d",
    "n_s",
    "k_rg",
    "k_tg",
    "k_a",
];

const EXPONENT: Range = Range::new(EXPONENT_RANGE[0], EXPONENT_RANGE[1], "");

pub(super) fn register(lua: &Lua, module: &Table) -> mlua::Result<()> {
    module
        .set("material", fault::function(lua, |_, a| material(Arguments::new("material", a, 1)?))?)
}

fn material(mut arguments: Arguments) -> mlua::Result<LuaMaterial> {
    let options = arguments.options(&KEYS)?;
    let material = Material {
        name: options
            .text("name")?
            .map_or_else(|| "material".to_owned(), |n| format!("material \"{n}\"")),
        reflectance: options.spectrum("reflectance")?.unwrap_or_else(|| Spectrum::constant(0.0)),
        transmittance: options.spectrum("transmittance")?,
        thickness_mm: options.number("thickness", Range::above_zero("mm"))?,
        ior: options.number("ior", Range::new(1.0, 4.0, ""))?,
        lobes: Lobes {
            k_d: options.number_or("k_d", Range::RATIO, 0.0)?,
            n_d: options.number_or("n_d", EXPONENT, 1.0)?,
            specular: specular_lobes(&options)?,
        },
        k_rg: options.number_or("k_rg", Range::RATIO, 0.0)?,
        k_tg: options.number_or("k_tg", Range::RATIO, 0.0)?,
        k_a: options.number_or("k_a", Range::RATIO, 0.0)?,
    };
    if material.thickness_mm.is_some() && material.transmittance.is_none() {
        let problem = "\"thickness\" without \"transmittance\", whose thickness it would be";
        return Err(Error::inconsistent(&material.name, problem).into());
    }
    material.check()?;
    Ok(LuaMaterial(Arc::new(material)))
}

/// `k_s` and `n_s` as numbers, or as lists of the same length.
fn specular_lobes(options: &Options) -> mlua::Result<Vec<SpecularLobe>> {
    let shares = numbers(options, "k_s", Range::RATIO)?.unwrap_or_else(|| vec![0.0]);
    let exponents = numbers(options, "n_s", EXPONENT)?.unwrap_or_else(|| vec![1.0]);
    if shares.len() != exponents.len() {
        let problem = format!(
            "\"k_s\" has {} values and \"n_s\" has {}, expected as many of each",
            shares.len(),
            exponents.len()
        );
        return Err(Error::inconsistent(options.object(), problem).into());
    }
    let lobes = shares.into_iter().zip(exponents).map(|(k_s, n_s)| SpecularLobe { k_s, n_s });
    Ok(lobes.filter(|lobe| lobe.k_s > 0.0).collect())
}

fn numbers(options: &Options, key: &str, range: Range) -> mlua::Result<Option<Vec<f64>>> {
    match options.value(key)? {
        Value::Table(_) => {
            let list = options.required_list(key, "a number or a list of numbers")?;
            let what = format!("\"{key}\"");
            let numbers =
                list.iter().map(|value| options::number(options.object(), &what, value, range));
            numbers.collect::<mlua::Result<Vec<f64>>>().map(Some)
        }
        _ => Ok(options.number(key, range)?.map(|number| vec![number])),
    }
}

/// A number, or a list where there are several lobes; 0 without any.
fn of_lobes(material: &Material, value: impl Fn(&SpecularLobe) -> f64) -> NumberOrList {
    match material.lobes.specular.as_slice() {
        [] => NumberOrList::Number(0.0),
        [lobe] => NumberOrList::Number(value(lobe)),
        lobes => NumberOrList::List(lobes.iter().map(value).collect()),
    }
}

enum NumberOrList {
    Number(f64),
    List(Vec<f64>),
}

impl IntoLua for NumberOrList {
    fn into_lua(self, lua: &Lua) -> mlua::Result<Value> {
        match self {
            Self::Number(number) => number.into_lua(lua),
            Self::List(list) => list.into_lua(lua),
        }
    }
}

const NAMES: [&str; 6] = ["k_d", "k_rg", "k_s", "k_tg", "n_d", "n_s"];

impl UserData for LuaMaterial {
    fn add_fields<F: UserDataFields<Self>>(fields: &mut F) {
        fields.add_field_method_get("k_d", |_, this| Ok(this.0.lobes.k_d));
        fields.add_field_method_get("n_d", |_, this| Ok(this.0.lobes.n_d));
        fields.add_field_method_get("k_s", |_, this| Ok(of_lobes(&this.0, |lobe| lobe.k_s)));
        fields.add_field_method_get("n_s", |_, this| Ok(of_lobes(&this.0, |lobe| lobe.n_s)));
        fields.add_field_method_get("k_rg", |_, this| Ok(this.0.k_rg));
        fields.add_field_method_get("k_tg", |_, this| Ok(this.0.k_tg));
    }

    fn add_methods<M: UserDataMethods<Self>>(methods: &mut M) {
        methods.add_meta_method(MetaMethod::ToString, |_, this, ()| Ok(summary(&this.0)));
        fault::refuse_unknown_fields(methods, "material", &NAMES);
    }
}

fn summary(material: &Material) -> String {
    let kind = if material.transmits() { "transmitting" } else { "opaque" };
    format!(
        "{}: {kind}, k_d {}, k_rg {}, k_tg {}, {} specular lobes",
        material.name,
        material.lobes.k_d,
        material.k_rg,
        material.k_tg,
        material.lobes.specular.len()
    )
}
