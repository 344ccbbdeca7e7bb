//! Lists and tables of options.

use std::marker::PhantomData;

use mlua::Value;

use super::super::options::{self, Range};
use super::super::record::Record;
use super::{Kind, Number, Vector};
use crate::error::Error;

/// A list whose entries are of one kind.
pub struct List<K> {
    pub entry: K,
    pub expected: &'static str,
    pub naming: Naming,
}

/// What messages call an entry of a list.
#[derive(Clone, Copy)]
pub enum Naming {
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
pub fn vectors(unit: &'static str) -> List<Vector> {
    List { entry: Vector(unit), expected: "a list of {x, y, z}", naming: Naming::Entry }
}

/// A list of numbers, as many as there are.
pub fn numbers(range: Range) -> List<Number> {
    List { entry: Number(range), expected: "a list of numbers", naming: Naming::Key }
}

/// As many numbers as a place needs.
pub struct Numbers<const N: usize> {
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
pub struct Nested<R>(PhantomData<R>);

impl<R> Nested<R> {
    pub const fn new() -> Self {
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
pub fn nested(object: &str, what: &str) -> String {
    format!("{object}: {}", what.trim_matches('"'))
}
