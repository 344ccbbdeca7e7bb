//! RAYSET light sources: samples and spectrum, ray files, filaments and the comparison cylinder,
//! and the sum over samples at a hit (eq. 9).

pub mod rayfile;
pub mod rayset;
pub mod sum;
pub mod tree;

pub use rayset::{RaySample, RaySet};
pub use sum::{HitQuery, LightSum, Photometry, Visibility};
pub use tree::LightTree;
