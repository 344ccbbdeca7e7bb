//! Indexed triangle meshes and their normals (eq. 3).

use glam::{DAffine3, DQuat};

use super::DVec3;
use crate::error::{Error, Result};

/// Triangles over shared positions, counter-clockwise from the front. Lengths in mm.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    /// Corners of the triangles, mm, finite.
    pub positions: Vec<DVec3>,
    /// Position indices of the corners, 0-based, each < `positions.len()`.
    pub triangles: Vec<[u32; 3]>,
    /// Where the shading normals come from.
    pub shading: Shading,
}

/// Where the shading normal comes from.
#[derive(Debug, Clone, PartialEq)]
pub enum Shading {
    /// N = N_g (`smooth = false`).
    Flat,
    /// One unit normal a position, used by every face around it; zero where N_g is to be used.
    PerPosition(Vec<DVec3>),
    /// Normals with indices of their own a corner, as OBJ files have them.
    PerCorner {
        /// Unit; zero where N_g is to be used.
        normals: Vec<DVec3>,
        /// One a triangle of the mesh: which normal each corner has.
        triangles: Vec<[u32; 3]>,
    },
}

/// A direction of the coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// To the viewer's right.
    X,
    /// Up.
    Y,
    /// Out of the lamp.
    Z,
}

/// How a mesh is placed in the scene: mirrored, then scaled, then turned, then moved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// The coordinate that changes its sign; fronts stay fronts.
    pub mirror: Option<Axis>,
    /// > 0.
    pub scale: f64,
    /// Right-handed.
    pub rotation: DQuat,
    /// mm.
    pub translation: DVec3,
}

impl Default for Placement {
    fn default() -> Self {
        Self { mirror: None, scale: 1.0, rotation: DQuat::IDENTITY, translation: DVec3::ZERO }
    }
}

impl Placement {
    /// The map from the mesh's own coordinates to the scene's.
    pub fn affine(&self) -> DAffine3 {
        DAffine3::from_scale_rotation_translation(
            self.signs() * self.scale,
            self.rotation,
            self.translation,
        )
    }

    /// −1 for the coordinate that is mirrored, else 1.
    fn signs(&self) -> DVec3 {
        match self.mirror {
            None => DVec3::ONE,
            Some(Axis::X) => DVec3::new(-1.0, 1.0, 1.0),
            Some(Axis::Y) => DVec3::new(1.0, -1.0, 1.0),
            Some(Axis::Z) => DVec3::new(1.0, 1.0, -1.0),
        }
    }
}

