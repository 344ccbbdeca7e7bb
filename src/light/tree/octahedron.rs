//! Directions on the unfolded octahedron |x| + |y| + |z| = 1, and triangles of its grid.

use super::eight::{Eight, Vectors};

/// Vertices of a square grid over the octahedron's map −1 … 1 × −1 … 1.
///
/// The faces are flat, and every triangle lies in one: on it a function that is convex and of
/// degree 1 in the direction is bounded from above by interpolation, and from below by tangents.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct OctahedronGrid {
    /// Cells along an edge of the map, even.
    pub cells: usize,
}

impl OctahedronGrid {
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

    /// The triangles that hold the points, which must lie on the octahedron.
    #[inline(always)]
    pub fn triangles(self, [x, y, z]: &Vectors) -> Triangles {
        let one = Eight::splat(1.0);
        let fold = |along: Eight, other: Eight| {
            let folded = (one - other.abs()).zip(along, f32::copysign);
            z.below(Eight::ZERO, folded, along)
        };
        let half = self.cells as f32 * 0.5;
        let (i, f) = cells((fold(*x, *y) + 1.0) * half, self.cells);
        let (j, h) = cells((fold(*y, *x) + 1.0) * half, self.cells);
        // The fold |u| + |v| = 1 runs along one diagonal in two quadrants, and along the other in
        // the other two; those are mirrored.
        let middle = Eight::splat(half);
        let side = |at: Eight| at.below(middle, Eight::ZERO, one);
        let mirrored = (side(i) - side(j)).abs();
        let f = f + mirrored * (f * -2.0 + 1.0);
        let (near, far) = (i + mirrored, i + one - mirrored);
        let lower = f + h;
        let pick = |below: Eight, above: Eight| lower.below(one, below, above);
        let row = (self.cells + 1) as f32;
        let corners =
            [pick(j * row + near, (j + 1.0) * row + far), j * row + far, (j + 1.0) * row + near];
        let weights = [pick(one - lower, lower + -1.0), pick(f, one - h), pick(h, one - f)];
        Triangles { corners, weights }
    }
}

/// Cell index and place in it.
#[inline(always)]
fn cells(at: Eight, cells: usize) -> (Eight, Eight) {
    const TO_INTEGER: f32 = 12_582_912.0; // 1.5 · 2²³: adding it rounds to an integer
    let index = at.map(|v| (v - 0.5 + TO_INTEGER) - TO_INTEGER);
    let index = index.at_least(0.0).at_most(cells as f32 - 1.0);
    (index, at - index)
}

/// For eight points: vertex indices (whole numbers) and their weights, which sum to 1.
#[derive(Debug, Clone, Copy)]
pub(super) struct Triangles {
    pub corners: [Eight; 3],
    pub weights: [Eight; 3],
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
            let grid = OctahedronGrid { cells: 2 * half_cells };
            let l1 = x.abs() + y.abs() + z.abs();
            prop_assume!(l1 > 1e-3);
            let point = Vec3::new(x, y, z) / l1;
            let triangles = grid.triangles(&[x, y, z].map(|v| Eight::splat(v / l1)));
            let mut sum = Vec3::ZERO;
            for (corner, weight) in triangles.corners.iter().zip(triangles.weights) {
                prop_assert!(weight.0[0] >= -1e-5);
                sum += Vec3::from(grid.vertex(corner.0[0] as usize)) * weight.0[0];
            }
            prop_assert!((sum - point).length() < 1e-5, "{sum} for {point}");
        }
    }
}
