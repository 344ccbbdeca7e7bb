//! Reads the values of scripts: types and ranges, with messages that name object and key.

use std::fmt;
use std::sync::Arc;

use glam::DVec3;
use mlua::{AnyUserData, MultiValue, Table, UserData, Value};

use super::fault::{key_text, unknown_key};
use super::kinds::Kind;
use super::record::Record;
use super::spectrum::LuaSpectrum;
use crate::error::{self, Error};
use crate::spectrum::Spectrum;

/// Which numbers are allowed, with their unit for the message.
#[derive(Debug, Clone, Copy)]
pub struct Range {
    pub min: f64,
    pub max: f64,
    pub unit: &'static str,
    /// Whether `min` and `max` themselves are left out.
    pub ends: Ends,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ends {
    Included,
    Excluded,
    MinExcluded,
}

impl Range {
    pub const ANY: Self = Self::new(f64::NEG_INFINITY, f64::INFINITY, "");
    pub const RATIO: Self = Self::new(0.0, 1.0, "");
    pub const NOT_NEGATIVE: Self = Self::new(0.0, f64::INFINITY, "");

    pub const fn new(min: f64, max: f64, unit: &'static str) -> Self {
        Self { min, max, unit, ends: Ends::Included }
    }

    pub const fn above_zero(unit: &'static str) -> Self {
        Self { min: 0.0, max: f64::INFINITY, unit, ends: Ends::MinExcluded }
    }

    pub const fn between(min: f64, max: f64, unit: &'static str) -> Self {
        Self { min, max, unit, ends: Ends::Excluded }
    }

    /// For people to read; empty where every number is allowed.
    pub(super) fn in_words(&self) -> String {
        if self.min.is_finite() || self.max.is_finite() {
            self.to_string()
        } else {
            self.unit.to_owned()
        }
    }

    fn contains(&self, value: f64) -> bool {
        let above = if self.ends == Ends::Included { value >= self.min } else { value > self.min };
        let below = if self.ends == Ends::Excluded { value < self.max } else { value <= self.max };
        value.is_finite() && above && below
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let excluded = self.ends != Ends::Included;
        match (self.min.is_finite(), self.max.is_finite()) {
            (false, _) => return write!(f, "finite numbers"),
            (true, false) if excluded => write!(f, "above {}", self.min),
            (true, false) => write!(f, "{} or more", self.min),
            (true, true) if excluded => write!(f, "between {} and {}", self.min, self.max),
            (true, true) => write!(f, "{} to {}", self.min, self.max),
        }?;
        if self.unit.is_empty() { Ok(()) } else { write!(f, " {}", self.unit) }
    }
}

/// A table of named options whose keys are all known.
pub struct Options {
    object: String,
    table: Option<Table>,
}

impl Options {
    /// Errors: not a table (nil stands for an empty one), a key that is not in `known`.
    pub fn new(object: &str, value: Value, known: &[&str]) -> mlua::Result<Self> {
        let table = match value {
            Value::Nil => None,
            Value::Table(table) => Some(table),
            other => {
                return Err(wrong_type(object, "argument", &other, "a table of options").into());
            }
        };
        let is_known = |key: &Value| key.is_string() && known.contains(&key_text(key).as_str());
        if let Some(key) = table.as_ref().map_or(Ok(None), |t| first_key(t, |k| !is_known(k)))? {
            return Err(unknown_key(object, &key, known).into());
        }
        Ok(Self { object: object.to_owned(), table })
    }

    pub fn object(&self) -> &str {
        &self.object
    }

    /// The value of `key`, as its row says.
    pub(super) fn read<K: Kind>(&self, key: &str, kind: &K) -> mlua::Result<K::Read> {
        match self.value(key)? {
            Value::Nil => kind.absent(&self.object, key),
            value => kind.read(&self.object, &Self::quoted(key), &value),
        }
    }

    /// The raw value; nil where the script gives none.
    pub fn value(&self, key: &str) -> mlua::Result<Value> {
        self.table.as_ref().map_or(Ok(Value::Nil), |table| table.raw_get(key))
    }

    pub fn has(&self, key: &str) -> mlua::Result<bool> {
        Ok(!self.value(key)?.is_nil())
    }

