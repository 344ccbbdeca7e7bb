//! Opaque bodies that go through each other, which no two things can.

use crate::geometry::{Closure, DVec3, Mesh, Ray};
use crate::scene::Prepared;

/// Triangles of a mesh that are looked at, evenly spread: enough for what a picture would show.
const TRIANGLES: usize = 4000;

/// How far edges are drawn into their body, of its size: bodies that touch do not overlap.
const INSET: f64 = 1e-5;

/// A warning that names the first pair, and how many there are.
pub(super) fn overlap_warning(prepared: &Prepared) -> Option<String> {
    let objects = &prepared.scene.objects;
    let opaque: Vec<usize> = (0..objects.len()).filter(|&at| prepared.opaque[at]).collect();
    let bounds: Vec<[DVec3; 2]> = objects.iter().map(|object| object.mesh.bounds()).collect();
    let mut pairs = Vec::new();
    for (i, &a) in opaque.iter().enumerate() {
        for &b in &opaque[i + 1..] {
            if may_overlap(bounds[a], bounds[b]) && overlap(prepared, a, b) {
                pairs.push((a, b));
            }
        }
    }
    let &(a, b) = pairs.first()?;
    let name = |object: usize| &prepared.scene.materials[objects[object].material.0].name;
    let more = match pairs.len() {
        1 => String::new(),
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

fn may_overlap([low, high]: [DVec3; 2], [other_low, other_high]: [DVec3; 2]) -> bool {
    low.cmplt(other_high).all() && other_low.cmplt(high).all()
}

/// Whether the inside of either meets the surface of the other, and both have an inside. Edges as they
/// are come first: most meshes do not meet, and whether they are closed takes longer to tell.
fn overlap(prepared: &Prepared, a: usize, b: usize) -> bool {
    let mesh = |object: usize| &*prepared.scene.objects[object].mesh;
    let meet = |inset_mm: [f64; 2]| {
        enters(prepared, mesh(a), inset_mm[0], b) || enters(prepared, mesh(b), inset_mm[1], a)
    };
    if !meet([0.0; 2]) {
        return false;
    }
    let inset = |object: usize| {
        let closure = Closure::of(mesh(object));
        let [low, high] = mesh(object).bounds();
        let inset_mm = INSET * low.distance(high) * closure.volume_mm3.signum();
        (closure.is_closed() && closure.volume_mm3 != 0.0).then_some(inset_mm)
    };
    inset(a).zip(inset(b)).is_some_and(|(a, b)| meet([a, b]))
}

/// Whether an edge of the mesh, drawn in behind its triangle's front, goes through an object.
fn enters(prepared: &Prepared, mesh: &Mesh, inset_mm: f64, object: usize) -> bool {
    let [low, high] = prepared.scene.objects[object].mesh.bounds();
    let stride = mesh.triangles.len().div_ceil(TRIANGLES).max(1);
    mesh.triangles.iter().step_by(stride).any(|triangle| {
        let corners = triangle.map(|corner| mesh.positions[corner as usize]);
        let [a, b, c] = corners;
        let (lowest, highest) = (a.min(b).min(c), a.max(b).max(c));
        if lowest.cmpgt(high).any() || highest.cmplt(low).any() {
            return false;
        }
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let middle = (a + b + c) / 3.0;
        let inside = corners.map(|p| p + (middle - p) * 1e-3 - normal * inset_mm);
        (0..3).any(|edge| {
            let way = inside[(edge + 1) % 3] - inside[edge];
            let length_mm = way.length();
            if length_mm <= 4.0 * prepared.bvh.place_mm() {
                return false;
            }
            let ray = Ray { origin: inside[edge], direction: way / length_mm };
            let hits = prepared.bvh.hits_up_to(&ray, None, length_mm);
            hits.iter().any(|hit| prepared.bvh.locate(hit.triangle).0 == object)
        })
    })
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
