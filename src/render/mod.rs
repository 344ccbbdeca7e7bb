//! Tiles, threads, samples a pixel; no physics.
//!
//! [`render`] takes a picture as a [`Quality`] says, [`render_to_target`] chooses the quality for an
//! error, and [`Asked`] is either. [`check_light_error`] and [`trace_paths`] look into a picture,
//! [`why_black`] says what is wrong with one that has no light.

mod asked;
mod black;
mod film;
mod inspect;
mod pattern;
mod plan;
mod quality;
mod sampler;
mod target;

use std::time::Instant;

use crate::error::Result;
use crate::image::SpectralImage;
use crate::scene::Prepared;
use crate::shading::{TraceCounts, Tracer};
use crate::view::View;

pub use asked::Asked;
pub use black::why_black;
use film::{Film, PixelStats};
pub use inspect::{check_light_error, mean_spectrum, trace_paths};
pub use quality::{Quality, Samples};
use sampler::Sampler;
pub use target::{MOST_SAMPLES, TargetReport, render_to_target};

/// Told of progress, and asked whether to go on; called from many threads.
pub trait Watch: Sync {
    /// Called when `count` further pixels are done.
    fn pixels_done(&self, count: usize);
    /// Whether to stop: the render then ends with [`crate::error::Error::Interrupted`].
    fn is_cancelled(&self) -> bool;
    /// Called with the time that the picture will still take, as far as can be told: only where its
    /// samples follow from an error.
    fn expects(&self, _seconds: f64) {}
}

/// Watches nothing.
#[derive(Debug, Clone, Copy)]
pub struct Unwatched;

impl Watch for Unwatched {
    fn pixels_done(&self, _: usize) {}

    fn is_cancelled(&self) -> bool {
        false
    }
}

/// Asks whether to go on, and tells nothing.
pub struct Untold<'a>(pub &'a dyn Watch);

impl Watch for Untold<'_> {
    fn pixels_done(&self, _: usize) {}

    fn is_cancelled(&self) -> bool {
        self.0.is_cancelled()
    }
}

/// What a render did.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RenderStats {
    /// Rays traced, and lights asked.
    pub counts: TraceCounts,
    /// Time of rendering, s.
    pub seconds: f64,
    /// Estimated error that the light sums leave in the image's mean luminance, relative to it.
    pub mean_light_error: f64,
    /// Largest error that the light sums are estimated to leave in a pixel, relative to
    /// max(pixel, image mean).
    pub largest_light_error: f64,
    /// Estimated rms error of luminance over lit pixels, relative to each: with [`Samples::Lit`].
    pub sampling_error: Option<f64>,
    /// Time that the picture was thought to take when its first samples were there, s: with
    /// [`Samples::Lit`].
    pub expected_seconds: Option<f64>,
    /// Relative error of the light that bounces, from the number of its samples.
    pub interreflection_error: Option<f64>,
    /// What was chosen, and the errors estimated: with [`render_to_target`].
    pub target: Option<TargetReport>,
}

/// Takes the picture of a view, its spectral radiance: same inputs, same bits, for any number of threads.
///
/// Errors: a light without luminous flux on the grid; [`crate::error::Error::Interrupted`]; a radiance that is
/// not finite, with its pixel.
pub fn render(
    prepared: &Prepared,
    view: &View,
    quality: &Quality,
    watch: &dyn Watch,
) -> Result<(SpectralImage, RenderStats)> {
    let start = Instant::now();
    let tables = prepared.tables(quality.grid)?;
    let layers = quality.layers.names(prepared);
    let mut film = Film::new(view, quality.grid.bands(), layers.len());
    let sampler = Sampler {
        tracer: Tracer { prepared, tables, limits: quality.limits },
        camera: view.camera(),
        width: view.width,
        set_size: match quality.samples {
            Samples::Fixed(count) => Some(count),
            Samples::Adaptive { .. } | Samples::Lit { .. } => None,
        },
        layers: quality.layers,
        watch,
    };
    let counts = sampler.take(&mut film, quality.samples)?;
    let mean = film.mean_luminance();
    let light_error = film.mean(|pixel| pixel.light_luminance_error / f64::from(pixel.count));
    let relative = |pixel: &PixelStats| {
        pixel.light_luminance_error / f64::from(pixel.count) / pixel.mean.max(mean)
    };
    let stats = RenderStats {
        counts,
        seconds: start.elapsed().as_secs_f64(),
        mean_light_error: if mean > 0.0 { light_error / mean } else { 0.0 },
        largest_light_error: film.pixels.iter().map(relative).fold(0.0, f64::max),
        sampling_error: matches!(quality.samples, Samples::Lit { .. }).then(|| film.lit_error()),
        expected_seconds: film.expected_seconds,
        interreflection_error: prepared.interreflection.and_then(|report| report.relative_error),
        target: None,
    };
    Ok((film.into_image(view, quality, (layers, prepared.scene.photometry)), stats))
}
