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
use crate::light::sum::{LightSum, Sight, Visibility};
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
    /// Whether that leaves nothing of the light to be seen.
    hides_all: bool,
    /// Whether anything does that takes some of the light.
    dims: bool,
    /// Whether all ways to the light go through the same.
    dims_alike: bool,
}

impl Between {
    /// For a light before which nothing stands.
    const NOTHING: Self =
        Self { shaft: None, hides: false, hides_all: false, dims: false, dims_alike: false };

    /// What is known of the light's places in a ball.
    fn sight(&self, center: DVec3, radius: f64) -> Sight {
        let Some(shaft) = &self.shaft else { return Sight::Unknown };
        match shaft.hides_ball(center, radius) {
            Some(true) => Sight::Hidden,
            Some(false) => Sight::Seen,
            None => Sight::Unknown,
        }
    }

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
        take: impl FnMut(LightSum, Option<&Bands>),
    ) -> u64 {
        let between = self.between(light, (surface, Some(before)));
        self.each_sum_through(&between, light, (surface, before), take)
    }

    fn each_sum_through(
        &self,
        between: &Between,
        light: usize,
        (surface, before): (&SurfacePoint, &Media),
        mut take: impl FnMut(LightSum, Option<&Bands>),
    ) -> u64 {
        if !between.dims || between.hides_all {
            let (sum, shadow_rays) =
                self.unveiled_sum(light, surface, self.limits.light_error, between);
            take(sum, None);
            return shadow_rays;
        }
        let from = (surface, before, between);
        let tree = &self.prepared.light_trees[light];
        if between.dims_alike && !between.hides {
            let veil = self.veil(from, tree.middle());
            let (sum, _) = self.unveiled_sum(light, surface, self.limits.light_error, between);
            take(sum, self.left_by(&veil).as_ref());
            return 1;
        }
        let query = self.hit_query(surface);
        let veils = RefCell::new(Vec::new());
        let shadow_rays = Cell::new(0);
        // The first is found by the first sum.
        for at in 0.. {
            let visible = |position: DVec3| {
                shadow_rays.set(shadow_rays.get() + 1);
                let veil = || match &mut *veils.borrow_mut() {
                    known if between.dims_alike && !known.is_empty() => 0,
                    known => self.find_veil(from, position, known),
                };
                self.is_free(light, surface, position, between) && veil() == at
            };
            let ball = |center, radius| {
                let is_alike = between.dims_alike && veils.borrow().len() == 1;
                match between.sight(center, radius) {
                    Sight::Seen if is_alike => Sight::Seen,
                    Sight::Hidden => Sight::Hidden,
                    _ => Sight::Unknown,
                }
            };
            let visible = Visibility { place: &visible, ball: &ball };
            let asked = (self.limits.light_error, Some(visible));
            let sum = self.both_sides(tree, &query, asked, surface);
            take(sum, veils.borrow().get(at).and_then(|veil| self.left_by(veil)).as_ref());
            if at + 1 >= veils.borrow().len() {
                break;
            }
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
        if between.hides_all {
            return (LightSum::default(), 0);
        }
        if !between.hides {
            return (self.both_sides(tree, &query, (light_error, None), surface), 0);
        }
        let shadow_rays = Cell::new(0);
        let visible = |position: DVec3| {
            shadow_rays.set(shadow_rays.get() + 1);
            self.is_free(light, surface, position, between)
        };
        let ball = |center, radius| between.sight(center, radius);
        let visible = Visibility { place: &visible, ball: &ball };
        (self.both_sides(tree, &query, (light_error, Some(visible)), surface), shadow_rays.get())
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
            return Between::NOTHING;
        }
        let (bvh, blocks) = (&self.prepared.bvh, self.prepared.blocks(light));
        let attenuates = before.is_some() && self.attenuates();
        let role = |object: usize| match blocks[object] {
            true => Role::Blocks,
            false if attenuates => Role::Counts,
            false => Role::None,
        };
        let leaving = surface.near.triangle;
        let shaft = bvh.shaft(&surface.near.departure, leaving, (low, high), role);
        let own = (height < -reach).then_some(surface.object);
        let dims = |object: usize| Some(object) != own && !blocks[object] && self.dims(object);
        let starts = [near.then_some(before).flatten(), far.then_some(&surface.after)];
        let started: Vec<usize> = starts.into_iter().flatten().flat_map(Media::objects).collect();
        let is_inside = started.iter().copied().any(dims);
        let crosses = shaft.as_ref().is_none_or(|shaft| bvh.objects_in(shaft).any(dims));
        let dims = attenuates && (is_inside || crosses);
        let is_one_side = height.abs() > reach;
        let dims_alike =
            |shaft: &Shaft| is_one_side && self.is_crossed_alike(shaft, blocks, &started);
        Between {
            hides: shaft.as_ref().is_none_or(|shaft| !shaft.is_free()),
            hides_all: shaft.as_ref().is_some_and(Shaft::hides_all),
            dims,
            dims_alike: dims && shaft.as_ref().is_some_and(dims_alike),
            shaft,
        }
    }

    /// Whether all ways in a shaft go through the same surfaces, in the same order.
    fn is_crossed_alike(&self, shaft: &Shaft, blocks: &[bool], started: &[usize]) -> bool {
        let crossed = self.prepared.bvh.objects_in(shaft).filter(|&object| !blocks[object]);
        let crossed: Vec<usize> = crossed.collect();
        let is_one = crossed.windows(2).all(|pair| pair[0] == pair[1]);
        // The mean path depends on what of the light shines to the hit.
        let has_path = |object: &usize| self.dims(*object) && self.has_path(*object);
        let has_no_path = !crossed.iter().chain(started).any(has_path);
        is_one && has_no_path && self.prepared.scene.contact_mm == 0.0 && shaft.crosses_alike()
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

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::geometry::Mesh;
    use crate::geometry::mesh::Shading;
    use crate::light::{RaySample, RaySet};
    use crate::material::{Lobes, Material, SpecularLobe};
    use crate::scene::{Light, MaterialId, Object, Prepared, Scene};
    use crate::shading::walk::Arrival;
    use crate::shading::{TraceLimits, TraceState};
    use crate::source::sequence::random;
    use crate::spectrum::{Spectrum, WavelengthGrid};

    fn unit(i: u64, axis: u64) -> f64 {
        random(1, i, axis)
    }

    /// A cuboid, its front outside.
    fn cuboid(low: [f64; 3], high: [f64; 3]) -> Arc<Mesh> {
        let at = |bits: usize| {
            DVec3::from(std::array::from_fn(|i| if bits >> i & 1 == 1 { high[i] } else { low[i] }))
        };
        let faces =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let halves = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
        let (positions, triangles) = ((0..8).map(at).collect(), halves.collect());
        Arc::new(Mesh { positions, triangles, shading: Shading::Flat })
    }

    /// A ball of samples over a floor, with a wall, a red slab that stands in water, and a filter.
    fn lit_floor(photometry: Photometry) -> Prepared {
        let red = Spectrum::from_pairs("red", [(380.0, 0.2), (780.0, 0.8)]).unwrap();
        let lobes = Lobes {
            k_d: 0.5,
            specular: vec![SpecularLobe { k_s: 0.5, n_s: 20.0 }],
            ..Lobes::default()
        };
        let opaque = Material { lobes, k_rg: 0.5, ..Material::default() };
        let clear = Material { transmittance: Some(red), k_tg: 0.9, ..opaque.clone() };
        let slab = Material { thickness_mm: Some(3.0), ..clear.clone() };
        let objects = [
            (cuboid([-40.0, -40.0, -1.0], [40.0, 40.0, 0.0]), 0),
            (cuboid([5.0, -8.0, 10.0], [6.0, 8.0, 25.0]), 0),
            (cuboid([-20.0, -20.0, 5.0], [-4.0, 20.0, 8.0]), 2),
            (cuboid([-30.0, 2.0, 3.0], [20.0, 20.0, 6.0]), 2),
            (cuboid([-3.0, -25.0, 2.0], [25.0, -12.0, 2.5]), 1),
        ];
        let sample = |i: u64| RaySample {
            position: std::array::from_fn(|axis| (2.0 * unit(i, axis as u64) - 1.0) as f32),
            direction: std::array::from_fn(|axis| (unit(i, 3 + axis as u64) - 0.5) as f32),
            flux: 1.0,
        };
        let mut rays = RaySet::new((0..5000).map(sample).collect(), 100.0);
        rays.world_from_local.translation = DVec3::new(0.0, 0.0, 20.0);
        let scene = Scene {
            objects: objects
                .into_iter()
                .map(|(mesh, material)| Object { mesh, material: MaterialId(material) })
                .collect(),
            materials: vec![opaque, clear, slab],
            lights: vec![Light::new(rays, Spectrum::constant(1.0))],
            photometry,
            shadows: Shadows::On,
            ..Scene::default()
        };
        scene.prepare().unwrap()
    }

    /// Both sums, as far as they pass.
    fn passed(tracer: &Tracer, between: &Between, from: (&SurfacePoint, &Media)) -> [f64; 2] {
        let mut total = [0.0; 2];
        tracer.each_sum_through(between, 0, from, |sum, left| {
            let left = left.map_or(1.0, |left| left.as_slice().iter().sum::<f64>() / 81.0);
            total[0] += left * sum.reflected;
            total[1] += left * sum.transmitted;
        });
        total
    }

    /// What is asked once for a hit, against every segment by itself.
    #[test]
    fn what_stands_between_is_what_every_segment_meets() {
        for (photometry, light_error) in
            [(Photometry::Relative, 0.0), (Photometry::Absolute, 0.0), (Photometry::Absolute, 0.01)]
        {
            let prepared = lit_floor(photometry);
            let tables = prepared.tables(WavelengthGrid::Step5).unwrap();
            let limits = TraceLimits { light_error, ..TraceLimits::default() };
            let tracer = Tracer { prepared: &prepared, tables, limits };
            // Hits, and those of them that see all or none of the light, or know at once that they see
            // none, see it dimmed, or dimmed alike.
            let mut seen = [0; 6];
            for i in 0..400 {
                let at = |axis| 70.0 * (unit(i, axis) - 0.5);
                let origin = DVec3::new(at(0), at(1), 60.0);
                let direction = (DVec3::new(at(2), at(3), 0.0) - origin).normalize();
                let mut state = TraceState::default();
                tracer.walk(Ray { origin, direction }, &mut state, |branch, arrival, _| {
                    let Arrival::Hit(surface) = arrival else { return };
                    let from = (surface, &branch.media);
                    let between = tracer.between(0, (surface, Some(&branch.media)));
                    let dims = tracer.attenuates();
                    let unknown = Between { hides: true, dims, ..Between::NOTHING };
                    let (quick, plain) =
                        (passed(&tracer, &between, from), passed(&tracer, &unknown, from));
                    for side in 0..2 {
                        // f32 lanes of another order, or both within their bounds.
                        let most = (1e-5 + 2.0 * light_error) * plain[side];
                        assert!((quick[side] - plain[side]).abs() <= most, "{quick:?} {plain:?}");
                    }
                    seen[0] += 1;
                    seen[1] += usize::from(!between.hides);
                    seen[2] += usize::from(between.hides && plain[0] + plain[1] == 0.0);
                    seen[3] += usize::from(between.hides_all);
                    seen[4] += usize::from(between.dims);
                    seen[5] += usize::from(between.dims_alike);
                });
            }
            assert!(seen[0] > 500 && seen[1] > 200 && seen[2] > 20, "{seen:?}");
            assert!(seen[3] > 20, "{seen:?}");
            let dims = photometry == Photometry::Absolute;
            assert!((seen[4] > 50) == dims && (seen[5] > 20) == dims, "{seen:?}");
        }
    }
}
