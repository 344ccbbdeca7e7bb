//! Handles and functions.

use std::marker::PhantomData;

use mlua::{Function, UserData, Value};

use super::super::options::{self, wrong_type};
use super::Kind;
use crate::spectrum::Spectrum;

/// A spectrum, or a number for a constant one.
pub struct SpectrumOrNumber {
    /// What a message about a missing one expects.
    pub expected: &'static str,
    /// In words.
    pub allowed: &'static str,
}

impl SpectrumOrNumber {
    pub const fn new(allowed: &'static str) -> Self {
        Self { expected: "a spectrum or a number", allowed }
    }

    /// The spectrum of a light, which cannot do without.
    pub const fn of_light() -> Self {
        let expected = "a spectrum, such as lampyris.spectrum.blackbody(2856)";
        Self { expected, allowed: "" }
    }
}

impl Kind for SpectrumOrNumber {
    type Read = Spectrum;

    fn read(&self, object: &str, what: &str, value: &Value) -> mlua::Result<Spectrum> {
        options::spectrum(object, what, value)
    }

    fn lua_type(&self) -> String {
        "Spectrum|number".to_owned()
    }

    fn expected(&self) -> String {
        self.expected.to_owned()
    }

    fn allowed(&self) -> String {
        self.allowed.to_owned()
    }

    fn shown(&self, value: &Spectrum) -> String {
        value.values()[0].to_string()
    }
}

/// One of our immutable handles: its class in the annotations, and what messages call it.
pub struct Handle<T> {
    class: &'static str,
    expected: &'static str,
    of: PhantomData<T>,
}

impl<T> Handle<T> {
    pub const fn new(class: &'static str, expected: &'static str) -> Self {
        Self { class, expected, of: PhantomData }
    }
}

impl<T: UserData + Clone + 'static> Kind for Handle<T> {
    type Read = T;

    fn read(&self, object: &str, what: &str, value: &Value) -> mlua::Result<T> {
        options::handle(object, what, value, self.expected)
    }

    fn lua_type(&self) -> String {
        self.class.to_owned()
    }

    fn expected(&self) -> String {
        self.expected.to_owned()
    }
}

/// A function of the script: its type in the annotations, and what messages call it.
pub struct Callback {
    pub lua_type: &'static str,
    pub expected: &'static str,
}

impl Kind for Callback {
    type Read = Function;

    fn read(&self, object: &str, what: &str, value: &Value) -> mlua::Result<Function> {
        match value {
            Value::Function(function) => Ok(function.clone()),
            other => Err(wrong_type(object, what, other, "a function").into()),
        }
    }

    fn lua_type(&self) -> String {
        self.lua_type.to_owned()
    }

    fn expected(&self) -> String {
        self.expected.to_owned()
    }
}
