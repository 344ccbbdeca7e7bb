//! What an option's value may be: how it is read, and what is said of it.

use std::marker::PhantomData;

use mlua::{Function, UserData, Value};

use super::options::{self, Range, wrong_type};
use super::record::Record;
use crate::error::Error;
use crate::geometry::DVec3;
use crate::spectrum::Spectrum;

/// A kind of value. A row's kind is required unless it is made [`Kind::or`] or [`Kind::optional`].
pub(super) trait Kind: Sized {
    type Read;

    /// Reads a value that is there; `what` names it in messages.
    fn read(&self, object: &str, what: &str, value: &Value) -> mlua::Result<Self::Read>;

    /// For the Lua language server.
    fn lua_type(&self) -> String;

    /// What a message about a missing key expects.
    fn expected(&self) -> String;

    /// What stands for an option that the script does not give.
    fn absent(&self, object: &str, key: &str) -> mlua::Result<Self::Read> {
        Err(missing(object, key, &self.expected()))
    }

    fn is_required(&self) -> bool {
        true
    }

    /// Range and unit in words; empty if the type says it.
    fn allowed(&self) -> String {
        String::new()
    }

    /// A default as scripts would write it, or in words.
    fn default_text(&self) -> String {
        String::new()
    }

    /// A value as scripts would write it.
    fn shown(&self, _value: &Self::Read) -> String {
        String::new()
    }

    /// With a value for scripts that give none.
    fn or(self, default: Self::Read) -> Or<Self> {
        Or { kind: self, default }
    }

    /// `None` for scripts that give none, which `default` puts in words.
    fn optional(self, default: &'static str) -> Optional<Self> {
        Optional { kind: self, default }
    }
}

pub(super) fn missing(object: &str, key: &str, expected: &str) -> mlua::Error {
    Error::MissingKey {
        object: object.to_owned(),
        key: key.to_owned(),
        expected: format!("expected {expected}"),
    }
    .into()
}

/// A kind with a default.
pub(super) struct Or<K: Kind> {
    pub kind: K,
    pub default: K::Read,
}

impl<K: Kind<Read: Clone>> Kind for Or<K> {
    type Read = K::Read;

    fn read(&self, object: &str, what: &str, value: &Value) -> mlua::Result<K::Read> {
        self.kind.read(object, what, value)
    }

    fn lua_type(&self) -> String {
        self.kind.lua_type()
    }

    fn expected(&self) -> String {
        self.kind.expected()
    }

    fn absent(&self, _: &str, _: &str) -> mlua::Result<K::Read> {
        Ok(self.default.clone())
    }

    fn is_required(&self) -> bool {
        false
    }

    fn allowed(&self) -> String {
        self.kind.allowed()
    }

    fn default_text(&self) -> String {
        self.kind.shown(&self.default)
    }
}

/// A kind that may be left out.
pub(super) struct Optional<K> {
    kind: K,
    default: &'static str,
}

impl<K: Kind> Kind for Optional<K> {
    type Read = Option<K::Read>;

    fn read(&self, object: &str, what: &str, value: &Value) -> mlua::Result<Self::Read> {
        self.kind.read(object, what, value).map(Some)
    }

    fn lua_type(&self) -> String {
        self.kind.lua_type()
    }

    fn expected(&self) -> String {
        self.kind.expected()
    }

    fn absent(&self, _: &str, _: &str) -> mlua::Result<Self::Read> {
        Ok(None)
    }

    fn is_required(&self) -> bool {
        false
    }

    fn allowed(&self) -> String {
        self.kind.allowed()
    }
    fn default_text(&self) -> String {
        self.default.to_owned()
    }
}

/// A number in a range.
pub(super) struct Number(pub Range);

impl Kind for Number {
    type Read = f64;

    fn read(&self, object: &str, what: &str, value: &Value) -> mlua::Result<f64> {
        options::number(object, what, value, self.0)
    }

    fn lua_type(&self) -> String {
        "number".to_owned()
    }

    fn expected(&self) -> String {
        format!("a number, {}", self.0)
    }

    fn allowed(&self) -> String {
        self.0.in_words()
    }

