//! The walk through the tree of rays that a camera ray becomes (eq. 1).

use super::interface::Interface;
use super::media::Media;
use super::{TraceState, Tracer};
use crate::geometry::{DVec3, Departure, Ray, TriangleId};
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
    /// The bodies that the ray runs in.
    pub media: Media,
    /// Which of the groups of bands (`dispersion`) it carries; `None` before it has split.
    pub group: Option<u32>,
    /// What is left of it in each band, 0 to 1.
    pub throughput: Bands,
}

/// How a ray left the surface before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RayKind {
    /// It left the eye.
    Camera,
    /// A surface mirrored it.
    Mirrored,
    /// It went on through a surface.
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
            media: Media::default(),
            group: None,
            throughput: Bands::one(bands),
        }
    }
}

/// A surface from which rays go on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Leaving {
    pub triangle: TriangleId,
    /// P, and where the rays that leave it start.
    pub departure: Departure,
}

/// A hit with its surface's frame: model.md, "V", "N_g, N".
#[derive(Debug, Clone)]
pub(super) struct SurfacePoint {
    /// For rays on V's side.
    pub near: Leaving,
    /// For rays that pass.
    pub far: Leaving,
    /// Whose material it is.
    pub object: usize,
    pub material: MaterialId,
    pub facing: Facing,
    /// Unit, on V's side (eq. 3).
    pub normal: DVec3,
    /// V.
    pub view: DVec3,
    /// Whose indices are on V's side and beyond; `None` is outside.
    pub indices: [Option<MaterialId>; 2],
    /// The bodies that a ray which passes is in.
    pub after: Media,
    /// Sheets in the same place, through which it passes too.
    pub filters: Vec<MaterialId>,
}

/// Which side of the triangle the ray comes from; counter-clockwise winding is the front.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Facing {
    Front,
    Back,
}

/// What became of a ray.
// One at a time, never in a list: a box would cost more than the room.
#[allow(clippy::large_enum_variant)]
#[derive(Debug, Clone)]
pub(super) enum Arrival {
    Missed,
    /// Too little is left of it.
    Cut,
    /// It goes straight on behind a surface that changes nothing but the bodies that it is in.
    Passed(Leaving, Media),
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
        let media = Media::around(first.ray.origin, self.prepared);
        state.pending.push(Branch { media, ..first });
        while let Some(mut branch) = state.pending.pop() {
            let arrival = self.arrive(&mut branch, state);
            visit(&branch, &arrival, state);
            match arrival {
                Arrival::Hit(surface) => self.push_children(&surface, branch, state),
                Arrival::Passed(from, media) => {
                    branch.ray.origin = from.departure.toward(branch.ray.direction);
                    branch.leaving = Some(from.triangle);
                    branch.media = media;
                    state.pending.push(branch);
                }
                Arrival::Missed | Arrival::Cut | Arrival::Emitter(_) => {}
            }
        }
    }

    fn arrive(&self, branch: &mut Branch, state: &mut TraceState) -> Arrival {
        let reach_mm = self.prepared.surfaces.reach_mm;
        let first = self.prepared.bvh.first_hit(&branch.ray, branch.leaving, reach_mm);
        let Some(first) = first else {
            return Arrival::Missed;
        };
        if let Some(object) = branch.media.medium(self.prepared) {
            let material = self.prepared.surfaces.of_object[object].material;
            let absorption = &self.tables.materials[material.0].absorption_per_mm;
            branch.throughput.attenuate(absorption, first.hit.distance_mm);
            if self.is_cut(&branch.throughput) {
                return Arrival::Cut;
            }
        }
        match self.interface(branch, first, state) {
            Interface::Passed { far, after } => Arrival::Passed(far, after),
            Interface::Met(surface) => Arrival::Hit(surface),
            Interface::Emitter(point) => Arrival::Emitter(point),
        }
    }

    pub(super) fn is_cut(&self, throughput: &Bands) -> bool {
        throughput.is_below(self.limits.min_throughput)
    }
}
