//! A box that lies wholly behind triangles that touch.
//!
//! What some triangles hide of the world, as seen from the hit, ends only at edges of theirs. From one
//! that hides the middle of the box go on to the neighbors over all edges that a way to the box may
//! meet: if there is a neighbor beyond each, no end of what they hide together lies before the box.
//! So all of it is hidden, wherever in it a segment ends. And if that holds for all triangles before a
//! box, all ways to it cross as many of them.

use super::super::DVec3;
use super::shaft::{Blocker, Pyramid};

/// Whether the blockers of a shaft hide a box, whose corners are given from the hit.
pub(super) fn holds(blockers: &[Blocker], (low, high): (DVec3, DVec3)) -> bool {
    let place = Place::new(low, high);
    let hides_middle = |blocker: &Blocker| blocker.pyramid.hides(place.middle) == Some(true);
    let mut first = (0..blockers.len()).filter(|&index| hides_middle(&blockers[index]));
    first.any(|index| place.is_behind_all_from(blockers, index))
}

/// Whether no blocker hides a place of a box.
pub(super) fn is_beside(blockers: &[Blocker], (low, high): (DVec3, DVec3)) -> bool {
    let place = Place::new(low, high);
    blockers.iter().all(|blocker| place.is_clear_of(&blocker.pyramid))
}

/// Whether all ways to a box cross the triangles alike.
pub(super) fn go_on(panes: &[Pyramid], (low, high): (DVec3, DVec3)) -> bool {
    let place = Place::new(low, high);
    let goes_on = |pane: &Pyramid| {
        let is_continued =
            |edge| panes.iter().any(|other| pane.continued_by(edge, other).is_some());
        pane.is_sure && place.is_beyond(pane) && place.edges_before(pane).all(is_continued)
    };
    panes.iter().all(goes_on)
}

/// A box seen from the hit.
struct Place {
    middle: DVec3,
    half: DVec3,
}

impl Place {
    fn new(low: DVec3, high: DVec3) -> Place {
        Place { middle: 0.5 * (low + high), half: 0.5 * (high - low) }
    }

    /// The edges of a triangle that a way to the box may pass.
    fn edges_before(&self, pyramid: &Pyramid) -> impl Iterator<Item = usize> {
        (0..3).filter(|&edge| self.may_be_met_past(pyramid, edge))
    }

    fn is_behind_all_from(&self, blockers: &[Blocker], first: usize) -> bool {
        // With the edges over which a neighbor was reached, one bit each.
        let mut reached = vec![(first, 0u8)];
        let mut next = 0;
        while let Some(&(here, known)) = reached.get(next) {
            let pyramid = &blockers[here].pyramid;
            if !(pyramid.is_sure && self.is_beyond(pyramid)) {
                return false;
            }
            for edge in self.edges_before(pyramid).filter(|edge| known >> edge & 1 == 0) {
                let continues = |(index, other): (usize, &Blocker)| {
                    Some((index, 1 << pyramid.continued_by(edge, &other.pyramid)?))
                };
                let neighbor = blockers.iter().enumerate().find_map(continues);
                let Some((neighbor, shared)) = neighbor else { return false };
                match reached.iter_mut().find(|(index, _)| *index == neighbor) {
                    Some((_, known)) => *known |= shared,
                    None => reached.push((neighbor, shared)),
                }
            }
            next += 1;
        }
        true
    }

    /// The most that a place of the box has of a direction.
    fn most(&self, direction: DVec3) -> f64 {
        direction.dot(self.middle) + self.half.dot(direction.abs())
    }

    /// Whether all of the box lies beyond the triangle's plane.
    fn is_beyond(&self, pyramid: &Pyramid) -> bool {
        pyramid.height + self.most(pyramid.normal) < -pyramid.slack_mm
    }

    /// Whether all of the box lies beside what the triangle hides, or before the triangle.
    fn is_clear_of(&self, pyramid: &Pyramid) -> bool {
        let is_past = |edge: usize| self.most(pyramid.edges[edge]) < -pyramid.slacks[edge];
        let lowest = pyramid.height - self.most(-pyramid.normal);
        pyramid.is_sure && ((0..3).any(is_past) || lowest > pyramid.slack_mm)
    }

    /// Whether a way to the box may pass an edge: some place of the box lies in the plane of the hit
    /// and the edge, between the edge's ends.
    fn may_be_met_past(&self, pyramid: &Pyramid, edge: usize) -> bool {
        let (inward, slack) = (pyramid.edges[edge], pyramid.slacks[edge]);
        if inward.dot(self.middle).abs() > self.half.dot(inward.abs()) + slack {
            return false;
        }
        let (from, to) = (pyramid.corners[edge], pyramid.corners[(edge + 1) % 3]);
        let across = from.cross(to);
        let far = 2.0 * pyramid.slack_mm * (self.middle.abs() + self.half).max_element();
        // In the plane, from each end toward the other.
        [(across.cross(from), from), (to.cross(across), to)].into_iter().all(|(toward, end)| {
            // As far as moving the hit by the slack turns the plane and the end.
            let slack = slack * end.length() + far * across.length();
            self.most(toward) >= -slack
        })
    }
}

impl Pyramid {
    /// The edge of another triangle that is this one's, if that lies on its other side.
    #[inline]
    fn continued_by(&self, edge: usize, other: &Pyramid) -> Option<usize> {
        let after = |corner: usize| (corner + 1) % 3;
        let (from, to) = (self.corners[edge], self.corners[after(edge)]);
        let at = other.corners.iter().position(|corner| *corner == from)?;
        let shared = match to {
            to if to == other.corners[after(at)] => at,
            to if to == other.corners[after(after(at))] => after(after(at)),
            _ => return None,
        };
        (self.edges[edge].dot(other.edges[shared]) < 0.0).then_some(shared)
    }
}
