//! Luminance as color.

use super::{RasterPanel, Scale, ScaleBar};
use crate::color::Lab;
use crate::display::{Display, Gamut, GamutMap};
use crate::error::{Error, Result};
use crate::image::XyzImage;

/// How luminance becomes color.
#[derive(Debug, Clone, PartialEq)]
pub struct FalseColor {
    /// How colors are spread over the range.
    pub scale: Scale,
    /// cd/m²; `None` ends at the brightest pixel, and begins at 0 or, if log, at 10⁻⁴ of it.
    pub range: Option<[f64; 2]>,
    /// Stands beside the bar, with its unit.
    pub label: String,
}

impl Default for FalseColor {
    fn default() -> Self {
        Self { scale: Scale::Log, range: None, label: "luminance (cd/m²)".to_owned() }
    }
}

/// Entries of the color scale.
const COLORS: usize = 256;

/// a*, b* along the scale: from blue over purple and red to pale yellow.
const HUES: [[f64; 2]; 6] =
    [[8.0, -20.0], [38.0, -52.0], [62.0, -12.0], [56.0, 42.0], [20.0, 70.0], [-8.0, 34.0]];

/// Colors of evenly rising lightness, so that the picture also reads in gray.
pub fn scale_colors() -> Vec<[u8; 3]> {
    let srgb = Display::srgb();
    let map = GamutMap::new(&srgb, Gamut::Desaturate);
    let color = |i: usize| {
        let share = i as f64 / (COLORS - 1) as f64;
        let place = share * (HUES.len() - 1) as f64;
        let below = (place as usize).min(HUES.len() - 2);
        let between = |c: usize| {
            HUES[below][c] + (place - below as f64) * (HUES[below + 1][c] - HUES[below][c])
        };
        let lab = Lab { l: 2.0 + 94.0 * share, a: between(0), b: between(1) };
        let (rgb, _) = map.map(lab.to_xyz(srgb.white()));
        // Finite by construction; black otherwise.
        srgb.digits_from_linear(rgb).unwrap_or_default().map(|digit| digit as u8)
    };
    (0..COLORS).map(color).collect()
}

/// The luminance of `image` in colors, with the bar that explains them.
///
/// Errors: a pixel that is not finite, named; [`Error::OutOfRange`] for a range that does not
/// ascend or, if log, does not begin above 0.
pub fn false_color(image: &XyzImage, options: &FalseColor) -> Result<RasterPanel> {
    image.check_finite()?;
    let range = options.range.unwrap_or_else(|| auto_range(image, options.scale));
    check_range(range, options.scale)?;
    let colors = scale_colors();
    let color = |luminance: f64| {
        let share = share(luminance, range, options.scale).clamp(0.0, 1.0);
        colors[(share * (COLORS - 1) as f64).round() as usize]
    };
    Ok(RasterPanel {
        title: String::new(),
        width: image.width,
        height: image.height,
        pixels: image.pixels.iter().map(|pixel| color(pixel.y)).collect(),
        scale_bar: Some(ScaleBar {
            label: options.label.clone(),
            scale: options.scale,
            range,
            colors,
        }),
    })
}

fn auto_range(image: &XyzImage, scale: Scale) -> [f64; 2] {
    let max = image.pixels.iter().map(|pixel| pixel.y).fold(0.0, f64::max);
    // A black image gets some range.
    let max = if max > 0.0 { max } else { 1.0 };
    match scale {
        Scale::Linear => [0.0, max],
        Scale::Log => [1e-4 * max, max],
    }
}

fn check_range([low, high]: [f64; 2], scale: Scale) -> Result<()> {
    let begins = scale == Scale::Linear || low > 0.0;
    if begins && low < high && low.is_finite() && high.is_finite() {
        return Ok(());
    }
    let allowed = "two ascending numbers, above 0 if log";
    Err(Error::out_of_range("false color", "range", format!("{low} to {high}"), allowed))
}

/// Where a luminance is on the scale; 0 and below are at the foot of a log scale.
fn share(luminance: f64, [low, high]: [f64; 2], scale: Scale) -> f64 {
    match scale {
        Scale::Linear => (luminance - low) / (high - low),
        Scale::Log if luminance <= low => 0.0,
        Scale::Log => (luminance / low).ln() / (high / low).ln(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lightness_rises_evenly() {
        let srgb = Display::srgb();
        let lightness =
            |c: &[u8; 3]| Lab::from_xyz(srgb.xyz_from_digits(c.map(f64::from)), srgb.white()).l;
        let colors = scale_colors();
        for (i, color) in colors.iter().enumerate() {
            let expected = 2.0 + 94.0 * i as f64 / 255.0;
            // Rounding to digits, coarsest in the dark.
            assert!((lightness(color) - expected).abs() < 0.8, "{i}: {color:?}");
        }
    }

    #[test]
    fn log_and_linear_by_hand() {
        let colors = scale_colors();
        let log =
            false_color(&XyzImage::gray(&[0.0, 1e-9, 1.0, 100.0, 1e4]), &FalseColor::default());
        let log = log.unwrap();
        assert_eq!(log.scale_bar.as_ref().unwrap().range, [1.0, 1e4]);
        let expected = [colors[0], colors[0], colors[0], colors[128], colors[255]];
        assert_eq!(log.pixels, expected);
        let options =
            FalseColor { scale: Scale::Linear, range: Some([0.0, 10.0]), ..FalseColor::default() };
        let linear = false_color(&XyzImage::gray(&[0.0, 5.0, 20.0]), &options).unwrap();
        assert_eq!(linear.pixels, [colors[0], colors[128], colors[255]]);
    }

    #[test]
    fn bad_ranges_are_refused_and_black_is_drawn() {
        let options = FalseColor { range: Some([0.0, 1.0]), ..FalseColor::default() };
        assert_eq!(
            false_color(&XyzImage::gray(&[1.0]), &options).unwrap_err().to_string(),
            "false color: range is 0 to 1, allowed: two ascending numbers, above 0 if log"
        );
        assert_eq!(
            false_color(&XyzImage::gray(&[0.0]), &FalseColor::default()).unwrap().pixels,
            [scale_colors()[0]]
        );
    }
}
