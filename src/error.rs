//! The one public error type.

use std::fmt;
use std::path::{Path, PathBuf};

/// Everything that a user's input can do wrong, by what the user must do about it.
///
/// A message names the thing, the bad value and what is allowed, in lower case and without a full
/// stop. The script's line is put in front in one place, `program::script::fault`.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// An option that nothing knows: correct its name.
    #[error("{object}: unknown key \"{key}\"{hint} (keys: {known})")]
    UnknownKey {
        /// What was given the option.
        object: String,
        /// The option's name.
        key: String,
        /// The name that was meant, if one is near.
        hint: Hint,
        /// All names, sorted, with commas between them.
        known: String,
    },

    /// An option that has no default: give it.
    #[error("{object}: missing \"{key}\", {expected}")]
    MissingKey {
        /// What needs the option.
        object: String,
        /// The option's name.
        key: String,
        /// What it has to be, in words.
        expected: String,
    },

    /// A value of another type: give one of the right type.
    #[error("{object}: {what} is {found}, expected {expected}")]
    WrongType {
        /// What was given the value.
        object: String,
        /// Which of its values.
        what: String,
        /// The value in words.
        found: String,
        /// The type in words.
        expected: String,
    },

    /// A value that is not allowed: give another.
    #[error("{object}: {what} is {value}, allowed: {allowed}")]
    OutOfRange {
        /// What was given the value.
        object: String,
        /// Which of its values.
        what: String,
        /// The value as it was given.
        value: String,
        /// The allowed values in words, with their unit.
        allowed: String,
    },

    /// A file that does not hold what it should: correct the file.
    #[error("{}{place}: {problem}", .path.display())]
    BadFile {
        /// The file.
        path: PathBuf,
        /// Where in it.
        place: Place,
        /// What is wrong there.
        problem: String,
    },

    /// A file that cannot be read or written: look at the file system.
    #[error("{}: {source}", .path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },

    /// Values that are good each, but not together.
    #[error("{object}: {problem}")]
    Inconsistent {
        /// What was given the values.
        object: String,
        /// Why they do not go together.
        problem: String,
    },

    /// Ctrl-C.
    #[error("interrupted")]
    Interrupted,
}

/// What can go wrong with a user's input.
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

/// Larger numbers are mistakes, and are refused where they enter: sums and products of a few that
/// are not fit into every file that is written.
pub const LARGEST: f64 = 1e32;

/// [`LARGEST`] in words, for messages.
pub(crate) const NUMBERS: &str = "finite numbers up to 1e32";

/// Whether a number may enter.
pub(crate) fn may_enter(number: f64) -> bool {
    number.abs() <= LARGEST
}

impl Error {
    /// [`Error::BadFile`].
    pub fn bad_file(path: &Path, place: Place, problem: impl Into<String>) -> Self {
        Error::BadFile { path: path.to_owned(), place, problem: problem.into() }
    }

    /// [`Error::Io`].
    pub fn io(path: &Path, source: std::io::Error) -> Self {
        Error::Io { path: path.to_owned(), source }
    }

    /// [`Error::OutOfRange`]; the value is shown as it displays itself.
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

    /// [`Error::Inconsistent`].
    pub fn inconsistent(object: &str, problem: impl Into<String>) -> Self {
        Error::Inconsistent { object: object.to_owned(), problem: problem.into() }
    }
}
