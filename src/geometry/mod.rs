//! Rays, hits, meshes with their normals, OBJ import, the BVH.

pub mod bvh;
pub mod mesh;
pub mod obj;
pub mod section;

pub use bvh::{Bvh, Departure};
pub use glam::DVec3;
pub use mesh::Mesh;
pub use section::Plane;

/// A half-line. `direction` is unit to f64.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    pub origin: DVec3,
    pub direction: DVec3,
}

/// A triangle of a scene: triangles are numbered through all objects in their order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TriangleId(pub u32);

/// Where a ray meets a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Along the ray from its origin, mm, > 0.
    pub distance_mm: f64,
    /// Weights of the second and third corner (Möller–Trumbore), which feed eq. 3.
    pub u: f64,
    pub v: f64,
    pub triangle: TriangleId,
}
