//! Sources with a body: the test lamp of a paraboloid and a filament, and sets of measured rays.
//!
//! Reference intensities: a path tracer (Mitsuba 3.9.1) and closed forms, measured for this project.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::DVec3;
use lampyris::color::Photometry;
use lampyris::geometry::mesh::Shading;
use lampyris::geometry::{Mesh, Ray};
use lampyris::light::{RaySample, RaySet};
use lampyris::material::{LobeShape, Lobes, Material};
use lampyris::scene::{Light, Prepared, Scene, Shadows};
use lampyris::shading::{TraceLimits, TraceState, Tracer};
use lampyris::source::emitter::{Radiance, Shape, fitted_shape, measured_emitter};
use lampyris::source::{Cylinder, Emitter};
use lampyris::spectrum::{Bands, Spectrum, WavelengthGrid};

use crate::stage::*;

const FOCAL_MM: f64 = 25.0;
const FLUX_LM: f64 = 440.0;

fn filament() -> Cylinder {
    Cylinder {
        center: DVec3::Z * FOCAL_MM,
        axis: DVec3::X,
        radius_mm: 0.5,
        length_mm: 5.5,
        flux_lm: FLUX_LM,
        samples: 2000,
        seed: 1,
    }
}

fn visible_filament() -> Light {
    Light {
        rays: filament().rayset().unwrap(),
        spectrum: Spectrum::blackbody(2856.0),
        surface: Some(filament().surface().unwrap()),
    }
}

/// z = r²/(4 f) from r = 12 to 60 mm, its front toward the axis, with the surface's own normals.
fn paraboloid() -> Mesh {
    let (around, along) = (480, 120);
    let point = |k: usize| {
        let angle = -TAU * (k % (around + 1)) as f64 / around as f64;
        let r = 12.0 + 48.0 * (k / (around + 1)) as f64 / along as f64;
        DVec3::new(r * angle.cos(), r * angle.sin(), r * r / (4.0 * FOCAL_MM))
    };
    let points: Vec<DVec3> = (0..(around + 1) * (along + 1)).map(point).collect();
    let normal = |p: &DVec3| DVec3::new(-p.x, -p.y, 2.0 * FOCAL_MM).normalize();
    let normals = points.iter().map(normal).collect();
    let grid: Vec<_> = points.iter().copied().map(Some).collect();
    let mesh = Mesh::from_grid("paraboloid", around, along, &grid).unwrap();
    Mesh { shading: Shading::PerPosition(normals), ..mesh }
}

fn absolute(objects: Vec<(Mesh, Material)>, lights: Vec<Light>) -> Scene {
    Scene { photometry: Photometry::Absolute, shadows: Shadows::On, ..scene(objects, lights) }
}

/// Luminance along a ray.
fn seen(prepared: &Prepared, ray: Ray) -> f64 {
    seen_within(prepared, ray, 0.0)
}

fn seen_within(prepared: &Prepared, ray: Ray, light_error: f64) -> f64 {
    let tables = prepared.tables(WavelengthGrid::Step20).unwrap();
    let limits = TraceLimits { light_error, ..exact(8).limits };
    let tracer = Tracer { prepared, tables, limits };
    let mut sum = Bands::zero(tables.bands);
    tracer.trace(ray, &mut TraceState::default(), &mut sum);
    sum.dot(&tables.luminance_weights)
}

/// cd toward (h, v) degrees: luminance over parallel rays through a square of 126 mm.
fn intensity(prepared: &Prepared, direction: [f64; 2]) -> f64 {
    intensity_of::<500>(direction, |ray| seen(prepared, ray))
}

fn intensity_of<const SIDE: usize>([h, v]: [f64; 2], seen: impl Fn(Ray) -> f64) -> f64 {
    let (h, v) = (h.to_radians(), v.to_radians());
    let toward = DVec3::new(h.sin() * v.cos(), v.sin(), h.cos() * v.cos());
    let right = DVec3::Y.cross(toward).normalize();
    let up = toward.cross(right);
    let cell = 126.0 / SIDE as f64;
    let at = |k: usize| (k as f64 + 0.5) * cell - 63.0;
    let ray = |k: usize| Ray {
        origin: right * at(k % SIDE) + up * at(k / SIDE) + toward * 1000.0,
        direction: -toward,
    };
    let sum: f64 = (0..SIDE * SIDE).map(|k| seen(ray(k))).sum();
    sum * cell * cell * 1e-6
}

