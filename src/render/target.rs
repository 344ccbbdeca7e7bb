//! A picture whose luminance is within a target: which limits, and how many samples, that takes.
//!
//! The error is the rms over lit pixels of the luminance's error relative to the pixel's, as
//! [`crate::image::difference`] measures it. Measured (`scripts/tradeoff.lua`), nearly all of it and
//! of the price of a smaller one is sampling's, so sampling has most of the target. Limits cost
//! little: the cheapest are taken whose error, at rays of this view, is within a small share. All
//! 81 bands are kept, since they cost next to nothing.

use std::fmt;
use std::time::Instant;

use rayon::prelude::*;

use super::pattern::Pattern;
use super::{Quality, RenderStats, Samples, Untold, Watch, render};
use crate::error::{Error, Result};
use crate::geometry::Ray;
use crate::image::SpectralImage;
use crate::image::difference::lit_luminance;
use crate::scene::{Prepared, SpectralTables};
use crate::shading::{TraceCounts, TraceLimits, TraceState, Tracer};
use crate::spectrum::{Bands, WavelengthGrid};
use crate::view::View;

/// The most that light sums and limits may take of the target. Noise adds to their sum by squares,
/// so that sampling has at least √(1 − 0.3²) = 0.95 of it.
const LIGHT_SHARE: f64 = 0.1;
const TRUNCATION_SHARE: f64 = 0.2;

/// Camera rays a pixel at which sampling gives up.
pub const MOST_SAMPLES: u32 = 100_000;

/// Camera rays a pixel of the picture that tells which places are lit, and about how many pixels it
/// has at most.
const PILOT_SAMPLES: u32 = 4;
const PILOT_PIXELS: f64 = 2048.0;

const GRID: WavelengthGrid = WavelengthGrid::Step5;

/// What [`render_to_target`] chose, and the errors that it estimates, all as `target` is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TargetReport {
    /// Relative rms of luminance over lit pixels.
    pub target: f64,
    /// Limits that were chosen.
    pub limits: TraceLimits,
    /// Bands of the picture.
    pub grid: WavelengthGrid,
    /// Mean number of camera rays a pixel.
    pub mean_samples: f64,
    /// Largest number of camera rays of a pixel.
    pub most_samples: u32,
    /// Error of the finite number of camera rays.
    pub sampling_error: f64,
    /// Error of the sums over light samples.
    pub light_sum_error: f64,
    /// Error of `max_depth` and `min_throughput`.
    pub truncation_error: f64,
}

impl TargetReport {
    /// Estimated error of the image.
    pub fn error(&self) -> f64 {
        self.sampling_error.hypot(self.light_sum_error + self.truncation_error)
    }

    /// Whether the estimated error is within the target.
    pub fn is_reached(&self) -> bool {
        self.error() <= self.target
    }
}

impl fmt::Display for TargetReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let reached = if self.is_reached() { "reached" } else { "not reached" };
        write!(
            f,
            "target_error {} is {reached}: {:.2e} is estimated ({:.2e} from up to {} samples a \
             pixel, {:.2e} from light_error {}, {:.2e} from max_depth {} and min_throughput {})",
            self.target,
            self.error(),
            self.sampling_error,
            self.most_samples,
            self.light_sum_error,
            self.limits.light_error,
            self.truncation_error,
            self.limits.max_depth,
            self.limits.min_throughput,
        )
    }
}

/// The view's spectral radiance, with the quality that brings its luminance within `target`.
///
/// `target`: relative rms over lit pixels, above 0. [`RenderStats::target`] says what was chosen,
/// and whether it is reached: it is not where [`MOST_SAMPLES`] are too few, or the deepest limits
/// too shallow. Same inputs, same bits, for any number of threads. Errors: as [`render`].
pub fn render_to_target(
    prepared: &Prepared,
    view: &View,
    target: f64,
    watch: &dyn Watch,
) -> Result<(SpectralImage, RenderStats)> {
    let start = Instant::now();
    let tables = prepared.tables(GRID)?;
    let trials = Trials { prepared, tables, view: &pilot_view(view), target, watch };
    let (chosen, pilot) = trials.choose()?;
    let bias = chosen.light_sum_error + chosen.truncation_error;
    let noise = (target.powi(2) - bias.powi(2)).max(0.0).sqrt();
    let quality = Quality {
        samples: Samples::Lit { max: MOST_SAMPLES, error: noise },
        limits: chosen.rung.limits(target),
        grid: GRID,
        ..Quality::default()
    };
    let trial_seconds = start.elapsed().as_secs_f64();
    let (mut image, mut stats) = render(prepared, view, &quality, watch)?;
    image.metadata.insert("target_error".to_owned(), target.to_string());
    stats.target = Some(chosen.report(target, &image, &stats));
    stats.counts = pilot + stats.counts;
    stats.expected_seconds = stats.expected_seconds.map(|seconds| trial_seconds + seconds);
    stats.seconds = start.elapsed().as_secs_f64();
    Ok((image, stats))
}

