//! Light that bounces, against closed forms.

use std::f64::consts::PI;

use glam::DVec3;
use lampyris::color::Photometry;
use lampyris::geometry::{Mesh, Ray};
use lampyris::light::{RaySample, RaySet};
use lampyris::material::Material;
use lampyris::scene::{Interreflection, Light, Prepared, Scene, Shadows};
use lampyris::shading::{self, TraceState, Tracer};
use lampyris::source::emitter::Shape;
use lampyris::spectrum::{Bands, Spectrum, WavelengthGrid};

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
    let darkest = cells.iter().copied().fold(f64::INFINITY, f64::min);
    let brightest = cells.iter().copied().fold(0.0, f64::max);
    // The darkest of 64 cells is below its mean by their noise, about 2 %.
    assert_close(darkest / brightest, 0.168, 0.05, "homogeneity");
}
