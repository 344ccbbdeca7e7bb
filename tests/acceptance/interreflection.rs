//! Light that bounces, against closed forms.

use std::f64::consts::PI;

use glam::DVec3;
use lampyris::color::Photometry;
use lampyris::geometry::{Mesh, Ray};
use lampyris::light::{RaySample, RaySet};
use lampyris::material::Material;
use lampyris::render::{Quality, check_light_error};
use lampyris::scene::{Interreflection, Light, Prepared, Scene, Shadows};
use lampyris::shading::{self, TraceLimits, TraceState, Tracer};
use lampyris::source::emitter::Shape;
use lampyris::spectrum::{Bands, Spectrum, WavelengthGrid};
use lampyris::view::View;

use crate::stage::*;

fn white(rho: f64) -> Material {
    Material { reflectance: Spectrum::constant(rho), lobes: diffuse(1.0, 1.0), ..material() }
}

fn lit(objects: Vec<(Mesh, Material)>, light: Light, bounces: u32, samples: usize) -> Prepared {
    let scene = Scene {
        photometry: Photometry::Absolute,
        shadows: Shadows::On,
        interreflection: Some(Interreflection { bounces, samples, seed: 1, by_light: false }),
        ..scene(objects, vec![light])
    };
    shading::prepare(scene, &[]).expect("a good scene")
}

fn seen(prepared: &Prepared, ray: Ray) -> f64 {
    let tables = prepared.tables(WavelengthGrid::Step20).unwrap();
    let mut limits = exact(2).limits;
    limits.light_error = 0.01;
    let tracer = Tracer { prepared, tables, limits };
    let mut sum = Bands::zero(tables.bands);
    tracer.trace(ray, &mut TraceState::default(), &mut sum);
    sum.dot(&tables.luminance_weights)
}

/// A point of six Lambert samples, ± along each axis: intensity (Φ/6π)(|x| + |y| + |z|).
fn star() -> Light {
    let samples = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|axis| [axis, -axis]);
    let sample = |direction: DVec3| RaySample {
        position: [0.0; 3],
        direction: direction.as_vec3().to_array(),
        flux: 1.0,
    };
    Light::new(RaySet::new(samples.map(sample).collect(), 100.0), Spectrum::blackbody(2856.0))
}

/// In a sphere the light returned from anywhere falls evenly everywhere, so that bounces give
/// E₀ (ρ + ρ² + …) beside the direct E.
#[test]
fn walls_of_a_sphere_light_each_other() {
    let sphere = || Shape::Sphere { center: DVec3::ZERO, radius_mm: 50.0 }.smooth_mesh().unwrap();
    for (rho, bounces, tolerance) in [(0.2, 8, 0.01), (0.5, 16, 0.01), (0.9, 100, 0.01)] {
        let inside = vec![(sphere().turned_inside_out(), white(rho))];
        let prepared = lit(inside, star(), bounces, 40_000);
        let (mut indirect, mut count) = (0.0, 0.0);
        for i in 0..40 {
            let z = 1.0 - (2 * i + 1) as f64 / 40.0;
            let (sin, cos) = (2.4 * f64::from(i)).sin_cos();
            let across = (1.0 - z * z).sqrt();
            let direction = DVec3::new(across * cos, across * sin, z);
            let intensity = 100.0 / (6.0 * PI) * direction.abs().element_sum();
            let direct = rho / PI * intensity / 0.05f64.powi(2);
            let ray = Ray { origin: DVec3::ZERO, direction };
            let found = seen(&prepared, ray) - direct;
            indirect += found;
            count += 1.0;
        }
        let e0 = 100.0 / (4.0 * PI * 0.05f64.powi(2));
        // ρ E₀ ρ/(1 − ρ)/π: all but the direct light's own return.
        let expected = rho * e0 * rho / (1.0 - rho) / PI;
        assert_close(indirect / count, expected, tolerance, &format!("rho {rho}"));
    }
}

