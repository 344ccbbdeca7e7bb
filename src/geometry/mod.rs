//! Rays, hits, meshes with their normals, OBJ import, the BVH.

pub mod bvh;
mod closure;
pub mod import;
mod measure;
pub mod mesh;
pub mod normals;
pub mod obj;
pub mod polygon;
#[cfg(test)]
#[path = "../../tests/common/random.rs"]
mod random;
pub mod section;
mod weld;

pub use bvh::{Bvh, Departure, FirstHit, Role, Shaft};
pub use closure::Closure;
pub use glam::DVec3;
pub use mesh::Mesh;
pub use section::Plane;

/// A half-line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Where it starts, mm.
    pub origin: DVec3,
    /// Unit to f64.
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
    /// Weight of the second corner (Möller–Trumbore), which feeds eq. 3.
    pub u: f64,
    /// Weight of the third corner.
    pub v: f64,
    /// The triangle that is met.
    pub triangle: TriangleId,
}
