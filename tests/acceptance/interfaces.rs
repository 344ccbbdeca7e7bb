//! Bodies, interfaces and Fresnel's law against closed forms.

use lampyris::geometry::{DVec3, Mesh};
use lampyris::material::{
    Fresnel, Material, OpticalConstants, dielectric_reflectance, metal_reflectance,
};
use lampyris::render::{Quality, trace_paths};
use lampyris::scene::{Background, Scene};
use lampyris::shading::{PathSegment, RayKind, TraceLimits};
use lampyris::spectrum::{Spectrum, WavelengthGrid};
use lampyris::view::View;

use crate::stage::*;

/// f32 images.
const SINGLE: f64 = 1e-6;

/// A closed box from `low` to `high`, fronts outward.
fn block(low: DVec3, high: DVec3) -> Mesh {
    let corner = |i: usize| {
        let pick = |bit: usize, axis: usize| if i >> bit & 1 == 1 { high[axis] } else { low[axis] };
        DVec3::new(pick(0, 0), pick(1, 1), pick(2, 2))
    };
    let faces =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh::flat("block", (0..8).map(corner).collect(), triangles).expect("a good mesh")
}

/// 2000 mm wide and long, from z = `low` to `high`.
fn slab(low: f64, high: f64) -> Mesh {
    block(DVec3::new(-1000.0, -1000.0, low), DVec3::new(1000.0, 1000.0, high))
}

fn glass(ior: f64) -> Material {
    Material {
        transmittance: Some(Spectrum::constant(1.0)),
        ior: Some(Spectrum::constant(ior)),
        k_tg: 1.0,
        ..material()
    }
}

fn tinted(ior: f64, transmittance: f64) -> Material {
    let transmittance = Some(Spectrum::constant(transmittance));
    Material { transmittance, thickness_mm: Some(10.0), ..glass(ior) }
}

fn fresnel(ior: f64) -> Material {
    Material { fresnel: Fresnel::Dielectric, k_rg: 1.0, ..glass(ior) }
}

fn black() -> Material {
    Material { reflectance: Spectrum::constant(0.0), ..material() }
}

/// In a uniform surround of 1.
fn surrounded(objects: Vec<(Mesh, Material)>) -> Scene {
    Scene { background: Background::Even(Spectrum::constant(1.0)), ..scene(objects, vec![]) }
}

fn radiance(scene: Scene, angle_deg: f64, quality: &Quality) -> f64 {
    f64::from(shoot(scene, &pixel_view(angle_deg, 100.0), quality).pixel(0, 0)[40])
}

fn paths(scene: Scene, view: &View) -> Vec<PathSegment> {
    let prepared = scene.prepare().expect("a good scene");
    trace_paths(&prepared, view, &exact(16), [0.5, 0.5]).expect("good paths")
}

/// Angle from the axis of the last segment, and the light that is left.
fn exit_of(segments: &[PathSegment]) -> (f64, f64) {
    let last = segments.iter().rfind(|segment| segment.end.is_none()).expect("a ray that leaves");
    (last.direction.z.abs().acos().to_degrees(), last.throughput)
}

#[test]
fn a_slab_of_glass_passes_what_fresnel_says() {
    for angle_deg in [0.0f64, 30.0, 45.0, 60.0, 70.0, 80.0, 85.0] {
        let ior = 1.49;
        // Black behind, so that only what the slab mirrors comes from the surround.
        let scene =
            surrounded(vec![(slab(-10.0, 0.0), fresnel(ior)), (slab(-12.0, -11.0), black())]);
        let seen = radiance(scene, angle_deg, &exact(64));
        let r = dielectric_reflectance(angle_deg.to_radians().cos(), 1.0, ior);
        // R + (1 − R)² R + …, all bounces between both faces.
        let mirrored = 2.0 * r / (1.0 + r);
        assert!((seen - mirrored).abs() < 1e-4, "{angle_deg}: {seen}, expected {mirrored}");
        let clear = surrounded(vec![(slab(-10.0, 0.0), fresnel(ior))]);
        assert_close(radiance(clear, angle_deg, &exact(64)), 1.0, 1e-4, "all light");
    }
}

