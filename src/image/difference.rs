//! How far an image is from a reference of the same scene.

use rayon::prelude::*;

use crate::color::{D65_XY, Lab, Xyz, delta_e_2000};
use crate::error::{Error, Result};
use crate::image::{AUTO_PERCENT, SpectralImage, XyzImage};
use crate::spectrum::{Spectrum, WavelengthGrid};
use crate::statistics::percentile;

/// Differences over the lit pixels: those whose luminance in the reference is at least [`LIT`] of
/// what a picture of it would show as white.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImageDifference {
    /// Pixels that were compared.
    pub lit_pixels: usize,
    /// Root mean square of (Y − Y_ref)/Y_ref.
    pub relative_rms: f64,
    /// The largest |Y − Y_ref|/Y_ref.
    pub worst: f64,
    /// CIEDE2000 as displayed: white is D65 with the luminance that auto exposure takes for it.
    pub mean_delta_e_2000: f64,
    /// CIEDE2000 that 95 % of the lit pixels do not exceed.
    pub percentile_95_delta_e_2000: f64,
    /// √(Σ (I − I_ref)² / Σ I_ref²) over lit pixels and bands of the reference.
    pub spectral_rms: f64,
}

/// Below a hundredth of white a picture shows next to nothing.
pub const LIT: f64 = 0.01;

impl ImageDifference {
    /// Errors: images of different size; a reference without light or with a pixel that is not
    /// finite.
    pub fn between(image: &SpectralImage, reference: &SpectralImage) -> Result<Self> {
        let sizes = [image, reference].map(|i| [i.width, i.height]);
        if sizes[0] != sizes[1] {
            let [a, b] = sizes;
            let problem = format!("{} × {} and {} × {} pixels", a[0], a[1], b[0], b[1]);
            return Err(Error::inconsistent("image difference", problem));
        }
        let (shown, expected) = (image.to_xyz(), reference.to_xyz());
        let white = white_of(&expected)?;
        let threshold = lit_luminance(expected.pixels.iter().map(|c| c.y).collect());
        let is_lit = |pixel: &usize| expected.pixels[*pixel].y >= threshold;
        let lit: Vec<usize> = (0..expected.pixels.len()).filter(is_lit).collect();
        let colors: Vec<[Xyz; 2]> =
            lit.iter().map(|&at| [shown.pixels[at], expected.pixels[at]]).collect();
        let relative = |[color, reference]: &[Xyz; 2]| (color.y - reference.y) / reference.y;
        let square: f64 = colors.iter().map(|pair| relative(pair).powi(2)).sum();
        let mut delta_e: Vec<f64> = colors
            .par_iter()
            .map(|pair| pair.map(|color| Lab::from_xyz(color, white)))
            .map(|[lab, reference]| delta_e_2000(lab, reference))
            .collect();
        let mean_delta_e_2000 = delta_e.iter().sum::<f64>() / lit.len() as f64;
        Ok(Self {
            lit_pixels: lit.len(),
            relative_rms: (square / lit.len() as f64).sqrt(),
            worst: colors.iter().map(|pair| relative(pair).abs()).fold(0.0, f64::max),
            mean_delta_e_2000,
            percentile_95_delta_e_2000: percentile(&mut delta_e, 95.0).unwrap_or(0.0),
            spectral_rms: spectral_rms(image, reference, &lit),
        })
    }
}

/// D65 as bright as auto exposure takes for white; above 0, so at least one pixel is lit.
fn white_of(reference: &XyzImage) -> Result<Xyz> {
    reference.check_finite()?;
    let luminance = white_luminance(reference.pixels.iter().map(|c| c.y).collect());
    if luminance <= 0.0 {
        return Err(Error::inconsistent("image difference", "the reference is black"));
    }
    Ok(Xyz::from_xy(D65_XY, luminance))
}

/// What counts as lit in a picture with these luminances; 0 if all are.
fn white_luminance(mut luminances: Vec<f64>) -> f64 {
    let shares = [AUTO_PERCENT, 100.0].map(|percent| percentile(&mut luminances, percent));
    shares.into_iter().flatten().find(|&luminance| luminance > 0.0).unwrap_or(0.0)
}

/// The luminance from which on pixels of a picture with these count as lit; 0 if all are black.
pub fn lit_luminance(luminances: Vec<f64>) -> f64 {
    LIT * white_luminance(luminances)
}