impl Mesh {
    /// A mesh whose normals are the angle-weighted means of the adjoining faces'.
    ///
    /// Errors: no triangles, a position that is not finite, an index out of range, more than 2³²
    /// positions; `what` names the mesh in the message.
    pub fn smooth(what: &str, positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Result<Self> {
        let mesh = Self::flat(what, positions, triangles)?;
        let normals = mesh.vertex_normals();
        Ok(Self { shading: Shading::PerPosition(normals), ..mesh })
    }

    /// A mesh whose shading normals are the geometric ones. Errors: as [`Mesh::smooth`].
    pub fn flat(what: &str, positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Result<Self> {
        if triangles.is_empty() {
            return Err(Error::inconsistent(what, "no triangles"));
        }
        let mesh = Self { positions, triangles, shading: Shading::Flat };
        mesh.check_positions(what)?;
        let count = mesh.positions.len();
        for (at, triangle) in mesh.triangles.iter().enumerate() {
            if let Some(&index) = triangle.iter().find(|&&i| i as usize >= count) {
                return Err(Error::out_of_range(
                    what,
                    &format!("index of triangle {}", at + 1),
                    u64::from(index) + 1,
                    format!("1 to {count}"),
                ));
            }
        }
        Ok(mesh)
    }

    /// The grid (i/nu, j/nv), 0 ≤ i ≤ nu, 0 ≤ j ≤ nv, row by row; cells with a corner that is
    /// `None` are left out. The front is the side from which u runs right and v up.
    pub fn from_grid(what: &str, nu: usize, nv: usize, points: &[Option<DVec3>]) -> Result<Self> {
        debug_assert_eq!(points.len(), (nu + 1) * (nv + 1));
        let mut index = vec![u32::MAX; points.len()];
        let mut positions = Vec::new();
        for (slot, point) in index.iter_mut().zip(points) {
            if let Some(point) = point {
                *slot = positions.len() as u32;
                positions.push(*point);
            }
        }
        let mut triangles = Vec::with_capacity(2 * nu * nv);
        for j in 0..nv {
            for i in 0..nu {
                let at = |i: usize, j: usize| index[j * (nu + 1) + i];
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                if [a, b, c, d].iter().all(|&corner| corner != u32::MAX) {
                    triangles.extend([[a, b, c], [a, c, d]]);
                }
            }
        }
        Self::smooth(what, positions, triangles)
    }

    /// All parts in one, each with its own positions and normals.
    ///
    /// Errors: no parts.
    pub fn merged(what: &str, parts: &[&Self]) -> Result<Self> {
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        let (mut normals, mut normal_triangles) = (Vec::new(), Vec::new());
        for part in parts {
            let shift = |by: usize| move |corners: &[u32; 3]| corners.map(|i| i + by as u32);
            triangles.extend(part.triangles.iter().map(shift(positions.len())));
            positions.extend(&part.positions);
            let first = normals.len();
            match &part.shading {
                // Zero stands for N_g.
                Shading::Flat => {
                    normals.push(DVec3::ZERO);
                    normal_triangles.extend(vec![[first as u32; 3]; part.triangles.len()]);
                }
                Shading::PerPosition(own) => {
                    normals.extend(own);
                    normal_triangles.extend(part.triangles.iter().map(shift(first)));
                }
                Shading::PerCorner { normals: own, triangles } => {
                    normals.extend(own);
                    normal_triangles.extend(triangles.iter().map(shift(first)));
                }
            }
        }
        let mesh = Self::flat(what, positions, triangles)?;
        Ok(Self { shading: Shading::PerCorner { normals, triangles: normal_triangles }, ..mesh })
    }

    /// Corners of a triangle in their order, mm.
    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|i| self.positions[i as usize])
    }

    /// N_g, unit; zero for a degenerate triangle.
    pub fn geometric_normal(&self, triangle: usize) -> DVec3 {
        let [a, b, c] = self.corners(triangle);
        unit_cross(b - a, c - a)
    }

    /// N of eq. 3 at (u, v), unit, on the side where the vertex normals are.
    pub fn shading_normal(&self, triangle: usize, [u, v]: [f64; 2], n_geom: DVec3) -> DVec3 {
        let [n0, n1, n2] = match &self.shading {
            Shading::Flat => return n_geom,
            Shading::PerPosition(normals) => self.triangles[triangle].map(|i| normals[i as usize]),
            Shading::PerCorner { normals, triangles } => {
                triangles[triangle].map(|i| normals[i as usize])
            }
        }
        .map(|n| if n == DVec3::ZERO { n_geom } else { n });
        let n = n0 * (1.0 - u - v) + n1 * u + n2 * v;
        n.try_normalize().unwrap_or(n_geom)
    }

    /// Mean of the adjoining faces' unit normals, weighted by the angle at the vertex, over the
    /// faces that share the position's index; zero where they cancel.
    pub fn vertex_normals(&self) -> Vec<DVec3> {
        let mut normals = vec![DVec3::ZERO; self.positions.len()];
        for (triangle, places) in self.triangles.iter().enumerate() {
            let n_geom = self.geometric_normal(triangle);
            let corners = self.corners(triangle);
            for (k, &place) in places.iter().enumerate() {
                let [here, next, last] = [0, 1, 2].map(|step| corners[(k + step) % 3]);
                normals[place as usize] += n_geom * angle_between(next - here, last - here);
            }
        }
        normals.iter().map(|n| n.try_normalize().unwrap_or(DVec3::ZERO)).collect()
    }

