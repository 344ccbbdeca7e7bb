//! RAYSET light sources: samples and spectrum, ray files, filaments and the comparison cylinder,
//! and the sum over samples at a hit (eq. 9).

pub mod noise;
pub mod rayfile;
pub mod rayset;
pub mod splitmix;
pub mod start_surface;
pub mod sum;
pub mod thinning;

pub use rayset::{RaySample, RaySet};
pub use start_surface::StartSurface;
