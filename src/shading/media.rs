//! The bodies that a ray is in (model.md, "Bodies").

use crate::geometry::{DVec3, Hit, Ray};
use crate::scene::{Prepared, SurfaceKind};

/// Objects whose bodies a ray is in, in the order in which it entered them.
///
/// Outside of all, which is where most rays are, it takes no memory.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Media(Vec<u32>);

impl Media {
    /// The object whose body is there: the highest priority, and among equals the last entered.
    #[inline]
    pub fn medium(&self, prepared: &Prepared) -> Option<usize> {
        if self.0.is_empty() {
            return None;
        }
        let priority = |object: &&u32| prepared.surfaces.of_object[**object as usize].priority;
        self.0.iter().max_by_key(priority).map(|&object| object as usize)
    }

    /// All of them.
    pub fn objects(&self) -> impl Iterator<Item = usize> + '_ {
        self.0.iter().map(|&object| object as usize)
    }

    /// Enters a body; once in it, nothing changes.
    pub fn enter(&mut self, object: usize) {
        if !self.0.contains(&(object as u32)) {
            self.0.push(object as u32);
        }
    }

    /// Leaves a body; out of it, nothing changes.
    pub fn leave(&mut self, object: usize) {
        self.0.retain(|&inside| inside as usize != object);
    }

    /// A front of a sheet with `thickness` begins a path through it, its back ends any.
    pub fn leave_sheets(&mut self, prepared: &Prepared) {
        let is_body =
            |object: u32| prepared.surfaces.of_object[object as usize].kind == SurfaceKind::Body;
        self.0.retain(|&object| is_body(object));
    }

    /// The bodies around a point, the innermost last.
    ///
    /// Found by a ray to the outside: what it leaves more often than it enters is around its start.
    pub fn around(point: DVec3, prepared: &Prepared) -> Self {
        if !prepared.surfaces.may_hold(point) {
            return Self::default();
        }
        // In no plane in which a face is likely to lie.
        let direction = DVec3::new(0.531, 0.243, 0.812).normalize();
        let hits = prepared.bvh.hits_up_to(&Ray { origin: point, direction }, None, f64::INFINITY);
        let mut around = Vec::new();
        for object in bodies(&hits, prepared) {
            let own = hits.iter().filter(|hit| prepared.bvh.locate(hit.triangle).0 == object);
            let (mut exits, mut last) = (0, None);
            for hit in own {
                let leaves = prepared.bvh.departure(hit).n_geom.dot(direction) > 0.0;
                // Both triangles at an edge that the ray meets are one crossing.
                let is_same = last.is_some_and(|(before, distance)| {
                    before == leaves && hit.distance_mm - distance <= prepared.surfaces.place_mm
                });
                if !is_same {
                    exits += if leaves { 1 } else { -1 };
                }
                if leaves && exits == 1 {
                    around.push((hit.distance_mm, object));
                }
                last = Some((leaves, hit.distance_mm));
            }
            if exits != 1 {
                around.retain(|&(_, other)| other != object);
            }
        }
        around.sort_by(|a, b| b.partial_cmp(a).expect("distances are finite"));
        let mut media = Self::default();
        around.iter().for_each(|&(_, object)| media.enter(object));
        media
    }
}

/// The bodies that are met, each once.
fn bodies(hits: &[Hit], prepared: &Prepared) -> Vec<usize> {
    let mut objects: Vec<usize> =
        hits.iter().map(|hit| prepared.bvh.locate(hit.triangle).0).collect();
    objects.sort_unstable();
    objects.dedup();
    let kind = |object: usize| prepared.surfaces.of_object.get(object).map(|surface| surface.kind);
    objects.retain(|&object| kind(object) == Some(SurfaceKind::Body));
    objects
}
