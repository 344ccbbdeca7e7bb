//! From a file's polygons to a mesh.

use super::parts::Parts;
use super::{Interpolation, MeshFault, MeshReading, MeshResult};
use crate::geometry::mesh::Shading;
use crate::geometry::normals::{Smoothing, creased};
use crate::geometry::polygon::Triangulator;
use crate::geometry::weld::weld;
use crate::geometry::{DVec3, Mesh};

/// A corner without a normal.
pub(super) const NONE: u32 = u32::MAX;

/// Polygons as a file holds them. All places are valid, the numbers finite.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Polygons {
    pub positions: Vec<DVec3>,
    /// Vectors of any length.
    pub normals: Vec<DVec3>,
    /// Places in `positions`, polygon after polygon.
    pub corners: Vec<u32>,
    /// A place in `normals` for each corner, or [`NONE`]; empty if no corner has one.
    pub corner_normals: Vec<u32>,
    /// Where each polygon ends in `corners`.
    pub ends: Vec<u32>,
    pub parts: Parts,
}

/// Triangles cut from polygons, and what they keep of them.
#[derive(Default)]
struct Cut {
    triangles: Vec<[u32; 3]>,
    /// As `triangles`, or empty.
    normals: Vec<[u32; 3]>,
    /// From which triangle on which smoothing holds.
    smoothing: Vec<(u32, Smoothing)>,
}

impl Polygons {
    /// Ends a polygon of the corners that were pushed since the last.
    pub fn end_polygon(&mut self) {
        self.ends.push(self.corners.len() as u32);
    }

    /// To be called once, after the last polygon.
    pub fn finish(&mut self) {
        self.parts.polygons = self.ends.len() as u32;
        self.parts.note_faces();
    }

    fn corners_of(&self, polygon: usize) -> std::ops::Range<usize> {
        let start = if polygon == 0 { 0 } else { self.ends[polygon - 1] };
        start as usize..self.ends[polygon] as usize
    }

    /// Keeps the polygons of these runs, in their order.
    pub fn keep(&mut self, runs: &[usize]) {
        let (mut corners, mut corner_normals, mut ends) = (Vec::new(), Vec::new(), Vec::new());
        let mut kept = Vec::new();
        for &run in runs {
            kept.push(super::PolygonRun { first: ends.len() as u32, ..self.parts.runs[run] });
            for polygon in self.parts.polygons_of(run) {
                let range = self.corners_of(polygon as usize);
                corners.extend(&self.corners[range.clone()]);
                corner_normals.extend(self.corner_normals.get(range).unwrap_or_default());
                ends.push(corners.len() as u32);
            }
        }
        self.parts.polygons = ends.len() as u32;
        self.parts.runs = kept;
        (self.corners, self.corner_normals, self.ends) = (corners, corner_normals, ends);
    }

    /// Scaled, welded, cut, with normals. Errors: no faces.
    pub fn into_mesh(
        mut self,
        reading: &MeshReading,
        warnings: &mut Vec<String>,
    ) -> MeshResult<Mesh> {
        if self.ends.is_empty() {
            return Err(MeshFault::file("no faces"));
        }
        if reading.unit_mm != 1.0 {
            self.positions.iter_mut().for_each(|p| *p *= reading.unit_mm);
            if let Some(p) = self.positions.iter().find(|p| !p.is_finite()) {
                return Err(MeshFault::file(format!(
                    "position {p} is not finite once it is scaled"
                )));
            }
        }
        self.weld(reading.weld_mm);
        let cut = self.cut();
        self.warn_of_flat_faces(&cut, warnings);
        let Self { positions, normals, .. } = self;
        let Cut { triangles, normals: corner_normals, smoothing } = cut;
        let mesh = Mesh::flat("mesh", positions, triangles).map_err(|_| {
            MeshFault::file("all faces have fewer than 3 corners apart: a unit or weld too large?")
        })?;
        Ok(match reading.interpolation {
            Interpolation::Flat => mesh,
            Interpolation::Smooth => {
                let own = OwnNormals { normals, triangles: corner_normals };
                let shading = own.shading(&mesh, reading.crease_deg, &smoothing);
                Mesh { shading, ..mesh }
            }
        })
    }

    fn weld(&mut self, weld_mm: f64) {
        let mut used = vec![false; self.positions.len()];
        self.corners.iter().for_each(|&corner| used[corner as usize] = true);
        let places = weld(&mut self.positions, &used, weld_mm);
        self.corners.iter_mut().for_each(|corner| *corner = places[*corner as usize]);
    }

