//! What a renderer asks: which triangle a ray meets first, and whether any hides a point.

use std::ops::ControlFlow;

use super::super::{DVec3, Hit, Ray, TriangleId};
#[cfg(target_arch = "x86_64")]
use super::avx2;
use super::bounds::FARTHEST;
use super::kernel::{Kernel, Portable, Sheared};
use super::probe::{self, Crossing, Probe};
use super::walk::{self, TreeRay};
use super::wide::Packet;
use super::{Bvh, Simd, departure};

/// The open segment of a visibility question.
#[derive(Debug, Clone, Copy)]
pub(super) struct Segment {
    ray: Ray,
    length_mm: f64,
    leaving: Option<TriangleId>,
}

impl Bvh {
    /// The nearest triangle that the ray meets, on either side, but not `leaving`. Of triangles at
    /// exactly the same distance it is that with the lower number.
    pub fn closest_hit(&self, ray: &Ray, leaving: Option<TriangleId>) -> Option<Hit> {
        match self.simd {
            Simd::Portable => self.closest_with::<Portable>(ray, leaving),
            #[cfg(target_arch = "x86_64")]
            // SAFETY: `Simd::detect` makes this variant only where the processor has the features.
            Simd::Avx2 => unsafe { avx2::closest(self, ray, leaving) },
        }
    }

    /// Whether a triangle lies strictly between `from` and `target`, of those objects for which
    /// `blocks` (one a mesh) is true. `from` is a [`super::Departure`]'s, `leaving` the triangle
    /// left.
    pub fn is_occluded(
        &self,
        from: DVec3,
        target: DVec3,
        leaving: Option<TriangleId>,
        blocks: &[bool],
    ) -> bool {
        let Some(segment) = self.segment(from, target, leaving) else { return false };
        match self.simd {
            Simd::Portable => self.occluded_with::<Portable>(&segment, blocks),
            #[cfg(target_arch = "x86_64")]
            // SAFETY: as above.
            Simd::Avx2 => unsafe { avx2::occluded(self, &segment, blocks) },
        }
    }

    #[inline(always)]
    pub(super) fn closest_with<K: Kernel>(
        &self,
        ray: &Ray,
        leaving: Option<TriangleId>,
    ) -> Option<Hit> {
        let probe = self.probe(ray)?;
        let tree_ray = TreeRay::new(&probe, &self.frame);
        let mut best: Option<(Crossing, u32)> = None;
        let mut end_mm = f64::INFINITY;
        let mut sheared = Sheared::NONE;
        self.tree.walk::<K>(&tree_ray, FARTHEST as f32, |packet| {
            let mut lanes = K::may_meet(packet, &probe, end_mm, &mut sheared);
            while lanes != 0 {
                let lane = walk::take_lane(&mut lanes);
                let triangle = packet.triangles[lane];
                if leaving != Some(TriangleId(triangle))
                    && let Some(found) = cross_lane(packet, lane, &sheared)
                    && (found.t_mm < end_mm
                        || found.t_mm == end_mm && best.is_some_and(|(_, id)| triangle < id))
                {
                    best = Some((found, triangle));
                    end_mm = found.t_mm;
                }
            }
            ControlFlow::Continue(self.frame.to_end(end_mm))
        });
        best.map(|(crossing, triangle)| Hit {
            distance_mm: crossing.t_mm + probe.advance_mm,
            u: crossing.u,
            v: crossing.v,
            triangle: TriangleId(triangle),
        })
    }

    #[inline(always)]
    pub(super) fn occluded_with<K: Kernel>(&self, segment: &Segment, blocks: &[bool]) -> bool {
        let Some(probe) = self.probe(&segment.ray) else { return false };
        let end_mm = segment.length_mm - probe.advance_mm;
        let tree_ray = TreeRay::new(&probe, &self.frame);
        let end = self.frame.to_end(end_mm);
        let mut is_hidden = false;
        let mut sheared = Sheared::NONE;
        self.tree.walk::<K>(&tree_ray, end, |packet| {
            let mut lanes = K::may_meet(packet, &probe, end_mm, &mut sheared);
            while lanes != 0 {
                let lane = walk::take_lane(&mut lanes);
                let id = TriangleId(packet.triangles[lane]);
                is_hidden = segment.leaving != Some(id)
                    && blocks[self.locate(id).0]
                    && cross_lane(packet, lane, &sheared).is_some_and(|c| c.t_mm < end_mm);
                if is_hidden {
                    return ControlFlow::Break(());
                }
            }
            ControlFlow::Continue(end)
        });
        is_hidden
    }

    /// `None` if the ray passes the scene by.
    #[inline(always)]
    pub(super) fn probe(&self, ray: &Ray) -> Option<Probe> {
        let to_center = self.frame.center - ray.origin;
        let along_mm = to_center.dot(ray.direction);
        let beside = to_center - ray.direction * along_mm;
        // The sphere, and what rounding far away may take from the distance to it.
        let reach_mm = self.frame.radius_mm * (1.0 + 1e-6)
            + 8.0 * f64::EPSILON * (along_mm.abs() + ray.origin.abs().max_element());
        // False for rays with NaN, and if there is no triangle.
        (beside.length_squared() <= reach_mm * reach_mm && along_mm >= -reach_mm)
            .then(|| Probe::new(ray, (along_mm - reach_mm).max(0.0)))
    }

    /// A little shorter than the way to `target`, so that a surface on which the target lies doesn't
    /// hide it; `None` if nothing is left.
    fn segment(&self, from: DVec3, target: DVec3, leaving: Option<TriangleId>) -> Option<Segment> {
        let path = target - from;
        let way_mm = path.length();
        let scale_mm = target.abs().max_element() + 2.0 * self.radius_mm() + way_mm;
        let length_mm = way_mm - departure::LIFT * 0.5 * f64::EPSILON * scale_mm;
        let ray = Ray { origin: from, direction: path / way_mm };
        (length_mm > 0.0).then_some(Segment { ray, length_mm, leaving })
    }
}

#[inline(always)]
fn cross_lane(packet: &Packet, lane: usize, sheared: &Sheared) -> Option<Crossing> {
    let [a, b, c] = [packet.corners[0][lane], packet.corners[1][lane], packet.corners[2][lane]];
    probe::cross([sheared.corner(a), sheared.corner(b), sheared.corner(c)])
}
