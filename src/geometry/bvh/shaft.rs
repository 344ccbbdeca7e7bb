//! What may stand between a hit and a box of places, asked once for all segments between them.
//!
//! At the share t of the way from the hit to any place of the box, all these segments lie in a box
//! that grows in proportion to t. So a node is left out by a slab test whose planes have a speed
//! each: `[P + t·low, P + t·high]` meets `[node low, node high]` on all three axes at some t. Of the
//! packets that are left, a triangle is left out if a plane parts it from the segments: that of the
//! hit, its own, or one through the hit and an edge. The same planes say of most segments whether
//! the triangle hides their ends; of the others the ray's own test does.

use std::array;
use std::cell::Cell;

use super::super::{DVec3, TriangleId};
#[cfg(target_arch = "x86_64")]
use super::avx2;
use super::bounds::PAD;
use super::departure::LIFT;
use super::umbra;
use super::walk::{LEAST_DIRECTION, take_lane};
use super::wide::{CORNERS, LANES, Packet, Tree, WideNode};
use super::{Bvh, Departure};
#[cfg(target_arch = "x86_64")]
use crate::simd::Simd;

/// Shafts in which more packets may stand are given up: asking them would cost as much as walks.
const MOST_PACKETS: usize = 16;

/// The same for nodes entered. A lamp's reflector seen from its bulb takes about ten.
const MOST_NODES: usize = 64;

/// The triangles that can meet a segment from a hit to a box.
#[derive(Debug, Clone)]
pub struct Shaft {
    /// Corners of the box, mm.
    low: DVec3,
    high: DVec3,
    /// The hit.
    point: DVec3,
    candidates: Vec<Candidate>,
    blockers: Vec<Blocker>,
    /// Of the candidates that do not block.
    panes: Vec<Pyramid>,
    /// The blocker that hid a place last is asked first: neighbors hide neighbors.
    last: Cell<usize>,
}

/// Triangles of a packet, one bit each.
#[derive(Debug, Clone, Copy)]
pub(super) struct Candidate {
    packet: usize,
    lanes: u32,
}

impl Candidate {
    #[inline(always)]
    pub(super) fn packet(self, tree: &Tree) -> (&Packet, u32) {
        (&tree.packets[self.packet], self.lanes)
    }
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Blocker {
    triangle: Candidate,
    pub pyramid: Pyramid,
}

/// What a triangle does in a shaft.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Segments pass it.
    None,
    /// [`Bvh::hits_among`] counts it.
    Counts,
    /// It hides what lies behind.
    Blocks,
}

impl Shaft {
    /// Whether the shaft says what stands before this place.
    pub fn holds(&self, target: DVec3) -> bool {
        target.cmpge(self.low).all() && target.cmple(self.high).all()
    }

    /// Whether nothing in it blocks.
    pub fn is_free(&self) -> bool {
        self.blockers.is_empty()
    }

    /// The same for the places of the box that are in a ball: `None` where a blocker ends before it.
    pub fn hides_ball(&self, center: DVec3, radius: f64) -> Option<bool> {
        let (low, high) = (center - DVec3::splat(radius), center + DVec3::splat(radius));
        let ball = (low.max(self.low) - self.point, high.min(self.high) - self.point);
        match umbra::is_beside(&self.blockers, ball) {
            true => Some(false),
            false => umbra::holds(&self.blockers, ball).then_some(true),
        }
    }

    /// Whether all ways to the box cross what counts and does not block alike, for sure: as often, and in
    /// the same order if it is of one object that does not cross itself.
    pub fn crosses_alike(&self) -> bool {
        umbra::go_on(&self.panes, (self.low - self.point, self.high - self.point))
    }

    /// Whether what blocks hides all places of the box for sure; of a box that is seen, or whose
    /// blockers only look closed, it may not tell.
    pub fn hides_all(&self) -> bool {
        umbra::holds(&self.blockers, (self.low - self.point, self.high - self.point))
    }

    pub(super) fn candidates(&self) -> &[Candidate] {
        &self.candidates
    }
}

