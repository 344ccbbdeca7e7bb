//! Opaque bodies that go through each other, which no two things can.

use std::collections::{BTreeMap, BTreeSet};

use rayon::prelude::*;

use crate::geometry::{Closure, DVec3, Mesh, Ray};
use crate::scene::Prepared;

/// Triangles of a scene that are looked at, evenly spread: some 20 ms, and enough for what a picture
/// would show.
const TRIANGLES: usize = 20_000;

/// The same of a mesh, once it is known to meet another.
const TRIANGLES_OF_ONE: usize = 4000;

/// Pairs that are looked for; who has so many will find the others.
const MOST_PAIRS: usize = 20;

/// How far edges are drawn into their body, of its size: bodies that touch do not overlap.
const INSET: f64 = 1e-5;

/// A warning that names the first pair, and how many there are.
pub(super) fn overlap_warning(prepared: &Prepared) -> Option<String> {
    let objects = &prepared.scene.objects;
    let mut bodies = BTreeMap::new();
    let pairs = pairs_that_meet(prepared).into_iter();
    let overlapping = pairs.filter(|&(a, b)| overlap(prepared, [a, b], &mut bodies));
    let pairs: Vec<(usize, usize)> = overlapping.take(MOST_PAIRS).collect();
    let &(a, b) = pairs.first()?;
    let name = |object: usize| &prepared.scene.materials[objects[object].material.0].name;
    let more = match pairs.len() {
        1 => String::new(),
        MOST_PAIRS => format!(" ({} more pairs do, or even more)", MOST_PAIRS - 1),
        count => format!(" ({} more pairs do)", count - 1),
    };
    Some(format!(
        "objects {}, {}, and {}, {}: two closed opaque bodies go through each other{more}: what of one \
         lies in the other is not seen; are both where they belong?",
        a + 1,
        name(a),
        b + 1,
        name(b)
    ))
}

/// Pairs of opaque objects of which an edge of one meets a triangle of the other, the smaller number
/// first.
fn pairs_that_meet(prepared: &Prepared) -> BTreeSet<(usize, usize)> {
    let objects = &prepared.scene.objects;
    let bounds: Vec<[DVec3; 2]> = objects.iter().map(|object| object.mesh.bounds()).collect();
    let is_near = |a: usize, b: usize| a != b && prepared.opaque[b] && meet(bounds[a], bounds[b]);
    let near = |&a: &usize| prepared.opaque[a] && (0..objects.len()).any(|b| is_near(a, b));
    let asked: Vec<usize> = (0..objects.len()).filter(near).collect();
    let all: usize = asked.iter().map(|&a| objects[a].mesh.triangles.len()).sum();
    let of_object = |&a: &usize| {
        let edges = edges(&objects[a].mesh, all.div_ceil(TRIANGLES).max(1), 0.0);
        let met = edges.flat_map(|edge| met_by(prepared, edge));
        let others = met.filter(|&b| prepared.opaque.get(b) == Some(&true) && b < objects.len());
        others.filter(|&b| b != a).map(|b| (a.min(b), a.max(b))).collect::<BTreeSet<_>>()
    };
    asked.par_iter().flat_map_iter(of_object).collect()
}

fn meet([low, high]: [DVec3; 2], [other_low, other_high]: [DVec3; 2]) -> bool {
    low.cmple(other_high).all() && other_low.cmple(high).all()
}

/// Whether both have an inside, and that of either meets the surface of the other; `bodies` has the
/// insets of those that were asked before, mm, none for what is no body.
fn overlap(
    prepared: &Prepared,
    [a, b]: [usize; 2],
    bodies: &mut BTreeMap<usize, Option<f64>>,
) -> bool {
    let mesh = |object: usize| &*prepared.scene.objects[object].mesh;
    let mut inset_mm = |object| *bodies.entry(object).or_insert_with(|| inset_mm(mesh(object)));
    let Some((inset_a, inset_b)) = inset_mm(a).zip(inset_mm(b)) else { return false };
    let enters = |object: usize, inset_mm: f64, other: usize| {
        let stride = mesh(object).triangles.len().div_ceil(TRIANGLES_OF_ONE).max(1);
        let mut edges = edges(mesh(object), stride, inset_mm);
        edges.any(|edge| met_by(prepared, edge).contains(&other))
    };
    enters(a, inset_a, b) || enters(b, inset_b, a)
}

/// How far a body's inside is behind its triangles' fronts, or their backs where it is inside out.
fn inset_mm(mesh: &Mesh) -> Option<f64> {
    let closure = Closure::of(mesh);
    let [low, high] = mesh.bounds();
    let inset_mm = INSET * low.distance(high) * closure.volume_mm3.signum();
    (closure.is_closed() && closure.volume_mm3 != 0.0).then_some(inset_mm)
}

