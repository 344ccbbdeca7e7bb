//! Rays shipped on an auxiliary sphere go back to the filament they come from.

use glam::DVec3;
use lampyris::light::{RaySample, RaySet};
use lampyris::source::surface_fit::FittedSurface;
use lampyris::source::{StartSurface, Starts};

const RADIUS_MM: f64 = 0.65;
const Z_MM: (f64, f64) = (9.0, 13.1);

/// Lambert rays from a cylinder, started on a sphere of 10 mm about its middle: what a maker's file
/// of a filament looks like. Steps of the golden ratio and its kin stand for random numbers.
fn filament_on_sphere(n: u32) -> RaySet {
    let fraction = |i: u32, step: f64| (f64::from(i) * step).fract();
    let sample = |i: u32| {
        let (phi, z) =
            (std::f64::consts::TAU * fraction(i, 0.618_033_988_7), fraction(i, 0.754_877_666_2));
        let normal = DVec3::new(phi.cos(), phi.sin(), 0.0);
        let start = RADIUS_MM * normal + (Z_MM.0 + z * (Z_MM.1 - Z_MM.0)) * DVec3::Z;
        let (u, psi) =
            (fraction(i, 0.569_840_291_0), std::f64::consts::TAU * fraction(i, 0.324_717_957_2));
        let tangent = DVec3::Z.cross(normal) * psi.cos() + DVec3::Z * psi.sin();
        let direction = (u.sqrt() * tangent + (1.0 - u).sqrt() * normal).normalize();
        let center = DVec3::new(0.0, 0.0, 10.0);
        let from_center = start - center;
        let along = from_center.dot(direction);
        let to_sphere = -along + (along * along + 100.0 - from_center.length_squared()).sqrt();
        RaySample {
            position: (start + to_sphere * direction).to_array().map(|x| x as f32),
            direction: direction.to_array().map(|x| x as f32),
            flux: 1.0,
        }
    };
    RaySet::new((0..n).map(sample).collect(), 460.0)
}

fn radius(s: &RaySample) -> f64 {
    f64::from(s.position[0]).hypot(f64::from(s.position[1]))
}

#[test]
fn the_nearest_points_fill_the_filament() {
    let axis = StartSurface::axis(DVec3::ZERO, DVec3::Z).unwrap();
    let rays = filament_on_sphere(100_000).starting_at(&axis).unwrap();
    // f32 starts at 10 mm and f32 directions: 1e-6 mm each.
    let largest = rays.samples.iter().map(radius).fold(0.0, f64::max);
    assert!((largest - RADIUS_MM).abs() < 5e-4, "{largest}");
    assert!(rays.samples.iter().all(|s| radius(s) < RADIUS_MM + 1e-5));
    // A tangential ray is nearest where it left the surface: within √(1 − 0.999²) of the radius,
    // 0.03 mm, along a ray no steeper than 45°.
    let is_tangential =
        |s: &&RaySample| radius(s) > 0.999 * RADIUS_MM && s.direction[2].abs() < 0.7;
    let tangential: Vec<&RaySample> = rays.samples.iter().filter(is_tangential).collect();
    assert!(tangential.len() > 20);
    for z in tangential.iter().map(|s| f64::from(s.position[2])) {
        assert!((Z_MM.0 - 0.03..Z_MM.1 + 0.03).contains(&z), "{z}");
    }
}

#[test]
fn with_its_radius_the_whole_filament_reappears() {
    let surface =
        StartSurface::axis(DVec3::ZERO, DVec3::Z).unwrap().with_radius(RADIUS_MM).unwrap();
    let rays = filament_on_sphere(10_000).starting_at(&surface).unwrap();
    let z = |s: &RaySample| f64::from(s.position[2]);
    let low = rays.samples.iter().map(z).fold(f64::INFINITY, f64::min);
    let high = rays.samples.iter().map(z).fold(f64::NEG_INFINITY, f64::max);
    // 10⁴ even points leave a gap of 4e-4 mm at the ends.
    assert!((low - Z_MM.0).abs() < 2e-3 && (high - Z_MM.1).abs() < 2e-3, "{low} {high}");
    assert!(rays.samples.iter().all(|s| (radius(s) - RADIUS_MM).abs() < 1e-4));
}

#[test]
fn the_report_sees_sphere_and_filament() {
    let rays = filament_on_sphere(20_000);
    let report = Starts::of(&rays.samples);
    let Some(FittedSurface::Sphere { center, radius_mm }) = report.surface.map(|fit| fit.surface)
    else {
        panic!("{report:?}")
    };
    // f32 start points at 10 mm.
    assert!(center.distance(DVec3::new(0.0, 0.0, 10.0)) < 1e-5 && (radius_mm - 10.0).abs() < 1e-5);
    let inner = report.inner_source.unwrap();
    assert_eq!(inner.axis, DVec3::Z);
    // The fitted axis is off by the standard error of the mean, about 0.65/√20000.
    assert!((inner.radius_mm - RADIUS_MM).abs() < 0.01);
    // An even source all around: as much below as above.
    assert!((report.below_rays - 0.5).abs() < 0.01 && report.mean_direction.length() < 0.01);
    let text = report.lines().join("\n");
    assert!(text.contains("start on a sphere about (0.0000, 0.0000, 10.0000), radius 10.0000"));
    assert!(text.contains("start = { axis = {0, 0, 1}, through = {"), "{text}");
}

#[test]
fn rays_that_start_on_their_source_need_no_remedy() {
    let source = StartSurface::axis(DVec3::ZERO, DVec3::Z).unwrap().with_radius(RADIUS_MM).unwrap();
    let report = Starts::of(&filament_on_sphere(20_000).starting_at(&source).unwrap().samples);
    let Some(FittedSurface::Cylinder { radius_mm, length_mm, .. }) =
        report.surface.map(|fit| fit.surface)
    else {
        panic!("{report:?}")
    };
    assert!((radius_mm - RADIUS_MM).abs() < 1e-5 && (length_mm - 4.1).abs() < 1e-3);
    assert_eq!(report.warning(), None);
}
