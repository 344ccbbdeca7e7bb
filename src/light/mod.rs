//! RAYSET light sources: samples and spectrum, ray files, filaments and the comparison cylinder,
//! and the sum over samples at a hit (eq. 9).

pub mod bulb;
pub mod coil;
pub mod cylinder;
pub mod filament;
mod lambert;
pub mod noise;
pub mod rayfile;
pub mod rayset;
pub mod report;
mod sequence;
pub mod start_surface;
pub mod sum;
pub mod surface_fit;
pub mod thinning;
pub mod tree;
pub mod tungsten;

pub use bulb::Bulb;
pub use coil::Coil;
pub use cylinder::Cylinder;
pub use filament::Filament;
pub use rayset::{RaySample, RaySet};
pub use start_surface::StartSurface;
pub use sum::{HitQuery, LightSum, Photometry, Visibility};
pub use tree::LightTree;
