//! Whether a mesh bounds a body, and which side of it is inside.

use std::collections::HashMap;

use rayon::prelude::*;

use super::{DVec3, Mesh};

/// How a mesh closes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Closure {
    /// Edges that no triangle of the same mesh, facing the same way, continues.
    pub open_edges: usize,
    /// What the mesh encloses; negative where the fronts look inside. Of a mesh with open edges it
    /// says nothing.
    pub volume_mm3: f64,
}

/// Corners of open edges that are nearer than this, of the mesh's size, are the same: parts of a
/// mesh that were computed one by one meet within rounding.
const SAME_CORNER: f64 = 1e-8;

impl Closure {
    /// Whether the mesh has an inside.
    pub fn is_closed(&self) -> bool {
        self.open_edges == 0
    }

    /// How a whole mesh closes. Time grows with its edges, a second for some ten million of them.
    pub fn of(mesh: &Mesh) -> Self {
        let mut open = unmatched(mesh.triangles.par_iter().copied());
        if !open.is_empty() {
            open = after_welding(mesh, &open);
        }
        let open_edges =
            if open.is_empty() || is_closed_in_space(mesh, &open) { 0 } else { open.len() };
        Self { open_edges, volume_mm3: mesh.volume_mm3() }
    }
}

/// A directed edge, as the triangles that have it run along it.
type Edge = [u32; 2];

/// Edges that are not run along as often in one direction as in the other.
fn unmatched(triangles: impl ParallelIterator<Item = [u32; 3]>) -> Vec<Edge> {
    let edges = triangles.flat_map_iter(|[a, b, c]| [[a, b], [b, c], [c, a]]);
    let mut edges: Vec<(Edge, bool)> =
        edges.filter(|[a, b]| a != b).map(|[a, b]| ([a.min(b), a.max(b)], a < b)).collect();
    edges.par_sort_unstable();
    let same = edges.chunk_by(|a, b| a.0 == b.0);
    same.flat_map(|uses| {
        let forward = uses.iter().filter(|(_, is_forward)| *is_forward).count();
        let backward = uses.len() - forward;
        let [a, b] = uses[0].0;
        let edge = if forward > backward { [a, b] } else { [b, a] };
        std::iter::repeat_n(edge, forward.abs_diff(backward))
    })
    .collect()
}

/// Those of `open` that stay so once corners in the same place are one.
fn after_welding(mesh: &Mesh, open: &[Edge]) -> Vec<Edge> {
    let [low, high] = mesh.bounds();
    let reach_mm = SAME_CORNER * (high - low).length();
    let mut welder = Welder { reach_mm, cells: HashMap::new() };
    let mut corner = HashMap::new();
    for &index in open.iter().flatten() {
        corner.entry(index).or_insert_with(|| welder.weld(index, mesh.positions[index as usize]));
    }
    let mut uses: HashMap<Edge, (i64, Edge)> = HashMap::new();
    for edge in open {
        let [a, b] = edge.map(|index| corner[&index]);
        if a != b {
            uses.entry([a.min(b), a.max(b)]).or_insert((0, *edge)).0 += if a < b { 1 } else { -1 };
        }
    }
    let mut left: Vec<Edge> =
        uses.into_values().filter(|(sum, _)| *sum != 0).map(|(_, edge)| edge).collect();
    left.sort_unstable();
    left
}

/// Finds corners in the same place, by cells twice as wide as their reach.
struct Welder {
    reach_mm: f64,
    cells: HashMap<[i64; 3], Vec<(u32, DVec3)>>,
}

impl Welder {
    /// The first corner that lies there.
    fn weld(&mut self, index: u32, place: DVec3) -> u32 {
        let cell = |p: DVec3| p.to_array().map(|x| (x / (2.0 * self.reach_mm)).floor() as i64);
        let around = (0..8).map(|i| {
            let side = |bit: i32| if i >> bit & 1 == 0 { -self.reach_mm } else { self.reach_mm };
            cell(place + DVec3::new(side(0), side(1), side(2)))
        });
        let is_near = |(_, other): &&(u32, DVec3)| other.distance(place) <= self.reach_mm;
        let found = around.filter_map(|key| self.cells.get(&key)?.iter().find(is_near)).next();
        if let Some(&(first, _)) = found {
            return first;
        }
        let key = cell(place);
        self.cells.entry(key).or_default().push((index, place));
        index
    }
}

