//! The way of a ray through the tree, for any kernel.

use std::mem::MaybeUninit;
use std::ops::ControlFlow;

use super::super::DVec3;
use super::binary;
use super::bounds::Frame;
use super::kernel::Kernel;
use super::probe::Probe;
use super::wide::{Child, LANES, Lanes, Packet, Tree, WideNode};

/// No level of the wide tree leaves more than 7 children behind; it has at most as many levels as
/// the binary tree: `SAH_DEPTH` and then halves of at most 2³² triangles.
const STACK: usize = (LANES - 1) * (binary::SAH_DEPTH as usize + 33) + 1;

/// A probe in the tree's frame, in f32.
#[derive(Debug, Clone, Copy)]
pub(super) struct TreeRay {
    pub inverse: [f32; 3],
    pub origin_inverse: [f32; 3],
}

impl TreeRay {
    #[inline(always)]
    pub fn new(probe: &Probe, frame: &Frame) -> TreeRay {
        /// Stands for 0, so that inverses and their products stay finite. It moves a ray by less
        /// than 2⁻⁵⁰ while it crosses the scene.
        const LEAST: f32 = 1e-18;
        let origin = frame.to_frame(DVec3::from_array(probe.origin));
        let direction = probe.direction.map(|d| d as f32);
        let inverse = direction.map(|d| 1.0 / if d.abs() < LEAST { LEAST.copysign(d) } else { d });
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
    pub fn walk<K: Kernel>(
        &self,
        ray: &TreeRay,
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
                    match nearest::<K>(node, lanes, &near, &mut stack) {
                        Some(nearest) => nearest,
                        None => match stack.pop_before(end) {
                            Some(next) => next,
                            None => return,
                        },
                    }
                }
                Some(packet) => {
                    let packet = self.packet(packet);
                    K::prefetch(packet);
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

/// The nearest child entered; the others wait on the stack, the farthest lowest.
///
/// Compares with branches, which the processor guesses: it starts on the guessed child while the
/// distances are still on their way. Choosing without branches makes primary rays 7 % slower.
#[inline(always)]
fn nearest<K: Kernel>(
    node: &WideNode,
    mut lanes: u32,
    near: &Lanes,
    stack: &mut Stack<'_>,
) -> Option<Child> {
    if lanes == 0 {
        return None;
    }
    let first = take_lane(&mut lanes);
    if lanes == 0 {
        return Some(node.children[first]);
    }
    let second = take_lane(&mut lanes);
    let (a, b) = (near[first], near[second]);
    if lanes == 0 {
        if a <= b {
            K::branch();
            stack.push(Waiting::new(b, node.children[second]));
            return Some(node.children[first]);
        }
        K::branch();
        stack.push(Waiting::new(a, node.children[first]));
        return Some(node.children[second]);
    }
    let bottom = stack.top;
    stack.push(Waiting::new(a, node.children[first]));
    stack.insert::<K>(Waiting::new(b, node.children[second]), bottom);
    while lanes != 0 {
        let lane = take_lane(&mut lanes);
        stack.insert::<K>(Waiting::new(near[lane], node.children[lane]), bottom);
    }
    stack.top -= 1;
    Some(stack.written(stack.top).child())
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
    fn insert<K: Kernel>(&mut self, waiting: Waiting, bottom: usize) {
        let mut place = self.top;
        while place > bottom && self.written(place - 1) < waiting {
            K::branch();
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
