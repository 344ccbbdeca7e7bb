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
///
/// Lambert samples are sorted by place alone, narrow ones by place and direction.
pub(super) fn order(samples: &[RaySample], exponent: f64) -> Order {
    let mut placed: Vec<Placed> = samples
        .iter()
        .zip(0u32..)
        .filter(|(sample, _)| emits(sample))
        .map(|(sample, index)| Placed { position: sample.position, index })
        .collect();
    let depth = depth(placed.len());
    let axes = Axes::new(samples, exponent, &placed);
    split(&mut placed, &axes, depth);
    Order::of_blocks(placed, depth)
}

impl Order {
    fn of_blocks(placed: Vec<Placed>, depth: u32) -> Order {
        let mut starts = vec![0];
        push_starts(0..placed.len(), depth, &mut starts);
        Order { placed, starts, depth }
    }

    /// An order that is known: indices in the order of the blocks. `None` for an index beyond `samples`.
    pub fn known(samples: &[RaySample], indices: &[u32]) -> Option<Order> {
        let place = |&index: &u32| {
            let position = samples.get(index as usize)?.position;
            Some(Placed { position, index })
        };
        let placed: Vec<Placed> = indices.iter().map(place).collect::<Option<_>>()?;
        let depth = depth(placed.len());
        Some(Order::of_blocks(placed, depth))
    }
}

/// Halvings until a block is small enough.
fn depth(count: usize) -> u32 {
    count.div_ceil(BLOCK_SAMPLES).next_power_of_two().ilog2()
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

fn split(placed: &mut [Placed], axes: &Axes, depth: u32) {
    if depth == 0 {
        placed.sort_unstable_by_key(|sample| sample.index);
        return;
    }
    let middle = left_half(placed.len());
    if middle < placed.len() {
        let axis = axes.longest(placed);
        // Ties by index, so that the halves do not depend on the order that they came in.
        placed.select_nth_unstable_by(middle, |a, b| {
            let at = |sample: &Placed| axes.coordinate(sample, axis);
            at(a).total_cmp(&at(b)).then(a.index.cmp(&b.index))
        });
    }
    let (left, right) = placed.split_at_mut(middle);
    rayon::join(|| split(left, axes, depth - 1), || split(right, axes, depth - 1));
}

/// What samples are sorted by.
struct Axes<'a> {
    samples: &'a [RaySample],
    /// Three for places, three more for directions.
    count: usize,
    /// mm that a direction's component of 1 counts for.
    direction_scale: f32,
}

impl Axes<'_> {
    fn new<'a>(samples: &'a [RaySample], exponent: f64, placed: &[Placed]) -> Axes<'a> {
        /// The whole set's size counts as much as this many standard deviations of a sample's lobe.
        const WIDTHS: f64 = 8.0;
        let mut axes = Axes { samples, count: 3, direction_scale: 0.0 };
        if exponent != 1.0 {
            let size = (0..3).map(|axis| axes.extent(placed, axis)).fold(0.0, f32::max);
            axes.count = 6;
            axes.direction_scale = size.max(f32::MIN_POSITIVE) * (exponent.sqrt() / WIDTHS) as f32;
        }
        axes
    }

    fn coordinate(&self, sample: &Placed, axis: usize) -> f32 {
        match axis {
            0..3 => sample.position[axis],
            _ => self.samples[sample.index as usize].direction[axis - 3] * self.direction_scale,
        }
    }

    fn extent(&self, placed: &[Placed], axis: usize) -> f32 {
        let at = placed.iter().map(|sample| self.coordinate(sample, axis));
        let nothing = (f32::INFINITY, f32::NEG_INFINITY);
        let (low, high) = at.fold(nothing, |(low, high), v| (low.min(v), high.max(v)));
        high - low
    }

    fn longest(&self, placed: &[Placed]) -> usize {
        let extents: Vec<f32> = (0..self.count).map(|axis| self.extent(placed, axis)).collect();
        (0..self.count).max_by(|&a, &b| extents[a].total_cmp(&extents[b])).unwrap_or(0)
    }
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
