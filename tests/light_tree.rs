//! Eq. 9 by the light tree: against the plain f64 sum, and its error against its own estimate.

#[path = "common/random.rs"]
mod random;

use std::f64::consts::{PI, TAU};

use glam::{DAffine3, DQuat, DVec3};
use lampyris::color::Photometry;
use lampyris::light::sum::reference_sum;
use lampyris::light::{HitQuery, LightSum, LightTree, RaySample, RaySet, Sight, Visibility};
use lampyris::material::{LobeShape, Lobes, SpecularLobe};
use random::Random;

impl Random {
    /// Evenly over the sphere.
    fn direction(&mut self) -> DVec3 {
        let (z, angle) = (2.0 * self.unit() - 1.0, TAU * self.unit());
        let across = (1.0 - z * z).sqrt();
        DVec3::new(across * angle.cos(), across * angle.sin(), z)
    }
}

fn set_of(count: usize, mut sample: impl FnMut(usize) -> (DVec3, DVec3, f64)) -> RaySet {
    let samples = (0..count)
        .map(|i| {
            let (position, direction, flux) = sample(i);
            RaySample {
                position: position.as_vec3().into(),
                direction: direction.as_vec3().into(),
                flux: flux as f32,
            }
        })
        .collect();
    RaySet::new(samples, 460.0)
}

/// A coiled filament of Lambert wire along X, 5.5 mm by 0.9 mm.
fn coil(count: usize) -> RaySet {
    let mut random = Random(1);
    set_of(count, |_| {
        let (t, around) = (random.unit(), TAU * random.unit());
        let (sin, cos) = (TAU * 22.0 * t).sin_cos();
        let outward = DVec3::new(0.0, cos, sin);
        let tangent = DVec3::new(5.5 / (TAU * 22.0), -0.41 * sin, 0.41 * cos).normalize();
        let normal = outward * around.cos() + tangent.cross(outward) * around.sin();
        let axis = DVec3::X * 5.5 * (t - 0.5) + outward * 0.41;
        (axis + normal * 0.04, normal, 1.0)
    })
}

fn ball(count: usize, radius: f64) -> RaySet {
    let mut random = Random(2);
    set_of(count, |_| {
        let place = random.direction() * radius * random.unit().cbrt();
        (place, random.direction(), random.unit())
    })
}

fn two_clouds(count: usize) -> RaySet {
    let mut random = Random(3);
    set_of(count, |i| {
        let center = if i % 2 == 0 { DVec3::X * -400.0 } else { DVec3::X * 400.0 };
        (center + random.direction() * random.unit(), random.direction(), 1.0)
    })
}

fn one_point(count: usize) -> RaySet {
    let mut random = Random(4);
    set_of(count, |_| (DVec3::new(0.3, -0.2, 0.1), random.direction(), 1.0))
}

/// A flat emitter: kinks in every table.
fn plate(count: usize) -> RaySet {
    let mut random = Random(5);
    set_of(count, |_| (DVec3::new(random.unit(), random.unit(), 0.0) * 3.0, DVec3::Z, 1.0))
}

/// A measured source that was traced to the bulb's surface, with a narrow beam.
fn beam(count: usize) -> RaySet {
    let mut random = Random(6);
    set_of(count, |_| {
        let place = random.direction() * 12.0;
        (place, (DVec3::Z + 0.2 * random.direction()).normalize(), 10f64.powf(-6.0 * random.unit()))
    })
}

fn lobes(k_d: f64, n_d: f64, specular: &[(f64, f64)]) -> Lobes {
    let specular = specular.iter().map(|&(k_s, n_s)| SpecularLobe { k_s, n_s }).collect();
    Lobes { k_d, n_d, specular, ..Lobes::default() }
}

/// A hit whose mirror direction points about where the light is, off by `off`.
fn hit_toward(point: DVec3, light: DVec3, off: f64, random: &mut Random) -> [DVec3; 3] {
    let to_light = (light - point).try_normalize().unwrap_or(DVec3::Z);
    let mirror = (to_light + off * random.direction()).normalize();
    let normal = (mirror + 0.7 * random.direction()).normalize();
    let view = (2.0 * normal.dot(mirror) * normal - mirror).normalize();
    [point, if normal.dot(view) < 0.0 { -normal } else { normal }, view]
}

