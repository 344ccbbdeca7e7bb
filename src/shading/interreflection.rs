//! Light that surfaces return diffusely becomes light samples (Keller, "Instant radiosity", 1997).
//!
//! Rays leave the light samples and are followed through mirrors and bodies as camera rays are. Where
//! one meets a diffuse lobe, what the lobe returns shines from there as a Lambert sample, and one
//! more ray goes on from one of these places, as often as light is left (Russian roulette). The
//! samples enter eq. 9 like any other light, spectrum by spectrum.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use rayon::prelude::*;

use super::walk::{Arrival, Branch, Facing, SurfacePoint};
use super::{TraceLimits, TraceState, Tracer};
use crate::color::Photometry;
use crate::error::{Error, Result};
use crate::geometry::{DVec3, Ray, TriangleId};
use crate::light::{HitQuery, LightTree, RaySample, RaySet};
use crate::material::Lobes;
use crate::scene::{Interreflection, InterreflectionReport, Light, MaterialId, Prepared, Scene};
use crate::source::noise::relative_error;
use crate::source::sequence::{EvenSequence, random};
use crate::spectrum::{Bands, Spectrum, WavelengthGrid};

/// Bands that the light is followed in; views take any grid.
const GRID: WavelengthGrid = WavelengthGrid::Step5;

/// Rays between two diffuse returns end as camera rays do, at these limits.
const LIMITS: TraceLimits =
    TraceLimits { max_depth: 32, min_throughput: 1e-3, light_error: 0.0, dispersion: 1 };

/// Paths that one job follows.
const PATHS_PER_JOB: usize = 256;

/// How far samples are lifted off their surface, of the largest coordinate: f32 would put half of
/// them behind it.
const LIFT: f64 = 1e-6;

/// Spectra nearer than this to each other, of their peak, are one light.
const SAME_SPECTRUM: f64 = 1e-3;

/// Prepares a scene, with light samples for what its surfaces return if it asks for that, and with
/// what `earlier` scenes have of its meshes and rays.
///
/// Errors: as [`Scene::prepare`]; interreflection in relative photometry.
pub fn prepare(scene: Scene, earlier: &[Arc<Prepared>]) -> Result<Prepared> {
    let Some(asked) = scene.interreflection else { return scene.prepare_from(earlier) };
    if scene.photometry == Photometry::Relative {
        let problem = "interreflection needs photometry = \"absolute\": relative values have no \
                       unit to be passed on";
        return Err(Error::inconsistent("scene", problem));
    }
    let mut prepared = scene.prepare_from(earlier)?;
    let groups = follow_all(&prepared, asked)?;
    let report = InterreflectionReport {
        first_light: prepared.scene.lights.len(),
        samples: groups.values().map(|group| group.samples.len()).sum(),
        relative_error: estimated_error(&prepared, &groups),
    };
    let lights = into_lights(&prepared, groups, asked.by_light)?;
    prepared.add_bounced(lights, report);
    Ok(prepared)
}

/// Samples whose light has about the same spectrum: of one light, from one material, after as many
/// returns.
type Key = (usize, usize, u32);

#[derive(Debug)]
struct Group {
    /// Position, normal, lm.
    samples: Vec<(DVec3, DVec3, f64)>,
    /// Spectral flux of all samples, W/nm.
    power: Bands,
}

type Groups = BTreeMap<Key, Group>;

/// Where light is returned.
struct Return {
    position: DVec3,
    normal: DVec3,
    triangle: TriangleId,
    material: MaterialId,
    /// What is left of the light's own spectrum, 0 to 1.
    share: Bands,
    lm: f64,
    departure: crate::geometry::Departure,
}

