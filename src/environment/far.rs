//! Sums of lobes over the sphere of directions, within a stated error: the far half of eq. 9.

use std::cmp::Ordering;

use glam::DVec3;
use rayon::prelude::*;

use super::dome::{CHANNELS, Dome, Luminances};
use super::node::{FarLobe, Node, NodeSum};
use super::patch::{Cells, Patch};
use super::table::CellTable;

/// Nodes are kept down to about this many leaves; what is finer is looked up when asked for.
const MOST_LEAVES: usize = 1 << 16;

/// A sum that does not settle within these is cut off, with the error that it has: without and with
/// shadow rays.
const MOST_NODES: [usize; 2] = [20_000, 1000];

/// Nodes wider than this (their distance from center to rim) are always cut when something may
/// stand before them: at most about 1/60 of the sphere is judged by one ray.
const WIDEST_JUDGED: f64 = 0.3;

/// Share of the budget that nodes which stay may take.
const KEPT: f64 = 0.9;

/// Sums under this fraction of what an even sphere of the same light sends count as dark: their
/// error is absolute.
const DARK: f64 = 1e-6;

/// Below it, f64 sums of moments are no better.
const SMALLEST_ERROR: f64 = 1e-5;

/// In deep shadow the error is relative to this share of what the lobes would get if nothing stood
/// before the surroundings: a corner that sees next to nothing is not worth thousands of rays.
const SHADED: f64 = 0.25;

/// Part of the error that is asked for: without shadow rays a sum is cheap, and a furnace even to 1e-4.
const WITHOUT_SHADOWS: f64 = 0.4;

/// Whether the surroundings are seen in a direction.
pub(super) type Sight<'a> = &'a dyn Fn(DVec3) -> bool;

/// The sphere halved again and again, with the moments of each part's light.
#[derive(Debug, Clone)]
pub(super) struct FarTree {
    table: CellTable,
    branches: Vec<FarBranch>,
    /// ∫ L over the sphere.
    light: f64,
}

#[derive(Debug, Clone)]
struct FarBranch {
    node: Node,
    /// Places of its halves in [`FarTree::branches`]; none for leaves.
    halves: Option<[u32; 2]>,
}

/// What the surroundings send through the lobes of a hit's side.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FarSum {
    /// Luminances of the surroundings' spectra, cd/m².
    pub values: Luminances,
    /// Estimate of how wrong their sum is.
    pub error: f64,
    /// Nodes that were evaluated.
    pub nodes: u32,
}

impl FarTree {
    pub fn build(dome: &Dome) -> FarTree {
        let table = CellTable::new(dome);
        let mut plan = Vec::new();
        plan_branches(Patch::SPHERE, table.cells, &mut plan);
        let is_leaf = |planned: &&Planned| planned.halves.is_none();
        let leaves: Vec<Patch> = plan.iter().filter(is_leaf).map(|leaf| leaf.patch).collect();
        let node = |patch: &Patch| make_node(dome, &table, *patch);
        let leaves: Vec<Node> = leaves.par_iter().map(node).collect();
        let branches = assemble(&plan, leaves);
        let light = branches[0].node.light();
        FarTree { table, branches, light }
    }

    /// `lobes` and `sight` in the dome's coordinates.
    pub fn sum(
        &self,
        dome: &Dome,
        lobes: &[FarLobe],
        largest_error: f64,
        sight: Option<Sight>,
    ) -> FarSum {
        let share = if sight.is_some() { 1.0 } else { WITHOUT_SHADOWS };
        let largest_error = (share * largest_error).max(SMALLEST_ERROR);
        FarDescent { tree: self, dome, lobes, largest_error, sight }.run()
    }
}

fn make_node(dome: &Dome, table: &CellTable, patch: Patch) -> Node {
    match patch.count(table.cells) {
        [1, 1] => Node::from_dome(dome, patch),
        _ => Node::from_table(table, patch),
    }
}

struct Planned {
    patch: Patch,
    halves: Option<[u32; 2]>,
}

