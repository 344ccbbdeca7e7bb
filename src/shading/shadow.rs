//! Light that reaches a hit, and through what: shadows of opaque surfaces, and the shade of those
//! that transmit.
//!
//! In absolute photometry a sample behind surfaces that transmit is attenuated by their F_t,
//! undeviated. Samples behind the same surfaces share one spectrum: F_t to the power of the
//! crossings, or of the mean path inside of a body with `thickness`. The light is summed once for
//! every such set of surfaces, so that each sum keeps the bound on its error.

use std::cell::{Cell, RefCell};

use super::Tracer;
use super::interface::{Met, sheets_beside};
use super::media::Media;
use super::walk::SurfacePoint;
use crate::color::Photometry;
use crate::geometry::{DVec3, Ray, Role, Shaft};
use crate::light::sum::{LightSum, Visibility};
use crate::scene::{Shadows, SurfaceKind};
use crate::spectrum::Bands;

/// Transmitting surfaces between a hit and light samples.
#[derive(Debug, Default)]
struct Veil {
    /// (object, crossings), ascending; a body with `thickness` has 0 crossings and a path.
    surfaces: Vec<(usize, u32)>,
    /// Σ of the paths inside, mm, in the same order, over all samples asked.
    paths_mm: Vec<f64>,
    asked: u32,
}

impl Veil {
    /// Place of an object among the surfaces.
    fn index(&mut self, object: usize) -> usize {
        self.surfaces.binary_search_by_key(&object, |entry| entry.0).unwrap_or_else(|at| {
            self.surfaces.insert(at, (object, 0));
            self.paths_mm.insert(at, 0.0);
            at
        })
    }

    fn add_path(&mut self, object: Option<usize>, path_mm: f64) {
        if let Some(object) = object {
            let at = self.index(object);
            self.paths_mm[at] += path_mm;
        }
    }

    fn add_crossing(&mut self, object: usize) {
        let at = self.index(object);
        self.surfaces[at].1 += 1;
    }
}

/// What may stand between a hit and a light, asked of the BVH once.
struct Between {
    /// `None` where so much may that each segment walks the BVH by itself.
    shaft: Option<Shaft>,
    /// Whether anything opaque does.
    hides: bool,
    /// Whether anything does that takes some of the light.
    dims: bool,
}

impl Between {
    /// The triangles to ask about a segment to `target`, if not all.
    fn shaft_to(&self, target: DVec3) -> Option<&Shaft> {
        self.shaft.as_ref().filter(|shaft| shaft.holds(target))
    }
}