fn spectral_rms(image: &SpectralImage, reference: &SpectralImage, pixels: &[usize]) -> f64 {
    let of_pixel = |&at: &usize| {
        let (x, y) = (at % image.width, at / image.width);
        let bands = bands_on(image, [x, y], reference.grid);
        let pairs = bands.iter().zip(reference.pixel(x, y)).map(|(&a, &b)| [a, f64::from(b)]);
        pairs.fold([0.0, 0.0], |[d, r], [a, b]| [d + (a - b).powi(2), r + b * b])
    };
    // In the order of the pixels, so that the sum does not depend on the threads.
    let sums: Vec<[f64; 2]> = pixels.par_iter().map(of_pixel).collect();
    let [difference, total] = sums.iter().fold([0.0; 2], |[a, b], s| [a + s[0], b + s[1]]);
    (difference / total).sqrt()
}

/// A pixel's bands on another grid, linear between its own.
fn bands_on(image: &SpectralImage, [x, y]: [usize; 2], grid: WavelengthGrid) -> Vec<f64> {
    let bands = image.pixel(x, y).iter().map(|&value| f64::from(value));
    if image.grid == grid {
        return bands.collect();
    }
    let rows = image.grid.wavelengths_nm().zip(bands);
    // A grid's wavelengths ascend and an image's values are finite.
    Spectrum::from_pairs("image", rows).map_or_else(|_| Vec::new(), |s| s.on_grid(grid))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Photometry;

    fn gray(grid: WavelengthGrid, values: &[f32]) -> SpectralImage {
        let mut image = SpectralImage::new(values.len(), 1, grid, Photometry::Relative);
        let bands = values.iter().flat_map(|&value| std::iter::repeat_n(value, grid.bands()));
        image.bands = bands.collect();
        image
    }

    #[test]
    fn equal_images_do_not_differ() {
        let image = gray(WavelengthGrid::Step5, &[0.0, 1.0, 2.0]);
        let found = ImageDifference::between(&image, &image).unwrap();
        let ImageDifference { lit_pixels, relative_rms, worst, spectral_rms, .. } = found;
        assert_eq!((lit_pixels, relative_rms, worst, spectral_rms), (2, 0.0, 0.0, 0.0));
        assert_eq!(found.percentile_95_delta_e_2000, 0.0);
    }

    #[test]
    fn one_pixel_off_by_a_tenth() {
        let reference = gray(WavelengthGrid::Step5, &[1.0, 1.0, 1.0, 1.0, 0.001]);
        let image = gray(WavelengthGrid::Step5, &[1.0, 1.1, 1.0, 1.0, 9.0]);
        let found = ImageDifference::between(&image, &reference).unwrap();
        assert_eq!(found.lit_pixels, 4, "the dark pixel does not count");
        // f32 holds 1.1 to 2e-8.
        assert!((found.worst - 0.1).abs() < 1e-7);
        assert!((found.relative_rms - 0.05).abs() < 1e-7);
        assert!((found.spectral_rms - 0.05).abs() < 1e-7);
        assert!(found.mean_delta_e_2000 > 0.1);
    }

    #[test]
    fn coarser_grids_are_interpolated() {
        let reference = gray(WavelengthGrid::Step5, &[1.0, 2.0]);
        let image = gray(WavelengthGrid::Step20, &[1.0, 2.0]);
        let found = ImageDifference::between(&image, &reference).unwrap();
        assert_eq!(found.spectral_rms, 0.0);
        // The sums of ȳ Δλ over 21 and over 81 bands differ by 1.141e-3.
        assert!((found.worst - 1.141e-3).abs() < 1e-6, "{}", found.worst);
    }

    #[test]
    fn black_references_and_other_sizes_are_refused() {
        let problem = |a: &[f32], b: &[f32]| {
            let [a, b] = [a, b].map(|values| gray(WavelengthGrid::Step20, values));
            ImageDifference::between(&a, &b).unwrap_err().to_string()
        };
        assert_eq!(problem(&[1.0], &[0.0]), "image difference: the reference is black");
        assert_eq!(problem(&[1.0], &[1.0, 2.0]), "image difference: 1 × 1 and 2 × 1 pixels");
    }
}
