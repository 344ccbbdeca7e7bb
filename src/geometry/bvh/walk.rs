//! The way of a ray through the tree, for any kernel.

use std::mem::MaybeUninit;
use std::ops::ControlFlow;

use super::super::DVec3;
use super::binary;
use super::bounds::Frame;
use super::kernel::Kernel;
use super::probe::Probe;
use super::wide::{Child, LANES, Packet, Tree};

/// Farther than any hit in the tree's frame: origins are at most 1.5 from the center.
pub(super) const FARTHEST: f32 = 8.0;
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

/// A distance as the kernels compare it, rounded up.
#[inline(always)]
pub(super) fn to_end(t_mm: f64, frame: &Frame) -> f32 {
    let end = (t_mm * frame.per_mm) as f32;
    if end < FARTHEST { end.next_up() } else { FARTHEST }
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
        let mut stack = [MaybeUninit::<Waiting>::uninit(); STACK];
        let mut top = 0;
        loop {
            match child.as_packet() {
                Some(packet) => {
                    let packet = &self.packets[packet];
                    K::prefetch(packet);
                    match meet(packet) {
                        ControlFlow::Continue(nearer) => end = nearer,
                        ControlFlow::Break(()) => return,
                    }
                }
                None => {
                    let node = &self.nodes[child.0 as usize];
                    let (mut lanes, near) = K::enter(node, ray, end);
                    if lanes != 0 {
                        let lane = take_lane(&mut lanes);
                        let mut nearest = Waiting::new(near[lane], node.children[lane]);
                        if lanes == 0 {
                            child = nearest.child();
                            continue;
                        }
                        let bottom = top;
                        while lanes != 0 {
                            let lane = take_lane(&mut lanes);
                            let mut other = Waiting::new(near[lane], node.children[lane]);
                            if other < nearest {
                                std::mem::swap(&mut other, &mut nearest);
                            }
                            // Insertion: the farthest stays at the bottom.
                            let mut place = top;
                            while place > bottom {
                                // SAFETY: all below `top` is written.
                                let below = unsafe { stack[place - 1].assume_init() };
                                if below > other {
                                    break;
                                }
                                stack[place].write(below);
                                place -= 1;
                            }
                            stack[place].write(other);
                            top += 1;
                        }
                        child = nearest.child();
                        continue;
                    }
                }
            }
            child = loop {
                if top == 0 {
                    return;
                }
                top -= 1;
                // SAFETY: all below the former `top` is written.
                let next = unsafe { stack[top].assume_init() };
                if next.near() <= end {
                    break next.child();
                }
            };
        }
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
