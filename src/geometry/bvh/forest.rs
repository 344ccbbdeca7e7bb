//! Which nodes of the binary tree become nodes and leaves of the wide one: the choice of least
//! expected cost, by dynamic programming (Ylitie, Karras and Laine, "Efficient Incoherent Ray
//! Traversal on GPUs Through Compressed Wide BVHs", HPG 2017, section 3).

use super::binary::BinaryNode;
use super::wide::LANES;

/// Cost of testing a packet, in tests of a node.
const PACKET_COST: f32 = 1.0;
/// Subtrees this large are worth a task of their own.
const PARALLEL_NODES: usize = 8192;

/// The cheapest ways to cut one subtree into at most 1, 2, … 7 trees, and into 8 below a node.
#[derive(Debug, Clone, Copy)]
pub(super) struct Forest {
    /// By number of trees, from 1.
    costs: [f32; LANES - 1],
    /// Trees left of the cut by number of trees, from 2; 0: one tree fewer does as well.
    left_trees: [u8; LANES - 1],
    is_leaf: bool,
}

/// How a subtree is cut into a number of trees.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum TreeCut {
    Whole,
    Cut { left: usize, right: usize },
}

impl Forest {
    const EMPTY: Forest =
        Forest { costs: [0.0; LANES - 1], left_trees: [0; LANES - 1], is_leaf: true };

    pub fn is_leaf(&self) -> bool {
        self.is_leaf
    }

    pub fn part(&self, mut trees: usize) -> TreeCut {
        while trees >= 2 {
            let left = usize::from(self.left_trees[trees - 2]);
            if left > 0 {
                return TreeCut::Cut { left, right: trees - left };
            }
            trees -= 1;
        }
        TreeCut::Whole
    }

    fn single(node: &BinaryNode) -> Forest {
        let cost = node.bounds.half_area() * PACKET_COST;
        Forest { costs: [cost; LANES - 1], ..Forest::EMPTY }
    }

    /// `fits` says whether the triangles can be one packet.
    fn join(node: &BinaryNode, left: &Forest, right: &Forest, fits: bool) -> Forest {
        let area = node.bounds.half_area();
        let mut forest = Forest::EMPTY;
        let (below, left_trees) = cheapest_cut(left, right, LANES);
        forest.left_trees[LANES - 2] = left_trees;
        let as_node = below + area;
        let as_leaf = if fits { area * PACKET_COST } else { f32::INFINITY };
        forest.is_leaf = as_leaf <= as_node;
        forest.costs[0] = as_leaf.min(as_node);
        for trees in 2..LANES {
            let (cost, left_trees) = cheapest_cut(left, right, trees);
            let fewer = forest.costs[trees - 2];
            forest.costs[trees - 1] = cost.min(fewer);
            forest.left_trees[trees - 2] = if cost < fewer { left_trees } else { 0 };
        }
        forest
    }
}

fn cheapest_cut(left: &Forest, right: &Forest, trees: usize) -> (f32, u8) {
    let mut best = (f32::INFINITY, 1);
    for left_trees in 1..trees {
        let cost = left.costs[left_trees - 1] + right.costs[trees - left_trees - 1];
        if cost < best.0 {
            best = (cost, left_trees as u8);
        }
    }
    best
}

/// One forest a node of the binary tree, in its order.
///
/// `fits` says whether the triangles of a node can be one packet.
pub(super) fn plan(nodes: &[BinaryNode], fits: impl Fn(&BinaryNode) -> bool + Sync) -> Vec<Forest> {
    let mut forests = vec![Forest::EMPTY; nodes.len()];
    if !nodes.is_empty() {
        plan_subtree(nodes, &mut forests, &fits);
    }
    forests
}

fn plan_subtree(
    nodes: &[BinaryNode],
    forests: &mut [Forest],
    fits: &(impl Fn(&BinaryNode) -> bool + Sync),
) {
    let node = &nodes[0];
    let Some([left, right]) = node.children() else {
        forests[0] = Forest::single(node);
        return;
    };
    let (own, below) = forests.split_at_mut(left);
    let (left_forests, right_forests) = below.split_at_mut(right - left);
    let (left_nodes, right_nodes) = (&nodes[left..right], &nodes[right..]);
    if nodes.len() >= PARALLEL_NODES {
        rayon::join(
            || plan_subtree(left_nodes, left_forests, fits),
            || plan_subtree(right_nodes, right_forests, fits),
        );
    } else {
        plan_subtree(left_nodes, left_forests, fits);
        plan_subtree(right_nodes, right_forests, fits);
    }
    let is_packet = node.count as usize <= LANES && fits(node);
    own[0] = Forest::join(node, &left_forests[0], &right_forests[0], is_packet);
}
