//! The wavelength grid, spectra and their resampling, Planck, the CIE tables.

mod blackbody;
pub mod cie;
pub mod grid;
mod table;

pub use grid::WavelengthGrid;
pub use table::Spectrum;
