//! `target_error` is kept, or its report says that it is not.

use lampyris::geometry::DVec3;
use lampyris::image::SpectralImage;
use lampyris::image::difference::ImageDifference;
use lampyris::material::Material;
use lampyris::render::{Quality, RenderStats, Samples, Unwatched, render_to_target};
use lampyris::scene::{Background, Prepared, Scene};
use lampyris::spectrum::Spectrum;
use lampyris::view::View;

use crate::stage::*;

/// Two mirrors at right angles, the one below matt too, and a pane of colored glass before them.
fn corner() -> Scene {
    let mirror = Material {
        reflectance: Spectrum::constant(0.9),
        lobes: specular(0.8, 400.0),
        k_rg: 0.9,
        ..material()
    };
    let glossy = Material { lobes: diffuse(0.5, 1.0), ..mirror.clone() };
    let colors = Spectrum::from_pairs("glass", [(400.0, 0.3), (700.0, 0.9)]);
    let glass = Material {
        reflectance: Spectrum::constant(0.1),
        transmittance: Some(colors.expect("a good spectrum")),
        lobes: specular(0.5, 1500.0),
        k_rg: 1.0,
        k_tg: 0.9,
        ..material()
    };
    let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| 20.0 * axis);
    let objects = vec![
        (rectangle(-z, x, y), mirror),
        (rectangle(-y, z, x), glossy),
        (rectangle(0.5 * z, 0.7 * x, 0.4 * y), glass),
    ];
    let places = [DVec3::new(3.0, 1.0, 5.0), DVec3::new(-9.0, 6.0, 2.0)];
    let lights = places.map(|place| point_light(place, DVec3::new(0.1, -1.0, -0.8), 100.0));
    Scene {
        background: Background::Even(Spectrum::constant(1e-3)),
        ..scene(objects, lights.into())
    }
}

fn take(
    prepared: &Prepared,
    view: &View,
    target: f64,
    reference: &SpectralImage,
) -> (f64, RenderStats) {
    let image = render_to_target(prepared, view, target, &Unwatched);
    let (image, stats) = image.expect("a good render");
    let difference = ImageDifference::between(&image, reference).expect("a lit reference");
    (difference.relative_rms, stats)
}

#[test]
fn targets_are_kept() {
    let view = View { width: 12, height: 9, elevation_deg: 20.0, ..pixel_view(25.0, 300.0) };
    // Of 2048 samples a pixel: some 0.002 off.
    let settled = Quality { samples: Samples::Fixed(2048), ..exact(40) };
    let cases = [(corner(), 9.0), (busy_scene(), 16.0)];
    for (scene, fov_deg) in cases {
        let prepared = scene.prepare().expect("a good scene");
        let view = View { fov_deg, ..view };
        let reference = shoot_prepared(&prepared, &view, &settled);
        for target in [0.1, 0.03, 0.015] {
            let (error, stats) = take(&prepared, &view, target, &reference);
            let report = stats.target.expect("a report");
            assert!(error <= target, "{error} for {report:?}");
            assert!(report.is_reached() && report.error() <= target, "{report:?}");
            // The estimate is there to be relied on: not below the truth but by chance.
            assert!(report.error() >= 0.5 * error, "{error} for {report:?}");
        }
    }
}

#[test]
fn closer_targets_take_more() {
    let prepared = corner().prepare().expect("a good scene");
    let view = View { width: 12, height: 9, fov_deg: 9.0, ..pixel_view(25.0, 300.0) };
    let samples = [0.3, 0.01].map(|target| {
        let (_, stats) = render_to_target(&prepared, &view, target, &Unwatched).expect("a picture");
        stats.target.expect("a report").mean_samples
    });
    // So small a picture has 16 samples a pixel at first.
    assert!(samples[1] > 1.2 * samples[0], "{samples:?}");
}

#[test]
fn what_cannot_be_reached_is_said() {
    let prepared = corner().prepare().expect("a good scene");
    let view = View { width: 2, height: 2, fov_deg: 9.0, ..pixel_view(25.0, 300.0) };
    let (_, stats) = render_to_target(&prepared, &view, 1e-9, &Unwatched).expect("a picture");
    let report = stats.target.expect("a report");
    assert!(!report.is_reached());
    let text = report.to_string();
    assert!(text.starts_with("target_error 0.000000001 is not reached: "), "{text}");
}

/// Mirrors that face each other need depth: 1 + R + R² + … of ambient light.
#[test]
fn depth_follows_from_the_target() {
    let mirror =
        Material { reflectance: Spectrum::constant(0.9), k_rg: 1.0, k_a: 1.0, ..material() };
    let facing = rectangle(DVec3::Z * 20.0, DVec3::Y * 10.0, DVec3::X * 10.0);
    let objects = vec![(square(0.0, 10.0), mirror.clone()), (facing, mirror)];
    let scene = Scene { ambient: Spectrum::constant(1.0), ..scene(objects, Vec::new()) };
    let prepared = scene.prepare().expect("a good scene");
    // From between the two.
    let view = View { fov_deg: 1e-6, ..pixel_view(0.0, 5.0) };
    let (image, stats) = render_to_target(&prepared, &view, 0.01, &Unwatched).expect("a picture");
    let report = stats.target.expect("a report");
    assert!(report.is_reached() && report.limits.max_depth == 64, "{report:?}");
    let expected = 0.9 / (1.0 - 0.9);
    assert_close(f64::from(image.pixel(0, 0)[40]), expected, 0.01, "all reflections");
}

#[test]
fn a_black_picture_is_within_any_target() {
    let prepared = scene(Vec::new(), Vec::new()).prepare().expect("a good scene");
    let view = View { width: 4, height: 3, ..pixel_view(0.0, 100.0) };
    let (image, stats) = render_to_target(&prepared, &view, 1e-3, &Unwatched).expect("a picture");
    assert!(image.bands.iter().all(|&value| value == 0.0));
    assert_eq!(stats.target.expect("a report").error(), 0.0);
}
