//! A camera as another observer than the eye.

use std::sync::LazyLock;

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::exposure::Exposure;
use super::model::Display;
use crate::color::{D65_XY, Xyz};
use crate::error::{Error, Result};
use crate::image::SpectralImage;
use crate::spectrum::{Spectrum, WavelengthGrid, cie};
use crate::statistics::percentile;

/// Spectral sensitivities of a camera, and how it is set.
///
/// Each channel collects Σ S(λ) I(λ) Δλ, is balanced so that `white_xy` is neutral, and is full at
/// `full_well`, whatever the others have: so a bright red turns to orange and yellow, as in
/// photographs of lamps.
#[derive(Debug, Clone, PartialEq)]
pub struct PhotoCamera {
    /// What it is called.
    pub name: String,
    /// Responses to equal radiant power of the red, green and blue channel, relative, ≥ 0; none
    /// outside of their tables.
    pub sensitivities: [Spectrum; 3],
    /// What a look uses that gives no exposure itself.
    pub exposure: Exposure,
    /// The level at which a channel is full, relative to the display's white; > 0.
    pub full_well: f64,
    /// Chromaticity that the white balance makes neutral.
    pub white_xy: [f64; 2],
}

/// A camera meters the scene, and lets a lamp before a dark background overexpose.
const METERED_PERCENT: f64 = 95.0;

static NIKON_D5100: LazyLock<[Spectrum; 3]> = LazyLock::new(|| {
    let text = include_str!("../../data/cameras/nikon_d5100_npl.csv");
    [1, 2, 3].map(|column| Spectrum::built_in(text, column))
});

static SIGMA_SD_MERRILL: LazyLock<[Spectrum; 3]> = LazyLock::new(|| {
    let text = include_str!("../../data/cameras/sigma_sd_merrill_npl.csv");
    [1, 2, 3].map(|column| Spectrum::built_in(text, column))
});

impl PhotoCamera {
    /// Automatic exposure, full at display white, balanced for D65.
    pub fn new(name: &str, sensitivities: [Spectrum; 3]) -> Self {
        let name = name.to_owned();
        Self { name, sensitivities, exposure: Exposure::Auto, full_well: 1.0, white_xy: D65_XY }
    }

    /// Nikon D5100, measured at NPL; origin in `data/README.md`.
    pub fn nikon_d5100() -> Self {
        Self::new("Nikon D5100", NIKON_D5100.clone())
    }

    /// Sigma SD Merrill, measured at NPL; origin in `data/README.md`.
    pub fn sigma_sd_merrill() -> Self {
        Self::new("Sigma SD Merrill", SIGMA_SD_MERRILL.clone())
    }

    /// Errors: sensitivities of which one follows from the others; a white that lights not all
    /// channels.
    pub fn check(&self) -> Result<()> {
        self.white_raw().map(|_| ())
    }

    /// Sensitivities on a grid, and 0 outside of their tables.
    fn on_grid(&self, grid: WavelengthGrid) -> Vec<[f64; 3]> {
        let value = |spectrum: &Spectrum, lambda_nm: f64| {
            let table = spectrum.wavelengths_nm();
            let inside =
                table.len() < 2 || (table[0]..=table[table.len() - 1]).contains(&lambda_nm);
            if inside { spectrum.at(lambda_nm) } else { 0.0 }
        };
        let channels = |lambda_nm| self.sensitivities.each_ref().map(|s| value(s, lambda_nm));
        grid.wavelengths_nm().map(channels).collect()
    }

    /// The matrix that comes nearest to XYZ from the channels, by least squares over wavelengths.
    fn xyz_from_raw(&self) -> Result<DMat3> {
        let grid = WavelengthGrid::Step5;
        let (mut products, mut squares) = (DMat3::ZERO, DMat3::ZERO);
        for (band, channels) in self.on_grid(grid).into_iter().enumerate() {
            let (cmf, s) = (DVec3::from(cie::cmf(grid, band)), DVec3::from(channels));
            products += DMat3::from_cols(cmf * s.x, cmf * s.y, cmf * s.z);
            squares += DMat3::from_cols(s * s.x, s * s.y, s * s.z);
        }
        let matrix = products * squares.inverse();
        if matrix.is_finite() && matrix.inverse().is_finite() {
            return Ok(matrix);
        }
        let problem = "the channels' sensitivities are zero or depend on each other";
        Err(Error::inconsistent("camera", problem))
    }