/// The same where the light stands `elevation` rad above the surface.
fn low_hit(
    point: DVec3,
    light: DVec3,
    (off, elevation): (f64, f64),
    random: &mut Random,
) -> [DVec3; 3] {
    let to_light = (light - point).try_normalize().unwrap_or(DVec3::Z);
    let across = to_light.cross(random.direction()).normalize();
    let normal = to_light * elevation.sin() + across * elevation.cos();
    let mirror = (to_light + off * elevation * random.direction()).normalize();
    let view = (2.0 * normal.dot(mirror) * normal - mirror).normalize();
    [point, if normal.dot(view) < 0.0 { -normal } else { normal }, view]
}

fn query(hit: [DVec3; 3], lobes: &Lobes, photometry: Photometry) -> HitQuery<'_> {
    let [point, normal, view] = hit;
    HitQuery { point, normal, view, lobes, photometry, reflects: true, transmits: true }
}

const BOTH: [Photometry; 2] = [Photometry::Relative, Photometry::Absolute];

fn assert_close(sum: f64, exact: f64, tolerance: f64, what: &str) {
    let error = (sum - exact).abs();
    assert!(error <= tolerance * exact.abs() + 1e-28, "{what}: {sum:e}, expected {exact:e}");
}

#[test]
fn exact_sums_are_those_of_plain_f64_at_every_exponent() {
    let set = coil(3000);
    let tree = LightTree::build(&set);
    let mut random = Random(7);
    for n_d in [1.0, 2.5, 10.0, 64.0, 65.0, 999.5, 1e4, 1e6] {
        for n_s in [1.0, 1.5, 20.0, 64.0, 100.0, 1500.0, 1e5, 1e6] {
            let lobes = lobes(0.08, n_d, &[(0.92, n_s), (0.1, 30.0)]);
            for photometry in BOTH {
                let point = random.direction() * (0.5 + 100.0 * random.unit());
                let off = 2.0 * random.unit() / f64::sqrt(n_s);
                let hit = hit_toward(point, DVec3::X * 2.0, off, &mut random);
                let query = query(hit, &lobes, photometry);
                let (sum, exact) = (tree.sum(&query, 0.0, None), reference_sum(&set, &query, None));
                // model.md asks for 1e-3 up to n = 10⁶, goldens for 1e-4 at n = 1500.
                let tolerance = if n_s.max(n_d) <= 2000.0 { 3e-5 } else { 3e-4 };
                let what = format!("n_d {n_d} n_s {n_s} {photometry:?} at {point}");
                assert_close(sum.reflected, exact.reflected, tolerance, &what);
                assert_close(sum.transmitted, exact.transmitted, tolerance, &what);
                assert_eq!((sum.reflected_error, sum.transmitted_error), (0.0, 0.0));
            }
        }
    }
}

#[test]
fn half_lobes_sum_like_plain_f64_at_every_exponent_and_elevation() {
    let mut random = Random(19);
    for exponent in [1.0, 30.0] {
        let set = coil(3000).with_exponent(exponent).unwrap();
        let tree = LightTree::build(&set);
        for n_s in [1.0, 1.5, 16.0, 20.0, 1500.0, 1e5, 1e6] {
            let lobes = Lobes { shape: LobeShape::Half, ..lobes(0.08, 2.0, &[(0.9, n_s)]) };
            for (i, elevation) in [1.5, 0.8, 0.3, 0.1, 0.02, 1e-3].into_iter().enumerate() {
                let point = random.direction() * (0.5 + 100.0 * random.unit());
                let off = 2.0 * random.unit() / f64::sqrt(n_s);
                let hit = low_hit(point, DVec3::X * 2.0, (off, elevation), &mut random);
                let query = query(hit, &lobes, BOTH[i % 2]);
                let (sum, exact) = (tree.sum(&query, 0.0, None), reference_sum(&set, &query, None));
                // As of R·V lobes; elevations under 0.1 sharpen the lobe as exponents do.
                let is_sharp = n_s > 2000.0 || elevation < 0.1;
                let tolerance = if is_sharp { 3e-4 } else { 3e-5 };
                let what = format!("m {exponent} n_s {n_s} {elevation} at {point}");
                assert_close(sum.reflected, exact.reflected, tolerance, &what);
                assert_close(sum.transmitted, exact.transmitted, tolerance, &what);
            }
        }
    }
}

