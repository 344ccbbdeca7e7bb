//! The descent: expand nodes until their estimated errors together are within the budget.

use std::cell::Cell;

use glam::DVec3;

use super::SideSum;
use super::blocks::{Blocks, Summing};
use super::levels::Levels;
use super::node::{NodeQuery, eval_octet};
use crate::light::sum::block::{BlockQuery, Scratch};
use crate::light::{Sight, Visibility};

/// Sums under this fraction of what the set could send straight at the hit (from its radius, if
/// the hit is nearer) count as dark: their error is absolute.
const DARK: f64 = 1e-14;

/// With shadows, nodes of more than about 1/64 of the samples are always expanded: a blocker that
/// hides no such node's mean place may be missed.
const SHADOW_LEVEL: usize = 1;

/// With 0.5 instead, a reflector like model 1's took 110 nodes a hit rather than 89.
const KEPT: f64 = 0.9;

/// The bound within which all nodes' errors add up as if they had one sign. A smaller `light_error`
/// asks so much only of nodes that are not [`Leaf::is_smooth`]; the others' errors, what a series or
/// an interpolation leaves out of either sign, add up as independent ones. Those of beams never do.
const LINEAR: f64 = 0.01;

/// An estimate of independent errors covers this many standard deviations, were each node's error
/// one. It is far more.
const DEVIATIONS: f64 = 3.0;

/// Largest error over value of a node that a series describes; beyond, the error is the most that the
/// node may send, and the value less than that: errors of one sign.
const SMOOTH: f32 = 0.3;

/// A node that stands for its samples.
#[derive(Debug, Clone, Copy)]
struct Leaf {
    value: f32,
    error: f32,
    level: u8,
    node: u32,
    /// What a hidden node would send if it were seen; 0 for a seen one.
    hidden: f32,
    /// Whether all of its places are seen or hidden alike, for sure.
    is_known: bool,
}

impl Leaf {
    fn is_smooth(&self) -> bool {
        self.error < SMOOTH * self.value
    }
}

/// One side of a hit, and what it asks of the tree.
pub(super) struct Descent<'a> {
    pub levels: &'a Levels,
    pub blocks: &'a Blocks,
    pub query: &'a BlockQuery<'a>,
    pub visible: Option<Visibility<'a>>,
    pub light_error: f64,
}

