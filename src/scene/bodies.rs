//! What the surfaces of a scene's objects are to a ray that meets them.

use crate::geometry::bvh::Bvh;
use crate::geometry::{Closure, DVec3};

use super::reuse::Earlier;
use super::{MaterialId, Object, Scene};

/// What a ray does at a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SurfaceKind {
    /// Nothing passes.
    Opaque,
    /// Light passes, and no body is behind: without `ior` and `thickness`, or an open mesh. As in
    /// the paper, its front is outside.
    Sheet,
    /// It bounds a body: a closed mesh of a material with `ior` or `thickness`.
    Body,
    /// A light's own, where rays end.
    Emitter,
}

/// An object's surface, as far as rays need to know it before they are shaded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surface {
    /// What it bounds.
    pub kind: SurfaceKind,
    /// What it is made of.
    pub material: MaterialId,
    /// Where bodies overlap, the one with the highest is there; among equals, the one entered last.
    pub priority: i32,
    /// How its mesh closes; `None` where no body is asked for.
    pub closure: Option<Closure>,
    /// What a body encloses, mm³; of those entered together, the smallest counts as the last.
    pub volume_mm3: f64,
}

/// All surfaces of a scene, and how near is "in one place".
#[derive(Debug)]
pub struct Surfaces {
    /// By object.
    pub of_object: Vec<Surface>,
    /// Where bodies are; `None` without any.
    pub bodies: Option<[DVec3; 2]>,
    /// Surfaces whose distance along the normal is at most this are in one place whatever they
    /// are: rounding does not tell them apart.
    pub place_mm: f64,
    /// The same for surfaces of different objects (`contact`).
    pub contact_mm: f64,
    /// How far behind a hit, along the ray, others may be in its place.
    pub reach_mm: f64,
}

/// Rays that run nearer along a surface than 1/1000 rad meet what is in one place one by one.
const STEEPEST: f64 = 1000.0;
/// The same for `contact`.
const STEEPEST_CONTACT: f64 = 30.0;

impl Surfaces {
    pub(super) fn new(scene: &Scene, bvh: &Bvh, earlier: Earlier) -> Self {
        let of_object: Vec<Surface> =
            scene.objects.iter().map(|object| Surface::new(object, scene, earlier)).collect();
        let are_bodies = scene.objects.iter().zip(&of_object);
        let bodies = are_bodies
            .filter(|(_, surface)| surface.kind == SurfaceKind::Body)
            .map(|(object, _)| object.mesh.bounds())
            .reduce(|[low, high], [l, h]| [low.min(l), high.max(h)]);
        let (place_mm, contact_mm) = (bvh.place_mm(), scene.contact_mm);
        Self {
            of_object,
            bodies,
            place_mm,
            contact_mm,
            reach_mm: (STEEPEST * place_mm).max(STEEPEST_CONTACT * contact_mm),
        }
    }

    /// Whether a point may lie in a body.
    pub fn may_hold(&self, point: DVec3) -> bool {
        self.bodies.is_some_and(|[low, high]| point.cmpge(low).all() && point.cmple(high).all())
    }
}

impl Surface {
    fn new(object: &Object, scene: &Scene, earlier: Earlier) -> Self {
        let material = &scene.materials[object.material.0];
        let mut surface = Self {
            kind: SurfaceKind::Opaque,
            material: object.material,
            priority: material.priority,
            closure: None,
            volume_mm3: 0.0,
        };
        if material.is_body() {
            let known = earlier.closure(&object.mesh);
            let closure = known.unwrap_or_else(|| Closure::of(&object.mesh));
            surface.closure = Some(closure);
            surface.volume_mm3 = closure.volume_mm3.abs();
            surface.kind = if closure.is_closed() { SurfaceKind::Body } else { SurfaceKind::Sheet };
        } else if material.transmits() {
            surface.kind = SurfaceKind::Sheet;
        }
        surface
    }
}
