//! Luminous intensity: two cases with closed answers.

use std::f64::consts::PI;

use lampyris::color::Photometry;
use lampyris::geometry::{DVec3, Mesh};
use lampyris::program::intensity::intensity;
use lampyris::scene::Scene;
use lampyris::view::View;

use crate::stage::*;

const FLUX_LM: f64 = 100.0;

/// A regular polygon about the origin that looks along +Z.
fn disc(radius: f64, corners: u32) -> Mesh {
    let corner = |k: u32| {
        let (sin, cos) = (2.0 * PI * f64::from(k) / f64::from(corners)).sin_cos();
        DVec3::new(radius * cos, radius * sin, 0.0)
    };
    let positions = std::iter::once(DVec3::ZERO).chain((0..corners).map(corner)).collect();
    let triangles = (0..corners).map(|k| [0, 1 + k, 1 + (k + 1) % corners]).collect();
    Mesh::flat("disc", positions, triangles).expect("a good mesh")
}

fn absolute(scene: Scene) -> Scene {
    Scene { photometry: Photometry::Absolute, ..scene }
}

/// A diffuse disc under even light: I(θ) = L A cos θ, L = E k_d / π, E = Φ / (π r²).
#[test]
fn lambert_disc() {
    let (radius_mm, corners, k_d) = (10.0, 256, 0.6);
    // From 10 m the light falls evenly: the edge of the disc gets 1e-6 less than its center.
    let light_mm = 1e4;
    let light = point_light(DVec3::Z * light_mm, DVec3::NEG_Z, FLUX_LM);
    let paper = lampyris::material::Material { lobes: diffuse(k_d, 1.0), ..material() };
    let scene = absolute(scene(vec![(disc(radius_mm, corners), paper)], vec![light]));
    let prepared = scene.prepare().expect("a good scene");
    let illuminance_lx = FLUX_LM / (PI * (light_mm * 1e-3).powi(2));
    let n = f64::from(corners);
    let area_m2 = 0.5 * n * (radius_mm * 1e-3).powi(2) * (2.0 * PI / n).sin();
    let axial_cd = illuminance_lx * k_d / PI * area_m2;
    let quality =
        lampyris::render::Quality { samples: lampyris::render::Samples::Fixed(16), ..exact(0) };
    for azimuth_deg in [0.0f64, 30.0, 60.0, -75.0] {
        // 3 m away, the disc fills two thirds of the image's height at 0°.
        let view =
            View { azimuth_deg, fov_deg: 0.6, width: 200, height: 200, ..pixel_view(0.0, 3000.0) };
        let image = shoot_prepared(&prepared, &view, &quality);
        let value = intensity(&image, &view).expect("absolute").y;
        let expected = axial_cd * azimuth_deg.to_radians().cos();
        // Its outline is sampled by 16 rays a pixel: 127 · 2π pixels of outline, each off by
        // some 1/16 either way, of 1.3e4 to 5e4 pixels; and 1e-5 for being 3 m away.
        assert_close(value, expected, 1e-3, &format!("{azimuth_deg}°"));
    }
}

/// A point source before a glossy mirror: the eye sees its image behind the mirror with
/// I = k_s Φ/π · (n + 2)/n · (D/(D + d))², a lobe (n + 2)/(2π) cosⁿα integrated over the mirror,
/// with α = ρ (1/d + 1/D) at ρ from the middle.
#[test]
fn point_source_in_a_mirror() {
    let (d_mm, eye_mm, k_s, n_s): (f64, f64, f64, f64) = (10.0, 1000.0, 0.8, 1e5);
    let light = point_light(DVec3::Z * d_mm, DVec3::NEG_Z, FLUX_LM);
    let mirror = lampyris::material::Material { lobes: specular(k_s, n_s), ..material() };
    let scene = absolute(scene(vec![(square(0.0, 5.0), mirror)], vec![light]));
    // The highlight's σ is 0.03 mm: ±0.2 mm hold all of it.
    let fov_deg = 2.0 * (0.2 / eye_mm).atan().to_degrees();
    let view = View { fov_deg, width: 200, height: 200, ..pixel_view(0.0, eye_mm) };
    let image = shoot(scene, &view, &exact(0));
    let value = intensity(&image, &view).expect("absolute").y;
    let expected = k_s * FLUX_LM / PI * (n_s + 2.0) / n_s * (eye_mm / (eye_mm + d_mm)).powi(2);
    // α is taken to first order, which is off by some 1/n.
    assert_close(value, expected, 1e-4, "highlight");
}

#[test]
fn relative_images_have_no_intensity() {
    let light = point_light(DVec3::Z, DVec3::NEG_Z, FLUX_LM);
    let view = pixel_view(0.0, 100.0);
    let image = shoot(scene(vec![(square(0.0, 5.0), material())], vec![light]), &view, &exact(0));
    assert!(
        intensity(&image, &view).unwrap_err().to_string().contains("photometry = \"absolute\"")
    );
}
