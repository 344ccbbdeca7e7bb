//! What a photometer would read: luminous intensity by direction, its files and its limits.

mod eulumdat;
mod grid;
mod ies;
mod intensity;
mod limits;
mod rules;

pub use grid::{Direction, Grid};
pub use intensity::{intensity, is_cut_off};
pub use limits::{Limits, PointCheck, Requirement};
pub use rules::{LampRules, Side, StopRatio, VisibilityField, Weakest};