/// The formula itself, in closed form: N, L and V in one plane, at ± 30° and a little beside.
#[test]
fn a_half_lobe_is_its_formula() {
    let n_s = 100.0f64;
    let lobes = Lobes { shape: LobeShape::Half, ..lobes(0.0, 1.0, &[(0.5, n_s)]) };
    for beside_deg in [0.0f64, 4.0] {
        let (l, v) = ((30.0 + beside_deg).to_radians(), 30f64.to_radians());
        let light = DVec3::new(l.sin(), 0.0, l.cos());
        let set = set_of(1, |_| (light * 2000.0, -light, 1.0));
        let tree = LightTree::build(&RaySet { flux_lm: 1.0, ..set });
        let hit = [DVec3::ZERO, DVec3::Z, DVec3::new(-v.sin(), 0.0, v.cos())];
        let g_s = (0.5 * beside_deg).to_radians().cos().powf(4.0 * n_s);
        let relative = tree.sum(&query(hit, &lobes, Photometry::Relative), 0.0, None);
        assert_close(relative.reflected, 0.5 * g_s, 2e-5, "relative");
        let absolute = tree.sum(&query(hit, &lobes, Photometry::Absolute), 0.0, None);
        let norm = (4.0 * n_s + 2.0) / (2.0 * PI) / (4.0 * v.cos());
        assert_close(absolute.reflected, 0.5 * norm * g_s / (4.0 * PI), 2e-5, "absolute");
    }
}

#[test]
fn narrow_samples_sum_like_plain_f64_up_to_the_largest_exponent() {
    let mut random = Random(17);
    for exponent in [1.0, 1.5, 7.0, 30.0, 300.0, 3e4] {
        let set = coil(3000).with_exponent(exponent).unwrap();
        let tree = LightTree::build(&set);
        for (i, n_s) in [20.0, 1500.0, 1e6].into_iter().cycle().take(30).enumerate() {
            let lobes = lobes(0.3, 1.0, &[(0.7, n_s)]);
            let point = random.direction() * (0.5 + 100.0 * random.unit());
            let off = 2.0 * random.unit() / f64::sqrt(n_s);
            let hit = hit_toward(point, DVec3::X * 2.0, off, &mut random);
            let query = query(hit, &lobes, BOTH[i % 2]);
            let (sum, exact) = (tree.sum(&query, 0.0, None), reference_sum(&set, &query, None));
            // Exponents over 2000 turn f32's rounding of directions into 1e-4, as model.md allows.
            let tolerance = if n_s.max(exponent) <= 2000.0 { 3e-5 } else { 3e-4 };
            let what = format!("m {exponent} n_s {n_s} at {point}");
            assert_close(sum.reflected, exact.reflected, tolerance, &what);
            assert_close(sum.transmitted, exact.transmitted, tolerance, &what);
        }
    }
    assert!(coil(1).with_exponent(3.1e4).is_err() && coil(1).with_exponent(0.9).is_err());
}

/// A narrow lobe's intensity straight on is Φ (m + 1)/(2π).
#[test]
fn a_narrow_sample_has_its_intensity() {
    for exponent in [1.0, 30.0, 3e4] {
        let set = RaySet::new(set_of(1, |_| (DVec3::Z * 2000.0, -DVec3::Z, 1.0)).samples, 1.0);
        let tree = LightTree::build(&set.with_exponent(exponent).unwrap());
        let lobes = lobes(1.0, 1.0, &[]);
        let hit = [DVec3::ZERO, DVec3::Z, DVec3::Z];
        let sum = tree.sum(&query(hit, &lobes, Photometry::Absolute), 0.0, None);
        assert_close(sum.reflected, (exponent + 1.0) / (2.0 * PI) / 4.0 / PI, 1e-6, "straight on");
    }
}

#[test]
fn estimates_hold_for_narrow_samples() {
    for exponent in [1.5, 30.0, 1000.0, 3e4] {
        let narrow = |set: RaySet| set.with_exponent(exponent).unwrap();
        check("narrow ball", &narrow(ball(4000, 2.0)), DVec3::ZERO, 2.0, 14);
        check("narrow beam", &narrow(beam(4000)), DVec3::ZERO, 12.0, 14);
        check("narrow plate", &narrow(plate(4000)), DVec3::new(1.5, 1.5, 0.0), 3.0, 14);
        check("narrow clouds", &narrow(two_clouds(4000)), DVec3::X * 400.0, 2.0, 14);
        check("narrow point", &narrow(one_point(4000)), DVec3::new(0.3, -0.2, 0.1), 1.0, 14);
        check_half("narrow ball", &narrow(ball(4000, 2.0)), DVec3::ZERO, 2.0, 7);
    }
}

