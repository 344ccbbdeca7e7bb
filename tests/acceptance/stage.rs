//! Small scenes, built without a script.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use lampyris::Result;
use lampyris::geometry::{DVec3, Mesh};
use lampyris::image::SpectralImage;
use lampyris::light::{RaySample, RaySet};
use lampyris::material::{Lobes, Material, SpecularLobe};
use lampyris::program::script::{self, Settings};
use lampyris::render::{Quality, Samples, Unwatched, render};
use lampyris::scene::{Background, Light, MaterialId, Object, Prepared, Scene};
use lampyris::shading::TraceLimits;
use lampyris::source::Cylinder;
use lampyris::spectrum::Spectrum;
use lampyris::view::View;

/// A black, opaque material to be changed.
pub fn material() -> Material {
    Material::default()
}

pub fn diffuse(k_d: f64, n_d: f64) -> Lobes {
    Lobes { k_d, n_d, ..Lobes::default() }
}

pub fn specular(k_s: f64, n_s: f64) -> Lobes {
    Lobes { specular: vec![SpecularLobe { k_s, n_s }], ..Lobes::default() }
}

/// A rectangle about `center`, spanned by two half-edges; its front is the side of u × v.
pub fn rectangle(center: DVec3, u: DVec3, v: DVec3) -> Mesh {
    let positions = vec![center - u - v, center + u - v, center + u + v, center - u + v];
    Mesh::flat("rectangle", positions, vec![[0, 1, 2], [0, 2, 3]]).expect("a good mesh")
}

/// A square at height z that looks along +Z.
pub fn square(z: f64, half: f64) -> Mesh {
    rectangle(DVec3::new(0.0, 0.0, z), DVec3::X * half, DVec3::Y * half)
}

/// One light sample.
pub fn point_light(position: DVec3, direction: DVec3, flux_lm: f64) -> Light {
    let sample = RaySample {
        position: position.as_vec3().to_array(),
        direction: direction.normalize().as_vec3().to_array(),
        flux: 1.0,
    };
    Light::new(RaySet::new([sample].into(), flux_lm), Spectrum::blackbody(2856.0))
}

pub fn scene(objects: Vec<(Mesh, Material)>, lights: Vec<Light>) -> Scene {
    let (meshes, materials): (Vec<Mesh>, Vec<Material>) = objects.into_iter().unzip();
    let object = |(at, mesh)| Object { mesh: Arc::new(mesh), material: MaterialId(at) };
    Scene {
        objects: meshes.into_iter().enumerate().map(object).collect(),
        materials,
        lights,
        ..Scene::default()
    }
}

/// A curved mirror before a filament, with everything on that a scene can have.
pub fn busy_scene() -> Scene {
    let cells = 24;
    let point = |k: usize| {
        let place = |i: usize| i as f64 / cells as f64 * 80.0 - 40.0;
        let (x, y) = (place(k % (cells + 1)), place(k / (cells + 1)));
        Some(DVec3::new(x, y, (x * x + y * y) / 120.0))
    };
    let points: Vec<_> = (0..(cells + 1) * (cells + 1)).map(point).collect();
    let bowl = Mesh::from_grid("bowl", cells, cells, &points).expect("a good grid");
    let aluminium = Material {
        reflectance: Spectrum::constant(0.9),
        lobes: specular(0.9, 300.0),
        k_rg: 0.95,
        ..material()
    };
    let filament = Cylinder {
        center: DVec3::Z * 30.0,
        axis: DVec3::X,
        radius_mm: 0.5,
        length_mm: 5.0,
        flux_lm: 440.0,
        samples: 2000,
        seed: 7,
    };
    let light = Light {
        surface: None,
        rays: filament.rayset().expect("a good cylinder"),
        spectrum: Spectrum::blackbody(2750.0),
    };
    Scene {
        background: Background::Even(Spectrum::constant(1e-6)),
        ..scene(vec![(bowl, aluminium)], vec![light])
    }
}

/// A view of one pixel that looks at the origin.
pub fn pixel_view(azimuth_deg: f64, distance_mm: f64) -> View {
    View {
        azimuth_deg,
        elevation_deg: 0.0,
        distance_mm,
        target: DVec3::ZERO,
        fov_deg: 1.0,
        width: 1,
        height: 1,
    }
}

pub fn exact(max_depth: u32) -> Quality {
    Quality {
        samples: Samples::Fixed(1),
        limits: TraceLimits {
            max_depth,
            min_throughput: 0.0,
            light_error: 0.0,
            ..TraceLimits::default()
        },
        ..Quality::default()
    }
}

pub fn shoot(scene: Scene, view: &View, quality: &Quality) -> SpectralImage {
    shoot_prepared(&scene.prepare().expect("a good scene"), view, quality)
}

pub fn shoot_prepared(prepared: &Prepared, view: &View, quality: &Quality) -> SpectralImage {
    let rendered: Result<_> = render(prepared, view, quality, &Unwatched);
    rendered.expect("a good render").0
}

pub fn assert_close(value: f64, expected: f64, relative: f64, what: &str) {
    let error = (value / expected - 1.0).abs();
    assert!(error <= relative, "{what}: {value}, expected {expected}, off by {error:e}");
}

/// A folder of a test's own.
pub fn scratch(test: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(test)
}

/// Runs a script that must succeed.
pub fn run_script(script: &Path, out: &Path, arguments: &[&str]) {
    let settings = Settings {
        out: out.to_owned(),
        arguments: arguments.iter().map(|&a| a.to_owned()).collect(),
        ..Settings::default()
    };
    script::run(script, settings).expect("the script runs");
}
