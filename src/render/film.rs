//! The picture while it is taken: each pixel's mean spectrum and its luminance statistics.

use super::plan::Quarters;
use super::{Quality, Samples};
use crate::color::Photometry;
use crate::image::difference::lit_luminance;
use crate::image::{Metadata, SpectralImage};
use crate::view::View;

/// Luminance statistics of a pixel's samples (Welford's recurrence).
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct PixelStats {
    pub count: u32,
    pub mean: f64,
    /// Σ (Y − mean)².
    squares: f64,
    /// Σ of the errors that light sums are estimated to leave in the samples' luminances.
    pub light_luminance_error: f64,
    /// What tells the mean's error, where that is asked.
    pub quarters: Quarters,
}

impl PixelStats {
    pub fn add(&mut self, luminance: f64, light_luminance_error: f64) {
        self.quarters.add(self.count, luminance);
        self.count += 1;
        let before = luminance - self.mean;
        self.mean += before / f64::from(self.count);
        self.squares += before * (luminance - self.mean);
        self.light_luminance_error += light_luminance_error;
    }

    /// Standard error of the mean, relative to max(pixel, image mean); infinite for one sample.
    pub fn relative_error(&self, image_mean: f64) -> f64 {
        let n = f64::from(self.count);
        let scale = self.mean.max(image_mean);
        if self.count < 2 {
            f64::INFINITY
        } else if scale == 0.0 {
            0.0
        } else {
            (self.squares / (n - 1.0)).sqrt() / n.sqrt() / scale
        }
    }
}

/// Each pixel's mean spectrum, and its statistics.
pub(super) struct Film {
    pub width: usize,
    pub bands: usize,
    pub spectra: Vec<f32>,
    pub pixels: Vec<PixelStats>,
    /// Seconds that the picture was first thought to take, where its samples follow from an error.
    pub expected_seconds: Option<f64>,
}

impl Film {
    pub fn new(view: &View, bands: usize) -> Self {
        let pixels = view.pixels();
        Self {
            width: view.width,
            bands,
            spectra: vec![0.0; pixels * bands],
            pixels: vec![PixelStats::default(); pixels],
            expected_seconds: None,
        }
    }

    pub fn mean(&self, value: impl Fn(&PixelStats) -> f64) -> f64 {
        self.pixels.iter().map(value).sum::<f64>() / self.pixels.len() as f64
    }

    pub fn mean_luminance(&self) -> f64 {
        self.mean(|pixel| pixel.mean)
    }

    /// Luminance from which on a pixel counts as lit.
    pub fn lit_luminance(&self) -> f64 {
        lit_luminance(self.pixels.iter().map(|pixel| pixel.mean).collect())
    }

    pub fn into_image(
        self,
        view: &View,
        quality: &Quality,
        photometry: Photometry,
    ) -> SpectralImage {
        let (error, samples) = match quality.samples {
            Samples::Fixed(_) => (None, None),
            Samples::Adaptive { .. } | Samples::Lit { .. } => {
                let image_mean = self.mean_luminance();
                let error = |pixel: &PixelStats| pixel.relative_error(image_mean) as f32;
                let samples = |pixel: &PixelStats| pixel.count as f32;
                (
                    Some(self.pixels.iter().map(error).collect()),
                    Some(self.pixels.iter().map(samples).collect()),
                )
            }
        };
        SpectralImage {
            width: view.width,
            height: view.height,
            grid: quality.grid,
            bands: self.spectra,
            photometry,
            error,
            samples,
            view: Some(*view),
            metadata: metadata(view, quality),
        }
    }
}

/// View, quality and program version, for the image's file.
fn metadata(view: &View, quality: &Quality) -> Metadata {
    [
        ("view", view.to_string()),
        ("quality", quality.to_string()),
        ("version", format!("lampyris {}", env!("CARGO_PKG_VERSION"))),
    ]
    .map(|(key, value)| (key.to_owned(), value))
    .into()
}
