//! What a ray brings back: the local (eq. 2, 9) and the global (eq. 1) terms.
//!
//! A camera ray becomes a binary tree of mirrored and transmitted rays. `walk` follows it, for the
//! picture (here), for figures (`paths`) and for the check of light sums (`light_check`); `global`
//! makes the rays that leave a hit, `local` adds what the lights send there, and `surroundings` what comes from far away. Each ray carries the
//! throughput of all bands, so the scalar sum over light samples is done once per hit and not once
//! per band.

mod darkness;
mod global;
mod interface;
mod interreflection;
mod layers;
mod light_check;
mod local;
mod media;
mod paths;
mod shadow;
mod surroundings;
mod walk;

pub use darkness::Darkness;
pub use interreflection::prepare;
pub use layers::{LayeredSum, Layers};
pub use light_check::LightCheck;
pub use paths::{PathEnd, PathSegment};
pub use walk::RayKind;

use crate::geometry::Ray;
use crate::scene::{Prepared, SpectralTables};
use crate::spectrum::Bands;
use layers::Origin;
use walk::{Arrival, Branch, EmitterPoint};

/// Where the tree of rays ends, and how exact the sum over light samples is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TraceLimits {
    /// Hits at this depth have no children; the camera ray's hit has depth 0.
    pub max_depth: u32,
    /// A ray whose throughput is below this in every band adds nothing.
    pub min_throughput: f64,
    /// Bound on the relative error of the sum over light samples; 0 is the exact sum.
    pub light_error: f64,
    /// Directions into which a ray splits that meets an index n(λ), 1 to 81; 1 does not split.
    pub dispersion: u32,
}

impl Default for TraceLimits {
    fn default() -> Self {
        Self { max_depth: 8, min_throughput: 1e-3, light_error: 0.01, dispersion: 1 }
    }
}

impl TraceLimits {
    /// A depth that rays end at by their throughput, not by their number: light guides have hundreds
    /// of total reflections. It only ends rays between mirrors that lose nothing.
    pub const ANY_DEPTH: u32 = 10_000;
}

/// What was traced and evaluated.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct TraceCounts {
    /// Rays from the eye.
    pub camera_rays: u64,
    /// Mirrored rays.
    pub mirror_rays: u64,
    /// Rays that went on through a surface.
    pub transmitted_rays: u64,
    /// Segments toward light that were tested for obstacles.
    pub shadow_rays: u64,
    /// Hits that asked the lights.
    pub light_sums: u64,
    /// Nodes of light trees that were evaluated.
    pub light_nodes: u64,
    /// Light samples that were summed one by one.
    pub light_samples: u64,
    /// Rays that ended at `max_depth` with more than a hundredth of their light in some band.
    pub rays_cut: u64,
    /// The lowest pair of opaque objects that lie in one place and face a ray alike.
    pub clash: Option<[usize; 2]>,
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
            rays_cut: self.rays_cut + other.rays_cut,
            clash: [self.clash, other.clash].into_iter().flatten().min(),
        }
    }
}

impl TraceCounts {
    /// Rays and light sums, which tell about how long tracing takes.
    pub fn steps(&self) -> u64 {
        self.camera_rays
            + self.mirror_rays
            + self.transmitted_rays
            + self.shadow_rays
            + self.light_sums
    }

    /// What pictures lack, in words.
    pub fn warnings(&self) -> Vec<String> {
        /// Share of all camera rays: fewer show nowhere.
        const TOLD: f64 = 1e-3;
        let Self { camera_rays, rays_cut, clash, .. } = *self;
        let mut warnings = Vec::new();
        if rays_cut as f64 > TOLD * camera_rays as f64 {
            warnings.push(format!(
                "render: {rays_cut} rays (of {camera_rays} from the camera) ended at max_depth with more \
                 than 1 % of their light: a higher max_depth, or \"auto\", follows them"
            ));
        }
        if let Some([a, b]) = clash {
            warnings.push(format!(
                "scene: objects {} and {} are opaque and lie in one place, facing the same way: the \
                 picture shows object {}",
                a + 1,
                b + 1,
                a + 1
            ));
        }
        warnings
    }
}

/// Traces rays through a prepared scene at the bands of its tables.
#[derive(Debug, Clone, Copy)]
pub struct Tracer<'a> {
    /// What is looked at.
    pub prepared: &'a Prepared,
    /// The scene's spectra at the bands.
    pub tables: &'a SpectralTables,
    /// When a ray ends.
    pub limits: TraceLimits,
}

/// One thread's working memory.
#[derive(Debug, Default)]
pub struct TraceState {
    pending: Vec<Branch>,
    /// What was done so far.
    pub counts: TraceCounts,
    /// Σ over hits of the estimated error of their light sums, in the luminance that reaches the
    /// camera (unit of Y).
    pub luminance_error: f64,
}

impl Tracer<'_> {
    /// Adds the spectral radiance that arrives along `ray` to `sum`.
    pub fn trace(&self, ray: Ray, state: &mut TraceState, sum: &mut Bands) {
        let mut sum = LayeredSum { whole: sum, parts: &mut [], layers: Layers::None };
        self.trace_layers(ray, state, &mut sum);
    }

    /// The same, parted into layers.
    pub fn trace_layers(&self, ray: Ray, state: &mut TraceState, sum: &mut LayeredSum) {
        state.counts.camera_rays += 1;
        self.walk(ray, state, |branch, arrival, state| match arrival {
            Arrival::Missed => sum.add(Origin::Surroundings, branch.kind, |sum| {
                self.add_background(branch, sum);
            }),
            Arrival::Cut | Arrival::Passed(..) => {}
            Arrival::Hit(surface) => self.add_local(surface, branch, state, sum),
            Arrival::Emitter(point) => self.add_emitted(point, branch, sum),
        });
    }

    /// L of the surface's front; its back is black.
    fn add_emitted(&self, at: &EmitterPoint, branch: &Branch, sum: &mut LayeredSum) {
        if at.departure.n_geom.dot(at.view) <= 0.0 {
            return;
        }
        let emitter = &self.prepared.emitters[at.emitter];
        let mut arriving = branch.throughput.clone();
        let luminance = emitter.luminance(at.departure.point, at.view);
        arriving.scale_by(luminance, &self.tables.lights[emitter.light]);
        sum.add(Origin::Light(emitter.light), branch.kind, |sum| sum.add(&arriving));
    }
}
