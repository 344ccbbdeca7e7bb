//! One way of showing pictures: exposure, tone, gamut and glare on a display.

use rayon::prelude::*;

use super::exposure::Exposure;
use super::gamut::{Gamut, GamutMap, GamutReport};
use super::glare::{Glare, GlareReport, apply_glare};
use super::model::Display;
use super::tone::Tone;
use crate::color::Xyz;
use crate::error::{Error, Result};
use crate::image::{SpectralImage, XyzImage};

/// How a picture is shown: on which display, how bright, and what becomes of what it cannot show.
///
/// The default is the paper's rendition (eq. 7 and 8, clipped) on sRGB.
#[derive(Debug, Clone)]
pub struct Look {
    /// The display whose digits are written.
    pub display: Display,
    /// How much light of the scene becomes how much light of the display.
    pub exposure: Exposure,
    /// The curve on luminance.
    pub tone: Tone,
    /// What becomes of colors that the display cannot show.
    pub gamut: Gamut,
    /// The eye whose glare the picture shows, if any.
    pub glare: Option<Glare>,
}

impl Default for Look {
    fn default() -> Self {
        Self {
            display: Display::srgb(),
            exposure: Exposure::Auto,
            tone: Tone::Linear,
            gamut: Gamut::Clip,
            glare: None,
        }
    }
}

/// Digits for a display, and what it took to get them.
#[derive(Debug, Clone, PartialEq)]
pub struct DisplayImage {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Red, green and blue, each 0 to 2ⁿ − 1; row 0 on top.
    pub digits: Vec<[u16; 3]>,
    /// Factor from the image's XYZ to cd/m² of the display.
    pub exposure_factor: f64,
    /// How much of the image the display cannot show.
    pub gamut: GamutReport,
}

/// A picture that can be written, and what was done to its light.
#[derive(Debug, Clone, PartialEq)]
pub struct Developed {
    /// What each pixel of the display gets.
    pub picture: DisplayImage,
    /// Light that glare scattered out of the frame; `None` without glare.
    pub glare: Option<GlareReport>,
}

impl Look {
    /// The picture of `image` on this look's display.
    ///
    /// Errors: as [`Look::seen`] and [`Look::present`].
    pub fn develop(&self, image: &SpectralImage) -> Result<Developed> {
        let (seen, glare) = self.seen(image)?;
        Ok(Developed { picture: self.present(&seen)?, glare })
    }

    /// Tristimulus values behind the eye's optics: those of `image`, with its glare if any.
    ///
    /// Errors: as [`apply_glare`]; glare for an image whose view is not known.
    pub fn seen(&self, image: &SpectralImage) -> Result<(XyzImage, Option<GlareReport>)> {
        let Some(glare) = &self.glare else {
            return Ok((image.to_xyz(), None));
        };
        let view = image.view.ok_or_else(|| {
            Error::inconsistent("glare", "the image does not say its view's angle")
        })?;
        let (seen, report) = apply_glare(&image.to_xyz(), view.fov_deg, glare)?;
        Ok((seen, Some(report)))
    }

    /// The digits with which the display shows `image` (eq. 7 and 8); glare is not applied.
    ///
    /// Errors: a pixel that is NaN or infinite, named; an exposure or a tone curve out of range.
    pub fn present(&self, image: &XyzImage) -> Result<DisplayImage> {
        image.check_finite()?;
        let exposure_factor = self.exposure_factor(image)?;
        let mut exposed = image.clone();
        exposed.pixels.iter_mut().for_each(|color| *color = *color * exposure_factor);
        self.tone.apply(&mut exposed, self.display.white().y)?;
        let (digits, gamut) = self.digits(&exposed)?;
        Ok(DisplayImage {
            width: image.width,
            height: image.height,
            digits,
            exposure_factor,
            gamut,
        })
    }

    /// The factor from the image's XYZ to cd/m² of the display.
    ///
    /// Errors: as [`Look::present`].
    pub fn exposure_factor(&self, image: &XyzImage) -> Result<f64> {
        match self.exposure.given()? {
            Some(factor) => Ok(factor),
            None => self.tone.auto_exposure(image, self.display.white().y),
        }
    }