fn follow_all(prepared: &Prepared, asked: Interreflection) -> Result<Groups> {
    let tables = prepared.tables(GRID)?;
    let follower = Follower { tracer: Tracer { prepared, tables, limits: LIMITS }, asked };
    let total_lm: f64 = prepared.scene.lights.iter().map(|light| light.rays.flux_lm).sum();
    let paths = (asked.samples as f64 / follower.samples_per_path()).ceil().max(1.0);
    let mut all = Groups::new();
    for (light, given) in prepared.scene.lights.iter().enumerate() {
        let count = (paths * given.rays.flux_lm / total_lm).ceil() as usize;
        let starts = PathStarts::new(given, count);
        let jobs: Vec<Groups> = (0..count.div_ceil(PATHS_PER_JOB))
            .into_par_iter()
            .map(|job| {
                let mut groups = Groups::new();
                let first = job * PATHS_PER_JOB;
                for path in first..count.min(first + PATHS_PER_JOB) {
                    follower.follow(&starts, (light, path), &mut groups);
                }
                groups
            })
            .collect();
        // In the order of the jobs, whichever thread did them.
        jobs.into_iter().for_each(|groups| merge(&mut all, groups));
    }
    Ok(all)
}

fn merge(all: &mut Groups, groups: Groups) {
    for (key, group) in groups {
        match all.get_mut(&key) {
            None => drop(all.insert(key, group)),
            Some(known) => {
                known.samples.extend(group.samples);
                known.power.add(&group.power);
            }
        }
    }
}

/// Light samples by flux, each path with an equal share of it.
struct PathStarts<'a> {
    light: &'a Light,
    /// Σ flux up to and with each sample.
    until: Vec<f64>,
    paths: usize,
}

impl PathStarts<'_> {
    fn new(light: &Light, paths: usize) -> PathStarts<'_> {
        let running = light.rays.samples.iter().scan(0.0, |sum, sample| {
            *sum += f64::from(sample.flux);
            Some(*sum)
        });
        PathStarts { light, until: running.collect(), paths }
    }

    /// Evenly over the flux, into the samples' lobes; `place`, `height` and `turn` from 0 to 1.
    fn ray(&self, path: usize, [place, height, turn]: [f64; 3]) -> Option<Ray> {
        let total = *self.until.last()?;
        let at = total * (path as f64 + place) / self.paths as f64;
        let index = self.until.partition_point(|until| *until <= at).min(self.until.len() - 1);
        let RaySet { samples, exponent, .. } = &self.light.rays;
        let cos = (1.0 - height).powf(1.0 / (exponent + 1.0));
        let axis = self.light.rays.world_direction(&samples[index]);
        let direction = tilted(axis, cos, turn);
        Some(Ray { origin: self.light.rays.world_origin(&samples[index]), direction })
    }
}

/// At an angle from a unit axis, `turn` of the way around it.
fn tilted(axis: DVec3, cos: f64, turn: f64) -> DVec3 {
    let (a, b) = axis.any_orthonormal_pair();
    let (sin_turn, cos_turn) = (TAU * turn).sin_cos();
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    (axis * cos + (a * cos_turn + b * sin_turn) * sin).normalize()
}

struct Follower<'a> {
    tracer: Tracer<'a>,
    asked: Interreflection,
}

