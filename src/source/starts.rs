//! What the start points and directions of a ray set tell of its source, for `lampyris info`, for
//! scripts, and for the warning of start points that are not the source's.

use super::StartSurface;
use super::surface_fit::{FittedSurface, SurfaceFit, fit_surface};
use crate::geometry::DVec3;
use crate::light::RaySample;

/// Start points and directions of a ray set in figures.
#[derive(Debug, Clone, Copy)]
pub struct Starts {
    /// Lowest coordinates of the start points, mm.
    pub low: DVec3,
    /// Highest coordinates of the start points, mm.
    pub high: DVec3,
    /// Mean weighted by flux, not unit: of length 1 for a beam, 0 for light to all sides.
    pub mean_direction: DVec3,
    /// Share of the rays that go below the base plane (direction z < 0), 0 to 1.
    pub below_rays: f64,
    /// Share of the flux that goes below the base plane, 0 to 1.
    pub below_flux: f64,
    /// What the start points lie on, if it is a point, a plane, a sphere or a cylinder.
    pub surface: Option<SurfaceFit>,
    /// What the rays come from, where they do not start on it.
    pub inner_source: Option<InnerSource>,
}

/// A cylinder about a coordinate axis, without ends, that the rays' lines pass through.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InnerSource {
    /// Unit: x, y or z.
    pub axis: DVec3,
    /// The point that is nearest to all lines, mm.
    pub through: DVec3,
    /// 99.9 % of the lines pass within, mm.
    pub radius_mm: f64,
}

/// Fits run on at most this many rays, taken evenly.
const MOST_POINTS: usize = 20_000;

impl Starts {
    /// Looks at all rays; surfaces are fitted to 20,000 of them.
    pub fn of(samples: &[RaySample]) -> Self {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (mut flux, mut moment) = (0.0, DVec3::ZERO);
        let (mut below, mut below_flux) = (0u64, 0.0);
        for sample in samples {
            let (origin, direction) = (sample.origin(), sample.unit_direction());
            let weight = f64::from(sample.flux);
            low = low.min(origin);
            high = high.max(origin);
            flux += weight;
            moment += weight * direction;
            if direction.z < 0.0 {
                below += 1;
                below_flux += weight;
            }
        }
        let few: Vec<RaySample> =
            samples.iter().copied().step_by(samples.len().div_ceil(MOST_POINTS).max(1)).collect();
        let surface = fit_surface(&few.iter().map(RaySample::origin).collect::<Vec<_>>());
        Self {
            low,
            high,
            mean_direction: moment / flux,
            below_rays: below as f64 / samples.len() as f64,
            below_flux: below_flux / flux,
            inner_source: surface.and_then(|fit| inner_source(&few, fit.surface)),
            surface,
        }
    }

    /// Why near fields and optics will be wrong with these start points, and the remedy, if so.
    pub fn warning(&self) -> Option<String> {
        let surface = self.surface?.surface;
        let InnerSource { axis, through, radius_mm } = self.inner_source?;
        Some(format!(
            "the rays start on a {surface}, but come from within {:.4} mm of an axis: near fields \
             and optics will be wrong; give start = {{ axis = {}, through = {}, radius = … }} with \
             the source's own radius",
            radius_mm,
            braced(axis),
            braced(through),
        ))
    }

    /// A line for each finding but the surface, for people.
    pub fn lines(&self) -> Vec<String> {
        let (rays, flux) = (100.0 * self.below_rays, 100.0 * self.below_flux);
        let mut lines = vec![
            format!("start points: {} to {} mm", triple(self.low), triple(self.high)),
            format!("mean direction: {}", triple(self.mean_direction)),
            format!("below z = 0: {rays:.2} % of the rays, {flux:.2} % of the flux"),
        ];
        lines.extend(self.warning().map(|warning| format!("warning: {warning}")));
        lines
    }
}

/// The thinnest cylinder along x, y or z through the point nearest to all lines, if the rays start
/// on a closed surface at least twice as wide around it.
fn inner_source(rays: &[RaySample], start: FittedSurface) -> Option<InnerSource> {
    let start_radius_mm = match start {
        FittedSurface::Sphere { radius_mm, .. } | FittedSurface::Cylinder { radius_mm, .. } => {
            radius_mm
        }
        FittedSurface::Point { .. } | FittedSurface::Plane { .. } => return None,
    };
    let through = focus(rays)?;
    let candidates = DVec3::AXES.into_iter().filter_map(|axis| {
        let surface = StartSurface::axis(through, axis).ok()?;
        let distance = |s: &RaySample| surface.distance_mm(s.origin(), s.unit_direction());
        let mut distances: Vec<f64> = rays.iter().map(distance).collect();
        distances.sort_by(f64::total_cmp);
        let radius_mm = distances[(distances.len() - 1) * 999 / 1000];
        Some(InnerSource { axis, through, radius_mm })
    });
    let thinnest = candidates.min_by(|a, b| a.radius_mm.total_cmp(&b.radius_mm))?;
    (2.0 * thinnest.radius_mm < start_radius_mm).then_some(thinnest)
}

/// The point with the least sum of squared distances to the rays' lines.
pub(super) fn focus(rays: &[RaySample]) -> Option<DVec3> {
    let mut matrix = glam::DMat3::ZERO;
    let mut vector = DVec3::ZERO;
    for ray in rays {
        let d = ray.unit_direction();
        let across = glam::DMat3::IDENTITY - glam::DMat3::from_cols(d.x * d, d.y * d, d.z * d);
        matrix += across;
        vector += across * ray.origin();
    }
    // Parallel rays have no such point.
    let scale = rays.len() as f64;
    ((matrix / scale).determinant() > 1e-9).then(|| matrix.inverse() * vector)
}

/// Six digits: what text files hold.
fn triple(v: DVec3) -> String {
    let [x, y, z] = v.to_array().map(|c| c as f32);
    format!("({x}, {y}, {z})")
}

/// As a script writes it, to 0.1 µm.
fn braced(v: DVec3) -> String {
    let [x, y, z] = v.to_array().map(|c| (c * 1e4).round() / 1e4 + 0.0);
    format!("{{{x}, {y}, {z}}}")
}
