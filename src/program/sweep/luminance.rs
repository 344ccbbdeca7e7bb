//! Luminance in false color, on a range that the views of a sweep share.

use crate::error::Result;
use crate::image::{Metadata, XyzImage};
use crate::output::{ColorSpace, Digits, Raster};
use crate::program::figure::{FalseColor, Scale, false_color};
use crate::statistics::percentile;

/// The luminances that a picture in false color tells apart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LuminanceScale {
    /// Logarithmic, from and to, in the unit of the image.
    pub range: [f64; 2],
    /// Luminance of the brightest pixel, in the unit of the image.
    pub max: f64,
}

/// Percentiles of the luminance of lit pixels at the ends of the range.
const PERCENTILES: [f64; 2] = [5.0, 99.8];

/// A lamp and its stray light together span about this much.
const MOST_DECADES: f64 = 5.0;

impl LuminanceScale {
    /// The range of an image without light.
    pub const BLACK: [f64; 2] = [0.1, 1.0];

    /// By percentiles, so that one hot pixel does not decide.
    pub fn of(image: &XyzImage) -> Self {
        let lit = image.pixels.iter().map(|color| color.y).filter(|&y| y > 0.0);
        let mut lit: Vec<f64> = lit.collect();
        let max = lit.iter().copied().fold(0.0, f64::max);
        let [low, high] = PERCENTILES.map(|percent| percentile(&mut lit, percent).unwrap_or(0.0));
        Self { range: Self::range_of_all(&[[low, high]]), max }
    }

    /// One range for all: to the highest, and down to the lowest within [`MOST_DECADES`]; a decade
    /// at least.
    pub(super) fn range_of_all(ranges: &[[f64; 2]]) -> [f64; 2] {
        let high = ranges.iter().map(|range| range[1]).fold(0.0, f64::max);
        let low = ranges.iter().map(|range| range[0]).fold(f64::INFINITY, f64::min);
        if high <= 0.0 {
            return Self::BLACK;
        }
        [low.clamp(high * 10f64.powf(-MOST_DECADES), 0.1 * high), high]
    }

    /// Luminances at the ends of the scale and between, evenly along it.
    pub(super) fn marks(self) -> [f64; 5] {
        let [low, high] = self.range;
        [0.0, 0.25, 0.5, 0.75, 1.0].map(|share| low * (high / low).powf(share))
    }

    /// In words; `unit` may be empty.
    pub(super) fn text(self, unit: &str) -> String {
        let Self { range: [low, high], max } = self;
        format!("luminance, logarithmic from {low:.2e} to {high:.2e}{unit}, up to {max:.4e}{unit}")
    }
}

/// The picture of `image` on `scale`.
///
/// Errors: a pixel that is not finite, named.
pub fn luminance_raster(image: &XyzImage, scale: LuminanceScale) -> Result<Raster<'static>> {
    let options =
        FalseColor { scale: Scale::Log, range: Some(scale.range), ..FalseColor::default() };
    let panel = false_color(image, &options)?;
    Ok(Raster {
        width: panel.width,
        height: panel.height,
        samples: Digits::Eight(panel.pixels.into_flattened().into()),
        color_space: ColorSpace::Srgb,
        metadata: Metadata::from([("luminance".to_owned(), scale.text(""))]),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::figure::scale_colors;

    #[test]
    fn scales_end_at_percentiles_of_what_is_lit() {
        let lit: Vec<f64> = (0..=1000).map(|i| 10f64.powf(f64::from(i) / 250.0)).collect();
        let dark = [vec![0.0; 5000], lit].concat();
        let LuminanceScale { range: [low, high], max } = LuminanceScale::of(&XyzImage::gray(&dark));
        // 5 % and 99.8 % of four decades.
        assert!((low.log10() - 0.2).abs() < 1e-2 && (high.log10() - 3.992).abs() < 1e-2);
        assert_eq!(max, 1e4);
        assert_eq!(LuminanceScale::of(&XyzImage::gray(&[0.0])).range, LuminanceScale::BLACK);
        // A decade at least, and five at most.
        assert_eq!(LuminanceScale::of(&XyzImage::gray(&[7.0])).range, [0.1 * 7.0, 7.0]);
        let wide = LuminanceScale::range_of_all(&[[1e-9, 1.0], [2.0, 10.0]]);
        assert!((wide[0] / 1e-4 - 1.0).abs() < 1e-12 && wide[1] == 10.0);
    }

    #[test]
    fn the_range_has_all_colors() {
        let image = XyzImage::gray(&[0.0, 0.009, 0.01, 1.0, 100.0]);
        let scale = LuminanceScale { range: [0.01, 100.0], max: 100.0 };
        let raster = luminance_raster(&image, scale).unwrap();
        let colors = scale_colors();
        let [foot, end] = [colors[0], colors[colors.len() - 1]];
        let middle = colors[colors.len() / 2];
        assert_eq!(raster.samples, Digits::Eight([foot, foot, foot, middle, end].concat().into()));
        assert!((scale.marks()[2] - 1.0).abs() < 1e-12);
    }

    #[test]
    fn black_is_drawn() {
        let black = XyzImage::gray(&[0.0]);
        assert!(luminance_raster(&black, LuminanceScale::of(&black)).is_ok());
    }
}