    /// All polygons as triangles; corners that repeat the one before are left out.
    fn cut(&mut self) -> Cut {
        let mut cut = Cut::default();
        cut.triangles
            .reserve_exact(self.corners.len() - 2 * self.ends.len().min(self.corners.len() / 2));
        let mut triangulator = Triangulator::default();
        let mut runs = self.parts.runs.iter().peekable();
        let (mut start, mut ring, mut points) = (0, Vec::new(), Vec::new());
        for (polygon, &end) in (0..).zip(&self.ends) {
            while let Some(run) = runs.next_if(|run| run.first <= polygon) {
                cut.smoothing.push((cut.triangles.len() as u32, run.smoothing));
            }
            let range = start..end as usize;
            start = end as usize;
            let corners = &self.corners[range.clone()];
            if let &[a, b, c] = corners {
                if a != b && b != c && c != a {
                    cut.triangles.push([a, b, c]);
                    if let Some(&[a, b, c]) = self.corner_normals.get(range) {
                        cut.normals.push([a, b, c]);
                    }
                }
                continue;
            }
            ring.clear();
            ring.extend(range.filter(|&at| {
                self.corners[at] != self.corners[self.before(at, corners.len(), end)]
            }));
            points.clear();
            points.extend(ring.iter().map(|&at| self.positions[self.corners[at] as usize]));
            triangulator.cut(&points, |places| {
                cut.triangles.push(places.map(|place| self.corners[ring[place]]));
                if !self.corner_normals.is_empty() {
                    cut.normals.push(places.map(|place| self.corner_normals[ring[place]]));
                }
            });
        }
        self.corners = Vec::new();
        self.corner_normals = Vec::new();
        cut
    }

    /// The corner before, around a polygon of `count` corners that ends at `end`.
    fn before(&self, at: usize, count: usize, end: u32) -> usize {
        if at + count == end as usize { end as usize - 1 } else { at - 1 }
    }

    fn warn_of_flat_faces(&self, cut: &Cut, warnings: &mut Vec<String>) {
        if cut.triangles.is_empty() {
            return;
        }
        let lost = self.parts.polygons as usize;
        let lost = lost.saturating_sub(cut.triangles.len());
        if lost > 0 {
            warnings.push(format!("at least {lost} faces have shrunk to an edge and are left out"));
        }
    }
}

/// The file's normals.
struct OwnNormals {
    normals: Vec<DVec3>,
    /// As the mesh's triangles, or empty.
    triangles: Vec<[u32; 3]>,
}

impl OwnNormals {
    /// The file's normals where a face has them at all corners, else made ones.
    fn shading(mut self, mesh: &Mesh, crease_deg: f64, smoothing: &[(u32, Smoothing)]) -> Shading {
        let has_all = |corners: &[u32; 3]| !corners.contains(&NONE);
        if !self.triangles.iter().any(has_all) {
            return creased(mesh, crease_deg, smoothing);
        }
        self.normals.iter_mut().for_each(|normal| *normal = to_unit(*normal));
        if !self.triangles.iter().all(has_all) {
            self.fill_in(mesh, creased(mesh, crease_deg, smoothing));
        }
        let Self { normals, triangles } = self;
        if normals.len() == mesh.positions.len() && triangles == mesh.triangles {
            return Shading::PerPosition(normals);
        }
        Shading::PerCorner { normals, triangles }
    }

    fn fill_in(&mut self, mesh: &Mesh, made: Shading) {
        let first = self.normals.len() as u32;
        let (normals, places) = match &made {
            Shading::PerCorner { normals, triangles } => (normals, triangles),
            Shading::PerPosition(normals) => (normals, &mesh.triangles),
            Shading::Flat => return,
        };
        self.normals.extend(normals);
        for (own, made) in self.triangles.iter_mut().zip(places) {
            if own.contains(&NONE) {
                *own = made.map(|place| first + place);
            }
        }
    }
}

/// Unit, or zero; one that is unit to rounding keeps its bits.
fn to_unit(normal: DVec3) -> DVec3 {
    const ROUNDING: f64 = 4.0 * f64::EPSILON;
    if (normal.length_squared() - 1.0).abs() <= ROUNDING {
        return normal;
    }
    let largest = normal.abs().max_element();
    if largest > 0.0 { (normal / largest).normalize_or_zero() } else { DVec3::ZERO }
}
