//! Least squares, linear and not, and the checks that measured tables pass before it.

mod least_squares;
mod linear;
mod table;

pub use least_squares::{Estimate, Residual, minimize};
pub use linear::solve_linear;
pub use table::{MeasuredTable, check_table};
