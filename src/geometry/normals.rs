//! Vertex normals where a mesh has none of its own (eq. 3): smooth, and sharp at creases.

use std::f64::consts::PI;

use super::{DVec3, Mesh};
use crate::geometry::mesh::Shading;

/// Which faces around a vertex share a normal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Smoothing {
    /// Those that a chain of angles within the crease angle joins.
    ByCrease,
    /// None (`s off`): each face is flat.
    Off,
    /// Those of the same smoothing group, whatever their angle.
    Group(u32),
}

/// Stands for N_g.
const FLAT: u32 = u32::MAX;

/// Angles between faces that are equal to the crease angle count as smooth: cosines are off by this.
const ROUNDING: f64 = 1e-9;

/// More faces around a vertex are first gathered by direction, so that the work does not grow as
/// their square.
const MANY: usize = 256;

/// Normals for a mesh that has none: the mean of the faces around a vertex, weighted by their angles,
/// over those that `smoothing` lets share it.
///
/// `smoothing` holds pairs of a triangle and what holds from it on; before the first it is
/// [`Smoothing::ByCrease`].
pub fn creased(mesh: &Mesh, crease_deg: f64, smoothing: &[(u32, Smoothing)]) -> Shading {
    let of_triangle = expand(smoothing, mesh.triangles.len());
    let n_geom: Vec<DVec3> =
        (0..mesh.triangles.len()).map(|triangle| unit_normal(mesh, triangle)).collect();
    let fans = Fans::new(mesh);
    let mut sharing = Sharing {
        cos_crease: crease_deg.to_radians().cos() - ROUNDING,
        n_geom: &n_geom,
        smoothing: &of_triangle,
        leaders: Vec::new(),
    };
    // While each position has one normal, they have the same numbers.
    let one_each = (0..mesh.positions.len()).position(|p| !sharing.is_one(fans.around(p)));
    let Some(first_split) = one_each else {
        return Shading::PerPosition(means(mesh, &mesh.triangles, mesh.positions.len(), &n_geom));
    };
    let mut corners = mesh.triangles.clone();
    let mut count = first_split as u32;
    for position in first_split..mesh.positions.len() {
        count += sharing.number(fans.around(position), count, &mut corners);
    }
    drop(fans);
    shading(mesh, corners, count as usize, &n_geom)
}

/// N_g; by way of [`Mesh::geometric_normal`] where products of lengths vanish or overflow.
fn unit_normal(mesh: &Mesh, triangle: usize) -> DVec3 {
    let [a, b, c] = mesh.corners(triangle);
    let across = (b - a).cross(c - a);
    let square = across.length_squared();
    if square > 1e-280 && square < 1e280 {
        return across / square.sqrt();
    }
    mesh.geometric_normal(triangle)
}

fn shading(mesh: &Mesh, mut corners: Vec<[u32; 3]>, count: usize, n_geom: &[DVec3]) -> Shading {
    // One more, which stays zero.
    for corner in corners.as_flattened_mut() {
        *corner = (*corner).min(count as u32);
    }
    let mut normals = means(mesh, &corners, count + 1, n_geom);
    normals[count] = DVec3::ZERO;
    Shading::PerCorner { normals, triangles: corners }
}

/// `count` normals: each the mean of the faces whose corners have its number in `corners`, weighted by
/// the angle there; zero where they cancel.
///
/// Its bits are not those of [`Mesh::vertex_normals`]: two arcs a triangle make three angles.
fn means(mesh: &Mesh, corners: &[[u32; 3]], count: usize, n_geom: &[DVec3]) -> Vec<DVec3> {
    let mut normals = vec![DVec3::ZERO; count];
    for (triangle, numbers) in corners.iter().enumerate() {
        let angles = angles(mesh.corners(triangle));
        for (&number, angle) in numbers.iter().zip(angles) {
            normals[number as usize] += n_geom[triangle] * angle;
        }
    }
    normals.iter_mut().for_each(|n| *n = n.try_normalize().unwrap_or(DVec3::ZERO));
    normals
}

