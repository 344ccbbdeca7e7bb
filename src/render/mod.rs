//! Tiles, threads, samples a pixel; no physics.

mod film;
mod target;

use std::fmt;
use std::time::Instant;

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::image::SpectralImage;
use crate::scene::Prepared;
use crate::shading::{LightCheck, PathSegment, TraceCounts, TraceLimits, TraceState, Tracer};
use crate::spectrum::{Bands, WavelengthGrid};
use crate::view::{Camera, View};

use film::{Film, PixelStats};
pub use target::{Asked, MOST_SAMPLES, TargetReport, render_to_target};

/// What a user trades for speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quality {
    pub samples: Samples,
    pub limits: TraceLimits,
    pub grid: WavelengthGrid,
}

impl Default for Quality {
    fn default() -> Self {
        Self {
            samples: Samples::Fixed(4),
            limits: TraceLimits { max_depth: 8, min_throughput: 1e-3, light_error: 0.01 },
            grid: WavelengthGrid::Step5,
        }
    }
}

/// Camera rays a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Samples {
    Fixed(u32),
    /// From `min` on, until the standard error of the pixel's luminance relative to
    /// max(pixel, image mean) is below `error`, or `max` is reached.
    Adaptive {
        min: u32,
        max: u32,
        error: f64,
    },
    /// Until the estimated rms error of luminance over lit pixels, relative to each, is below
    /// `error`, or pixels that have `max` are too many for that; most where they help most.
    Lit {
        max: u32,
        error: f64,
    },
}

impl fmt::Display for Quality {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.samples {
            Samples::Fixed(count) => write!(f, "samples {count}")?,
            Samples::Adaptive { min, max, error } => {
                write!(f, "samples {min} to {max} for error {error}")?;
            }
            Samples::Lit { max, error } => {
                write!(f, "samples up to {max} for error {error} over lit pixels")?;
            }
        }
        let TraceLimits { max_depth, min_throughput, light_error } = self.limits;
        let step_nm = self.grid.step_nm();
        write!(
            f,
            ", max_depth {max_depth}, min_throughput {min_throughput}, light_error {light_error}, \
             wavelength_step {step_nm}"
        )
    }
}

/// Told of progress, and asked whether to go on; called from many threads.
pub trait Watch: Sync {
    fn pixels_done(&self, count: usize);
    fn is_cancelled(&self) -> bool;
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
struct Untold<'a>(&'a dyn Watch);

impl Watch for Untold<'_> {
    fn pixels_done(&self, _: usize) {}

    fn is_cancelled(&self) -> bool {
        self.0.is_cancelled()
    }
}

/// What a render did.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RenderStats {
    pub counts: TraceCounts,
    pub seconds: f64,
    /// Estimated error of the light sums: of the image's mean luminance, relative to it.
    pub light_error: f64,
    /// The largest of a pixel, relative to max(pixel, image mean).
    pub largest_light_error: f64,
    /// With [`Samples::Lit`]: the estimate that it is about.
    pub sampling_error: Option<f64>,
    /// With [`render_to_target`].
    pub target: Option<TargetReport>,
}

/// Small enough to share pixels evenly among threads, large enough that tasks cost nothing.
const PIXELS_A_TASK: usize = 64;

/// The view's spectral radiance: same inputs, same bits, for any number of threads.
///
/// Errors: a light without luminous flux on the grid; [`Error::Interrupted`]; a radiance that is
/// not finite, with its pixel.
pub fn render(
    prepared: &Prepared,
    view: &View,
    quality: &Quality,
    watch: &dyn Watch,
) -> Result<(SpectralImage, RenderStats)> {
    let start = Instant::now();
    let tables = prepared.tables(quality.grid)?;
    let mut film = Film::new(view, quality.grid.bands());
    let renderer = Renderer {
        tracer: Tracer { prepared, tables, limits: quality.limits },
        camera: view.camera(),
        width: view.width,
        watch,
    };
    let counts = renderer.take(&mut film, quality.samples)?;
    let mean = film.mean_luminance();
    let light_error = film.mean(|pixel| pixel.light_error / f64::from(pixel.count));
    let relative =
        |pixel: &PixelStats| pixel.light_error / f64::from(pixel.count) / pixel.mean.max(mean);
    let stats = RenderStats {
        counts,
        seconds: start.elapsed().as_secs_f64(),
        light_error: if mean > 0.0 { light_error / mean } else { 0.0 },
        largest_light_error: film.pixels.iter().map(relative).fold(0.0, f64::max),
        sampling_error: matches!(quality.samples, Samples::Lit { .. }).then(|| film.lit_error()),
        target: None,
    };
    Ok((film.into_image(view, quality, prepared.scene.photometry), stats))
}

/// Compares the light sums of `hits` hits of a view, drawn evenly, with the exact ones.
///
/// Same inputs, same hits. `None` if no light arrives at any of them. Errors: as [`render`].
pub fn check_light_error(
    prepared: &Prepared,
    view: &View,
    quality: &Quality,
    hits: usize,
) -> Result<Option<LightCheck>> {
    /// Camera rays tried for each hit, before the view is taken for empty.
    const TRIES: usize = 100;
    let tables = prepared.tables(quality.grid)?;
    let tracer = Tracer { prepared, tables, limits: quality.limits };
    let camera = view.camera();
    let rays = (0..(hits * TRIES) as u32).map(|i| {
        let [x, y] = sample_place(i);
        camera.ray(x * view.width as f64, y * view.height as f64)
    });
    Ok(tracer.check_light(rays, hits))
}

