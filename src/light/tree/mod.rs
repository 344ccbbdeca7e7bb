//! The sum over a RAYSET at a hit, exactly or within a stated error (eq. 9).

mod blocks;
mod cones;
mod descent;
mod eight;
mod half;
mod interpolation;
mod levels;
mod lobe;
mod moments;
mod node;
mod octahedron;
mod order;
mod stored;
mod table;

use std::f64::consts::PI;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

use glam::{DAffine3, DVec3};

use crate::color::Photometry;
use crate::light::sum::block::{BlockQuery, Scratch};
use crate::light::sum::power::LobeSet;
use crate::light::sum::{HitQuery, LightSum, Side, Sight, Visibility};
use crate::light::{RaySample, RaySet};

use blocks::{Blocks, Summing};
use cones::Cones;
use descent::Descent;
use levels::Levels;

/// A RAYSET prepared for sums at many hits.
///
/// Sums run in the set's own coordinates: the hit is moved there, not the samples.
#[derive(Debug, Clone)]
pub struct LightTree {
    ordered: Arc<Ordered>,
    exponent: f64,
    world_from_local: DAffine3,
    local_from_world: DAffine3,
    /// Scale of the placement.
    scale: f64,
    /// Φ_i of a sample whose flux is 1.
    lm_per_flux: f64,
    bounds: (DVec3, DVec3),
}

/// A set's samples in their order, and what stands for many of them. It depends on nothing but the
/// samples and their exponent: all scenes with the same samples share it.
#[derive(Debug)]
struct Ordered {
    blocks: Blocks,
    /// None for small sets.
    levels: Option<Levels>,
    /// Instead of levels, for samples whose lobes are not Lambert's.
    cones: Option<Cones>,
}

fn is_lambert(set: &RaySet) -> bool {
    set.exponent == 1.0
}

/// What was built of samples that some scene still holds.
static SHARED: Mutex<Vec<Shared>> = Mutex::new(Vec::new());

struct Shared {
    samples: Weak<[RaySample]>,
    exponent: f64,
    ordered: Weak<Ordered>,
}

fn shared() -> MutexGuard<'static, Vec<Shared>> {
    SHARED.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Shared {
    fn is_of(&self, set: &RaySet) -> bool {
        std::ptr::eq(self.samples.as_ptr(), Arc::as_ptr(&set.samples))
            && self.exponent == set.exponent
    }
}

impl Ordered {
    /// What is already built of the same samples.
    fn shared(set: &RaySet) -> Option<Arc<Ordered>> {
        let mut shared = shared();
        shared.retain(|it| it.ordered.strong_count() > 0);
        shared.iter().find(|it| it.is_of(set)).and_then(|it| it.ordered.upgrade())
    }

    /// For all that have the same samples.
    fn share(self, set: &RaySet) -> Arc<Ordered> {
        let ordered = Arc::new(self);
        shared().push(Shared {
            samples: Arc::downgrade(&set.samples),
            exponent: set.exponent,
            ordered: Arc::downgrade(&ordered),
        });
        ordered
    }

    fn build(set: &RaySet) -> Ordered {
        let order = order::order(&set.samples, set.exponent);
        let blocks = Blocks::new(set, &order);
        match is_lambert(set) {
            true => Ordered { levels: Levels::build(&blocks, order.depth), cones: None, blocks },
            false => Ordered::with_cones(blocks),
        }
    }

    fn with_cones(blocks: Blocks) -> Ordered {
        Ordered { levels: None, cones: Some(Cones::build(&blocks)), blocks }
    }
}

/// The f32 of nodes holds no less; below it every sum is exact.
const SMALLEST_LIGHT_ERROR: f64 = 1e-4;

/// What one side of a hit adds up to, in the set's relative fluxes.
#[derive(Debug, Clone, Copy, Default)]
struct SideSum {
    sum: f64,
    error: f64,
    nodes: u32,
    samples: u32,
}

impl LightTree {
    /// The same bits for any number of threads.
    ///
    /// Samples that are not finite, or have neither flux nor direction, are left out.
    pub fn build(set: &RaySet) -> LightTree {
        LightTree::shared(set).unwrap_or_else(|| LightTree::of(set, Ordered::build(set).share(set)))
    }

