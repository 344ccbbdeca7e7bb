//! From tristimulus values to the digits of a display.

use rayon::prelude::*;

use super::exposure::Exposure;
use super::gamut::{Gamut, GamutMap, GamutReport};
use super::model::Display;
use super::tone::Tone;
use crate::color::Xyz;
use crate::error::Result;
use crate::image::XyzImage;

/// How a scene is fitted to a display; the default is the paper's.
#[derive(Clone, Copy, Default)]
pub struct Rendition<'a> {
    pub exposure: Exposure,
    pub tone: Tone<'a>,
    pub gamut: Gamut,
}

/// Digits for a display, and what it took to get them.
#[derive(Debug, Clone, PartialEq)]
pub struct DisplayImage {
    pub width: usize,
    pub height: usize,
    /// 0 to 2ⁿ − 1; row 0 on top.
    pub digits: Vec<[u16; 3]>,
    /// From the image's XYZ to cd/m² of the display.
    pub exposure_factor: f64,
    pub gamut: GamutReport,
}

/// The digits with which `display` shows `image` (eq. 7 and 8).
///
/// Errors: a pixel that is NaN or infinite, named; an exposure or a tone curve out of range.
pub fn present(image: &XyzImage, display: &Display, rendition: &Rendition) -> Result<DisplayImage> {
    image.check_finite()?;
    let white_cd_m2 = display.white().y;
    let exposure_factor = match rendition.exposure.given()? {
        Some(factor) => factor,
        None => rendition.tone.auto_exposure(image, white_cd_m2)?,
    };
    let mut exposed = image.clone();
    exposed.pixels.iter_mut().for_each(|color| *color = *color * exposure_factor);
    rendition.tone.apply(&mut exposed, white_cd_m2)?;
    let map = GamutMap::new(display, rendition.gamut);
    let rows: Vec<(Vec<[u16; 3]>, GamutReport)> = exposed
        .pixels
        .par_chunks(exposed.width.max(1))
        .enumerate()
        .map(|(row, pixels)| digits_of_row(&map, display, pixels).map_err(|at| (row, at)))
        .collect::<std::result::Result<_, _>>()
        .map_err(|(row, at)| exposed.pixel_error(row * exposed.width + at, "has no digits"))?;
    // Row by row in order, so that the report does not depend on the threads.
    let gamut = rows.iter().fold(GamutReport::default(), |sum, (_, report)| sum.merge(*report));
    let digits = rows.into_iter().flat_map(|(digits, _)| digits).collect();
    Ok(DisplayImage { width: image.width, height: image.height, digits, exposure_factor, gamut })
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
            let shown = present(&image(vec![gray; 300]), &display, &Rendition::default()).unwrap();
            assert!(shown.digits.iter().all(|d| *d == [255; 3]));
            assert!((shown.exposure_factor - 1e4).abs() < 1e-8);
            assert_eq!(shown.gamut.outside(), 0);
        }
    }

    #[test]
    fn factor_is_taken_as_it_is() {
        let display = Display::srgb();
        let half = display.xyz_from_digits([188.0, 100.0, 17.0]);
        let rendition = Rendition { exposure: Exposure::Factor(0.5), ..Default::default() };
        let shown = present(&image(vec![half * 2.0]), &display, &rendition).unwrap();
        assert_eq!(shown.digits, [[188, 100, 17]]);
    }

    #[test]
    fn nan_never_reaches_digits() {
        let pixels = vec![Xyz::default(), Xyz::new(f64::NAN, 1.0, 1.0)];
        let error = present(&image(pixels), &Display::srgb(), &Rendition::default()).unwrap_err();
        assert_eq!(error.to_string(), "image: pixel x = 1, y = 0 is not finite: XYZ = (NaN, 1, 1)");
    }

    #[test]
    fn overflow_by_exposure_is_an_error_too() {
        let rendition = Rendition { exposure: Exposure::Factor(1e300), ..Default::default() };
        let pixels = vec![Xyz::new(1e200, 1e200, 1e200)];
        assert!(present(&image(pixels), &Display::srgb(), &rendition).is_err());
    }

    #[test]
    fn empty_image() {
        let rendition = Rendition { exposure: Exposure::Factor(1.0), ..Default::default() };
        let shown = present(&image(vec![]), &Display::srgb(), &rendition).unwrap();
        assert!(shown.digits.is_empty());
    }
}
