//! The wavelength grid, spectra and their resampling, Planck, the CIE tables.

pub mod grid;

pub use grid::WavelengthGrid;
