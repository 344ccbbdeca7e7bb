//! `lampyris.material`.

use std::sync::Arc;

use mlua::{IntoLua, Lua, Table, UserData, UserDataRegistry, Value};

use super::kinds::{Choice, Flag, Kind, Number, Or, SpectrumOrNumber, Text, Whole};
use super::members::{Functions, Members};
use super::options::{self, Arguments, Range};
use super::record::options;
use crate::error::Error;
use crate::material::{EXPONENT_RANGE, Fresnel, LobeShape, Lobes, Material, SpecularLobe};
use crate::spectrum::Spectrum;

/// Handle of a material.
#[derive(Debug, Clone)]
pub struct LuaMaterial(pub Arc<Material>);

options! {
    struct MaterialOptions {
        /// for messages
        name: Option<String> = Text("a name").optional(""),
        /// F_r
        reflectance: Option<Spectrum> = SpectrumOrNumber::new("0 to 1").optional("0, or 1 with `fresnel`"),
        /// F_t
        transmittance: Option<Spectrum> = SpectrumOrNumber::new("0 to 1").optional("none: opaque"),
        /// F_t is the internal transmittance of this thickness
        thickness: Option<f64> = Number(Range::above_zero("mm")).optional("none: F_t at every interface crossed"),
        /// index of refraction
        ior: Option<Spectrum> = SpectrumOrNumber::new("1 to 4").optional("none: rays go straight through"),
        /// whether Fresnel's law shares out what is mirrored and what goes on
        fresnel: bool = Flag.or(false),
        /// of a metal, with `k`
        n: Option<Spectrum> = SpectrumOrNumber::new("0 to 100").optional("none"),
        /// of a metal, with `n`
        k: Option<Spectrum> = SpectrumOrNumber::new("0 to 100").optional("none"),
        /// where bodies overlap, the higher one is there
        priority: i32 = Whole::new(-1000, 1000).or(0),
        /// proportion of the diffuse lobe
        k_d: f64 = SHARE,
        /// its exponent; 1 is Lambert's
        n_d: f64 = Number(EXPONENT).or(1.0),
        /// proportion of the specular lobe, or of several
        k_s: Vec<f64> = OneOrMore(Number(Range::RATIO)).or(vec![0.0]),
        /// its exponent
        n_s: Vec<f64> = OneOrMore(Number(EXPONENT)).or(vec![1.0]),
        /// of the specular lobes: about the mirror direction, or by the half vector as of a rough surface
        lobe: LobeShape = LOBES.or(LobeShape::Mirror),
        /// proportion of the mirrored ray
        k_rg: Option<f64> = Number(Range::RATIO).optional("0, or 1 with `fresnel`"),
        /// proportion of the transmitted ray
        k_tg: Option<f64> = Number(Range::RATIO).optional("0, or 1 with `fresnel`"),
        /// proportion of the ambient light
        k_a: f64 = SHARE,
    }
}

const LOBES: Choice<LobeShape> =
    Choice(&[("mirror", LobeShape::Mirror), ("half", LobeShape::Half)]);
const SHARE: Or<Number> = Or { kind: Number(Range::RATIO), default: 0.0 };
const EXPONENT: Range = Range::new(EXPONENT_RANGE[0], EXPONENT_RANGE[1], "");

pub(super) fn register(lua: &Lua, module: &Table) -> mlua::Result<()> {
    Functions::of_module(lua, module).add("material", 1, |_, a| material(a))
}

