//! Sums over the surroundings against closed forms and plain integration in f64.

use super::*;
use crate::color::Photometry;
use crate::material::{LobeShape, Lobes, SpecularLobe};

const ALL: SpecularShares = SpecularShares { reflected: 1.0, transmitted: 1.0 };

fn white() -> Vec<Spectrum> {
    vec![Spectrum::constant(1.0)]
}

fn even(width: usize, height: usize) -> Environment {
    let picture = Picture::new(width, height, vec![[1.0, 0.0, 0.0]; width * height]).unwrap();
    Environment::new(Dome::Picture(picture), white()).unwrap()
}

fn diffuse(n_d: f64) -> Lobes {
    Lobes { k_d: 1.0, n_d, ..Lobes::default() }
}

fn specular(n_s: f64) -> Lobes {
    Lobes { specular: vec![SpecularLobe { k_s: 1.0, n_s }], ..Lobes::default() }
}

fn half(n_s: f64) -> Lobes {
    Lobes { shape: LobeShape::Half, ..specular(n_s) }
}

fn query<'a>(normal: DVec3, view: DVec3, lobes: &'a Lobes) -> HitQuery<'a> {
    HitQuery {
        point: DVec3::ZERO,
        normal,
        view,
        lobes,
        photometry: Photometry::Absolute,
        reflects: true,
        transmits: false,
    }
}

fn reflected(environment: &Environment, query: &HitQuery, largest_error: f64) -> FarSide {
    environment.light(query, ALL, largest_error, None).reflected
}

/// Directions all over the place.
fn around(count: usize) -> impl Iterator<Item = DVec3> {
    (0..count).map(move |i| {
        let y = 1.0 - 2.0 * (i as f64 + 0.5) / count as f64;
        let (sin, cos) = (2.399963 * i as f64).sin_cos();
        DVec3::new(cos, 0.0, sin) * (1.0 - y * y).sqrt() + DVec3::Y * y
    })
}

/// A white furnace: ∫ cosⁿ/π = 2/(n + 1), and a whole lobe is (n + 2)/(n + 1).
#[test]
fn furnace_is_even_for_any_resolution() {
    for (width, height) in [(1, 1), (2, 1), (7, 5), (64, 32), (1000, 500)] {
        let furnace = even(width, height);
        for normal in around(12) {
            for n_d in [1.0, 2.5, 10.0, 300.0] {
                let lobes = diffuse(n_d);
                let sum = reflected(&furnace, &query(normal, normal, &lobes), 0.01).dome[0];
                let error = sum / (2.0 / (n_d + 1.0)) - 1.0;
                let allowed = if n_d == 1.0 { 1e-4 } else { 1e-3 };
                assert!(error.abs() < allowed, "{width}: n_d {n_d}: {error:e}");
            }
            for n_s in [20.0, 1500.0, 1e4, 1e6] {
                let lobes = specular(n_s);
                let sum = reflected(&furnace, &query(normal, normal, &lobes), 0.01).dome[0];
                let error = sum / ((n_s + 2.0) / (n_s + 1.0)) - 1.0;
                assert!(error.abs() < 1e-3, "{width}: n_s {n_s}: {error:e}");
            }
        }
    }
}

/// An even light comes back whole where the lobe is above the horizon, and never more than whole.
#[test]
fn half_lobes_return_no_more_than_arrives() {
    let furnace = even(64, 32);
    let normal = toward(20.0, 50.0);
    let across = normal.any_orthonormal_vector();
    for n_s in [1.0, 2.0, 5.0, 20.0, 100.0, 1500.0, 1e6] {
        for degrees in [0.0f64, 30.0, 45.0, 60.0, 75.0, 80.0, 85.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let lobes = half(n_s);
            let query = query(normal, normal * cos + across * sin, &lobes);
            let sum = reflected(&furnace, &query, 0.002).dome[0];
            assert!(sum <= 1.0 + 1e-3, "n_s {n_s} at {degrees}°: {sum}");
            let is_whole = n_s >= 1500.0 || n_s >= 20.0 && degrees <= 45.0;
            assert!(!is_whole || sum >= 1.0 - 1e-3, "n_s {n_s} at {degrees}°: {sum}");
        }
    }
}

/// Plane tilts: level, toward the sun, upright on both sides, and nearly upside down.
const TILTS: [(f64, f64); 5] =
    [(0.0, 90.0), (40.0, 50.0), (40.0, 0.0), (-140.0, 0.0), (100.0, -60.0)];

