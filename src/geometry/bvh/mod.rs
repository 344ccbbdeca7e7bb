//! The bounding volume hierarchy: which triangle a ray meets first, and whether any is in its way.

mod binary;
mod bounds;
mod departure;
mod probe;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use super::{DVec3, Hit, Mesh, Ray, TriangleId};
use binary::{BinaryNode, Primitive};
use bounds::{Box3, Frame};
pub use departure::Departure;
use probe::{Crossing, Probe};

/// All triangles of a scene, ordered for rays. Shares the meshes, never copies their positions.
#[derive(Debug, Clone)]
pub struct Bvh {
    meshes: Vec<Arc<Mesh>>,
    /// Number of the first triangle of each mesh, and the count of all.
    first_triangles: Vec<u32>,
    low: DVec3,
    high: DVec3,
    frame: Frame,
    nodes: Vec<BinaryNode>,
    triangles: Vec<u32>,
}

impl Bvh {
    /// Orders the triangles of all objects. The same meshes give the same tree on any number of
    /// threads. Degenerate triangles stay numbered and are never met.
    pub fn build(meshes: &[Arc<Mesh>]) -> Bvh {
        let mut first_triangles = vec![0u32];
        for mesh in meshes {
            let last = first_triangles[first_triangles.len() - 1];
            first_triangles.push(last + mesh.triangles.len() as u32);
        }
        let mut low = DVec3::INFINITY;
        let mut high = DVec3::NEG_INFINITY;
        for mesh in meshes {
            for corners in sound_triangles(mesh).map(|(_, corners)| corners) {
                for corner in corners {
                    low = low.min(corner);
                    high = high.max(corner);
                }
            }
        }
        let frame = Frame::new(low, high);
        let mut primitives: Vec<Primitive> = Vec::new();
        for (mesh, first) in meshes.iter().zip(&first_triangles) {
            primitives.extend(sound_triangles(mesh).map(|(index, corners)| Primitive {
                bounds: frame.box_of(corners),
                triangle: first + index,
            }));
        }
        let nodes = binary::build(&mut primitives);
        let triangles = primitives.iter().map(|p| p.triangle).collect();
        let meshes = meshes.to_vec();
        Bvh { meshes, first_triangles, low, high, frame, nodes, triangles }
    }

    /// The nearest triangle that the ray meets, on either side, but not `leaving`. Of triangles at
    /// exactly the same distance it is that with the lower number.
    pub fn closest_hit(&self, ray: &Ray, leaving: Option<TriangleId>) -> Option<Hit> {
        let probe = self.probe(ray)?;
        let mut best: Option<(Crossing, u32)> = None;
        self.visit(&probe, f64::INFINITY, |triangle| {
            if leaving != Some(TriangleId(triangle))
                && let Some(found) = probe.cross(self.corners(TriangleId(triangle)))
                && best.is_none_or(|(b, id)| (found.t_mm, triangle) < (b.t_mm, id))
            {
                best = Some((found, triangle));
            }
            best.map_or(f64::INFINITY, |(b, _)| b.t_mm)
        });
        best.map(|(crossing, triangle)| Hit {
            distance_mm: crossing.t_mm + probe.advance_mm,
            u: crossing.u,
            v: crossing.v,
            triangle: TriangleId(triangle),
        })
    }

    /// Whether a triangle lies strictly between `from` and `target`, of those objects for which
    /// `blocks` (one a mesh) is true. `from` is a [`Departure`]'s, `leaving` the triangle left.
    pub fn is_occluded(
        &self,
        from: DVec3,
        target: DVec3,
        leaving: Option<TriangleId>,
        blocks: &[bool],
    ) -> bool {
        let Some((ray, length_mm)) = self.segment(from, target) else { return false };
        let Some(probe) = self.probe(&ray) else { return false };
        let end_mm = length_mm - probe.advance_mm;
        let mut is_hidden = false;
        self.visit(&probe, end_mm, |triangle| {
            let id = TriangleId(triangle);
            is_hidden = is_hidden
                || (leaving != Some(id)
                    && blocks[self.locate(id).0]
                    && probe.cross(self.corners(id)).is_some_and(|found| found.t_mm < end_mm));
            if is_hidden { -1.0 } else { end_mm }
        });
        is_hidden
    }

