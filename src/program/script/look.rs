//! How pictures are shown: the options of PNG files and of pictures in figures.

use std::sync::Arc;

use mlua::{Function, Value};

use super::camera::LuaCamera;
use super::display::LuaDisplay;
use super::fault;
use super::kinds::{Choice, Count, Custom, Handle, Kind, Number, missing, nested};
use super::options::{self, Range, describe};
use super::record::{Record, options};
use crate::display::{Exposure, Gamut, Glare, Look, PhotoCamera, Tone};
use crate::error::Error;

options! {
    struct PngOptions {
        /// which the options beside it change
        look: Look = LOOK.or(Look::paper()),
        ..own: LookOptions,
    }
}

options! {
    /// How a picture is shown.
    struct LookOptions {
        display: Option<LuaDisplay> = Handle::new("Display", "a display").optional("sRGB"),
        /// of a channel
        bits: Option<u32> = BITS.optional("the display's"),
        ..rendition: RenditionOptions,
    }
}

options! {
    /// How a picture is shown, on any display.
    struct RenditionOptions {
        /// a factor, or stops or an adaptation in a table; a PQ display shows its own cd/m²
        exposure: Option<Exposure> = EXPOSURE.optional("\"auto\""),
        gamut: Option<Gamut> = Choice(&[("clip", Gamut::Clip), ("desaturate", Gamut::Desaturate)])
            .optional("\"clip\""),
        /// of the eye; true is the default eye's
        glare: Option<Option<Glare>> = GLARE.optional("none"),
        /// the curve on luminance, from and to luminance relative to display white
        tone: Option<Tone> = TONE.optional("\"linear\""),
        /// looks in place of the eye
        camera: Option<Option<PhotoCamera>> = CAMERA.optional("none"),
    }
}

/// Bits of a display's channel.
pub(super) const BITS: Count<u32> = Count::new(1, 16);

impl PngOptions {
    pub(super) fn look(self) -> crate::Result<Look> {
        self.own.change(self.look)
    }

    /// With so many bits unless the options say how many.
    pub(super) fn look_of_bits(self, bits: u32) -> crate::Result<Look> {
        let bits = self.own.bits.or(Some(bits));
        LookOptions { bits, ..self.own }.change(self.look)
    }
}

impl LookOptions {
    fn change(self, look: Look) -> crate::Result<Look> {
        let look = self.rendition.change(look);
        let display = self.display.map(|handle| Arc::unwrap_or_clone(handle.display));
        let display = display.unwrap_or_else(|| look.display.clone());
        let display = match self.bits {
            Some(bits) => display.with_bits(bits)?,
            None => display,
        };
        Ok(Look { display, ..look })
    }
}

impl RenditionOptions {
    /// A look with what is given here.
    pub(super) fn change(self, look: Look) -> Look {
        let Self { exposure, gamut, glare, tone, camera } = self;
        Look {
            display: look.display,
            exposure: exposure.unwrap_or(look.exposure),
            tone: tone.unwrap_or(look.tone),
            gamut: gamut.unwrap_or(look.gamut),
            glare: glare.unwrap_or(look.glare),
            camera: camera.unwrap_or(look.camera),
        }
    }
}

/// A look's name, or a table that changes the paper's.
pub(super) const LOOK: Custom<Look> = Custom {
    lua_type: "\"paper\"|\"seen\"|\"camera\"|LookOptions",
    allowed: "",
    read: |object, what, value| {
        if value.is_table() {
            let given = LookOptions::read(&nested(object, what), value.clone())?;
            return Ok(given.change(Look::paper())?);
        }
        let names = Look::NAMES.map(|name| (name, name));
        let name = options::choice(object, what, &options::text(object, what, value)?, &names)?;
        Ok(Look::named(name).unwrap_or_default())
    },
    shown: |_| "\"paper\"".to_owned(),
};

/// A camera, or `false` for the eye.
const CAMERA: Custom<Option<PhotoCamera>> = Custom {
    lua_type: "false|Camera",
    allowed: "",
    read: |object, what, value| match value {
        Value::Boolean(false) => Ok(None),
        value => {
            let camera: LuaCamera = options::handle(object, what, value, "a camera")?;
            Ok(Some(camera.0))
        }
    },
    shown: |_| String::new(),
};

