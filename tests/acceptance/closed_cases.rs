//! Scenes with an answer on paper.

use std::f64::consts::PI;

use lampyris::color::Photometry;
use lampyris::geometry::{DVec3, Mesh};
use lampyris::image::{Region, SpectralImage};
use lampyris::material::Material;
use lampyris::scene::Scene;
use lampyris::spectrum::{Spectrum, WavelengthGrid};
use lampyris::view::View;

use crate::stage::*;

/// f32 samples and images: six digits and a bit.
const SINGLE: f64 = 1e-6;

fn luminance(image: &SpectralImage) -> f64 {
    image.mean_xyz(Region::pixel(0, 0)).expect("a pixel").y
}

/// Luminance of a Lambert square (ρ = 0.5) at the origin, lit by 100 lm from `position`.
fn lambert_luminance(position: DVec3, direction: DVec3) -> f64 {
    let wall =
        Material { reflectance: Spectrum::constant(0.5), lobes: diffuse(1.0, 1.0), ..material() };
    let lit = Scene {
        photometry: Photometry::Absolute,
        ..scene(vec![(square(0.0, 10.0), wall)], vec![point_light(position, direction, 100.0)])
    };
    luminance(&shoot(lit, &pixel_view(0.0, 1000.0), &exact(0)))
}

#[test]
fn inverse_square_law() {
    for distance_mm in [1e-2, 1.0, 500.0, 1e6] {
        let axis = DVec3::Z * distance_mm;
        // I = Φ/π on the emitter's axis, E = I/r², L = ρE/π.
        let expected = 0.5 / PI * (100.0 / PI) / (distance_mm / 1000.0).powi(2);
        assert_close(lambert_luminance(axis, -axis), expected, SINGLE, "distance");
    }
}

#[test]
fn cosine_law_at_both_ends() {
    for degrees in [0.0_f64, 30.0, 60.0, 89.0] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let place = DVec3::new(sin, 0.0, cos) * 300.0;
        let normal_emission = 0.5 / PI * (100.0 / PI) / 0.09;
        let tilted_wall = lambert_luminance(place, -place);
        // f32 positions turn the angle by up to 1e-7, which the slope of the cosine multiplies.
        let tolerance = SINGLE * (1.0 + 1.0 / cos);
        assert_close(tilted_wall, normal_emission * cos, tolerance, "receiver");
        let tilted_emitter = lambert_luminance(DVec3::Z * 300.0, DVec3::new(sin, 0.0, -cos));
        assert_close(tilted_emitter, normal_emission * cos, tolerance, "emitter");
    }
}

/// Eq. 12: 683 Σ I_i(λ) V(λ) Δλ is the flux that went in, on every grid.
#[test]
fn lumens_come_back() {
    for flux_lm in [1e-12, 35.0, 1e12] {
        let light = point_light(DVec3::Z, DVec3::NEG_Z, flux_lm);
        for grid in [WavelengthGrid::Step5, WavelengthGrid::Step10, WavelengthGrid::Step20] {
            let power = light.power_per_lumen(grid).expect("a good light");
            let watts = Spectrum::from_pairs("power", grid.wavelengths_nm().zip(power));
            let lumens = watts.expect("a good table").luminous_flux(grid) * flux_lm;
            assert_close(lumens, flux_lm, 1e-14, "flux");
        }
    }
}

/// A flat mirror shows a light where its mirror image stands: the brightest pixel of a sharp lobe.
#[test]
fn a_mirror_shows_the_mirrored_light_where_geometry_says() {
    let source = DVec3::new(7.0, -4.0, 60.0);
    let mirror = Material { lobes: specular(1.0, 1e5), ..material() };
    let light = point_light(source, DVec3::NEG_Z, 1.0);
    let view = View {
        distance_mm: 300.0,
        fov_deg: 10.0,
        width: 201,
        height: 201,
        ..pixel_view(10.0, 300.0)
    };
    let image = shoot(scene(vec![(square(0.0, 200.0), mirror)], vec![light]), &view, &exact(0));
    let y =
        |pixel: usize| image.mean_xyz(Region::pixel(pixel % 201, pixel / 201)).expect("a pixel").y;
    let brightest = (0..view.pixels()).max_by(|&a, &b| y(a).total_cmp(&y(b))).expect("pixels");
    let toward = view.camera().ray((brightest % 201) as f64 + 0.5, (brightest / 201) as f64 + 0.5);
    let image_of_source = DVec3::new(source.x, source.y, -source.z);
    let expected = (image_of_source - toward.origin).normalize();
    // Half a pixel's diagonal: 10°/201/√2.
    assert!(toward.direction.angle_between(expected) < 6.3e-4);
}