impl Tracer<'_> {
    /// A light's sums at a hit, each with what the way there leaves of it, and the shadow rays that
    /// they took. `before` are the bodies on V's side.
    pub(super) fn each_light_sum(
        &self,
        light: usize,
        (surface, before): (&SurfacePoint, &Media),
        mut take: impl FnMut(LightSum, Option<&Bands>),
    ) -> u64 {
        let between = self.between(light, (surface, Some(before)));
        if !between.dims {
            let (sum, shadow_rays) =
                self.unveiled_sum(light, surface, self.limits.light_error, &between);
            take(sum, None);
            return shadow_rays;
        }
        let query = self.hit_query(surface);
        let tree = &self.prepared.light_trees[light];
        let veils = RefCell::new(vec![Veil::default()]);
        let shadow_rays = Cell::new(0);
        let mut at = 0;
        while at < veils.borrow().len() {
            let visible = |position: DVec3| {
                shadow_rays.set(shadow_rays.get() + 1);
                let veil = || {
                    let from = (surface, before, &between);
                    self.find_veil(from, position, &mut veils.borrow_mut())
                };
                self.is_free(light, surface, position, &between) && veil() == at
            };
            let asked = (self.limits.light_error, Some(&visible as Visibility));
            let sum = self.both_sides(tree, &query, asked, surface);
            take(sum, self.left_by(&veils.borrow()[at]).as_ref());
            at += 1;
        }
        shadow_rays.get()
    }

    /// The sum over a light's samples as if what transmits were not there.
    pub(super) fn light_sum(
        &self,
        light: usize,
        surface: &SurfacePoint,
        light_error: f64,
    ) -> LightSum {
        let between = self.between(light, (surface, None));
        self.unveiled_sum(light, surface, light_error, &between).0
    }

    /// The same, and the shadow rays that it took.
    fn unveiled_sum(
        &self,
        light: usize,
        surface: &SurfacePoint,
        light_error: f64,
        between: &Between,
    ) -> (LightSum, u64) {
        let query = self.hit_query(surface);
        let tree = &self.prepared.light_trees[light];
        if !between.hides {
            return (self.both_sides(tree, &query, (light_error, None), surface), 0);
        }
        let shadow_rays = Cell::new(0);
        let visible = |position: DVec3| {
            shadow_rays.set(shadow_rays.get() + 1);
            self.is_free(light, surface, position, between)
        };
        (self.both_sides(tree, &query, (light_error, Some(&visible)), surface), shadow_rays.get())
    }

    /// Nothing for a light of which the hit sees no sample on the sides that it asks; without
    /// `before`, nothing dims.
    fn between(&self, light: usize, (surface, before): (&SurfacePoint, Option<&Media>)) -> Between {
        let (low, high) = self.prepared.light_trees[light].bounds();
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        let height = (middle - surface.near.departure.point).dot(surface.normal);
        let reach = half.dot(surface.normal.abs());
        let query = self.hit_query(surface);
        let [near, far] = [query.reflects && height > -reach, query.transmits && height < reach];
        if !(self.casts_shadows() && (near || far)) {
            return Between { shaft: None, hides: false, dims: false };
        }
        let (bvh, blocks) = (&self.prepared.bvh, self.prepared.blocks(light));
        let role = |object: usize| if blocks[object] { Role::Blocks } else { Role::Counts };
        let leaving = surface.near.triangle;
        let shaft = bvh.shaft(&surface.near.departure, leaving, (low, high), role);
        let own = (height < -reach).then_some(surface.object);
        let dims = |object: usize| Some(object) != own && !blocks[object] && self.dims(object);
        let starts = [near.then_some(before).flatten(), far.then_some(&surface.after)];
        let is_inside = starts.into_iter().flatten().flat_map(Media::objects).any(dims);
        let crosses = shaft.as_ref().is_none_or(|shaft| bvh.objects_in(shaft).any(dims));
        Between {
            hides: shaft.as_ref().is_none_or(|shaft| !shaft.is_free()),
            dims: before.is_some() && self.attenuates() && (is_inside || crosses),
            shaft,
        }
    }

    pub(super) fn casts_shadows(&self) -> bool {
        self.prepared.scene.shadows == Shadows::On
    }

    /// Whether surfaces that transmit take light from the samples behind them.
    fn attenuates(&self) -> bool {
        self.casts_shadows()
            && self.prepared.scene.photometry == Photometry::Absolute
            && (0..self.prepared.surfaces.of_object.len()).any(|object| self.dims(object))
    }

    /// Whether nothing opaque is in the way.
    fn is_free(
        &self,
        light: usize,
        surface: &SurfacePoint,
        position: DVec3,
        between: &Between,
    ) -> bool {
        let from = surface.near.departure.toward(position - surface.near.departure.point);
        let (bvh, leaving) = (&self.prepared.bvh, surface.near.triangle);
        !match between.shaft_to(position) {
            Some(shaft) => bvh.is_occluded_in(shaft, (from, position), leaving),
            None => bvh.is_occluded(from, position, Some(leaving), self.prepared.blocks(light)),
        }
    }

    /// The number of the veil before a sample, a new one if it is not among them.
    fn find_veil(
        &self,
        from: (&SurfacePoint, &Media, &Between),
        position: DVec3,
        veils: &mut Vec<Veil>,
    ) -> usize {
        let here = self.veil(from, position);
        let known = veils.iter().position(|veil| veil.surfaces == here.surfaces);
        let at = known.unwrap_or_else(|| {
            let (surfaces, paths_mm) = (here.surfaces, vec![0.0; here.paths_mm.len()]);
            veils.push(Veil { surfaces, paths_mm, asked: 0 });
            veils.len() - 1
        });
        let veil = &mut veils[at];
        veil.asked += 1;
        veil.paths_mm.iter_mut().zip(here.paths_mm).for_each(|(sum, path)| *sum += path);
        at
    }

    /// What a straight way to a sample crosses: the interfaces that a ray would meet there, `before`
    /// being the bodies on V's side. The lobe of light from the far side is measured on the whole
    /// sheet, so that the rest of the hit's own body is part of it.
    fn veil(
        &self,
        (surface, before, between): (&SurfacePoint, &Media, &Between),
        position: DVec3,
    ) -> Veil {
        let start = surface.near.departure.point;
        let way = position - start;
        let length_mm = way.length();
        if length_mm == 0.0 {
            return Veil::default();
        }
        let from = surface.near.departure.toward(way);
        let ray = Ray { origin: from, direction: way / length_mm };
        let end_mm = length_mm - self.prepared.bvh.place_mm();
        let (leaving, among) = (Some(surface.near.triangle), between.shaft_to(position));
        let hits = self.prepared.bvh.hits_among(&ray, leaving, end_mm, among);
        let met: Vec<Met> = hits.into_iter().map(|hit| self.met(&ray, hit)).collect();
        let is_far = way.dot(surface.normal) < 0.0;
        let own = is_far.then_some(surface.object);
        let mut media = if is_far { surface.after.clone() } else { before.clone() };
        let (mut veil, mut from_mm, mut rest) = (Veil::default(), 0.0, &met[..]);
        let counts = |object: &usize| Some(*object) != own && self.dims(*object);
        let medium = |media: &Media| {
            media.medium(self.prepared).filter(|object| self.has_path(*object) && counts(object))
        };
        while let Some(first) = rest.first() {
            let shared = rest.iter().take_while(|other| self.share_place(&ray, first, other));
            let (place, behind) = rest.split_at(shared.count().max(1));
            let here_mm = first.hit.distance_mm;
            veil.add_path(medium(&media), here_mm - from_mm);
            let after = self.media_after(place, &media);
            if let Some((seen, ..)) = self.boundary(place, [&media, &after]) {
                let crossed = std::iter::once(seen.object).chain(sheets_beside(place, &seen));
                let crossed = crossed.filter(|object| !self.has_path(*object) && counts(object));
                crossed.for_each(|object| veil.add_crossing(object));
            }
            (media, from_mm, rest) = (after, here_mm, behind);
        }
        veil.add_path(medium(&media), end_mm - from_mm);
        veil
    }

    /// Whether a surface takes light from a way through it. That of an open mesh with `thickness`
    /// does not: it has no inside in which a path could be measured.
    fn dims(&self, object: usize) -> bool {
        let Some(surface) = self.prepared.surfaces.of_object.get(object) else { return false };
        self.tables.materials[surface.material.0].attenuates
            && (surface.kind == SurfaceKind::Body || !self.has_path(object))
    }

    /// Whether it takes light along the path inside, not at its surfaces.
    fn has_path(&self, object: usize) -> bool {
        let material = self.prepared.surfaces.of_object[object].material;
        self.prepared.scene.materials[material.0].thickness_mm.is_some()
    }

    /// What the surfaces leave of light, `None` for all of it.
    fn left_by(&self, veil: &Veil) -> Option<Bands> {
        if veil.surfaces.is_empty() {
            return None;
        }
        let mut left = Bands::one(self.tables.bands);
        for (&(object, count), &path_mm) in veil.surfaces.iter().zip(&veil.paths_mm) {
            let material = self.prepared.surfaces.of_object[object].material;
            let tables = &self.tables.materials[material.0];
            if self.has_path(object) {
                left.attenuate(&tables.absorption_per_mm, path_mm / f64::from(veil.asked.max(1)));
                continue;
            }
            for _ in 0..count {
                left.scale_by(1.0, &tables.transmittance);
            }
        }
        Some(left)
    }
}