#[test]
fn a_right_angle_prism_mirrors_all_light() {
    // Legs along x and z; the eye on +z sees the hypotenuse from inside.
    let positions = [(0.0, 0.0), (20.0, 0.0), (0.0, -20.0)];
    let at = |y: f64| positions.map(|(x, z)| DVec3::new(x - 10.0, y, z + 1.0));
    let corners: Vec<DVec3> = at(-20.0).into_iter().chain(at(20.0)).collect();
    let triangles = vec![
        [0, 1, 2],
        [3, 5, 4],
        [0, 3, 4],
        [0, 4, 1],
        [1, 4, 5],
        [1, 5, 2],
        [2, 5, 3],
        [2, 3, 0],
    ];
    let mesh = Mesh::flat("prism", corners, triangles).expect("a good mesh");
    let seen = radiance(surrounded(vec![(mesh, fresnel(1.49))]), 0.0, &exact(64));
    assert!((seen - 1.0).abs() < SINGLE, "{seen}");
}

/// A straight rod whose walls a ray meets 50 times at 60°, past the critical 42.2°, before it leaves
/// by the end at 30°.
#[test]
fn a_light_guide_of_50_total_reflections_loses_nothing() {
    let width = 4.0;
    let length = 50.0 * width / 30f64.to_radians().tan();
    let rod = block(DVec3::new(-2.0, -2.0, -length), DVec3::new(2.0, 2.0, 0.0));
    let view = View {
        elevation_deg: 30.0,
        target: DVec3::new(0.0, 0.0, -2.0),
        fov_deg: 0.01,
        ..pixel_view(0.0, 1.0)
    };
    let clear = Material { reflectance: Spectrum::constant(1.0), ..glass(1.49) };
    let scene = surrounded(vec![(rod, clear)]);
    let prepared = scene.clone().prepare().expect("a good scene");
    let ways = trace_paths(&prepared, &view, &exact(64), [0.5, 0.5]).expect("good paths");
    assert!((51..=52).contains(&ways.len()), "{} segments", ways.len());
    let seen = f64::from(shoot(scene, &view, &exact(64)).pixel(0, 0)[40]);
    assert!((seen - 1.0).abs() < SINGLE, "{seen}");
}

/// Two bodies that touch, T 0.5 and 1 per 10 mm, 10 mm each, at 40°.
#[test]
fn two_shot_lenses_are_one_glass_in_any_order_and_with_any_gap() {
    let gaps = [(0.0, 0.0), (1e-12, 0.0), (1e-9, 0.0), (0.01, 0.02)];
    for (gap, contact_mm) in gaps {
        for turned in [false, true] {
            let mut objects = vec![
                (slab(-10.0, 0.0), tinted(1.49, 0.5)),
                (slab(-20.0 - gap, -10.0 - gap), tinted(1.49, 1.0)),
            ];
            if turned {
                objects.reverse();
            }
            let scene = Scene { contact_mm, ..surrounded(objects) };
            let segments = paths(scene, &pixel_view(40.0, 100.0));
            for inside in &segments[1..segments.len() - 1] {
                // Thin air between, 1e-9 mm, turns the ray there and back.
                let degrees = inside.direction.z.abs().acos().to_degrees();
                let is_in_air = gap == 1e-9 && (degrees - 40.0).abs() < 1e-6;
                assert!(is_in_air || (degrees - 25.5565).abs() < 1e-4, "{gap} {turned}: {degrees}");
            }
            let (angle, left) = exit_of(&segments);
            assert!((angle - 40.0).abs() < 1e-9, "gap {gap}, turned {turned}: leaves at {angle}");
            assert!((left - 0.4638).abs() < 5e-5, "gap {gap}, turned {turned}: {left} is left");
        }
    }
}

/// A body of n 1.6 in n 1.33 (0.9 per 10 mm), 10 mm on each side, at 40°.
#[test]
fn a_body_in_a_body_is_entered_from_it() {
    for turned in [false, true] {
        let mut objects =
            vec![(slab(-30.0, 0.0), tinted(1.33, 0.9)), (slab(-20.0, -10.0), tinted(1.6, 1.0))];
        if turned {
            objects.reverse();
        }
        let segments = paths(surrounded(objects), &pixel_view(40.0, 100.0));
        let angles: Vec<f64> =
            segments.iter().map(|s| s.direction.z.abs().acos().to_degrees()).collect();
        for (angle, expected) in angles.iter().zip([40.0, 28.901, 23.687, 28.901, 40.0]) {
            assert!((angle - expected).abs() < 1e-3, "{angles:?}");
        }
        let (_, left) = exit_of(&segments);
        assert!((left - 0.7861).abs() < 5e-5, "{left}");
    }
}