#[test]
fn the_bare_test_lamp_has_its_reference_intensities() {
    let mirror = Material { reflectance: Spectrum::constant(0.9), k_rg: 1.0, ..material() };
    let lamp = absolute(vec![(paraboloid(), mirror)], vec![visible_filament()]);
    let lamp = lamp.prepare().unwrap();
    // Mean of the path tracer's 75,510 and a numeric 75,416.
    assert_close(intensity(&lamp, [0.0, 0.0]), 75_460.0, 0.003, "on axis");
    // The path tracer's noise is about 1 %, and 5 % near 45 cd.
    assert_close(intensity(&lamp, [2.0, 0.0]), 34_127.0, 0.02, "2, 0");
    assert_close(intensity(&lamp, [4.0, 0.0]), 13_999.0, 0.02, "4, 0");
    // Beside the beam only the filament itself: L 2 r l cos h, 44.6 cd at h = 0. The path tracer's
    // 39 to 46 scatter around that. Four rays across the filament leave 2 %.
    let itself = FLUX_LM / (PI * TAU * 0.5 * 5.5) * 5.5;
    assert_close(intensity(&lamp, [0.0, 4.0]), itself, 0.03, "0, 4");
    let aside = itself * 20f64.to_radians().cos();
    assert_close(intensity(&lamp, [20.0, 4.0]), aside, 0.03, "20, 4");
}

/// The microfacet reference (Beckmann 0.01826) in all directions of the beam over 100 cd: it is the
/// lobe of n_s = 1500, which about the mirror direction is −7 to +40 % off.
#[test]
fn the_rough_test_lamp_is_a_microfacet_mirror() {
    let lobes = Lobes { shape: LobeShape::Half, ..specular(1.0, 1500.0) };
    let mirror = Material { reflectance: Spectrum::constant(0.9), lobes, ..material() };
    // All of the mirror sees the same samples in its lobes: 2,000 were 5 % off by chance.
    let filament = Cylinder { samples: 200_000, ..filament() };
    let rays = filament.rayset().unwrap();
    let light = Light { surface: None, rays, ..visible_filament() };
    let lamp =
        Scene { shadows: Shadows::Off, ..absolute(vec![(paraboloid(), mirror)], vec![light]) };
    let lamp = lamp.prepare().unwrap();
    // The filament itself is seen, too.
    let itself = FLUX_LM / (PI * TAU * 0.5 * 5.5) * 5.5;
    let reference = [
        ([0.0, 0.0], 25_817.0),
        ([2.0, 0.0], 19_385.0),
        ([4.0, 0.0], 8_124.0),
        ([6.0, 0.0], 1_771.0),
        ([0.0, 4.0], 964.0),
        ([6.0, 4.0], 109.0),
    ];
    for ([h, v], expected) in reference {
        let mirrored = intensity_of::<90>([h, v], |ray| seen_within(&lamp, ray, 0.003));
        let all = mirrored + itself * h.to_radians().cos();
        // The path tracer's noise is about 1 % in the beam, and 3 % at 109 cd.
        let tolerance = if expected > 900.0 { 0.02 } else { 0.04 };
        assert_close(all, expected, tolerance, &format!("{h}, {v}"));
    }
}

#[test]
fn a_visible_cylinder_has_its_radiance_in_front_and_none_behind() {
    let alone = absolute(vec![(square(-50.0, 1.0), material())], vec![visible_filament()]);
    let alone = alone.prepare().unwrap();
    let toward_axis = Ray { origin: DVec3::Z * 100.0, direction: DVec3::NEG_Z };
    let expected = FLUX_LM / (PI * TAU * 0.5 * 5.5 * 1e-6);
    assert_close(seen(&alone, toward_axis), expected, 1e-5, "front");
    let from_inside = Ray { origin: DVec3::Z * FOCAL_MM, direction: DVec3::Z };
    assert_eq!(seen(&alone, from_inside), 0.0);
}

#[test]
fn a_visible_light_needs_absolute_photometry() {
    let relative = scene(vec![(square(-50.0, 1.0), material())], vec![visible_filament()]);
    assert_eq!(
        relative.prepare().unwrap_err().to_string(),
        "scene: a visible light has a radiance, which has no unit in relative photometry: set \
         photometry = \"absolute\""
    );
}

/// Independent random numbers in 0 to 1 (SplitMix64).
fn fraction(i: u32, k: u64) -> f64 {
    let mut x = (u64::from(i) * 8 + k).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((x ^ (x >> 31)) >> 11) as f64 * 2f64.powi(-53)
}

/// Rays of a shape with a radiance that falls as cosᵏ of the polar angle, started far around it.
fn rays_of(shape: Shape, k: f64, count: u32) -> RaySet {
    let ray = |i: u32| {
        let place = shape.place(fraction(i, 0), fraction(i, 1));
        let cos = fraction(i, 2).powf(1.0 / (k + 2.0));
        let (sin, azimuth) = ((1.0 - cos * cos).sqrt(), TAU * fraction(i, 3));
        let bitangent = place.normal.cross(place.tangent);
        let direction =
            place.normal * cos + (place.tangent * azimuth.cos() + bitangent * azimuth.sin()) * sin;
        let around = Shape::Sphere { center: DVec3::ZERO, radius_mm: 15.0 };
        let start = around.exit_of(shape.point(&place), direction);
        RaySample {
            position: start.as_vec3().to_array(),
            direction: direction.as_vec3().to_array(),
            flux: 1.0,
        }
    };
    RaySet::new((0..count).map(ray).collect(), FLUX_LM)
}

const CYLINDER: Shape =
    Shape::Cylinder { center: DVec3::ZERO, axis: DVec3::X, radius_mm: 0.65, length_mm: 4.1 };

