//! The mirrored and the transmitted ray (eq. 1).

use super::walk::{Branch, Facing, RayKind, SurfacePoint};
use super::{TraceState, Tracer};
use crate::geometry::{DVec3, Ray};
use crate::material::Material;
use crate::scene::MaterialId;
use crate::spectrum::Bands;

impl Tracer<'_> {
    /// Pushes the rays that `branch` continues in; those of no weight are never traced.
    pub(super) fn push_children(
        &self,
        surface: &SurfacePoint,
        branch: Branch,
        state: &mut TraceState,
    ) {
        if branch.depth >= self.limits.max_depth {
            return;
        }
        let material = &self.prepared.scene.materials[surface.material.0];
        let transmitted = material.transmits().then(|| transmit(surface, material)).flatten();
        let mirror_share = if material.transmits() && transmitted.is_none() {
            material.k_rg + material.k_tg // total internal reflection
        } else {
            material.k_rg
        };
        if let Some(direction) = transmitted {
            let throughput = self.transmitted_throughput(surface, material, &branch.throughput);
            if !self.is_cut(&throughput) {
                state.counts.transmitted_rays += 1;
                let body = body_after_transmission(surface, material, branch.body);
                let way = Way { kind: RayKind::Transmitted, direction, body };
                state.pending.push(surface.child(way, throughput, branch.depth + 1));
            }
        }
        if mirror_share > 0.0 {
            let mut throughput = branch.throughput;
            let tables = &self.tables.materials[surface.material.0];
            throughput.scale_by(mirror_share, &tables.reflectance);
            if !self.is_cut(&throughput) {
                state.counts.mirror_rays += 1;
                let direction = mirror(surface.normal, surface.view);
                let way = Way { kind: RayKind::Mirrored, direction, body: branch.body };
                state.pending.push(surface.child(way, throughput, branch.depth + 1));
            }
        }
    }

    /// k_tg F_t, or k_tg alone where F_t belongs to the path inside the body.
    fn transmitted_throughput(
        &self,
        surface: &SurfacePoint,
        material: &Material,
        arriving: &Bands,
    ) -> Bands {
        let mut throughput = arriving.clone();
        if material.thickness_mm.is_some() {
            throughput.as_mut_slice().iter_mut().for_each(|value| *value *= material.k_tg);
        } else {
            let tables = &self.tables.materials[surface.material.0];
            throughput.scale_by(material.k_tg, &tables.transmittance);
        }
        throughput
    }
}

/// How a ray goes on behind a hit.
struct Way {
    kind: RayKind,
    direction: DVec3,
    body: Option<MaterialId>,
}

impl SurfacePoint {
    fn child(&self, way: Way, throughput: Bands, depth: u32) -> Branch {
        let Way { kind, direction, body } = way;
        let ray = Ray { origin: self.departure.toward(direction), direction };
        Branch { ray, kind, leaving: Some(self.triangle), depth, body, throughput }
    }
}

/// 2(N·V)N − V.
fn mirror(normal: DVec3, view: DVec3) -> DVec3 {
    (2.0 * normal.dot(view) * normal - view).normalize()
}

/// Snell's refraction about N, or straight on without `ior`; `None` at total internal reflection.
fn transmit(surface: &SurfacePoint, material: &Material) -> Option<DVec3> {
    let Some(ior) = material.ior else {
        return Some(-surface.view);
    };
    let eta = match surface.side {
        Facing::Front => ior.recip(),
        Facing::Back => ior,
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

/// A front-side transmission into a material with `thickness` enters its body, a back-side one
/// leaves it; other surfaces keep the state.
fn body_after_transmission(
    surface: &SurfacePoint,
    material: &Material,
    body: Option<MaterialId>,
) -> Option<MaterialId> {
    match (material.thickness_mm, surface.side) {
        (None, _) => body,
        (Some(_), Facing::Front) => Some(surface.material),
        (Some(_), Facing::Back) => None,
    }
}