#[test]
fn nothing_passes_a_black_plate_on_glass() {
    for turned in [false, true] {
        for front in [false, true] {
            let plate = if front { slab(0.0, 1.0) } else { slab(-11.0, -10.0) };
            let mut objects = vec![(slab(-10.0, 0.0), glass(1.49)), (plate, black())];
            if turned {
                objects.reverse();
            }
            assert_eq!(radiance(surrounded(objects), 20.0, &exact(16)), 0.0);
        }
    }
}

/// The stronger of two bodies that overlap fills the overlap; the weaker one's face in it is gone.
#[test]
fn priorities_decide_where_bodies_overlap() {
    for (strong, expected) in [(0, [40.0, 28.901, 23.687, 40.0]), (1, [40.0, 28.901, 23.687, 40.0])]
    {
        let mut objects = vec![(slab(-10.0, 0.0), glass(1.33)), (slab(-20.0, -9.9), glass(1.6))];
        objects[strong].1.priority = 1;
        let segments = paths(surrounded(objects), &pixel_view(40.0, 100.0));
        let turns: Vec<&PathSegment> =
            segments.iter().filter(|s| s.depth > 0 || s.kind == RayKind::Camera).collect();
        let depth =
            |z: f64| turns.iter().filter_map(|s| s.end).any(|end| (end.point.z - z).abs() < 1e-9);
        let angles: Vec<f64> =
            turns.iter().map(|s| s.direction.z.abs().acos().to_degrees()).collect();
        assert!(
            (angles[0] - expected[0]).abs() < 1e-3
                && (angles.last().expect("rays") - 40.0).abs() < 1e-9
        );
        assert!(depth(-9.9) && depth(0.0), "{segments:?}");
        // Where the index changes: at the strong body's own face.
        let boundary = if strong == 0 { -10.0 } else { -9.9 };
        let change = segments.windows(2).find(|pair| {
            (pair[0].direction.z.abs().acos().to_degrees() - 28.901).abs() < 1e-3
                && (pair[1].direction.z.abs().acos().to_degrees() - 23.687).abs() < 1e-3
        });
        let end = change.expect("a change").first().and_then(|s| s.end).expect("a surface");
        assert!((end.point.z - boundary).abs() < 1e-9, "{strong}: {}", end.point.z);
    }
}

#[test]
fn an_eye_in_a_body_knows_it() {
    let view = pixel_view(30.0, 5.0);
    let segments = paths(
        surrounded(vec![(block(DVec3::splat(-50.0), DVec3::splat(50.0)), glass(1.5))]),
        &view,
    );
    let leaves = segments.last().expect("a ray").direction;
    let expected = (1.5 * 30f64.to_radians().sin()).asin();
    assert!((leaves.z.abs().acos() - expected).abs() < 1e-12);
}

/// A mirror of the program's own aluminium in a surround of 1, at every band.
#[test]
fn aluminium_mirrors_by_angle_and_wavelength() {
    let OpticalConstants { n, k } = OpticalConstants::aluminium();
    let metal = Material {
        fresnel: Fresnel::Metal { n: n.clone(), k: k.clone() },
        k_rg: 1.0,
        ..material()
    };
    for angle_deg in [0.0f64, 45.0, 80.0, 89.0] {
        let image = shoot(
            surrounded(vec![(slab(-1.0, 0.0), metal.clone())]),
            &pixel_view(angle_deg, 100.0),
            &exact(1),
        );
        for (band, lambda_nm) in WavelengthGrid::Step5.wavelengths_nm().enumerate() {
            let index = [n.at(lambda_nm), k.at(lambda_nm)];
            let expected = metal_reflectance(angle_deg.to_radians().cos(), 1.0, index);
            assert!((f64::from(image.pixel(0, 0)[band]) - expected).abs() < 1e-6);
        }
    }
}

