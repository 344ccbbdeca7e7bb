//! Luminance in false color: four decades, from black over red to white.

use super::page::Legend;
use crate::image::{Metadata, XyzImage};
use crate::output::{ColorSpace, Raster, Samples};

/// The decades of luminance that a picture shows, the highest ending at a power of ten.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LuminanceScale {
    /// Exponent of the power of ten that is shown white.
    pub top: i32,
    /// Of the brightest pixel, in the unit of the image.
    pub max: f64,
}

/// A lamp and its stray light together span about this much.
pub const DECADES: i32 = 4;

/// sRGB, evenly spaced; each lighter than the one before.
pub(super) const ANCHORS: [[f64; 3]; 6] = [
    [0.0, 0.0, 0.0],
    [0.24, 0.06, 0.44],
    [0.62, 0.12, 0.42],
    [0.92, 0.38, 0.20],
    [0.99, 0.72, 0.25],
    [1.0, 1.0, 0.88],
];

impl LuminanceScale {
    /// Powers of ten, so that the views of a sweep mostly share one scale.
    pub fn of(image: &XyzImage) -> Self {
        let max = image.pixels.iter().map(|color| color.y).fold(0.0, f64::max);
        let top = if max > 0.0 { max.log10().ceil() as i32 } else { 0 };
        Self { top, max }
    }

    /// 0 to 1, and 0 for black.
    fn place(self, luminance: f64) -> f64 {
        if luminance <= 0.0 {
            return 0.0;
        }
        let decades = luminance.log10() - f64::from(self.top - DECADES);
        (decades / f64::from(DECADES)).clamp(0.0, 1.0)
    }
}

/// The picture of `image` on its own scale.
pub fn luminance_raster(image: &XyzImage, scale: LuminanceScale) -> Raster<'static> {
    let samples = image.pixels.iter().flat_map(|pixel| digits(scale.place(pixel.y))).collect();
    Raster {
        width: image.width,
        height: image.height,
        samples: Samples::Eight(samples),
        color_space: ColorSpace::Srgb,
        metadata: Metadata::from([("luminance".to_owned(), Legend::of(scale).text())]),
    }
}

fn digits(place: f64) -> [u8; 3] {
    let last = ANCHORS.len() - 1;
    let position = place * last as f64;
    let before = (position as usize).min(last - 1);
    let t = position - before as f64;
    std::array::from_fn(|c| {
        let value = ANCHORS[before][c] + t * (ANCHORS[before + 1][c] - ANCHORS[before][c]);
        (value * 255.0).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::{Xyz, srgb_decode, xyz_from_rec709};

    #[test]
    fn brighter_is_lighter() {
        let luminance = |step: u32| {
            let rgb = digits(f64::from(step) / 255.0);
            xyz_from_rec709(rgb.map(|d| srgb_decode(f64::from(d) / 255.0))).y
        };
        for step in 1..=255 {
            assert!(luminance(step) > luminance(step - 1) - 1e-4, "step {step}");
        }
        assert_eq!(digits(0.0), [0; 3]);
        assert_eq!(digits(1.0), [255, 255, 224]);
    }

    #[test]
    fn scales_end_at_powers_of_ten() {
        let image = |y: f64| XyzImage { width: 1, height: 1, pixels: vec![Xyz::new(y, y, y)] };
        for (max, top) in [(3.0, 1), (10.0, 1), (10.1, 2), (2e-7, -6), (0.0, 0), (1e300, 300)] {
            let scale = LuminanceScale::of(&image(max));
            assert_eq!((scale.top, scale.max), (top, max));
        }
        let scale = LuminanceScale { top: 2, max: 100.0 };
        for (luminance, place) in [(100.0, 1.0), (1.0, 0.5), (1e-9, 0.0), (0.0, 0.0), (1e9, 1.0)] {
            assert_eq!(scale.place(luminance), place);
        }
    }
}
