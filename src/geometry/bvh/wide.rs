//! The tree that rays walk: nodes of eight boxes, leaves of up to eight triangles.

use rayon::prelude::*;

use super::super::DVec3;
use super::binary::BinaryNode;
use super::forest::{Forest, TreeCut};

/// Children of a node, triangles of a packet, lanes of a kernel.
pub(super) const LANES: usize = 8;

/// No triangle has this number.
pub(super) const NO_TRIANGLE: u32 = u32::MAX;

/// One value a child or triangle.
pub(super) type Lanes = [f32; LANES];

/// A child: a node, or a packet if the highest bit is set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Child(pub u32);

impl Child {
    const PACKET: u32 = 1 << 31;

    #[inline(always)]
    pub fn as_packet(self) -> Option<usize> {
        (self.0 & Child::PACKET != 0).then_some(self.index())
    }

    #[inline(always)]
    pub fn index(self) -> usize {
        (self.0 & !Child::PACKET) as usize
    }
}

/// Boxes of eight children, in the tree's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(64))]
pub(super) struct WideNode {
    /// Low x, high x, low y, high y, low z, high z. A box that holds nothing is inside out.
    pub planes: [Lanes; 6],
    pub children: [Child; LANES],
}

impl WideNode {
    const EMPTY: WideNode = {
        let (low, high) = ([f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]);
        WideNode { planes: [low, high, low, high, low, high], children: [Child(0); LANES] }
    };
}

/// Different corners that the triangles of a packet have at most: a strip of six triangles has 8.
/// With twelve (2 × 2 quads of a grid have 9) a lamp's tree takes 78 bytes a triangle instead of
/// 70, and its rays are no faster.
pub(super) const CORNERS: usize = 8;

/// Up to eight neighboring triangles with their corners in f64, each stored once: smaller than
/// eight separate triangles in f32, and no test has to fetch anything else.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(64))]
pub(super) struct Packet {
    /// x, y, z in mm; places without a corner repeat the first.
    pub positions: [[f64; CORNERS]; 3],
    pub triangles: [u32; LANES],
    /// Places of the first, second and third corners in `positions`.
    pub corners: [[u8; LANES]; 3],
    /// One bit a triangle.
    pub present: u8,
}

impl Packet {
    /// `None` if the corners are too many.
    fn new(triangles: impl Iterator<Item = (u32, [DVec3; 3])>) -> Option<Packet> {
        let mut packet = Packet {
            positions: [[0.0; CORNERS]; 3],
            triangles: [NO_TRIANGLE; LANES],
            corners: [[0; LANES]; 3],
            present: 0,
        };
        let mut corners = Corners::default();
        for (lane, (triangle, positions)) in triangles.enumerate() {
            packet.triangles[lane] = triangle;
            packet.present |= 1 << lane;
            for (place, position) in positions.into_iter().enumerate() {
                packet.corners[place][lane] = corners.place_of(position)?;
            }
        }
        for (place, position) in corners.filled().into_iter().enumerate() {
            for (axis, value) in position.to_array().into_iter().enumerate() {
                packet.positions[axis][place] = value;
            }
        }
        Some(packet)
    }
}

/// Different positions in the order of their first use.
#[derive(Default)]
struct Corners {
    positions: [DVec3; CORNERS],
    count: usize,
}

impl Corners {
    fn place_of(&mut self, position: DVec3) -> Option<u8> {
        // By bits, so that a corner keeps the sign of its zeros.
        let bits = position.to_array().map(f64::to_bits);
        let known = &self.positions[..self.count];
        let found = known.iter().position(|p| p.to_array().map(f64::to_bits) == bits);
        let place = found.unwrap_or(self.count);
        if found.is_none() {
            *self.positions.get_mut(place)? = position;
            self.count += 1;
        }
        Some(place as u8)
    }

    fn filled(mut self) -> [DVec3; CORNERS] {
        let first = self.positions[0];
        self.positions[self.count..].fill(first);
        self.positions
    }
}

/// Whether one packet holds all these triangles.
pub(super) fn fits_a_packet(triangles: impl ExactSizeIterator<Item = [DVec3; 3]>) -> bool {
    if triangles.len() <= 2 {
        return true;
    }
    let mut corners = Corners::default();
    triangles.len() <= LANES
        && triangles.flatten().all(|position| corners.place_of(position).is_some())
}

/// Nodes and packets below `root`, which is `None` if there is nothing to meet.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tree {
    pub nodes: Vec<WideNode>,
    pub packets: Vec<Packet>,
    pub root: Option<Child>,
}

impl Tree {
    /// `triangle_at` gives number and corners of the triangle at a place of the binary tree's order.
    pub fn new(
        binary: &[BinaryNode],
        forests: &[Forest],
        triangle_at: impl Fn(u32) -> (u32, [DVec3; 3]) + Sync,
    ) -> Tree {
        let mut collapse = Collapse { binary, forests, nodes: Vec::new(), leaves: Vec::new() };
        let root = (!binary.is_empty()).then(|| collapse.emit(0));
        let packets = collapse
            .leaves
            .par_iter()
            .map(|leaf| {
                Packet::new(leaf.clone().map(&triangle_at)).expect("forests cut what fits a packet")
            })
            .collect();
        Tree { nodes: collapse.nodes, packets, root }
    }

    pub fn memory_bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.packets[..])
    }
}

/// Takes the nodes that the forests chose out of the binary tree, depth first.
struct Collapse<'a> {
    binary: &'a [BinaryNode],
    forests: &'a [Forest],
    nodes: Vec<WideNode>,
    leaves: Vec<std::ops::Range<u32>>,
}

impl Collapse<'_> {
    fn emit(&mut self, index: usize) -> Child {
        let source = self.binary[index];
        if self.forests[index].is_leaf() {
            self.leaves.push(source.first..source.first + source.count);
            return Child(Child::PACKET | (self.leaves.len() - 1) as u32);
        }
        let slot = self.nodes.len();
        self.nodes.push(WideNode::EMPTY);
        let mut roots = Vec::with_capacity(LANES);
        self.gather(index, self.forests[index].part(LANES), &mut roots);
        for (lane, &root) in roots.iter().enumerate() {
            let child = self.emit(root);
            let bounds = self.binary[root].bounds;
            let node = &mut self.nodes[slot];
            node.children[lane] = child;
            for axis in 0..3 {
                node.planes[2 * axis][lane] = bounds.low[axis];
                node.planes[2 * axis + 1][lane] = bounds.high[axis];
            }
        }
        Child(slot as u32)
    }

    /// The roots of the trees into which `part` cuts the subtree.
    fn gather(&self, index: usize, part: TreeCut, roots: &mut Vec<usize>) {
        let (TreeCut::Cut { left, right }, Some(below)) = (part, self.binary[index].children())
        else {
            return roots.push(index);
        };
        for (child, trees) in below.into_iter().zip([left, right]) {
            self.gather(index + child, self.forests[index + child].part(trees), roots);
        }
    }
}
