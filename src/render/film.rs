//! The picture while it is taken: each pixel's mean spectrum and its luminance statistics.

use super::plan::Quarters;
use super::{Quality, Samples};
use crate::color::Photometry;
use crate::image::difference::lit_luminance;
use crate::image::{Layer, Metadata, SpectralImage};
use crate::view::View;

/// Luminance statistics of a pixel's samples (Welford's recurrence).
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct PixelStats {
    pub count: u32,
    pub mean: f64,
    /// Σ (Y − mean)².
    squares: f64,
    /// Rays and light sums that the samples took.
    pub steps: u64,
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
    /// Layers of each pixel.
    pub parts: usize,
    /// For each pixel the mean spectrum, then those of its layers.
    pub spectra: Vec<f32>,
    pub pixels: Vec<PixelStats>,
    /// Seconds that the picture was first thought to take, where its samples follow from an error.
    pub expected_seconds: Option<f64>,
}

impl Film {
    pub fn new(view: &View, bands: usize, parts: usize) -> Self {
        let pixels = view.pixels();
        Self {
            width: view.width,
            bands,
            parts,
            spectra: vec![0.0; pixels * bands * (1 + parts)],
            pixels: vec![PixelStats::default(); pixels],
            expected_seconds: None,
        }
    }

    /// Values a pixel.
    pub fn stride(&self) -> usize {
        self.bands * (1 + self.parts)
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

    /// Spectra of all pixels: 0 the whole, then the layers.
    fn part(&self, part: usize) -> Vec<f32> {
        let place = part * self.bands..(part + 1) * self.bands;
        let pixels = self.spectra.chunks_exact(self.stride());
        pixels.flat_map(|pixel| &pixel[place.clone()]).copied().collect()
    }

    pub fn into_image(
        self,
        view: &View,
        quality: &Quality,
        (names, photometry): (Vec<String>, Photometry),
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
        let layers = (1..).zip(names).map(|(part, name)| Layer { name, bands: self.part(part) });
        let layers = layers.collect();
        SpectralImage {
            width: view.width,
            height: view.height,
            grid: quality.grid,
            bands: if self.parts == 0 { self.spectra } else { self.part(0) },
            layers,
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