/// Where the view is along the normal but for rounding, what is across has no direction.
#[test]
fn a_view_along_the_normal_is_exact() {
    let set = ball(50, 1.0);
    let tree = LightTree::build(&set);
    let lobes = lobes(0.5, 1.0, &[(0.5, 100.0)]);
    let mut random = Random(18);
    for _ in 0..50 {
        let normal = random.direction();
        for nudge in [0.0, 1e-17, 1e-12, 1e-8, 1e-4] {
            let view = (normal + random.direction() * nudge).normalize();
            let query = query([normal * -20.0, normal, view], &lobes, Photometry::Absolute);
            let (sum, exact) = (tree.sum(&query, 0.0, None), reference_sum(&set, &query, None));
            assert_close(sum.reflected, exact.reflected, 3e-5, "reflected");
        }
    }
}

#[test]
fn hits_on_and_among_the_samples_are_exact_and_finite() {
    let set = ball(2000, 1.0);
    let tree = LightTree::build(&set);
    let lobes = lobes(0.5, 10.0, &[(0.5, 1e6)]);
    let mut random = Random(8);
    for i in 0..50 {
        let on = set.samples[i * 31].origin();
        let point = if i % 2 == 0 { on } else { on + random.direction() * 1e-6 };
        for photometry in BOTH {
            let light = set.samples[i].origin();
            let hit = hit_toward(point, light, 0.0, &mut random);
            let query = query(hit, &lobes, photometry);
            let exact = reference_sum(&set, &query, None);
            for light_error in [0.0, 0.01] {
                let sum = tree.sum(&query, light_error, None);
                assert!(sum.reflected.is_finite() && sum.transmitted.is_finite());
                let tolerance = light_error + 3e-4;
                assert_close(sum.reflected, exact.reflected, tolerance, "reflected");
                assert_close(sum.transmitted, exact.transmitted, tolerance, "transmitted");
            }
        }
    }
}

#[test]
fn placement_scale_and_flux_carry_over() {
    let mut set = coil(500);
    set.world_from_local = DAffine3::from_scale_rotation_translation(
        DVec3::splat(2.5),
        DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 1.1),
        DVec3::new(1e4, -300.0, 20.0),
    );
    let lobes = lobes(0.08, 10.0, &[(0.92, 1500.0)]);
    let mut random = Random(9);
    for flux_lm in [1e-12, 1.0, 1e12] {
        set.flux_lm = flux_lm;
        let tree = LightTree::build(&set);
        for photometry in BOTH {
            let light = set.world_from_local.translation;
            let hit = hit_toward(light + random.direction() * 60.0, light, 0.01, &mut random);
            let query = query(hit, &lobes, photometry);
            let (sum, exact) = (tree.sum(&query, 0.0, None), reference_sum(&set, &query, None));
            let relative = |a: f64, b: f64| if b > 0.0 { (a / b - 1.0).abs() } else { a.abs() };
            assert!(relative(sum.reflected, exact.reflected) < 3e-5, "{sum:?} {exact:?}");
            assert!(relative(sum.transmitted, exact.transmitted) < 3e-5, "{sum:?} {exact:?}");
        }
    }
}

/// Hits around a set, from inside it to kilometers away.
fn hits(light: DVec3, size: f64, n_s: f64, random: &mut Random, count: usize) -> Vec<[DVec3; 3]> {
    let reach = [0.3, 1.0, 3.0, 10.0, 40.0, 1e3, 1e6];
    (0..count)
        .map(|i| {
            let point = light + random.direction() * size * reach[i % reach.len()];
            let off =
                [0.0, 1.0, 3.0, 8.0][i / 7 % 4] / f64::sqrt(n_s) + 0.3 * f64::from(i % 5 == 0);
            hit_toward(point, light, off, random)
        })
        .collect()
}

