//! Why is it black? Each reason, from a scene that has it.

use lampyris::geometry::{DVec3, Mesh};
use lampyris::material::Material;
use lampyris::render::{Quality, Unwatched, render, why_black};
use lampyris::scene::{Light, Scene, Shadows};
use lampyris::spectrum::Spectrum;
use lampyris::view::View;

use crate::stage::{diffuse, material, pixel_view, point_light, scene, square};

fn white() -> Material {
    Material { lobes: diffuse(1.0, 1.0), ..material() }
}

fn lamp() -> Light {
    point_light(DVec3::new(0.0, 0.0, 50.0), DVec3::NEG_Z, 100.0)
}

fn reason_of(scene: Scene, view: View, quality: Quality) -> Option<String> {
    let prepared = scene.prepare().unwrap();
    let (image, _) = render(&prepared, &view, &quality, &Unwatched).unwrap();
    why_black(&image, &prepared, &view, quality.limits).unwrap()
}

fn view() -> View {
    View { fov_deg: 6.0, width: 20, height: 20, ..pixel_view(0.0, 300.0) }
}

fn reason(scene: Scene) -> String {
    reason_of(scene, view(), Quality::default()).unwrap()
}

fn with(mesh: Mesh, material: Material, light: Light) -> Scene {
    scene(vec![(mesh, material)], vec![light])
}

#[test]
fn a_lit_picture_is_not_explained() {
    assert_eq!(
        reason_of(with(square(0.0, 10.0), white(), lamp()), view(), Quality::default()),
        None
    );
}

#[test]
fn each_reason_is_told() {
    let square = || square(0.0, 10.0);
    let dark = Scene { lights: Vec::new(), ..with(square(), white(), lamp()) };
    assert_eq!(reason(dark), "the picture is black: the scene has no lights, and no ambient light");
    let away = point_light(DVec3::new(0.0, 0.0, 50.0), DVec3::Z, 100.0);
    assert!(reason(with(square(), white(), away)).contains("all light samples face away"));
    let behind = point_light(DVec3::new(0.0, 0.0, -50.0), DVec3::Z, 100.0);
    assert!(reason(with(square(), white(), behind)).contains("only from behind the surfaces"));
    assert!(reason(with(square(), material(), lamp())).contains("k_d = k_s = k_rg = 0"));
    let black = Material { reflectance: Spectrum::constant(0.0), ..white() };
    assert!(reason(with(square(), black, lamp())).contains("their reflectance is 0"));
    let shut = Material {
        transmittance: Some(Spectrum::constant(0.9)),
        reflectance: Spectrum::constant(0.0),
        ..material()
    };
    assert!(reason(with(square(), shut, lamp())).contains("but k_tg = 0"));
}

#[test]
fn views_that_see_nothing_are_told() {
    let lit = || with(square(0.0, 10.0), white(), lamp());
    let past = View { target: DVec3::new(500.0, 0.0, 0.0), ..view() };
    assert!(reason_of(lit(), past, Quality::default()).unwrap().contains("looks past the objects"));
    let behind = View { target: DVec3::new(0.0, 0.0, -900.0), ..view() };
    assert!(reason_of(lit(), behind, Quality::default()).unwrap().contains("behind the eye"));
    let back = View { azimuth_deg: 180.0, ..view() };
    assert!(reason_of(lit(), back, Quality::default()).unwrap().contains("meet its back"));
}

#[test]
fn shadows_and_limits_are_told() {
    // The lid hangs between the square and its light, out of the view's way.
    let objects = vec![(square(0.0, 10.0), white()), (square(40.0, 30.0), material())];
    let low = View { elevation_deg: 80.0, ..view() };
    let shadowed = Scene { shadows: Shadows::On, ..scene(objects, vec![lamp()]) };
    assert!(reason_of(shadowed, low, Quality::default()).unwrap().contains("shadows: "));
    // A mirror over a lit square that faces down: one bounce away.
    let mirror = Material { k_rg: 1.0, ..material() };
    let mut ceiling = square(20.0, 60.0);
    ceiling.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    let below = point_light(DVec3::new(0.0, 0.0, 1.0), DVec3::Z, 100.0);
    let objects = || vec![(square(0.0, 60.0), mirror.clone()), (ceiling.clone(), white())];
    let side = View {
        elevation_deg: 70.0,
        target: DVec3::new(0.0, 0.0, 0.0),
        distance_mm: 300.0,
        ..view()
    };
    let mut quality = Quality::default();
    quality.limits.max_depth = 0;
    let told = reason_of(scene(objects(), vec![below.clone()]), side, quality);
    assert_eq!(
        told.unwrap(),
        "the picture is black: every path to the light is longer than max_depth = 0"
    );
    let faint = Material { k_rg: 1e-4, ..mirror.clone() };
    let objects = vec![(square(0.0, 60.0), faint), (ceiling.clone(), white())];
    let told = reason_of(scene(objects, vec![below]), side, Quality::default());
    assert!(told.unwrap().contains("cut by min_throughput = 0.001"));
}
