//! Camera rays of all pixels, tile by tile on all threads, until each pixel has enough.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use rayon::prelude::*;

use super::film::{Film, PixelStats};
use super::pattern::Pattern;
use super::{Samples, Untold, Watch};
use crate::error::{Error, Result};
use crate::shading::{LayeredSum, Layers, TraceCounts, TraceState, Tracer};
use crate::spectrum::Bands;
use crate::view::Camera;

/// Small enough to share pixels evenly among threads, large enough that tasks cost nothing.
const PIXELS_A_TASK: usize = 64;

/// Takes the samples of a picture.
#[derive(Clone, Copy)]
pub(super) struct Sampler<'a> {
    pub tracer: Tracer<'a>,
    pub camera: Camera,
    /// Pixels of a row.
    pub width: usize,
    /// Samples of each pixel, if that is known beforehand.
    pub set_size: Option<u32>,
    pub layers: Layers,
    pub watch: &'a dyn Watch,
}

/// Tells a round's part of the picture while the round goes on, evenly over its pixels.
struct Round<'a> {
    watch: &'a dyn Watch,
    pixels: usize,
    /// Pixels that count as done before the round, and after it.
    span: [usize; 2],
    seen: AtomicUsize,
    told: AtomicUsize,
}

impl<'a> Round<'a> {
    fn new(watch: &'a dyn Watch, pixels: usize, after: usize, told: usize) -> Self {
        let span = [told, after.max(told)];
        Self { watch, pixels, span, seen: AtomicUsize::new(0), told: AtomicUsize::new(told) }
    }
}

impl Watch for Round<'_> {
    fn pixels_done(&self, count: usize) {
        let seen = self.seen.fetch_add(count, Ordering::Relaxed) + count;
        let [before, after] = self.span;
        let due = before + (after - before) * seen / self.pixels;
        let told = self.told.fetch_max(due, Ordering::Relaxed);
        self.watch.pixels_done(due.saturating_sub(told));
    }

    fn is_cancelled(&self) -> bool {
        self.watch.is_cancelled()
    }
}

impl Sampler<'_> {
    /// Adds to `film` what `samples` ask for.
    ///
    /// Errors: [`Error::Interrupted`]; a radiance that is not finite.
    pub fn take(&self, film: &mut Film, samples: Samples) -> Result<TraceCounts> {
        match samples {
            Samples::Fixed(count) => self.sample_until(film, |pixel| pixel.count >= count),
            Samples::Adaptive { min, max, error } => {
                // Pixels are told once: when they are done.
                let untold = Sampler { watch: &Untold(self.watch), ..*self };
                let counts = untold.sample_until(film, |pixel| pixel.count >= min)?;
                let image_mean = film.mean_luminance();
                let more = self.sample_until(film, |pixel| {
                    pixel.count >= max || pixel.relative_error(image_mean) <= error
                })?;
                Ok(counts + more)
            }
            Samples::Lit { max, error } => self.sample_lit(film, max, error),
        }
    }

    /// Rounds that double the samples of those pixels where that helps most.
    fn sample_lit(&self, film: &mut Film, max: u32, error: f64) -> Result<TraceCounts> {
        let start = Instant::now();
        let mut counts = TraceCounts::default();
        let (mut told, mut share_after) = (0, 0.0);
        film.plan_first(error, max);
        loop {
            let pixels = film.pixels.len();
            let round =
                Round::new(self.watch, pixels, (pixels as f64 * share_after) as usize, told);
            let of_round = Sampler { watch: &round, ..*self };
            counts = counts
                + of_round.sample_until(film, |pixel| pixel.quarters.is_full(pixel.count))?;
            told = round.told.into_inner();
            let outlook = film.plan(error, max);
            let share = film.steps() / outlook.steps;
            share_after = (share + film.steps_to_come() / outlook.steps).min(1.0);
            let spent_seconds = start.elapsed().as_secs_f64();
            film.expected_seconds.get_or_insert(spent_seconds / share);
            self.watch.expects(spent_seconds * (share.recip() - 1.0));
            let share = if outlook.goes_on { share.min(1.0) } else { 1.0 };
            let done = ((film.pixels.len() as f64 * share) as usize).max(told);
            self.watch.pixels_done(done - told);
            told = done;
            if !outlook.goes_on {
                return Ok(counts);
            }
        }
    }

    /// Adds samples to every pixel until it is `enough`.
    fn sample_until(
        &self,
        film: &mut Film,
        enough: impl Fn(&PixelStats) -> bool + Sync,
    ) -> Result<TraceCounts> {
        let stride = film.stride();
        let tasks = film
            .spectra
            .par_chunks_mut(PIXELS_A_TASK * stride)
            .zip(film.pixels.par_chunks_mut(PIXELS_A_TASK))
            .enumerate();
        let counts = tasks.map(|(task, (spectra, pixels))| {
            let mut state = TraceState::default();
            let places = (task * PIXELS_A_TASK..).zip(spectra.chunks_mut(stride)).zip(&mut *pixels);
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
        let bands = self.tracer.tables.bands;
        let mut sums = spectrum.chunks(bands).map(|mean| sum_of(mean, stats.count));
        let mut sum = sums.next().unwrap_or_else(|| Bands::zero(bands));
        // Without layers there are none, and nothing is allocated.
        let mut parts: Vec<Bands> = sums.collect();
        let pattern = Pattern::of_pixel(x, y);
        let set = self.set_size.map(|count| pattern.set(count)).unwrap_or_default();
        let steps_before = state.counts.steps();
        while !enough(stats) {
            let in_set = set.get(stats.count as usize).copied();
            let [dx, dy] = in_set.unwrap_or_else(|| pattern.place(stats.count));
            let ray = self.camera.ray(x as f64 + dx, y as f64 + dy);
            let mut sample = Bands::zero(bands);
            state.luminance_error = 0.0;
            let layers = self.layers;
            let mut layered = LayeredSum { whole: &mut sample, parts: &mut parts, layers };
            self.tracer.trace_layers(ray, state, &mut layered);
            let luminance = sample.dot(&self.tracer.tables.luminance_weights);
            stats.add(luminance, state.luminance_error);
            sum.add(&sample);
        }
        stats.steps += state.counts.steps() - steps_before;
        let sums = sum.as_slice().iter().chain(parts.iter().flat_map(Bands::as_slice));
        for (mean, sum) in spectrum.iter_mut().zip(sums) {
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

/// Σ of as many samples as have made this mean.
///
/// Memory that nothing was written to is not read: the kernel would map it twice.
fn sum_of(mean: &[f32], count: u32) -> Bands {
    let mut sum = Bands::zero(mean.len());
    if count == 0 {
        return sum;
    }
    for (sum, mean) in sum.as_mut_slice().iter_mut().zip(mean) {
        *sum = f64::from(*mean) * f64::from(count);
    }
    sum
}
