//! What the surroundings show to a ray that leaves the scene, and send to a hit's lobes.

use std::cell::Cell;

use super::walk::{Branch, SurfacePoint};
use super::{TraceState, Tracer};
use crate::environment::{FarLight, FarSide, SpecularShares};
use crate::geometry::DVec3;
use crate::material::Material;
use crate::scene::SurroundingsTables;
use crate::spectrum::Bands;

/// Shadows ask at least this often otherwise, and their edges are no better for it.
const SMALLEST_SHADOWED_ERROR: f64 = 1e-3;

impl Tracer<'_> {
    /// What a ray sees that hits nothing.
    pub(super) fn add_background(&self, branch: &Branch, sum: &mut Bands) {
        let environment = self.prepared.scene.background.environment();
        let Some((environment, tables)) = environment.zip(self.tables.surroundings.as_ref()) else {
            return sum.add_product(&branch.throughput, &self.tables.background);
        };
        let (dome, sun) = environment.seen(branch.ray.direction);
        sum.add_product(&branch.throughput, &tables.mixed(&dome, sun));
    }

    /// What the lobes of a hit return of the surroundings; nothing in a scene without. `shares` are
    /// what the two sides return.
    pub(super) fn add_surroundings(
        &self,
        surface: &SurfacePoint,
        [f_r, f_t]: [&Bands; 2],
        throughput: &Bands,
        state: &mut TraceState,
        sum: &mut Bands,
    ) {
        let Some(surroundings) = &self.tables.surroundings else { return };
        let (light, shadow_rays) = self.far_light(surface);
        state.counts.light_sums += 1;
        state.counts.light_nodes += u64::from(light.nodes);
        state.counts.shadow_rays += shadow_rays;
        for (side, filter) in [(&light.reflected, f_r), (&light.transmitted, f_t)] {
            let returned = returned(surroundings, side, filter);
            sum.add_product(throughput, &returned);
            let luminance = side.dome.iter().sum::<f64>() + side.sun;
            if side.error > 0.0 && luminance > 0.0 {
                let mut seen = Bands::zero(self.tables.bands);
                seen.add_product(throughput, &returned);
                let share = side.error / luminance;
                state.luminance_error += share * seen.dot(&self.tables.luminance_weights);
            }
        }
    }

    /// The sums over the surroundings, and the shadow rays that they took.
    fn far_light(&self, surface: &SurfacePoint) -> (FarLight, u64) {
        let scene = &self.prepared.scene;
        let Some(environment) = scene.background.environment() else {
            return (FarLight::default(), 0);
        };
        let query = self.hit_query(surface);
        let shares = shares(&scene.materials[surface.material.0]);
        let largest_error = self.limits.light_error;
        if !self.casts_shadows() {
            return (environment.light(&query, shares, largest_error, None), 0);
        }
        let shadow_rays = Cell::new(0);
        let sight = |direction: DVec3| {
            shadow_rays.set(shadow_rays.get() + 1);
            let from = surface.near.departure.toward(direction);
            let target = from + direction * self.prepared.beyond_mm;
            let leaving = Some(surface.near.triangle);
            !self.prepared.bvh.is_occluded(from, target, leaving, &self.prepared.opaque)
        };
        let largest_error = largest_error.max(SMALLEST_SHADOWED_ERROR);
        let light = environment.light(&query, shares, largest_error, Some(&sight));
        (light, shadow_rays.get())
    }
}

fn returned(surroundings: &SurroundingsTables, side: &FarSide, filter: &Bands) -> Bands {
    let mut bands = surroundings.mixed(&side.dome, side.sun);
    bands.scale_by(1.0, filter);
    bands
}

/// What of the specular lobes the mirrored and the transmitted ray do not bring back themselves.
///
/// Deviation: the paper's surfaces have rays and lobes for the same light, since its light samples
/// are not seen by rays. Surroundings are seen by both: k_s counts up to 1 − k_rg − k_d on the
/// viewer's side, and up to 1 − k_tg − k_d on the far one, so that both together return no more
/// than arrives.
fn shares(material: &Material) -> SpecularShares {
    let specular: f64 = material.lobes.specular.iter().map(|lobe| lobe.k_s).sum();
    let share = |k_ray: f64| {
        let left = (1.0 - k_ray - material.lobes.k_d).max(0.0);
        if specular > left { left / specular } else { 1.0 }
    };
    SpecularShares { reflected: share(material.k_rg), transmitted: share(material.k_tg) }
}
