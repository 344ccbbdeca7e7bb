//! A picture of colors as an image of spectra.

use super::SpectralImage;
use crate::color::upsampling::Upsampling;
use crate::color::{Photometry, Xyz};
use crate::spectrum::WavelengthGrid;

impl SpectralImage {
    /// Colors, row by row, as smooth spectra that have them, with the luminance Y; and the share of
    /// pixels that no mix of P3's primaries has, which are paled.
    ///
    /// The spectra are not those of what the picture shows: see [`Upsampling`].
    pub fn from_colors(
        width: usize,
        height: usize,
        colors: impl Iterator<Item = Xyz> + Clone,
        photometry: Photometry,
    ) -> (Self, f64) {
        let (upsampling, outside) = Upsampling::holding(colors.clone());
        let mut image = Self::new(width, height, WavelengthGrid::Step5, photometry);
        let spectra = [0, 1, 2].map(|primary| upsampling.bands(primary, image.grid));
        let pixels = image.bands.chunks_exact_mut(image.grid.bands());
        for (pixel, color) in pixels.zip(colors) {
            let mix = upsampling.mix(color);
            for (band, value) in pixel.iter_mut().enumerate() {
                *value =
                    (0..3).map(|primary| mix[primary] * spectra[primary][band]).sum::<f64>() as f32;
            }
        }
        (image, outside as f64 / (width * height).max(1) as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::D65_XY;

    #[test]
    fn spectra_have_the_colors() {
        let colors = [
            Xyz::from_xy(D65_XY, 250.0),
            Xyz::from_xy([0.6, 0.33], 3.0),
            Xyz::from_xy([0.17, 0.1], 0.5),
            Xyz::default(),
        ];
        let (image, paled) =
            SpectralImage::from_colors(4, 1, colors.into_iter(), Photometry::Absolute);
        assert_eq!(paled, 0.0);
        for (found, color) in image.to_xyz().pixels.iter().zip(colors) {
            // As near as the three spectra are to their primaries.
            let off = [found.x - color.x, found.y - color.y, found.z - color.z];
            assert!(off.iter().all(|off| off.abs() <= 1e-3 * color.y), "{found:?}, {color:?}");
        }
        // No mix is as red as a stop lamp.
        let red = std::iter::once(Xyz::from_xy([0.72, 0.28], 10.0));
        let (image, paled) = SpectralImage::from_colors(1, 1, red, Photometry::Absolute);
        assert_eq!(paled, 1.0);
        assert!((image.to_xyz().pixels[0].y - 10.0).abs() < 0.02, "its luminance stays");
    }
}