/// The same view in few pixels: what is lit, and what limits cost, is seen in those, too.
fn pilot_view(view: &View) -> View {
    let shrink = (view.pixels() as f64 / PILOT_PIXELS).sqrt().max(1.0);
    let fewer = |pixels: usize| (pixels as f64 / shrink).ceil() as usize;
    View { width: fewer(view.width), height: fewer(view.height), ..*view }
}

/// Limits from cheap to close.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Rung {
    depth: usize,
    light: usize,
}

impl Rung {
    const CHEAPEST: Self = Self { depth: 0, light: 0 };
    const DEEPEST: usize = 3;
    /// The last is the exact sum.
    const LIGHT_ERRORS: [f64; 6] = [0.1, 0.03, 0.01, 0.003, 0.001, 0.0];

    /// 8, 16, 32 or 64 hits deep, each with a tenth of the throughput of the one before.
    fn limits(self, target: f64) -> TraceLimits {
        TraceLimits {
            max_depth: 8 << self.depth,
            min_throughput: 0.5 * target * 0.1f64.powi(self.depth as i32),
            light_error: Self::LIGHT_ERRORS[self.light],
            ..TraceLimits::default()
        }
    }

    fn deeper(self) -> Self {
        Self { depth: self.depth + 1, ..self }
    }

    fn closer(self) -> Self {
        Self { light: self.light + 1, ..self }
    }
}

/// Limits, and what they were found to cost.
#[derive(Debug, Clone, Copy)]
struct Chosen {
    rung: Rung,
    light_sum_error: f64,
    truncation_error: f64,
}

impl Chosen {
    fn report(&self, target: f64, image: &SpectralImage, stats: &RenderStats) -> TargetReport {
        let samples = image.samples.as_deref().unwrap_or_default();
        TargetReport {
            target,
            limits: self.rung.limits(target),
            grid: GRID,
            mean_samples: stats.counts.camera_rays as f64 / samples.len() as f64,
            most_samples: samples.iter().copied().fold(0.0, f32::max) as u32,
            sampling_error: stats.sampling_error.unwrap_or(0.0),
            light_sum_error: self.light_sum_error,
            truncation_error: self.truncation_error,
        }
    }
}

/// Traces some camera rays of lit pixels within other limits, to see what they change.
///
/// A ray differs by more than the mean of its pixel's rays, so the estimates err to the safe side.
struct Trials<'a> {
    prepared: &'a Prepared,
    tables: &'a SpectralTables,
    /// The pilot's.
    view: &'a View,
    target: f64,
    watch: &'a dyn Watch,
}

/// A camera ray, and the luminance of its pixel.
#[derive(Debug, Clone, Copy)]
struct LitRay {
    ray: Ray,
    luminance: f64,
}

