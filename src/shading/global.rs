//! The mirrored and the transmitted ray (eq. 1), with Snell's and Fresnel's laws.

use super::media::Media;
use super::walk::{Branch, Leaving, RayKind, SurfacePoint};
use super::{TraceState, Tracer};
use crate::geometry::{DVec3, Ray};
use crate::material::{Material, dielectric_reflectance, metal_reflectance};
use crate::scene::{Index, MaterialId};
use crate::spectrum::Bands;

/// A ray that ends at `max_depth` with more than this of its light in some band is told.
const TOLD: f64 = 0.01;

impl Tracer<'_> {
    /// Pushes the rays that `branch` continues in; those of no weight are never traced.
    pub(super) fn push_children(
        &self,
        surface: &SurfacePoint,
        branch: Branch,
        state: &mut TraceState,
    ) {
        let material = &self.prepared.scene.materials[surface.material.0];
        if branch.depth >= self.limits.max_depth {
            state.counts.rays_cut += u64::from(is_told(material, &branch.throughput));
            return;
        }
        let share = self.mirrored_share(surface);
        let kept = if material.transmits() {
            let mut throughput = self.transmitted_throughput(surface, material, &branch.throughput);
            if let Some(share) = &share {
                scale(&mut throughput, share.as_slice().iter().map(|share| 1.0 - share));
            }
            self.push_transmitted(surface, &branch, throughput, state)
        } else {
            TotalReflection::Nowhere
        };
        let mut throughput = branch.throughput;
        self.keep_mirrored(surface, &kept, share.as_ref(), &mut throughput);
        if !self.is_cut(&throughput) {
            state.counts.mirror_rays += 1;
            let direction = mirror(surface.normal, surface.view);
            let (media, group, depth) = (branch.media, branch.group, branch.depth + 1);
            let way = Way { kind: RayKind::Mirrored, direction, media, group, depth };
            state.pending.push(way.branch(&surface.near, throughput));
        }
    }

    /// What of `throughput` is mirrored: k_rg F_r, with k_tg where no light passes, or k_rg F_r R.
    fn keep_mirrored(
        &self,
        surface: &SurfacePoint,
        kept: &TotalReflection,
        share: Option<&Bands>,
        throughput: &mut Bands,
    ) {
        let material = &self.prepared.scene.materials[surface.material.0];
        let f_r = &self.tables.materials[surface.material.0].reflectance;
        // Of Fresnel's law R is 1 there.
        let k_tg = if share.is_some() { 0.0 } else { material.k_tg };
        match kept {
            TotalReflection::Nowhere => throughput.scale_by(material.k_rg, f_r),
            TotalReflection::Everywhere => throughput.scale_by(material.k_rg + k_tg, f_r),
            TotalReflection::At(bands) => {
                let k = |is_total: &bool| material.k_rg + if *is_total { k_tg } else { 0.0 };
                scale(throughput, bands.iter().zip(f_r.as_slice()).map(|(at, f_r)| k(at) * f_r));
            }
        }
        if let Some(share) = share {
            scale(throughput, share.as_slice().iter().copied());
        }
    }

    /// Pushes the rays that pass, in as many directions as `dispersion` asks for; says where none
    /// passes since all light is mirrored.
    fn push_transmitted(
        &self,
        surface: &SurfacePoint,
        branch: &Branch,
        throughput: Bands,
        state: &mut TraceState,
    ) -> TotalReflection {
        let mut push = |direction: DVec3, group: Option<u32>, throughput: Bands| {
            if !self.is_cut(&throughput) {
                state.counts.transmitted_rays += 1;
                let (media, depth) = (surface.after.clone(), branch.depth + 1);
                let way = Way { kind: RayKind::Transmitted, direction, media, group, depth };
                state.pending.push(way.branch(&surface.far, throughput));
            }
        };
        if !self.splits(surface, branch) {
            return match transmit(surface, self.eta(surface, branch.group)) {
                Some(direction) => {
                    push(direction, branch.group, throughput);
                    TotalReflection::Nowhere
                }
                None => TotalReflection::Everywhere,
            };
        }
        let mut is_total = vec![false; self.tables.bands];
        for group in 0..self.limits.dispersion {
            let bands = self.bands_of(group);
            match transmit(surface, self.eta(surface, Some(group))) {
                Some(direction) => {
                    let mut part = Bands::zero(self.tables.bands);
                    part.as_mut_slice()[bands.clone()]
                        .copy_from_slice(&throughput.as_slice()[bands]);
                    push(direction, Some(group), part);
                }
                None => is_total[bands].fill(true),
            }
        }
        TotalReflection::At(is_total)
    }

    /// Whether the bands part here: not before, and at an index that depends on the wavelength.
    fn splits(&self, surface: &SurfacePoint, branch: &Branch) -> bool {
        self.limits.dispersion > 1
            && branch.group.is_none()
            && surface.indices.iter().any(|&at| self.index(at).is_some_and(|n| !n.is_constant))
    }

    /// Neighboring bands, as many in every group as can be.
    pub(super) fn bands_of(&self, group: u32) -> std::ops::Range<usize> {
        let edge = |group: u32| {
            group as usize * self.tables.bands / self.limits.dispersion.max(1) as usize
        };
        edge(group)..edge(group + 1)
    }

    fn index(&self, of: Option<MaterialId>) -> Option<&Index> {
        self.tables.materials[of?.0].index.as_ref()
    }

    /// n before over n after; `None` where rays go straight on.
    fn eta(&self, surface: &SurfacePoint, group: Option<u32>) -> Option<f64> {
        let [before, after] = surface.indices.map(|of| {
            self.index(of).map(|index| match group {
                Some(group) => {
                    let bands = self.bands_of(group);
                    index.bands.as_slice()[(bands.start + bands.end - 1) / 2]
                }
                None => index.at_d,
            })
        });
        (before.is_some() || after.is_some())
            .then(|| before.unwrap_or(1.0) / after.unwrap_or(1.0))
            .filter(|_| before != after)
    }

    /// R(λ) at V's angle, or `None` for a material without Fresnel's law.
    pub(super) fn mirrored_share(&self, surface: &SurfacePoint) -> Option<Bands> {
        let material = &self.prepared.scene.materials[surface.material.0];
        if !material.fresnel.is_on() {
            return None;
        }
        let cos = surface.normal.dot(surface.view).clamp(0.0, 1.0);
        let [before, after] = surface.indices.map(|of| self.index(of));
        let at = |index: Option<&Index>, band: usize| {
            index.map_or(1.0, |index| index.bands.as_slice()[band])
        };
        let metal = self.tables.materials[surface.material.0].metal.as_ref();
        let share = |band: usize| match metal {
            Some([n, k]) => {
                let metal = [n.as_slice()[band], k.as_slice()[band]];
                metal_reflectance(cos, at(before, band), metal)
            }
            None => dielectric_reflectance(cos, at(before, band), at(after, band)),
        };
        let mut shares = Bands::zero(self.tables.bands);
        let is_same =
            metal.is_none() && [before, after].into_iter().flatten().all(|index| index.is_constant);
        if is_same {
            shares.as_mut_slice().fill(share(0));
        } else {
            shares.as_mut_slice().iter_mut().enumerate().for_each(|(band, r)| *r = share(band));
        }
        Some(shares)
    }

    /// k_tg F_t, or k_tg alone where F_t belongs to the path inside the body.
    fn transmitted_throughput(
        &self,
        surface: &SurfacePoint,
        material: &Material,
        arriving: &Bands,
    ) -> Bands {
        let mut throughput = arriving.clone();
        self.pass(&mut throughput, surface.material, material);
        for &filter in &surface.filters {
            self.pass(&mut throughput, filter, &self.prepared.scene.materials[filter.0]);
        }
        throughput
    }

    fn pass(&self, throughput: &mut Bands, id: MaterialId, material: &Material) {
        if material.thickness_mm.is_some() {
            throughput.as_mut_slice().iter_mut().for_each(|value| *value *= material.k_tg);
        } else {
            throughput.scale_by(material.k_tg, &self.tables.materials[id.0].transmittance);
        }
    }
}