#[test]
fn the_radiance_of_a_measured_cylinder_is_its_flux_over_pi_and_area() {
    let rays = rays_of(CYLINDER, 0.0, 10_000);
    let shape = fitted_shape(&rays.samples).unwrap();
    let (_, Emitter { radiance, .. }) = measured_emitter(&rays, shape, 1).unwrap();
    let Radiance::Measured(table) = radiance else { panic!("a table") };
    let expected = 1.0 / (PI * CYLINDER.area_mm2());
    let place = CYLINDER.place(0.3, 0.4);
    let reading = table.at(CYLINDER.point(&place), place.normal);
    assert!((reading.radiance - expected).abs() < 2.0 * reading.sigma + 0.01 * expected);
    assert!(table.noise() < 0.05, "{} {:?}", table.noise(), table.cells());
}

#[test]
fn stated_errors_of_radiance_are_honest() {
    let rays = rays_of(CYLINDER, 2.0, 100_000);
    let (_, Emitter { radiance, .. }) = measured_emitter(&rays, CYLINDER, 1).unwrap();
    let Radiance::Measured(table) = radiance else { panic!("a table") };
    // cos² with the flux of 1: L = 2/(π A) cos² θ; over a cell of sin²θ the mean is linear in it.
    let (mut within, mut cells) = (0.0, 0.0);
    for (point, direction, reading) in table.cell_readings() {
        let cos = direction.dot(CYLINDER.place_of(point).normal);
        let truth = 2.0 * cos * cos / (PI * CYLINDER.area_mm2());
        within += f64::from(u8::from((reading.radiance - truth).abs() < 2.0 * reading.sigma));
        cells += 1.0;
    }
    println!("{:?}: {within} of {cells} within 2 sigma", table.cells());
    assert!((within / cells - 0.95).abs() < 0.04 || cells < 100.0, "{within} of {cells}");
}

/// From the samples of a measured set, a reflector returns what the true cylinder makes it return.
#[test]
fn measured_rays_light_the_test_lamp_like_their_source() {
    let shape = Shape::Cylinder {
        center: DVec3::Z * FOCAL_MM,
        axis: DVec3::X,
        radius_mm: 0.5,
        length_mm: 5.5,
    };
    let rays = rays_of(shape, 0.0, 100_000);
    let mirror = Material { reflectance: Spectrum::constant(0.9), k_rg: 1.0, ..material() };
    let (rays, surface) = measured_emitter(&rays, shape, 1).unwrap();
    let light = Light { rays, spectrum: Spectrum::blackbody(2856.0), surface: Some(surface) };
    let lamp = absolute(vec![(paraboloid(), mirror)], vec![light]).prepare().unwrap();
    assert_close(intensity(&lamp, [0.0, 0.0]), 75_460.0, 0.02, "on axis");
    assert_close(intensity(&lamp, [2.0, 0.0]), 34_127.0, 0.03, "2, 0");
}

#[test]
fn rays_see_only_the_nearest_surface_of_a_light_and_shadows_spare_its_own() {
    let wall =
        Material { reflectance: Spectrum::constant(1.0), lobes: diffuse(1.0, 1.0), ..material() };
    let lit = |surface: bool| {
        let light =
            Light { surface: surface.then(|| filament().surface().unwrap()), ..visible_filament() };
        let scene = absolute(vec![(square(0.0, 5.0), wall.clone())], vec![light]);
        let slanted = DVec3::new(0.0, 60.0, 80.0);
        seen(&scene.prepare().unwrap(), Ray { origin: slanted, direction: -slanted.normalize() })
    };
    // Half of the samples are turned away; none that is turned to the wall is hidden by its own
    // surface. 1e-7: one scene asks sample by sample, the other adds them up in f32 lanes.
    assert_close(lit(true), lit(false), 1e-7, "wall");
}

#[test]
fn an_emitter_mesh_keeps_its_flux_wherever_it_is_moved() {
    let shape = Shape::Sphere { center: DVec3::ZERO, radius_mm: 2.0 };
    let mesh = Arc::new(shape.mesh().unwrap());
    let area_mm2 = lampyris::source::emitter::mesh_area(&mesh);
    let rays = lampyris::source::emitter::mesh_rayset(&mesh, FLUX_LM, (1000, 1)).unwrap();
    let world_from_local = glam::DAffine3::from_scale_rotation_translation(
        DVec3::splat(3.0),
        glam::DQuat::IDENTITY,
        DVec3::X,
    );
    let light = Light {
        rays: RaySet { world_from_local, ..rays },
        spectrum: Spectrum::blackbody(2856.0),
        surface: Some(Emitter { mesh, radiance: Radiance::Lambert { area_mm2 } }),
    };
    let alone = absolute(vec![(square(-50.0, 1.0), material())], vec![light]).prepare().unwrap();
    let ray = Ray { origin: DVec3::new(1.0, 0.0, 100.0), direction: DVec3::NEG_Z };
    assert_close(seen(&alone, ray), FLUX_LM / (PI * 9.0 * area_mm2 * 1e-6), 1e-9, "moved");
}
