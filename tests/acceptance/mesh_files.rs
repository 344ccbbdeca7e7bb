//! Meshes from files, as pictures: what CAD systems write shades as it is meant.

use std::path::Path;

use lampyris::geometry::import::{self, Interpolation, MeshReading};
use lampyris::geometry::mesh::{Axis, Placement};
use lampyris::geometry::{DVec3, Mesh};
use lampyris::image::SpectralImage;
use lampyris::light::RaySet;
use lampyris::material::Material;
use lampyris::scene::Light;
use lampyris::view::View;

use crate::stage::{exact, material, pixel_view, point_light, scene, shoot, specular};

fn load(text: &str, interpolation: Interpolation) -> Mesh {
    let reading = MeshReading { interpolation, ..MeshReading::default() };
    import::from_bytes(Path::new("part.obj"), text.into(), &reading).unwrap().mesh
}

fn shiny() -> Material {
    Material { lobes: specular(0.9, 20.0), ..material() }
}

fn lamp() -> Light {
    point_light(DVec3::new(40.0, 60.0, 200.0), DVec3::new(-0.2, -0.3, -1.0), 100.0)
}

fn view() -> View {
    View { fov_deg: 10.0, width: 40, height: 40, elevation_deg: 20.0, ..pixel_view(25.0, 300.0) }
}

fn picture(mesh: Mesh) -> SpectralImage {
    shoot(scene(vec![(mesh, shiny())], vec![lamp()]), &view(), &exact(0))
}

/// A sphere of facets 15° wide; each with corners of its own, or all sharing theirs.
fn sphere(has_own_corners: bool) -> String {
    const AROUND: usize = 24;
    const UP: usize = 12;
    let corner = |i: usize, j: usize| {
        let azimuth = (i % AROUND) as f64 / AROUND as f64 * std::f64::consts::TAU;
        let polar = j as f64 / UP as f64 * std::f64::consts::PI;
        let ring = if j == 0 || j == UP { 0.0 } else { 20.0 * polar.sin() };
        format!("v {} {} {}\n", ring * azimuth.cos(), ring * azimuth.sin(), 20.0 * polar.cos())
    };
    let places = (0..=UP).flat_map(|j| (0..AROUND).map(move |i| (i, j)));
    let mut text: String = places.filter(|_| !has_own_corners).map(|(i, j)| corner(i, j)).collect();
    for (i, j) in (0..UP).flat_map(|j| (0..AROUND).map(move |i| (i, j))) {
        let corners = [(i, j), (i, j + 1), (i + 1, j + 1), (i + 1, j)];
        if has_own_corners {
            text += &corners.map(|(i, j)| corner(i, j)).concat();
            text += "f -4 -3 -2 -1\n";
        } else {
            let [a, b, c, d] = corners.map(|(i, j)| 1 + j * AROUND + i % AROUND);
            text += &format!("f {a} {b} {c} {d}\n");
        }
    }
    text
}

/// Unwelded, the picture was 31 % off.
#[test]
fn facets_with_corners_of_their_own_look_like_shared_ones() {
    let own = picture(load(&sphere(true), Interpolation::Smooth));
    let shared = picture(load(&sphere(false), Interpolation::Smooth));
    let flat = picture(load(&sphere(false), Interpolation::Flat));
    assert!(own.bands.iter().any(|&value| value > 0.0));
    // To the rounding of f32: the corners' numbers differ, and so do the sums over them.
    let close = |a: f32, b: f32| (a - b).abs() <= 1e-5 * a.abs().max(b.abs());
    assert!(own.bands.iter().zip(&shared.bands).all(|(&a, &b)| close(a, b)));
    assert!(!own.bands.iter().zip(&flat.bands).all(|(&a, &b)| close(a, b)));
}

/// Smoothed over its edges, the picture was 63 % off.
#[test]
fn a_cube_looks_like_a_flat_cube() {
    let cube = "v -20 -20 -20\nv 20 -20 -20\nv 20 20 -20\nv -20 20 -20\nv -20 -20 20\nv 20 -20 20\n\
                v 20 20 20\nv -20 20 20\nf 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\n\
                f 4 1 5 8\n";
    let smooth = picture(load(cube, Interpolation::Smooth));
    assert_eq!(smooth.bands, picture(load(cube, Interpolation::Flat)).bands);
    assert_ne!(smooth.bands, picture(load(&format!("s 1\n{cube}"), Interpolation::Smooth)).bands);
}

/// The left lamp from the right one: part and rays in a mirror give the picture in a mirror.
#[test]
fn a_mirrored_scene_is_the_mirrored_picture() {
    let part = load(&sphere(false), Interpolation::Smooth).transformed(&Placement {
        translation: DVec3::new(15.0, 5.0, 0.0),
        ..Placement::default()
    });
    let mirror = Placement { mirror: Some(Axis::X), ..Placement::default() };
    let light = lamp();
    let rays = RaySet { world_from_local: mirror.affine(), ..light.rays.clone() };
    let mirrored = Light { rays, ..light.clone() };
    let of = |mesh: &Mesh, light: Light, azimuth_deg: f64| {
        let scene = scene(vec![(mesh.clone(), shiny())], vec![light]);
        shoot(scene, &View { azimuth_deg, ..view() }, &exact(2))
    };
    let right = of(&part, light.clone(), 25.0);
    let left = of(&part.transformed(&mirror), mirrored, -25.0);
    let (width, height) = (right.width, right.height);
    let (mut lit, mut wrong) = (0, 0);
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let pairs = right.pixel(x, y).iter().zip(left.pixel(width - 1 - x, y));
        lit += usize::from(right.pixel(x, y)[40] > 0.0);
        wrong += usize::from(pairs.clone().any(|(a, b)| (a - b).abs() > 1e-4 * a.max(*b)));
    }
    // A pixel's ray on an edge may fall on either side of it.
    assert!(lit > 50 && wrong <= 2, "{lit} lit, {wrong} wrong");
}
