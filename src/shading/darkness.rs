//! What keeps light from the camera: counted along rays that bring none back.

use super::walk::{Arrival, Branch, Facing, RayKind, SurfacePoint};
use super::{TraceState, Tracer};
use crate::geometry::Ray;
use crate::spectrum::Bands;

/// Samples of a light that are asked whether they face a hit.
const ASKED_SAMPLES: usize = 200;

/// What rays met, in numbers of hits but for the first two.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Darkness {
    /// Camera rays.
    pub rays: usize,
    /// Those that met a surface.
    pub seen: usize,
    /// Those that met a back side.
    pub backs: usize,
    /// Hits of any depth.
    pub hits: usize,
    /// Hits on materials that return nothing: no lobes, no mirrored and no transmitted ray.
    pub dead: usize,
    /// Hits on materials with lobes or a mirrored ray, but without reflectance.
    pub without_reflectance: usize,
    /// Hits on materials with a transmittance, but k_tg = 0.
    pub shut: usize,
    /// Hits that asked the lights.
    pub asked: usize,
    /// Hits among `asked` that a light sample faces.
    pub faced: usize,
    /// Hits among `faced` that light would reach without shadows.
    pub reached: usize,
    /// Rays that were cut, at `max_depth` or inside a body.
    pub ended: usize,
}

impl Tracer<'_> {
    /// Follows `rays` and counts what they meet.
    pub fn darkness(&self, rays: impl Iterator<Item = Ray>) -> Darkness {
        let mut found = Darkness::default();
        for ray in rays {
            found.rays += 1;
            self.walk(ray, &mut TraceState::default(), |branch, arrival, _| {
                self.note(&mut found, branch, arrival);
            });
        }
        found
    }

    /// Whether any of `rays` brings light back.
    pub fn is_lit_along(&self, mut rays: impl Iterator<Item = Ray>) -> bool {
        rays.any(|ray| {
            let mut sum = Bands::zero(self.tables.bands);
            self.trace(ray, &mut TraceState::default(), &mut sum);
            !sum.is_zero()
        })
    }

    fn note(&self, found: &mut Darkness, branch: &Branch, arrival: &Arrival) {
        let surface = match arrival {
            Arrival::Missed | Arrival::Passed(..) | Arrival::Emitter(_) => return,
            Arrival::Cut => {
                found.ended += 1;
                return;
            }
            Arrival::Hit(surface) => surface,
        };
        found.hits += 1;
        if branch.kind == RayKind::Camera {
            found.seen += 1;
            found.backs += usize::from(surface.facing == Facing::Back);
        }
        let material = &self.prepared.scene.materials[surface.material.0];
        let tables = &self.tables.materials[surface.material.0];
        let reflects = material.k_rg > 0.0 || !material.lobes.is_black();
        let is_dead = !reflects && !material.transmits();
        found.dead += usize::from(is_dead);
        found.without_reflectance += usize::from(reflects && tables.reflectance.is_zero());
        found.shut += usize::from(material.transmittance.is_some() && material.k_tg == 0.0);
        found.ended += usize::from(!is_dead && branch.depth >= self.limits.max_depth);
        if self.is_lit(surface) {
            found.asked += 1;
            found.faced += usize::from(self.is_faced(surface));
            found.reached += usize::from(self.is_reached(surface));
        }
    }

    fn is_faced(&self, surface: &SurfacePoint) -> bool {
        self.prepared.scene.lights.iter().any(|light| {
            let samples = light.rays.samples.iter();
            let step = (light.rays.samples.len() / ASKED_SAMPLES).max(1);
            samples.step_by(step).any(|sample| {
                let way = surface.near.departure.point - light.rays.world_origin(sample);
                way.dot(light.rays.world_direction(sample)) > 0.0
            })
        })
    }

    fn is_reached(&self, surface: &SurfacePoint) -> bool {
        let query = self.hit_query(surface);
        self.prepared.light_trees.iter().any(|tree| {
            let answer = tree.sum(&query, self.limits.light_error, None);
            answer.reflected > 0.0 || answer.transmitted > 0.0
        })
    }
}