/// A 60° prism of PMMA at minimum deviation of the d line: what leaves is turned by
/// 2 asin(n sin 30°) − 60° there, and by Snell's law twice at the C and F lines.
#[test]
fn a_prism_of_pmma_deviates_each_line_by_its_index() {
    let n = OpticalConstants::pmma().n;
    let incidence = (0.5 * n.at(587.56)).asin();
    let deviation = |index: f64| {
        let inside = 60f64.to_radians() - (incidence.sin() / index).asin();
        (incidence + (index * inside.sin()).asin()).to_degrees() - 60.0
    };
    // Its first face lies at z = 0, the second turned by 60° about y.
    let (sin, cos) = 60f64.to_radians().sin_cos();
    let corners =
        [DVec3::ZERO, DVec3::new(40.0, 0.0, 0.0), DVec3::new(40.0 * cos, 0.0, -40.0 * sin)];
    let at = |y: f64| corners.map(|c| c - DVec3::new(10.0, y, 0.0));
    let positions: Vec<DVec3> = at(20.0).into_iter().chain(at(-20.0)).collect();
    let triangles = vec![
        [0, 2, 1],
        [3, 4, 5],
        [0, 1, 4],
        [0, 4, 3],
        [1, 2, 5],
        [1, 5, 4],
        [2, 0, 3],
        [2, 3, 5],
    ];
    let mesh = Mesh::flat("prism", positions, triangles).expect("a good mesh");
    let quality = Quality { limits: TraceLimits { dispersion: 81, ..exact(8).limits }, ..exact(8) };
    let material = Material { ior: Some(n.clone()), ..glass(1.5) };
    let prepared = surrounded(vec![(mesh, material)]).prepare().expect("a good scene");
    // From the side of the apex, so that the ray is turned away from it.
    let view = pixel_view(-incidence.to_degrees(), 100.0);
    let segments = trace_paths(&prepared, &view, &quality, [0.5, 0.5]).expect("paths");
    let first = segments[0].direction;
    let turned: Vec<f64> = segments
        .iter()
        .filter(|segment| segment.depth == 2 && segment.kind == RayKind::Transmitted)
        .map(|segment| segment.direction.dot(first).acos().to_degrees())
        .collect();
    assert_eq!(turned.len(), 81);
    let bands: Vec<(f64, f64)> =
        WavelengthGrid::Step5.wavelengths_nm().zip(turned.into_iter().rev()).collect();
    let by_band = Spectrum::from_pairs("deviation", bands).expect("a good table");
    for lambda_nm in [656.27, 587.56, 486.13] {
        let (found, expected) = (by_band.at(lambda_nm), deviation(n.at(lambda_nm)));
        assert!((found - expected).abs() < 1e-3, "{lambda_nm}: {found}, expected {expected}");
    }
}

/// Every group of bands leaves a 60° prism in the direction of its own n(λ).
#[test]
fn dispersion_turns_every_band_by_its_own_index() {
    let n_of = |lambda_nm: f64| 1.48 + 4000.0 / (lambda_nm * lambda_nm);
    let table = WavelengthGrid::Step5.wavelengths_nm().map(|l| (l, n_of(l)));
    let ior = Spectrum::from_pairs("n", table).expect("a good table");
    let glass = Material { ior: Some(ior), ..glass(1.5) };
    let quality = Quality { limits: TraceLimits { dispersion: 81, ..exact(8).limits }, ..exact(8) };
    let prepared = surrounded(vec![(slab(-10.0, 0.0), glass)]).prepare().expect("a good scene");
    let segments =
        trace_paths(&prepared, &pixel_view(50.0, 100.0), &quality, [0.5, 0.5]).expect("paths");
    let inside: Vec<f64> = segments
        .iter()
        .filter(|s| s.depth == 1)
        .map(|s| s.direction.z.abs().acos().to_degrees())
        .collect();
    assert_eq!(inside.len(), 81);
    // The last group is followed first.
    for (angle, lambda_nm) in inside.iter().rev().zip(WavelengthGrid::Step5.wavelengths_nm()) {
        let expected = (50f64.to_radians().sin() / n_of(lambda_nm)).asin().to_degrees();
        assert!((angle - expected).abs() < 1e-9, "{lambda_nm}: {angle} {expected}");
    }
    let whole = radiance(
        surrounded(vec![(slab(-10.0, 0.0), fresnel(1.5))]),
        30.0,
        &Quality { limits: TraceLimits { dispersion: 5, ..quality.limits }, ..quality },
    );
    assert_close(whole, 1.0, 1e-4, "constant indices do not split");
}

