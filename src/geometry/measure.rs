//! How large a mesh is.

use super::{DVec3, Mesh};

impl Mesh {
    /// Area of all triangles, mm².
    pub fn area_mm2(&self) -> f64 {
        let doubled = |at| {
            let [a, b, c] = self.corners(at);
            (b - a).cross(c - a).length()
        };
        (0..self.triangles.len()).map(doubled).sum::<f64>() / 2.0
    }

    /// Volume that the triangles enclose, mm³: positive if their fronts are outside.
    ///
    /// A mesh that is not closed has none: see [`super::Closure`]. Its parts are summed about the
    /// middle of the bounds, one after the other: in parallel the sum would depend on the threads.
    pub fn volume_mm3(&self) -> f64 {
        let [low, high] = self.bounds();
        let middle = (low + high) / 2.0;
        let sixfold = |at| {
            let [a, b, c]: [DVec3; 3] = self.corners(at).map(|corner| corner - middle);
            a.dot(b.cross(c))
        };
        (0..self.triangles.len()).map(sixfold).sum::<f64>() / 6.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cube of 2 mm whose faces have corners of their own.
    fn cube() -> Mesh {
        let mut positions = Vec::new();
        let mut triangles = Vec::new();
        for (axis, sign) in (0..3).flat_map(|axis| [(axis, 1.0), (axis, -1.0)]) {
            let first = positions.len() as u32;
            for [u, v] in [[-1., -1.], [1., -1.], [1., 1.], [-1., 1.]] {
                let mut corner = [0.0; 3];
                corner[axis] = sign;
                corner[(axis + 1) % 3] = u * sign;
                corner[(axis + 2) % 3] = v;
                positions.push(DVec3::from_array(corner) + DVec3::splat(100.0));
            }
            triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
        Mesh::flat("cube", positions, triangles).unwrap()
    }

    #[test]
    fn a_cube_has_the_area_and_volume_of_a_cube() {
        let mut mesh = cube();
        assert!((mesh.area_mm2() - 24.0).abs() < 1e-12);
        assert!((mesh.volume_mm3() - 8.0).abs() < 1e-10);
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        assert!(mesh.volume_mm3() < 0.0);
    }
}
