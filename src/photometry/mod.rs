//! What a photometer would read: luminous intensity by direction, its files and its limits.

mod eulumdat;
mod grid;
mod ies;
mod intensity;
mod limits;

pub use grid::{Direction, Grid};
pub use intensity::{intensity, is_cut_off};
pub use limits::{Limits, PointCheck, Requirement};
