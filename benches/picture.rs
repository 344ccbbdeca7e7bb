//! What a whole picture costs: 81 bands against 1, two threads against one, by light samples, by
//! `light_error`, and with features that the scene has but the picture does not need.
//!
//! `cargo bench --bench picture`. A lamp of 711 thousand triangles, 160 × 120 pixels, one sample a
//! pixel. Each figure is the fastest of several runs; ratios within one run say more than seconds.

use std::sync::Arc;
use std::time::Instant;

use lampyris::geometry::{DVec3, Mesh};
use lampyris::material::{Lobes, Material, SpecularLobe};
use lampyris::render::{Quality, Samples, Unwatched, render};
use lampyris::scene::{Light, MaterialId, MaterialTables, Object, Prepared, Scene, SpectralTables};
use lampyris::shading::{TraceLimits, TraceState, Tracer};
use lampyris::source::{Coil, Filament};
use lampyris::spectrum::{Bands, Spectrum, WavelengthGrid};
use lampyris::view::View;

const PASSES: usize = 5;
const LIMITS: TraceLimits =
    TraceLimits { max_depth: 8, min_throughput: 1e-3, light_error: 0.01, dispersion: 1 };

fn main() {
    let lamp = lamp(100_000).prepare().expect("a good scene");
    bands(&lamp);
    threads(&lamp);
    light_errors(&lamp);
    unused_features();
    samples();
}

fn fastest(mut work: impl FnMut()) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..PASSES {
        let start = Instant::now();
        work();
        best = best.min(start.elapsed().as_secs_f64());
    }
    best
}

/// Seconds of two works in turn, so that what else the machine does meets both.
fn compare(mut a: impl FnMut(), mut b: impl FnMut()) -> [f64; 2] {
    let mut best = [f64::INFINITY; 2];
    for _ in 0..PASSES {
        let start = Instant::now();
        a();
        let between = Instant::now();
        b();
        best[0] = best[0].min((between - start).as_secs_f64());
        best[1] = best[1].min(between.elapsed().as_secs_f64());
    }
    best
}

fn view() -> View {
    View {
        azimuth_deg: 0.0,
        elevation_deg: 0.0,
        distance_mm: 3000.0,
        target: DVec3::new(0.0, 0.0, 60.0),
        fov_deg: 2.6,
        width: 160,
        height: 120,
    }
}

fn shoot(lamp: &Prepared, light_error: f64) {
    let quality = Quality {
        samples: Samples::Fixed(1),
        limits: TraceLimits { light_error, ..LIMITS },
        ..Quality::default()
    };
    render(lamp, &view(), &quality, &Unwatched).expect("a good picture");
}

/// 81 bands against the one at 650 nm, which the lens lets through, on one thread: both trace the
/// same rays.
fn bands(lamp: &Prepared) {
    let all = lamp.tables(WavelengthGrid::Step5).expect("a good light");
    let one = single_band(all);
    let [many, few] = compare(|| trace_all(lamp, all), || trace_all(lamp, &one));
    println!("81 bands {many:.3} s, 1 band {few:.3} s: ×{:.3}", many / few);
}

fn trace_all(lamp: &Prepared, tables: &SpectralTables) {
    let tracer = Tracer { prepared: lamp, tables, limits: LIMITS };
    let (view, camera) = (view(), view().camera());
    let mut state = TraceState::default();
    for pixel in 0..view.pixels() {
        let (x, y) = (pixel % view.width, pixel / view.width);
        let mut sum = Bands::zero(tables.bands);
        let ray = camera.ray(x as f64 + 0.5, y as f64 + 0.5);
        tracer.trace(ray, &mut state, &mut sum);
    }
}

fn single_band(all: &SpectralTables) -> SpectralTables {
    /// 650 nm.
    const BAND: usize = 54;
    let pick = |bands: &Bands| Bands::from_slice(&bands.as_slice()[BAND..=BAND]);
    SpectralTables {
        surroundings: None,
        bands: 1,
        materials: all
            .materials
            .iter()
            .map(|material| MaterialTables {
                reflectance: pick(&material.reflectance),
                transmittance: pick(&material.transmittance),
                absorption_per_mm: pick(&material.absorption_per_mm),
                ..material.clone()
            })
            .collect(),
        lights: all.lights.iter().map(pick).collect(),
        background: pick(&all.background),
        ambient: pick(&all.ambient),
        has_ambient: all.has_ambient,
        luminance_weights: pick(&all.luminance_weights),
    }
}

fn threads(lamp: &Prepared) {
    let pool = |count| rayon::ThreadPoolBuilder::new().num_threads(count).build().expect("a pool");
    let (single, pair) = (pool(1), pool(2));
    let take = || shoot(lamp, LIMITS.light_error);
    let [one, two] = compare(|| single.install(take), || pair.install(take));
    println!("one thread {one:.3} s, two {two:.3} s: ×{:.2}", one / two);
}