    /// Fronts become backs: what bounds a hollow.
    pub fn turned_inside_out(self) -> Self {
        let flipped = |triangles: Vec<[u32; 3]>| {
            triangles.into_iter().map(|[a, b, c]| [a, c, b]).collect::<Vec<_>>()
        };
        let opposite = |normals: Vec<DVec3>| normals.into_iter().map(|n| -n).collect::<Vec<_>>();
        let shading = match self.shading {
            Shading::Flat => Shading::Flat,
            Shading::PerPosition(normals) => Shading::PerPosition(opposite(normals)),
            Shading::PerCorner { normals, triangles } => {
                Shading::PerCorner { normals: opposite(normals), triangles: flipped(triangles) }
            }
        };
        Self { positions: self.positions, triangles: flipped(self.triangles), shading }
    }

    /// The same triangles without interpolated normals, for Fig. 5.
    pub fn into_flat(self) -> Self {
        Self { shading: Shading::Flat, ..self }
    }

    /// The mesh in another place; its normals stay unit, its fronts fronts.
    pub fn transformed(&self, placement: &Placement) -> Self {
        let world_from_local = placement.affine();
        let turn = |normals: &[DVec3]| {
            let signs = placement.signs();
            normals.iter().map(|&n| placement.rotation * (signs * n)).collect()
        };
        // Seen in a mirror, corners run the other way.
        let wind = |triangles: &[[u32; 3]]| match placement.mirror {
            None => triangles.to_vec(),
            Some(_) => triangles.iter().map(|&[a, b, c]| [a, c, b]).collect(),
        };
        let move_to = |&p: &DVec3| world_from_local.transform_point3(p);
        Self {
            positions: self.positions.iter().map(move_to).collect(),
            triangles: wind(&self.triangles),
            shading: match &self.shading {
                Shading::Flat => Shading::Flat,
                Shading::PerPosition(normals) => Shading::PerPosition(turn(normals)),
                Shading::PerCorner { normals, triangles } => {
                    Shading::PerCorner { normals: turn(normals), triangles: wind(triangles) }
                }
            },
        }
    }

    /// Errors: a position that is not finite; `what` names the mesh in the message.
    pub fn check_positions(&self, what: &str) -> Result<()> {
        self.positions.iter().position(|p| !p.is_finite()).map_or(Ok(()), |at| {
            let position = format!("position {}", at + 1);
            Err(Error::out_of_range(what, &position, self.positions[at], "finite numbers"))
        })
    }

    /// Smallest and largest coordinates, mm.
    pub fn bounds(&self) -> [DVec3; 2] {
        self.positions.iter().fold(
            [DVec3::splat(f64::INFINITY), DVec3::splat(f64::NEG_INFINITY)],
            |[low, high], &p| [low.min(p), high.max(p)],
        )
    }
}

/// Direction of a × b for vectors of any length, or zero: scaled first, so that products of
/// lengths from 1e-150 mm on neither vanish nor overflow.
fn unit_cross(a: DVec3, b: DVec3) -> DVec3 {
    let (la, lb) = (a.abs().max_element(), b.abs().max_element());
    if la == 0.0 || lb == 0.0 {
        return DVec3::ZERO;
    }
    (a / la).cross(b / lb).try_normalize().unwrap_or(DVec3::ZERO)
}