impl Bvh {
    /// What may meet segments from a hit to places in the box `low` to `high`, mm, of the objects
    /// that have a role, without the triangle left.
    ///
    /// `None` where so much may that a shaft does not pay. It leaves out only what
    /// [`Bvh::is_occluded`] and [`Bvh::hits_up_to`] would not meet either.
    pub fn shaft(
        &self,
        from: &Departure,
        leaving: TriangleId,
        (low, high): (DVec3, DVec3),
        role: impl Fn(usize) -> Role,
    ) -> Option<Shaft> {
        let shaft = Shaft {
            low,
            high,
            point: from.point,
            candidates: Vec::with_capacity(MOST_PACKETS + 1),
            blockers: Vec::with_capacity(16),
            panes: Vec::new(),
            last: Cell::new(0),
        };
        if self.tree.root.is_none() {
            return Some(shaft);
        }
        let sides = Sides::new(self, from, low, high);
        let slabs = Slabs::new(self, &sides, low, high)?;
        match self.simd {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: `Simd` names these variants only where the processor has the features.
            Simd::Avx2 | Simd::Avx512 => unsafe {
                avx2::gather_shaft(self, (&slabs, &sides), leaving, role, shaft)
            },
            _ => self.gather((&slabs, &sides), leaving, role, shaft),
        }
    }

    /// Fills a shaft.
    #[inline(always)]
    pub(super) fn gather(
        &self,
        (slabs, sides): (&Slabs, &Sides),
        leaving: TriangleId,
        role: impl Fn(usize) -> Role,
        mut shaft: Shaft,
    ) -> Option<Shaft> {
        let mut child = self.tree.root?;
        let mut waiting = Vec::with_capacity(LANES * MOST_NODES);
        let mut nodes = 0;
        loop {
            if let Some(packet) = child.as_packet() {
                self.take(packet, leaving, (sides, &role), &mut shaft);
            } else {
                let node = &self.tree.nodes[child.index()];
                let mut lanes = slabs.entered(node);
                while lanes != 0 {
                    waiting.push(node.children[take_lane(&mut lanes)]);
                }
                nodes += 1;
            }
            if shaft.candidates.len() > MOST_PACKETS || nodes > MOST_NODES {
                return None;
            }
            match waiting.pop() {
                Some(next) => child = next,
                None => return Some(shaft),
            }
        }
    }

    /// Adds the triangles of a packet that no plane parts from the segments.
    #[inline(always)]
    fn take(
        &self,
        packet_index: usize,
        leaving: TriangleId,
        (sides, role): (&Sides, &impl Fn(usize) -> Role),
        shaft: &mut Shaft,
    ) {
        let packet = &self.tree.packets[packet_index];
        let under = sides.corners_under_the_hit(packet);
        let (mut asked, mut kept) = (u32::from(packet.present) & !sides.parted(packet), 0);
        while asked != 0 {
            let lane = take_lane(&mut asked);
            let triangle = TriangleId(packet.triangles[lane]);
            let is_under = packet.corners.iter().all(|c| under >> c[lane] & 1 == 1);
            if triangle == leaving || is_under {
                continue;
            }
            let role = role(self.locate(triangle).0);
            if role == Role::None {
                continue;
            }
            if let Some(pyramid) = sides.pyramid(corners(packet, lane)) {
                kept |= 1 << lane;
                if role == Role::Blocks {
                    let triangle = Candidate { packet: packet_index, lanes: 1 << lane };
                    shaft.blockers.push(Blocker { triangle, pyramid });
                } else {
                    shaft.panes.push(pyramid);
                }
            }
        }
        if kept != 0 {
            shaft.candidates.push(Candidate { packet: packet_index, lanes: kept });
        }
    }

    /// The objects that stand in a shaft, some more than once.
    pub fn objects_in<'a>(&'a self, shaft: &'a Shaft) -> impl Iterator<Item = usize> + 'a {
        shaft.candidates.iter().flat_map(|candidate| {
            let (packet, kept) = candidate.packet(&self.tree);
            let lanes = (0..LANES).filter(move |lane| kept >> lane & 1 == 1);
            lanes.map(|lane| self.locate(TriangleId(packet.triangles[lane])).0)
        })
    }

