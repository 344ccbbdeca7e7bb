//! Lights with a body: their surfaces in the world, and what changes for lobes and shadows where
//! rays see them.

use std::sync::Arc;

use glam::DAffine3;

use super::{Light, Scene};
use crate::geometry::mesh::Shading;
use crate::geometry::{DVec3, Mesh};
use crate::light::RaySet;
use crate::material::{Lobes, Material};
use crate::source::Emitter;

/// A light's surface in the world.
#[derive(Debug)]
pub struct PreparedEmitter {
    /// Index into [`Scene::lights`].
    pub light: usize,
    pub(super) mesh: Arc<Mesh>,
    surface: Emitter,
    local_from_world: DAffine3,
    /// Luminance where the surface's own is 1 per lm, lm.
    flux_over_scale2: f64,
}

impl PreparedEmitter {
    pub(super) fn all(lights: &[Light]) -> Vec<Self> {
        let lit = lights.iter().enumerate();
        lit.filter_map(|(light, given)| Some(Self::new(light, given, given.surface.as_ref()?)))
            .collect()
    }

    fn new(light: usize, given: &Light, surface: &Emitter) -> Self {
        let RaySet { world_from_local, flux_lm, .. } = given.rays;
        let to_world = |p: &DVec3| world_from_local.transform_point3(*p);
        let positions = surface.mesh.positions.iter().map(to_world).collect();
        let triangles = surface.mesh.triangles.clone();
        let scale2 = world_from_local.matrix3.determinant().abs().cbrt().powi(2);
        Self {
            light,
            mesh: Arc::new(Mesh { positions, triangles, shading: Shading::Flat }),
            surface: surface.clone(),
            local_from_world: world_from_local.inverse(),
            flux_over_scale2: flux_lm / scale2,
        }
    }

    /// cd/m² that leaves the front at `point` into `direction` (unit), both in the world.
    pub fn luminance(&self, point: DVec3, direction: DVec3) -> f64 {
        let point = self.local_from_world.transform_point3(point);
        let direction = self.local_from_world.transform_vector3(direction).normalize_or_zero();
        self.flux_over_scale2 * self.surface.luminance_per_lm(point, direction)
    }
}

impl Scene {
    /// Whether any light has a surface that rays see.
    pub fn has_emitters(&self) -> bool {
        self.lights.iter().any(|light| light.surface.is_some())
    }

    /// Whether light ends at an object, or at an emitter behind these.
    pub(super) fn opaque(&self, emitters: &[PreparedEmitter]) -> Arc<[bool]> {
        let objects = self.objects.iter().map(|o| !self.materials[o.material.0].transmits());
        objects.chain(emitters.iter().map(|_| true)).collect()
    }

    /// Per light, what blocks its samples: all that is opaque but its own surface, on which they lie.
    pub(super) fn blocks(
        &self,
        opaque: &Arc<[bool]>,
        emitters: &[PreparedEmitter],
    ) -> Vec<Arc<[bool]>> {
        let of_light = |light| match emitters.iter().position(|e| e.light == light) {
            None => Arc::clone(opaque),
            Some(own) => {
                let mut others = opaque.to_vec();
                others[self.objects.len() + own] = false;
                others.into()
            }
        };
        (0..self.lights.len()).map(of_light).collect()
    }

    /// Where rays see the source through a surface that bends them, its lobe about the undeviated
    /// direction would show the same light a second time.
    pub(super) fn far_lobes(&self, material: &Material) -> Option<Lobes> {
        let is_seen_twice = self.has_emitters() && material.ior.is_some() && material.transmits();
        is_seen_twice.then(|| Lobes { specular: Vec::new(), ..material.lobes.clone() })
    }

    /// Mirrored rays see an emitter's surface, specular lobes its samples.
    pub(super) fn double_count_warnings(&self) -> impl Iterator<Item = String> + '_ {
        let materials = self.materials.iter().filter(|_| self.has_emitters());
        materials.filter_map(|material| {
            let k_s: f64 = material.lobes.specular.iter().map(|lobe| lobe.k_s).sum();
            let total = material.k_rg + k_s;
            // 1e-9: a sum of proportions may round above 1.
            (total > 1.0 + 1e-9 && material.reflectance.max() > 0.0).then(|| {
                format!(
                    "{}: mirrored rays and lobes both return a visible light, {total:.3} times: \
                     k_rg + k_s should be at most 1",
                    material.name
                )
            })
        })
    }
}
