//! Illuminance and intensity of sets of measured rays, against integrals over their sources.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use lampyris::color::Photometry;
use lampyris::light::{HitQuery, LightTree, RaySample, RaySet};
use lampyris::source::directions::measured_exponent;
use lampyris::source::emitter::{Shape, measured_emitter};

use crate::stage::*;

const FLUX_LM: f64 = 100.0;
const RAYS: u32 = 200_000;

/// A disc in z = 0 that looks along +Z, with a radiance that depends on the angle alone.
struct Source {
    radius_mm: f64,
    /// By the cosine of the angle to +Z; at most 1.
    radiance: fn(f64) -> f64,
}

const LAMBERT: Source = Source { radius_mm: 0.5, radiance: |_| 1.0 };

/// Intensity cos θ (1 + 4 sin² θ), most at 52°.
const BATWING: Source =
    Source { radius_mm: 0.5, radiance: |cos| (1.0 + 4.0 * (1.0 - cos * cos)) / 5.0 };

/// Even within 10° of the axis.
const BEAM: Source =
    Source { radius_mm: 2.5, radiance: |cos| if cos >= COS_10_DEG { 1.0 } else { 0.0 } };
const COS_10_DEG: f64 = 0.984_807_753_012_208;

/// Independent random numbers in 0 to 1 (SplitMix64).
fn fraction(i: u32, k: u64) -> f64 {
    let mut x = (u64::from(i) * 8 + k).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((x ^ (x >> 31)) >> 11) as f64 * 2f64.powi(-53)
}

impl Source {
    /// By rejection, so that the radiance needs no inverse.
    fn rays(&self) -> RaySet {
        let ray = |i: u32| {
            let cos = (1.0 - fraction(i, 2)).sqrt();
            if fraction(i, 3) >= (self.radiance)(cos) {
                return None;
            }
            let (r, at) = (self.radius_mm * fraction(i, 0).sqrt(), TAU * fraction(i, 1));
            let (sin, turn) = ((1.0 - cos * cos).sqrt(), TAU * fraction(i, 4));
            Some(RaySample {
                position: [(r * at.cos()) as f32, (r * at.sin()) as f32, 0.0],
                direction: [(sin * turn.cos()) as f32, (sin * turn.sin()) as f32, cos as f32],
                flux: 1.0,
            })
        };
        RaySet::new((0..).filter_map(ray).take(RAYS as usize).collect(), FLUX_LM)
    }

    /// cd/m² where the radiance function is 1: the flux is π A times its mean over cos² θ.
    fn luminance(&self) -> f64 {
        let steps = 100_000;
        let cos = |k: u32| (1.0 - (f64::from(k) + 0.5) / f64::from(steps)).sqrt();
        let mean = (0..steps).map(|k| (self.radiance)(cos(k))).sum::<f64>() / f64::from(steps);
        FLUX_LM / (PI * PI * self.radius_mm.powi(2) * 1e-6 * mean)
    }

    /// lx on a plane that faces the source, by the midpoint rule over the disc.
    fn illuminance(&self, point: DVec3) -> f64 {
        let (rings, around) = (60, 120);
        let mut sum = 0.0;
        for k in 0..rings * around {
            let r = self.radius_mm * ((f64::from(k / around) + 0.5) / f64::from(rings)).sqrt();
            let (sin, cos) = (TAU * (f64::from(k % around) + 0.5) / f64::from(around)).sin_cos();
            let way = point - DVec3::new(r * cos, r * sin, 0.0);
            let cos = way.z / way.length();
            sum += (self.radiance)(cos) * cos * cos / way.length_squared();
        }
        let area_mm2 = PI * self.radius_mm.powi(2);
        self.luminance() * sum * area_mm2 / f64::from(rings * around)
    }

    /// Along x at a height, as far as `reach_mm`.
    fn points(reach_mm: f64, z: f64) -> impl Iterator<Item = DVec3> {
        (-20..=20).map(move |k| DVec3::new(reach_mm * f64::from(k) / 20.0, 0.0, z))
    }

    /// Root mean square of what is wrong over that of what is right.
    fn error(&self, tree: &LightTree, reach_mm: f64, z: f64) -> f64 {
        let (mut wrong, mut right) = (0.0, 0.0);
        for point in Self::points(reach_mm, z) {
            let expected = self.illuminance(point);
            wrong += (illuminance(tree, point) - expected).powi(2);
            right += expected * expected;
        }
        (wrong / right).sqrt()
    }
}

fn illuminance(tree: &LightTree, point: DVec3) -> f64 {
    let lobes = diffuse(1.0, 1.0);
    let query = HitQuery {
        point,
        normal: DVec3::NEG_Z,
        view: DVec3::NEG_Z,
        lobes: &lobes,
        photometry: Photometry::Absolute,
        reflects: true,
        transmits: false,
    };
    PI * tree.sum(&query, 1e-3, None).reflected
}

#[test]
fn measured_rays_light_near_and_far_planes_like_their_source() {
    for (name, source) in [("Lambert", LAMBERT), ("batwing", BATWING)] {
        let rays = source.rays();
        let exponent = measured_exponent(&rays.samples);
        let tree = LightTree::build(&rays.with_exponent(exponent).unwrap());
        for (reach_mm, z) in [(10.0, 5.0), (2000.0, 1000.0)] {
            let error = source.error(&tree, reach_mm, z);
            assert!(error < 0.03, "{name}, exponent {exponent}, at {z} mm: {error}");
        }
    }
}

/// At the foot of its edges a picture of a beam is as sharp as its rays are many: what is asked far
/// off is its inside.
#[test]
fn a_narrow_beam_of_measured_rays_keeps_its_edges() {
    let disc = Shape::Disc { center: DVec3::ZERO, normal: DVec3::Z, radius_mm: BEAM.radius_mm };
    let rays = BEAM.rays();
    let exponent = measured_exponent(&rays.samples);
    let (of_table, _) = measured_emitter(&rays, disc, 1).unwrap();
    for set in [rays.with_exponent(exponent).unwrap(), of_table] {
        let tree = LightTree::build(&set);
        // As far as 8.5° at 1000 mm.
        for (reach_mm, z) in [(5.0, 10.0), (150.0, 1000.0)] {
            let error = BEAM.error(&tree, reach_mm, z);
            // Its lobes are narrow, 0.5°, so that few rays are in each: 4 % of noise.
            assert!(error < 0.05, "exponent {}, at {z} mm: {error}", set.exponent);
        }
    }
}

#[test]
fn a_measured_lambert_led_has_its_intensity_on_axis() {
    let rays = LAMBERT.rays();
    let exponent = measured_exponent(&rays.samples);
    let tree = LightTree::build(&rays.with_exponent(exponent).unwrap());
    // I = E r², and Φ/π on the axis.
    let mean = |angles: [f64; 5]| {
        let point = |a: f64| DVec3::new(a.sin(), 0.0, a.cos()) * 1e4;
        let ratio = |a: f64| {
            let cos = a.cos();
            illuminance(&tree, point(a)) / cos * 100.0 / (FLUX_LM / PI * cos)
        };
        angles.map(ratio).iter().sum::<f64>() / 5.0
    };
    let found = mean([0.0, 0.02, 0.04, -0.02, -0.04]);
    assert_close(found, 1.0, 0.01, "on axis");
}