/// Refraction through one face: the direct view of a background pattern would need images; the
/// bent ray is seen by what it meets. Two walls stand so that Snell's direction meets one of them.
#[test]
fn snell_and_the_critical_angle() {
    let ior = 1.5;
    let critical_deg = (1.0f64 / ior).asin().to_degrees();
    // Seen from inside (the back side), a face passes light up to the critical angle.
    for (angle_deg, passes) in
        [(0.0, true), (critical_deg - 0.01, true), (critical_deg + 0.01, false), (80.0, false)]
    {
        let face = Material {
            transmittance: Some(Spectrum::constant(1.0)),
            ior: Some(Spectrum::constant(ior)),
            k_tg: 0.9,
            k_rg: 0.1,
            ..material()
        };
        // The face's back looks at the camera; a glowing ceiling is behind it.
        let back = rectangle(DVec3::ZERO, DVec3::NEG_X * 10.0, DVec3::Y * 10.0);
        let ceiling = Material { k_a: 1.0, ..material() };
        let glowing = Scene {
            ambient: Spectrum::constant(1.0),
            ..scene(vec![(back, face), (square(-100.0, 1e7), ceiling)], vec![])
        };
        let image = shoot(glowing, &pixel_view(angle_deg, 50.0), &exact(1));
        let seen = f64::from(image.pixel(0, 0)[0]);
        assert_close(1.0 + seen, if passes { 1.9 } else { 1.0 }, SINGLE, "at the face");
    }
}

/// The refracted ray meets a tilted wall where Snell's law says: its distance shows as absorption.
#[test]
fn beer_and_lambert_along_the_refracted_path() {
    let (ior, thickness_mm, depth_mm) = (1.49, 3.0, 7.0);
    for angle_deg in [0.0_f64, 30.0, 75.0] {
        let body = Material {
            transmittance: Some(Spectrum::constant(0.4)),
            thickness_mm: Some(thickness_mm),
            ior: Some(Spectrum::constant(ior)),
            k_tg: 1.0,
            ..material()
        };
        let wall = Material { k_a: 1.0, ..material() };
        let glowing = Scene {
            ambient: Spectrum::constant(1.0),
            ..scene(vec![(square(0.0, 50.0), body), (square(-depth_mm, 50.0), wall)], vec![])
        };
        let image = shoot(glowing, &pixel_view(angle_deg, 40.0), &exact(1));
        let sin_inside = angle_deg.to_radians().sin() / ior;
        let path_mm = depth_mm / (1.0 - sin_inside * sin_inside).sqrt();
        let expected = 0.4f64.powf(path_mm / thickness_mm);
        assert_close(f64::from(image.pixel(0, 0)[40]), expected, SINGLE, "attenuation");
    }
}

/// Two mirrors face each other: after depth d the sum is a(1 + q + … + q^d).
#[test]
fn depth_64_between_mirrors_is_a_geometric_series() {
    let q = 0.97;
    let mirror = Material { reflectance: Spectrum::constant(q), k_rg: 1.0, k_a: 1.0, ..material() };
    let facing = |z: f64, up: DVec3| rectangle(DVec3::Z * z, DVec3::X * 1e3, up * 1e3);
    for (max_depth, spacing) in [(64, 10.0), (64, 1e-6), (0, 10.0)] {
        let corridor = Scene {
            ambient: Spectrum::constant(1.0),
            ..scene(
                vec![
                    (facing(-spacing, DVec3::Y), mirror.clone()),
                    (facing(spacing, DVec3::NEG_Y), mirror.clone()),
                ],
                vec![],
            )
        };
        let image = shoot(corridor, &pixel_view(0.0, 0.5 * spacing), &exact(max_depth));
        let expected = q * (1.0 - q.powi(max_depth as i32 + 1)) / (1.0 - q);
        assert_close(f64::from(image.pixel(0, 0)[0]), expected, SINGLE, "series");
    }
}

/// Lobes of every exponent, at the mirror direction and beside it, against f64.
#[test]
fn lobes_keep_their_accuracy_from_1_to_a_million() {
    let source = DVec3::new(0.0, 0.0, 100.0);
    for n_s in [1.0, 10.0, 1500.0, 1e5, 1e6] {
        for offset_deg in [0.0, 0.05, 0.2] {
            let mirror = Material { lobes: specular(1.0, n_s), ..material() };
            let light = point_light(source, DVec3::NEG_Z, 1.0);
            let mirror_scene = scene(vec![(square(0.0, 200.0), mirror)], vec![light]);
            let image = shoot(mirror_scene, &pixel_view(offset_deg, 1000.0), &exact(0));
            let relative = luminance(&image);
            // V is turned by the offset, L is N.
            let expected = (n_s * offset_deg.to_radians().cos().ln()).exp();
            // model.md, "Accuracy that the numbers must keep".
            if expected > 1e-30 {
                assert_close(relative, expected, 1e-3, "lobe");
            }
        }
    }
}

#[test]
fn shadows_fall_only_where_they_are_asked_for() {
    let wall = || Material { lobes: diffuse(1.0, 1.0), ..material() };
    let light = || vec![point_light(DVec3::Z * 100.0, DVec3::NEG_Z, 1.0)];
    let glass = Material { transmittance: Some(Spectrum::constant(0.5)), k_tg: 1.0, ..material() };
    let lamp = |between: Option<Material>, shadows| {
        // Seen from the side, past the blocker.
        let mut objects: Vec<(Mesh, Material)> = vec![(square(0.0, 50.0), wall())];
        objects.extend(between.map(|m| (square(50.0, 5.0), m)));
        let image = shoot(
            Scene { shadows, ..scene(objects, light()) },
            &pixel_view(45.0, 200.0),
            &exact(0),
        );
        luminance(&image)
    };
    use lampyris::scene::Shadows::{Off, On};
    let free = lamp(None, On);
    assert!(free > 0.0);
    assert_eq!(lamp(Some(wall()), On), 0.0);
    assert_eq!(lamp(Some(wall()), Off), free);
    assert_eq!(lamp(Some(glass), On), free);
}
