//! Surfaces that shine: what a ray sees that meets a light source.
//!
//! An emitter's samples light the lobes (eq. 9), its surface is what rays see: a mesh in the set's
//! own coordinates, and the radiance that it sends from a place into a direction.

mod fit;
mod shape;
mod table;

use std::f64::consts::PI;
use std::sync::Arc;

use glam::DVec3;

pub use fit::fitted_shape;
pub use shape::Shape;
pub use table::{RadianceTable, TableRadiance};

use super::sequence::EvenSequence;
use crate::error::{Error, Result};
use crate::geometry::Mesh;
use crate::light::{RaySample, RaySet};

/// A shining surface; its back is black.
#[derive(Debug, Clone)]
pub struct Emitter {
    /// In the coordinates of the light's ray set; triangles counter-clockwise from the front.
    pub mesh: Arc<Mesh>,
    /// What the front sends.
    pub radiance: Radiance,
}

/// Radiance by place and direction.
#[derive(Debug, Clone)]
pub enum Radiance {
    /// The same from everywhere into every direction: Φ/(π A).
    Lambert {
        /// mm² in the set's own coordinates: what a closed, convex surface has, or less where it
        /// hides a part of its own light.
        area_mm2: f64,
    },
    /// As measured rays tell.
    Measured(Arc<RadianceTable>),
}

impl Emitter {
    /// L in lm m⁻² sr⁻¹ of a set of 1 lm at scale 1; `point` and `direction` (unit, away from the
    /// surface) in the set's coordinates.
    pub fn luminance_per_lm(&self, point: DVec3, direction: DVec3) -> f64 {
        const MM2_PER_M2: f64 = 1e6;
        MM2_PER_M2
            * match &self.radiance {
                Radiance::Lambert { area_mm2 } => 1.0 / (PI * area_mm2),
                Radiance::Measured(table) => table.at(point, direction).radiance,
            }
    }
}

/// Samples of a Lambert emitter: even over the mesh's area, about the triangles' normals.
///
/// Errors: a mesh without area; no flux, or too few or too many samples.
pub fn mesh_rayset(mesh: &Mesh, flux_lm: f64, (samples, seed): (usize, u64)) -> Result<RaySet> {
    super::filament::check_emitter("emitter", flux_lm, samples)?;
    let areas: Vec<f64> = (0..mesh.triangles.len()).map(|at| triangle_area(mesh, at)).collect();
    let total: f64 = areas.iter().sum();
    if !(total > 0.0 && total.is_finite()) {
        return Err(Error::inconsistent("emitter", "the mesh has no area"));
    }
    let sequence = EvenSequence::new(seed);
    let mut drawn = Vec::with_capacity(samples);
    let (mut before, mut taken) = (0.0, 0usize);
    for (at, area) in areas.iter().enumerate() {
        before += area;
        // As many as its share of the area, so that the samples stay even over the surface.
        let until = ((before / total) * samples as f64).round() as usize;
        let normal = mesh.geometric_normal(at);
        let corners = mesh.corners(at);
        for index in taken..until.min(samples) {
            let [u, v, ..] = sequence.point(index as u32);
            drawn.push(sample(place_in_triangle(corners, u, v), normal));
        }
        taken = until.max(taken);
    }
    Ok(RaySet::new(drawn.into(), flux_lm))
}

fn sample(position: DVec3, direction: DVec3) -> RaySample {
    RaySample {
        position: position.as_vec3().to_array(),
        direction: direction.as_vec3().to_array(),
        flux: 1.0,
    }
}

/// Even over the triangle as (u, v) runs over the unit square.
fn place_in_triangle([a, b, c]: [DVec3; 3], u: f64, v: f64) -> DVec3 {
    let root = u.sqrt();
    a * (1.0 - root) + b * (root * (1.0 - v)) + c * (root * v)
}

/// mm².
pub fn mesh_area(mesh: &Mesh) -> f64 {
    (0..mesh.triangles.len()).map(|at| triangle_area(mesh, at)).sum()
}

fn triangle_area(mesh: &Mesh, at: usize) -> f64 {
    let [a, b, c] = mesh.corners(at);
    0.5 * (b - a).cross(c - a).length()
}

/// A ray set as an emitter of the given shape: its rays moved back onto the surface, the radiance a
/// table of them, and new samples from that table.
///
/// Errors: a shape that f32 cannot hold; no ray that leaves it outward.
pub fn measured_emitter(rays: &RaySet, shape: Shape, seed: u64) -> Result<(RaySet, Emitter)> {
    let table = RadianceTable::new(&rays.samples, shape)?;
    let count = rays.samples.len().clamp(20_000, 200_000);
    let (samples, exponent) = table.samples(count, seed);
    let set = RaySet { samples: samples.into(), exponent, ..rays.clone() };
    let mesh = Arc::new(shape.mesh()?);
    Ok((set, Emitter { mesh, radiance: Radiance::Measured(Arc::new(table)) }))
}
