//! What can be rendered but was hardly meant: noticed once the scene is prepared.

use super::overlap::overlap_warning;
use crate::geometry::{DVec3, Mesh, Ray};
use crate::light::RaySample;
use crate::scene::{Prepared, Scene, SurfaceKind};
use crate::view::View;

/// Smaller scenes are lamps whose meshes were made in meters, more often than not, mm.
const SMALLEST_SCENE_MM: f64 = 1.0;

/// Six directions that see every wall of a room.
const AROUND: [DVec3; 6] = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];

/// Warnings about the scene, for people.
pub fn of_scene(prepared: &Prepared) -> Vec<String> {
    let mut warnings: Vec<String> = size_warning(prepared).into_iter().collect();
    warnings.extend(unit_warnings(&prepared.scene));
    let objects = 0..prepared.scene.objects.len();
    warnings.extend(objects.clone().filter_map(|at| normals_warning(&prepared.scene, at)));
    warnings.extend(objects.filter_map(|at| body_warning(prepared, at)));
    warnings.extend(overlap_warning(prepared));
    // What bounces lies on surfaces of itself.
    let all = prepared.scene.lights.len();
    let lights = 0..prepared.interreflection.map_or(all, |report| report.first_light);
    warnings.extend(lights.clone().filter_map(|at| light_warning(prepared, at)));
    warnings.extend(lights.filter_map(|at| near_field_warning(prepared, at)));
    warnings
}

/// A warning about where the eye is.
pub fn of_view(prepared: &Prepared, view: &View) -> Option<String> {
    let eye = view.camera().ray(0.0, 0.0).origin;
    let is_seen_through = |object: usize| {
        prepared
            .surfaces
            .of_object
            .get(object)
            .is_none_or(|surface| surface.kind != SurfaceKind::Body)
    };
    is_enclosed(prepared, eye, is_seen_through).then(|| {
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

/// Units that CAD systems write instead of mm, with their length in mm.
const UNITS: [(&str, f64); 2] = [("m", 1000.0), ("inch", 25.4)];

/// Objects so small among the others that they would fit if their lengths were in another unit.
fn unit_warnings(scene: &Scene) -> Vec<String> {
    let bounds: Vec<[DVec3; 2]> = scene.objects.iter().map(|o| o.mesh.bounds()).collect();
    let whole = bounds.iter().copied().reduce(joined);
    let largest_mm = whole.map_or(0.0, |[low, high]| (high - low).max_element());
    let warning = |at: usize| {
        let size = bounds[at][1] - bounds[at][0];
        if size.max_element() > largest_mm / 10.0 {
            return None;
        }
        let others = (0..bounds.len()).filter(|&other| other != at).map(|other| bounds[other]);
        let [low, high] = others.reduce(joined)?;
        let (unit, mm) = UNITS.into_iter().find(|&(_, mm)| fits(size * mm, high - low, mm))?;
        let (size, rest) = (size.max_element(), (high - low).max_element());
        Some(format!(
            "scene: object {} is {size:.3} mm across among objects of {rest:.0} mm: is it in {unit}? \
             unit = \"{unit}\" (factor {mm}) makes it {:.0} mm",
            at + 1,
            size * mm
        ))
    };
    (0..bounds.len()).filter_map(warning).collect()
}

fn joined([low, high]: [DVec3; 2], [other_low, other_high]: [DVec3; 2]) -> [DVec3; 2] {
    [low.min(other_low), high.max(other_high)]
}

/// Whether a part of this size belongs among the others: roughly as large, if it was a thousand times
/// smaller; as long and as wide within a quarter, if only 25 times: chips of LEDs are as small.
fn fits(size: DVec3, others: DVec3, mm: f64) -> bool {
    let ratio = size.max_element() / others.max_element();
    if mm > 100.0 {
        return (0.3..3.0).contains(&ratio);
    }
    let is_alike = |axis: usize| (0.8..1.25).contains(&(size[axis] / others[axis]));
    let narrowest = (0..3).min_by(|&a, &b| others[a].total_cmp(&others[b])).unwrap_or(2);
    (0..3).filter(|&axis| axis != narrowest).all(is_alike)
}

/// A mesh whose normals are of no use, since they belong to its backs.
fn normals_warning(scene: &Scene, object: usize) -> Option<String> {
    let opposed = scene.objects[object].mesh.opposed_share();
    let name = &scene.materials[scene.objects[object].material.0].name;
    (opposed > Mesh::OPPOSED_SHARE).then(|| {
        format!(
            "object {}, {name}: vertex normals oppose the winding on {:.0} % of the area, which is \
             shaded flat: turn over the faces or the normals where the mesh was made",
            object + 1,
            100.0 * opposed
        )
    })
}

/// A mesh that is not the body that its material asks for.
fn body_warning(prepared: &Prepared, object: usize) -> Option<String> {
    let closure = prepared.surfaces.of_object[object].closure?;
    let material = &prepared.scene.materials[prepared.scene.objects[object].material.0];
    let (number, name) = (object + 1, &material.name);
    let key = if material.thickness_mm.is_some() { "thickness" } else { "ior" };
    if !closure.is_closed() {
        return Some(format!(
            "object {number}, {name}: \"{key}\" asks for a closed body, but {} edges of the mesh bound \
             a hole or join triangles that face opposite sides; each of its surfaces is taken by \
             itself, with its front outside",
            closure.open_edges
        ));
    }
    (closure.volume_mm3 < 0.0).then(|| {
        format!(
            "object {number}, {name}: the mesh is inside out: its fronts look into the body, so that \
             rays count as outside where they are inside"
        )
    })
}

fn light_warning(prepared: &Prepared, at: usize) -> Option<String> {
    let rays = &prepared.scene.lights[at].rays;
    let sum: DVec3 = rays.samples.iter().map(RaySample::origin).sum();
    let center = rays.world_from_local.transform_point3(sum / rays.samples.len().max(1) as f64);
    is_enclosed(prepared, center, |object| prepared.blocks(at)[object]).then(|| {
        format!(
            "light {}: its center {center:.3} mm is inside an opaque mesh, behind back sides only",
            at + 1
        )
    })
}

/// A surface that a far field lights from too near.
fn near_field_warning(prepared: &Prepared, at: usize) -> Option<String> {
    const RAYS: usize = 1000;
    let rays = &prepared.scene.lights[at].rays;
    let good_beyond_mm = rays.good_beyond_mm * rays.scale();
    if good_beyond_mm == 0.0 {
        return None;
    }
    let hits = rays.samples.iter().step_by(rays.samples.len().div_ceil(RAYS).max(1));
    let hits = hits.filter_map(|sample| {
        let (origin, direction) = (rays.world_origin(sample), rays.world_direction(sample));
        prepared.bvh.closest_hit(&Ray { origin, direction }, None)
    });
    // Rays meet what is large, corners tell of what is small.
    let center = rays.world_from_local.translation;
    let corners = prepared.scene.objects.iter().flat_map(|object| &object.mesh.positions);
    let nearest_mm = hits
        .map(|hit| hit.distance_mm)
        .chain(corners.map(|corner| corner.distance(center)))
        .fold(f64::INFINITY, f64::min);
    (nearest_mm < good_beyond_mm).then(|| {
        format!(
            "light {}: a surface is {nearest_mm:.0} mm away, but a photometric file tells the light \
             beyond {good_beyond_mm:.0} mm, ten times the luminous opening: nearer, rays of a ray file \
             are needed",
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
