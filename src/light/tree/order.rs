//! Samples sorted into compact blocks, by halving along the longest axis.

use crate::light::RaySample;

/// Samples a block holds at most, before rounding to whole groups.
const BLOCK_SAMPLES: usize = 256;

/// A sample's place, and its index in the ray set.
#[derive(Debug, Clone, Copy)]
pub(super) struct Placed {
    pub position: [f32; 3],
    pub index: u32,
}

/// Samples in the order of their blocks, and where each block begins.
#[derive(Debug)]
pub(super) struct Order {
    pub placed: Vec<Placed>,
    /// 2^depth + 1 boundaries.
    pub starts: Vec<usize>,
    /// Number of halvings.
    pub depth: u32,
}

/// Only samples that emit: finite, with flux and direction.
pub(super) fn order(samples: &[RaySample]) -> Order {
    let mut placed: Vec<Placed> = samples
        .iter()
        .zip(0u32..)
        .filter(|(sample, _)| emits(sample))
        .map(|(sample, index)| Placed { position: sample.position, index })
        .collect();
    let depth = placed.len().div_ceil(BLOCK_SAMPLES).next_power_of_two().ilog2();
    split(&mut placed, depth);
    let mut starts = vec![0];
    push_starts(0..placed.len(), depth, &mut starts);
    Order { placed, starts, depth }
}

fn emits(sample: &RaySample) -> bool {
    let finite = sample.position.iter().chain(&sample.direction).all(|v| v.is_finite());
    let turned = sample.direction.iter().any(|v| *v != 0.0);
    finite && turned && sample.flux > 0.0 && sample.flux.is_finite()
}

/// The left half, rounded so that blocks are whole groups of 16.
fn left_half(count: usize) -> usize {
    count.div_ceil(2).next_multiple_of(16).min(count)
}

fn split(placed: &mut [Placed], depth: u32) {
    if depth == 0 {
        placed.sort_unstable_by_key(|sample| sample.index);
        return;
    }
    let middle = left_half(placed.len());
    if middle < placed.len() {
        let axis = longest_axis(placed);
        // Ties by index, so that the halves do not depend on the order that they came in.
        placed.select_nth_unstable_by(middle, |a, b| {
            a.position[axis].total_cmp(&b.position[axis]).then(a.index.cmp(&b.index))
        });
    }
    let (left, right) = placed.split_at_mut(middle);
    rayon::join(|| split(left, depth - 1), || split(right, depth - 1));
}

fn longest_axis(placed: &[Placed]) -> usize {
    let mut low = [f32::INFINITY; 3];
    let mut high = [f32::NEG_INFINITY; 3];
    for sample in placed {
        for axis in 0..3 {
            low[axis] = low[axis].min(sample.position[axis]);
            high[axis] = high[axis].max(sample.position[axis]);
        }
    }
    let extent = |axis: &usize| high[*axis] - low[*axis];
    (0..3).max_by(|a, b| extent(a).total_cmp(&extent(b))).unwrap_or(0)
}

fn push_starts(range: std::ops::Range<usize>, depth: u32, starts: &mut Vec<usize>) {
    if depth == 0 {
        starts.push(range.end);
        return;
    }
    let middle = range.start + left_half(range.len());
    push_starts(range.start..middle, depth - 1, starts);
    push_starts(middle..range.end, depth - 1, starts);
}