    /// The tree of the same samples, if somebody still holds one.
    pub fn shared(set: &RaySet) -> Option<LightTree> {
        Ordered::shared(set).map(|ordered| LightTree::of(set, ordered))
    }

    fn of(set: &RaySet, ordered: Arc<Ordered>) -> LightTree {
        LightTree {
            bounds: ordered.blocks.bounds(|p| set.world_from_local.transform_point3(p)),
            ordered,
            exponent: set.exponent,
            world_from_local: set.world_from_local,
            local_from_world: set.world_from_local.inverse(),
            scale: set.scale(),
            lm_per_flux: set.lm_per_flux(),
        }
    }

    /// Eq. 9 at a hit; deterministic, without noise.
    ///
    /// `light_error`: largest error relative to each of the two sums; 0, or less than 1e-4, for the
    /// exact sum. The answer's estimates are at most `light_error` times the sums, or times 1e-14
    /// of what the set could send straight at the hit where the sums are darker than that.
    /// `visible` takes places in mm of the world. Nodes of which it knows nothing are asked at one
    /// place each, and at each sample where hidden and seen ones touch; a blocker too small to hide
    /// the mean place of one of about 64 such nodes may be missed unless `light_error` is 0.
    /// Below 0.01 the errors of nodes that a series describes well add up as independent ones, three
    /// times the root of the sum of their squares; by their plain sum they stay within 0.01 still.
    /// A sample at the hit itself has no direction and adds nothing.
    pub fn sum(&self, query: &HitQuery, light_error: f64, visible: Option<Visibility>) -> LightSum {
        let (near, far) = (Side::reflected(query), Side::transmitted(query));
        let lobes = LobeSet::new(query.lobes, query.photometry, &near);
        let mut sum = LightSum::default();
        if query.reflects {
            let side = self.sum_side(query, &lobes, near, light_error, visible);
            (sum.reflected, sum.reflected_error) = (side.sum, side.error);
            (sum.nodes, sum.samples) = (side.nodes, side.samples);
        }
        if query.transmits {
            let far_lobes = || LobeSet::new(query.lobes, query.photometry, &far);
            let lobes = if near.is_half { far_lobes() } else { lobes };
            let side = self.sum_side(query, &lobes, far, light_error, visible);
            (sum.transmitted, sum.transmitted_error) = (side.sum, side.error);
            sum.nodes += side.nodes;
            sum.samples += side.samples;
        }
        sum
    }