    fn quoted(key: &str) -> String {
        format!("\"{key}\"")
    }
}

/// Among the keys that pass, the first by its text: Lua's own order differs from run to run.
fn first_key(table: &Table, passes: impl Fn(&Value) -> bool) -> mlua::Result<Option<String>> {
    let mut first: Option<String> = None;
    for pair in table.pairs::<Value, Value>() {
        let (key, _) = pair?;
        if passes(&key) {
            let text = key_text(&key);
            first = Some(first.map_or(text.clone(), |known| known.min(text)));
        }
    }
    Ok(first)
}

/// What a value is, for a message.
pub fn describe(value: &Value) -> String {
    match value {
        Value::Nil => "nil".to_owned(),
        Value::Boolean(flag) => flag.to_string(),
        Value::Integer(_) | Value::Number(_) => {
            format!("the number {}", value.to_string().unwrap_or_default())
        }
        Value::String(text) => format!("the string \"{}\"", text.to_string_lossy()),
        Value::UserData(_) => value.to_string().unwrap_or_else(|_| "a handle".to_owned()),
        other => format!("a {}", other.type_name()),
    }
}

pub fn wrong_type(object: &str, what: &str, found: &Value, expected: &str) -> Error {
    Error::WrongType {
        object: object.to_owned(),
        what: what.to_owned(),
        found: describe(found),
        expected: expected.to_owned(),
    }
}

/// A number in range.
pub fn number(object: &str, what: &str, value: &Value, range: Range) -> mlua::Result<f64> {
    let number = match value {
        Value::Integer(i) => *i as f64,
        Value::Number(n) => *n,
        other => return Err(wrong_type(object, what, other, "a number").into()),
    };
    in_range(object, what, number, range)
}

/// A number that has to be in a range.
pub(super) fn in_range(object: &str, what: &str, number: f64, range: Range) -> mlua::Result<f64> {
    if number.is_finite() && !error::may_enter(number) {
        let found = format!("{number:e}");
        return Err(Error::out_of_range(object, what, found, error::NUMBERS).into());
    }
    if range.contains(number) {
        return Ok(number);
    }
    Err(Error::out_of_range(object, what, number, range.to_string()).into())
}

/// A whole number in range.
pub fn count(object: &str, what: &str, value: &Value, min: u64, max: u64) -> mlua::Result<u64> {
    whole(object, what, number(object, what, value, Range::ANY)?, min, max)
}

/// A number that has to be whole and in range.
pub(super) fn whole(object: &str, what: &str, given: f64, min: u64, max: u64) -> mlua::Result<u64> {
    if given.fract() == 0.0 && (min as f64..=max as f64).contains(&given) {
        return Ok(given as u64);
    }
    Err(Error::out_of_range(object, what, given, format!("whole numbers, {min} to {max}")).into())
}

pub fn text(object: &str, what: &str, value: &Value) -> mlua::Result<String> {
    match value {
        Value::String(text) => Ok(text.to_string_lossy()),
        other => Err(wrong_type(object, what, other, "a string").into()),
    }
}

/// One of a fixed set of words.
pub fn choice<T: Copy>(
    object: &str,
    what: &str,
    word: &str,
    choices: &[(&str, T)],
) -> mlua::Result<T> {
    if let Some((_, value)) = choices.iter().find(|(name, _)| *name == word) {
        return Ok(*value);
    }
    let names: Vec<&str> = choices.iter().map(|(name, _)| *name).collect();
    let quoted: Vec<String> = names.iter().map(|name| format!("\"{name}\"")).collect();
    let hint = super::fault::nearest(word, &names);
    let found = format!("\"{word}\"{hint}");
    Err(Error::out_of_range(object, what, found, quoted.join(", ")).into())
}

/// `{x, y, z}`.
pub fn vector(object: &str, what: &str, value: &Value) -> mlua::Result<DVec3> {
    let entries = list(object, what, value, "a vector {x, y, z}")?;
    let [x, y, z] = entries.as_slice() else {
        let found = format!("{what} has {} entries", entries.len());
        return Err(Error::inconsistent(object, format!("{found}, expected {{x, y, z}}")).into());
    };
    let part = |value: &Value| number(object, what, value, Range::ANY);
    Ok(DVec3::new(part(x)?, part(y)?, part(z)?))
}

/// The entries of a table without other keys.
///
/// Each table among them that is held takes a slot of Lua's stack, which has less than 10⁶: long
/// lists are for [`Options::list_of`].
pub fn list(object: &str, what: &str, value: &Value, expected: &str) -> mlua::Result<Vec<Value>> {
    checked_list(object, what, value, expected)?.sequence_values().collect()
}

/// The entries of a list, as `entry` reads each by its number, from 1, and value.
pub(super) fn each<T>(
    object: &str,
    what: &str,
    value: &Value,
    expected: &str,
    entry: impl Fn(usize, &Value) -> mlua::Result<T>,
) -> mlua::Result<Vec<T>> {
    let list = checked_list(object, what, value, expected)?;
    (1..).zip(list.sequence_values()).map(|(number, value)| entry(number, &value?)).collect()
}

/// A table that is a list: without other keys and gaps.
fn checked_list<'a>(
    object: &str,
    what: &str,
    value: &'a Value,
    expected: &str,
) -> mlua::Result<&'a Table> {
    let Value::Table(table) = value else {
        return Err(wrong_type(object, what, value, expected).into());
    };
    if let Some(key) = first_key(table, |key| !key.is_integer())? {
        let found = format!("{what} has the key \"{key}\"");
        return Err(Error::inconsistent(object, format!("{found}, expected {expected}")).into());
    }
    let entries = table.sequence_values::<Value>().count();
    if table.pairs::<Value, Value>().count() != entries {
        let gap = format!("{what} has a gap after entry {entries}");
        return Err(Error::inconsistent(object, gap).into());
    }
    Ok(table)
}

