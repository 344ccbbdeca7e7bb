//! Many runs with inputs that vary as they do in life: tolerances, and what they do to a result.

mod design;
mod distribution;
mod sensitivity;

pub use design::{Design, Draws, MOST_DRAWS, MOST_PARAMETERS};
pub use distribution::{Distribution, normal_quantile};
pub use sensitivity::{Sensitivity, sensitivity};