impl Follower<'_> {
    /// How many samples a path leaves on average, from a few of them.
    fn samples_per_path(&self) -> f64 {
        const PILOTS: usize = 64;
        let lights = &self.tracer.prepared.scene.lights;
        let of_light = |(light, given): (usize, &Light)| {
            let starts = PathStarts::new(given, PILOTS);
            let mut groups = Groups::new();
            (0..PILOTS).for_each(|path| self.follow(&starts, (light, path), &mut groups));
            let samples: usize = groups.values().map(|group| group.samples.len()).sum();
            given.rays.flux_lm * samples as f64
        };
        let total_lm: f64 = lights.iter().map(|light| light.rays.flux_lm).sum();
        let mean = lights.iter().enumerate().map(of_light).sum::<f64>() / total_lm;
        (mean / PILOTS as f64).max(0.01)
    }

    fn follow(&self, starts: &PathStarts, (light, path): (usize, usize), groups: &mut Groups) {
        let seed = self.asked.seed;
        let [height, turn, luck, _] = EvenSequence::new(seed).point(path as u32);
        let place = random(seed, path as u64, 0);
        let Some(ray) = starts.ray(path, [place, height, turn]) else { return };
        // One number, even over the paths, says how far each goes: then next to no noise is left in
        // how many go on. The sequence has 32 bits, which long paths would use up.
        let mut luck = luck + 2f64.powi(-32) * (random(seed, path as u64, 1) - 0.5);
        let bands = self.tracer.tables.bands;
        let mut branch =
            self.off_its_emitter(Branch::from_light(ray, None, Bands::one(bands)), light);
        let mut lm = starts.light.rays.flux_lm / starts.paths as f64;
        // lm that the ray carries.
        let mut arriving = lm;
        for bounce in 0..self.asked.bounces {
            let returns = self.returns(branch, light, lm);
            let total: f64 = returns.iter().map(|r| r.lm).sum();
            if total <= 0.0 {
                return;
            }
            for r in &returns {
                self.keep(r, (light, r.material.0, bounce), lm, groups);
            }
            // One of them goes on for all, as often as light is left of what arrived.
            let chance = |k: u64| random(seed, path as u64, 8 + 3 * u64::from(bounce) + k);
            let survival = (total / arriving).min(1.0);
            if luck >= survival {
                return;
            }
            luck /= survival;
            let mut left = chance(0) * total;
            let next = returns.iter().find(|r| {
                left -= r.lm;
                left < 0.0
            });
            let Some(next) = next.or(returns.last()) else { return };
            let direction = tilted(next.normal, (1.0 - chance(1)).sqrt(), chance(2));
            let origin = next.departure.toward(direction);
            lm *= total / (next.lm * survival);
            arriving = total / survival;
            let ray = Ray { origin, direction };
            branch = Branch::from_light(ray, Some(next.triangle), next.share.clone());
        }
    }

    /// A ray starts on its own light's surface, which it must not meet again.
    fn off_its_emitter(&self, mut branch: Branch, light: usize) -> Branch {
        let prepared = self.tracer.prepared;
        // A coil's wire is met a few times at most.
        for _ in 0..64 {
            let Some(hit) = prepared.bvh.closest_hit(&branch.ray, branch.leaving) else { break };
            let (object, _) = prepared.bvh.locate(hit.triangle);
            let emitter = object.checked_sub(prepared.scene.objects.len());
            if emitter.is_none_or(|emitter| prepared.emitters[emitter].light != light) {
                break;
            }
            branch.ray.origin = prepared.bvh.departure(&hit).toward(branch.ray.direction);
            branch.leaving = Some(hit.triangle);
        }
        branch
    }

    /// Every place where a ray's light is returned diffusely, by the ray or what it becomes.
    fn returns(&self, first: Branch, light: usize, lm: f64) -> Vec<Return> {
        let mut returns = Vec::new();
        self.tracer.walk_from(first, &mut TraceState::default(), |branch, arrival, _| {
            if let Arrival::Hit(surface) = arrival {
                self.add_returns(surface, branch, &mut returns);
            }
        });
        let power = &self.tracer.tables.lights[light];
        for r in &mut returns {
            let mut spectrum = r.share.clone();
            spectrum.scale_by(lm, power);
            r.lm = spectrum.dot(&self.tracer.tables.luminance_weights);
        }
        returns.retain(|r| r.lm > 0.0);
        returns
    }

    /// To the side that the light comes from, and through a sheet from its back to its front.
    fn add_returns(&self, surface: &SurfacePoint, branch: &Branch, returns: &mut Vec<Return>) {
        let material = &self.tracer.prepared.scene.materials[surface.material.0];
        let tables = &self.tracer.tables.materials[surface.material.0];
        let k_d = material.lobes.k_d;
        let mut add = |normal: DVec3, factor: &Bands| {
            let mut share = branch.throughput.clone();
            share.scale_by(k_d, factor);
            let material = surface.material;
            let super::walk::Leaving { triangle, departure } = surface.near;
            let position = departure.point;
            returns.push(Return {
                position,
                normal,
                triangle,
                material,
                share,
                lm: 0.0,
                departure,
            });
        };
        if k_d > 0.0 && tables.reflects {
            add(surface.normal, &tables.reflectance);
        }
        if k_d > 0.0 && tables.transmits && surface.facing == Facing::Back {
            add(-surface.normal, &tables.transmittance);
        }
    }

    fn keep(&self, r: &Return, key: Key, lm: f64, groups: &mut Groups) {
        let bands = self.tracer.tables.bands;
        let empty = || Group { samples: Vec::new(), power: Bands::zero(bands) };
        let group = groups.entry(key).or_insert_with(empty);
        let lift = LIFT * r.position.abs().max_element();
        group.samples.push((r.position + r.normal * lift, r.normal, r.lm));
        let mut power = r.share.clone();
        power.scale_by(lm, &self.tracer.tables.lights[key.0]);
        group.power.add(&power);
    }
}