    fn shown(&self, value: &f64) -> String {
        value.to_string()
    }
}

/// A whole number, both ends included.
pub(super) struct Count<T> {
    min: u64,
    max: u64,
    unit: &'static str,
    of: PhantomData<T>,
}

impl<T> Count<T> {
    pub(super) const fn new(min: u64, max: u64) -> Self {
        Self { min, max, unit: "", of: PhantomData }
    }

    pub(super) const fn of(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }
}

impl<T: TryFrom<u64> + ToString> Kind for Count<T> {
    type Read = T;

    fn read(&self, object: &str, what: &str, value: &Value) -> mlua::Result<T> {
        let count = options::count(object, what, value, self.min, self.max)?;
        T::try_from(count)
            .map_err(|_| Error::out_of_range(object, what, count, "smaller numbers").into())
    }

    fn lua_type(&self) -> String {
        "integer".to_owned()
    }

    fn expected(&self) -> String {
        format!("a whole number, {} to {}", self.min, self.max)
    }

    fn allowed(&self) -> String {
        format!("{} to {} {}", self.min, self.max, self.unit).trim_end().to_owned()
    }

    fn shown(&self, value: &T) -> String {
        value.to_string()
    }
}

/// A whole number that may be negative, both ends included.
pub(super) struct Whole {
    min: i32,
    max: i32,
}

impl Whole {
    pub(super) const fn new(min: i32, max: i32) -> Self {
        Self { min, max }
    }
}

impl Kind for Whole {
    type Read = i32;

    fn read(&self, object: &str, what: &str, value: &Value) -> mlua::Result<i32> {
        let number = options::number(object, what, value, Range::ANY)?;
        let is_whole = number.fract() == 0.0;
        if is_whole && (f64::from(self.min)..=f64::from(self.max)).contains(&number) {
            return Ok(number as i32);
        }
        Err(Error::out_of_range(object, what, number, self.expected()).into())
    }

    fn lua_type(&self) -> String {
        "integer".to_owned()
    }

    fn expected(&self) -> String {
        format!("whole numbers, {} to {}", self.min, self.max)
    }

    fn allowed(&self) -> String {
        format!("{} to {}", self.min, self.max)
    }

    fn shown(&self, value: &i32) -> String {
        value.to_string()
    }
}

/// `true` or `false`.
pub(super) struct Flag;

impl Kind for Flag {
    type Read = bool;

    fn read(&self, object: &str, what: &str, value: &Value) -> mlua::Result<bool> {
        match value {
            Value::Boolean(flag) => Ok(*flag),
            other => Err(wrong_type(object, what, other, &self.expected()).into()),
        }
    }

    fn lua_type(&self) -> String {
        "boolean".to_owned()
    }

    fn expected(&self) -> String {
        "true or false".to_owned()
    }

    fn shown(&self, value: &bool) -> String {
        value.to_string()
    }
}

