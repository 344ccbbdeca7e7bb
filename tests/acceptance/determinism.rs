//! Same inputs, same bits.

use lampyris::geometry::{DVec3, Mesh};
use lampyris::image::SpectralImage;
use lampyris::light::Cylinder;
use lampyris::material::Material;
use lampyris::render::{Quality, Samples};
use lampyris::scene::{Light, Scene};
use lampyris::shading::TraceLimits;
use lampyris::spectrum::Spectrum;
use lampyris::view::View;

use crate::stage::*;

/// A curved mirror before a filament, with everything on that a scene can have.
fn busy_scene() -> Scene {
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
        rays: filament.rayset().expect("a good cylinder"),
        spectrum: Spectrum::blackbody(2750.0),
    };
    Scene { background: Spectrum::constant(1e-6), ..scene(vec![(bowl, aluminium)], vec![light]) }
}

fn shoot_with_threads(threads: usize, quality: &Quality) -> SpectralImage {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
    let view = View { width: 48, height: 32, fov_deg: 12.0, ..pixel_view(5.0, 500.0) };
    pool.install(|| shoot(busy_scene(), &view, quality))
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let adaptive = Quality {
        samples: Samples::Adaptive { min: 2, max: 16, error: 0.02 },
        limits: TraceLimits { max_depth: 4, min_throughput: 1e-3, light_error: 0.01 },
        ..exact(4)
    };
    for quality in [exact(4), adaptive] {
        let one = shoot_with_threads(1, &quality);
        assert!(one.bands.iter().any(|&v| v > 0.0));
        for threads in [2, 3, 7] {
            assert!(shoot_with_threads(threads, &quality) == one, "{threads} threads");
        }
    }
}
