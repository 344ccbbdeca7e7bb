//! Parts of scenes that were prepared before, for one that has the same meshes or rays.

use std::sync::Arc;

use super::{Object, Prepared, PreparedEmitter};
use crate::geometry::bvh::Bvh;
use crate::geometry::mesh::Shading;
use crate::geometry::{Closure, DVec3, Mesh};
use crate::light::RaySet;
use crate::light::tree::LightTree;

/// Prepared scenes to take parts from; parts are the same bits whether they are built or taken.
#[derive(Debug, Clone, Copy)]
pub(super) struct Earlier<'a>(pub &'a [Arc<Prepared>]);

impl Earlier<'_> {
    pub fn bvh(&self, meshes: &[Arc<Mesh>]) -> Option<Arc<Bvh>> {
        let has_them = |scene: &&Arc<Prepared>| {
            let theirs = scene.meshes();
            theirs.len() == meshes.len() && theirs.zip(meshes).all(|(a, b)| is_same_mesh(a, b))
        };
        self.0.iter().find(has_them).map(|scene| Arc::clone(&scene.bvh))
    }

    pub fn light_tree(&self, rays: &RaySet) -> Option<Arc<LightTree>> {
        let all = self.0.iter().flat_map(|scene| scene.scene.lights.iter().zip(&scene.light_trees));
        let mut same = all.filter(|(light, _)| is_same_set(&light.rays, rays));
        same.next().map(|(_, tree)| Arc::clone(tree))
    }

    pub fn closure(&self, mesh: &Arc<Mesh>) -> Option<Closure> {
        let of = |scene: &Prepared| {
            let surfaces = scene.scene.objects.iter().zip(&scene.surfaces.of_object);
            let same = |(object, _): &(&Object, _)| Arc::ptr_eq(&object.mesh, mesh);
            surfaces.filter(same).find_map(|(_, surface)| surface.closure)
        };
        self.0.iter().find_map(|scene| of(scene))
    }
}

impl Prepared {
    /// What the BVH was built of.
    fn meshes(&self) -> impl ExactSizeIterator<Item = &Arc<Mesh>> {
        let objects = &self.scene.objects;
        let all = objects.len() + self.emitters.len();
        (0..all).map(move |at| match objects.get(at) {
            Some(Object { mesh, .. }) => mesh,
            None => {
                let PreparedEmitter { mesh, .. } = &self.emitters[at - objects.len()];
                mesh
            }
        })
    }
}

/// To the bit: 0 and −0 differ.
fn is_same_mesh(a: &Arc<Mesh>, b: &Arc<Mesh>) -> bool {
    Arc::ptr_eq(a, b)
        || a.triangles == b.triangles
            && are_same_points(&a.positions, &b.positions)
            && is_same_shading(&a.shading, &b.shading)
}

fn is_same_shading(a: &Shading, b: &Shading) -> bool {
    match (a, b) {
        (Shading::Flat, Shading::Flat) => true,
        (Shading::PerPosition(a), Shading::PerPosition(b)) => are_same_points(a, b),
        (
            Shading::PerCorner { normals: a, triangles: of_a },
            Shading::PerCorner { normals: b, triangles: of_b },
        ) => of_a == of_b && are_same_points(a, b),
        _ => false,
    }
}

fn are_same_points(a: &[DVec3], b: &[DVec3]) -> bool {
    let bits = |p: &DVec3| p.to_array().map(f64::to_bits);
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| bits(a) == bits(b))
}

fn is_same_set(a: &RaySet, b: &RaySet) -> bool {
    let place = |set: &RaySet| set.world_from_local.to_cols_array().map(f64::to_bits);
    let rest = |set: &RaySet| [set.flux_lm, set.exponent].map(f64::to_bits);
    place(a) == place(b) && rest(a) == rest(b) && are_same_samples(a, b)
}

fn are_same_samples(a: &RaySet, b: &RaySet) -> bool {
    let (a, b) = (&a.samples, &b.samples);
    let bits = |v: &[f32; 3]| v.map(f32::to_bits);
    Arc::ptr_eq(a, b)
        || a.len() == b.len()
            && a.iter().zip(b.iter()).all(|(a, b)| {
                bits(&a.position) == bits(&b.position)
                    && bits(&a.direction) == bits(&b.direction)
                    && a.flux.to_bits() == b.flux.to_bits()
            })
}
