//! Directions on the unfolded octahedron |x| + |y| + |z| = 1, and triangles of its grid.

/// Vertices of a square grid over the octahedron's map −1 … 1 × −1 … 1.
///
/// The faces are flat, and every triangle lies in one: on it a function that is convex and of
/// degree 1 in the direction is bounded from above by interpolation, and from below by tangents.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Grid {
    /// Cells along an edge of the map, even.
    pub cells: usize,
}

impl Grid {
    pub fn vertices(self) -> usize {
        (self.cells + 1) * (self.cells + 1)
    }

    /// On the octahedron, not on the sphere.
    pub fn vertex(self, index: usize) -> [f32; 3] {
        let along = |i: usize| 2.0 * i as f32 / self.cells as f32 - 1.0;
        let (u, v) = (along(index % (self.cells + 1)), along(index / (self.cells + 1)));
        let z = 1.0 - u.abs() - v.abs();
        if z >= 0.0 {
            [u, v, z]
        } else {
            [(1.0 - v.abs()).copysign(u), (1.0 - u.abs()).copysign(v), z]
        }
    }

    /// The triangle that holds the point, which must lie on the octahedron.
    #[inline(always)]
    pub fn triangle(self, [x, y, z]: [f32; 3]) -> Triangle {
        let folded = z < 0.0;
        let u = if folded { (1.0 - y.abs()).copysign(x) } else { x };
        let v = if folded { (1.0 - x.abs()).copysign(y) } else { y };
        let half = self.cells as f32 * 0.5;
        let (i, f) = cell((u + 1.0) * half, self.cells);
        let (j, h) = cell((v + 1.0) * half, self.cells);
        // The fold |u| + |v| = 1 runs along one diagonal in two quadrants, and along the other in
        // the other two; those are mirrored.
        let mirrored = (i < self.cells / 2) != (j < self.cells / 2);
        let (near, far) = if mirrored { (i + 1, i) } else { (i, i + 1) };
        let f = if mirrored { 1.0 - f } else { f };
        let row = self.cells + 1;
        let lower = f + h < 1.0;
        let corner = if lower { j * row + near } else { (j + 1) * row + far };
        let weights = if lower { [1.0 - f - h, f, h] } else { [f + h - 1.0, 1.0 - h, 1.0 - f] };
        Triangle { corners: [corner, j * row + far, (j + 1) * row + near], weights }
    }
}

/// Cell index and place in it.
#[inline(always)]
fn cell(at: f32, cells: usize) -> (usize, f32) {
    let index = (at as usize).min(cells - 1);
    (index, at - index as f32)
}

/// Vertex indices and their weights, which sum to 1.
#[derive(Debug, Clone, Copy)]
pub(super) struct Triangle {
    pub corners: [usize; 3],
    pub weights: [f32; 3],
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn interpolated_vertices_give_the_point_back(
            x in -1.0f32..1.0, y in -1.0f32..1.0, z in -1.0f32..1.0, half_cells in 1usize..20,
        ) {
            let grid = Grid { cells: 2 * half_cells };
            let l1 = x.abs() + y.abs() + z.abs();
            prop_assume!(l1 > 1e-3);
            let point = Vec3::new(x, y, z) / l1;
            let triangle = grid.triangle(point.into());
            let mut sum = Vec3::ZERO;
            for (corner, weight) in triangle.corners.iter().zip(triangle.weights) {
                prop_assert!(weight >= -1e-5);
                sum += Vec3::from(grid.vertex(*corner)) * weight;
            }
            prop_assert!((sum - point).length() < 1e-5, "{sum} for {point}");
        }
    }
}
