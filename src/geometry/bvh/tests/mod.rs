mod exact;
mod leaving;
mod shaft;
mod watertight;

use crate::geometry::random::Random;
use std::sync::Arc;

use super::super::mesh::Shading;
use super::super::{DVec3, Hit, Mesh, Ray, TriangleId};
use super::{Bvh, probe};
use crate::simd::Simd;

fn mesh(positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Arc<Mesh> {
    Arc::new(Mesh { positions, triangles, shading: Shading::Flat })
}

/// The same scene once for each kernel that this processor has.
fn on_each_kernel(meshes: &[Arc<Mesh>]) -> Vec<Bvh> {
    let best = Bvh::build(meshes);
    Simd::available().into_iter().map(|simd| best.clone().with_simd(simd)).collect()
}

/// What the tree must return, bit for bit: the f64 test on every triangle.
fn brute_force(bvh: &Bvh, ray: &Ray, leaving: Option<TriangleId>) -> Option<Hit> {
    let probe = bvh.probe(ray)?;
    let count = bvh.first_triangles[bvh.meshes.len()];
    let hits = (0..count).map(TriangleId).filter(|&id| leaving != Some(id)).filter_map(|id| {
        let corners = bvh.corners(id);
        if probe::is_degenerate(corners) {
            return None;
        }
        let crossing = probe.cross(corners)?;
        Some((
            crossing.t_mm,
            Hit {
                distance_mm: crossing.t_mm + probe.advance_mm,
                u: crossing.u,
                v: crossing.v,
                triangle: id,
            },
        ))
    });
    // Of equal distances `min_by` keeps the first, which has the lowest number.
    hits.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, hit)| hit)
}

impl Random {
    /// In a cube of half-width 1.
    fn in_cube(&mut self) -> DVec3 {
        2.0 * DVec3::new(self.unit(), self.unit(), self.unit()) - DVec3::ONE
    }

    fn direction(&mut self) -> DVec3 {
        loop {
            let v = self.in_cube();
            if (0.01..1.0).contains(&v.length_squared()) {
                return v.normalize();
            }
        }
    }
}

fn aimed(origin: DVec3, target: DVec3) -> Ray {
    Ray { origin, direction: (target - origin).normalize() }
}

/// A closed, bumpy ball of 4 `rings`² triangles around `center`, front outside.
fn ball(center: DVec3, radius: f64, rings: u32, random: &mut Random) -> Mesh {
    let columns = 2 * rings;
    let mut positions = vec![];
    for ring in 1..rings {
        let theta = std::f64::consts::PI * f64::from(ring) / f64::from(rings);
        for column in 0..columns {
            let phi = std::f64::consts::TAU * f64::from(column) / f64::from(columns);
            let r = radius * (1.0 + 0.02 * random.unit());
            let (z, s) = (theta.cos(), theta.sin());
            positions.push(center + r * DVec3::new(s * phi.cos(), s * phi.sin(), z));
        }
    }
    positions.push(center + radius * DVec3::Z);
    positions.push(center - radius * DVec3::Z);
    let [north, south] = [2, 1].map(|k| positions.len() as u32 - k);
    let mut triangles = vec![];
    for column in 0..columns {
        let next = (column + 1) % columns;
        triangles.push([north, column, next]);
        let last = (rings - 2) * columns;
        triangles.push([south, last + next, last + column]);
        for ring in 0..rings - 2 {
            let (a, b) = (ring * columns, (ring + 1) * columns);
            triangles.push([a + column, b + column, b + next]);
            triangles.push([a + column, b + next, a + next]);
        }
    }
    Mesh { positions, triangles, shading: Shading::Flat }
}

/// `cells`² squares of two triangles each from `corner` along both sides.
fn grid(corner: DVec3, sides: [DVec3; 2], cells: u32) -> Arc<Mesh> {
    let at = |i: u32| f64::from(i) / f64::from(cells);
    let positions = (0..=cells)
        .flat_map(|j| (0..=cells).map(move |i| corner + sides[0] * at(i) + sides[1] * at(j)))
        .collect();
    let row = cells + 1;
    let triangles = (0..cells * cells)
        .flat_map(|cell| {
            let a = cell / cells * row + cell % cells;
            [[a, a + 1, a + row + 1], [a, a + row + 1, a + row]]
        })
        .collect();
    mesh(positions, triangles)
}

/// Edge lengths of the scenes to test, mm: 1 µm, 1 mm, 1 km.
const SCALES_MM: [f64; 3] = [1e-3, 1.0, 1e6];