    /// Digits of an image in cd/m² of the display.
    fn digits(&self, exposed: &XyzImage) -> Result<(Vec<[u16; 3]>, GamutReport)> {
        let map = GamutMap::new(&self.display, self.gamut);
        let rows: Vec<(Vec<[u16; 3]>, GamutReport)> = exposed
            .pixels
            .par_chunks(exposed.width.max(1))
            .enumerate()
            .map(|(row, pixels)| digits_of_row(&map, &self.display, pixels).map_err(|at| (row, at)))
            .collect::<std::result::Result<_, _>>()
            .map_err(|(row, at)| exposed.pixel_error(row * exposed.width + at, "has no digits"))?;
        // Row by row in order, so that the report does not depend on the threads.
        let gamut = rows.iter().fold(GamutReport::default(), |sum, (_, row)| sum.merge(*row));
        Ok((rows.into_iter().flat_map(|(digits, _)| digits).collect(), gamut))
    }
}

/// Digits and report of a row, or the column that is not finite.
fn digits_of_row(
    map: &GamutMap,
    display: &Display,
    pixels: &[Xyz],
) -> std::result::Result<(Vec<[u16; 3]>, GamutReport), usize> {
    let mut digits = Vec::with_capacity(pixels.len());
    let mut report = GamutReport::default();
    for (column, &color) in pixels.iter().enumerate() {
        let (rgb, pixel) = map.map(color);
        digits.push(display.digits_from_linear(rgb).ok_or(column)?);
        report = report.merge(pixel);
    }
    Ok((digits, report))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(pixels: Vec<Xyz>) -> XyzImage {
        XyzImage { width: pixels.len(), height: 1, pixels }
    }

    #[test]
    fn auto_exposure_shows_the_percentile_as_white() {
        for display in [Display::srgb(), Display::eizo_t766()] {
            let gray = display.white() * 1e-4;
            let shown = Look { display: display.clone(), ..Look::default() }
                .present(&image(vec![gray; 300]))
                .unwrap();
            assert!(shown.digits.iter().all(|d| *d == [255; 3]));
            assert!((shown.exposure_factor - 1e4).abs() < 1e-8);
            assert_eq!(shown.gamut.outside(), 0);
        }
    }

    #[test]
    fn factor_is_taken_as_it_is() {
        let display = Display::srgb();
        let half = display.xyz_from_digits([188.0, 100.0, 17.0]);
        let look = Look { exposure: Exposure::Factor(0.5), ..Look::default() };
        let shown = look.present(&image(vec![half * 2.0])).unwrap();
        assert_eq!(shown.digits, [[188, 100, 17]]);
    }

    #[test]
    fn nan_never_reaches_digits() {
        let pixels = vec![Xyz::default(), Xyz::new(f64::NAN, 1.0, 1.0)];
        let error = Look::default().present(&image(pixels)).unwrap_err();
        assert_eq!(error.to_string(), "image: pixel x = 1, y = 0 is not finite: XYZ = (NaN, 1, 1)");
    }

    #[test]
    fn overflow_by_exposure_is_an_error_too() {
        let look = Look { exposure: Exposure::Factor(1e300), ..Look::default() };
        let pixels = vec![Xyz::new(1e200, 1e200, 1e200)];
        assert!(look.present(&image(pixels)).is_err());
    }

    #[test]
    fn empty_image() {
        let look = Look { exposure: Exposure::Factor(1.0), ..Look::default() };
        let shown = look.present(&image(vec![])).unwrap();
        assert!(shown.digits.is_empty());
    }

    #[test]
    fn glare_needs_the_angle_of_the_view() {
        use crate::color::Photometry;
        use crate::spectrum::WavelengthGrid;
        let image = SpectralImage::new(2, 1, WavelengthGrid::Step20, Photometry::Absolute);
        let look = Look { glare: Some(Glare::default()), ..Look::default() };
        let message = look.develop(&image).unwrap_err().to_string();
        assert_eq!(message, "glare: the image does not say its view's angle");
        assert!(Look::default().develop(&image).is_ok());
    }
}
