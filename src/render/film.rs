//! The picture while it is taken: each pixel's mean spectrum and its luminance statistics.

use super::{Quality, Samples};
use crate::color::Photometry;
use crate::image::difference::lit_luminance;
use crate::image::{Metadata, SpectralImage};
use crate::view::View;

/// Every sixth sample is of a group: each of the six is as evenly spread as all together (those of
/// 4, 7 and 8 groups would line up), so that their means tell how far the mean is off.
const GROUPS: usize = 6;

/// Luminance statistics of a pixel's samples (Welford's recurrence).
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct PixelStats {
    pub count: u32,
    /// What [`Film::plan`] asks for.
    pub planned: u32,
    pub mean: f64,
    /// Σ (Y − mean)².
    squares: f64,
    groups: [f64; GROUPS],
    /// Σ of the errors that light sums are estimated to leave in the samples' luminances.
    pub light_luminance_error: f64,
}

impl PixelStats {
    pub fn add(&mut self, luminance: f64, light_luminance_error: f64) {
        self.groups[self.count as usize % GROUPS] += luminance;
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
            self.deviation() / n.sqrt() / scale
        }
    }

    /// Standard deviation of the samples.
    fn deviation(&self) -> f64 {
        (self.squares / (f64::from(self.count) - 1.0)).sqrt()
    }

    /// Square of the mean's error, from how the groups differ.
    ///
    /// Evenly spread samples are closer than their deviation tells; the groups are spread as
    /// evenly, only coarser, so that this errs to the safe side by less.
    fn squared_error(&self) -> f64 {
        let squares: f64 = self.group_means().map(|mean| (mean - self.mean).powi(2)).sum();
        squares / (GROUPS * (GROUPS - 1)) as f64
    }

    /// What errors are relative to: the mean without its brightest group, or `lit`.
    ///
    /// A rare highlight that one sample has met by chance would otherwise excuse itself.
    fn scale(&self, lit: f64) -> f64 {
        let (sum, most) = self
            .group_means()
            .fold((0.0, 0.0f64), |(sum, most), mean| (sum + mean, most.max(mean)));
        ((sum - most) / (GROUPS - 1) as f64).max(lit)
    }

    fn group_means(&self) -> impl Iterator<Item = f64> {
        let of_group = |(group, sum): (usize, &f64)| {
            let count = (self.count as usize + GROUPS - 1 - group) / GROUPS;
            sum / count as f64
        };
        self.groups.iter().enumerate().map(of_group)
    }
}

/// Each pixel's mean spectrum, and its statistics.
pub(super) struct Film {
    width: usize,
    pub bands: usize,
    pub spectra: Vec<f32>,
    pub pixels: Vec<PixelStats>,
}