/// A string, and what a message expects where it is missing.
pub(super) struct Text(pub &'static str);

impl Kind for Text {
    type Read = String;

    fn read(&self, object: &str, what: &str, value: &Value) -> mlua::Result<String> {
        options::text(object, what, value)
    }

    fn lua_type(&self) -> String {
        "string".to_owned()
    }

    fn expected(&self) -> String {
        self.0.to_owned()
    }

    fn shown(&self, value: &String) -> String {
        format!("\"{value}\"")
    }
}

/// A name, or a number from 1 in its place.
pub(super) struct Name;

impl Kind for Name {
    type Read = String;

    fn read(&self, object: &str, what: &str, value: &Value) -> mlua::Result<String> {
        match value {
            Value::String(_) => options::text(object, what, value),
            _ => Ok(options::count(object, what, value, 1, u64::from(u32::MAX))?.to_string()),
        }
    }

    fn lua_type(&self) -> String {
        "integer|string".to_owned()
    }

    fn expected(&self) -> String {
        "a name or a number".to_owned()
    }
}

/// A name of any bytes, as files have them.
pub(super) struct Bytes(pub &'static str);

impl Kind for Bytes {
    type Read = Vec<u8>;

    fn read(&self, object: &str, what: &str, value: &Value) -> mlua::Result<Vec<u8>> {
        match value {
            Value::String(name) => Ok(name.as_bytes().to_vec()),
            other => Err(wrong_type(object, what, other, "a string").into()),
        }
    }

    fn lua_type(&self) -> String {
        "string".to_owned()
    }

    fn expected(&self) -> String {
        self.0.to_owned()
    }
}

/// One of a fixed set of words.
pub(super) struct Choice<T: 'static>(pub &'static [(&'static str, T)]);

impl<T: Copy + PartialEq> Kind for Choice<T> {
    type Read = T;

    fn read(&self, object: &str, what: &str, value: &Value) -> mlua::Result<T> {
        options::choice(object, what, &options::text(object, what, value)?, self.0)
    }

    fn lua_type(&self) -> String {
        let words: Vec<String> = self.0.iter().map(|(word, _)| format!("\"{word}\"")).collect();
        words.join("|")
    }

    fn expected(&self) -> String {
        self.lua_type().replace('|', ", ")
    }

    fn shown(&self, value: &T) -> String {
        let word = self.0.iter().find(|(_, choice)| choice == value);
        word.map_or_else(String::new, |(word, _)| format!("\"{word}\""))
    }
}

/// `{x, y, z}` with its unit.
pub(super) struct Vector(pub &'static str);

impl Kind for Vector {
    type Read = DVec3;

    fn read(&self, object: &str, what: &str, value: &Value) -> mlua::Result<DVec3> {
        options::vector(object, what, value)
    }

    fn lua_type(&self) -> String {
        "vector".to_owned()
    }

    fn expected(&self) -> String {
        "{x, y, z}".to_owned()
    }

    fn allowed(&self) -> String {
        self.0.to_owned()
    }

    fn shown(&self, DVec3 { x, y, z }: &DVec3) -> String {
        format!("{{{x}, {y}, {z}}}")
    }
}

/// A spectrum, or a number for a constant one.
pub(super) struct SpectrumOrNumber {
    /// What a message about a missing one expects.
    pub expected: &'static str,
    /// In words.
    pub allowed: &'static str,
}

impl SpectrumOrNumber {
    pub(super) const fn new(allowed: &'static str) -> Self {
        Self { expected: "a spectrum or a number", allowed }
    }

    /// The spectrum of a light, which cannot do without.
    pub(super) const fn of_light() -> Self {
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
pub(super) struct Handle<T> {
    class: &'static str,
    expected: &'static str,
    of: PhantomData<T>,
}

impl<T> Handle<T> {
    pub(super) const fn new(class: &'static str, expected: &'static str) -> Self {
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
pub(super) struct Callback {
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

/// A list whose entries are of one kind.
pub(super) struct List<K> {
    pub entry: K,
    pub expected: &'static str,
    pub naming: Naming,
}

/// What messages call an entry of a list.
#[derive(Clone, Copy)]
pub(super) enum Naming {
    /// By the list's own key.
    Key,
    /// `"key" entry 1`
    Entry,
    /// `"key" row 1`
    Row,
}

impl<K: Kind> Kind for List<K> {
    type Read = Vec<K::Read>;

    fn read(&self, object: &str, what: &str, value: &Value) -> mlua::Result<Self::Read> {
        options::each(object, what, value, self.expected, |number, value| match self.naming {
            Naming::Key => self.entry.read(object, what, value),
            Naming::Entry => self.entry.read(object, &format!("{what} entry {number}"), value),
            Naming::Row => self.entry.read(object, &format!("{what} row {number}"), value),
        })
    }

    fn lua_type(&self) -> String {
        let entry = self.entry.lua_type();
        if entry.contains(['|', ' ']) { format!("({entry})[]") } else { format!("{entry}[]") }
    }

    fn expected(&self) -> String {
        self.expected.to_owned()
    }

    fn allowed(&self) -> String {
        self.entry.allowed()
    }

    fn shown(&self, value: &Self::Read) -> String {
        let entries: Vec<String> = value.iter().map(|entry| self.entry.shown(entry)).collect();
        format!("{{{}}}", entries.join(", "))
    }
}

/// A list of `{x, y, z}` with their unit.
pub(super) fn vectors(unit: &'static str) -> List<Vector> {
    List { entry: Vector(unit), expected: "a list of {x, y, z}", naming: Naming::Entry }
}

/// A list of numbers, as many as there are.
pub(super) fn numbers(range: Range) -> List<Number> {
    List { entry: Number(range), expected: "a list of numbers", naming: Naming::Key }
}

/// As many numbers as a place needs.
pub(super) struct Numbers<const N: usize> {
    pub range: Range,
    /// What the list is, in messages and tables.
    pub expected: &'static str,
}

impl<const N: usize> Kind for Numbers<N> {
    type Read = [f64; N];

    fn read(&self, object: &str, what: &str, value: &Value) -> mlua::Result<[f64; N]> {
        let list = options::each(object, what, value, self.expected, |_, entry| {
            options::number(object, what, entry, self.range)
        })?;
        <[f64; N]>::try_from(list).map_err(|list| {
            let problem = format!("{what} has {} entries, expected {}", list.len(), self.expected);
            Error::inconsistent(object, problem).into()
        })
    }

    fn lua_type(&self) -> String {
        "number[]".to_owned()
    }

    fn expected(&self) -> String {
        self.expected.to_owned()
    }

    fn allowed(&self) -> String {
        self.range.in_words()
    }

    fn shown(&self, value: &[f64; N]) -> String {
        let entries: Vec<String> = value.iter().map(f64::to_string).collect();
        format!("{{{}}}", entries.join(", "))
    }
}

/// A table of options in an option; an absent one is an empty one.
pub(super) struct Nested<R>(PhantomData<R>);

impl<R> Nested<R> {
    pub(super) const fn new() -> Self {
        Self(PhantomData)
    }
}

impl<R: Record> Kind for Nested<R> {
    type Read = R;

    fn read(&self, object: &str, what: &str, value: &Value) -> mlua::Result<R> {
        R::read(&nested(object, what), value.clone())
    }

    fn lua_type(&self) -> String {
        R::CLASS.to_owned()
    }

    fn expected(&self) -> String {
        "a table of options".to_owned()
    }

    fn absent(&self, object: &str, key: &str) -> mlua::Result<R> {
        R::read(&nested(object, key), Value::Nil)
    }

    fn is_required(&self) -> bool {
        R::rows().iter().any(|row| row.is_required)
    }
}

/// The object of the messages about a table in an option.
pub(super) fn nested(object: &str, what: &str) -> String {
    format!("{object}: {}", what.trim_matches('"'))
}

/// A value that is read by a function of its own.
pub(super) struct Custom<T> {
    /// For the annotations.
    pub lua_type: &'static str,
    /// Which values are allowed, in words; empty if the type says it.
    pub allowed: &'static str,
    /// As [`Kind::read`].
    pub read: fn(&str, &str, &Value) -> mlua::Result<T>,
    /// As [`Kind::shown`].
    pub shown: fn(&T) -> String,
}

impl<T> Kind for Custom<T> {
    type Read = T;

    fn read(&self, object: &str, what: &str, value: &Value) -> mlua::Result<T> {
        (self.read)(object, what, value)
    }

    fn lua_type(&self) -> String {
        self.lua_type.to_owned()
    }

    fn expected(&self) -> String {
        self.allowed.to_owned()
    }

    fn allowed(&self) -> String {
        self.allowed.to_owned()
    }

    fn shown(&self, value: &T) -> String {
        (self.shown)(value)
    }
}

/// Any value, read by the caller: its type in the annotations, and what messages expect.
pub(super) struct Any {
    pub lua_type: &'static str,
    pub expected: &'static str,
}

/// Any value that need not be there.
pub(super) const fn any(lua_type: &'static str) -> Any {
    Any { lua_type, expected: "" }
}

impl Kind for Any {
    type Read = Value;

    fn read(&self, _: &str, _: &str, value: &Value) -> mlua::Result<Value> {
        Ok(value.clone())
    }

    fn lua_type(&self) -> String {
        self.lua_type.to_owned()
    }

    fn expected(&self) -> String {
        self.expected.to_owned()
    }
}
