//! The rays of a camera ray's tree, as a figure draws them.

use super::walk::{Arrival, Branch, RayKind};
use super::{TraceState, Tracer};
use crate::geometry::{DVec3, Ray};

/// One ray, from where it starts to what it hits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathSegment {
    /// How it left the surface before.
    pub kind: RayKind,
    /// 0 for the camera ray.
    pub depth: u32,
    /// mm.
    pub start: DVec3,
    /// Unit.
    pub direction: DVec3,
    /// `None` where it leaves the scene, or is cut inside a body.
    pub end: Option<PathEnd>,
    /// The largest band of what the ray still counts for where it ends, 0 to 1.
    pub throughput: f64,
}

/// Where a ray meets a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathEnd {
    /// mm.
    pub point: DVec3,
    /// Unit; the shading normal on the side where the ray arrives.
    pub normal: DVec3,
    /// Index into the scene's objects; behind these come the lights' surfaces.
    pub object: usize,
}

impl Tracer<'_> {
    /// All rays that [`Tracer::trace`] follows for `ray`, in its order.
    pub fn paths(&self, ray: Ray) -> Vec<PathSegment> {
        let mut segments = Vec::new();
        self.walk(ray, &mut TraceState::default(), |branch, arrival, _| {
            segments.push(self.segment(branch, arrival));
        });
        segments
    }

    fn segment(&self, branch: &Branch, arrival: &Arrival) -> PathSegment {
        let end = match arrival {
            Arrival::Missed | Arrival::Cut => None,
            Arrival::Passed(from, _) => Some(PathEnd {
                point: from.departure.point,
                normal: from.departure.n_geom,
                object: self.prepared.bvh.locate(from.triangle).0,
            }),
            Arrival::Hit(surface) => Some(PathEnd {
                point: surface.near.departure.point,
                normal: surface.normal,
                object: surface.object,
            }),
            Arrival::Emitter(at) => Some(PathEnd {
                point: at.departure.point,
                normal: at.departure.n_geom,
                object: self.prepared.bvh.locate(at.triangle).0,
            }),
        };
        let bands = branch.throughput.as_slice();
        PathSegment {
            kind: branch.kind,
            depth: branch.depth,
            start: branch.ray.origin,
            direction: branch.ray.direction,
            end,
            throughput: bands.iter().copied().fold(0.0, f64::max),
        }
    }
}
