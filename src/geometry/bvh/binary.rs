//! A binary tree over triangle boxes, by the surface area heuristic with bins.

use super::bounds::Box3;

/// Bins along each axis.
const BINS: usize = 16;
/// Below this depth the heuristic decides, from there on halves: it bounds the depth of any tree.
pub(super) const SAH_DEPTH: u32 = 40;
/// Ranges this long are worth a task of their own.
const PARALLEL_TRIANGLES: usize = 4096;

/// A triangle as the builder sees it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Primitive {
    pub bounds: Box3,
    pub triangle: u32,
}

impl Primitive {
    /// Twice the center, which spares a product.
    fn center(&self, axis: usize) -> f32 {
        self.bounds.low[axis] + self.bounds.high[axis]
    }
}

/// One node of the tree. The subtree of n triangles fills 2n − 1 slots: first the node itself, then
/// the left subtree, then the right one.
#[derive(Debug, Clone, Copy)]
pub(super) struct BinaryNode {
    pub bounds: Box3,
    /// First of its triangles in the order that the builder leaves.
    pub first: u32,
    pub count: u32,
    /// Triangles in the left child; 0 in a leaf.
    pub left_count: u32,
}

impl BinaryNode {
    const EMPTY: BinaryNode = BinaryNode { bounds: Box3::EMPTY, first: 0, count: 0, left_count: 0 };

    /// Slots of the children, counted from the node's own; `None` in a leaf.
    pub fn children(&self) -> Option<[usize; 2]> {
        (self.left_count > 0).then(|| [1, 2 * self.left_count as usize])
    }
}

/// Builds down to single triangles and puts `primitives` into leaf order.
pub(super) fn build(primitives: &mut [Primitive]) -> Vec<BinaryNode> {
    if primitives.is_empty() {
        return Vec::new();
    }
    let mut nodes = vec![BinaryNode::EMPTY; 2 * primitives.len() - 1];
    build_range(primitives, &mut nodes, TreeRange { first: 0, depth: 0 });
    nodes
}

#[derive(Clone, Copy)]
struct TreeRange {
    first: u32,
    depth: u32,
}

fn build_range(primitives: &mut [Primitive], nodes: &mut [BinaryNode], place: TreeRange) {
    let count = primitives.len();
    let (bounds, centers) = bounds_of(primitives);
    let left_count = if count == 1 {
        0
    } else if place.depth >= SAH_DEPTH {
        count / 2
    } else {
        split(primitives, &centers)
    };
    let (node, below) = nodes.split_first_mut().expect("a range has a node");
    *node = BinaryNode {
        bounds,
        first: place.first,
        count: count as u32,
        left_count: left_count as u32,
    };
    if left_count == 0 {
        return;
    }
    let (left, right) = primitives.split_at_mut(left_count);
    let (left_nodes, right_nodes) = below.split_at_mut(2 * left_count - 1);
    let depth = place.depth + 1;
    let left_place = TreeRange { first: place.first, depth };
    let right_place = TreeRange { first: place.first + left_count as u32, depth };
    if count >= PARALLEL_TRIANGLES {
        rayon::join(
            || build_range(left, left_nodes, left_place),
            || build_range(right, right_nodes, right_place),
        );
    } else {
        build_range(left, left_nodes, left_place);
        build_range(right, right_nodes, right_place);
    }
}

/// Box of the triangles and box of their (doubled) centers.
fn bounds_of(primitives: &[Primitive]) -> (Box3, Box3) {
    let mut bounds = Box3::EMPTY;
    let mut centers = Box3::EMPTY;
    for primitive in primitives {
        bounds.grow(&primitive.bounds);
        let center = std::array::from_fn(|axis| primitive.center(axis));
        centers.grow(&Box3 { low: center, high: center });
    }
    (bounds, centers)
}

/// Orders the range into a left and a right part; returns the length of the left one.
fn split(primitives: &mut [Primitive], centers: &Box3) -> usize {
    let Some(plane) = best_plane(primitives, centers) else {
        return primitives.len() / 2;
    };
    let left = partition(primitives, |p| plane.bin(p) < plane.bin_right);
    debug_assert!(left > 0 && left < primitives.len());
    left
}

/// A stable order is not needed, only one that does not depend on threads.
fn partition(primitives: &mut [Primitive], is_left: impl Fn(&Primitive) -> bool) -> usize {
    let (mut start, mut end) = (0, primitives.len());
    loop {
        while start < end && is_left(&primitives[start]) {
            start += 1;
        }
        while start < end && !is_left(&primitives[end - 1]) {
            end -= 1;
        }
        if start >= end {
            return start;
        }
        primitives.swap(start, end - 1);
    }
}

struct SplitPlane {
    axis: usize,
    low: f32,
    bins_per_unit: f32,
    /// First bin of the right side.
    bin_right: usize,
}

impl SplitPlane {
    #[inline]
    fn bin(&self, primitive: &Primitive) -> usize {
        // Saturates at 0 for what rounding puts below.
        (((primitive.center(self.axis) - self.low) * self.bins_per_unit) as usize).min(BINS - 1)
    }
}

#[derive(Clone, Copy)]
struct Bin {
    bounds: Box3,
    count: u32,
}

/// The plane of least Σ area · count, `None` if all centers coincide.
fn best_plane(primitives: &[Primitive], centers: &Box3) -> Option<SplitPlane> {
    let mut best: Option<(f32, SplitPlane)> = None;
    for axis in 0..3 {
        let extent = centers.high[axis] - centers.low[axis];
        // The largest center must reach the last bin and an inverse must be finite.
        if extent.is_nan() || extent <= f32::MIN_POSITIVE * BINS as f32 {
            continue;
        }
        let bins_per_unit = BINS as f32 / extent;
        let mut plane = SplitPlane { axis, low: centers.low[axis], bins_per_unit, bin_right: 0 };
        let mut bins = [Bin { bounds: Box3::EMPTY, count: 0 }; BINS];
        for primitive in primitives {
            let bin = &mut bins[plane.bin(primitive)];
            bin.bounds.grow(&primitive.bounds);
            bin.count += 1;
        }
        let (cost, bin_right) = cheapest(&bins);
        if best.as_ref().is_none_or(|(least, _)| cost < *least) {
            plane.bin_right = bin_right;
            best = Some((cost, plane));
        }
    }
    best.map(|(_, plane)| plane)
}

/// Least Σ area · count over the borders between bins, and the first bin right of it.
fn cheapest(bins: &[Bin; BINS]) -> (f32, usize) {
    let mut right_costs = [0.0; BINS];
    let mut right = Bin { bounds: Box3::EMPTY, count: 0 };
    for i in (1..BINS).rev() {
        right.bounds.grow(&bins[i].bounds);
        right.count += bins[i].count;
        right_costs[i] = right.bounds.half_area() * right.count as f32;
    }
    let mut left = Bin { bounds: Box3::EMPTY, count: 0 };
    let mut best = (f32::INFINITY, BINS / 2);
    let total = right.count + bins[0].count;
    for i in 1..BINS {
        left.bounds.grow(&bins[i - 1].bounds);
        left.count += bins[i - 1].count;
        if left.count == 0 || left.count == total {
            continue;
        }
        let cost = left.bounds.half_area() * left.count as f32 + right_costs[i];
        if cost < best.0 {
            best = (cost, i);
        }
    }
    best
}
