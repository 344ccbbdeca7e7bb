//! The wavelength grid, spectra and their resampling, Planck, the CIE tables.

mod bands;
mod blackbody;
pub mod cie;
pub mod daylight;
pub mod grid;
mod table;

pub use bands::Bands;
pub use grid::WavelengthGrid;
pub use table::Spectrum;
