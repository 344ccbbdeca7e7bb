//! The samples as the exact kernel wants them, and the exact sum over any of the blocks.

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use super::order::{Order, Placed};
use crate::light::sum::block::{Block, BlockQuery, LANES, Reach, SampleGroup, Scratch, sum_block};
use crate::light::{RaySample, RaySet, Sight, Visibility};

/// How a block is summed.
pub(super) struct Summing<'a> {
    /// Takes places in the set's own coordinates.
    pub visible: Option<Visibility<'a>>,
    /// Ask toward four samples, and toward all only where these differ.
    pub few_questions: bool,
}

/// All samples of a set in blocks; coordinates and fluxes are the set's own.
#[derive(Debug, Clone)]
pub(super) struct Blocks {
    pub blocks: Vec<Block>,
    pub groups: Vec<SampleGroup>,
    /// Index in `source` of each sample in block order.
    order: Vec<u32>,
    source: Arc<[RaySample]>,
}

impl Blocks {
    pub fn new(set: &RaySet, order: &Order) -> Blocks {
        let pairs: Vec<(usize, usize)> = order.starts.windows(2).map(|w| (w[0], w[1])).collect();
        let built: Vec<(Block, Vec<SampleGroup>)> = pairs
            .par_iter()
            .map(|&(start, end)| build_block(&set.samples, &order.placed[start..end], start))
            .collect();
        let mut groups = Vec::with_capacity(built.iter().map(|(_, groups)| groups.len()).sum());
        let mut blocks = Vec::with_capacity(built.len());
        for (mut block, block_groups) in built {
            let start = groups.len() as u32;
            groups.extend(block_groups);
            block.groups = start..groups.len() as u32;
            blocks.push(block);
        }
        let order = order.placed.iter().map(|sample| sample.index).collect();
        Blocks { blocks, groups, order, source: set.samples.clone() }
    }

    /// Index in the ray set of each sample, block by block.
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    pub fn groups_of(&self, block: &Block) -> &[SampleGroup] {
        &self.groups[block.groups.start as usize..block.groups.end as usize]
    }

    /// Where a block's samples lie, within the rounding of offsets: beside each other in memory, as
    /// [`Blocks::samples_of`] are not.
    fn places_of(&self, block: &Block) -> impl Iterator<Item = DVec3> {
        let center = block.center;
        let place = |group: &'_ SampleGroup, lane: usize| {
            DVec3::from([0, 1, 2].map(|axis| f64::from(group.offset[axis][lane])))
        };
        let groups = self.groups_of(block).iter();
        groups.flat_map(move |group| (0..LANES).map(move |lane| center + place(group, lane)))
    }

    pub fn samples_of(&self, block: &Block) -> impl Iterator<Item = &RaySample> {
        let order = &self.order[block.samples.start as usize..block.samples.end as usize];
        order.iter().map(|index| &self.source[*index as usize])
    }

    /// A box of all samples as `moved` has them, 10⁻⁴ wider, so that rounded means of them lie in it.
    pub fn bounds(&self, moved: impl Fn(DVec3) -> DVec3 + Sync) -> (DVec3, DVec3) {
        let join = |a: (DVec3, DVec3), b: (DVec3, DVec3)| (a.0.min(b.0), a.1.max(b.1));
        let nothing = || (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let of_block = |block: &Block| {
            let places = self.samples_of(block).map(|sample| moved(sample.origin()));
            places.map(|p| (p, p)).fold(nothing(), join)
        };
        let (low, high) = self.blocks.par_iter().map(of_block).reduce(nothing, join);
        let margin = 1e-4 * low.distance(high);
        (low - margin, high + margin)
    }

    pub fn memory_bytes(&self) -> usize {
        size_of_val(&*self.blocks) + size_of_val(&*self.groups) + size_of_val(&*self.order)
    }

    /// Σ Φ c (k_d g_d + Σ k_s g_s) over a block, in the set's relative fluxes; (sum, samples).
    pub fn sum(
        &self,
        index: usize,
        query: &BlockQuery,
        how: &Summing,
        scratch: &mut Scratch,
    ) -> (f64, u32) {
        let block = &self.blocks[index];
        let reach = block.reach(query);
        let mut visible = how.visible;
        if let Some(by) = visible.filter(|_| reach != Reach::Nothing) {
            match (by.ball)(block.center, block.radius) {
                Sight::Unknown if how.few_questions => match self.all_or_none_free(block, by.place)
                {
                    Some(true) => visible = None,
                    Some(false) => return (0.0, 0),
                    None => {}
                },
                Sight::Seen => visible = None,
                Sight::Hidden => return (0.0, 0),
                Sight::Unknown => {}
            }
        }
        let visible = visible.map(|by| by.place);
        let sum = match (reach, visible) {
            (Reach::Nothing, _) => return (0.0, 0),
            (Reach::NeedsF64, _) => self.sum_f64(block, query, visible),
            (_, None) => sum_block(self.groups_of(block), block.center, query, reach, scratch),
            (_, Some(free)) => {
                sum_block(self.groups_of(block), block.center, query, reach, scratch);
                let values = scratch.contributions(block.samples.len()).zip(self.places_of(block));
                let seen = values.filter(|(value, place)| *value > 0.0 && free(*place));
                seen.map(|(value, _)| f64::from(value)).sum()
            }
        };
        (sum, block.samples.end - block.samples.start)
    }

    /// What four samples of a block say of all, if they agree.
    fn all_or_none_free(&self, block: &Block, free: &dyn Fn(DVec3) -> bool) -> Option<bool> {
        let count = (block.samples.end - block.samples.start) as usize;
        let mut asked = self.samples_of(block).step_by(count.div_ceil(4).max(1));
        let first = free(asked.next()?.origin());
        asked.all(|sample| free(sample.origin()) == first).then_some(first)
    }

    fn sum_f64(
        &self,
        block: &Block,
        query: &BlockQuery,
        visible: Option<&dyn Fn(DVec3) -> bool>,
    ) -> f64 {
        self.samples_of(block)
            .filter_map(|sample| {
                let value = contribution_f64(sample, query);
                (value > 0.0 && visible.is_none_or(|free| free(sample.origin()))).then_some(value)
            })
            .sum()
    }
}