    /// [`Bvh::is_occluded`] for a place that the shaft holds.
    pub fn is_occluded_in(
        &self,
        shaft: &Shaft,
        (from, target): (DVec3, DVec3),
        leaving: TriangleId,
    ) -> bool {
        let way = target - shaft.point;
        let hides = |blocker: &Blocker| match blocker.pyramid.hides(way) {
            Some(hides) => hides,
            None => self.is_occluded_by(blocker.triangle, (from, target), leaving),
        };
        let last = shaft.last.get();
        if shaft.blockers.get(last).is_some_and(hides) {
            return true;
        }
        let found = shaft.blockers.iter().position(hides);
        shaft.last.set(found.unwrap_or(last));
        found.is_some()
    }
}

fn corners(packet: &Packet, lane: usize) -> [DVec3; 3] {
    packet.corners.map(|corners| {
        let place = usize::from(corners[lane]) % CORNERS;
        DVec3::from_array(packet.positions.map(|axis| axis[place]))
    })
}

/// The shaft as nodes are tested against it, in the tree's frame.
pub(super) struct Slabs {
    /// In the order of [`WideNode::planes`]: 1/speed of the shaft's opposite face, and P over it.
    inverse: [f32; 6],
    origin_inverse: [f32; 6],
    /// Whether t is at least what the plane says, or at most.
    is_least: [bool; 6],
    /// The hit's normal to the box's side, 0 if that is not clear, and P along it. Rounding takes
    /// less of a height than the pad of boxes gives.
    normal: [f32; 3],
    height: f32,
}

impl Slabs {
    /// Widened by the pad of boxes, which covers the rounding of coordinates up to 2: `None` beyond.
    fn new(bvh: &Bvh, sides: &Sides, low: DVec3, high: DVec3) -> Option<Slabs> {
        let pad = f64::from(PAD);
        let to_frame = |p: DVec3| (p - bvh.frame.center) * bvh.frame.per_mm;
        let (point, low, high) = (to_frame(sides.point), to_frame(low), to_frame(high));
        let is_near = |p: DVec3| p.abs().max_element() <= 2.0; // false for NaN
        if !(is_near(point) && is_near(low) && is_near(high)) {
            return None;
        }
        let normal = sides.normal * sides.side;
        let mut slabs = Slabs {
            inverse: [0.0; 6],
            origin_inverse: [0.0; 6],
            is_least: [false; 6],
            normal: normal.as_vec3().into(),
            height: normal.dot(point) as f32,
        };
        for plane in 0..6 {
            let axis = plane / 2;
            // A node's low plane stops the shaft's high face, its high plane the low face.
            let is_low = plane % 2 == 0;
            let (end, outward) = if is_low { (high, pad) } else { (low, -pad) };
            let speed = (end[axis] - point[axis] + outward) as f32;
            let still = if is_low { LEAST_DIRECTION } else { -LEAST_DIRECTION };
            let inverse = 1.0 / if speed.abs() < LEAST_DIRECTION { still } else { speed };
            slabs.inverse[plane] = inverse;
            slabs.origin_inverse[plane] = (point[axis] + outward) as f32 * inverse;
            slabs.is_least[plane] = (inverse > 0.0) == is_low;
        }
        Some(slabs)
    }

