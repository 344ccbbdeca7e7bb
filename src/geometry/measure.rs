//! How large a mesh is.

use super::mesh::Shading;
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

    /// Share of the area from which on opposed normals are told of: a few come from rounding.
    pub const OPPOSED_SHARE: f64 = 0.01;

    /// Share of the area, 0 to 1, whose interpolated normals look to the back: rays find the face's
    /// front and no normal of its side, so that it is shaded flat (eq. 3). Told by 10,000 triangles.
    pub fn opposed_share(&self) -> f64 {
        const TRIANGLES: usize = 10_000;
        const MIDDLE: [f64; 2] = [1.0 / 3.0; 2];
        if self.shading == Shading::Flat {
            return 0.0;
        }
        let step = self.triangles.len().div_ceil(TRIANGLES);
        let (mut opposed, mut all) = (0.0, 0.0);
        for at in (0..self.triangles.len()).step_by(step) {
            let [a, b, c] = self.corners(at);
            let across = (b - a).cross(c - a);
            let n_geom = self.geometric_normal(at);
            all += across.length();
            if self.shading_normal(at, MIDDLE, n_geom).dot(n_geom) < 0.0 {
                opposed += across.length();
            }
        }
        if all > 0.0 { opposed / all } else { 0.0 }
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

    #[test]
    fn normals_that_oppose_the_winding_are_told_by_area() {
        let cube = cube();
        let normals = cube.vertex_normals();
        assert_eq!(cube.opposed_share(), 0.0, "flat");
        let mut mesh = Mesh { shading: Shading::PerPosition(normals), ..cube };
        assert_eq!(mesh.opposed_share(), 0.0);
        mesh.triangles[..3].iter_mut().for_each(|t| t.swap(1, 2));
        assert!((mesh.opposed_share() - 0.25).abs() < 1e-12, "3 of 12 equal triangles");
    }
}