/// Largest ratio of true to estimated error, after checking each hit.
fn check(name: &str, set: &RaySet, light: DVec3, size: f64, count: usize) -> f64 {
    let count = count * effort();
    let mut random = Random(11);
    let mut all = Vec::new();
    for n_s in [20.0, 1500.0, 1e6] {
        for n_d in [1.0, 10.0, 50.0] {
            for photometry in BOTH {
                let hits = hits(light, size, n_s, &mut random, count);
                all.push((lobes(0.08, n_d, &[(0.92, n_s)]), photometry, hits));
            }
        }
    }
    check_all(name, set, (light, size), &all)
}

/// How many times as many random hits are tried, by the environment.
fn effort() -> usize {
    std::env::var("LAMPYRIS_HITS").ok().and_then(|text| text.parse().ok()).unwrap_or(1)
}

/// The same for half-vector lobes, with hits that the light grazes.
fn check_half(name: &str, set: &RaySet, light: DVec3, size: f64, count: usize) -> f64 {
    let count = count * effort();
    let mut random = Random(20);
    let mut all = Vec::new();
    for (i, n_s) in [1.0, 20.0, 1500.0, 1e6].into_iter().enumerate() {
        let mut hits = hits(light, size, n_s, &mut random, count);
        for (i, elevation) in [0.5, 0.2, 0.05, 0.01].into_iter().cycle().take(count).enumerate() {
            let point = light + random.direction() * size * [1.5, 5.0, 40.0, 1e3, 1e6][i % 5];
            let off = [0.0, 1.0, 3.0][i / 4 % 3] / f64::sqrt(n_s);
            hits.push(low_hit(point, light, (off, elevation), &mut random));
        }
        let lobes = lobes(0.08, 1.0, &[(0.7, n_s), (0.22, 3.0)]);
        all.push((Lobes { shape: LobeShape::Half, ..lobes }, BOTH[i % 2], hits));
    }
    check_all(name, set, (light, size), &all)
}

fn check_all(
    name: &str,
    set: &RaySet,
    (light, size): (DVec3, f64),
    all: &[(Lobes, Photometry, Vec<[DVec3; 3]>)],
) -> f64 {
    let tree = LightTree::build(set);
    let from_light = |sample| set.world_origin(sample).distance(light);
    let reach = set.samples.iter().map(from_light).fold(0.0, f64::max);
    let (mut worst, mut nodes, mut samples) = (0.0f64, 0, 0);
    for (lobes, photometry, hits) in all {
        for hit in hits {
            let query = query(*hit, lobes, *photometry);
            let exact = tree.sum(&query, 0.0, None);
            for light_error in [0.1, 0.01, 0.001] {
                let sum = tree.sum(&query, light_error, None);
                let what = format!("{name} {lobes:?} {photometry:?} {light_error} {hit:?}");
                let beam = (set.exponent + 1.0) / 2.0;
                let dark = 1e-13 * beam * brightest(&query, light, size.min(reach));
                let ratio = check_sides(&sum, &exact, light_error, dark, &what);
                worst = worst.max(ratio);
                (nodes, samples) = (nodes + sum.nodes, samples + sum.samples);
            }
        }
    }
    println!("{name}: largest true/estimated error {worst:.3}, {nodes} nodes, {samples} samples");
    worst
}

/// What the set could send straight at the hit, or from `size` if the hit is nearer.
fn brightest(query: &HitQuery, light: DVec3, size: f64) -> f64 {
    let absolute = query.photometry == Photometry::Absolute;
    let cos_view = query.normal.dot(query.view);
    let norm = |n: f64| match (absolute, query.lobes.shape) {
        (false, _) => 1.0,
        (true, LobeShape::Mirror) => (n + 2.0) / (2.0 * PI),
        (true, LobeShape::Half) => (4.0 * n + 2.0) / (8.0 * PI * cos_view),
    };
    let diffuse = query.lobes.k_d * if absolute { 1.0 / PI } else { 1.0 };
    let specular: f64 = query.lobes.specular.iter().map(|lobe| lobe.k_s * norm(lobe.n_s)).sum();
    let distance_m = query.point.distance(light).max(size) * 1e-3;
    let falloff = if absolute { 1.0 / (PI * distance_m * distance_m) } else { 1.0 };
    460.0 * (diffuse + specular) * falloff
}

