//! Where light comes from: ray files, filaments, bulbs and the comparison cylinder (eq. 10 to 12),
//! each of which becomes a [`crate::light::RaySet`].

pub mod bulb;
pub mod coil;
pub mod cylinder;
pub mod directions;
pub mod emitter;
pub mod filament;
mod lambert;
pub mod noise;
pub mod photometric;
pub mod rayfile;
pub(crate) mod sequence;
pub mod start_surface;
pub mod starts;
pub mod surface_fit;
pub mod thinning;
pub mod tungsten;

pub use bulb::Bulb;
pub use coil::Coil;
pub use cylinder::Cylinder;
pub use emitter::Emitter;
pub use filament::Filament;
pub use start_surface::StartSurface;
pub use starts::Starts;
