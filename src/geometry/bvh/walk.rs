//! The way of a ray through the tree, for any kernel.

use std::mem::MaybeUninit;
use std::ops::ControlFlow;

use super::super::DVec3;
use super::binary;
use super::bounds::Frame;
use super::kernel::TriangleKernel;
use super::probe::Probe;
use super::wide::{Child, LANES, Lanes, Packet, Tree, WideNode};

/// No level of the wide tree leaves more than 7 children behind; it has at most as many levels as
/// the binary tree: `SAH_DEPTH` and then halves of at most 2³² triangles.
const STACK: usize = (LANES - 1) * (binary::SAH_DEPTH as usize + 33) + 1;

/// Stands for a direction's 0, so that inverses and their products stay finite. It moves a ray by
/// less than 2⁻⁵⁰ while it crosses the scene.
pub(super) const LEAST_DIRECTION: f32 = 1e-18;

/// A probe in the tree's frame, in f32.
#[derive(Debug, Clone, Copy)]
pub(super) struct TreeRay {
    pub inverse: [f32; 3],
    pub origin_inverse: [f32; 3],
}

impl TreeRay {
    #[inline(always)]
    pub fn new(probe: &Probe, direction: &DVec3, frame: &Frame) -> TreeRay {
        let origin = frame.to_frame(DVec3::from_array(probe.origin));
        let direction = direction.to_array().map(|d| d as f32);
        let inverse = direction
            .map(|d| 1.0 / if d.abs() < LEAST_DIRECTION { LEAST_DIRECTION.copysign(d) } else { d });
        let origin_inverse = std::array::from_fn(|i| origin[i] * inverse[i]);
        TreeRay { inverse, origin_inverse }
    }

    /// 1 where the ray runs against the axis, and so enters a box through its high plane.
    #[inline(always)]
    pub fn sign(&self, axis: usize) -> usize {
        usize::from(self.inverse[axis].is_sign_negative())
    }
}

impl Tree {
    /// Calls `meet` with the packets whose boxes the ray enters before `end`, nearer ones first; it
    /// returns the new `end`, or breaks off.
    #[inline(always)]
    pub fn walk<K: TriangleKernel>(
        &self,
        ray: &K::Ray,
        mut end: f32,
        mut meet: impl FnMut(&Packet) -> ControlFlow<(), f32>,
    ) {
        let Some(mut child) = self.root else { return };
        let mut waiting = MaybeUninit::uninit();
        let mut stack = Stack { waiting: &mut waiting, top: 0 };
        loop {
            child = match child.as_packet() {
                None => {
                    let node = self.node(child);
                    let (lanes, near) = K::enter(node, ray, end);
                    match self.nearest::<K>(node, lanes, &near, &mut stack) {
                        Some(nearest) => nearest,
                        None => match stack.pop_before(end) {
                            Some(next) => next,
                            None => return,
                        },
                    }
                }
                Some(packet) => {
                    let packet = self.packet(packet);
                    match meet(packet) {
                        ControlFlow::Continue(nearer) => end = nearer,
                        ControlFlow::Break(()) => return,
                    }
                    match stack.pop_before(end) {
                        Some(next) => next,
                        None => return,
                    }
                }
            };
        }
    }

    /// The nearest child entered; the others wait on the stack, the farthest lowest.
    ///
    /// Compares with branches, which the processor guesses, see [`pick`]. What may be visited is
    /// asked of the memory first, since a wrong guess costs as long as its reading takes.
    #[inline(always)]
    fn nearest<K: TriangleKernel>(
        &self,
        node: &WideNode,
        mut lanes: u32,
        near: &Lanes,
        stack: &mut Stack<'_>,
    ) -> Option<Child> {
        if lanes == 0 {
            return None;
        }
        let first = take_lane(&mut lanes);
        self.prefetch::<K>(node.children[first]);
        if lanes == 0 {
            return Some(pick::<K>(node, first));
        }
        let second = take_lane(&mut lanes);
        let (a, b) = (near[first], near[second]);
        self.prefetch::<K>(node.children[second]);
        if lanes == 0 {
            if a <= b {
                K::branch::<LANES>();
                stack.push(Waiting::new(b, node.children[second]));
                return Some(pick::<K>(node, first));
            }
            K::branch::<LANES>();
            stack.push(Waiting::new(a, node.children[first]));
            return Some(pick::<K>(node, second));
        }
        let bottom = stack.top;
        stack.push(Waiting::new(a, node.children[first]));
        stack.insert::<K>(Waiting::new(b, node.children[second]), bottom);
        while lanes != 0 {
            let lane = take_lane(&mut lanes);
            self.prefetch::<K>(node.children[lane]);
            stack.insert::<K>(Waiting::new(near[lane], node.children[lane]), bottom);
        }
        stack.top -= 1;
        Some(stack.written(stack.top).child())
    }