/// Whether a ray that ends at `max_depth` would go on with much of its light.
fn is_told(material: &Material, throughput: &Bands) -> bool {
    let most = throughput.as_slice().iter().copied().fold(0.0, f64::max);
    most * material.k_rg.max(if material.transmits() { material.k_tg } else { 0.0 }) > TOLD
}

/// Which bands are mirrored as a whole, so that k_tg's share stays too.
enum TotalReflection {
    Nowhere,
    Everywhere,
    At(Vec<bool>),
}

/// How a ray goes on behind a hit.
struct Way {
    kind: RayKind,
    direction: DVec3,
    media: Media,
    group: Option<u32>,
    depth: u32,
}

impl Way {
    fn branch(self, from: &Leaving, throughput: Bands) -> Branch {
        let Way { kind, direction, media, group, depth } = self;
        let ray = Ray { origin: from.departure.toward(direction), direction };
        Branch { ray, kind, leaving: Some(from.triangle), depth, media, group, throughput }
    }
}

fn scale(bands: &mut Bands, factors: impl Iterator<Item = f64>) {
    bands.as_mut_slice().iter_mut().zip(factors).for_each(|(value, factor)| *value *= factor);
}

/// 2(N·V)N − V.
fn mirror(normal: DVec3, view: DVec3) -> DVec3 {
    (2.0 * normal.dot(view) * normal - view).normalize()
}

/// Snell's refraction about N, or straight on without `eta`; `None` at total internal reflection.
fn transmit(surface: &SurfacePoint, eta: Option<f64>) -> Option<DVec3> {
    let Some(eta) = eta else {
        return Some(-surface.view);
    };
    let cos_in = surface.normal.dot(surface.view);
    // sin² of the refracted angle, from the component across N, which keeps its digits where the
    // angle is small.
    let across = surface.view - cos_in * surface.normal;
    let sin2_out = eta * eta * across.length_squared();
    if sin2_out > 1.0 {
        return None;
    }
    let cos_out = (1.0 - sin2_out).sqrt();
    Some((-eta * across - cos_out * surface.normal).normalize())
}
