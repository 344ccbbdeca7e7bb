//! What a manifest says of a view, under the names that scripts use.

use crate::color::Xyz;
use crate::error::Result;
use crate::image::{Region, SpectralImage};
use crate::spectrum::WavelengthGrid;

/// The light of a region that the script names.
#[derive(Debug, Clone, PartialEq)]
pub struct RegionReading {
    /// Where it was read.
    pub region: Region,
    /// Wavelengths of the bands.
    pub grid: WavelengthGrid,
    /// Mean of each band.
    pub bands: Vec<f64>,
    /// Mean tristimulus values.
    pub xyz: Xyz,
}

impl RegionReading {
    /// Errors: a region that leaves the image.
    pub fn of(image: &SpectralImage, region: Region) -> Result<Self> {
        let bands = image.mean_bands(region)?;
        let xyz = Xyz::from_bands(image.grid, &bands);
        Ok(Self { region, grid: image.grid, bands, xyz })
    }
}