fn light_errors(lamp: &Prepared) {
    let start = Instant::now();
    shoot(lamp, 0.0);
    let exact = start.elapsed().as_secs_f64();
    println!("10⁵ samples, exact: {exact:.3} s");
    for light_error in [0.1, 0.03, 0.01, 0.003] {
        let seconds = fastest(|| shoot(lamp, light_error));
        println!("  light_error {light_error}: {seconds:.3} s, 1/{:.0}", exact / seconds);
    }
}

/// By number of samples; the first is the reference.
fn samples() {
    let mut first = None;
    for count in [10_000, 100_000, 1_000_000] {
        let lamp = lamp(count).prepare().expect("a good scene");
        let seconds = fastest(|| shoot(&lamp, LIMITS.light_error));
        let ratio = seconds / *first.get_or_insert(seconds);
        let build = lamp.seconds.light_trees;
        let megabytes = lamp.light_trees[0].memory_bytes() as f64 / 1e6;
        println!(
            "{count} samples: {seconds:.3} s, ×{ratio:.2}; tree in {build:.2} s, {megabytes:.0} MB"
        );
    }
}

/// The same picture with what it does not need: ambient shares in a scene without ambient light,
/// and transmittances of surfaces that let nothing through.
fn unused_features() {
    let plain = lamp(10_000);
    let mut laden = plain.clone();
    for material in &mut laden.materials {
        material.k_a = 0.5;
        material.transmittance.get_or_insert_with(|| Spectrum::constant(0.5));
    }
    let [plain, laden] = [plain, laden].map(|scene| scene.prepare().expect("a good scene"));
    let take = |lamp: &Prepared| shoot(lamp, LIMITS.light_error);
    let [bare, with] = compare(|| take(&plain), || take(&laden));
    println!("features absent {bare:.3} s, present but unused {with:.3} s: ×{:.3}", with / bare);
}

fn lamp(samples: usize) -> Scene {
    let pillow = |x: f64, y: f64, width: f64, depth: f64| {
        let across = |t: f64| 2.0 * (t / width).rem_euclid(1.0) - 1.0;
        0.5 * depth * (across(x).powi(2) + across(y).powi(2))
    };
    let reflector =
        sheet("reflector", 200.0, 490, |x, y| (x * x + y * y) / 100.0 + pillow(x, y, 12.0, 0.25));
    let lens_in = turned(sheet("lens", 204.0, 240, |x, y| 117.0 - pillow(x, y, 6.0, 0.25)));
    let lens_out = sheet("lens", 204.0, 240, |_, _| 120.0);
    let meshes = [reflector, lens_in, lens_out];
    let material = [0, 1, 1];
    let objects = meshes.into_iter().zip(material);
    Scene {
        objects: objects
            .map(|(mesh, at)| Object { mesh: Arc::new(mesh), material: MaterialId(at) })
            .collect(),
        materials: vec![aluminium(), red_lens()],
        lights: vec![filament(samples)],
        ..Scene::default()
    }
}

fn sheet(what: &str, side: f64, cells: usize, height: impl Fn(f64, f64) -> f64) -> Mesh {
    let place = |i: usize| (i as f64 / cells as f64 - 0.5) * side;
    let mut points = Vec::new();
    for j in 0..=cells {
        for i in 0..=cells {
            let (x, y) = (place(i), 0.6 * place(j));
            points.push(Some(DVec3::new(x, y, height(x, y))));
        }
    }
    Mesh::from_grid(what, cells, cells, &points).expect("a good grid")
}

/// The other side in front.
fn turned(mesh: Mesh) -> Mesh {
    let triangles = mesh.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    Mesh::smooth("mesh", mesh.positions, triangles).expect("a good mesh")
}

/// Table 4.
fn aluminium() -> Material {
    Material {
        name: "aluminium".to_owned(),
        reflectance: Spectrum::constant(0.91),
        lobes: Lobes {
            k_d: 0.08,
            n_d: 10.0,
            specular: vec![SpecularLobe { k_s: 0.92, n_s: 1500.0 }],
            ..Lobes::default()
        },
        k_rg: 0.95,
        ..Material::default()
    }
}

fn red_lens() -> Material {
    let red = Spectrum::from_pairs("red", [(590.0, 0.01), (640.0, 0.9)]).expect("a good table");
    Material {
        name: "lens".to_owned(),
        reflectance: Spectrum::constant(0.04),
        transmittance: Some(red),
        thickness_mm: Some(3.0),
        ior: Some(Spectrum::constant(1.49)),
        lobes: Lobes { n_d: 50.0, ..aluminium().lobes },
        k_rg: 0.05,
        k_tg: 0.95,
        ..Material::default()
    }
}

fn filament(samples: usize) -> Light {
    let coil = Coil { wire_radius_mm: 0.0635, turns: 34.0, pitch_mm: 0.1765, coil_radius_mm: 0.5 };
    let filament = Filament {
        coil,
        center: DVec3::Z * 25.0,
        axis: DVec3::X,
        flux_lm: 440.0,
        samples,
        seed: 1,
    };
    Light::new(filament.rayset().expect("a good coil"), Spectrum::blackbody(2750.0))
}
