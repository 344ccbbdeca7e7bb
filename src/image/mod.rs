//! What a render returns, and its tristimulus values.

mod colors;
/// How far an image is from a reference.
pub mod difference;
/// How even an image is.
pub mod homogeneity;
mod sum;

use std::collections::BTreeMap;

use rayon::prelude::*;

use crate::color::Photometry;
use crate::color::Xyz;
use crate::error::{Error, Result};
use crate::spectrum::{WavelengthGrid, cie};
use crate::statistics::percentile;
use crate::view::View;

pub use sum::weighted_sum;

/// Percentile of luminance that a picture shows as white, unless it is told its exposure.
pub const AUTO_PERCENT: f64 = 99.5;

/// One spectrum a pixel.
///
/// Unit: W·m⁻²·sr⁻¹·nm⁻¹ in absolute photometry, without a unit in relative.
#[derive(Debug, Clone, PartialEq)]
pub struct SpectralImage {
    /// Pixels of a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Wavelengths of the bands.
    pub grid: WavelengthGrid,
    /// Row 0 on top, pixel-major: value of `band` at `pixel * grid.bands() + band`.
    pub bands: Vec<f32>,
    /// Whether the values have a unit.
    pub photometry: Photometry,
    /// Standard error of each pixel's luminance, relative to it or, where it is darker, to the image's
    /// mean.
    pub error: Option<Vec<f32>>,
    /// Camera rays traced for each pixel.
    pub samples: Option<Vec<f32>>,
    /// Parts that add up to the picture, by where their light came from; none unless asked for.
    pub layers: Vec<Layer>,
    /// From where it was seen; `None` where nobody knows.
    pub view: Option<View>,
    /// What made the image, in plain words.
    pub metadata: Metadata,
}

/// A part of a picture: the light that came one way.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    /// As `light 1`, `mirrored`.
    pub name: String,
    /// As [`SpectralImage::bands`].
    pub bands: Vec<f32>,
}

/// Key (`script`, `view`, `quality`, `version`, …) and value.
pub type Metadata = BTreeMap<String, String>;

impl SpectralImage {
    /// All black.
    pub fn new(width: usize, height: usize, grid: WavelengthGrid, photometry: Photometry) -> Self {
        Self {
            width,
            height,
            grid,
            bands: vec![0.0; width * height * grid.bands()],
            photometry,
            error: None,
            samples: None,
            layers: Vec::new(),
            view: None,
            metadata: Metadata::new(),
        }
    }

    /// A layer as a picture of its own.
    pub fn layer(&self, layer: &Layer) -> Self {
        let mut metadata = self.metadata.clone();
        metadata.insert("layer".to_owned(), layer.name.clone());
        Self {
            bands: layer.bands.clone(),
            layers: Vec::new(),
            error: None,
            samples: None,
            metadata,
            ..*self
        }
    }

    /// The bands of one pixel.
    pub fn pixel(&self, x: usize, y: usize) -> &[f32] {
        let bands = self.grid.bands();
        let start = (y * self.width + x) * bands;
        &self.bands[start..start + bands]
    }

    /// Mean of each band over `region`.
    ///
    /// Errors: [`Error::OutOfRange`] if the region is empty or leaves the image.
    pub fn mean_bands(&self, region: Region) -> Result<Vec<f64>> {
        region.check(self.width, self.height)?;
        let mut mean = vec![0.0; self.grid.bands()];
        for (x, y) in region.pixels() {
            for (m, value) in mean.iter_mut().zip(self.pixel(x, y)) {
                *m += f64::from(*value);
            }
        }
        let pixels = region.width as f64 * region.height as f64;
        mean.iter_mut().for_each(|m| *m /= pixels);
        Ok(mean)
    }

    /// Mean tristimulus values over `region`; errors as [`Self::mean_bands`].
    pub fn mean_xyz(&self, region: Region) -> Result<Xyz> {
        Ok(Xyz::from_bands(self.grid, &self.mean_bands(region)?))
    }

