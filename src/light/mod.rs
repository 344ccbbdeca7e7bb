//! RAYSET light sources: samples and spectrum, ray files, filaments and the comparison cylinder,
//! and the sum over samples at a hit (eq. 9).

pub mod rayfile;
pub mod rayset;
pub mod sum;

pub use rayset::{RaySample, RaySet};
