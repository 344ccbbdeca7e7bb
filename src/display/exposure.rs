//! How much light of the scene becomes how much light of the display.

use super::tone::MIDDLE_GRAY;
use crate::color::Photometry;
use crate::error::{Error, Result};
use crate::image::{AUTO_PERCENT, XyzImage};

/// The factor from the image's XYZ to the display's, cd/m².
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Exposure {
    /// What the tone curve asks for: in general [`AUTO_PERCENT`] of the pixels below display white.
    #[default]
    Auto,
    /// > 0.
    Factor(f64),
    /// 2 to this power.
    Stops(f64),
    /// This luminance, cd/m², is shown as middle gray: an eye is adapted to it. For relative
    /// light, which has no cd/m², as [`Exposure::Auto`].
    Adapted(f64),
}

/// Adaptation of an eye before a lit lamp at dusk, cd/m².
pub const DUSK_CD_M2: f64 = 300.0;

impl Exposure {
    /// The factor that is given, for a display of this white, or `None` for [`Exposure::Auto`].
    ///
    /// Errors: [`Error::OutOfRange`] for a factor that is not finite and above 0.
    pub fn given(self, white_cd_m2: f64, photometry: Photometry) -> Result<Option<f64>> {
        let (what, value, factor) = match self {
            Self::Auto => return Ok(None),
            Self::Factor(factor) => ("factor", factor, factor),
            Self::Stops(stops) => ("stops", stops, stops.exp2()),
            Self::Adapted(_) if photometry == Photometry::Relative => return Ok(None),
            Self::Adapted(luminance) => {
                ("adaptation", luminance, MIDDLE_GRAY * white_cd_m2 / luminance)
            }
        };
        if factor > 0.0 && factor.is_finite() {
            Ok(Some(factor))
        } else {
            Err(Error::out_of_range("exposure", what, value, "a finite factor above 0"))
        }
    }
}

/// Factor that puts the [`AUTO_PERCENT`] percentile at `white_cd_m2`.
///
/// Where that percentile is black (a lamp that fills less than 0.5 % of its image) the brightest
/// pixel is put there, and a black image is left as it is.
pub fn auto_factor(image: &XyzImage, white_cd_m2: f64) -> Result<f64> {
    for percent in [AUTO_PERCENT, 100.0] {
        let factor = white_cd_m2 / image.luminance_percentile(percent)?;
        if factor > 0.0 && factor.is_finite() {
            return Ok(factor);
        }
    }
    Ok(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Xyz;

    fn image(luminances: impl IntoIterator<Item = f64>) -> XyzImage {
        let pixels: Vec<Xyz> = luminances.into_iter().map(|y| Xyz::new(y, y, y)).collect();
        XyzImage { width: pixels.len(), height: 1, pixels }
    }

    #[test]
    fn auto_puts_the_percentile_at_white() {
        // 1001 luminances 0 to 1000: the 99.5th percentile is 995.
        let factor = auto_factor(&image((0..=1000).map(f64::from)), 80.0).unwrap();
        assert!((factor - 80.0 / 995.0).abs() < 1e-15);
    }

    #[test]
    fn auto_falls_back_to_the_brightest_pixel_then_to_one() {
        let mut mostly_black = image(std::iter::repeat_n(0.0, 1000));
        assert_eq!(auto_factor(&mostly_black, 80.0).unwrap(), 1.0);
        mostly_black.pixels[3].y = 160.0;
        assert_eq!(auto_factor(&mostly_black, 80.0).unwrap(), 0.5);
    }

    #[test]
    fn factors_and_stops() {
        assert_eq!(Exposure::Auto.given(80.0, Photometry::Relative).unwrap(), None);
        assert_eq!(Exposure::Factor(0.25).given(80.0, Photometry::Relative).unwrap(), Some(0.25));
        assert_eq!(Exposure::Stops(-2.0).given(80.0, Photometry::Relative).unwrap(), Some(0.25));
        assert_eq!(
            Exposure::Factor(0.0).given(80.0, Photometry::Relative).unwrap_err().to_string(),
            "exposure: factor is 0, allowed: a finite factor above 0"
        );
        assert!(Exposure::Stops(f64::NAN).given(80.0, Photometry::Relative).is_err());
        assert!(Exposure::Stops(1e9).given(80.0, Photometry::Relative).is_err());
    }
}
