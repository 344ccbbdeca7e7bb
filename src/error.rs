//! The one public error type.

use std::fmt;
use std::path::{Path, PathBuf};

/// Everything that a user's input can do wrong, by what the user must do about it.
///
/// A message names the thing, the bad value and what is allowed, in lower case and without a full
/// stop. The script's line is put in front in one place, `script::position`.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    #[error("{object}: unknown key \"{key}\"{hint} (keys: {known})")]
    UnknownKey { object: String, key: String, hint: Hint, known: String },

    #[error("{object}: missing \"{key}\", {expected}")]
    MissingKey { object: String, key: String, expected: String },

    #[error("{object}: {what} is {found}, expected {expected}")]
    WrongType { object: String, what: String, found: String, expected: String },

    #[error("{object}: {what} is {value}, allowed: {allowed}")]
    OutOfRange { object: String, what: String, value: String, allowed: String },

    #[error("{}{place}: {problem}", .path.display())]
    BadFile { path: PathBuf, place: Place, problem: String },

    #[error("{}: {source}", .path.display())]
    Io { path: PathBuf, source: std::io::Error },

    #[error("{object}: {problem}")]
    Inconsistent { object: String, problem: String },

    #[error("interrupted")]
    Interrupted,
}

pub type Result<T> = std::result::Result<T, Error>;

/// Where in a file the fault is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// The file as a whole.
    File,
    /// 1-based line of a text file.
    Line(u64),
    /// 1-based record (ray, vertex, patch) of a binary file, or of a table with no line numbers.
    Record(u64),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::File => Ok(()),
            Place::Line(n) => write!(f, ":{n}"),
            Place::Record(n) => write!(f, ": record {n}"),
        }
    }
}

/// `, did you mean "x"?`, or nothing.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Hint(pub Option<String>);

impl fmt::Display for Hint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0 {
            Some(name) => write!(f, ", did you mean \"{name}\"?"),
            None => Ok(()),
        }
    }
}

impl Error {
    pub fn bad_file(path: &Path, place: Place, problem: impl Into<String>) -> Self {
        Error::BadFile { path: path.to_owned(), place, problem: problem.into() }
    }

    pub fn io(path: &Path, source: std::io::Error) -> Self {
        Error::Io { path: path.to_owned(), source }
    }

    pub fn out_of_range(
        object: &str,
        what: &str,
        value: impl fmt::Display,
        allowed: impl Into<String>,
    ) -> Self {
        Error::OutOfRange {
            object: object.to_owned(),
            what: what.to_owned(),
            value: value.to_string(),
            allowed: allowed.into(),
        }
    }

    pub fn inconsistent(object: &str, problem: impl Into<String>) -> Self {
        Error::Inconsistent { object: object.to_owned(), problem: problem.into() }
    }
}