impl Trials<'_> {
    /// The cheapest limits whose errors are within their shares, and what the pilot traced.
    fn choose(&self) -> Result<(Chosen, TraceCounts)> {
        /// Differences of depth need no exact sums, which take a million times longer.
        const RAYS: usize = 1024;
        const EXACT_RAYS: usize = 64;
        let limits = Rung::CHEAPEST.limits(self.target);
        let quality = Quality {
            samples: Samples::Fixed(PILOT_SAMPLES),
            limits,
            grid: GRID,
            ..Quality::default()
        };
        let (pilot, stats) = render(self.prepared, self.view, &quality, &Untold(self.watch))?;
        let rays = self.lit_rays(&pilot, RAYS);
        let (depth, truncation_error) = self.choose_depth(&rays)?;
        let few: Vec<LitRay> = rays.into_iter().step_by(RAYS / EXACT_RAYS).collect();
        let (light, light_sum_error) = self.choose_light(&few, depth)?;
        let rung = Rung { depth, light };
        Ok((Chosen { rung, light_sum_error, truncation_error }, stats.counts))
    }

    /// Index of the depth, and its error.
    fn choose_depth(&self, rays: &[LitRay]) -> Result<(usize, f64)> {
        let mut rung = Rung::CHEAPEST;
        let mut here = self.luminances(rays, rung.limits(self.target))?;
        loop {
            let deeper = self.luminances(rays, rung.deeper().limits(self.target))?;
            let error = rms_change(rays, &here, &deeper);
            if error <= TRUNCATION_SHARE * self.target || rung.depth == Rung::DEEPEST {
                return Ok((rung.depth, error));
            }
            (rung, here) = (rung.deeper(), deeper);
        }
    }

    /// Index of the light error, and what it leaves.
    fn choose_light(&self, rays: &[LitRay], depth: usize) -> Result<(usize, f64)> {
        /// What stands for the exact sum, its own bound added, where that is within a third of the
        /// share: it takes a hundredth of the time.
        const NEARLY_EXACT: f64 = 0.001;
        let share = LIGHT_SHARE * self.target;
        let light_error = if NEARLY_EXACT <= share / 3.0 { NEARLY_EXACT } else { 0.0 };
        let mut rung = Rung { depth, light: 0 };
        let limits = rung.limits(self.target);
        let exact = self.luminances(rays, TraceLimits { light_error, ..limits })?;
        loop {
            let near = self.luminances(rays, rung.limits(self.target))?;
            let error = light_error + rms_change(rays, &near, &exact);
            // The last is exact, so its error is 0; before it comes what stands for it.
            if error <= share {
                return Ok((rung.light, error));
            }
            rung = rung.closer();
        }
    }

    /// This many rays, evenly among the lit pixels, at places that the pilot has not sampled; none
    /// if all are black.
    fn lit_rays(&self, pilot: &SpectralImage, count: usize) -> Vec<LitRay> {
        let luminances: Vec<f64> = pilot.to_xyz().pixels.iter().map(|c| c.y).collect();
        let threshold = lit_luminance(luminances.clone());
        let is_lit = |&pixel: &usize| luminances[pixel] > 0.0 && luminances[pixel] >= threshold;
        let lit: Vec<usize> = (0..luminances.len()).filter(is_lit).collect();
        let camera = self.view.camera();
        let ray = |i: usize| {
            let pixel = *lit.get(i * lit.len() / count)?;
            let (x, y) = (pixel % pilot.width, pixel / pilot.width);
            let [dx, dy] = Pattern::of_pixel(x, y).place(PILOT_SAMPLES + i as u32);
            let ray = camera.ray(x as f64 + dx, y as f64 + dy);
            Some(LitRay { ray, luminance: luminances[pixel] })
        };
        (0..count).filter_map(ray).collect()
    }

    fn luminances(&self, rays: &[LitRay], limits: TraceLimits) -> Result<Vec<f64>> {
        let tracer = Tracer { prepared: self.prepared, tables: self.tables, limits };
        let luminance = |lit: &LitRay| {
            if self.watch.is_cancelled() {
                return Err(Error::Interrupted);
            }
            let mut sum = Bands::zero(self.tables.bands);
            tracer.trace(lit.ray, &mut TraceState::default(), &mut sum);
            Ok(sum.dot(&self.tables.luminance_weights))
        };
        rays.par_iter().map(luminance).collect()
    }
}

/// Rms change of the rays' luminances, relative to those of their pixels with the ray among the
/// samples: a highlight that the pilot has missed makes its pixel brighter.
fn rms_change(rays: &[LitRay], from: &[f64], to: &[f64]) -> f64 {
    let share = f64::from(PILOT_SAMPLES + 1).recip();
    let changes = rays.iter().zip(from.iter().zip(to));
    let relative = |(lit, (from, to)): (&LitRay, (&f64, &f64))| {
        (to - from) / (lit.luminance + share * (to - lit.luminance))
    };
    let squares: f64 = changes.map(|change| relative(change).powi(2)).sum();
    (squares / rays.len().max(1) as f64).sqrt()
}