    /// Object and index in its mesh of a triangle.
    pub fn locate(&self, triangle: TriangleId) -> (usize, usize) {
        let object = self.first_triangles.partition_point(|&first| first <= triangle.0) - 1;
        (object, (triangle.0 - self.first_triangles[object]) as usize)
    }

    /// Corners of a triangle, mm.
    #[inline]
    pub fn corners(&self, triangle: TriangleId) -> [DVec3; 3] {
        let (object, index) = self.locate(triangle);
        let mesh = &self.meshes[object];
        mesh.triangles[index].map(|position| mesh.positions[position as usize])
    }

    /// Lowest and highest corner of the scene, mm; `None` if no triangle has an area.
    pub fn bounds(&self) -> Option<(DVec3, DVec3)> {
        (!self.triangles.is_empty()).then_some((self.low, self.high))
    }

    /// Memory of the tree, without the meshes.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.triangles[..])
    }

    fn radius_mm(&self) -> f64 {
        self.frame.radius_mm
    }

    /// `None` if the ray passes the scene by.
    fn probe(&self, ray: &Ray) -> Option<Probe> {
        if self.triangles.is_empty() {
            return None;
        }
        let to_center = self.frame.center - ray.origin;
        let along_mm = to_center.dot(ray.direction);
        let beside = to_center - ray.direction * along_mm;
        // The sphere, and what rounding far away may take from the distance to it.
        let reach_mm = self.frame.radius_mm * (1.0 + 1e-6)
            + 8.0 * f64::EPSILON * (along_mm.abs() + ray.origin.length());
        // Negated so that rays with NaN end here.
        if !(beside.length_squared() <= reach_mm * reach_mm && along_mm >= -reach_mm) {
            return None;
        }
        Some(Probe::new(ray, (along_mm - reach_mm).max(0.0)))
    }

    /// The ray to `target` and its length, a little before the target so that a surface on which
    /// the target lies doesn't hide it.
    fn segment(&self, from: DVec3, target: DVec3) -> Option<(Ray, f64)> {
        let path = target - from;
        let length_mm = path.length();
        let scale_mm = target.abs().max_element() + 2.0 * self.radius_mm() + length_mm;
        let margin_mm = departure::LIFT * 0.5 * f64::EPSILON * scale_mm;
        (length_mm > margin_mm)
            .then(|| (Ray { origin: from, direction: path / length_mm }, length_mm - margin_mm))
    }

    /// Calls `visit` with every triangle whose box the probe meets before the distance that `visit`
    /// last returned, beginning with `end_mm`.
    fn visit(&self, probe: &Probe, mut end_mm: f64, mut visit: impl FnMut(u32) -> f64) {
        let origin = self.frame.to_frame(probe.origin);
        let inverse = probe.direction.to_array().map(|d| {
            let d = d as f32;
            1.0 / if d.abs() < 1e-18 { 1e-18f32.copysign(d) } else { d }
        });
        let mut stack = vec![0usize];
        while let Some(index) = stack.pop() {
            let node = &self.nodes[index];
            if !meets(&node.bounds, origin, inverse, (end_mm * self.frame.per_mm) as f32) {
                continue;
            }
            match node.children() {
                None => end_mm = visit(self.triangles[node.first as usize]),
                Some([left, right]) => stack.extend([index + right, index + left]),
            }
        }
    }
}

fn meets(bounds: &Box3, origin: [f32; 3], inverse: [f32; 3], end: f32) -> bool {
    let mut near = 0.0f32;
    let mut far = end.next_up();
    for axis in 0..3 {
        let a = (bounds.low[axis] - origin[axis]) * inverse[axis];
        let b = (bounds.high[axis] - origin[axis]) * inverse[axis];
        near = near.max(a.min(b));
        far = far.min(a.max(b));
    }
    near <= far
}

/// Index and corners of the triangles that can be met.
fn sound_triangles(mesh: &Mesh) -> impl Iterator<Item = (u32, [DVec3; 3])> {
    (0..).zip(&mesh.triangles).filter_map(|(index, triangle)| {
        let corners = triangle.map(|position| mesh.positions[position as usize]);
        (!probe::is_degenerate(corners)).then_some((index, corners))
    })
}