/// ∫ L cos dω by the midpoint rule in f64, on planes with these normals; a coarser grid changes the
/// fifth digit.
fn illuminances_by_integration(sky: &Sky, normals: [DVec3; 5]) -> [f64; 5] {
    let (rows, columns) = (300, 600);
    let mut sums = [0.0; 5];
    for row in 0..rows {
        let (sin, cos) = (PI / 2.0 * (row as f64 + 0.5) / rows as f64).sin_cos();
        let solid_angle = sin * (PI / 2.0 / rows as f64) * (2.0 * PI / columns as f64);
        for column in 0..columns {
            let phi = 2.0 * PI * (column as f64 + 0.5) / columns as f64;
            let direction = DVec3::new(sin * phi.sin(), cos, sin * phi.cos());
            let light = sky.luminances(direction)[0] * solid_angle;
            for (sum, normal) in sums.iter_mut().zip(normals) {
                *sum += light * direction.dot(normal).max(0.0);
            }
        }
    }
    sums
}

/// Within 0.1 %: every kind on planes of five tilts.
#[test]
fn skies_light_planes_of_any_tilt() {
    let sun = toward(40.0, 35.0);
    let numbers = (1..=15).filter_map(SkyKind::standard);
    let normals = TILTS.map(|(azimuth, elevation)| toward(azimuth, elevation));
    for kind in numbers.chain([SkyKind::Overcast]) {
        let sky = Sky::new(kind, sun).unwrap();
        let environment = Environment::new(Dome::Sky(sky.clone()), white()).unwrap();
        for (normal, expected) in
            normals.into_iter().zip(illuminances_by_integration(&sky, normals))
        {
            let lobes = diffuse(1.0);
            let light = PI * reflected(&environment, &query(normal, normal, &lobes), 0.01).dome[0];
            for found in [environment.illuminance_lx(normal), light] {
                let error = found / expected - 1.0;
                assert!(error.abs() < 1e-3, "{kind:?} {normal}: {error:e}");
            }
        }
    }
}

/// Over the lune that a level plane and one tilted by β both see, ∫ cos dω = π (1 + cos β)/2 and
/// ∫ sin γ cos dω = 2/3 (sin β + (π − β) cos β): type 5 is the first, Moon & Spencer's overcast sky
/// a third of the first and two thirds of the second.
#[test]
fn even_and_overcast_skies_have_their_closed_forms() {
    for (azimuth, elevation) in TILTS {
        let tilt = (90.0 - elevation).to_radians();
        let (sin, cos) = tilt.sin_cos();
        let even = PI * (1.0 + cos) / 2.0;
        let overcast = even / 3.0 + 4.0 / 9.0 * (sin + (PI - tilt) * cos);
        let type_5 = SkyKind::standard(5).unwrap();
        for (kind, expected) in [(type_5, even), (SkyKind::Overcast, overcast)] {
            let sky = Sky::new(kind, DVec3::Y).unwrap();
            let environment = Environment::new(Dome::Sky(sky), white()).unwrap();
            let found = environment.illuminance_lx(toward(azimuth, elevation));
            let error = found / expected - 1.0;
            assert!(error.abs() < 1e-3, "{kind:?} at {elevation}°: {error:e}");
        }
    }
}

/// π L of the polygon that a rectangle in the ceiling covers: Lambert's sum over its edges.
fn ceiling_lx(low: [f64; 2], high: [f64; 2], above_mm: f64) -> f64 {
    let corners = [[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]]
        .map(|[x, z]| DVec3::new(x, above_mm, z).normalize());
    let edge = |k: usize| {
        let (from, to) = (corners[k], corners[(k + 1) % 4]);
        let across = from.cross(to);
        across.length().atan2(from.dot(to)) * across.normalize().y
    };
    (0..4).map(edge).sum::<f64>().abs() / 2.0
}

