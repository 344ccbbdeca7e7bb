//! What a ray brings back: the local (eq. 2, 9) and the global (eq. 1) terms.
//!
//! A camera ray becomes a binary tree of mirrored and transmitted rays. It is walked depth first
//! with a stack; each ray carries the throughput of all bands, so the scalar sum over light samples
//! is done once a hit and not once a band.

mod bands;
mod global;
mod light_check;
mod local;
mod paths;
mod tables;

pub use bands::Bands;
pub use light_check::LightCheck;
pub use paths::{PathEnd, PathKind, PathSegment};
pub use tables::{MaterialTables, SpectralTables};

use crate::geometry::{DVec3, Departure, Hit, Ray, TriangleId};
use crate::scene::{MaterialId, Prepared, Shadows};

/// Where the tree of rays ends, and how exact the sum over light samples is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TraceLimits {
    /// Hits at this depth have no children; the camera ray's hit has depth 0.
    pub max_depth: u32,
    /// A ray whose throughput is below this in every band adds nothing.
    pub min_throughput: f64,
    /// Bound on the relative error of the sum over light samples; 0 is the exact sum.
    pub light_error: f64,
}

/// What was traced and evaluated.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct TraceCounts {
    pub camera_rays: u64,
    pub mirror_rays: u64,
    pub transmitted_rays: u64,
    pub shadow_rays: u64,
    /// Hits that asked the lights.
    pub light_sums: u64,
    pub light_nodes: u64,
    pub light_samples: u64,
}

impl std::ops::Add for TraceCounts {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            camera_rays: self.camera_rays + other.camera_rays,
            mirror_rays: self.mirror_rays + other.mirror_rays,
            transmitted_rays: self.transmitted_rays + other.transmitted_rays,
            shadow_rays: self.shadow_rays + other.shadow_rays,
            light_sums: self.light_sums + other.light_sums,
            light_nodes: self.light_nodes + other.light_nodes,
            light_samples: self.light_samples + other.light_samples,
        }
    }
}

/// Traces rays through a prepared scene at the bands of its tables.
#[derive(Debug, Clone, Copy)]
pub struct Tracer<'a> {
    pub prepared: &'a Prepared,
    pub tables: &'a SpectralTables,
    pub limits: TraceLimits,
}

/// One thread's working memory.
#[derive(Debug, Default)]
pub struct TraceState {
    pending: Vec<Branch>,
    pub counts: TraceCounts,
    /// Σ over hits of the estimated error of their light sums, in the luminance that reaches the
    /// camera (unit of Y).
    pub light_error: f64,
}

/// A ray still to be traced.
#[derive(Debug, Clone)]
struct Branch {
    ray: Ray,
    leaving: Option<TriangleId>,
    depth: u32,
    /// The body (material with `thickness`) that the ray runs in.
    body: Option<MaterialId>,
    throughput: Bands,
}

impl Branch {
    fn from_camera(ray: Ray, bands: usize) -> Self {
        Self { ray, leaving: None, depth: 0, body: None, throughput: Bands::one(bands) }
    }
}

/// A hit with its surface's frame: model.md, "V", "N_g, N".
#[derive(Debug, Clone, Copy)]
struct SurfacePoint {
    triangle: TriangleId,
    /// P, and where the rays that leave it start.
    departure: Departure,
    material: MaterialId,
    side: Side,
    /// Unit, on V's side (eq. 3).
    normal: DVec3,
    /// V.
    view: DVec3,
}

/// Which side of the triangle the ray comes from; counter-clockwise winding is the front.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    Front,
    Back,
}

/// What became of a ray.
enum Arrival {
    Missed,
    /// Too little is left of it.
    Cut,
    Hit(SurfacePoint),
}

impl Tracer<'_> {
    /// Adds the spectral radiance that arrives along `ray` to `sum`.
    pub fn trace(&self, ray: Ray, state: &mut TraceState, sum: &mut Bands) {
        state.counts.camera_rays += 1;
        state.pending.push(Branch::from_camera(ray, self.tables.bands));
        while let Some(mut branch) = state.pending.pop() {
            match self.arrive(&mut branch) {
                Arrival::Missed => sum.add_product(&branch.throughput, &self.tables.background),
                Arrival::Cut => {}
                Arrival::Hit(surface) => {
                    self.add_local(&surface, &branch.throughput, state, sum);
                    self.push_children(&surface, branch, state);
                }
            }
        }
    }

    fn arrive(&self, branch: &mut Branch) -> Arrival {
        let Some(hit) = self.prepared.bvh.closest_hit(&branch.ray, branch.leaving) else {
            return Arrival::Missed;
        };
        if let Some(body) = branch.body {
            let absorption = &self.tables.materials[body.0].absorption_per_mm;
            branch.throughput.attenuate(absorption, hit.distance_mm);
            if self.is_cut(&branch.throughput) {
                return Arrival::Cut;
            }
        }
        Arrival::Hit(self.surface_point(&branch.ray, hit))
    }

    fn is_cut(&self, throughput: &Bands) -> bool {
        throughput.is_below(self.limits.min_throughput)
    }

    fn surface_point(&self, ray: &Ray, hit: Hit) -> SurfacePoint {
        let (object, triangle) = self.prepared.bvh.locate(hit.triangle);
        let object = &self.prepared.scene.objects[object];
        let view = -ray.direction;
        let departure = self.prepared.bvh.departure(&hit);
        let outward = departure.n_geom;
        let shading = object.mesh.shading_normal(triangle, [hit.u, hit.v], outward);
        let (side, n_geom, normal) = if outward.dot(view) < 0.0 {
            (Side::Back, -outward, -shading)
        } else {
            (Side::Front, outward, shading)
        };
        SurfacePoint {
            triangle: hit.triangle,
            departure,
            material: object.material,
            side,
            normal: if normal.dot(view) < 0.0 { n_geom } else { normal },
            view,
        }
    }

    fn casts_shadows(&self) -> bool {
        self.prepared.scene.shadows == Shadows::On
    }
}
