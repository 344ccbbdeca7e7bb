//! What a renderer asks: which triangle a ray meets first, and whether any hides a point.

use std::ops::ControlFlow;

use super::super::{DVec3, Hit, Ray, TriangleId};
#[cfg(target_arch = "x86_64")]
use super::avx2;
use super::bounds::FARTHEST;
use super::kernel::{Aim, Portable, TriangleKernel, to_end_mm};
use super::probe::{Crossing, Probe};
use super::shaft::{Candidate, Shaft};
use super::walk;
use super::wide::{NO_TRIANGLE, Packet};
use super::{Bvh, departure};
#[cfg(target_arch = "x86_64")]
use crate::simd::Simd;

/// The open segment of a visibility question.
#[derive(Debug, Clone, Copy)]
pub(super) struct Segment {
    ray: Ray,
    length_mm: f64,
    leaving: Option<TriangleId>,
}

/// The nearest triangle that a ray meets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FirstHit {
    /// Where it meets it.
    pub hit: Hit,
    /// Whether it meets others that near behind it, see [`Bvh::hits_up_to`].
    pub has_company: bool,
}

#[inline(always)]
fn hit(Crossing { t_mm, u, v }: Crossing, triangle: TriangleId, probe: &Probe) -> Hit {
    Hit { distance_mm: t_mm + probe.advance_mm, u, v, triangle }
}

/// Adds what the probe meets of the asked triangles of a packet.
#[inline(always)]
fn take_hits<K: TriangleKernel>(
    (packet, asked): (&Packet, u32),
    ray: &K::Ray,
    (aim, end_mm): (&Aim, f64),
    hits: &mut Vec<Hit>,
) {
    let mut lanes = K::may_meet(packet, ray, aim) & asked;
    while lanes != 0 {
        let lane = walk::take_lane(&mut lanes);
        let found = K::cross(packet, lane, aim.probe).filter(|c| c.t_mm <= end_mm);
        let triangle = TriangleId(packet.triangles[lane]);
        hits.extend(found.map(|crossing| hit(crossing, triangle, aim.probe)));
    }
}

impl Bvh {
    /// The nearest triangle that the ray meets, on either side, but not `leaving`. Of triangles at
    /// exactly the same distance it is that with the lower number.
    pub fn closest_hit(&self, ray: &Ray, leaving: Option<TriangleId>) -> Option<Hit> {
        self.first_hit(ray, leaving, 0.0).map(|first| first.hit)
    }

    /// The same, and whether the ray meets other triangles up to `reach_mm` (≥ 0) behind it.
    #[inline]
    pub fn first_hit(
        &self,
        ray: &Ray,
        leaving: Option<TriangleId>,
        reach_mm: f64,
    ) -> Option<FirstHit> {
        match self.simd {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: `Simd` names these variants only where the processor has the features.
            Simd::Avx2 | Simd::Avx512 => unsafe { avx2::closest(self, ray, leaving, reach_mm) },
            _ => self.closest_with::<Portable>(ray, leaving, reach_mm),
        }
    }

    /// All triangles that the ray meets up to `end_mm`, but not `leaving`: the nearest first, and of
    /// those at exactly the same distance that with the lower number first.
    pub fn hits_up_to(&self, ray: &Ray, leaving: Option<TriangleId>, end_mm: f64) -> Vec<Hit> {
        self.hits_among(ray, leaving, end_mm, None)
    }

    /// The same of the triangles in a shaft that holds the ray up to `end_mm`.
    pub fn hits_among(
        &self,
        ray: &Ray,
        leaving: Option<TriangleId>,
        end_mm: f64,
        shaft: Option<&Shaft>,
    ) -> Vec<Hit> {
        let mut hits = match self.simd {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: as above.
            Simd::Avx2 | Simd::Avx512 => unsafe { avx2::hits(self, ray, leaving, end_mm, shaft) },
            _ => self.hits_with::<Portable>(ray, leaving, end_mm, shaft),
        };
        let place = |hit: &Hit| (hit.distance_mm, hit.triangle);
        hits.sort_by(|a, b| place(a).partial_cmp(&place(b)).expect("distances are finite"));
        hits
    }