/// Angle between two vectors, 0 to π, exact for slivers too: atan2 loses nothing near 0 and π.
fn angle_between(a: DVec3, b: DVec3) -> f64 {
    let (a, b) = (a.normalize_or_zero(), b.normalize_or_zero());
    a.cross(b).length().atan2(a.dot(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn v(x: f64, y: f64, z: f64) -> DVec3 {
        DVec3::new(x, y, z)
    }

    /// At a cube's corner the three faces weigh the same however they are cut into triangles.
    #[test]
    fn angle_weights_do_not_see_the_triangulation() {
        let positions = vec![
            v(0., 0., 0.),
            v(1., 0., 0.),
            v(1., 1., 0.),
            v(0., 1., 0.),
            v(0., 0., 1.),
            v(1., 0., 1.),
            v(0., 1., 1.),
        ];
        // The face z = 0 is cut through the corner, the other two are not.
        let triangles = vec![[0, 2, 1], [0, 3, 2], [0, 1, 4], [1, 5, 4], [0, 4, 3], [4, 6, 3]];
        let mesh = Mesh::smooth("cube", positions, triangles).unwrap();
        let Shading::PerPosition(normals) = &mesh.shading else { panic!() };
        assert!((normals[0] - DVec3::splat(-1.0 / 3f64.sqrt())).length() < 1e-15);
    }

    #[test]
    fn degenerate_triangles_and_cancelling_normals_fall_back() {
        let positions = vec![v(0., 0., 0.), v(1., 0., 0.), v(0., 1., 0.)];
        let both_sides =
            Mesh::smooth("m", positions, vec![[0, 1, 2], [0, 2, 1], [0, 0, 1]]).unwrap();
        assert_eq!(both_sides.geometric_normal(2), DVec3::ZERO);
        let n_geom = both_sides.geometric_normal(0);
        assert_eq!(both_sides.shading_normal(0, [0.2, 0.3], n_geom), n_geom);
    }

    #[test]
    fn normals_hold_from_tiny_to_huge() {
        for scale in [1e-140, 1e-6, 1.0, 1e9, 1e140] {
            let positions = [v(0., 0., 0.), v(scale, 0., 0.), v(0., scale, 0.)].to_vec();
            let mesh = Mesh::smooth("m", positions, vec![[0, 1, 2]]).unwrap();
            assert_eq!(mesh.shading_normal(0, [0.3, 0.3], mesh.geometric_normal(0)), DVec3::Z);
        }
    }

    #[test]
    fn bad_meshes_are_refused() {
        let message = |r: Result<Mesh>| r.unwrap_err().to_string();
        assert_eq!(message(Mesh::flat("mesh", vec![], vec![])), "mesh: no triangles");
        assert_eq!(
            message(Mesh::flat("mesh", vec![DVec3::X], vec![[0, 0, 1]])),
            "mesh: index of triangle 1 is 2, allowed: 1 to 1"
        );
        assert_eq!(
            message(Mesh::flat("mesh", vec![v(f64::NAN, 0., 0.)], vec![[0, 0, 0]])),
            "mesh: position 1 is [NaN, 0, 0], allowed: finite numbers"
        );
    }

    #[test]
    fn a_mirrored_mesh_keeps_its_fronts_outside() {
        let positions = vec![v(0., 0., 0.), v(2., 0., 0.), v(0., 3., 0.), v(0., 0., 5.)];
        let triangles = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let mesh = Mesh::smooth("m", positions, triangles).unwrap();
        for axis in [Axis::X, Axis::Y, Axis::Z] {
            let placement = Placement { mirror: Some(axis), ..Placement::default() };
            let mirrored = mesh.transformed(&placement);
            assert_eq!(mirrored.volume_mm3(), mesh.volume_mm3());
            let signs = placement.signs();
            for triangle in 0..4 {
                let n_geom = mesh.geometric_normal(triangle);
                assert_eq!(mirrored.geometric_normal(triangle), signs * n_geom);
                let normal = mesh.shading_normal(triangle, [0.25, 0.5], n_geom);
                let turned = mirrored.shading_normal(triangle, [0.5, 0.25], signs * n_geom);
                assert!((turned - signs * normal).length() < 1e-15);
            }
            assert_eq!(mirrored.transformed(&placement), mesh);
        }
    }

    #[test]
    fn grid_leaves_out_cells_with_a_missing_corner() {
        let mut points: Vec<_> =
            (0..9).map(|k| Some(v(f64::from(k % 3), f64::from(k / 3), 0.))).collect();
        let whole = Mesh::from_grid("g", 2, 2, &points).unwrap();
        assert_eq!(whole.triangles.len(), 8);
        assert_eq!(whole.geometric_normal(0), DVec3::Z);
        points[8] = None;
        assert_eq!(Mesh::from_grid("g", 2, 2, &points).unwrap().triangles.len(), 6);
    }
}