impl Film {
    pub fn new(view: &View, bands: usize) -> Self {
        let pixels = view.pixels();
        Self {
            width: view.width,
            bands,
            spectra: vec![0.0; pixels * bands],
            pixels: vec![PixelStats::default(); pixels],
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

    /// Estimated rms error of luminance over lit pixels, relative to each.
    pub fn lit_error(&self) -> f64 {
        self.lit_error_of(|_| true)
    }

    /// The same, with no error at pixels but these.
    pub fn lit_error_of(&self, is_meant: impl Fn(&PixelStats) -> bool) -> f64 {
        let lit = self.lit_luminance();
        let is_lit = |pixel: &&PixelStats| pixel.mean > 0.0 && pixel.mean >= lit;
        let relative = |pixel: &PixelStats| pixel.squared_error() / pixel.scale(lit).powi(2);
        let all_lit = self.pixels.iter().filter(is_lit);
        let squares: f64 = all_lit.clone().filter(|pixel| is_meant(pixel)).map(relative).sum();
        (squares / all_lit.count().max(1) as f64).sqrt()
    }

    /// Plans `growth` times as many samples as there are, each pixel's in proportion to their
    /// deviation relative to its luminance: so a given number makes the rms error least.
    ///
    /// A pixel may have a highlight that no sample has met, and the more likely the more its
    /// neighbors need: none has less than a share of the mean, and of any neighbor's. Pixels that
    /// have `most` are left out. Whether any pixel has more to come.
    pub fn plan(&mut self, growth: f64, most: u32) -> bool {
        const LEAST_OF_MEAN: f64 = 0.25;
        const LEAST_OF_NEIGHBOR: f64 = 0.25;
        let lit = self.lit_luminance();
        let is_open = |pixel: &&PixelStats| pixel.count < most;
        let weight = |pixel: &PixelStats| pixel.deviation() / pixel.scale(lit);
        let open = || self.pixels.iter().filter(is_open);
        let samples = growth * open().map(|pixel| f64::from(pixel.count)).sum::<f64>();
        let weights: f64 = open().map(weight).sum();
        let least = LEAST_OF_MEAN * samples / open().count() as f64;
        // Where no weight is above 0, the quotient is NaN, and `max` passes it over.
        let share = |pixel: &PixelStats| (samples * weight(pixel) / weights).max(least);
        let shares: Vec<f64> = self.pixels.iter().map(share).collect();
        for at in 0..self.pixels.len() {
            let around = self.around(at).map(|other| LEAST_OF_NEIGHBOR * shares[other]);
            let wanted = around.fold(shares[at], f64::max).ceil() as u32;
            let pixel = &mut self.pixels[at];
            pixel.planned = wanted.clamp(pixel.count.min(most), most);
        }
        self.pixels.iter().any(|pixel| pixel.planned > pixel.count)
    }

    /// A pixel and those that touch it.
    fn around(&self, at: usize) -> impl Iterator<Item = usize> + use<> {
        let (width, height) = (self.width, self.pixels.len() / self.width);
        let (x, y) = (at % width, at / width);
        let rows = y.saturating_sub(1)..(y + 2).min(height);
        let columns = x.saturating_sub(1)..(x + 2).min(width);
        rows.flat_map(move |row| columns.clone().map(move |column| row * width + column))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::DVec3;

    fn film(width: usize, height: usize) -> Film {
        let view = View {
            azimuth_deg: 0.0,
            elevation_deg: 0.0,
            distance_mm: 1.0,
            target: DVec3::ZERO,
            fov_deg: 1.0,
            width,
            height,
        };
        Film::new(&view, 1)
    }

    fn add(pixel: &mut PixelStats, luminances: impl IntoIterator<Item = f64>) {
        luminances.into_iter().for_each(|luminance| pixel.add(luminance, 0.0));
    }

    #[test]
    fn error_is_that_of_the_mean_of_six_groups() {
        let mut film = film(1, 1);
        // Groups of 10 equal samples each, of means 1 to 6: variance 3.5, brightest 6.
        add(&mut film.pixels[0], (0..60).map(|i| f64::from(i % 6 + 1)));
        let expected = (3.5f64 / 6.0).sqrt() / 3.0;
        assert!((film.lit_error() / expected - 1.0).abs() < 1e-12, "{}", film.lit_error());
    }

    #[test]
    fn dark_pixels_do_not_count() {
        let mut film = film(2, 1);
        add(&mut film.pixels[0], [1.0; 12]);
        add(&mut film.pixels[1], (0..12).map(|i| 1e-3 * f64::from(i)));
        assert_eq!(film.lit_error(), 0.0);
    }

    #[test]
    fn samples_go_where_they_help() {
        let mut film = film(9, 1);
        for (at, pixel) in film.pixels.iter_mut().enumerate() {
            let spread = if at == 0 { 0.5 } else { 0.01 };
            add(pixel, (0..60).map(|i| 1.0 + spread * f64::from(i % 2)));
        }
        assert!(film.plan(2.0, 100_000));
        let planned: Vec<u32> = film.pixels.iter().map(|pixel| pixel.planned).collect();
        assert!(planned[0] > 600, "{planned:?}");
        assert!(planned[1] > planned[0] / 5, "a neighbor has some, too: {planned:?}");
        assert_eq!(planned[2..], [60; 7], "none is taken away");
        assert!(film.plan(2.0, 100));
        assert_eq!(film.pixels[0].planned, 100);
        assert!(!film.plan(2.0, 60), "all have as many");
    }
}