/// Whether edges that meet others in their middle leave no hole: seen from beside them, the mesh
/// then covers all directions, or as much of them forward as backward.
fn is_closed_in_space(mesh: &Mesh, open: &[Edge]) -> bool {
    const PLACES: usize = 16;
    const WHOLE: f64 = 1e-6;
    let step = open.len().div_ceil(PLACES);
    open.iter().step_by(step).all(|&[a, b]| {
        let [a, b] = [a, b].map(|index| mesh.positions[index as usize]);
        let (x, y) = (b - a).normalize_or_zero().any_orthonormal_pair();
        // In no plane in which a face is likely to lie.
        let aside =
            (0.8 * x + 0.6 * y + 0.1 * (b - a).normalize_or_zero()) * (0.3 * (b - a).length());
        [aside, -aside].into_iter().all(|aside| {
            let turns = winding(mesh, 0.5 * (a + b) + aside);
            (turns - turns.round()).abs() < WHOLE
        })
    })
}

/// How often the mesh goes around a point: 1 inside of a closed one, 0 outside.
///
/// Source: A. van Oosterom, J. Strackee, "The solid angle of a plane triangle", IEEE Trans. Biomed.
/// Eng. 30, 125 (1983).
fn winding(mesh: &Mesh, point: DVec3) -> f64 {
    let half_angle = |triangle: usize| {
        let [a, b, c] = mesh.corners(triangle).map(|corner| (corner - point).normalize_or_zero());
        a.dot(b.cross(c)).atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
    };
    (0..mesh.triangles.len()).map(half_angle).sum::<f64>() / (2.0 * std::f64::consts::PI)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn v(x: f64, y: f64, z: f64) -> DVec3 {
        DVec3::new(x, y, z)
    }

    /// Six sides of a 2 × 3 × 4 box, each with corners of its own, in n × n cells; `jitter` moves
    /// them, as rounding does.
    fn box_of_sides(cells: [usize; 6], jitter: f64) -> Mesh {
        let side = |at: usize| {
            let axis = at / 2;
            let (n, sign) = (cells[at], if at.is_multiple_of(2) { 1.0 } else { -1.0 });
            let points = (0..(n + 1) * (n + 1)).map(|k| {
                let unit = |i: usize| i as f64 / n as f64 - 0.5;
                let mut p = [0.0; 3];
                p[axis] = 0.5 * sign;
                p[(axis + 1) % 3] = sign * unit(k % (n + 1));
                p[(axis + 2) % 3] = unit(k / (n + 1));
                Some(DVec3::from(p) * v(2.0, 3.0, 4.0) + jitter * (at as f64))
            });
            Mesh::from_grid("side", n, n, &points.collect::<Vec<_>>()).unwrap()
        };
        let sides: Vec<Mesh> = (0..6).map(side).collect();
        Mesh::merged("box", &sides.iter().collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn a_box_of_six_sides_closes_within_rounding() {
        for jitter in [0.0, 1e-12] {
            let closure = Closure::of(&box_of_sides([2; 6], jitter));
            assert_eq!(closure.open_edges, 0);
            assert!((closure.volume_mm3 - 24.0).abs() < 1e-9, "{closure:?}");
        }
        assert!(!Closure::of(&box_of_sides([2; 6], 1e-3)).is_closed());
    }

    #[test]
    fn sides_of_unlike_cells_close_too() {
        assert!(Closure::of(&box_of_sides([1, 2, 3, 4, 5, 6], 0.0)).is_closed());
    }

    #[test]
    fn a_missing_triangle_opens_three_edges() {
        let mut mesh = box_of_sides([2; 6], 0.0);
        mesh.triangles.pop();
        assert_eq!(Closure::of(&mesh).open_edges, 3);
    }

    #[test]
    fn a_turned_triangle_opens_its_edges_and_a_turned_mesh_its_volume() {
        let mut mesh = box_of_sides([1; 6], 0.0);
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        assert!(Closure::of(&mesh).volume_mm3 < -23.9);
        mesh.triangles[0].swap(1, 2);
        assert!(!Closure::of(&mesh).is_closed());
    }
}
