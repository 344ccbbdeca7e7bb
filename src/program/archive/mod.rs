//! An experiment in one file: `pack` takes a sweep's or study's folder with all that it was made from,
//! `replay` makes it again elsewhere and compares.
//!
//! The file is a tar archive whose first entry, `experiment.json`, lists all others with size and
//! SHA-256. The same experiment gives the same bytes.

mod experiment;
mod pack;
mod replay;

pub use pack::pack;
pub use replay::{Replayed, compare, unpack};