/// A wall behind a filter of T = 0.1.
#[test]
fn light_through_a_filter_is_attenuated_in_absolute_photometry() {
    use lampyris::color::Photometry::{Absolute, Relative};
    use lampyris::scene::Shadows;
    let wall = Material { lobes: diffuse(1.0, 1.0), ..material() };
    let light = || vec![point_light(DVec3::Z * 100.0, DVec3::NEG_Z, 1.0)];
    let tint = Some(Spectrum::constant(0.1));
    let sheet = Material { transmittance: tint.clone(), k_tg: 1.0, ..material() };
    let body = Material { thickness_mm: Some(4.0), ..sheet.clone() };
    let lamp = |between: Option<(Mesh, Material)>, photometry, shadows| {
        let mut objects = vec![(square(0.0, 50.0), wall.clone())];
        objects.extend(between);
        let scene = Scene { shadows, photometry, ..scene(objects, light()) };
        f64::from(shoot(scene, &pixel_view(45.0, 200.0), &exact(0)).pixel(0, 0)[40])
    };
    let free = lamp(None, Absolute, Shadows::On);
    let filter = || Some((square(50.0, 5.0), sheet.clone()));
    let plate = block(DVec3::new(-5.0, -5.0, 48.0), DVec3::new(5.0, 5.0, 50.0));
    assert_close(lamp(filter(), Absolute, Shadows::On) / free, 0.1, SINGLE, "filter");
    let half = lamp(Some((plate, body)), Absolute, Shadows::On) / free;
    assert_close(half, 0.1f64.sqrt(), SINGLE, "half of the thickness");
    assert_eq!(lamp(filter(), Absolute, Shadows::Off), free);
    let free = lamp(None, Relative, Shadows::On);
    assert_eq!(lamp(filter(), Relative, Shadows::On), free, "the paper's photometry");
}

/// Where two bodies overlap only the stronger one is there, for light as for eyes.
#[test]
fn light_through_overlapping_bodies_is_attenuated_by_the_stronger() {
    use lampyris::color::Photometry::Absolute;
    use lampyris::scene::Shadows;
    let wall = Material { lobes: diffuse(1.0, 1.0), ..material() };
    let body = |transmittance: f64, priority: i32| Material {
        transmittance: Some(Spectrum::constant(transmittance)),
        thickness_mm: Some(1.0),
        k_tg: 1.0,
        priority,
        ..material()
    };
    let plate =
        |low: f64, high: f64| block(DVec3::new(-9.0, -9.0, low), DVec3::new(9.0, 9.0, high));
    let lamp = |bodies: Vec<(Mesh, Material)>| {
        let mut objects = vec![(square(0.0, 50.0), wall.clone())];
        objects.extend(bodies);
        let light = point_light(DVec3::Z * 100.0, DVec3::NEG_Z, 1.0);
        let scene =
            Scene { shadows: Shadows::On, photometry: Absolute, ..scene(objects, vec![light]) };
        f64::from(shoot(scene, &pixel_view(45.0, 200.0), &exact(0)).pixel(0, 0)[40])
    };
    let free = lamp(vec![]);
    // 2 mm of 0.5, 3 mm of 0.8, of which 1 mm is in both.
    for (strong, expected) in [(0, 0.5f64.powi(2) * 0.8f64.powi(2)), (1, 0.5 * 0.8f64.powi(3))] {
        let bodies = |turned: bool| {
            let priority = |at: usize| i32::from(at == strong);
            let mut bodies = vec![
                (plate(50.0, 52.0), body(0.5, priority(0))),
                (plate(51.0, 54.0), body(0.8, priority(1))),
            ];
            bodies.rotate_left(usize::from(turned));
            bodies
        };
        for turned in [false, true] {
            assert_close(lamp(bodies(turned)) / free, expected, SINGLE, "overlap");
        }
    }
    // Without `thickness`, faces inside of a stronger body are no interfaces.
    let glass = |priority: i32| Material { thickness_mm: None, ..body(0.5, priority) };
    let glass = |priority: i32| Material { ior: Some(Spectrum::constant(1.5)), ..glass(priority) };
    let inner = vec![(plate(50.0, 54.0), glass(1)), (plate(51.0, 52.0), glass(0))];
    assert_close(lamp(inner) / free, 0.25, SINGLE, "hidden in a stronger body");
}