#[test]
fn threads_change_no_bounced_sample() {
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let sphere = Shape::Sphere { center: DVec3::ZERO, radius_mm: 5.0 };
            let inside = vec![(sphere.mesh().unwrap().turned_inside_out(), white(0.5))];
            let prepared = lit(inside, star(), 3, 5000);
            prepared.scene.lights.iter().map(|l| l.rays.samples.to_vec()).collect::<Vec<_>>()
        })
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn the_opal_box_has_its_flux_and_homogeneity() {
    // 40 × 40 × 10 mm, ρ = 0.9; the sheet (R 0.5, T 0.4) looks outward.
    let white = white(0.9);
    let [x, y, z] = [DVec3::X * 20.0, DVec3::Y * 20.0, DVec3::Z * 5.0];
    let middle = DVec3::Z * 5.0;
    let opal = Material {
        reflectance: Spectrum::constant(0.5),
        transmittance: Some(Spectrum::constant(0.4)),
        k_tg: 1e-9,
        lobes: diffuse(1.0, 1.0),
        ..material()
    };
    let walls = [
        rectangle(DVec3::ZERO, x, y),
        rectangle(middle - x, y, z),
        rectangle(middle + x, z, y),
        rectangle(middle - y, z, x),
        rectangle(middle + y, x, z),
    ];
    let mut objects: Vec<_> = walls.into_iter().map(|wall| (wall, white.clone())).collect();
    objects.push((rectangle(DVec3::Z * 10.0, x, y), opal));
    let light = point_light(DVec3::Z * 1e-3, DVec3::Z, 100.0);
    let prepared = lit(objects, light, 60, 200_000);
    let mut cells = [0.0f64; 64];
    const PER_CELL: usize = 3;
    for (cell, mean) in cells.iter_mut().enumerate() {
        for k in 0..PER_CELL * PER_CELL {
            let place = |cell: usize, k: usize| {
                (cell as f64 + (k as f64 + 0.5) / PER_CELL as f64) * 5.0 - 20.0
            };
            let origin =
                DVec3::new(place(cell % 8, k % PER_CELL), place(cell / 8, k / PER_CELL), 50.0);
            *mean += seen(&prepared, Ray { origin, direction: DVec3::NEG_Z });
        }
        *mean /= (PER_CELL * PER_CELL) as f64;
    }
    let flux = PI * cells.iter().sum::<f64>() / 64.0 * 0.04 * 0.04;
    assert_close(flux / 100.0, 0.659, 0.01, "flux out");
    // By symmetry four cells are the darkest and four the brightest. 3·10⁷ random walks between the
    // walls give 0.6590 and 0.1697; the one darkest cell of a picture with noise is darker than that.
    let mean = |of: [usize; 4]| of.map(|cell| cells[cell]).iter().sum::<f64>() / 4.0;
    let homogeneity = mean([0, 7, 56, 63]) / mean([27, 28, 35, 36]);
    // The noise of the darkest cells is 0.8 % after that.
    assert_close(homogeneity, 0.1697, 0.015, "homogeneity");
}

/// Numbers that look random: 0 to 1.
fn fraction(seed: u32, k: u32) -> f64 {
    (f64::from(seed * 131 + k) * 0.754_877_666_246_693).fract()
}

/// Boxes of any size and colour with a mirror, a sheet and a plate in them.
fn random_room(seed: u32, shadows: Shadows) -> Prepared {
    let at = |k: u32| fraction(seed, k);
    let half = DVec3::new(10.0 + 30.0 * at(1), 10.0 + 30.0 * at(2), 5.0 + 20.0 * at(3));
    let wall = |rho: f64| Material {
        lobes: diffuse(1.0, 1.0 + 4.0 * at(4)),
        reflectance: Spectrum::from_pairs("wall", [(400.0, rho), (700.0, at(5))]).unwrap(),
        ..material()
    };
    let mirror = Material { k_rg: 0.9, lobes: specular(0.05, 300.0), ..white(0.9) };
    let opal = Material { transmittance: Some(Spectrum::constant(0.4)), k_tg: 1e-9, ..white(0.5) };
    let [x, y, z] = [DVec3::X * half.x, DVec3::Y * half.y, DVec3::Z * half.z];
    let plate = DVec3::new(at(6) - 0.5, at(7) - 0.5, at(8) - 0.5) * half;
    let objects = vec![
        (rectangle(-z, x, y), wall(at(9))),
        (rectangle(-x, y, z), wall(at(10))),
        (rectangle(x, z, y), mirror),
        (rectangle(-y, z, x), wall(0.9)),
        (rectangle(z, x, y), opal),
        (rectangle(plate, x * 0.3, z * 0.3), wall(0.5)),
    ];
    let toward = DVec3::new(at(11) - 0.5, at(12) - 0.5, at(13) - 0.5);
    let light = point_light(DVec3::new(0.0, 0.3 * half.y, 0.0), toward, 100.0);
    let scene = Scene {
        photometry: Photometry::Absolute,
        shadows,
        interreflection: Some(Interreflection {
            bounces: 6,
            samples: 20_000,
            seed: u64::from(seed),
            by_light: false,
        }),
        ..scene(objects, vec![light])
    };
    shading::prepare(scene, &[]).expect("a good scene")
}

/// Thousands of samples all around a hit, many of them near it, keep the bound of their sum.
#[test]
fn sums_of_bounced_light_keep_their_bound() {
    for seed in 0..8 {
        let prepared = random_room(seed, Shadows::Off);
        for light_error in [0.1, 0.01] {
            let limits = TraceLimits { light_error, ..exact(3).limits };
            let view = View { fov_deg: 25.0, ..pixel_view(8.0 * f64::from(seed) - 28.0, 100.0) };
            let quality = Quality { limits, ..exact(3) };
            let check = check_light_error(&prepared, &view, &quality, 60).unwrap();
            let check = check.expect("light");
            assert!(check.largest <= light_error, "{seed}: {check:?}");
            // Single sums' own estimates are lower than that, and too low by half now and then.
            assert!(check.largest_of_estimate <= 2.0, "{seed}: {check:?}");
        }
    }
}
