//! Compares light sums with exact ones, at hits of a real view.

use std::time::Instant;

use rayon::prelude::*;

use super::walk::{Arrival, SurfacePoint};
use super::{TraceState, Tracer};
use crate::geometry::Ray;
use crate::light::LightSum;
use crate::statistics::percentile;

/// Errors of the light sums at some hits, relative to the exact sum.
///
/// Sums below 10⁻⁹ of the largest one are taken for that much: what is so dark is rounding.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightCheck {
    /// Sums compared: one per side of a hit and light that shine.
    pub sums: usize,
    /// The middle one of the relative errors.
    pub median: f64,
    /// The relative error that 95 % stay below.
    pub percentile_95: f64,
    /// The largest relative error.
    pub largest: f64,
    /// The largest ratio of the true error to the estimated one; 0 where all sums were exact.
    pub largest_of_estimate: f64,
    /// Time of the exact sums over that of these, at all hits and both on all threads.
    pub speedup: f64,
}

/// Share of the brightest that no picture shows.
const DARK: f64 = 1e-9;

/// A sum within `light_error`, and the exact one.
#[derive(Debug, Clone, Copy)]
struct Compared {
    exact: f64,
    error: f64,
    estimate: f64,
}

impl Tracer<'_> {
    /// Light sums at the hits of `rays` and of their mirrored and transmitted rays, until `hits`
    /// are reached; `None` if no light arrives at any.
    pub fn check_light(&self, rays: impl Iterator<Item = Ray>, hits: usize) -> Option<LightCheck> {
        let mut surfaces = Vec::new();
        for ray in rays {
            if surfaces.len() >= hits {
                break;
            }
            self.lit_surfaces(ray, &mut surfaces);
        }
        surfaces.truncate(hits);
        let (sums, seconds) = timed(|| self.light_sums(&surfaces, self.limits.light_error));
        let (exact, exact_seconds) = timed(|| self.light_sums(&surfaces, 0.0));
        let compared: Vec<Compared> =
            sums.iter().zip(&exact).flat_map(|(sum, exact)| Compared::sides(sum, exact)).collect();
        LightCheck::from_compared(&compared, exact_seconds / seconds)
    }

    /// Sums of every light at every hit.
    fn light_sums(&self, surfaces: &[SurfacePoint], light_error: f64) -> Vec<LightSum> {
        let at = |surface| {
            let lights = 0..self.prepared.light_trees.len();
            lights.map(move |light| self.light_sum(light, surface, light_error))
        };
        surfaces.par_iter().flat_map_iter(at).collect()
    }

    fn lit_surfaces(&self, ray: Ray, surfaces: &mut Vec<SurfacePoint>) {
        self.walk(ray, &mut TraceState::default(), |_, arrival, _| match arrival {
            Arrival::Hit(surface) if self.is_lit(surface) => surfaces.push(surface.clone()),
            Arrival::Hit(_)
            | Arrival::Passed(..)
            | Arrival::Missed
            | Arrival::Cut
            | Arrival::Emitter(_) => {}
        });
    }
}

fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let result = work();
    (result, start.elapsed().as_secs_f64().max(1e-9))
}

impl Compared {
    fn sides(sum: &LightSum, exact: &LightSum) -> [Compared; 2] {
        let side = |sum: f64, exact: f64, estimate| Compared {
            exact,
            error: (sum - exact).abs(),
            estimate,
        };
        [
            side(sum.reflected, exact.reflected, sum.reflected_error),
            side(sum.transmitted, exact.transmitted, sum.transmitted_error),
        ]
    }
}

impl LightCheck {
    fn from_compared(compared: &[Compared], speedup: f64) -> Option<Self> {
        let brightest = compared.iter().map(|c| c.exact).fold(0.0, f64::max);
        let lit = || compared.iter().filter(|c| c.exact > 0.0);
        let mut errors: Vec<f64> = lit().map(|c| c.error / c.exact.max(DARK * brightest)).collect();
        // Exact sums in another order differ by rounding, which no estimate covers.
        let of_estimate = lit().filter(|c| c.estimate > 0.0).map(|c| c.error / c.estimate);
        Some(Self {
            sums: errors.len(),
            median: percentile(&mut errors, 50.0)?,
            percentile_95: percentile(&mut errors, 95.0)?,
            largest: percentile(&mut errors, 100.0)?,
            largest_of_estimate: of_estimate.fold(0.0, f64::max),
            speedup,
        })
    }
}