    /// Eq. 4 at every pixel.
    pub fn to_xyz(&self) -> XyzImage {
        let cmf: Vec<[f64; 3]> =
            (0..self.grid.bands()).map(|band| cie::cmf(self.grid, band)).collect();
        let scale = cie::K_LM_PER_W * self.grid.step_nm();
        let pixels = self.bands.par_chunks_exact(cmf.len());
        let pixels = pixels.map(|bands| weigh(bands, &cmf) * scale).collect();
        XyzImage { width: self.width, height: self.height, pixels }
    }
}

fn weigh(bands: &[f32], cmf: &[[f64; 3]]) -> Xyz {
    bands
        .iter()
        .zip(cmf)
        .fold(Xyz::default(), |sum, (&value, &weights)| sum + Xyz::from(weights) * f64::from(value))
}

/// Pixels `x .. x + width`, `y .. y + height`, 0-based from the top left.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Region {
    /// Pixels from the left.
    pub x: usize,
    /// Pixels from the top.
    pub y: usize,
    /// Pixels of a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

impl Region {
    /// One pixel.
    pub fn pixel(x: usize, y: usize) -> Self {
        Self { x, y, width: 1, height: 1 }
    }

    /// Errors: [`Error::OutOfRange`] if the region is empty or leaves the image.
    pub fn check(self, image_width: usize, image_height: usize) -> Result<()> {
        check_span(["x", "width"], [self.x, self.width], image_width)?;
        check_span(["y", "height"], [self.y, self.height], image_height)
    }

    /// (x, y), row by row.
    pub fn pixels(self) -> impl Iterator<Item = (usize, usize)> {
        let columns = self.x..self.x + self.width;
        (self.y..self.y + self.height).flat_map(move |y| columns.clone().map(move |x| (x, y)))
    }
}

fn check_span(names: [&str; 2], [start, length]: [usize; 2], limit: usize) -> Result<()> {
    if start >= limit {
        let allowed = format!("0 to {} pixels", limit.saturating_sub(1));
        return Err(Error::out_of_range("region", names[0], start, allowed));
    }
    if length == 0 || length > limit - start {
        let allowed = format!("1 to {} pixels from {} = {start}", limit - start, names[0]);
        return Err(Error::out_of_range("region", names[1], length, allowed));
    }
    Ok(())
}

/// Tristimulus values, one a pixel, row 0 on top.
///
/// f64: a ninth of a spectral image's memory, and what glare and gamut mapping make of it is
/// rounded once, to the display's digits.
#[derive(Debug, Clone, PartialEq)]
pub struct XyzImage {
    /// Pixels of a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Row by row from the top.
    pub pixels: Vec<Xyz>,
}

impl XyzImage {
    /// Luminance that `percent` of the pixels do not exceed, linear between their ranks.
    ///
    /// Range: 0 to 100. Errors: a NaN pixel, named; an image without pixels.
    pub fn luminance_percentile(&self, percent: f64) -> Result<f64> {
        self.check_finite()?;
        let mut luminances: Vec<f64> = self.pixels.iter().map(|c| c.y).collect();
        percentile(&mut luminances, percent)
            .ok_or_else(|| Error::inconsistent("image", "has no pixels"))
    }

    /// Errors: [`Error::Inconsistent`] with the first pixel that is NaN or infinite.
    pub fn check_finite(&self) -> Result<()> {
        match self.pixels.iter().position(|c| !c.is_finite()) {
            None => Ok(()),
            Some(at) => Err(self.pixel_error(at, "is not finite")),
        }
    }

    /// An error that names pixel number `at` and its color.
    pub fn pixel_error(&self, at: usize, problem: &str) -> Error {
        let Xyz { x, y, z } = self.pixels[at];
        let (column, row) = (at % self.width, at / self.width);
        let problem = format!("pixel x = {column}, y = {row} {problem}: XYZ = ({x}, {y}, {z})");
        Error::inconsistent("image", problem)
    }
}