fn contribution_f64(sample: &RaySample, query: &BlockQuery) -> f64 {
    let to_light = sample.origin() - query.point;
    let l = to_light.normalize_or_zero();
    let q = sample.unit_direction();
    let power = |axis: DVec3, l: DVec3, (weight, exponent): (f64, f64)| {
        let versine = 0.5 * (axis - l).length_squared();
        if versine < 1.0 { weight * (exponent * (-versine).ln_1p()).exp() } else { 0.0 }
    };
    let emission = match query.exponent {
        1.0 => (-l.dot(q)).max(0.0),
        exponent => power(q, -l, (1.0, exponent)),
    };
    let emitted = f64::from(sample.flux) * emission;
    if emitted == 0.0 || l.dot(query.side.normal) <= 0.0 {
        return 0.0;
    }
    let diffuse = query.lobes.exact_diffuse;
    let mut scattered = if diffuse.0 > 0.0 { power(query.side.normal, l, diffuse) } else { 0.0 };
    for lobe in &query.lobes.exact_specular {
        scattered += query.side.specular(l, *lobe);
    }
    // 1e-9 mm: nearer than that, 1/r² would leave f64.
    let falloff = if query.inverse_square { to_light.length().max(1e-9).powi(-2) } else { 1.0 };
    emitted * scattered * falloff
}

fn build_block(source: &[RaySample], placed: &[Placed], start: usize) -> (Block, Vec<SampleGroup>) {
    let positions = || placed.iter().map(|p| DVec3::from(p.position.map(f64::from)));
    let center = box_center(positions());
    let radius = positions().map(|p| p.distance(center)).fold(0.0, f64::max);
    let mut groups = vec![SampleGroup::EMPTY; placed.len().div_ceil(LANES)];
    for (i, (position, sample)) in positions().zip(placed).enumerate() {
        let sample = &source[sample.index as usize];
        let direction = sample.unit_direction();
        let (offset, flux) = (position - center, direction * f64::from(sample.flux));
        let group = &mut groups[i / LANES];
        for axis in 0..3 {
            group.offset[axis][i % LANES] = offset[axis] as f32;
            group.flux[axis][i % LANES] = flux[axis] as f32;
        }
    }
    let samples = start as u32..(start + placed.len()) as u32;
    // The stored offsets are rounded: let the sphere hold those.
    (Block { center, radius: radius * (1.0 + 1e-6), groups: 0..0, samples }, groups)
}

pub(super) fn box_center(positions: impl Iterator<Item = DVec3>) -> DVec3 {
    let empty = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = positions.fold(empty, |(low, high), p| (low.min(p), high.max(p)));
    if low.x <= high.x { (low + high) * 0.5 } else { DVec3::ZERO }
}