/// Within 0.1 %, as skies: a panel's rim cuts the dome's cells.
#[test]
fn rooms_light_a_level_plane() {
    let panel = CeilingPanel { center: [1000.0, 500.0], size: [1500.0, 900.0], luminance: 5000.0 };
    let room = Room {
        size: [6000.0, 8000.0],
        above_mm: 2000.0,
        below_mm: 1000.0,
        panels: vec![panel],
        ceiling: 120.0,
        walls: 80.0,
        floor: 30.0,
    };
    let spectra = [white(), white()].concat();
    let found = Environment::new(Dome::Room(room), spectra).unwrap().illuminance_lx(DVec3::Y);
    let expected = 80.0 * PI
        + (120.0 - 80.0) * ceiling_lx([-3000.0, -4000.0], [3000.0, 4000.0], 2000.0)
        + (5000.0 - 120.0) * ceiling_lx([250.0, 50.0], [1750.0, 950.0], 2000.0);
    assert!((found / expected - 1.0).abs() < 1e-3, "{found} for {expected}");
}

/// A picture with a pixel a thousand times as bright as what is around it.
fn spotted() -> Environment {
    let (width, height) = (96, 48);
    let pixel = |at: usize| {
        let (x, y) = (at % width, at / width);
        let spot = if (x, y) == (30, 12) { 1000.0 } else { 0.0 };
        let wave = 1.0 + (x as f32 * 0.4).sin() * (y as f32 * 0.3).cos();
        [wave + spot, 0.5 * wave, if y > 24 { 0.2 } else { 0.0 }]
    };
    let pixels = (0..width * height).map(pixel).collect();
    let picture = Picture::new(width, height, pixels).unwrap();
    let spectra = [450.0, 550.0, 650.0].map(|center| {
        let rows = (0..81).map(|band| {
            let l = 380.0 + 5.0 * f64::from(band);
            (l, (-((l - center) / 40.0f64).powi(2)).exp())
        });
        Spectrum::from_pairs("bell", rows).unwrap()
    });
    Environment::new(Dome::Picture(picture), spectra.to_vec()).unwrap()
}

/// Σ of a lobe over what rays see, on a grid of `per_pixel`² looks a pixel.
fn by_integration(environment: &Environment, side: &Side, lobes: &Lobes) -> Luminances {
    let lobes =
        environment.lobes(&HitQuery { lobes, ..query(side.normal, side.normal, lobes) }, side, 1.0);
    let (rows, columns) = (48 * 16, 96 * 16);
    let mut sums = [0.0; CHANNELS];
    for row in 0..rows {
        for column in 0..columns {
            let place = [(column as f64 + 0.5) / columns as f64, (row as f64 + 0.5) / rows as f64];
            let direction = patch::direction(place);
            if direction.dot(side.normal) <= 0.0 {
                continue;
            }
            let sine = (PI * place[1]).sin();
            let solid_angle = sine * (PI / rows as f64) * (2.0 * PI / columns as f64);
            let scattered = |lobe: &FarLobe| {
                let half = |view: DVec3| (direction + view).normalize();
                let cosine = lobe.half.map_or(direction, half).dot(lobe.axis);
                if cosine > 0.0 { lobe.weight * cosine.powf(lobe.exponent) } else { 0.0 }
            };
            let weight = solid_angle * lobes.iter().map(scattered).sum::<f64>();
            let seen = environment.dome.luminances(place, direction);
            sums.iter_mut().zip(seen).for_each(|(sum, value)| *sum += weight * value);
        }
    }
    sums
}

/// What is stated as error holds, and each spectrum on its own is right, in daylight with a spot.
#[test]
fn sums_keep_their_error() {
    let environment = spotted();
    let lobes =
        [diffuse(1.0), diffuse(10.0), specular(20.0), specular(1500.0), half(2.0), half(100.0)];
    for lobes in lobes {
        for normal in around(6) {
            let view = (normal + DVec3::new(0.5, 0.2, -0.3)).normalize();
            if view.dot(normal) < 0.1 {
                continue;
            }
            let query = query(normal, view, &lobes);
            let exact = by_integration(&environment, &Side::reflected(&query), &lobes);
            for largest_error in [0.1, 0.01] {
                let far = reflected(&environment, &query, largest_error);
                let total: f64 = exact.iter().sum();
                let error = far.dome.iter().sum::<f64>() - total;
                // 1e-3: of the integration.
                let allowed = far.error + 1e-3 * total;
                assert!(error.abs() < allowed, "{lobes:?} {normal}: {error:e} {allowed:e}");
                for (found, exact) in far.dome.iter().zip(exact) {
                    assert!((found - exact).abs() < largest_error * total + 1e-3 * total);
                }
            }
        }
    }
}