    /// Balanced values of the channels: a white of 1 cd/m² gives (1, 1, 1).
    ///
    /// Errors: sensitivities of which one follows from the others; a white that the camera cannot
    /// see as one; a pixel that is not finite.
    pub fn raw(&self, image: &SpectralImage) -> Result<Vec<[f64; 3]>> {
        let sensitivities = self.on_grid(image.grid);
        let white = self.white_raw()?;
        let scale = white.recip() * (cie::K_LM_PER_W * image.grid.step_nm());
        let pixels = image.bands.par_chunks_exact(sensitivities.len().max(1)).map(|bands| {
            let sum = bands
                .iter()
                .zip(&sensitivities)
                .fold(DVec3::ZERO, |sum, (&value, &s)| sum + DVec3::from(s) * f64::from(value));
            (sum * scale).to_array()
        });
        let pixels: Vec<[f64; 3]> = pixels.collect();
        match pixels.iter().position(|p| p.iter().any(|v| !v.is_finite())) {
            None => Ok(pixels),
            Some(at) => {
                let (x, y) = (at % image.width, at / image.width);
                let problem = format!("pixel x = {x}, y = {y} is not finite");
                Err(Error::inconsistent("camera", problem))
            }
        }
    }

    /// Channels of a white of 1 cd/m², in the unit of Σ S I Δλ · 683.
    fn white_raw(&self) -> Result<DVec3> {
        let white = self.xyz_from_raw()?.inverse() * DVec3::from(Xyz::from_xy(self.white_xy, 1.0));
        if white.is_finite() && white.min_element() > 0.0 {
            return Ok(white);
        }
        let [x, y] = self.white_xy;
        let allowed = "a chromaticity that lights all channels";
        Err(Error::out_of_range("camera", "white", format!("({x}, {y})"), allowed))
    }

    /// The factor that fills the brightest channel of the [`METERED_PERCENT`] percentile.
    pub(super) fn auto_factor(&self, raw: &[[f64; 3]]) -> f64 {
        let mut brightest: Vec<f64> =
            raw.iter().map(|p| p.iter().copied().fold(0.0, f64::max)).collect();
        let level = [METERED_PERCENT, 100.0].map(|p| percentile(&mut brightest, p).unwrap_or(0.0));
        let level = level.into_iter().find(|&level| level > 0.0);
        level.map_or(1.0, |level| self.full_well / level)
    }

    /// From balanced channels, full at 1, to light of the display's channels: the camera's white
    /// becomes D65 as bright as the display can.
    ///
    /// Errors: as [`PhotoCamera::raw`].
    pub(super) fn display_matrix(&self, display: &Display) -> Result<DMat3> {
        let mixed = display.matrix().inverse()
            * self.xyz_from_raw()?
            * DMat3::from_diagonal(self.white_raw()?);
        let d65 = display.matrix().inverse() * DVec3::from(Xyz::from_xy(D65_XY, 1.0));
        let target = d65 / d65.max_element();
        let gains = target / (mixed * DVec3::ONE);
        Ok(DMat3::from_diagonal(gains) * mixed)
    }

    /// What a channel keeps.
    pub(super) fn clip(&self, raw: [f64; 3], factor: f64) -> DVec3 {
        DVec3::from(raw.map(|value| (value * factor).clamp(0.0, self.full_well)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Photometry;

    fn image(light: &Spectrum) -> SpectralImage {
        let grid = WavelengthGrid::Step5;
        let mut image = SpectralImage::new(1, 1, grid, Photometry::Absolute);
        let bands = light.on_grid(grid);
        image.bands.iter_mut().zip(&bands).for_each(|(place, &value)| *place = value as f32);
        image
    }

    #[test]
    fn daylight_is_neutral() {
        for camera in [PhotoCamera::nikon_d5100(), PhotoCamera::sigma_sd_merrill()] {
            let d65 = cie::illuminant("D65").unwrap();
            let [r, g, b] = camera.raw(&image(&d65)).unwrap()[0];
            // The matrix takes D65 for the nearest that three channels can tell.
            assert!((r / g - 1.0).abs() < 0.12 && (b / g - 1.0).abs() < 0.12, "{r} {g} {b}");
            let matrix = camera.display_matrix(&Display::srgb()).unwrap();
            assert!((matrix * DVec3::ONE - DVec3::ONE).length() < 1e-12);
        }
    }

    #[test]
    fn bright_red_turns_to_orange_and_yellow() {
        let camera = PhotoCamera::nikon_d5100();
        let red = Spectrum::from_pairs("red", [(599.0, 0.0), (600.0, 1.0), (780.0, 1.0)]).unwrap();
        let raw = camera.raw(&image(&red)).unwrap()[0];
        let ratio = |factor: f64| {
            let clipped = camera.clip(raw, factor);
            clipped.y / clipped.x
        };
        let full = camera.auto_factor(&[raw]);
        assert!(ratio(full) < 0.4, "{raw:?}");
        assert!(ratio(4.0 * full) > 1.9 * ratio(full), "green fills up while red is full");
    }

    #[test]
    fn equal_channels_are_refused() {
        let one = Spectrum::constant(1.0);
        let camera = PhotoCamera::new("gray", [one.clone(), one.clone(), one]);
        let message = camera.raw(&image(&Spectrum::constant(1.0))).unwrap_err().to_string();
        assert_eq!(message, "camera: the channels' sensitivities are zero or depend on each other");
    }
}
