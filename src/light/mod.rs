//! What a hit asks of light: ray sets, the exact sum over their samples (eq. 9), and the tree that
//! answers within a bound.

pub mod rayset;
mod stored;
pub mod sum;
pub mod tree;

pub use rayset::{RaySample, RaySet};
pub use stored::{read_samples, write_samples};
pub use sum::{HitQuery, LightSum, Sight, Visibility};
pub use tree::LightTree;
