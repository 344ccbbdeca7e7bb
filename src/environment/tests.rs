//! Sums over the surroundings against closed forms and plain integration in f64.

use super::*;
use crate::color::Photometry;
use crate::material::{Lobes, SpecularLobe};

const ALL: SpecularShares = SpecularShares { reflected: 1.0, transmitted: 1.0 };

fn white() -> Vec<Spectrum> {
    vec![Spectrum::constant(1.0)]
}

fn even(width: usize, height: usize) -> Environment {
    let picture = Picture::new(width, height, vec![[1.0, 0.0, 0.0]; width * height]).unwrap();
    Environment::new(Dome::Picture(picture), white()).unwrap()
}

fn diffuse(n_d: f64) -> Lobes {
    Lobes { k_d: 1.0, n_d, specular: Vec::new() }
}

fn specular(n_s: f64) -> Lobes {
    Lobes { k_d: 0.0, n_d: 1.0, specular: vec![SpecularLobe { k_s: 1.0, n_s }] }
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
                assert!(error.abs() < 1e-4, "{width}: n_d {n_d}: {error:e}");
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

#[test]
fn probe() {
    for (width, height) in [(1, 1), (64, 32), (1000, 500)] {
        let furnace = even(width, height);
        for (name, lobes, right) in [
            ("d1", diffuse(1.0), 1.0),
            ("d2.5", diffuse(2.5), 2.0 / 3.5),
            ("d10", diffuse(10.0), 2.0 / 11.0),
            ("s20", specular(20.0), 22.0 / 21.0),
            ("s1500", specular(1500.0), 1502.0 / 1501.0),
            ("s1e4", specular(1e4), 1.0001),
            ("s1e6", specular(1e6), 1.000001),
        ] {
            for budget in [0.03, 0.01, 0.003, 0.001, 0.0001] {
                let mut worst = 0.0f64;
                let mut nodes = 0;
                let start = std::time::Instant::now();
                for normal in around(12) {
                    let light = furnace.light(&query(normal, normal, &lobes), ALL, budget, None);
                    worst = worst.max((light.reflected.dome[0] / right - 1.0).abs());
                    nodes += light.nodes;
                }
                println!(
                    "{width} {name} {budget}: {worst:.2e}, {} nodes, {:.1} us",
                    nodes / 12,
                    start.elapsed().as_secs_f64() / 12.0 * 1e6
                );
            }
        }
    }
}