#[cfg(test)]
impl XyzImage {
    /// One row of grays of these luminances.
    pub fn gray(luminances: &[f64]) -> Self {
        let pixels = luminances.iter().map(|&y| Xyz::new(y, y, y)).collect();
        Self { width: luminances.len(), height: 1, pixels }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gradient() -> SpectralImage {
        let mut image = SpectralImage::new(4, 3, WavelengthGrid::Step20, Photometry::Relative);
        for (at, value) in image.bands.iter_mut().enumerate() {
            *value = at as f32;
        }
        image
    }

    #[test]
    fn region_mean_is_the_mean_of_its_pixels() {
        let image = gradient();
        let mean = image.mean_bands(Region { x: 1, y: 1, width: 2, height: 2 }).unwrap();
        // Pixels 5, 6, 9, 10: mean 7.5, each 21 bands apart.
        for (band, value) in mean.iter().enumerate() {
            assert_eq!(*value, 7.5 * 21.0 + band as f64);
        }
        let one = image.mean_bands(Region::pixel(3, 2)).unwrap();
        assert_eq!(one[20], 251.0);
    }

    #[test]
    fn regions_outside_are_refused() {
        let message = |x, y, width, height| {
            gradient().mean_bands(Region { x, y, width, height }).unwrap_err().to_string()
        };
        assert_eq!(message(4, 0, 1, 1), "region: x is 4, allowed: 0 to 3 pixels");
        assert_eq!(message(1, 0, 4, 1), "region: width is 4, allowed: 1 to 3 pixels from x = 1");
        assert_eq!(message(0, 2, 1, 2), "region: height is 2, allowed: 1 to 1 pixels from y = 2");
        assert_eq!(message(0, 0, 0, 1), "region: width is 0, allowed: 1 to 4 pixels from x = 0");
        assert!(
            gradient().mean_bands(Region { x: 1, y: 0, width: usize::MAX, height: 1 }).is_err()
        );
    }

    #[test]
    fn image_xyz_equals_pixel_xyz() {
        let image = gradient();
        let xyz = image.to_xyz();
        for (x, y) in [(0, 0), (3, 2), (2, 1)] {
            let direct = image.mean_xyz(Region::pixel(x, y)).unwrap();
            let pixel = xyz.pixels[y * 4 + x];
            // Same terms, scaled before or after the sum.
            assert!((direct.y - pixel.y).abs() <= 1e-14 * direct.y.abs());
            assert!((direct.z - pixel.z).abs() <= 1e-14 * direct.z.abs());
        }
    }

    fn luminances(values: &[f64]) -> XyzImage {
        let pixels = values.iter().map(|&y| Xyz::new(y, y, y)).collect();
        XyzImage { width: values.len(), height: 1, pixels }
    }

    #[test]
    fn percentile_lies_between_ranks() {
        let image = luminances(&[3.0, 0.0, 1.0, 2.0, 4.0]);
        for (percent, expected) in [(0.0, 0.0), (50.0, 2.0), (99.5, 3.98), (100.0, 4.0)] {
            let value = image.luminance_percentile(percent).unwrap();
            assert!((value - expected).abs() < 1e-12, "{percent}: {value}");
        }
        assert_eq!(luminances(&[7.0]).luminance_percentile(99.5).unwrap(), 7.0);
        assert!(luminances(&[]).luminance_percentile(99.5).is_err());
    }

    #[test]
    fn nan_is_an_error_that_names_the_pixel() {
        let image = luminances(&[1.0, f64::NAN]);
        assert_eq!(
            image.luminance_percentile(50.0).unwrap_err().to_string(),
            "image: pixel x = 1, y = 0 is not finite: XYZ = (NaN, NaN, NaN)"
        );
    }
}