/// A spectrum, or a number for a constant one.
pub fn spectrum(object: &str, what: &str, value: &Value) -> mlua::Result<Spectrum> {
    match value {
        Value::Integer(_) | Value::Number(_) => {
            number(object, what, value, Range::ANY).map(Spectrum::constant)
        }
        other => {
            let handle: LuaSpectrum = handle(object, what, other, "a spectrum or a number")?;
            Ok(Arc::unwrap_or_clone(handle.0))
        }
    }
}

/// One of our immutable handles.
pub fn handle<T: UserData + Clone + 'static>(
    object: &str,
    what: &str,
    value: &Value,
    expected: &str,
) -> mlua::Result<T> {
    let found = match value {
        Value::UserData(data) => borrowed::<T>(data),
        _ => None,
    };
    found.ok_or_else(|| wrong_type(object, what, value, expected).into())
}

fn borrowed<T: UserData + Clone + 'static>(data: &AnyUserData) -> Option<T> {
    data.borrow::<T>().ok().map(|handle| handle.clone())
}

/// The arguments of a call, in order; missing ones are nil.
pub struct Arguments {
    object: Arc<str>,
    values: std::vec::IntoIter<Value>,
}

impl Arguments {
    /// Errors: more than `most` arguments.
    pub fn new(object: impl Into<Arc<str>>, values: MultiValue, most: usize) -> mlua::Result<Self> {
        let (object, count) = (object.into(), values.len());
        if count > most {
            let problem = format!("{count} arguments, expected at most {most}");
            return Err(Error::inconsistent(&object, problem).into());
        }
        Ok(Self { object, values: values.into_vec().into_iter() })
    }

    /// Whether none is left.
    pub fn is_empty(&self) -> bool {
        self.values.len() == 0
    }

    pub fn value(&mut self) -> Value {
        self.values.next().unwrap_or(Value::Nil)
    }

    pub fn number(&mut self, what: &str, range: Range) -> mlua::Result<f64> {
        let value = self.value();
        number(&self.object, what, &value, range)
    }

    /// One of our immutable handles.
    pub(super) fn handle<T: UserData + Clone + 'static>(
        &mut self,
        what: &str,
        expected: &str,
    ) -> mlua::Result<T> {
        let value = self.value();
        handle(&self.object, what, &value, expected)
    }

    pub fn text(&mut self, what: &str) -> mlua::Result<String> {
        let value = self.value();
        text(&self.object, what, &value)
    }

    /// A table of options, as its record reads it.
    pub(super) fn record<R: Record>(&mut self) -> mlua::Result<R> {
        let value = self.value();
        R::read(&self.object, value)
    }
}
