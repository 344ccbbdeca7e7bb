//! Curves on luminance that bring a scene's range into a display's; chromaticity is kept.

use std::fmt;
use std::sync::Arc;

use super::exposure;
use crate::error::Result;
use crate::image::XyzImage;

/// A curve from luminance to luminance, both relative to display white.
#[derive(Clone, Default)]
pub enum Tone {
    /// Luminance as it is.
    #[default]
    Linear,
    /// L/(1 + L).
    Reinhard,
    /// L (1 + L/L_white²)/(1 + L), with the brightest pixel as L_white; its automatic exposure
    /// puts the mean of log luminance at [`MIDDLE_GRAY`].
    ///
    /// Source: Reinhard, Stark, Shirley & Ferwerda, "Photographic tone reproduction for digital
    /// images", SIGGRAPH 2002, eq. 1, 2 and 4. Deviation: the mean is over the pixels that are not
    /// black, since a lamp stands before a black background.
    Photographic,
    /// Any other; must return finite values ≥ 0.
    Curve(Arc<ToneCurve>),
}

/// From luminance to luminance, both relative to display white.
pub type ToneCurve = dyn Fn(f64) -> Result<f64> + Send + Sync;

impl fmt::Debug for Tone {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Linear => "Linear",
            Self::Reinhard => "Reinhard",
            Self::Photographic => "Photographic",
            Self::Curve(_) => "Curve",
        })
    }
}

/// Key of [`Tone::Photographic`].
pub const MIDDLE_GRAY: f64 = 0.18;

impl Tone {
    /// Factor to cd/m² that this curve wants for `image`.
    ///
    /// Errors: as [`XyzImage::luminance_percentile`].
    pub fn auto_exposure(&self, image: &XyzImage, white_cd_m2: f64) -> Result<f64> {
        match (self, log_mean_luminance(image)) {
            (Self::Photographic, Some(mean)) => {
                image.check_finite()?;
                Ok(MIDDLE_GRAY * white_cd_m2 / mean)
            }
            _ => exposure::auto_factor(image, white_cd_m2),
        }
    }

    /// Bends the luminances of `image`, which is exposed in cd/m².
    ///
    /// Errors: those of the curve; a value of it that is negative or not finite, with its pixel.
    pub fn apply(&self, image: &mut XyzImage, white_cd_m2: f64) -> Result<()> {
        match self {
            Self::Linear => Ok(()),
            Self::Reinhard => bend(image, white_cd_m2, |l| Ok(l / (1.0 + l))),
            Self::Photographic => {
                let brightest = image.pixels.iter().map(|c| c.y).fold(0.0, f64::max) / white_cd_m2;
                let white_2 = brightest * brightest;
                bend(image, white_cd_m2, |l| Ok(l * (1.0 + l / white_2) / (1.0 + l)))
            }
            Self::Curve(curve) => bend(image, white_cd_m2, &**curve),
        }
    }
}

/// exp of the mean of ln Y over pixels with Y > 0.
fn log_mean_luminance(image: &XyzImage) -> Option<f64> {
    let lit = image.pixels.iter().map(|c| c.y).filter(|&y| y > 0.0);
    let (sum, count) = lit.fold((0.0, 0u64), |(sum, count), y| (sum + y.ln(), count + 1));
    (count > 0).then(|| (sum / count as f64).exp())
}

fn bend(image: &mut XyzImage, white_cd_m2: f64, curve: impl Fn(f64) -> Result<f64>) -> Result<()> {
    for at in 0..image.pixels.len() {
        let luminance = image.pixels[at].y / white_cd_m2;
        if luminance > 0.0 {
            let bent = curve(luminance)?;
            if !(bent >= 0.0 && bent.is_finite()) {
                return Err(image.pixel_error(at, &format!("gets {bent} by the tone curve")));
            }
            image.pixels[at] = image.pixels[at] * (bent / luminance);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Xyz;

    fn image() -> XyzImage {
        let pixels = [0.0, 10.0, 100.0, 1000.0].map(|y| Xyz::new(2.0 * y, y, 0.1 * y)).to_vec();
        XyzImage { width: 4, height: 1, pixels }
    }

    fn luminances(tone: Tone) -> Vec<f64> {
        let mut image = image();
        tone.apply(&mut image, 100.0).unwrap();
        for color in &image.pixels[1..] {
            // Chromaticity is kept to rounding.
            assert!((color.x / color.y - 2.0).abs() < 1e-14, "{color:?}");
            assert!((color.z / color.y - 0.1).abs() < 1e-14, "{color:?}");
        }
        image.pixels.iter().map(|c| c.y).collect()
    }

    fn assert_close(values: &[f64], expected: &[f64]) {
        for (value, wanted) in values.iter().zip(expected) {
            assert!((value - wanted).abs() <= 1e-13 * wanted, "{values:?}");
        }
    }

    #[test]
    fn curves_by_hand() {
        assert_eq!(luminances(Tone::Linear), [0.0, 10.0, 100.0, 1000.0]);
        let reinhard = [0.0, 10.0 / 1.1, 50.0, 1000.0 / 11.0];
        assert_close(&luminances(Tone::Reinhard), &reinhard);
        // L_white = 10; the brightest pixel reaches display white.
        let photographic = [0.0, 10.0 * 1.001 / 1.1, 100.0 * 1.01 / 2.0, 100.0];
        assert_close(&luminances(Tone::Photographic), &photographic);
        let root = |l: f64| Ok(l.sqrt());
        let roots = [0.0, 100.0 * 0.1f64.sqrt(), 100.0, 100.0 * 10f64.sqrt()];
        assert_close(&luminances(Tone::Curve(Arc::new(root))), &roots);
    }

    #[test]
    fn photographic_exposure_puts_the_log_mean_at_middle_gray() {
        // Log mean of 10, 100 and 1000 is 100.
        let factor = Tone::Photographic.auto_exposure(&image(), 50.0).unwrap();
        assert!((factor - 0.18 * 50.0 / 100.0).abs() < 1e-12);
    }

    #[test]
    fn a_curve_that_gives_nonsense_names_the_pixel() {
        let negative = |l: f64| Ok(-l);
        let message =
            Tone::Curve(Arc::new(negative)).apply(&mut image(), 100.0).unwrap_err().to_string();
        assert_eq!(
            message,
            "image: pixel x = 1, y = 0 gets -0.1 by the tone curve: XYZ = (20, 10, 1)"
        );
    }
}