/// Below `dark` the error is absolute.
fn check_sides(sum: &LightSum, exact: &LightSum, light_error: f64, dark: f64, what: &str) -> f64 {
    let reflected = (sum.reflected, sum.reflected_error, exact.reflected);
    let transmitted = (sum.transmitted, sum.transmitted_error, exact.transmitted);
    let mut worst = 0.0f64;
    for (value, estimate, exact) in [reflected, transmitted] {
        assert!(value.is_finite() && estimate.is_finite(), "{what}: {sum:?}");
        // Both sums round in f32: 3e-6 of them is not the tree's.
        let error = ((value - exact).abs() - 3e-6 * exact).max(0.0);
        assert!(estimate <= light_error * exact.max(dark), "{what}: {sum:?} for {exact:e}");
        assert!(error <= estimate.max(1e-3 * dark), "{what}: {sum:?} for {exact:e}");
        if error > 1e-3 * dark {
            worst = worst.max(error / estimate);
        }
    }
    worst
}

#[test]
fn estimates_hold_for_half_lobes() {
    check_half("coil", &coil(20_000), DVec3::ZERO, 3.0, 56);
    check_half("ball", &ball(10_000, 2.0), DVec3::ZERO, 2.0, 56);
    check_half("two clouds", &two_clouds(10_000), DVec3::X * 400.0, 2.0, 28);
    check_half("two clouds, all", &two_clouds(10_000), DVec3::ZERO, 400.0, 28);
    check_half("one point", &one_point(10_000), DVec3::new(0.3, -0.2, 0.1), 1.0, 28);
    check_half("plate", &plate(10_000), DVec3::new(1.5, 1.5, 0.0), 3.0, 56);
    check_half("beam", &beam(10_000), DVec3::ZERO, 12.0, 700);
    check_half("one sample", &ball(1, 1.0), DVec3::ZERO, 1.0, 7);
}

#[test]
fn estimates_hold_for_a_filament() {
    check("coil", &coil(20_000), DVec3::ZERO, 3.0, 56);
}

#[test]
fn estimates_hold_down_to_the_coarse_grids() {
    check("coil of 150,000", &coil(150_000), DVec3::ZERO, 3.0, 7);
}

#[test]
fn estimates_hold_for_a_ball_of_random_samples() {
    check("ball", &ball(10_000, 2.0), DVec3::ZERO, 2.0, 56);
}

#[test]
fn estimates_hold_for_two_far_clouds() {
    check("two clouds", &two_clouds(10_000), DVec3::X * 400.0, 2.0, 28);
    check("two clouds, all", &two_clouds(10_000), DVec3::ZERO, 400.0, 28);
}

#[test]
fn estimates_hold_for_samples_in_one_point() {
    check("one point", &one_point(10_000), DVec3::new(0.3, -0.2, 0.1), 1.0, 28);
}

#[test]
fn estimates_hold_for_a_plate_and_a_beam() {
    check("plate", &plate(10_000), DVec3::new(1.5, 1.5, 0.0), 3.0, 56);
    // Few of the hits within the beam's sphere are of those that only samples turned toward them light.
    check("beam", &beam(10_000), DVec3::ZERO, 12.0, 350);
}

#[test]
fn estimates_hold_for_few_samples() {
    check("one sample", &ball(1, 1.0), DVec3::ZERO, 1.0, 7);
    check("two thousand", &ball(2100, 1.0), DVec3::ZERO, 1.0, 28);
}

/// A hit 200 mm from the coil, which sees its middle `elevation` above the horizon.
fn grazing_hit(elevation: f64, random: &mut Random) -> [DVec3; 3] {
    let point = random.direction() * 200.0;
    let to_light = -point.normalize();
    let across = to_light.cross(random.direction()).normalize();
    [point, to_light * elevation.sin() + across * elevation.cos(), across]
}

#[test]
fn estimates_hold_toward_the_horizon_and_leave_the_samples_alone() {
    let tree = LightTree::build(&coil(100_000));
    let mut random = Random(14);
    let (mut worst, mut most_samples) = (0.0f64, 0);
    for n_d in [1.0, 1.5, 2.5, 3.5, 5.0, 10.0, 39.0, 41.0] {
        let lobes = lobes(0.08, n_d, &[(0.92, 1500.0)]);
        for elevation in [-0.02, 0.001, 0.01, 0.02, 0.03, 0.05, 0.1, 0.3] {
            let query = query(grazing_hit(elevation, &mut random), &lobes, Photometry::Relative);
            let exact = tree.sum(&query, 0.0, None);
            for light_error in [0.1, 0.01] {
                let sum = tree.sum(&query, light_error, None);
                let what = format!("{n_d} {elevation} {light_error}");
                let dark = 1e-13 * brightest(&query, DVec3::ZERO, 3.0);
                worst = worst.max(check_sides(&sum, &exact, light_error, dark, &what));
                if elevation > 0.015 {
                    most_samples = most_samples.max(sum.samples);
                }
            }
        }
    }
    println!("horizon: largest true/estimated error {worst:.3}, at most {most_samples} samples");
    // The cloud is 0.03 rad wide: from there on its nodes are within the lobe.
    assert!(most_samples < 5000, "{most_samples} of 100,000 samples");
}