    /// Which children of a node the shaft meets.
    #[inline(always)]
    fn entered(&self, node: &WideNode) -> u32 {
        /// A little past the box.
        const END: f32 = 1.0 + PAD;
        let (mut near, mut far) = ([0.0f32; LANES], [END; LANES]);
        for plane in 0..6 {
            let (inverse, origin) = (self.inverse[plane], self.origin_inverse[plane]);
            let at: [f32; LANES] =
                array::from_fn(|lane| node.planes[plane][lane] * inverse - origin);
            if self.is_least[plane] {
                near = array::from_fn(|i| if at[i] > near[i] { at[i] } else { near[i] });
            } else {
                far = array::from_fn(|i| if at[i] < far[i] { at[i] } else { far[i] });
            }
        }
        let mut top = [-self.height; LANES];
        for axis in 0..3 {
            let n = self.normal[axis];
            let plane = &node.planes[2 * axis + usize::from(n > 0.0)];
            top = array::from_fn(|lane| top[lane] + n * plane[lane]);
        }
        let meets = |i: usize| (near[i] <= far[i]) & (top[i] >= 0.0);
        (0..LANES).fold(0, |bits, lane| bits | u32::from(meets(lane)) << lane)
    }
}

/// The shaft as triangles are tested against it, in f64.
///
/// Segments start one lift over the hit's plane or under it, and up to 64² lifts beside the hit.
pub(super) struct Sides {
    /// The hit, and where segments to either side of its plane start.
    point: DVec3,
    starts: [DVec3; 2],
    normal: DVec3,
    /// +1 or −1 if all of the box lies clearly on that side of the hit's plane, else 0.
    side: f64,
    /// Middle of the box from the hit, and half its size, mm.
    middle: DVec3,
    half: DVec3,
    lift_mm: f64,
    /// More than what starts and rounding move a plane by.
    slack_mm: f64,
}

impl Sides {
    fn new(bvh: &Bvh, from: &Departure, low: DVec3, high: DVec3) -> Sides {
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        let scale_mm = from.point.abs().max_element() + 2.0 * bvh.radius_mm();
        let (point, normal) = (from.point, from.n_geom);
        let slack_mm = 1e-9 * (scale_mm + middle.abs().max_element() + half.max_element());
        let height = (middle - point).dot(normal);
        let is_clear = height.abs() - half.dot(normal.abs()) > slack_mm;
        let starts = match is_clear {
            true => [from.toward(normal * height); 2],
            false => [from.toward(normal), from.toward(-normal)],
        };
        Sides {
            point,
            starts,
            normal,
            side: if is_clear { height.signum() } else { 0.0 },
            middle: middle - point,
            half,
            lift_mm: LIFT * (0.5 * f64::EPSILON) * scale_mm,
            slack_mm,
        }
    }

    /// The corners of a packet on the hit's plane or on the side without the box, one bit each.
    ///
    /// A quarter of a lift covers the rounding of the hit and of the corners' heights, and leaves
    /// half of one, under which the ray's test may see a neighbor.
    #[inline(always)]
    fn corners_under_the_hit(&self, packet: &Packet) -> u32 {
        if self.side == 0.0 {
            return 0;
        }
        let n = self.normal * self.side;
        let [xs, ys, zs] = &packet.positions;
        let height: [f64; CORNERS] = array::from_fn(|i| {
            let [x, y, z] = [xs[i] - self.point.x, ys[i] - self.point.y, zs[i] - self.point.z];
            n.x * x + n.y * y + n.z * z
        });
        let most = 0.25 * self.lift_mm;
        (0..CORNERS).fold(0, |bits, i| bits | u32::from(height[i] <= most) << i)
    }

    /// Triangles that the plane of an edge parts from all segments, one bit each; none of slivers, whose
    /// edges have no sure side. All lanes at once.
    #[inline(always)]
    fn parted(&self, packet: &Packet) -> u32 {
        let mut corners = [[[0.0; LANES]; 3]; 3];
        for (corner, places) in corners.iter_mut().zip(&packet.corners) {
            for (axis, values) in corner.iter_mut().enumerate() {
                for (value, &place) in values.iter_mut().zip(places) {
                    *value =
                        packet.positions[axis][usize::from(place) % CORNERS] - self.point[axis];
                }
            }
        }
        let (far, middle, half) = (self.far(), self.middle, self.half);
        let mut parted = [false; LANES];
        for i in 0..LANES {
            let at =
                |corner: usize| DVec3::from_array(corners[corner].each_ref().map(|axis| axis[i]));
            let (a, b, c) = (at(0), at(1), at(2));
            let (of_a, of_b, of_c) = (far * a.length(), far * b.length(), far * c.length());
            let (ab, bc, ca) = (a.cross(b), b.cross(c), c.cross(a));
            let volume = ab.dot(c);
            let is_past = |normal: DVec3, slack: f64| {
                let at = volume.signum() * normal.dot(middle);
                (volume.abs() > slack, at + half.dot(normal.abs()) < -slack)
            };
            let (turned_ab, past_ab) = is_past(ab, of_a + of_b);
            let (turned_bc, past_bc) = is_past(bc, of_b + of_c);
            let (turned_ca, past_ca) = is_past(ca, of_c + of_a);
            parted[i] = (turned_ab & turned_bc & turned_ca) & (past_ab | past_bc | past_ca);
        }
        (0..LANES).fold(0, |bits, i| bits | u32::from(parted[i]) << i)
    }

