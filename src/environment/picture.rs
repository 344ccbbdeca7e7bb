//! Latitude–longitude pictures.

use super::dome::Luminances;
use super::patch::Cells;
use crate::color::Xyz;
use crate::color::upsampling::Upsampling;
use crate::error::{Error, Result};

/// A picture of all directions: row 0 is straight up, the middle column −Z, right of it +X.
///
/// Between the pixels' centers it is bilinear, around the seam and over the poles, too.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    width: usize,
    height: usize,
    /// Luminances of its spectra, row by row.
    pixels: Vec<[f32; 3]>,
}

impl Picture {
    /// Errors: a size that `pixels` does not fill, a pixel that is not finite or below 0.
    pub fn new(width: usize, height: usize, pixels: Vec<[f32; 3]>) -> Result<Picture> {
        if width == 0 || height == 0 || pixels.len() != width * height {
            let count = pixels.len();
            let problem = format!("{width} × {height} pixels cannot be filled from {count}");
            return Err(Error::inconsistent("environment", problem));
        }
        let is_bad = |pixel: &[f32; 3]| pixel.iter().any(|v| !(v.is_finite() && *v >= 0.0));
        if let Some(at) = pixels.iter().position(is_bad) {
            let what = format!("pixel ({}, {})", at % width, at / width);
            let found = format!("{:?}", pixels[at]);
            return Err(Error::out_of_range("environment", &what, found, "finite, 0 or more"));
        }
        Ok(Picture { width, height, pixels })
    }

    /// Colors (XYZ) as a mix of three spectra: those of Rec. 709 where all colors lie in there, else
    /// P3's. The third is the share of pixels that were outside of both and had to be paled.
    ///
    /// Errors: as [`Picture::new`].
    pub fn from_colors(
        width: usize,
        height: usize,
        colors: impl Iterator<Item = Xyz> + Clone,
    ) -> Result<(Picture, &'static Upsampling, f64)> {
        let (upsampling, outside) = Upsampling::holding(colors.clone());
        let pixels = colors.map(|color| upsampling.mix(color).map(|value| value as f32));
        let picture = Picture::new(width, height, pixels.collect())?;
        Ok((picture, upsampling, outside as f64 / (width * height) as f64))
    }

    /// Pixels around the horizon.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Pixels from zenith to nadir.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Luminances by primary, cd/m², row by row from the zenith.
    pub fn pixels(&self) -> &[[f32; 3]] {
        &self.pixels
    }

    pub(super) fn luminances(&self, [u, v]: [f64; 2]) -> Luminances {
        let (x, y) = (u * self.width as f64 - 0.5, v * self.height as f64 - 0.5);
        let (column, row) = (x.floor(), y.floor());
        let (fx, fy) = (x - column, y - row);
        let mut sum = [0.0; 3];
        for (dy, wy) in [(0, 1.0 - fy), (1, fy)] {
            for (dx, wx) in [(0, 1.0 - fx), (1, fx)] {
                let pixel = self.pixel(column as i64 + dx, row as i64 + dy);
                for (sum, value) in sum.iter_mut().zip(pixel) {
                    *sum += wx * wy * f64::from(value);
                }
            }
        }
        sum
    }

    /// Beyond a pole the picture goes on at the opposite longitude.
    fn pixel(&self, column: i64, row: i64) -> [f32; 3] {
        let (width, height) = (self.width as i64, self.height as i64);
        let (column, row) = match row {
            row if row < 0 => (column + width / 2, -1 - row),
            row if row >= height => (column + width / 2, 2 * height - 1 - row),
            row => (column, row),
        };
        let row = row.clamp(0, height - 1);
        self.pixels[(row * width + column.rem_euclid(width)) as usize]
    }

    /// Whole fractions of its pixels, of at most a degree. Even ones where a pixel is cut: the
    /// picture bends at the pixels' centers, and is bilinear over a quarter of a cell. A picture of
    /// more than 4096 columns has cells of two pixels each way.
    pub(super) fn cells(&self) -> Cells {
        const MOST: usize = 4096;
        let fine = |count: usize, least: usize| match least.div_ceil(count) {
            1 if self.width > MOST => count.div_ceil(2),
            1 => count,
            cuts => count * cuts.next_multiple_of(2),
        };
        Cells { columns: fine(self.width, 360), rows: fine(self.height, 180) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(width: usize, height: usize) -> Picture {
        let pixels = (0..width * height).map(|i| [i as f32, 0.0, 1.0]).collect();
        Picture::new(width, height, pixels).unwrap()
    }

    #[test]
    fn centers_see_their_pixel_and_borders_the_mean() {
        let picture = ramp(4, 2);
        assert_eq!(picture.luminances([0.375, 0.25]), [1.0, 0.0, 1.0]);
        assert_eq!(picture.luminances([0.5, 0.25])[0], 1.5);
        assert_eq!(picture.luminances([0.0, 0.25])[0], 1.5, "around the seam");
        assert_eq!(picture.luminances([0.125, 0.0])[0], 1.0, "over the pole: columns 0 and 2");
        assert_eq!(picture.luminances([0.125, 1.0])[0], 5.0);
    }

    #[test]
    fn small_pictures_are_cut() {
        assert_eq!(ramp(2, 1).cells(), Cells { columns: 360, rows: 180 });
        assert_eq!(ramp(100, 50).cells(), Cells { columns: 400, rows: 200 });
        assert_eq!(ramp(360, 181).cells(), Cells { columns: 360, rows: 181 });
    }

    #[test]
    fn faults_are_named() {
        let problem = |pixels| Picture::new(2, 1, pixels).unwrap_err().to_string();
        assert_eq!(problem(vec![[0.0; 3]]), "environment: 2 × 1 pixels cannot be filled from 1");
        assert_eq!(
            problem(vec![[0.0; 3], [f32::NAN, 0.0, 0.0]]),
            "environment: pixel (1, 0) is [NaN, 0.0, 0.0], allowed: finite, 0 or more"
        );
    }
}