#[test]
fn an_empty_set_and_one_that_points_away_are_dark() {
    let lobes = lobes(0.5, 1.0, &[(0.5, 100.0)]);
    let hit = [DVec3::Z * 50.0, -DVec3::Z, -DVec3::Z];
    for set in [ball(0, 1.0), set_of(5000, |i| (DVec3::X * i as f64 * 1e-3, -DVec3::Z, 1.0))] {
        let tree = LightTree::build(&set);
        for light_error in [0.0, 0.01] {
            let sum = tree.sum(&query(hit, &lobes, Photometry::Absolute), light_error, None);
            assert_eq!((sum.reflected, sum.transmitted), (0.0, 0.0));
        }
    }
}

#[test]
fn threads_change_no_bit() {
    let set = coil(30_000);
    let build = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads").install(|| LightTree::build(&set))
    };
    let (one, many) = (build(1), build(5));
    let lobes = lobes(0.08, 10.0, &[(0.92, 1500.0)]);
    let mut random = Random(12);
    for hit in hits(DVec3::ZERO, 3.0, 1500.0, &mut random, 70) {
        let query = query(hit, &lobes, Photometry::Relative);
        for light_error in [0.0, 0.01] {
            assert_eq!(one.sum(&query, light_error, None), many.sum(&query, light_error, None));
        }
    }
}

#[test]
fn shadows_of_an_edge_are_within_the_error() {
    let set = coil(20_000);
    let tree = LightTree::build(&set);
    let lobes = lobes(0.08, 10.0, &[(0.92, 300.0)]);
    let mut random = Random(13);
    for i in 0..40 {
        // Hides everything beyond an x that cuts the coil.
        let edge = 4.0 * random.unit() - 2.0;
        let free = move |light: DVec3| light.x < edge;
        let point = DVec3::new(10.0 * random.unit(), 5.0, 60.0);
        let hit = hit_toward(point, DVec3::ZERO, 0.03, &mut random);
        let query = query(hit, &lobes, BOTH[i % 2]);
        let exact = reference_sum(&set, &query, Some(&free));
        let nothing = Visibility::of_places(&|_| false);
        assert_eq!(tree.sum(&query, 0.0, Some(nothing)).reflected, 0.0);
        let ball = |center: DVec3, radius: f64| match center.x {
            x if x + radius < edge => Sight::Seen,
            x if x - radius >= edge => Sight::Hidden,
            _ => Sight::Unknown,
        };
        let by_places = Visibility::of_places(&free);
        for visible in [by_places, Visibility { ball: &ball, ..by_places }] {
            let plain = tree.sum(&query, 0.0, Some(visible));
            assert_close(plain.reflected, exact.reflected, 3e-5, "exact");
            let sum = tree.sum(&query, 0.01, Some(visible));
            assert_close(sum.reflected, exact.reflected, 0.01, "tree");
        }
    }
}

#[test]
fn a_lambert_reflector_under_a_point_source_has_its_textbook_luminance() {
    // E = Φ/π cos / r² of a Lambert point, L = k_d E / π: 1 lm at 2 m, straight on.
    let set = set_of(1, |_| (DVec3::Z * 2000.0, -DVec3::Z, 1.0));
    let lobes = lobes(0.8, 1.0, &[]);
    let tree = LightTree::build(&RaySet { flux_lm: 1.0, ..set });
    let hit = [DVec3::ZERO, DVec3::Z, DVec3::Z];
    let sum = tree.sum(&query(hit, &lobes, Photometry::Absolute), 0.0, None);
    let expected = 0.8 / PI * (1.0 / PI / 4.0);
    assert_close(sum.reflected, expected, 1e-6, "luminance");
}