/// A triangle's angles. The sine of each times its sides is twice the area.
fn angles([a, b, c]: [DVec3; 3]) -> [f64; 3] {
    let (ab, ac, bc) = (b - a, c - a, c - b);
    let doubled_area = ab.cross(ac).length();
    let at_a = doubled_area.atan2(ab.dot(ac));
    let at_b = doubled_area.atan2(-ab.dot(bc));
    [at_a, at_b, (PI - at_a - at_b).max(0.0)]
}

fn expand(smoothing: &[(u32, Smoothing)], count: usize) -> Vec<Smoothing> {
    if smoothing.iter().all(|&(_, one)| one == Smoothing::ByCrease) {
        return Vec::new();
    }
    let mut all = vec![Smoothing::ByCrease; count];
    for &(first, one) in smoothing {
        all[first as usize..].fill(one);
    }
    all
}

/// Which corners of which triangles lie at each position.
struct Fans {
    /// Start of each position's list.
    starts: Vec<u32>,
    /// Three times the triangle plus the corner.
    corners: Vec<u32>,
}

impl Fans {
    fn new(mesh: &Mesh) -> Self {
        let all = mesh.triangles.as_flattened();
        let mut starts = vec![0; mesh.positions.len() + 1];
        all.iter().for_each(|&position| starts[position as usize + 1] += 1);
        for position in 1..starts.len() {
            starts[position] += starts[position - 1];
        }
        let mut corners = vec![0; all.len()];
        let mut ends = starts.clone();
        for (corner, &position) in (0..).zip(all) {
            corners[ends[position as usize] as usize] = corner;
            ends[position as usize] += 1;
        }
        Self { starts, corners }
    }

    fn around(&self, position: usize) -> &[u32] {
        &self.corners[self.starts[position] as usize..self.starts[position + 1] as usize]
    }
}

/// Parts the faces around a vertex into those that share a normal.
struct Sharing<'a> {
    cos_crease: f64,
    n_geom: &'a [DVec3],
    /// Empty if all are by crease.
    smoothing: &'a [Smoothing],
    /// For each face of the fan, one that it shares its normal with, at or before it.
    leaders: Vec<usize>,
}

