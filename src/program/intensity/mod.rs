//! What a photometer would read: luminous intensity by direction, its files and its limits.

mod eulumdat;
mod far_field;
mod grid;
mod ies;
mod limits;
mod rules;

pub use far_field::{facing_sr, intensity, intensity_bands, is_cut_off};
pub use grid::{Direction, IntensityGrid};
pub use limits::{Limits, PointCheck, Requirement};
pub use rules::{LampRules, RoadSide, StopRatio, VisibilityField, Weakest};