/// Half of the sky is hidden by a wall: what is left is half of the light, and no more rays are
/// asked than the error needs.
#[test]
fn what_is_hidden_sends_nothing() {
    let furnace = even(8, 4);
    let lobes = diffuse(1.0);
    let up = query(DVec3::Y, DVec3::Y, &lobes);
    for azimuth in [0.0, 33.0, 77.0] {
        let wall = toward(azimuth, 0.0);
        let sight = |direction: DVec3| direction.dot(wall) > 0.0;
        for largest_error in [0.1, 0.01] {
            let light = furnace.light(&up, ALL, largest_error, Some(&sight));
            let error = light.reflected.dome[0] / 0.5 - 1.0;
            assert!(error.abs() < largest_error, "{azimuth}: {error:e}");
            assert!(light.nodes < 2000, "{} nodes", light.nodes);
        }
    }
    let nothing = |_: DVec3| false;
    assert_eq!(furnace.light(&up, ALL, 0.01, Some(&nothing)).reflected.dome[0], 0.0);
}

fn with_sun(elevation_deg: f64) -> Environment {
    let sun = Sun {
        direction: toward(0.0, elevation_deg),
        illuminance_lx: 1e5,
        spectrum: Spectrum::constant(1.0),
    };
    even(2, 1).scaled(0.0).with_sun(sun)
}

#[test]
fn sunlight_is_right_on_any_plane() {
    for (elevation, normal) in [(90.0, DVec3::Y), (30.0, DVec3::Y), (10.0, toward(50.0, 20.0))] {
        let environment = with_sun(elevation);
        let lobes = diffuse(1.0);
        let sun = reflected(&environment, &query(normal, normal, &lobes), 0.01).sun * PI;
        let expected = 1e5 * toward(0.0, elevation).dot(normal);
        assert!((sun / expected - 1.0).abs() < 1e-3, "{elevation}: {sun} for {expected}");
    }
}

/// A straight edge crosses the disc: the part that is seen is a segment of the circle.
#[test]
fn half_shadows_are_segments_of_the_disc() {
    let environment = with_sun(90.0);
    let lobes = diffuse(1.0);
    let up = query(DVec3::Y, DVec3::Y, &lobes);
    for at in -10..=10 {
        // From one rim of the disc to the other.
        let t = f64::from(at) / 10.0;
        let edge = t * SUN_RADIUS_RAD.sin();
        let (sin, cos) = 0.7f64.sin_cos();
        let sight = |direction: DVec3| direction.x * cos + direction.z * sin > edge;
        let seen = environment.light(&up, ALL, 0.01, Some(&sight)).reflected.sun * PI / 1e5;
        let expected = (t.acos() - t * (1.0 - t * t).sqrt()) / PI;
        assert!((seen - expected).abs() < 0.01, "{t}: {seen} for {expected}");
    }
}

/// A mirror so smooth that its lobe is narrower than the disc sees the disc's luminance.
#[test]
fn sharp_lobes_see_the_disc() {
    let environment = with_sun(40.0);
    let sun = environment.sun().unwrap();
    let normal = (sun.direction + DVec3::X).normalize();
    for lobes in [specular(1e6), half(1e6)] {
        let far = reflected(&environment, &query(normal, DVec3::X, &lobes), 0.01);
        // The part of an R·V lobe within the radius α is 1 − cosⁿ⁺¹ α; the other is no wider.
        let part = 1.0 - SUN_RADIUS_RAD.cos().powf(1e6 + 1.0);
        let expected = sun.luminance() * part;
        assert!((far.sun / expected - 1.0).abs() < 0.01, "{} for {expected}", far.sun);
    }
}

#[test]
fn turned_and_scaled() {
    let environment = spotted();
    let turned = environment.clone().turned(50.0).scaled(3.0);
    let (before, _) = environment.seen(toward(20.0, 10.0));
    let (after, _) = turned.seen(toward(70.0, 10.0));
    for (before, after) in before.iter().zip(after) {
        assert!((3.0 * before - after).abs() < 1e-9 * after.abs().max(1.0));
    }
    let lobes = specular(300.0);
    let [a, b] = [(toward(20.0, 40.0), &environment), (toward(70.0, 40.0), &turned)]
        .map(|(normal, environment)| reflected(environment, &query(normal, normal, &lobes), 0.003));
    assert!((3.0 * a.dome[0] / b.dome[0] - 1.0).abs() < 1e-6);
}