impl Sharing<'_> {
    /// Gives the corners of a fan the numbers of their normals, from `first` on; how many there are.
    ///
    /// A face that shares with none stays flat, unless it is alone at the vertex.
    fn number(&mut self, fan: &[u32], first: u32, corners: &mut [[u32; 3]]) -> u32 {
        let mut put = |corner: u32, number: u32| {
            corners[corner as usize / 3][corner as usize % 3] = number;
        };
        if self.is_one(fan) {
            fan.iter().for_each(|&corner| put(corner, first));
            return 1;
        }
        self.part(fan);
        let mut count = 0;
        let mut numbers = vec![FLAT; fan.len()];
        let mut members = vec![0u32; fan.len()];
        self.leaders.iter().for_each(|&leader| members[leader] += 1);
        for (&corner, &leader) in fan.iter().zip(&self.leaders) {
            if members[leader] > 1 && numbers[leader] == FLAT {
                numbers[leader] = first + count;
                count += 1;
            }
            put(corner, numbers[leader]);
        }
        count
    }

    /// Whether the first face shares its normal with all others, so that they have one.
    fn is_one(&self, fan: &[u32]) -> bool {
        match fan {
            [] => false,
            [corner] => self.smoothing_of(*corner) != Smoothing::Off,
            [first, others @ ..] => others.iter().all(|&corner| self.shares(*first, corner)),
        }
    }

    fn part(&mut self, fan: &[u32]) {
        self.leaders.clear();
        if fan.len() > MANY {
            return self.part_many(fan);
        }
        self.leaders.extend(0..fan.len());
        self.join(fan);
    }

    /// As [`Sharing::part`], over one face for each direction (to 1/16) and smoothing.
    fn part_many(&mut self, fan: &[u32]) {
        let key = |corner: u32| {
            let cell =
                self.n_geom[corner as usize / 3].to_array().map(|x| (x * 16.0).round() as i8);
            (self.smoothing_of(corner), cell)
        };
        let mut order: Vec<usize> = (0..fan.len()).collect();
        order.sort_by_key(|&at| (key(fan[at]), at));
        let firsts: Vec<usize> = order
            .chunk_by(|&a, &b| {
                key(fan[a]) == key(fan[b]) && self.smoothing_of(fan[a]) != Smoothing::Off
            })
            .map(|same| same[0])
            .collect();
        let group_of: Vec<(usize, usize)> = order
            .chunk_by(|&a, &b| {
                key(fan[a]) == key(fan[b]) && self.smoothing_of(fan[a]) != Smoothing::Off
            })
            .enumerate()
            .flat_map(|(group, same)| same.iter().map(move |&at| (at, group)))
            .collect();
        let faces: Vec<u32> = firsts.iter().map(|&at| fan[at]).collect();
        self.leaders.extend(0..faces.len());
        self.join(&faces);
        let leaders = std::mem::take(&mut self.leaders);
        self.leaders = vec![0; fan.len()];
        for (at, group) in group_of {
            self.leaders[at] = firsts[leaders[group]];
        }
    }

    /// Joins every two faces that share; then each one's leader is the first it is joined with.
    fn join(&mut self, faces: &[u32]) {
        for here in 1..faces.len() {
            for there in 0..here {
                if self.leader(here) != self.leader(there) && self.shares(faces[here], faces[there])
                {
                    let (a, b) = (self.leader(here), self.leader(there));
                    self.leaders[a.max(b)] = a.min(b);
                }
            }
        }
        for at in 0..faces.len() {
            self.leaders[at] = self.leader(at);
        }
    }

    fn leader(&self, mut at: usize) -> usize {
        while self.leaders[at] != at {
            at = self.leaders[at];
        }
        at
    }

    fn shares(&self, a: u32, b: u32) -> bool {
        match (self.smoothing_of(a), self.smoothing_of(b)) {
            (Smoothing::ByCrease, Smoothing::ByCrease) => {
                self.n_geom[a as usize / 3].dot(self.n_geom[b as usize / 3]) >= self.cos_crease
            }
            (Smoothing::Group(a), Smoothing::Group(b)) => a == b,
            _ => false,
        }
    }

    fn smoothing_of(&self, corner: u32) -> Smoothing {
        self.smoothing.get(corner as usize / 3).copied().unwrap_or(Smoothing::ByCrease)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A prism of `sides` sides without ends.
    fn prism(sides: u32) -> Mesh {
        let rim = (0..2 * sides).map(|k| {
            let angle = f64::from(k / 2) / f64::from(sides) * std::f64::consts::TAU;
            DVec3::new(angle.cos(), angle.sin(), f64::from(k % 2))
        });
        let quad = |k: u32| {
            let next = (k + 1) % sides;
            [[2 * k, 2 * next, 2 * next + 1], [2 * k, 2 * next + 1, 2 * k + 1]]
        };
        Mesh::flat("prism", rim.collect(), (0..sides).flat_map(quad).collect()).unwrap()
    }

    /// Largest angle between shading and geometric normal at the triangles' corners, degrees.
    fn bend_deg(mesh: &Mesh) -> f64 {
        let corners = [[0., 0.], [1., 0.], [0., 1.]];
        let bend = |triangle, corner| {
            let n_geom = mesh.geometric_normal(triangle);
            n_geom.dot(mesh.shading_normal(triangle, corner, n_geom)).min(1.0).acos().to_degrees()
        };
        (0..mesh.triangles.len())
            .flat_map(|triangle| corners.map(|corner| bend(triangle, corner)))
            .fold(0.0, f64::max)
    }

    fn with(mesh: &Mesh, crease_deg: f64, smoothing: &[(u32, Smoothing)]) -> Mesh {
        Mesh { shading: creased(mesh, crease_deg, smoothing), ..mesh.clone() }
    }

    /// Nine sides meet at 40°, eight at 45°.
    #[test]
    fn edges_within_the_crease_angle_are_smooth() {
        assert!(bend_deg(&with(&prism(8), 40.0, &[])) < 1e-5);
        let smooth = bend_deg(&with(&prism(9), 40.0, &[]));
        assert!((smooth - 20.0).abs() < 10.0, "{smooth}");
        assert!(matches!(with(&prism(9), 40.0, &[]).shading, Shading::PerPosition(_)));
        assert!(bend_deg(&with(&prism(8), 45.0, &[])) > 10.0);
    }

    #[test]
    fn a_crease_of_180_degrees_is_the_plain_mean() {
        let mesh = prism(4);
        let Shading::PerPosition(made) = with(&mesh, 180.0, &[]).shading else { panic!() };
        for (made, plain) in made.iter().zip(mesh.vertex_normals()) {
            assert!((*made - plain).length() < 1e-15);
        }
    }

    #[test]
    fn angles_of_slivers_are_those_of_their_corners() {
        let sliver = [DVec3::ZERO, DVec3::X, DVec3::new(0.5, 1e-9, 0.0)];
        let [a, b, c] = angles(sliver);
        assert!((a / 2e-9 - 1.0).abs() < 1e-12 && (b / 2e-9 - 1.0).abs() < 1e-12);
        assert!((c - PI + 4e-9).abs() < 1e-15);
        assert_eq!(angles([DVec3::ONE; 3]).map(f64::is_finite), [true; 3]);
    }

    #[test]
    fn smoothing_groups_decide_where_they_are_given() {
        let mesh = prism(4);
        let smooth = with(&mesh, 0.0, &[(0, Smoothing::Group(1))]);
        assert!(bend_deg(&smooth) > 20.0);
        assert!(bend_deg(&with(&prism(30), 180.0, &[(0, Smoothing::Off)])) < 1e-5);
        // Two sides of one group, two of another: sharp between them, smooth inside.
        let halves = with(&mesh, 0.0, &[(0, Smoothing::Group(1)), (4, Smoothing::Group(2))]);
        let Shading::PerCorner { normals, .. } = &halves.shading else { panic!() };
        // At 4 positions one, of two sides; at the others one, of a side's two triangles; the third
        // triangle there is flat.
        assert_eq!(normals.iter().filter(|&&n| n != DVec3::ZERO).count(), 8);
    }

    /// A fan of more faces than are compared one by one gives what the comparison gives.
    #[test]
    fn large_fans_are_parted_alike() {
        let cone = |sides: u32, height: f64| {
            let rim = (0..sides).map(|k| {
                let angle = f64::from(k) / f64::from(sides) * std::f64::consts::TAU;
                DVec3::new(angle.cos(), angle.sin(), 0.0)
            });
            let positions = rim.chain([DVec3::Z * height]).collect();
            let triangles = (0..sides).map(|k| [k, (k + 1) % sides, sides]).collect();
            Mesh::flat("cone", positions, triangles).unwrap()
        };
        for sides in [200, 1000] {
            // Smooth around, though opposite faces are 127° apart.
            let mesh = with(&cone(sides, 2.0), 40.0, &[]);
            let tip = mesh.shading_normal(0, [0.0, 1.0], mesh.geometric_normal(0));
            assert!((tip - DVec3::Z).length() < 1e-12, "{sides}: {tip}");
            let off = with(&cone(sides, 2.0), 40.0, &[(0, Smoothing::Off)]);
            assert!(bend_deg(&off) < 1e-5);
        }
    }
}
