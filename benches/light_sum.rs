//! Sums over light samples at the hits of a lamp like model 1: exact and by the light tree.
//!
//! `cargo bench --bench light_sum [-- N …]`. Every ratio is taken within one run.

use std::f64::consts::TAU;
use std::sync::Arc;
use std::time::Instant;

use glam::DVec3;
use lampyris::color::Photometry;
use lampyris::light::sum::reference_sum;
use lampyris::light::{HitQuery, LightSum, LightTree, RaySample, RaySet};
use lampyris::material::{Lobes, SpecularLobe};

/// The base-b radical inverse of i, in 0 … 1.
fn radical_inverse(base: u64, mut i: u64) -> f64 {
    let (mut digit, mut value) = (1.0 / base as f64, 0.0);
    while i > 0 {
        value += (i % base) as f64 * digit;
        i /= base;
        digit /= base as f64;
    }
    value
}

/// A coil along X, 5.5 mm long and 0.9 mm wide, of Lambert wire.
fn coil(count: usize) -> RaySet {
    const WIRE_RADIUS_MM: f64 = 0.04;
    const COIL_RADIUS_MM: f64 = 0.45 - WIRE_RADIUS_MM;
    const LENGTH_MM: f64 = 5.5;
    const TURNS: f64 = 22.0;
    let sample = |i: u64| {
        let (t, around) = (radical_inverse(2, i), TAU * radical_inverse(3, i));
        let (sin, cos) = (TAU * TURNS * t).sin_cos();
        let outward = DVec3::new(0.0, cos, sin);
        let advance = LENGTH_MM / (TAU * TURNS);
        let tangent = DVec3::new(advance, -COIL_RADIUS_MM * sin, COIL_RADIUS_MM * cos).normalize();
        let normal = outward * around.cos() + tangent.cross(outward) * around.sin();
        let axis = DVec3::X * LENGTH_MM * (t - 0.5) + outward * COIL_RADIUS_MM;
        RaySample {
            position: (axis + normal * WIRE_RADIUS_MM).as_vec3().into(),
            direction: normal.as_vec3().into(),
            flux: 1.0,
        }
    };
    let samples: Arc<[RaySample]> = (1..=count as u64).map(sample).collect();
    RaySet::new(samples, 460.0)
}

/// Pixels along a tile's edge: neighbors in a picture ask nearly the same.
const TILE: u64 = 4;

/// The i-th of a picture's points, 0 … 1 in four dimensions: tiles anywhere, their pixels side by
/// side.
fn picture_point(i: u64) -> [f64; 4] {
    let (tile, pixel) = (1 + i / (TILE * TILE), i % (TILE * TILE));
    let [x, y] = [pixel % TILE, pixel / TILE].map(|step| step as f64 / 500.0);
    let at = |base, step| (radical_inverse(base, tile) + step) % 1.0;
    [at(2, x), at(3, y), at(5, x), at(7, y)]
}

/// A point of a surface as a camera ray on +Z finds it.
struct Hit {
    point: DVec3,
    normal: DVec3,
    view: DVec3,
}

/// Hits on a paraboloid of focal length 20 mm about the coil, with pillows that tilt its normal.
fn reflector_hits(count: u64, tilt_rad: f64) -> Vec<Hit> {
    const FOCAL_MM: f64 = 20.0;
    let eye = DVec3::new(0.0, 0.0, 3000.0);
    let hit = |i: u64| {
        let [u, v, tilt_u, tilt_v] = picture_point(i);
        let distance = 20.0 + 90.0 * u;
        let (sin, cos) = (TAU * v).sin_cos();
        let across = (4.0 * FOCAL_MM * (distance - FOCAL_MM)).sqrt();
        let point = DVec3::new(across * cos, across * sin, distance - 2.0 * FOCAL_MM);
        let tilt = DVec3::new(tilt_u - 0.5, tilt_v - 0.5, 0.0);
        let slope = DVec3::new(-point.x, -point.y, 2.0 * FOCAL_MM).normalize();
        let normal = (slope + 2.0 * tilt_rad * tilt).normalize();
        Hit { point, normal, view: (eye - point).normalize() }
    };
    (0..count).map(hit).collect()
}

/// Hits on a plane lens 60 mm before the coil, whose optics tilt its normal.
fn lens_hits(count: u64) -> Vec<Hit> {
    let eye = DVec3::new(0.0, 0.0, 3000.0);
    let hit = |i: u64| {
        let [u, v, tilt_u, tilt_v] = picture_point(i);
        let tilt = DVec3::new(tilt_u - 0.5, tilt_v - 0.5, 0.0);
        let point = DVec3::new(120.0 * u - 60.0, 120.0 * v - 60.0, 60.0);
        let normal = (DVec3::Z + 0.4 * tilt).normalize();
        Hit { point, normal, view: (eye - point).normalize() }
    };
    (0..count).map(hit).collect()
}

struct Case {
    name: &'static str,
    hits: Vec<Hit>,
    lobes: Lobes,
    transmits: bool,
    photometry: Photometry,
}

impl Case {
    fn query(&self, hit: &Hit) -> HitQuery<'_> {
        HitQuery {
            point: hit.point,
            normal: hit.normal,
            view: hit.view,
            lobes: &self.lobes,
            photometry: self.photometry,
            reflects: true,
            transmits: self.transmits,
        }
    }
}

fn lobes(n_d: f64, n_s: f64) -> Lobes {
    Lobes { k_d: 0.08, n_d, specular: vec![SpecularLobe { k_s: 0.92, n_s }], ..Lobes::default() }
}

