//! The rays of a camera ray's tree, as a figure draws them.

use super::{Arrival, Branch, SurfacePoint, TraceState, Tracer};
use crate::geometry::{DVec3, Ray};

/// One ray, from where it starts to what it hits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathSegment {
    pub kind: PathKind,
    /// 0 for the camera ray.
    pub depth: u32,
    pub start: DVec3,
    /// Unit.
    pub direction: DVec3,
    /// `None` where it leaves the scene, or is cut inside a body.
    pub end: Option<PathEnd>,
    /// The largest band of what the ray still counts for where it ends, 0 to 1.
    pub throughput: f64,
}

/// How a ray left the surface before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PathKind {
    Camera,
    Mirrored,
    Transmitted,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathEnd {
    pub point: DVec3,
    /// Shading normal on the side where the ray arrives.
    pub normal: DVec3,
    /// Index into the scene's objects.
    pub object: usize,
}

impl Tracer<'_> {
    /// All rays that [`Tracer::trace`] follows for `ray`.
    pub fn paths(&self, ray: Ray) -> Vec<PathSegment> {
        let mut state = TraceState::default();
        state.pending.push(Branch::from_camera(ray, self.tables.bands));
        let mut kinds = vec![PathKind::Camera];
        let mut segments = Vec::new();
        while let (Some(mut branch), Some(kind)) = (state.pending.pop(), kinds.pop()) {
            let arrival = self.arrive(&mut branch);
            segments.push(self.segment(kind, &branch, &arrival));
            if let Arrival::Hit(surface) = arrival {
                let before = state.pending.len();
                self.push_children(&surface, branch, &mut state);
                kinds.extend(state.pending[before..].iter().map(|child| kind_of(child, &surface)));
            }
        }
        segments
    }

    fn segment(&self, kind: PathKind, branch: &Branch, arrival: &Arrival) -> PathSegment {
        let end = match arrival {
            Arrival::Missed | Arrival::Cut => None,
            Arrival::Hit(surface) => Some(PathEnd {
                point: surface.departure.point,
                normal: surface.normal,
                object: self.prepared.bvh.locate(surface.triangle).0,
            }),
        };
        let bands = branch.throughput.as_slice();
        PathSegment {
            kind,
            depth: branch.depth,
            start: branch.ray.origin,
            direction: branch.ray.direction,
            end,
            throughput: bands.iter().copied().fold(0.0, f64::max),
        }
    }
}

/// Mirrored rays leave on the viewer's side of N, transmitted ones on the other.
fn kind_of(child: &Branch, surface: &SurfacePoint) -> PathKind {
    if child.ray.direction.dot(surface.normal) > 0.0 {
        PathKind::Mirrored
    } else {
        PathKind::Transmitted
    }
}
