//! All surfaces that a ray meets in one place, as one interface (model.md, "Bodies").

use super::media::Media;
use super::walk::{Branch, EmitterPoint, Facing, Leaving, SurfacePoint};
use super::{TraceState, Tracer};
use crate::geometry::{DVec3, FirstHit, Hit, Ray, TriangleId};
use crate::scene::{MaterialId, SurfaceKind};

/// What a ray finds where it meets surfaces.
// One at a time, never in a list: a box would cost more than the room.
#[allow(clippy::large_enum_variant)]
pub(super) enum Interface {
    /// Nothing that changes its way: bonded bodies, or bodies that a stronger one fills.
    Passed { far: Leaving, after: Media },
    /// A surface that is shaded.
    Met(SurfacePoint),
    /// A light's, which counts before all else.
    Emitter(EmitterPoint),
}

/// One of the surfaces.
#[derive(Clone, Copy)]
pub(super) struct Met {
    pub hit: Hit,
    pub object: usize,
    pub kind: SurfaceKind,
    facing: Facing,
}

impl Tracer<'_> {
    pub(super) fn interface(
        &self,
        branch: &Branch,
        first: FirstHit,
        state: &mut TraceState,
    ) -> Interface {
        let met = self.met(&branch.ray, first.hit);
        if !first.has_company {
            return self.interface_of(&[met], branch, state);
        }
        self.interface_of(&self.company(branch, met), branch, state)
    }

    /// What lies in one place with the first hit, in the order along the ray.
    fn company(&self, branch: &Branch, first: Met) -> Vec<Met> {
        let surfaces = &self.prepared.surfaces;
        let ray = &branch.ray;
        let end_mm = first.hit.distance_mm + surfaces.reach_mm;
        let hits = self.prepared.bvh.hits_up_to(ray, branch.leaving, end_mm);
        let is_there = |other: &Met| self.share_place(ray, &first, other);
        hits.into_iter().map(|hit| self.met(ray, hit)).filter(is_there).collect()
    }

    /// Whether `other`, behind `first`, is part of the same interface.
    pub(super) fn share_place(&self, ray: &Ray, first: &Met, other: &Met) -> bool {
        let surfaces = &self.prepared.surfaces;
        let cos = |hit: &Hit| self.prepared.bvh.departure(hit).n_geom.dot(ray.direction).abs();
        let gap_mm = other.hit.distance_mm - first.hit.distance_mm;
        let (first_cos, is_other) = (cos(&first.hit), other.object != first.object);
        gap_mm * first_cos.min(cos(&other.hit)) <= surfaces.place_mm
            || is_other && gap_mm * first_cos <= surfaces.contact_mm
    }

    #[inline]
    pub(super) fn met(&self, ray: &Ray, hit: Hit) -> Met {
        let object = self.prepared.bvh.locate(hit.triangle).0;
        let surfaces = &self.prepared.surfaces.of_object;
        // The meshes of emitters lie behind the objects'.
        let kind = surfaces.get(object).map_or(SurfaceKind::Emitter, |surface| surface.kind);
        let [a, b, c] = self.prepared.bvh.corners(hit.triangle);
        let is_back = (b - a).cross(c - a).dot(ray.direction) > 0.0;
        let facing = if is_back { Facing::Back } else { Facing::Front };
        Met { hit, object, kind, facing }
    }

    fn interface_of(&self, all: &[Met], branch: &Branch, state: &mut TraceState) -> Interface {
        if let Some(emitter) = all.iter().find(|met| met.kind == SurfaceKind::Emitter) {
            return Interface::Emitter(self.emitter_point(&branch.ray, emitter));
        }
        if let Some(opaque) = self.opaque(all, state) {
            let before = self.medium_material(&branch.media);
            let indices = [before, Some(self.material(opaque.object))];
            let surface = self.surface_point(&branch.ray, all, &opaque);
            return Interface::Met(SurfacePoint { indices, ..surface });
        }
        let after = self.media_after(all, &branch.media);
        match self.boundary(all, [&branch.media, &after]) {
            Some((seen, facing, indices)) => {
                let surface = self.surface_point(&branch.ray, all, &seen);
                let material = surface.material;
                let filters = sheets_beside(all, &seen).map(|object| self.material(object));
                let filters = filters.collect();
                Interface::Met(SurfacePoint {
                    facing,
                    indices,
                    after,
                    filters,
                    material,
                    ..surface
                })
            }
            None => Interface::Passed { far: self.leaving(&all[all.len() - 1].hit), after },
        }
    }

    fn emitter_point(&self, ray: &Ray, met: &Met) -> EmitterPoint {
        EmitterPoint {
            emitter: met.object - self.prepared.scene.objects.len(),
            triangle: met.hit.triangle,
            departure: self.prepared.bvh.departure(&met.hit),
            view: -ray.direction,
        }
    }

    /// The opaque surface that counts: one that faces the ray, and of several the lowest object.
    fn opaque(&self, all: &[Met], state: &mut TraceState) -> Option<Met> {
        let mut opaque = all.iter().filter(|met| met.kind == SurfaceKind::Opaque);
        let mut best = *opaque.next()?;
        for other in opaque {
            let order = |met: &Met| (met.facing == Facing::Back, met.object);
            if other.object == best.object {
                continue;
            }
            if other.facing == best.facing {
                let [a, b] = [best.object.min(other.object), best.object.max(other.object)];
                let pair = Some([a, b]);
                state.counts.clash = [state.counts.clash, pair].into_iter().flatten().min();
            }
            if order(other) < order(&best) {
                best = *other;
            }
        }
        Some(best)
    }

    /// Every change applied: bodies are left, then entered, the largest first.
    pub(super) fn media_after(&self, all: &[Met], before: &Media) -> Media {
        let mut after = before.clone();
        let surfaces = &self.prepared.surfaces.of_object;
        let mut entered: Vec<usize> = Vec::new();
        for (at, met) in all.iter().enumerate() {
            let is_known = all[..at].iter().any(|other| other.object == met.object);
            match met.kind {
                SurfaceKind::Body if !is_known => match net_crossing(all, met.object) {
                    1.. => entered.push(met.object),
                    0 => {}
                    _ => after.leave(met.object),
                },
                SurfaceKind::Sheet => {
                    let material = &self.prepared.scene.materials[surfaces[met.object].material.0];
                    if material.thickness_mm.is_some() {
                        after.leave_sheets(self.prepared);
                        if met.facing == Facing::Front {
                            after.enter(met.object);
                        }
                    }
                }
                SurfaceKind::Body | SurfaceKind::Opaque | SurfaceKind::Emitter => {}
            }
        }
        entered.sort_by(|&a, &b| surfaces[b].volume_mm3.total_cmp(&surfaces[a].volume_mm3));
        entered.into_iter().for_each(|object| after.enter(object));
        after
    }

    /// The surface that is shaded, the side from which it is seen, and what lies before and behind;
    /// `None` where the ray goes on as if there were nothing.
    pub(super) fn boundary(
        &self,
        all: &[Met],
        [before, after]: [&Media; 2],
    ) -> Option<(Met, Facing, [Option<MaterialId>; 2])> {
        let crossed =
            |met: &&Met| met.kind == SurfaceKind::Body && net_crossing(all, met.object) != 0;
        let body = all.iter().find(crossed);
        let media = [before, after].map(|media| media.medium(self.prepared));
        let [inside, beyond] = media.map(|medium| medium.filter(|&object| self.is_body(object)));
        let of = |object: usize| all.iter().find(|met| met.object == object);
        match (body, inside, beyond) {
            (Some(body), None, None) => {
                let own = Some(self.material(body.object));
                Some((*body, body.facing, [own, own]))
            }
            (Some(body), inside, beyond) if !self.are_bonded(inside, beyond) => {
                let shaded = beyond.or(inside)?;
                let other = if beyond.is_some() { inside } else { None };
                let seen = of(shaded).or_else(|| of(other?)).unwrap_or(body);
                let facing = if beyond.is_some() { Facing::Front } else { Facing::Back };
                let indices = [inside, beyond].map(|object| Some(self.material(object?)));
                Some((Met { object: shaded, ..*seen }, facing, indices))
            }
            _ => self.sheet(all),
        }
    }

    /// Among surfaces without a body behind them, the one that faces the ray, or the lowest object.
    fn sheet(&self, all: &[Met]) -> Option<(Met, Facing, [Option<MaterialId>; 2])> {
        let order = |met: &&Met| (met.facing == Facing::Back, met.object);
        let sheets = all.iter().filter(|met| met.kind == SurfaceKind::Sheet);
        let seen = sheets.min_by_key(order)?;
        let own = Some(self.material(seen.object));
        let indices = match seen.facing {
            Facing::Front => [None, own],
            Facing::Back => [own, None],
        };
        Some((*seen, seen.facing, indices))
    }

    /// Whether no light is turned between two bodies: they are one, or have the same index.
    fn are_bonded(&self, before: Option<usize>, after: Option<usize>) -> bool {
        let (Some(before), Some(after)) = (before, after) else { return false };
        let ior = |object: usize| &self.prepared.scene.materials[self.material(object).0].ior;
        before == after || ior(before) == ior(after)
    }

    fn is_body(&self, object: usize) -> bool {
        self.prepared.surfaces.of_object[object].kind == SurfaceKind::Body
    }

    fn material(&self, object: usize) -> MaterialId {
        self.prepared.surfaces.of_object[object].material
    }

    fn medium_material(&self, media: &Media) -> Option<MaterialId> {
        let medium = media.medium(self.prepared).filter(|&object| self.is_body(object))?;
        Some(self.material(medium))
    }

    pub(super) fn leaving(&self, hit: &Hit) -> Leaving {
        Leaving { triangle: hit.triangle, departure: self.prepared.bvh.departure(hit) }
    }

    /// The frame of `seen` as the ray meets it; rays on its side leave from the first surface, those
    /// beyond from the last.
    fn surface_point(&self, ray: &Ray, all: &[Met], seen: &Met) -> SurfacePoint {
        let (shape, triangle) = self.prepared.bvh.locate(seen.hit.triangle);
        let mesh = &self.prepared.scene.objects[shape].mesh;
        let view = -ray.direction;
        let own = self.leaving(&seen.hit);
        let leaving = |hit: &Hit, id: TriangleId| {
            if hit.triangle == id { own } else { self.leaving(hit) }
        };
        let near = leaving(&all[0].hit, own.triangle);
        let far = leaving(&all[all.len() - 1].hit, own.triangle);
        let outward = own.departure.n_geom;
        let shading = mesh.shading_normal(triangle, [seen.hit.u, seen.hit.v], outward);
        let (facing, n_geom, normal) = toward(view, outward, shading);
        SurfacePoint {
            near,
            far,
            object: seen.object,
            material: self.material(seen.object),
            facing,
            normal: if normal.dot(view) < 0.0 { n_geom } else { normal },
            view,
            indices: [None; 2],
            after: Media::default(),
            filters: Vec::new(),
        }
    }
}

/// Geometric and shading normal on V's side, and which side that is.
fn toward(view: DVec3, outward: DVec3, shading: DVec3) -> (Facing, DVec3, DVec3) {
    if outward.dot(view) < 0.0 {
        (Facing::Back, -outward, -shading)
    } else {
        (Facing::Front, outward, shading)
    }
}

/// Objects whose sheets lie in the same place, through which a transmitted ray goes too.
pub(super) fn sheets_beside(all: &[Met], seen: &Met) -> impl Iterator<Item = usize> {
    let seen = seen.object;
    let others = all.iter().filter(move |m| m.kind == SurfaceKind::Sheet && m.object != seen);
    others.map(|met| met.object)
}

/// Fronts of an object's surfaces less backs: above 0 the ray enters it, below it leaves it.
fn net_crossing(all: &[Met], object: usize) -> i32 {
    let own = all.iter().filter(|met| met.object == object);
    own.map(|met| if met.facing == Facing::Front { 1 } else { -1 }).sum()
}