impl Descent<'_> {
    pub fn run(&self) -> SideSum {
        let local = (self.query.point - self.levels.center).as_vec3();
        let node_query = NodeQuery {
            point: local.into(),
            normal: self.query.side.normal.as_vec3().into(),
            axis: self.query.side.axis.as_vec3().into(),
            diffuse: self.query.lobes.diffuse,
            specular: &self.query.lobes.specular,
            half: self.query.side.is_half.then(|| self.query.side.view().as_vec3().into()),
            inverse_square: self.query.inverse_square,
        };
        // None after a panic, or within another sum of this thread: then there is a new one.
        let mut state = KEPT_STATE.take().unwrap_or_default();
        state.clear();
        self.expand_octet(0, 0, &node_query, &mut state);
        while let Some([smooth, other]) = self.thresholds(&mut state) {
            let threshold = |leaf: &Leaf| if leaf.is_smooth() { smooth } else { other };
            let too_wrong = |leaf: &Leaf| f64::from(leaf.error) > threshold(leaf);
            state.expanded.extend(state.leaves.iter().copied().filter(too_wrong));
            state.leaves.retain(|leaf| !too_wrong(leaf));
            while let Some(leaf) = state.expanded.pop() {
                self.expand(leaf, &node_query, &mut state);
            }
        }
        let (value, error) = (state.value(), self.estimate(&state));
        let sum = SideSum { sum: value, error, nodes: state.nodes, samples: state.samples };
        KEPT_STATE.set(Some(state));
        sum
    }

    /// The errors over which smooth nodes and others are expanded; none once all of them are within
    /// the budget.
    ///
    /// Nodes that stay may take [`KEPT`] of the budget; the others' children have the rest.
    fn thresholds(&self, state: &mut DescentState) -> Option<[f64; 2]> {
        if self.visible.is_some() {
            self.doubt_borders(state);
        }
        let (value, error) = (state.value(), state.error());
        let bound = self.light_error.max(self.linear_from());
        let least = (value - error).max(self.dark_sum());
        if error > bound * least {
            // In the first rounds `value − error` says little; the value itself is the better guess.
            let budget = (bound * least).max(0.5 * bound * value);
            return Some([state.threshold(KEPT * budget, |leaf| f64::from(leaf.error)); 2]);
        }
        let budget = self.light_error * least;
        if self.light_error >= self.linear_from() || self.estimate(state) <= budget {
            return None;
        }
        let (smooth, other) = state.parted_errors();
        // Each part has what the other leaves, at least half.
        let [of_smooth, of_other] = [other, smooth].map(|rest| budget - rest.min(0.5 * budget));
        let square =
            |leaf: &Leaf| if leaf.is_smooth() { f64::from(leaf.error).powi(2) } else { 0.0 };
        let plain = |leaf: &Leaf| if leaf.is_smooth() { 0.0 } else { f64::from(leaf.error) };
        let squares = KEPT * (of_smooth / DEVIATIONS).powi(2);
        let thresholds = [
            (smooth > of_smooth).then(|| state.threshold(squares, square)),
            (other > of_other).then(|| state.threshold(KEPT * of_other, plain)),
        ];
        // Neither, where only rounding is over the budget.
        let any = thresholds.iter().any(Option::is_some);
        any.then(|| thresholds.map(|threshold| threshold.unwrap_or(f64::INFINITY)))
    }

    /// The smallest `light_error` for which all errors add up as if they had one sign.
    fn linear_from(&self) -> f64 {
        if self.levels.has_beams { 0.0 } else { LINEAR }
    }

    /// Of the error that nodes have together.
    fn estimate(&self, state: &DescentState) -> f64 {
        let together = state.error();
        if self.light_error >= self.linear_from() {
            return together;
        }
        let (smooth, other) = state.parted_errors();
        together.min(smooth + other)
    }

    fn dark_sum(&self) -> f64 {
        let weights = self.query.lobes.total_weight() * self.levels.flux * DARK;
        if !self.query.inverse_square {
            return weights;
        }
        let distance = self.query.point.distance(self.levels.center).max(self.levels.radius);
        weights / distance.max(1e-9).powi(2)
    }

    fn expand(&self, leaf: Leaf, query: &NodeQuery, state: &mut DescentState) {
        let level = usize::from(leaf.level);
        if level + 1 < self.levels.levels.len() {
            self.expand_octet(level + 1, leaf.node as usize, query, state);
            return;
        }
        let per_node = self.levels.levels[level].blocks_per_node;
        let first = leaf.node as usize * per_node;
        let (any_seen, any_hidden) = (Cell::new(false), Cell::new(false));
        let place = |place: DVec3| {
            let is_free = self.visible.is_none_or(|by| (by.place)(place));
            (if is_free { &any_seen } else { &any_hidden }).set(true);
            is_free
        };
        let ball = |center: DVec3, radius: f64| {
            let sight = self.visible.map_or(Sight::Seen, |by| (by.ball)(center, radius));
            any_seen.set(any_seen.get() || sight == Sight::Seen);
            any_hidden.set(any_hidden.get() || sight == Sight::Hidden);
            sight
        };
        let visible = self.visible.map(|_| Visibility { place: &place, ball: &ball });
        let scratch = state.scratch.get_or_insert_with(|| Box::new(Scratch::new()));
        for block in first..first + per_node {
            let how = Summing { visible, few_questions: false };
            let (sum, samples) = self.blocks.sum(block, self.query, &how, scratch);
            state.exact += sum;
            state.samples += samples;
        }
        if visible.is_some() {
            let (center, radius) = self.sphere(&leaf);
            let (is_seen, is_hidden) = (any_seen.get(), any_hidden.get());
            state.settled.push(Shade { center, radius, is_seen, is_hidden });
        }
    }

    /// Octets of a level are in the order of their parents.
    fn expand_octet(
        &self,
        level: usize,
        octet: usize,
        query: &NodeQuery,
        state: &mut DescentState,
    ) {
        let at = &self.levels.levels[level];
        let sums = eval_octet(&at.octets[octet], (at.grid, at.tables(octet)), query);
        state.nodes += 8;
        for lane in 0..8 {
            let (value, error) = (sums.value.0[lane], sums.error.0[lane]);
            if value > 0.0 || error > 0.0 {
                let node = (octet * 8 + lane) as u32;
                let (level, hidden, is_known) = (level as u8, 0.0, false);
                let leaf = Leaf { value, error, level, node, hidden, is_known };
                let place = sums.place.map(|axis| f64::from(axis.0[lane]));
                state.leaves.push(self.shaded(leaf, DVec3::from(place) + self.levels.center));
            }
        }
    }

    /// Asks of all of it; where that tells nothing, once, towards its mean place.
    fn shaded(&self, leaf: Leaf, place: DVec3) -> Leaf {
        let Some(visible) = self.visible.filter(|_| leaf.value > 0.0) else { return leaf };
        let is_coarse = usize::from(leaf.level) < SHADOW_LEVEL;
        let most = leaf.value + leaf.error;
        let (center, radius) = self.sphere(&leaf);
        let sight = (visible.ball)(center + self.levels.center, radius);
        let is_free = match sight {
            Sight::Seen => true,
            Sight::Hidden => false,
            Sight::Unknown => (visible.place)(place),
        };
        let is_known = sight != Sight::Unknown;
        let error = match is_free {
            _ if is_coarse && !is_known => most,
            true => leaf.error,
            false => 0.0,
        };
        let (value, hidden) = if is_free { (leaf.value, 0.0) } else { (0.0, most) };
        Leaf { value, error, hidden, is_known, ..leaf }
    }

    /// Where seen and hidden nodes touch, any of them may be hidden in part.
    fn doubt_borders(&self, state: &mut DescentState) {
        if state.leaves.iter().all(|leaf| leaf.is_known) {
            return;
        }
        let (leaves, settled) = (&state.leaves, &state.settled);
        let is_any_seen =
            leaves.iter().any(|leaf| leaf.value > 0.0) || settled.iter().any(|it| it.is_seen);
        let is_any_hidden =
            leaves.iter().any(|leaf| leaf.hidden > 0.0) || settled.iter().any(|it| it.is_hidden);
        if !(is_any_seen && is_any_hidden) {
            return;
        }
        let shade = |leaf: &Leaf| {
            let (center, radius) = self.sphere(leaf);
            Shade { center, radius, is_seen: leaf.value > 0.0, is_hidden: leaf.hidden > 0.0 }
        };
        let mut shades: Vec<Shade> = state.leaves.iter().map(shade).collect();
        shades.extend(&state.settled);
        for (leaf, here) in state.leaves.iter_mut().zip(&shades) {
            let most = leaf.value.max(leaf.hidden);
            let may_be_doubted = !leaf.is_known && leaf.error < most;
            if may_be_doubted && shades.iter().any(|there| here.borders_on(there)) {
                leaf.error = most;
            }
        }
    }

    fn sphere(&self, leaf: &Leaf) -> (DVec3, f64) {
        let octet = &self.levels.levels[usize::from(leaf.level)].octets[leaf.node as usize / 8];
        let lane = leaf.node as usize % 8;
        let center = octet.center.map(|axis| f64::from(axis.0[lane]));
        (DVec3::from(center), f64::from(octet.radius.0[lane]))
    }
}

