//! Nonlinear least squares, and the checks that measured tables pass before it.

mod least_squares;
mod table;

pub use least_squares::{Estimate, Residual, minimize};
pub use table::{Table, check_table};