fn material(mut arguments: Arguments) -> mlua::Result<LuaMaterial> {
    let given: MaterialOptions = arguments.record()?;
    let specular = specular_lobes(&given)?;
    let name = given.name.map_or_else(|| "material".to_owned(), |n| format!("material \"{n}\""));
    let share = if given.fresnel { 1.0 } else { 0.0 };
    let fresnel = fresnel(&name, given.fresnel, [given.n, given.k])?;
    let material = Material {
        name,
        reflectance: given.reflectance.unwrap_or_else(|| Spectrum::constant(share)),
        transmittance: given.transmittance,
        thickness_mm: given.thickness,
        ior: given.ior,
        fresnel,
        priority: given.priority,
        lobes: Lobes { k_d: given.k_d, n_d: given.n_d, specular, shape: given.lobe },
        k_rg: given.k_rg.unwrap_or(share),
        k_tg: given.k_tg.unwrap_or(share),
        k_a: given.k_a,
    };
    if material.thickness_mm.is_some() && material.transmittance.is_none() {
        let problem = "\"thickness\" without \"transmittance\", whose thickness it would be";
        return Err(Error::inconsistent(&material.name, problem).into());
    }
    material.check()?;
    Ok(LuaMaterial(Arc::new(material)))
}

/// Errors: one of `n` and `k` alone, or without `fresnel`.
fn fresnel(name: &str, is_asked: bool, [n, k]: [Option<Spectrum>; 2]) -> mlua::Result<Fresnel> {
    match (is_asked, n, k) {
        (false, None, None) => Ok(Fresnel::Off),
        (true, None, None) => Ok(Fresnel::Dielectric),
        (true, Some(n), Some(k)) => Ok(Fresnel::Metal { n, k }),
        (true, _, _) => {
            let problem = "a metal has both \"n\" and \"k\"";
            Err(Error::inconsistent(name, problem).into())
        }
        (false, _, _) => {
            let problem =
                "\"n\" and \"k\" are a metal's, with \"fresnel\" = true; a body's index is \"ior\"";
            Err(Error::inconsistent(name, problem).into())
        }
    }
}

/// `k_s` and `n_s` as numbers, or as lists of the same length.
fn specular_lobes(given: &MaterialOptions) -> mlua::Result<Vec<SpecularLobe>> {
    let (shares, exponents) = (&given.k_s, &given.n_s);
    if shares.len() != exponents.len() {
        let problem = format!(
            "\"k_s\" has {} values and \"n_s\" has {}, expected as many of each",
            shares.len(),
            exponents.len()
        );
        return Err(Error::inconsistent("material", problem).into());
    }
    let lobes = shares.iter().zip(exponents).map(|(&k_s, &n_s)| SpecularLobe { k_s, n_s });
    Ok(lobes.filter(|lobe| lobe.k_s > 0.0).collect())
}

/// A number, or a list of them.
struct OneOrMore(Number);

impl Kind for OneOrMore {
    type Read = Vec<f64>;

    fn read(&self, object: &str, what: &str, value: &Value) -> mlua::Result<Vec<f64>> {
        if !value.is_table() {
            return Ok(vec![self.0.read(object, what, value)?]);
        }
        options::each(object, what, value, "a number or a list of numbers", |_, entry| {
            self.0.read(object, what, entry)
        })
    }

    fn lua_type(&self) -> String {
        "number|number[]".to_owned()
    }

    fn expected(&self) -> String {
        self.0.expected()
    }

    fn allowed(&self) -> String {
        self.0.allowed()
    }

    fn shown(&self, value: &Vec<f64>) -> String {
        value.iter().map(f64::to_string).collect()
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

impl UserData for LuaMaterial {
    fn register(registry: &mut UserDataRegistry<Self>) {
        let mut members = Members::new(registry, "material");
        members.field("k_d", |_, this| Ok(this.0.lobes.k_d));
        members.field("n_d", |_, this| Ok(this.0.lobes.n_d));
        members.field("k_s", |_, this| Ok(of_lobes(&this.0, |lobe| lobe.k_s)));
        members.field("n_s", |_, this| Ok(of_lobes(&this.0, |lobe| lobe.n_s)));
        members.field("k_rg", |_, this| Ok(this.0.k_rg));
        members.field("k_tg", |_, this| Ok(this.0.k_tg));
        members.text(|this| Ok(summary(&this.0)));
        members.no_others();
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