/// Where a node lies, and what of it the hit sees as far as it asked.
#[derive(Debug, Clone, Copy)]
struct Shade {
    center: DVec3,
    radius: f64,
    is_seen: bool,
    is_hidden: bool,
}

impl Shade {
    fn borders_on(&self, other: &Shade) -> bool {
        let differs = (self.is_seen && other.is_hidden) || (self.is_hidden && other.is_seen);
        let reach = self.radius + other.radius;
        differs && self.center.distance_squared(other.center) <= reach * reach
    }
}

thread_local! {
    /// Each thread's lists, so that a sum allocates nothing.
    static KEPT_STATE: Cell<Option<Box<DescentState>>> = const { Cell::new(None) };
}

#[derive(Default)]
struct DescentState {
    leaves: Vec<Leaf>,
    expanded: Vec<Leaf>,
    /// Nodes that were summed sample by sample; only with shadows.
    settled: Vec<Shade>,
    exact: f64,
    nodes: u32,
    samples: u32,
    /// For sums by samples: most hits have none.
    scratch: Option<Box<Scratch>>,
}

impl DescentState {
    fn clear(&mut self) {
        let Self { leaves, expanded, settled, exact, nodes, samples, scratch: _ } = self;
        leaves.clear();
        expanded.clear();
        settled.clear();
        (*exact, *nodes, *samples) = (0.0, 0, 0);
    }

    fn value(&self) -> f64 {
        self.exact + self.leaves.iter().map(|leaf| f64::from(leaf.value)).sum::<f64>()
    }

    fn error(&self) -> f64 {
        self.leaves.iter().map(|leaf| f64::from(leaf.error)).sum()
    }

    /// Of smooth nodes and of others.
    fn parted_errors(&self) -> (f64, f64) {
        let (mut squares, mut other) = (0.0, 0.0);
        for leaf in &self.leaves {
            let error = f64::from(leaf.error);
            if leaf.is_smooth() { squares += error * error } else { other += error }
        }
        (DEVIATIONS * squares.sqrt(), other)
    }

    /// The error up to which nodes stay, so that what they weigh together is within `guess`.
    fn threshold(&self, guess: f64, weight: impl Fn(&Leaf) -> f64) -> f64 {
        let mut by_exponent = [0.0f64; 256];
        for leaf in &self.leaves {
            by_exponent[(leaf.error.to_bits() >> 23) as usize & 255] += weight(leaf);
        }
        let (mut stays, mut exponent) = (0.0, 0u32);
        while exponent < 255 && stays + by_exponent[exponent as usize] <= guess {
            stays += by_exponent[exponent as usize];
            exponent += 1;
        }
        // All of the bucket at `exponent`: at least the largest are expanded.
        let below = f32::from_bits((exponent << 23).saturating_sub(1));
        let weighed = self.leaves.iter().filter(|leaf| weight(leaf) > 0.0);
        let largest = weighed.map(|leaf| leaf.error).fold(0.0, f32::max);
        f64::from(below.min(largest * 0.999))
    }
}