/// Depth first; returns the patch's place in `plan`.
fn plan_branches(patch: Patch, cells: Cells, plan: &mut Vec<Planned>) -> u32 {
    let own = plan.len();
    plan.push(Planned { patch, halves: None });
    let [columns, rows] = patch.count(cells);
    let most_cells = (cells.columns * cells.rows).div_ceil(MOST_LEAVES);
    if columns * rows > most_cells {
        let [first, second] = patch.halves(cells);
        let first = plan_branches(first, cells, plan);
        let second = plan_branches(second, cells, plan);
        plan[own].halves = Some([first, second]);
    }
    own as u32
}

/// Halves follow what they are halves of, so that from the end on they are there when needed.
fn assemble(plan: &[Planned], leaves: Vec<Node>) -> Vec<FarBranch> {
    let mut leaves = leaves.into_iter().rev();
    let mut nodes: Vec<Option<Node>> = vec![None; plan.len()];
    for (at, planned) in plan.iter().enumerate().rev() {
        let half = |index: u32| nodes[index as usize].as_ref();
        nodes[at] = match planned.halves {
            None => leaves.next(),
            Some([a, b]) => {
                half(a).zip(half(b)).map(|(a, b)| Node::from_halves(planned.patch, [a, b]))
            }
        };
    }
    let branch = |(node, planned): (Option<Node>, &Planned)| {
        node.map(|node| FarBranch { node, halves: planned.halves })
    };
    nodes.into_iter().zip(plan).filter_map(branch).collect()
}

/// A node that stands for its part of the sphere.
#[derive(Debug, Clone, Copy)]
struct FarLeaf {
    /// In the tree; None for what was looked up.
    index: Option<u32>,
    patch: Patch,
    center: DVec3,
    radius: f64,
    sum: NodeSum,
    is_hidden: bool,
    /// With what stands before it in part.
    error: f64,
}

/// The centers and radii of leaves, close together: every leaf is held against all of the other kind.
type Discs = Vec<(DVec3, f64)>;

fn discs(leaves: &[FarLeaf], are_hidden: bool) -> Discs {
    let of_kind = leaves.iter().filter(|leaf| leaf.is_hidden == are_hidden);
    of_kind.map(|leaf| (leaf.center, leaf.radius)).collect()
}

impl FarLeaf {
    fn touches_any(&self, discs: &Discs) -> bool {
        discs.iter().any(|(center, radius)| {
            let reach = self.radius + radius;
            self.center.distance_squared(*center) <= reach * reach
        })
    }
}

struct FarDescent<'a> {
    tree: &'a FarTree,
    dome: &'a Dome,
    lobes: &'a [FarLobe],
    largest_error: f64,
    sight: Option<Sight<'a>>,
}

