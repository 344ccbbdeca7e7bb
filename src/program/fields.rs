//! Results as data: one list of fields per record, which scripts, manifests and annotations read.
//!
//! To add a result, add its [`Field`] to the record's list in [`super::results`]: scripts have it,
//! manifests too where they hold the record, and `MAKE_REF=1 cargo test --lib annotations` tells
//! the Lua language server.

use std::fmt;

use serde_json::{Map, json};

use crate::color::Xyz;
use crate::geometry::DVec3;

/// A value that scripts and manifests can hold.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// Left out of records.
    Nothing,
    /// A number.
    Number(f64),
    /// A whole number.
    Count(u64),
    /// True or false.
    Flag(bool),
    /// A string.
    Text(String),
    /// Values in their order.
    List(Vec<Cell>),
    /// Values by name.
    Record(Vec<(&'static str, Cell)>),
}

impl Cell {
    /// As manifests hold it.
    pub fn to_json(&self) -> serde_json::Value {
        match self {
            Self::Nothing => serde_json::Value::Null,
            Self::Number(number) => json!(number),
            Self::Count(count) => json!(count),
            Self::Flag(flag) => json!(flag),
            Self::Text(text) => json!(text),
            Self::List(list) => list.iter().map(Self::to_json).collect(),
            Self::Record(fields) => {
                let rows = fields.iter().map(|(name, cell)| ((*name).to_owned(), cell.to_json()));
                rows.collect::<Map<_, _>>().into()
            }
        }
    }
}

/// For people: numbers to seven digits, lists and records as scripts write them.
impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let joined = |parts: Vec<String>| format!("{{{}}}", parts.join(", "));
        match self {
            Self::Nothing => Ok(()),
            // Adding 0 turns −0 into 0.
            Self::Number(number) => match format!("{:.6e}", number + 0.0).parse::<f64>() {
                Ok(number) if number == 0.0 || (1e-4..1e9).contains(&number.abs()) => {
                    write!(f, "{number}")
                }
                Ok(number) => write!(f, "{number:e}"),
                Err(_) => write!(f, "{number}"),
            },
            Self::Count(count) => write!(f, "{count}"),
            Self::Flag(flag) => write!(f, "{flag}"),
            Self::Text(text) => f.write_str(text),
            Self::List(list) => f.write_str(&joined(list.iter().map(Self::to_string).collect())),
            Self::Record(cells) => {
                let cells = cells.iter().map(|(name, cell)| format!("{name} = {cell}"));
                f.write_str(&joined(cells.collect()))
            }
        }
    }
}

/// One field of a record of type `T`.
pub struct Field<T> {
    /// As scripts and manifests call it.
    pub name: &'static str,
    /// For the Lua language server.
    pub lua_type: &'static str,
    /// Without a full stop; may be empty where the name says it.
    pub sentence: &'static str,
    /// Its value in a record.
    pub cell: fn(&T) -> Cell,
}

/// A [`Field`] from its parts, in a line.
pub const fn field<T>(
    name: &'static str,
    lua_type: &'static str,
    sentence: &'static str,
    cell: fn(&T) -> Cell,
) -> Field<T> {
    Field { name, lua_type, sentence, cell }
}

/// The fields of a record, by the name of its class in the annotations.
pub struct Fields<T: 'static> {
    /// Name of the record in the annotations.
    pub class: &'static str,
    /// In the order of the manual.
    pub fields: &'static [Field<T>],
}

impl<T> Fields<T> {
    /// All fields that hold something.
    pub fn record(&self, value: &T) -> Cell {
        Cell::Record(self.cells(value))
    }

    /// Names and values of the fields that hold something.
    pub fn cells(&self, value: &T) -> Vec<(&'static str, Cell)> {
        let cells = self.fields.iter().map(|field| (field.name, (field.cell)(value)));
        cells.filter(|(_, cell)| *cell != Cell::Nothing).collect()
    }

    /// A line for each field that holds something, for people: name, value and sentence.
    pub fn lines(&self, value: &T) -> Vec<String> {
        let line = |field: &Field<T>| match (field.cell)(value) {
            Cell::Nothing => None,
            Cell::List(list) if list.is_empty() => None,
            cell if field.sentence.is_empty() => Some(format!("{}: {cell}", field.name)),
            cell => Some(format!("{}: {cell} ({})", field.name, field.sentence)),
        };
        self.fields.iter().filter_map(line).collect()
    }

    /// The records of several values.
    pub fn list(&self, values: &[T]) -> Cell {
        Cell::List(values.iter().map(|value| self.record(value)).collect())
    }
}

impl From<f64> for Cell {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl From<u64> for Cell {
    fn from(count: u64) -> Self {
        Self::Count(count)
    }
}

impl From<u32> for Cell {
    fn from(count: u32) -> Self {
        Self::Count(count.into())
    }
}

impl From<usize> for Cell {
    fn from(count: usize) -> Self {
        Self::Count(count as u64)
    }
}

impl From<bool> for Cell {
    fn from(flag: bool) -> Self {
        Self::Flag(flag)
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl<T: Into<Cell>> From<Option<T>> for Cell {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::Nothing, Into::into)
    }
}

impl<T: Into<Cell>> From<Vec<T>> for Cell {
    fn from(list: Vec<T>) -> Self {
        Self::List(list.into_iter().map(Into::into).collect())
    }
}

impl<T: Into<Cell>, const N: usize> From<[T; N]> for Cell {
    fn from(list: [T; N]) -> Self {
        Self::List(list.into_iter().map(Into::into).collect())
    }
}

impl From<DVec3> for Cell {
    fn from(vector: DVec3) -> Self {
        vector.to_array().into()
    }
}

impl From<Xyz> for Cell {
    fn from(color: Xyz) -> Self {
        <[f64; 3]>::from(color).into()
    }
}
