//! What a ray file holds, for `lampyris info`.

use std::fmt;

use super::StartSurface;
use super::rayfile::{RayFile, SpectrumSource};
use super::surface_fit::{FittedSurface, SurfaceFit, fit_surface};
use crate::geometry::DVec3;
use crate::light::RaySample;

/// A ray file's content in figures. Lengths in mm.
#[derive(Debug, Clone)]
pub struct RayReport<'a> {
    file: &'a RayFile,
    pub low: DVec3,
    pub high: DVec3,
    /// Flux-weighted, not unit: 1 for a beam, 0 for light to all sides.
    pub mean_direction: DVec3,
    /// Share of the rays, and of their flux, that goes below the base plane (direction z < 0).
    pub below_rays: f64,
    pub below_flux: f64,
    pub start_surface: Option<SurfaceFit>,
    /// What the rays come from, where they do not start on it.
    pub emitter: Option<Emitter>,
}

/// A cylinder about a coordinate axis through which the rays' lines pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Emitter {
    pub axis: DVec3,
    pub through: DVec3,
    /// 99.9 % of the lines pass within.
    pub radius_mm: f64,
}

/// Fits run on at most this many rays, taken evenly.
const MOST_POINTS: usize = 20_000;

impl<'a> RayReport<'a> {
    pub fn new(file: &'a RayFile) -> Self {
        let samples = &file.samples;
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (mut flux, mut moment) = (0.0, DVec3::ZERO);
        let (mut below, mut below_flux) = (0u64, 0.0);
        for sample in samples.iter() {
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
        let start_surface = fit_surface(&few.iter().map(RaySample::origin).collect::<Vec<_>>());
        Self {
            file,
            low,
            high,
            mean_direction: moment / flux,
            below_rays: below as f64 / samples.len() as f64,
            below_flux: below_flux / flux,
            emitter: start_surface.and_then(|fit| emitter(&few, fit.surface)),
            start_surface,
        }
    }
}

/// The thinnest cylinder along x, y or z through the point nearest to all lines, if the rays start
/// on a closed surface at least twice as wide around it.
fn emitter(rays: &[RaySample], start: FittedSurface) -> Option<Emitter> {
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
        Some(Emitter { axis, through, radius_mm })
    });
    let thinnest = candidates.min_by(|a, b| a.radius_mm.total_cmp(&b.radius_mm))?;
    (2.0 * thinnest.radius_mm < start_radius_mm).then_some(thinnest)
}

/// The point with the least sum of squared distances to the rays' lines.
fn focus(rays: &[RaySample]) -> Option<DVec3> {
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

impl fmt::Display for RayReport<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let file = self.file;
        writeln!(f, "format          {}", file.format)?;
        writeln!(f, "rays            {}", file.samples.len())?;
        let unit = file.flux_unit;
        match file.header_flux {
            Some(header) => writeln!(f, "header flux     {} {unit}", header as f32)?,
            None => writeln!(f, "header flux     not stated")?,
        }
        writeln!(f, "sum of rays     {} {unit}", file.flux_sum as f32)?;
        match file.flux_lm {
            Some(lumens) => writeln!(f, "luminous flux   {} lm", lumens as f32)?,
            None => writeln!(f, "luminous flux   needs a spectrum")?,
        }
        writeln!(f, "start points    {} to {} mm", triple(self.low), triple(self.high))?;
        writeln!(f, "mean direction  {}", triple(self.mean_direction))?;
        let (rays, flux) = (100.0 * self.below_rays, 100.0 * self.below_flux);
        writeln!(f, "below base      {rays:.2} % of the rays, {flux:.2} % of the flux")?;
        write!(f, "spectrum        ")?;
        match file.spectrum_source {
            SpectrumSource::None => writeln!(f, "none")?,
            SpectrumSource::Line { nm } => writeln!(f, "one wavelength, {nm} nm")?,
            SpectrumSource::PerRay { min_nm, max_nm } => {
                writeln!(f, "a wavelength a ray, {} to {} nm", min_nm as f32, max_nm as f32)?;
            }
            SpectrumSource::Table => writeln!(f, "one table")?,
            SpectrumSource::Mixture { tables } => writeln!(f, "{tables} tables, one a ray")?,
        }
        self.fmt_geometry(f)?;
        for (name, text) in &file.description {
            writeln!(f, "{name:<15} {text}")?;
        }
        for warning in &file.warnings {
            writeln!(f, "problem         {warning}")?;
        }
        Ok(())
    }
}

impl RayReport<'_> {
    fn fmt_geometry(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.start_surface {
            Some(fit) => {
                let SurfaceFit { surface, rms_mm, share } = fit;
                let share = 100.0 * share;
                writeln!(
                    f,
                    "start surface   {surface}, rms {rms_mm:.1e} mm, {share:.1} % of rays"
                )?;
            }
            None => writeln!(f, "start surface   no point, plane, sphere or cylinder")?,
        }
        let Some(Emitter { axis, through, radius_mm }) = self.emitter else { return Ok(()) };
        let radius = radius_mm as f32;
        writeln!(
            f,
            "problem         the rays start far from what emits them, which lies within {radius} mm \
             of an axis: start = {{ axis = {{{}, {}, {}}}, through = {{{:.4}, {:.4}, {:.4}}} }}",
            axis.x, axis.y, axis.z, through.x, through.y, through.z
        )
    }
}
