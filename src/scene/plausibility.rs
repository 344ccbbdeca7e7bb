//! What can be rendered but was hardly meant: noticed once the scene is prepared.

use std::collections::HashMap;

use crate::geometry::{DVec3, Mesh, Ray};
use crate::light::RaySample;
use crate::scene::{MaterialId, Prepared};
use crate::view::View;

/// Smaller scenes are lamps whose meshes were made in meters, more often than not, mm.
const SMALLEST_SCENE_MM: f64 = 1.0;

/// Six directions that see every wall of a room.
const AROUND: [DVec3; 6] = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];

/// Warnings about the scene, for people.
pub fn of_scene(prepared: &Prepared) -> Vec<String> {
    let mut warnings: Vec<String> = size_warning(prepared).into_iter().collect();
    let materials = 0..prepared.scene.materials.len();
    warnings.extend(materials.filter_map(|at| body_warning(prepared, MaterialId(at))));
    let lights = 0..prepared.scene.lights.len();
    warnings.extend(lights.filter_map(|at| light_warning(prepared, at)));
    warnings
}

/// A warning about where the eye is.
pub fn of_view(prepared: &Prepared, view: &View) -> Option<String> {
    let eye = view.camera().ray(0.0, 0.0).origin;
    is_enclosed(prepared, eye, |_| true).then(|| {
        format!(
            "view: the eye, {} mm from its target, is inside a mesh: it sees only back sides",
            view.distance_mm
        )
    })
}

fn size_warning(prepared: &Prepared) -> Option<String> {
    let (low, high) = prepared.bvh.bounds()?;
    let size_mm = (high - low).max_element();
    (size_mm < SMALLEST_SCENE_MM).then(|| {
        format!(
            "scene: all objects lie within {size_mm:.3e} mm: are their meshes in m? \
                 \"scale\" = 1000 makes them mm"
        )
    })
}

/// `thickness` attenuates between entering and leaving, so that the surfaces of a body have to
/// close it.
fn body_warning(prepared: &Prepared, material: MaterialId) -> Option<String> {
    let scene = &prepared.scene;
    let given = &scene.materials[material.0];
    if given.thickness_mm.is_none() || !given.transmits() {
        return None;
    }
    let objects = scene.objects.iter().filter(|object| object.material == material);
    let mut uses = HashMap::new();
    objects.for_each(|object| count_edges(&object.mesh, &mut uses));
    let open = uses.values().filter(|&&count| count % 2 != 0).count();
    (open > 0).then(|| {
        format!(
            "{}: \"thickness\" asks for closed bodies, but {open} edges bound a hole",
            given.name
        )
    })
}

/// Corners by their bits: neighbors that share a corner share it exactly.
type Corner = [u64; 3];

fn count_edges(mesh: &Mesh, uses: &mut HashMap<[Corner; 2], u32>) {
    // Adding 0 makes −0 and 0 the same corner.
    let corner = |index: u32| -> Corner {
        mesh.positions[index as usize].to_array().map(|v| (v + 0.0).to_bits())
    };
    for triangle in &mesh.triangles {
        let corners = triangle.map(corner);
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            let (a, b) = (corners[a], corners[b]);
            *uses.entry([a.min(b), a.max(b)]).or_default() += 1;
        }
    }
}

fn light_warning(prepared: &Prepared, at: usize) -> Option<String> {
    let rays = &prepared.scene.lights[at].rays;
    let sum: DVec3 = rays.samples.iter().map(RaySample::origin).sum();
    let center = rays.world_from_local.transform_point3(sum / rays.samples.len().max(1) as f64);
    is_enclosed(prepared, center, |object| prepared.blocks[object]).then(|| {
        format!(
            "light {}: its center {center:.3} mm is inside an opaque mesh, behind back sides only",
            at + 1
        )
    })
}

/// Whether back sides of objects that pass are all that there is around `point`.
fn is_enclosed(prepared: &Prepared, point: DVec3, passes: impl Fn(usize) -> bool) -> bool {
    AROUND.into_iter().all(|direction| {
        let hit = prepared.bvh.closest_hit(&Ray { origin: point, direction }, None);
        hit.is_some_and(|hit| {
            let [a, b, c] = prepared.bvh.corners(hit.triangle);
            let is_back = (b - a).cross(c - a).dot(direction) > 0.0;
            is_back && passes(prepared.bvh.locate(hit.triangle).0)
        })
    })
}