    #[inline(always)]
    pub(super) fn hits_with<K: TriangleKernel>(
        &self,
        ray: &Ray,
        leaving: Option<TriangleId>,
        end_mm: f64,
        shaft: Option<&Shaft>,
    ) -> Vec<Hit> {
        let Some(probe) = self.probe(ray) else { return Vec::new() };
        let tree_ray = K::aim(&probe, &ray.direction, &self.frame);
        let end = end_mm - probe.advance_mm;
        let leaving = leaving.map_or(NO_TRIANGLE, |triangle| triangle.0);
        let aim = Aim { probe: &probe, leaving, end_mm: to_end_mm(end) };
        let mut hits = Vec::new();
        // Written out twice: a closure that both used would not be compiled for the kernel.
        if let Some(shaft) = shaft {
            for candidate in shaft.candidates() {
                let asked = candidate.packet(&self.tree);
                take_hits::<K>(asked, &tree_ray, (&aim, end), &mut hits);
            }
            return hits;
        }
        let end_in_frame = self.frame.to_end(end);
        self.tree.walk::<K>(&tree_ray, end_in_frame, |packet| {
            take_hits::<K>((packet, u32::MAX), &tree_ray, (&aim, end), &mut hits);
            ControlFlow::Continue(end_in_frame)
        });
        hits
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
            #[cfg(target_arch = "x86_64")]
            // SAFETY: as above.
            Simd::Avx2 | Simd::Avx512 => unsafe { avx2::occluded(self, &segment, blocks) },
            _ => self.occluded_with::<Portable>(&segment, blocks),
        }
    }

    /// The same of some triangles of one packet, all of which block.
    pub(super) fn is_occluded_by(
        &self,
        triangles: Candidate,
        (from, target): (DVec3, DVec3),
        leaving: TriangleId,
    ) -> bool {
        let Some(segment) = self.segment(from, target, Some(leaving)) else { return false };
        let Some(probe) = self.probe(&segment.ray) else { return false };
        let end_mm = segment.length_mm - probe.advance_mm;
        let (packet, mut lanes) = triangles.packet(&self.tree);
        while lanes != 0 {
            let found = probe.cross_lane(packet, walk::take_lane(&mut lanes));
            if found.is_some_and(|crossing| crossing.t_mm < end_mm) {
                return true;
            }
        }
        false
    }

    #[inline(always)]
    pub(super) fn closest_with<K: TriangleKernel>(
        &self,
        ray: &Ray,
        leaving: Option<TriangleId>,
        reach_mm: f64,
    ) -> Option<FirstHit> {
        let probe = self.probe(ray)?;
        let tree_ray = K::aim(&probe, &ray.direction, &self.frame);
        let leaving = leaving.map_or(NO_TRIANGLE, |triangle| triangle.0);
        let mut best = Crossing { t_mm: f64::INFINITY, u: 0.0, v: 0.0 };
        let mut best_triangle = NO_TRIANGLE;
        let mut has_company = false;
        let mut end = FARTHEST as f32;
        let mut end_mm = f32::INFINITY;
        self.tree.walk::<K>(&tree_ray, end, |packet| {
            let aim = Aim { probe: &probe, leaving, end_mm };
            let mut lanes = K::may_meet(packet, &tree_ray, &aim);
            while lanes != 0 {
                let lane = walk::take_lane(&mut lanes);
                let triangle = packet.triangles[lane];
                if let Some(found) = K::cross(packet, lane, &probe)
                    && found.t_mm <= best.t_mm + reach_mm
                {
                    let is_first = found.t_mm < best.t_mm
                        || found.t_mm == best.t_mm && triangle < best_triangle;
                    // Company that is farther than the new one's reach is forgotten.
                    has_company = !is_first || best.t_mm - found.t_mm <= reach_mm;
                    if is_first {
                        best = found;
                        best_triangle = triangle;
                        end = self.frame.to_end(found.t_mm + reach_mm);
                        end_mm = to_end_mm(found.t_mm + reach_mm);
                    }
                }
            }
            ControlFlow::Continue(end)
        });
        (best_triangle != NO_TRIANGLE)
            .then(|| FirstHit { hit: hit(best, TriangleId(best_triangle), &probe), has_company })
    }

    #[inline(always)]
    pub(super) fn occluded_with<K: TriangleKernel>(
        &self,
        segment: &Segment,
        blocks: &[bool],
    ) -> bool {
        let Some(probe) = self.probe(&segment.ray) else { return false };
        let end_mm = segment.length_mm - probe.advance_mm;
        let tree_ray = K::aim(&probe, &segment.ray.direction, &self.frame);
        let end = self.frame.to_end(end_mm);
        let aim = Aim {
            probe: &probe,
            leaving: segment.leaving.map_or(NO_TRIANGLE, |triangle| triangle.0),
            end_mm: to_end_mm(end_mm),
        };
        let mut is_hidden = false;
        self.tree.walk::<K>(&tree_ray, end, |packet| {
            let mut lanes = K::may_meet(packet, &tree_ray, &aim);
            while lanes != 0 {
                let lane = walk::take_lane(&mut lanes);
                let id = TriangleId(packet.triangles[lane]);
                is_hidden = blocks[self.locate(id).0]
                    && K::cross(packet, lane, &probe).is_some_and(|c| c.t_mm < end_mm);
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
        let away = ray.origin - self.frame.center;
        if away.length_squared() <= self.frame.limit_mm2 {
            // NaN and infinities only in the direction.
            let is_finite = ray.direction.length_squared() < 2.0;
            return is_finite.then(|| Probe::new(ray.origin, &ray.direction, 0.0));
        }
        self.probe_from_afar(ray)
    }

    /// Moves the origin of a ray toward the scene.
    #[inline(always)]
    fn probe_from_afar(&self, ray: &Ray) -> Option<Probe> {
        let frame = &self.frame;
        let along_mm = (frame.center - ray.origin).dot(ray.direction);
        // Rounding far away may take a few ε of the distance.
        let reach_mm = frame.reach_mm + 8.0 * f64::EPSILON * along_mm.abs();
        let advance_mm = (along_mm - reach_mm).max(0.0);
        let origin = ray.origin + ray.direction * advance_mm;
        let is_near = (origin - frame.center).length_squared() <= frame.limit_mm2;
        // False for rays with NaN, and if there is no triangle.
        is_near.then(|| Probe::new(origin, &ray.direction, advance_mm))
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