    /// How far moving the start by the slack moves the end of a segment, times its length.
    #[inline(always)]
    fn far(&self) -> f64 {
        2.0 * self.slack_mm * (self.middle.abs() + self.half).max_element()
    }

    /// What a triangle hides; `None` if its own plane parts it from all segments.
    #[inline(always)]
    fn pyramid(&self, corners: [DVec3; 3]) -> Option<Pyramid> {
        let [a, b, c] = corners.map(|corner| corner - self.point);
        let lengths = [a, b, c].map(|corner| self.far() * corner.length());
        // Moving the start by the slack turns an edge's plane by that over the edge's distance.
        let slacks = [lengths[0] + lengths[1], lengths[1] + lengths[2], lengths[2] + lengths[0]];
        let volume = a.cross(b).dot(c);
        // Of a sliver, or one seen edge-on, no side of an edge is sure to be inside.
        let is_turned = volume.abs() > slacks[0].max(slacks[1]).max(slacks[2]);
        let edges = [a.cross(b), b.cross(c), c.cross(a)].map(|n| n * volume.signum());
        let across = (b - a).cross(c - a);
        let normal = across / across.length();
        let of_starts = self.starts.map(|start| (start - corners[0]).dot(normal));
        let above = of_starts[0].signum();
        let (normal, of_starts) = (above * normal, of_starts.map(|height| above * height));
        let height = -normal.dot(a);
        let least = of_starts[0].min(of_starts[1]);
        let lowest = height + normal.dot(self.middle) - self.half.dot(normal.abs());
        if lowest > self.slack_mm && least >= 0.5 * self.lift_mm {
            return None;
        }
        let is_sure = is_turned && least > self.slack_mm;
        let corners = [a, b, c];
        Some(Pyramid { corners, edges, slacks, normal, height, slack_mm: self.slack_mm, is_sure })
    }
}

/// The hit and a triangle: what lies in the pyramid beyond the triangle is hidden.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pyramid {
    /// Of the triangle, from the hit, mm.
    pub corners: [DVec3; 3],
    /// Normals of the planes through the hit and an edge, inward, not unit. The first edge leads from
    /// the first corner to the second, and so on.
    pub edges: [DVec3; 3],
    pub slacks: [f64; 3],
    /// Unit, on the hit's side.
    pub normal: DVec3,
    /// Of the hit over the triangle's plane, mm.
    pub height: f64,
    pub slack_mm: f64,
    /// False for slivers, and where the hit lies in the triangle's plane.
    pub is_sure: bool,
}

impl Pyramid {
    /// Whether the triangle hides a place, from the way there; `None` where rounding decides.
    #[inline(always)]
    pub fn hides(&self, way: DVec3) -> Option<bool> {
        if !self.is_sure {
            return None;
        }
        let beyond = -(self.height + self.normal.dot(way));
        let at = self.edges.map(|edge| edge.dot(way));
        if beyond < -self.slack_mm || (0..3).any(|i| at[i] < -self.slacks[i]) {
            return Some(false);
        }
        (beyond > self.slack_mm && (0..3).all(|i| at[i] > self.slacks[i])).then_some(true)
    }
}
