//! The tree that rays walk: nodes of eight boxes, leaves of up to eight triangles.

use rayon::prelude::*;

use super::super::DVec3;
use super::binary::BinaryNode;
use super::bounds::Frame;
use super::forest::{Forest, Part};

/// Children of a node, triangles of a packet, lanes of a kernel.
pub(super) const LANES: usize = 8;

/// One value a child or triangle.
pub(super) type Lanes = [f32; LANES];

/// A child: a node, or a packet if the highest bit is set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Child(pub u32);

impl Child {
    const PACKET: u32 = 1 << 31;

    #[inline(always)]
    pub fn as_packet(self) -> Option<usize> {
        (self.0 & Child::PACKET != 0).then_some((self.0 & !Child::PACKET) as usize)
    }
}

/// Boxes of eight children, in the tree's frame.
#[derive(Debug, Clone, Copy)]
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

/// Up to eight triangles, in the tree's frame, rounded to f32: enough to say which the ray may meet.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Packet {
    /// First corner; NaN where there is no triangle, which no comparison accepts.
    pub corner: [Lanes; 3],
    /// From the first corner to the second, and to the third.
    pub edges: [[Lanes; 3]; 2],
    pub triangles: [u32; LANES],
    /// Indices of the corners in their mesh, so that the exact test starts without a detour.
    pub positions: [[u32; 3]; LANES],
    /// At least the longest edge.
    pub edge_length: f32,
}

/// Corners and where they come from.
pub(super) struct PacketTriangle {
    pub triangle: u32,
    pub positions: [u32; 3],
    pub corners: [DVec3; 3],
}

impl Packet {
    /// Keeps squares of edges far from the end of f32; makes the filter milder, never wrong.
    const LEAST_EDGE: f32 = 1.0 / (1u64 << 40) as f32;

    fn new(frame: &Frame, triangles: impl Iterator<Item = PacketTriangle>) -> Packet {
        let mut packet = Packet {
            corner: [[f32::NAN; LANES]; 3],
            edges: [[[0.0; LANES]; 3]; 2],
            triangles: [u32::MAX; LANES],
            positions: [[0; 3]; LANES],
            edge_length: Packet::LEAST_EDGE,
        };
        for (lane, source) in triangles.enumerate() {
            let [a, b, c] = source.corners;
            let corner = frame.to_frame(a);
            let edges = [b - a, c - a].map(|e| (e * frame.per_mm).to_array().map(|x| x as f32));
            for axis in 0..3 {
                packet.corner[axis][lane] = corner[axis];
                packet.edges[0][axis][lane] = edges[0][axis];
                packet.edges[1][axis][lane] = edges[1][axis];
            }
            packet.triangles[lane] = source.triangle;
            packet.positions[lane] = source.positions;
            let longest = (b - a).length().max((c - a).length()).max((c - b).length());
            let length = ((longest * frame.per_mm) as f32).next_up();
            packet.edge_length = packet.edge_length.max(length);
        }
        packet
    }
}

/// Nodes and packets below `root`, which is `None` if there is nothing to meet.
#[derive(Debug, Clone)]
pub(super) struct Tree {
    pub nodes: Vec<WideNode>,
    pub packets: Vec<Packet>,
    pub root: Option<Child>,
}

impl Tree {
    /// `triangle_at` gives the triangle at a place of the binary tree's order.
    pub fn new(
        binary: &[BinaryNode],
        forests: &[Forest],
        frame: &Frame,
        triangle_at: impl Fn(u32) -> PacketTriangle + Sync,
    ) -> Tree {
        let mut collapse = Collapse { binary, forests, nodes: Vec::new(), leaves: Vec::new() };
        let root = (!binary.is_empty()).then(|| collapse.emit(0));
        let packets = collapse
            .leaves
            .par_iter()
            .map(|leaf| Packet::new(frame, leaf.clone().map(&triangle_at)))
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
    fn gather(&self, index: usize, part: Part, roots: &mut Vec<usize>) {
        let (Part::Cut { left, right }, Some(below)) = (part, self.binary[index].children()) else {
            return roots.push(index);
        };
        for (child, trees) in below.into_iter().zip([left, right]) {
            self.gather(index + child, self.forests[index + child].part(trees), roots);
        }
    }
}