    /// The box that holds the samples that emit, and a little more, mm of the world.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        self.bounds
    }

    /// The middle of [`LightTree::bounds`].
    pub fn middle(&self) -> DVec3 {
        0.5 * (self.bounds.0 + self.bounds.1)
    }

    /// How many samples emit.
    pub fn len(&self) -> usize {
        self.ordered.blocks.blocks.last().map_or(0, |block| block.samples.end as usize)
    }

    /// Whether no sample emits.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Memory of the tree and its copy of the samples, without the ray set itself, bytes.
    pub fn memory_bytes(&self) -> usize {
        let Ordered { blocks, levels, cones } = &*self.ordered;
        blocks.memory_bytes()
            + levels.as_ref().map_or(0, Levels::memory_bytes)
            + cones.as_ref().map_or(0, Cones::memory_bytes)
    }

    fn sum_side(
        &self,
        query: &HitQuery,
        lobes: &LobeSet,
        side: Side,
        light_error: f64,
        visible: Option<Visibility>,
    ) -> SideSum {
        let to_local = |v: DVec3| self.local_from_world.transform_vector3(v).normalize_or_zero();
        let query_here = BlockQuery {
            point: self.local_from_world.transform_point3(query.point),
            side: Side { normal: to_local(side.normal), axis: to_local(side.axis), ..side },
            lobes,
            inverse_square: query.photometry == Photometry::Absolute,
            exponent: self.exponent,
        };
        let to_world = |p: DVec3| self.world_from_local.transform_point3(p);
        let place = |p: DVec3| visible.is_none_or(|by| (by.place)(to_world(p)));
        let ball = |center: DVec3, radius: f64| {
            let in_world = |by: Visibility| (by.ball)(to_world(center), radius * self.scale);
            visible.map_or(Sight::Seen, in_world)
        };
        let visible_here = visible.map(|_| Visibility { place: &place, ball: &ball });
        let is_exact = light_error < SMALLEST_LIGHT_ERROR;
        let Ordered { blocks, levels, cones } = &*self.ordered;
        let mut side_sum = match (levels, cones) {
            (Some(levels), _) if !is_exact => {
                Descent { levels, blocks, query: &query_here, visible: visible_here, light_error }
                    .run()
            }
            (_, Some(cones)) if !is_exact => {
                cones.sum(blocks, &query_here, (visible_here, light_error))
            }
            _ => self.sum_exact(&query_here, visible_here),
        };
        let lobe = 0.5 * (self.exponent + 1.0); // 1 for Lambert's
        let unit = self.lm_per_flux * lobe * self.distance_unit(query.photometry);
        side_sum.sum *= unit;
        side_sum.error *= unit;
        side_sum
    }

    /// 1/(π r²) in m⁻² for r of 1 in the set's own coordinates.
    fn distance_unit(&self, photometry: Photometry) -> f64 {
        match photometry {
            Photometry::Relative => 1.0,
            Photometry::Absolute => 1.0 / (PI * (self.scale * 1e-3).powi(2)),
        }
    }

    fn sum_exact(&self, query: &BlockQuery, visible: Option<Visibility>) -> SideSum {
        let mut total = SideSum::default();
        let mut scratch = Scratch::new();
        let blocks = &self.ordered.blocks;
        for index in 0..blocks.blocks.len() {
            let how = Summing { visible, few_questions: false };
            let (sum, samples) = blocks.sum(index, query, &how, &mut scratch);
            total.sum += sum;
            total.samples += samples;
        }
        total
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::{LobeShape, Lobes, SpecularLobe};
    use crate::simd::test::under_each;

    /// On a helix, turned outward.
    fn helix(count: usize) -> RaySet {
        let sample = |i: usize| {
            let t = i as f64 / count as f64;
            let (sin, cos) = (t * 300.0).sin_cos();
            let direction = DVec3::new(0.3 * (t * 7.0).sin(), cos, sin).normalize();
            let position = DVec3::new(5.0 * t, 0.4 * cos, 0.4 * sin);
            RaySample {
                position: position.as_vec3().into(),
                direction: direction.as_vec3().into(),
                flux: 1.0 + (t * 11.0).cos() as f32,
            }
        };
        let samples = (0..count).map(sample).collect();
        RaySet::new(samples, 1.0)
    }

    #[test]
    fn vector_width_changes_no_bit() {
        let set = helix(9000);
        let lobes = Lobes {
            k_d: 0.08,
            n_d: 10.5,
            specular: vec![
                SpecularLobe { k_s: 0.5, n_s: 20.0 },
                SpecularLobe { k_s: 0.4, n_s: 1500.0 },
            ],
            ..Lobes::default()
        };
        let half = Lobes { shape: LobeShape::Half, ..lobes.clone() };
        let sums = under_each(|| {
            let tree = LightTree::build(&set);
            let at = |i: u32| {
                let angle = f64::from(i) * 0.4;
                let normal = DVec3::new(0.2 * angle.sin(), 0.1 * angle.cos(), 1.0).normalize();
                let query = HitQuery {
                    point: DVec3::new(2.5 + angle.sin(), angle.cos(), -2.0 - f64::from(i)),
                    normal,
                    view: DVec3::Z,
                    lobes: if i.is_multiple_of(2) { &lobes } else { &half },
                    photometry: Photometry::Absolute,
                    reflects: true,
                    transmits: true,
                };
                [0.0, 0.01, 0.1].map(|light_error| tree.sum(&query, light_error, None))
            };
            (0..40).map(at).collect::<Vec<_>>()
        });
        assert!(sums[0].iter().all(|sums| sums[1].reflected > 0.0));
        assert!(sums.iter().all(|of_isa| *of_isa == sums[0]));
    }
}
