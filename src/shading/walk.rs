//! The walk through the tree of rays that a camera ray becomes (eq. 1).

use super::{TraceState, Tracer};
use crate::geometry::{DVec3, Departure, Hit, Ray, TriangleId};
use crate::scene::MaterialId;
use crate::spectrum::Bands;

/// A ray still to be traced.
#[derive(Debug, Clone)]
pub(super) struct Branch {
    pub ray: Ray,
    pub kind: RayKind,
    pub leaving: Option<TriangleId>,
    /// 0 for the camera ray.
    pub depth: u32,
    /// The body (material with `thickness`) that the ray runs in.
    pub body: Option<MaterialId>,
    /// What is left of it in each band, 0 to 1.
    pub throughput: Bands,
}

/// How a ray left the surface before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RayKind {
    /// It left the eye.
    Camera,
    Mirrored,
    Transmitted,
}

impl Branch {
    /// A ray that brings light, of what is left of the light's spectrum.
    pub(super) fn from_light(ray: Ray, leaving: Option<TriangleId>, throughput: Bands) -> Self {
        Self { leaving, throughput, ..Self::from_camera(ray, 0) }
    }

    fn from_camera(ray: Ray, bands: usize) -> Self {
        Self {
            ray,
            kind: RayKind::Camera,
            leaving: None,
            depth: 0,
            body: None,
            throughput: Bands::one(bands),
        }
    }
}

/// A hit with its surface's frame: model.md, "V", "N_g, N".
#[derive(Debug, Clone, Copy)]
pub(super) struct SurfacePoint {
    pub triangle: TriangleId,
    /// P, and where the rays that leave it start.
    pub departure: Departure,
    pub material: MaterialId,
    pub side: Facing,
    /// Unit, on V's side (eq. 3).
    pub normal: DVec3,
    /// V.
    pub view: DVec3,
}

/// Which side of the triangle the ray comes from; counter-clockwise winding is the front.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Facing {
    Front,
    Back,
}

/// What became of a ray.
#[derive(Debug, Clone, Copy)]
pub(super) enum Arrival {
    Missed,
    /// Too little is left of it.
    Cut,
    Hit(SurfacePoint),
    /// A light's surface, where the ray ends.
    Emitter(EmitterPoint),
}

/// Where a ray meets a light's surface.
#[derive(Debug, Clone, Copy)]
pub(super) struct EmitterPoint {
    /// Index into [`crate::scene::Prepared::emitters`].
    pub emitter: usize,
    pub triangle: TriangleId,
    pub departure: Departure,
    /// V.
    pub view: DVec3,
}

impl Tracer<'_> {
    /// Follows `ray` and all that it becomes, depth first, and shows each to `visit` where it
    /// arrives.
    #[inline(always)]
    pub(super) fn walk(
        &self,
        ray: Ray,
        state: &mut TraceState,
        visit: impl FnMut(&Branch, &Arrival, &mut TraceState),
    ) {
        self.walk_from(Branch::from_camera(ray, self.tables.bands), state, visit);
    }

    /// Follows a ray that did not leave the eye.
    #[inline(always)]
    pub(super) fn walk_from(
        &self,
        first: Branch,
        state: &mut TraceState,
        mut visit: impl FnMut(&Branch, &Arrival, &mut TraceState),
    ) {
        state.pending.push(first);
        while let Some(mut branch) = state.pending.pop() {
            let arrival = self.arrive(&mut branch);
            visit(&branch, &arrival, state);
            if let Arrival::Hit(surface) = arrival {
                self.push_children(&surface, branch, state);
            }
        }
    }

    fn arrive(&self, branch: &mut Branch) -> Arrival {
        let Some(hit) = self.prepared.bvh.closest_hit(&branch.ray, branch.leaving) else {
            return Arrival::Missed;
        };
        if let Some(body) = branch.body {
            let absorption = &self.tables.materials[body.0].absorption_per_mm;
            branch.throughput.attenuate(absorption, hit.distance_mm);
            if self.is_cut(&branch.throughput) {
                return Arrival::Cut;
            }
        }
        self.arrival_at(&branch.ray, hit)
    }

    pub(super) fn is_cut(&self, throughput: &Bands) -> bool {
        throughput.is_below(self.limits.min_throughput)
    }

    fn arrival_at(&self, ray: &Ray, hit: Hit) -> Arrival {
        let (object, triangle) = self.prepared.bvh.locate(hit.triangle);
        let view = -ray.direction;
        let departure = self.prepared.bvh.departure(&hit);
        let objects = &self.prepared.scene.objects;
        let Some(object) = objects.get(object) else {
            let emitter = object - objects.len();
            return Arrival::Emitter(EmitterPoint {
                emitter,
                triangle: hit.triangle,
                departure,
                view,
            });
        };
        let outward = departure.n_geom;
        let shading = object.mesh.shading_normal(triangle, [hit.u, hit.v], outward);
        let (side, n_geom, normal) = if outward.dot(view) < 0.0 {
            (Facing::Back, -outward, -shading)
        } else {
            (Facing::Front, outward, shading)
        };
        Arrival::Hit(SurfacePoint {
            triangle: hit.triangle,
            departure,
            material: object.material,
            side,
            normal: if normal.dot(view) < 0.0 { n_geom } else { normal },
            view,
        })
    }
}
