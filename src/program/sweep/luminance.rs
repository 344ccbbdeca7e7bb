//! Luminance in false color, on decades that the views of a sweep share.

use crate::error::Result;
use crate::image::{Metadata, XyzImage};
use crate::output::{ColorSpace, Raster, Samples};
use crate::program::figure::{FalseColor, Scale, false_color};

/// The decades of luminance that a picture shows, the highest ending at a power of ten.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LuminanceScale {
    /// Exponent of the power of ten at the scale's upper end.
    pub top: i32,
    /// Of the brightest pixel, in the unit of the image.
    pub max: f64,
}

/// A lamp and its stray light together span about this much.
const DECADES: i32 = 4;

impl LuminanceScale {
    /// Powers of ten, so that the views of a sweep mostly share one scale.
    pub fn of(image: &XyzImage) -> Self {
        let max = image.pixels.iter().map(|color| color.y).fold(0.0, f64::max);
        let top = if max > 0.0 { max.log10().ceil() as i32 } else { 0 };
        Self { top, max }
    }

    /// Exponents of the powers of ten along the scale.
    pub(super) fn decades(self) -> impl Iterator<Item = i32> {
        self.top - DECADES..=self.top
    }

    /// In words; `unit` may be empty.
    pub(super) fn text(self, unit: &str) -> String {
        let Self { top, max } = self;
        let low = top - DECADES;
        format!("luminance, logarithmic from 1e{low} to 1e{top}{unit}, up to {max:.4e}{unit}")
    }
}

/// The picture of `image` on its own scale.
///
/// Errors: a pixel that is not finite, named.
pub fn luminance_raster(image: &XyzImage, scale: LuminanceScale) -> Result<Raster<'static>> {
    let range = [scale.top - DECADES, scale.top].map(|exponent| 10f64.powi(exponent));
    let options = FalseColor { scale: Scale::Log, range: Some(range), ..FalseColor::default() };
    let panel = false_color(image, &options)?;
    Ok(Raster {
        width: panel.width,
        height: panel.height,
        samples: Samples::Eight(panel.pixels.into_flattened().into()),
        color_space: ColorSpace::Srgb,
        metadata: Metadata::from([("luminance".to_owned(), scale.text(""))]),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Xyz;
    use crate::program::figure::scale_colors;

    fn image(luminances: &[f64]) -> XyzImage {
        let pixels = luminances.iter().map(|&y| Xyz::new(y, y, y)).collect();
        XyzImage { width: luminances.len(), height: 1, pixels }
    }

    #[test]
    fn scales_end_at_powers_of_ten() {
        for (max, top) in [(3.0, 1), (10.0, 1), (10.1, 2), (2e-7, -6), (0.0, 0), (1e300, 300)] {
            let scale = LuminanceScale::of(&image(&[max]));
            assert_eq!((scale.top, scale.max), (top, max));
        }
    }

    #[test]
    fn four_decades_have_colors() {
        let image = image(&[0.0, 0.009, 0.01, 1.0, 100.0]);
        let scale = LuminanceScale::of(&image);
        let raster = luminance_raster(&image, scale).unwrap();
        let colors = scale_colors();
        let [foot, end] = [colors[0], colors[colors.len() - 1]];
        let middle = colors[colors.len() / 2];
        assert_eq!(raster.samples, Samples::Eight([foot, foot, foot, middle, end].concat().into()));
    }

    #[test]
    fn black_is_drawn() {
        let black = image(&[0.0]);
        assert!(luminance_raster(&black, LuminanceScale::of(&black)).is_ok());
    }
}