fn cases() -> Vec<Case> {
    use Photometry::{Absolute, Relative};
    let case = |name, hits, lobes, transmits, photometry| Case {
        name,
        hits,
        lobes,
        transmits,
        photometry,
    };
    vec![
        case("reflector", reflector_hits(1600, 0.1), lobes(10.0, 1500.0), false, Relative),
        case(
            "reflector, no pillows",
            reflector_hits(1600, 0.0),
            lobes(10.0, 1500.0),
            false,
            Relative,
        ),
        case(
            "reflector, absolute",
            reflector_hits(1600, 0.1),
            lobes(10.0, 1500.0),
            false,
            Absolute,
        ),
        case("lens, both sides", lens_hits(1600), lobes(50.0, 1500.0), true, Relative),
    ]
}

/// This thread's processor time, which other programs on the machine disturb less; wall time
/// where the system does not tell.
fn processor_s() -> f64 {
    static START: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();
    let wall = START.get_or_init(Instant::now).elapsed().as_secs_f64();
    let stat = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let spent = stat.split(' ').next().and_then(|ns| ns.parse::<f64>().ok());
    spent.map_or(wall, |ns| ns * 1e-9)
}

/// Seconds a call, and the results.
fn timed<T>(queries: &[HitQuery], mut sum: impl FnMut(&HitQuery) -> T) -> (f64, Vec<T>) {
    let start = processor_s();
    let sums = queries.iter().map(&mut sum).collect();
    ((processor_s() - start) / queries.len() as f64, sums)
}

/// The larger of the two sides' relative errors; (true, estimated).
fn relative_errors(sum: &LightSum, exact: &LightSum) -> (f64, f64) {
    let side = |sum: f64, error: f64, exact: f64| {
        if exact > 0.0 { ((sum - exact).abs() / exact, error / exact) } else { (0.0, 0.0) }
    };
    let reflected = side(sum.reflected, sum.reflected_error, exact.reflected);
    let transmitted = side(sum.transmitted, sum.transmitted_error, exact.transmitted);
    (reflected.0.max(transmitted.0), reflected.1.max(transmitted.1))
}

fn quantile(sorted: &[f64], fraction: f64) -> f64 {
    sorted[((sorted.len() - 1) as f64 * fraction) as usize]
}

/// The processor's clock ticks every few milliseconds: enough sums to fill some of them.
const ROUNDS: usize = 10;

fn bench_case(tree: &LightTree, case: &Case) {
    let queries: Vec<HitQuery> = case.hits.iter().map(|hit| case.query(hit)).collect();
    // The exact sum of every hit would take minutes.
    let step = (tree.len() / 20_000).clamp(1, 13);
    let few: Vec<HitQuery> = queries.iter().copied().step_by(step).collect();
    let (exact_s, exact) = timed(&few, |query| tree.sum(query, 0.0, None));
    let evaluations = tree.len() as f64 / exact_s * 1e-6;
    println!("  {}: exact {:.1} µs a hit, {evaluations:.0} M samples/s", case.name, exact_s * 1e6);
    let mut default_s = f64::NAN;
    for light_error in [0.05, 0.01, 0.003, 0.001] {
        let sums: Vec<LightSum> =
            queries.iter().map(|query| tree.sum(query, light_error, None)).collect();
        let (tree_s, _) =
            timed(&queries.repeat(ROUNDS), |query| tree.sum(query, light_error, None));
        if light_error == 0.01 {
            default_s = tree_s;
        }
        let pairs: Vec<(f64, f64)> = sums
            .iter()
            .step_by(step)
            .zip(&exact)
            .map(|(sum, exact)| relative_errors(sum, exact))
            .collect();
        let mut errors: Vec<f64> = pairs.iter().map(|pair| pair.0).collect();
        errors.sort_by(f64::total_cmp);
        let tightest =
            pairs.iter().map(|(e, estimate)| e / estimate.max(1e-30)).fold(0.0, f64::max);
        let mean = |count: fn(&LightSum) -> u32| {
            sums.iter().map(|sum| f64::from(count(sum))).sum::<f64>() / sums.len() as f64
        };
        println!(
            "    {light_error:<5} {:7.2} µs a hit ({:.2} of 0.01's), 1/{:<5.0} nodes {:6.0}, samples {:7.0}, error {:.3} \
             {:.3} {:.3} %, largest error/estimate {tightest:.2}",
            tree_s * 1e6,
            tree_s / default_s,
            exact_s / tree_s,
            mean(|sum| sum.nodes),
            mean(|sum| sum.samples),
            quantile(&errors, 0.5) * 100.0,
            quantile(&errors, 0.95) * 100.0,
            quantile(&errors, 1.0) * 100.0,
        );
    }
}

fn bench_reference(set: &RaySet, case: &Case) {
    let queries: Vec<HitQuery> = case.hits.iter().take(4).map(|hit| case.query(hit)).collect();
    let (seconds, _) = timed(&queries, |query| reference_sum(set, query, None));
    println!("plain f64: {:.0} M samples/s", set.samples.len() as f64 / seconds * 1e-6);
}

fn main() {
    let asked: Vec<usize> = std::env::args().filter_map(|arg| arg.parse().ok()).collect();
    let counts = if asked.is_empty() { vec![10_000, 100_000, 1_000_000] } else { asked };
    let cases = cases();
    for count in counts {
        let set = coil(count);
        let start = Instant::now();
        let tree = LightTree::build(&set);
        let megabytes = tree.memory_bytes() as f64 * 1e-6;
        println!(
            "{count} samples: build {:.2} s, {megabytes:.0} MB",
            start.elapsed().as_secs_f64()
        );
        if count <= 100_000 {
            bench_reference(&set, &cases[0]);
        }
        for case in &cases {
            bench_case(&tree, case);
        }
    }
}