/// The rays that are followed for image position (x, y), in pixels from the top left corner.
///
/// Errors: as [`render`].
pub fn trace_paths(
    prepared: &Prepared,
    view: &View,
    quality: &Quality,
    [x, y]: [f64; 2],
) -> Result<Vec<PathSegment>> {
    let tables = prepared.tables(quality.grid)?;
    let tracer = Tracer { prepared, tables, limits: quality.limits };
    Ok(tracer.paths(view.camera().ray(x, y)))
}

#[derive(Clone, Copy)]
struct Renderer<'a> {
    tracer: Tracer<'a>,
    camera: Camera,
    width: usize,
    watch: &'a dyn Watch,
}

impl Renderer<'_> {
    fn take(&self, film: &mut Film, samples: Samples) -> Result<TraceCounts> {
        match samples {
            Samples::Fixed(count) => self.sample_until(film, |pixel| pixel.count >= count),
            Samples::Adaptive { min, max, error } => {
                let counts = self.sample_until(film, |pixel| pixel.count >= min)?;
                let image_mean = film.mean_luminance();
                let more = self.sample_until(film, |pixel| {
                    pixel.count >= max || pixel.relative_error(image_mean) <= error
                })?;
                Ok(counts + more)
            }
            Samples::Lit { max, error } => self.sample_lit(film, max, error),
        }
    }

    /// Rounds of at most twice as many samples, planned by what is known of each pixel.
    fn sample_lit(&self, film: &mut Film, max: u32, error: f64) -> Result<TraceCounts> {
        const FIRST: u32 = 60;
        let untold = Renderer { watch: &Untold(self.watch), ..*self };
        let mut counts = untold.sample_until(film, |pixel| pixel.count >= FIRST.min(max))?;
        let mut told = 0;
        loop {
            let excess = film.lit_error() / error;
            let is_hopeless = film.lit_error_of(|pixel| pixel.count >= max) > error;
            // Evenly spread samples at edges: the error falls as count^−¾ (measured).
            let growth = excess.powf(4.0 / 3.0).max(1.0);
            let goes_on = excess > 1.0 && !is_hopeless && film.plan(growth.clamp(1.2, 2.0), max);
            let share = if goes_on { growth.recip() } else { 1.0 };
            let done = ((film.pixels.len() as f64 * share) as usize).max(told);
            self.watch.pixels_done(done - told);
            told = done;
            if !goes_on {
                return Ok(counts);
            }
            counts = counts + untold.sample_until(film, |pixel| pixel.count >= pixel.planned)?;
        }
    }

    /// Adds samples to every pixel until it is `enough`.
    fn sample_until(
        &self,
        film: &mut Film,
        enough: impl Fn(&PixelStats) -> bool + Sync,
    ) -> Result<TraceCounts> {
        let bands = film.bands;
        let tasks = film
            .spectra
            .par_chunks_mut(PIXELS_A_TASK * bands)
            .zip(film.pixels.par_chunks_mut(PIXELS_A_TASK))
            .enumerate();
        let counts = tasks.map(|(task, (spectra, pixels))| {
            let mut state = TraceState::default();
            let places = (task * PIXELS_A_TASK..).zip(spectra.chunks_mut(bands)).zip(&mut *pixels);
            for ((pixel, spectrum), stats) in places {
                if self.watch.is_cancelled() {
                    return Err(Error::Interrupted);
                }
                self.sample_pixel(pixel, spectrum, stats, &enough, &mut state)?;
            }
            self.watch.pixels_done(pixels.len());
            Ok(state.counts)
        });
        counts.try_reduce(TraceCounts::default, |a, b| Ok(a + b))
    }

    fn sample_pixel(
        &self,
        pixel: usize,
        spectrum: &mut [f32],
        stats: &mut PixelStats,
        enough: &impl Fn(&PixelStats) -> bool,
        state: &mut TraceState,
    ) -> Result<()> {
        if enough(stats) {
            return Ok(());
        }
        let (x, y) = (pixel % self.width, pixel / self.width);
        let mut sum = Bands::zero(spectrum.len());
        for (sum, mean) in sum.as_mut_slice().iter_mut().zip(&*spectrum) {
            *sum = f64::from(*mean) * f64::from(stats.count);
        }
        while !enough(stats) {
            let [dx, dy] = sample_place(stats.count);
            let ray = self.camera.ray(x as f64 + dx, y as f64 + dy);
            let mut sample = Bands::zero(spectrum.len());
            state.light_error = 0.0;
            self.tracer.trace(ray, state, &mut sample);
            let luminance = sample.dot(&self.tracer.tables.luminance_weights);
            stats.add(luminance, state.light_error);
            sum.add(&sample);
        }
        for (mean, sum) in spectrum.iter_mut().zip(sum.as_slice()) {
            *mean = (sum / f64::from(stats.count)) as f32;
            if !mean.is_finite() {
                return Err(Error::inconsistent(
                    "render",
                    format!("radiance of pixel ({x}, {y}) is {mean} after sample {}", stats.count),
                ));
            }
        }
        Ok(())
    }
}

/// Where in the unit square the i-th sample lies: the additive recurrence of the plastic number,
/// evenly spread for every count, begun at the pixel's center.
fn sample_place(i: u32) -> [f64; 2] {
    const PLASTIC: f64 = 1.324_717_957_244_746;
    [1.0 / PLASTIC, 1.0 / (PLASTIC * PLASTIC)].map(|step| (0.5 + f64::from(i) * step).fract())
}