    /// Without a branch, which would be guessed wrong as often as not.
    #[inline(always)]
    fn prefetch<K: TriangleKernel>(&self, child: Child) {
        const { assert!(size_of::<Packet>() == size_of::<WideNode>()) };
        let (nodes, packets) = (self.nodes.as_ptr(), self.packets.as_ptr());
        let first: *const u8 =
            if child.as_packet().is_some() { packets.cast() } else { nodes.cast() };
        K::prefetch(first.wrapping_add(child.index() * size_of::<Packet>()));
    }

    #[inline(always)]
    fn node(&self, child: Child) -> &WideNode {
        debug_assert!((child.0 as usize) < self.nodes.len());
        // SAFETY: `Tree::new` writes only slots of nodes that it pushed, and nothing else writes.
        unsafe { self.nodes.get_unchecked(child.0 as usize) }
    }

    #[inline(always)]
    fn packet(&self, index: usize) -> &Packet {
        debug_assert!(index < self.packets.len());
        // SAFETY: `Tree::new` makes one packet of each leaf, and numbers children by their leaves.
        unsafe { self.packets.get_unchecked(index) }
    }
}

/// The child in a lane, by a jump instead of an index.
///
/// Processors guess jumps: they read the guessed child's boxes while those of its parent are still
/// being tested. Rays that resemble the ray before them become faster by a half, others slower by
/// less than a tenth.
#[inline(always)]
fn pick<K: TriangleKernel>(node: &WideNode, lane: usize) -> Child {
    macro_rules! children {
        ($($i:literal)*) => {
            match lane {
                $($i => {
                    K::branch::<$i>();
                    node.children[$i]
                })*
                _ => unreachable!("take_lane returns lanes"),
            }
        };
    }
    children!(0 1 2 3 4 5 6 7)
}

struct Stack<'a> {
    /// Borrowed: as a field of its own it would be cleared together with `top`, for every ray.
    waiting: &'a mut MaybeUninit<[Waiting; STACK]>,
    /// All below is written.
    top: usize,
}

impl Stack<'_> {
    #[inline(always)]
    fn push(&mut self, waiting: Waiting) {
        self.write(self.top, waiting);
        self.top += 1;
    }

    /// Puts `waiting` among those from `bottom` on, which are sorted.
    #[inline(always)]
    fn insert<K: TriangleKernel>(&mut self, waiting: Waiting, bottom: usize) {
        let mut place = self.top;
        while place > bottom && self.written(place - 1) < waiting {
            K::branch::<LANES>();
            let farther = self.written(place - 1);
            self.write(place, farther);
            place -= 1;
        }
        self.write(place, waiting);
        self.top += 1;
    }

    #[inline(always)]
    fn write(&mut self, place: usize, waiting: Waiting) {
        debug_assert!(place < STACK);
        // SAFETY: the tree has too few levels to fill the stack, see `STACK`.
        unsafe { self.waiting.as_mut_ptr().cast::<Waiting>().add(place).write(waiting) }
    }

    #[inline(always)]
    fn written(&self, place: usize) -> Waiting {
        // SAFETY: callers name places that were below `top`, and all these are written.
        unsafe { self.waiting.as_ptr().cast::<Waiting>().add(place).read() }
    }

    /// The nearest child that begins before `end`.
    #[inline(always)]
    fn pop_before(&mut self, end: f32) -> Option<Child> {
        while self.top > 0 {
            self.top -= 1;
            let next = self.written(self.top);
            if next.near() <= end {
                return Some(next.child());
            }
        }
        None
    }
}

#[inline(always)]
pub(super) fn take_lane(lanes: &mut u32) -> usize {
    let lane = lanes.trailing_zeros() as usize;
    *lanes &= *lanes - 1;
    // The mask has eight bits; this tells the compiler so.
    lane % LANES
}

/// A child and the distance of its box, which is at least 0 and therefore sorts by its bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Waiting(u64);

impl Waiting {
    #[inline(always)]
    fn new(near: f32, child: Child) -> Waiting {
        Waiting(u64::from(near.to_bits()) << 32 | u64::from(child.0))
    }

    #[inline(always)]
    fn near(self) -> f32 {
        f32::from_bits((self.0 >> 32) as u32)
    }

    #[inline(always)]
    fn child(self) -> Child {
        Child(self.0 as u32)
    }
}
