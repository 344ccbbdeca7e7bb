//! Indexed triangle meshes and their normals (eq. 3).

use super::DVec3;

/// Triangles over shared positions, counter-clockwise from the front. Lengths in mm.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    pub positions: Vec<DVec3>,
    /// Position indices of the corners, 0-based, each < `positions.len()`.
    pub triangles: Vec<[u32; 3]>,
    pub shading: Shading,
}

/// Where the shading normal comes from.
#[derive(Debug, Clone, PartialEq)]
pub enum Shading {
    /// N = N_g (`smooth = false`).
    Flat,
    /// One unit normal a position, used by every face around it.
    PerPosition(Vec<DVec3>),
    /// Unit normals with indices of their own a corner, as OBJ files have them.
    PerCorner { normals: Vec<DVec3>, triangles: Vec<[u32; 3]> },
}
