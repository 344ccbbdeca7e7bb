//! Compares light sums with exact ones, at hits of a real view.

use rayon::prelude::*;

use super::{Arrival, Branch, SurfacePoint, TraceState, Tracer};
use crate::geometry::Ray;

/// Errors of the light sums at some hits, relative to the exact sum.
///
/// Sums below [`DARK`] of the largest one are taken for that much: what is so dark is rounding.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightCheck {
    /// Sums compared: one a side of a hit and a light that shine.
    pub sums: usize,
    pub median: f64,
    pub percentile_95: f64,
    pub largest: f64,
    /// The largest ratio of the true error to the estimated one; 0 where all sums were exact.
    pub largest_of_estimate: f64,
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
        let compared: Vec<Compared> =
            surfaces.par_iter().flat_map_iter(|surface| self.compare(surface)).collect();
        LightCheck::from_compared(&compared)
    }

    fn lit_surfaces(&self, ray: Ray, surfaces: &mut Vec<SurfacePoint>) {
        let mut state = TraceState::default();
        state.pending.push(Branch::from_camera(ray, self.tables.bands));
        while let Some(mut branch) = state.pending.pop() {
            if let Arrival::Hit(surface) = self.arrive(&mut branch) {
                if self.is_lit(&surface) {
                    surfaces.push(surface);
                }
                self.push_children(&surface, branch, &mut state);
            }
        }
    }

    fn compare<'a>(&'a self, surface: &'a SurfacePoint) -> impl Iterator<Item = Compared> + 'a {
        let of_light = move |light: usize| {
            let (sum, _) = self.light_sum(light, surface, self.limits.light_error);
            let (exact, _) = self.light_sum(light, surface, 0.0);
            [
                Compared {
                    exact: exact.reflected,
                    error: (sum.reflected - exact.reflected).abs(),
                    estimate: sum.reflected_error,
                },
                Compared {
                    exact: exact.transmitted,
                    error: (sum.transmitted - exact.transmitted).abs(),
                    estimate: sum.transmitted_error,
                },
            ]
        };
        (0..self.prepared.light_trees.len()).flat_map(of_light)
    }
}

impl LightCheck {
    fn from_compared(compared: &[Compared]) -> Option<Self> {
        let brightest = compared.iter().map(|c| c.exact).fold(0.0, f64::max);
        let lit = || compared.iter().filter(|c| c.exact > 0.0);
        let mut errors: Vec<f64> = lit().map(|c| c.error / c.exact.max(DARK * brightest)).collect();
        // Exact sums in another order differ by rounding, which no estimate covers.
        let of_estimate = lit().filter(|c| c.estimate > 0.0).map(|c| c.error / c.estimate);
        errors.sort_by(f64::total_cmp);
        let rank = |share: f64| errors.get(((errors.len() as f64 - 1.0) * share).round() as usize);
        Some(Self {
            sums: errors.len(),
            median: *rank(0.5)?,
            percentile_95: *rank(0.95)?,
            largest: *errors.last()?,
            largest_of_estimate: of_estimate.fold(0.0, f64::max),
        })
    }
}
