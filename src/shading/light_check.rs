//! Compares light sums with exact ones, at hits of a real view.

use rayon::prelude::*;

use super::{Arrival, Branch, SurfacePoint, TraceState, Tracer};
use crate::geometry::Ray;

/// Relative errors of the light sums at some hits.
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

/// A sum within `light_error`, and the exact one.
#[derive(Debug, Clone, Copy)]
struct Compared {
    relative: f64,
    of_estimate: f64,
}

impl Compared {
    /// `None` where no light arrives.
    fn new(sum: f64, estimate: f64, exact: f64) -> Option<Self> {
        let error = (sum - exact).abs();
        let of_estimate = if error > 0.0 { error / estimate } else { 0.0 };
        (exact > 0.0).then(|| Self { relative: error / exact, of_estimate })
    }
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

    fn compare(&self, surface: &SurfacePoint) -> impl Iterator<Item = Compared> {
        let of_light = |light: usize| {
            let (sum, _) = self.light_sum(light, surface, self.limits.light_error);
            let (exact, _) = self.light_sum(light, surface, 0.0);
            [
                Compared::new(sum.reflected, sum.reflected_error, exact.reflected),
                Compared::new(sum.transmitted, sum.transmitted_error, exact.transmitted),
            ]
        };
        (0..self.prepared.light_trees.len())
            .flat_map(of_light)
            .flatten()
            .collect::<Vec<_>>()
            .into_iter()
    }
}

impl LightCheck {
    fn from_compared(compared: &[Compared]) -> Option<Self> {
        let mut errors: Vec<f64> = compared.iter().map(|c| c.relative).collect();
        errors.sort_by(f64::total_cmp);
        let rank = |share: f64| errors.get(((errors.len() as f64 - 1.0) * share).round() as usize);
        Some(Self {
            sums: errors.len(),
            median: *rank(0.5)?,
            percentile_95: *rank(0.95)?,
            largest: *errors.last()?,
            largest_of_estimate: compared.iter().map(|c| c.of_estimate).fold(0.0, f64::max),
        })
    }
}
