//! One way of showing pictures: exposure, tone, gamut and glare on a display.

use glam::DVec3;
use rayon::prelude::*;

use super::camera::PhotoCamera;
use super::exposure::{DUSK_CD_M2, Exposure};
use super::gamut::{Gamut, GamutMap, GamutReport};
use super::glare::{Glare, GlareReport, apply_glare};
use super::model::Display;
use super::tone::Tone;
use crate::color::{Photometry, Xyz};
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
    /// A camera that looks in place of the eye; tone, gamut and glare are the eye's.
    pub camera: Option<PhotoCamera>,
}

impl Default for Look {
    fn default() -> Self {
        Self::paper()
    }
}

impl Look {
    /// Names of the looks, in the order of [`Look::named`].
    pub const NAMES: [&'static str; 3] = ["camera", "paper", "seen"];

    /// The look of that name; `None` for others than [`Look::NAMES`].
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "camera" => Some(Self::camera()),
            "paper" => Some(Self::paper()),
            "seen" => Some(Self::seen()),
            _ => None,
        }
    }

    /// Eq. 7 and 8 as the paper has them: each channel clipped by itself.
    pub fn paper() -> Self {
        Self {
            display: Display::srgb(),
            exposure: Exposure::Auto,
            tone: Tone::Linear,
            gamut: Gamut::Clip,
            glare: None,
            camera: None,
        }
    }

    /// What an eye sees that is adapted to a street at dusk: glare around bright parts, highlights
    /// that lose saturation and keep their hue.
    pub fn seen() -> Self {
        Self {
            exposure: Exposure::Adapted(DUSK_CD_M2),
            tone: Tone::Photographic,
            gamut: Gamut::Desaturate,
            glare: Some(Glare { age: 30.0, ..Glare::default() }),
            ..Self::paper()
        }
    }

    /// What a camera records: other sensitivities than the eye's, and channels that fill up.
    pub fn camera() -> Self {
        Self { camera: Some(PhotoCamera::nikon_d5100()), ..Self::paper() }
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

/// Light as it falls on what sees it, not exposed yet.
#[derive(Debug, Clone)]
pub struct Latent {
    width: usize,
    height: usize,
    light: Observed,
    photometry: Photometry,
    glare: Option<GlareReport>,
}

// One at a time, never in a list: a box would cost more than the room.
#[allow(clippy::large_enum_variant)]
#[derive(Debug, Clone)]
enum Observed {
    /// Behind the eye's optics.
    Eye(XyzImage),
    /// Channels of the camera, balanced.
    Camera(PhotoCamera, Vec<[f64; 3]>),
}

impl Look {
    /// The picture of `image` on this look's display.
    ///
    /// Errors: as [`Look::latent`] and [`Look::show`].
    pub fn develop(&self, image: &SpectralImage) -> Result<Developed> {
        let latent = self.latent(image)?;
        self.show(&latent, self.factor(&latent)?)
    }

    /// The light of `image` behind the eye's optics or the camera's filters.
    ///
    /// Errors: as [`apply_glare`] and [`PhotoCamera::raw`]; glare for an image whose view is not known;
    /// a pixel that is NaN or infinite, named.
    pub fn latent(&self, image: &SpectralImage) -> Result<Latent> {
        let (light, glare) = match &self.camera {
            Some(camera) => (Observed::Camera(camera.clone(), camera.raw(image)?), None),
            None => {
                let (seen, glare) = self.seen_by_eye(image)?;
                seen.check_finite()?;
                (Observed::Eye(seen), glare)
            }
        };
        let (width, height, photometry) = (image.width, image.height, image.photometry);
        Ok(Latent { width, height, light, photometry, glare })
    }

    fn seen_by_eye(&self, image: &SpectralImage) -> Result<(XyzImage, Option<GlareReport>)> {
        let Some(glare) = &self.glare else {
            return Ok((image.to_xyz(), None));
        };
        let view = image.view.ok_or_else(|| {
            Error::inconsistent("glare", "the image does not say its view's angle")
        })?;
        let (seen, report) = apply_glare(&image.to_xyz(), view.fov_deg, glare)?;
        Ok((seen, Some(report)))
    }

    /// The factor from the image's XYZ to cd/m² of the display.
    ///
    /// Without a given one: 1 on a display of absolute luminance for light in cd/m²; what fills
    /// the camera; or what the tone curve asks for.
    /// Errors: an exposure out of range; an image without pixels.
    pub fn factor(&self, latent: &Latent) -> Result<f64> {
        let exposure = match (&latent.light, self.exposure) {
            (Observed::Camera(camera, _), Exposure::Auto) => camera.exposure,
            (_, exposure) => exposure,
        };
        let (white, photometry) = (self.display.white().y, latent.photometry);
        if let Some(factor) = exposure.given(white, photometry)? {
            return Ok(factor);
        }
        match &latent.light {
            Observed::Eye(_)
                if self.display.is_absolute() && photometry == Photometry::Absolute =>
            {
                Ok(1.0)
            }
            Observed::Eye(seen) => self.tone.auto_exposure(seen, white),
            Observed::Camera(camera, raw) => Ok(camera.auto_factor(raw) * white),
        }
    }

    /// The digits with which the display shows `latent`, exposed by `factor` (eq. 7 and 8).
    ///
    /// Errors: a tone curve's value out of range, or a pixel that overflows, named.
    pub fn show(&self, latent: &Latent, factor: f64) -> Result<Developed> {
        let (digits, gamut) = match &latent.light {
            Observed::Eye(seen) => self.show_to_eye(seen, factor)?,
            Observed::Camera(camera, raw) => self.show_photograph(camera, raw, factor)?,
        };
        let (width, height) = (latent.width, latent.height);
        let picture = DisplayImage { width, height, digits, exposure_factor: factor, gamut };
        Ok(Developed { picture, glare: latent.glare })
    }

    fn show_to_eye(&self, seen: &XyzImage, factor: f64) -> Result<(Vec<[u16; 3]>, GamutReport)> {
        let mut exposed = seen.clone();
        exposed.pixels.iter_mut().for_each(|color| *color = *color * factor);
        self.tone.apply(&mut exposed, self.display.white().y)?;
        self.digits(&exposed)
    }

    /// A photograph has clipped what it cannot show before the display comes to it.
    fn show_photograph(
        &self,
        camera: &PhotoCamera,
        raw: &[[f64; 3]],
        factor: f64,
    ) -> Result<(Vec<[u16; 3]>, GamutReport)> {
        let matrix = camera.display_matrix(&self.display)?;
        let factor = factor / self.display.white().y;
        let digits = raw.par_iter().map(|&pixel| {
            let light = (matrix * camera.clip(pixel, factor)).clamp(DVec3::ZERO, DVec3::ONE);
            self.display.digits_from_linear(light.to_array()).unwrap_or_default()
        });
        let report = GamutReport { pixels: raw.len(), ..GamutReport::default() };
        Ok((digits.collect(), report))
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

    fn present(look: &Look, pixels: Vec<Xyz>) -> Result<DisplayImage> {
        let seen = XyzImage { width: pixels.len(), height: 1, pixels };
        seen.check_finite()?;
        let latent = Latent {
            width: seen.width,
            height: 1,
            light: Observed::Eye(seen),
            photometry: Photometry::Relative,
            glare: None,
        };
        Ok(look.show(&latent, look.factor(&latent)?)?.picture)
    }

    #[test]
    fn auto_exposure_shows_the_percentile_as_white() {
        for display in [Display::srgb(), Display::eizo_t766()] {
            let gray = display.white() * 1e-4;
            let look = Look { display: display.clone(), ..Look::default() };
            let shown = present(&look, vec![gray; 300]).unwrap();
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
        let shown = present(&look, vec![half * 2.0]).unwrap();
        assert_eq!(shown.digits, [[188, 100, 17]]);
    }

    #[test]
    fn nan_never_reaches_digits() {
        let pixels = vec![Xyz::default(), Xyz::new(f64::NAN, 1.0, 1.0)];
        let error = present(&Look::default(), pixels).unwrap_err();
        assert_eq!(error.to_string(), "image: pixel x = 1, y = 0 is not finite: XYZ = (NaN, 1, 1)");
    }

    #[test]
    fn overflow_by_exposure_is_an_error_too() {
        let look = Look { exposure: Exposure::Factor(1e300), ..Look::default() };
        let pixels = vec![Xyz::new(1e200, 1e200, 1e200)];
        assert!(present(&look, pixels).is_err());
    }

    #[test]
    fn empty_image() {
        let look = Look { exposure: Exposure::Factor(1.0), ..Look::default() };
        let shown = present(&look, vec![]).unwrap();
        assert!(shown.digits.is_empty());
    }

    #[test]
    fn glare_needs_the_angle_of_the_view() {
        use crate::spectrum::WavelengthGrid;
        let image = SpectralImage::new(2, 1, WavelengthGrid::Step20, Photometry::Absolute);
        let look = Look { glare: Some(Glare::default()), ..Look::default() };
        let message = look.develop(&image).unwrap_err().to_string();
        assert_eq!(message, "glare: the image does not say its view's angle");
        assert!(Look::default().develop(&image).is_ok());
    }

    #[test]
    fn absolute_displays_show_cd_m2_as_they_are() {
        use crate::spectrum::WavelengthGrid;
        let mut image = SpectralImage::new(1, 1, WavelengthGrid::Step20, Photometry::Absolute);
        image.bands.fill(1e-3);
        let look = Look { display: Display::rec2020_pq(1000.0).unwrap(), ..Look::default() };
        let shown = look.develop(&image).unwrap().picture;
        let luminance = image.to_xyz().pixels[0].y;
        let digits = shown.digits[0].map(f64::from);
        assert_eq!(shown.exposure_factor, 1.0);
        assert!((look.display.xyz_from_digits(digits).y / luminance - 1.0).abs() < 5e-4);
        // Relative light has no cd/m²: the brightest becomes the peak.
        image.photometry = Photometry::Relative;
        let shown = look.develop(&image).unwrap().picture;
        assert!((shown.exposure_factor * luminance - 1000.0).abs() < 1e-6);
    }

    #[test]
    fn an_adapted_eye_sees_its_adaptation_as_middle_gray() {
        use crate::spectrum::WavelengthGrid;
        let image = SpectralImage::new(1, 1, WavelengthGrid::Step20, Photometry::Absolute);
        let look = Look { exposure: Exposure::Adapted(50.0), ..Look::default() };
        let latent = look.latent(&image).unwrap();
        assert!((look.factor(&latent).unwrap() * 50.0 / 80.0 - 0.18).abs() < 1e-12);
    }
}