/// The edges of some triangles, moved behind their fronts and a little toward their middles.
fn edges(mesh: &Mesh, stride: usize, inset_mm: f64) -> impl Iterator<Item = [DVec3; 2]> {
    mesh.triangles.iter().step_by(stride).flat_map(move |triangle| {
        let corners = triangle.map(|corner| mesh.positions[corner as usize]);
        let [a, b, c] = corners;
        let behind = (b - a).cross(c - a).normalize_or_zero() * inset_mm;
        let middle = (a + b + c) / 3.0;
        let [a, b, c] = corners.map(|p| p + (middle - p) * 1e-3 - behind);
        [[a, b], [b, c], [c, a]]
    })
}

/// The objects that a segment meets.
fn met_by(prepared: &Prepared, [from, to]: [DVec3; 2]) -> Vec<usize> {
    let length_mm = from.distance(to);
    if length_mm <= 4.0 * prepared.bvh.place_mm() {
        return Vec::new();
    }
    let ray = Ray { origin: from, direction: (to - from) / length_mm };
    let hits = prepared.bvh.hits_up_to(&ray, None, length_mm);
    hits.into_iter().map(|hit| prepared.bvh.locate(hit.triangle).0).collect()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::DQuat;

    use super::*;
    use crate::geometry::mesh::Shading;
    use crate::material::{Lobes, Material};
    use crate::scene::{MaterialId, Object, Scene};
    use crate::spectrum::Spectrum;

    /// Twelve triangles, fronts outside; `faces` of them.
    fn cuboid(low: [f64; 3], high: [f64; 3], faces: usize) -> Mesh {
        let at = |bits: usize| {
            DVec3::from(std::array::from_fn(|i| if bits >> i & 1 == 1 { high[i] } else { low[i] }))
        };
        let quads =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads.iter().take(faces).flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
        let triangles = triangles.collect();
        Mesh { positions: (0..8).map(at).collect(), triangles, shading: Shading::Flat }
    }

    fn warning(meshes: [Mesh; 2], size: f64, transmittance: f64) -> Option<String> {
        let turn = DQuat::from_scaled_axis(DVec3::new(0.3, -1.1, 0.7));
        let placed = |mesh: Mesh| {
            let positions = mesh.positions.iter().map(|p| turn * (*p * size)).collect();
            Arc::new(Mesh { positions, ..mesh })
        };
        let material = Material {
            name: "white".to_owned(),
            reflectance: Spectrum::constant(0.5),
            transmittance: (transmittance > 0.0).then(|| Spectrum::constant(transmittance)),
            lobes: Lobes { k_d: 1.0, ..Lobes::default() },
            k_tg: transmittance,
            ..Material::default()
        };
        let objects = meshes.map(|mesh| Object { mesh: placed(mesh), material: MaterialId(0) });
        let scene =
            Scene { objects: objects.into(), materials: vec![material], ..Scene::default() };
        overlap_warning(&scene.prepare().unwrap())
    }

    #[test]
    fn bodies_that_go_through_each_other_are_told_from_those_that_touch() {
        let block = || cuboid([-1.0; 3], [1.0; 3], 6);
        let beside = |low: [f64; 3], high: [f64; 3]| cuboid(low, high, 6);
        for size in [1e-3, 1.0, 1e5] {
            let is_warned = |other: Mesh| warning([block(), other], size, 0.0).is_some();
            assert!(is_warned(beside([0.5, -0.3, -0.3], [2.0, 0.3, 0.3])), "a corner, {size}");
            assert!(is_warned(beside([-2.0, -0.3, -0.3], [2.0, 0.3, 0.3])), "a bar, {size}");
            assert!(is_warned(beside([0.99, -1.0, -1.0], [2.0, 1.0, 1.0])), "1 %, {size}");
            let inside_out = beside([0.99, -1.0, -1.0], [2.0, 1.0, 1.0]).turned_inside_out();
            assert!(is_warned(inside_out), "inside out, {size}");
            let inside_out = beside([1.0, -1.0, -1.0], [2.0, 1.0, 1.0]).turned_inside_out();
            assert!(!is_warned(inside_out), "inside out and beside, {size}");
            for y in [-1.0, -0.7, 0.3] {
                assert!(!is_warned(beside([1.0, y, y], [2.0, y + 2.0, y + 1.5])), "{y}, {size}");
            }
            assert!(!is_warned(beside([1.1, -1.0, -1.0], [2.0, 1.0, 1.0])), "apart, {size}");
        }
    }

    #[test]
    fn open_meshes_and_what_transmits_may_go_through_each_other() {
        let bar = |faces| cuboid([-2.0, -0.3, -0.3], [2.0, 0.3, 0.3], faces);
        let block = || cuboid([-1.0; 3], [1.0; 3], 6);
        assert!(warning([block(), bar(6)], 1.0, 0.0).is_some());
        assert!(warning([block(), bar(5)], 1.0, 0.0).is_none());
        assert!(warning([block(), bar(6)], 1.0, 0.5).is_none());
    }
}