impl FarDescent<'_> {
    fn run(&self) -> FarSum {
        let mut leaves = Vec::with_capacity(256);
        let mut nodes = 0;
        let most = MOST_NODES[usize::from(self.sight.is_some())];
        self.push(Some(0), &self.tree.branches[0].node, &mut leaves);
        loop {
            self.judge(&mut leaves);
            let (values, error) = totals(&leaves);
            let least = self.shaded(&leaves).max(self.dark());
            let budget = self.largest_error * values.iter().sum::<f64>().max(least);
            if error <= budget || nodes > most {
                return FarSum { values, error, nodes: nodes as u32 };
            }
            let wrong = take_wrongest(&mut leaves, KEPT * budget);
            nodes += 2 * wrong.len();
            wrong.into_iter().for_each(|leaf| self.expand(leaf, &mut leaves));
        }
    }

    /// See [`SHADED`].
    fn shaded(&self, leaves: &[FarLeaf]) -> f64 {
        let open = |leaf: &FarLeaf| leaf.sum.values.iter().sum::<f64>();
        let share = if self.sight.is_some() { SHADED } else { 0.0 };
        share * leaves.iter().map(open).sum::<f64>()
    }

    /// A sum that is as good as none.
    fn dark(&self) -> f64 {
        let weigh = |lobe: &FarLobe| lobe.weight / (lobe.exponent + 1.0);
        DARK * 0.5 * self.tree.light * self.lobes.iter().map(weigh).sum::<f64>()
    }

    fn expand(&self, leaf: FarLeaf, leaves: &mut Vec<FarLeaf>) {
        let halves = leaf.index.and_then(|index| self.tree.branches[index as usize].halves);
        match halves {
            Some(halves) => {
                for index in halves {
                    self.push(Some(index), &self.tree.branches[index as usize].node, leaves);
                }
            }
            None => {
                let table = &self.tree.table;
                for patch in leaf.patch.halves(table.cells) {
                    self.push(None, &make_node(self.dome, table, patch), leaves);
                }
            }
        }
    }

    /// Leaves out what sends nothing.
    fn push(&self, index: Option<u32>, node: &Node, leaves: &mut Vec<FarLeaf>) {
        let sum = node.sum(self.lobes);
        if sum.most == 0.0 {
            return;
        }
        let is_judged = node.radius <= WIDEST_JUDGED;
        let is_seen = |sight: Sight| !is_judged || sight(node.mean_direction());
        let is_hidden = !self.sight.is_none_or(is_seen);
        let &Node { patch, center, radius, .. } = node;
        leaves.push(FarLeaf { index, patch, center, radius, sum, is_hidden, error: sum.error });
    }

    /// Sets errors: too wide nodes may be hidden in part, and so may those on both sides of where
    /// seen and hidden ones touch. There a ray through the middle tells which half is larger, and
    /// what is wrong at one node cancels what is wrong at others: twice the root of the sum of
    /// squares is taken for all.
    fn judge(&self, leaves: &mut [FarLeaf]) {
        if self.sight.is_none() {
            return;
        }
        let [seen, hidden] = [false, true].map(|are_hidden| discs(leaves, are_hidden));
        let touches =
            |leaf: &FarLeaf| leaf.touches_any(if leaf.is_hidden { &seen } else { &hidden });
        let doubt = |leaf: &FarLeaf| if touches(leaf) { 0.5 * leaf.sum.most } else { 0.0 };
        let doubts: Vec<f64> = leaves.iter().map(doubt).collect();
        let squares: f64 = doubts.iter().map(|doubt| doubt * doubt).sum();
        let sum: f64 = doubts.iter().sum();
        let share = (2.0 * squares.sqrt() / sum.max(f64::MIN_POSITIVE)).min(1.0);
        for (leaf, doubt) in leaves.iter_mut().zip(doubts) {
            let own = if leaf.is_hidden { 0.0 } else { leaf.sum.error };
            let is_too_wide = leaf.radius > WIDEST_JUDGED;
            leaf.error = if is_too_wide { leaf.sum.most } else { own + share * doubt };
        }
    }
}

fn totals(leaves: &[FarLeaf]) -> (Luminances, f64) {
    let (mut values, mut error) = ([0.0; CHANNELS], 0.0);
    for leaf in leaves {
        error += leaf.error;
        if !leaf.is_hidden {
            for (sum, value) in values.iter_mut().zip(leaf.sum.values) {
                *sum += value;
            }
        }
    }
    (values, error)
}

/// Those of the largest errors, so that the errors of the rest sum to at most `kept`.
fn take_wrongest(leaves: &mut Vec<FarLeaf>, kept: f64) -> Vec<FarLeaf> {
    let place = |leaf: &FarLeaf| (leaf.patch.low[1], leaf.patch.low[0]);
    leaves.sort_unstable_by(|a, b| match a.error.total_cmp(&b.error) {
        // By place, so that the order does not depend on how they came in.
        Ordering::Equal => place(a).partial_cmp(&place(b)).unwrap_or(Ordering::Equal),
        order => order,
    });
    let mut sum = 0.0;
    let stays = leaves.iter().take_while(|leaf| {
        sum += leaf.error;
        sum <= kept
    });
    let stays = stays.count().min(leaves.len() - 1);
    leaves.split_off(stays)
}