/// One light for each spectrum, or for each spectrum of each light, with the light that it came of.
fn into_lights(
    prepared: &Prepared,
    groups: Groups,
    by_light: bool,
) -> Result<Vec<(Light, Option<usize>)>> {
    let weights = &prepared.tables(GRID)?.luminance_weights;
    let mut merged: Vec<(Group, Option<usize>)> = Vec::new();
    for ((light, ..), group) in groups {
        let same = |(known, came_of): &&mut (Group, Option<usize>)| {
            (!by_light || *came_of == Some(light)) && is_same(&known.power, &group.power, weights)
        };
        match merged.iter_mut().find(same) {
            None => merged.push((group, Some(light))),
            Some((known, came_of)) => {
                known.samples.extend(group.samples);
                known.power.add(&group.power);
                *came_of = came_of.filter(|of| *of == light);
            }
        }
    }
    merged.into_iter().map(|(group, came_of)| Ok((light_of(group)?, came_of))).collect()
}

fn is_same(a: &Bands, b: &Bands, weights: &Bands) -> bool {
    let scale = a.dot(weights) / b.dot(weights);
    let peak = a.as_slice().iter().copied().fold(0.0, f64::max);
    let pairs = a.as_slice().iter().zip(b.as_slice());
    pairs.into_iter().all(|(a, b)| (a - scale * b).abs() <= SAME_SPECTRUM * peak)
}

fn light_of(group: Group) -> Result<Light> {
    let pairs = GRID.wavelengths_nm().zip(group.power.as_slice().iter().copied());
    let spectrum = Spectrum::from_pairs("interreflection", pairs)?;
    Ok(Light::new(rayset_of(&group.samples), spectrum))
}

/// Fluxes relative to the largest, so that f32 holds them whatever their unit.
fn rayset_of(samples: &[(DVec3, DVec3, f64)]) -> RaySet {
    let largest = samples.iter().map(|(_, _, lm)| *lm).fold(0.0, f64::max);
    let sample = |(position, normal, lm): &(DVec3, DVec3, f64)| RaySample {
        position: position.as_vec3().to_array(),
        direction: normal.as_vec3().to_array(),
        flux: (lm / largest.max(f64::MIN_POSITIVE)) as f32,
    };
    let flux_lm = samples.iter().map(|(_, _, lm)| lm).sum();
    RaySet::new(samples.iter().map(sample).collect(), flux_lm)
}

/// The relative standard error of what the samples send to each other's places, from halves.
fn estimated_error(prepared: &Prepared, groups: &Groups) -> Option<f64> {
    const PROBES: usize = 100;
    let all: Vec<&(DVec3, DVec3, f64)> = groups.values().flat_map(|group| &group.samples).collect();
    let half = |parity: usize| {
        let of_half = all.iter().enumerate().filter(|(index, _)| index % 2 == parity);
        let samples: Vec<_> = of_half.map(|(_, sample)| **sample).collect();
        LightTree::build(&rayset_of(&samples))
    };
    if all.len() < 2 {
        return None;
    }
    let halves = [half(0), half(1)];
    let lobes = Lobes { k_d: 1.0, ..Lobes::default() };
    let step = all.len().div_ceil(PROBES);
    let pairs = all.iter().step_by(step).map(|(point, normal, _)| {
        let query = HitQuery {
            point: *point,
            normal: *normal,
            view: *normal,
            lobes: &lobes,
            photometry: prepared.scene.photometry,
            reflects: true,
            transmits: false,
        };
        // Twice, since each has half of the flux.
        halves.each_ref().map(|tree| 2.0 * PI * tree.sum(&query, 0.01, None).reflected)
    });
    relative_error(pairs.collect::<Vec<_>>())
}