const TONE: Custom<Tone> = Custom {
    lua_type: "\"linear\"|\"reinhard\"|\"photographic\"|fun(luminance: number): number",
    allowed: "",
    read: tone,
    shown: |_| "\"linear\"".to_owned(),
};

/// A curve's name, or a function.
fn tone(object: &str, what: &str, value: &Value) -> mlua::Result<Tone> {
    if let Value::Function(curve) = value {
        let curve = curve.clone();
        return Ok(Tone::Curve(Arc::new(move |luminance| curve_value(&curve, luminance))));
    }
    let word = options::text(object, what, value)?;
    options::choice(object, what, &word, &[("linear", 0), ("reinhard", 1), ("photographic", 2)])
        .map(|number| match number {
            1 => Tone::Reinhard,
            2 => Tone::Photographic,
            _ => Tone::Linear,
        })
}

/// A script's tone curve, from and to luminance relative to display white.
fn curve_value(curve: &Function, luminance: f64) -> crate::Result<f64> {
    let failed = |problem: String| Error::inconsistent("image:save: tone", problem);
    match curve.call::<Value>(luminance) {
        Ok(Value::Number(value)) => Ok(value),
        Ok(Value::Integer(value)) => Ok(value as f64),
        Ok(other) => Err(failed(format!("returned {}, expected a number", describe(&other)))),
        Err(error) => Err(failed(fault::message(&error))),
    }
}

const GLARE: Custom<Option<Glare>> =
    Custom { lua_type: "boolean|Glare", allowed: "", read: glare, shown: |_| "false".to_owned() };

options! {
    /// The eye whose glare a picture shows.
    struct GlareOptions {
        age: f64 = Number(Range::new(0.0, 120.0, "years")).or(Glare::default().age),
        pigment: f64 = Number(Range::new(0.0, 1.2, "")).or(Glare::default().pigment),
        strength: f64 = Number(Range::RATIO).or(Glare::default().strength),
    }
}

fn glare(object: &str, what: &str, value: &Value) -> mlua::Result<Option<Glare>> {
    let eye = match value {
        Value::Boolean(false) => return Ok(None),
        Value::Boolean(true) => Value::Nil,
        value => value.clone(),
    };
    let GlareOptions { age, pigment, strength } = Record::read(&nested(object, what), eye)?;
    Ok(Some(Glare { age, pigment, strength }))
}

pub(super) const EXPOSURE: Custom<Exposure> = Custom {
    lua_type: "\"auto\"|number|ExposureOptions",
    allowed: "factor above 0",
    read: exposure,
    shown: |_| "\"auto\"".to_owned(),
};

options! {
    /// One of the two.
    struct ExposureOptions {
        ev: Option<f64> = EV.optional(""),
        /// luminance that an eye is adapted to, shown as middle gray
        adaptation: Option<f64> = Number(Range::above_zero("cd/m²")).optional(""),
    }
}

const EV: Number = Number(Range::new(-100.0, 100.0, "stops"));

/// `"auto"`, a factor, `{ev = stops}` or `{adaptation = cd/m²}`.
fn exposure(object: &str, what: &str, value: &Value) -> mlua::Result<Exposure> {
    match value {
        Value::Table(_) => {
            let object = nested(object, what);
            let ExposureOptions { ev, adaptation } = Record::read(&object, value.clone())?;
            match adaptation {
                Some(luminance) => Ok(Exposure::Adapted(luminance)),
                None => {
                    ev.map(Exposure::Stops).ok_or_else(|| missing(&object, "ev", &EV.expected()))
                }
            }
        }
        Value::String(word) if word == "auto" => Ok(Exposure::Auto),
        Value::String(word) => {
            let allowed = "\"auto\", a factor above 0, {ev = stops}, {adaptation = cd/m²}";
            let found = format!("\"{}\"", word.to_string_lossy());
            Err(Error::out_of_range(object, what, found, allowed).into())
        }
        value => options::number(object, what, value, Range::above_zero("")).map(Exposure::Factor),
    }
}
