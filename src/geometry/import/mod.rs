//! Mesh files as CAD systems write them, told apart by content.
//!
//! Each reader fills `Polygons`; what follows is the same for all: choice of parts, welding,
//! cutting into triangles, normals.

mod encoding;
mod gltf;
mod obj;
mod parts;
mod ply;
mod polygons;
mod refused;
mod stl;

use std::path::Path;

use super::{Closure, Mesh};
use crate::error::{Error, Place, Result};
use crate::input;
use parts::PolygonRun;
use polygons::Polygons;

/// Which of a file's faces are wanted: those that have all of the names that are given.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Selection {
    /// One of the names after `g`; if no face has it, an object's.
    pub group: Option<Vec<u8>>,
    /// The name after `o`, of a glTF node, of an STL solid.
    pub object: Option<Vec<u8>>,
    /// The name after `usemtl`, of a glTF material.
    pub material: Option<Vec<u8>>,
}

/// How the shading normals come about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Interpolation {
    /// The file's own, else smooth up to the crease angle.
    Smooth,
    /// N = N_g.
    Flat,
}

/// What a file does not say.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshReading {
    /// The parts to read.
    pub selection: Selection,
    /// Length of the file's unit times the scale wanted, mm, > 0.
    pub unit_mm: f64,
    /// Vertices no farther apart are one, ≥ 0; 0: those exactly equal.
    pub weld_mm: f64,
    /// Where the file has neither normals nor smoothing groups, faces at a larger angle meet at a
    /// sharp edge; 0 to 180.
    pub crease_deg: f64,
    /// Shading normals.
    pub interpolation: Interpolation,
}

/// Faces of CAD parts meet at 90° or, at chamfers, 45°; tessellations of round parts stay below 30°.
pub const CREASE_DEG: f64 = 40.0;

impl Default for MeshReading {
    fn default() -> Self {
        Self {
            selection: Selection::default(),
            unit_mm: 1.0,
            weld_mm: 0.0,
            crease_deg: CREASE_DEG,
            interpolation: Interpolation::Smooth,
        }
    }
}

/// A mesh and what its file was taken for.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshFile {
    /// The wanted faces.
    pub mesh: Mesh,
    /// Such as "OBJ" or "binary STL".
    pub format: &'static str,
    /// Names of the groups that have faces, wanted or not, in the file's order.
    pub groups: Vec<String>,
    /// Names of the objects that have faces.
    pub objects: Vec<String>,
    /// Names of the materials that have faces.
    pub materials: Vec<String>,
    /// What was mended or left out, in words.
    pub warnings: Vec<String>,
}

impl MeshFile {
    /// What the format says of the unit, for a script that says nothing.
    pub fn unit_warning(&self) -> Option<String> {
        matches!(self.format, "glTF" | "GLB").then(|| {
            "glTF's lengths are in m, but are taken for mm: unit = \"m\", or unit = \"mm\" if they are"
                .to_owned()
        })
    }

    /// Whether its lengths look like mm: lamps are larger than 20 mm and smaller than 5 m.
    pub fn size_warning(&self) -> Option<String> {
        let [low, high] = self.mesh.bounds();
        let size_mm = (high - low).max_element();
        let (unit, mm) = match size_mm {
            size if size <= 0.0 => return None,
            ..2.0 => ("m", 1000.0),
            2.0..20.0 => ("inch", 25.4),
            5000.0.. => ("um", 1e-3),
            _ => return None,
        };
        let (size, other) = (Short(size_mm), Short(size_mm * mm));
        Some(format!(
            "is {size} mm across: if it should be {other} mm, its unit is not mm: unit = \"{unit}\""
        ))
    }

    /// Whether a closed mesh has its fronts inside.
    pub fn inside_out_warning(&self) -> Option<String> {
        let is_inside_out = self.mesh.volume_mm3() < 0.0 && Closure::of(&self.mesh).is_closed();
        is_inside_out.then(|| "its volume is negative: fronts are inside".to_owned())
    }

    /// Whether its vertex normals are those of its backs.
    pub fn normals_warning(&self) -> Option<String> {
        let opposed = self.mesh.opposed_share();
        (opposed > Mesh::OPPOSED_SHARE).then(|| {
            let percent = 100.0 * opposed;
            format!("vertex normals oppose the winding on {percent:.0} % of the area: shaded flat")
        })
    }
}

/// A number to three digits.
struct Short(f64);

impl std::fmt::Display for Short {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let digits = (2 - self.0.abs().log10().floor() as i32).clamp(0, 9) as usize;
        let text = format!("{:.digits$}", self.0);
        let has_point = text.contains('.');
        f.write_str(if has_point {
            text.trim_end_matches('0').trim_end_matches('.')
        } else {
            &text
        })
    }
}

/// What is wrong with a file, before it has a path.
#[derive(Debug, PartialEq)]
pub(super) struct MeshFault {
    pub place: Place,
    pub problem: String,
}

impl MeshFault {
    fn file(problem: impl Into<String>) -> Self {
        Self { place: Place::File, problem: problem.into() }
    }

    fn record(number: usize, problem: impl Into<String>) -> Self {
        Self { place: Place::Record(number as u64), problem: problem.into() }
    }
}

type MeshResult<T> = std::result::Result<T, MeshFault>;

/// What a format's reader finds.
struct Contents {
    format: &'static str,
    polygons: Polygons,
    warnings: Vec<String>,
}

/// Reads a mesh file: OBJ, STL, PLY, glTF or GLB.
///
/// Errors: [`Error::Io`]; [`Error::BadFile`] with the line or record; other formats, with how to
/// export; a part that is not there, with the names that are.
pub fn load(path: &Path, reading: &MeshReading) -> Result<MeshFile> {
    from_bytes(path, input::bytes(path)?, reading)
}

/// Names of the files beside a mesh, relative to its folder, that [`load`] reads with it: the buffers
/// of a glTF file.
///
/// Errors: [`Error::Io`].
pub fn companions(path: &Path) -> Result<Vec<String>> {
    const START: u64 = 4096;
    if !gltf::is_gltf(&encoding::to_ascii_based(input::head(path, START)?)) {
        return Ok(Vec::new());
    }
    Ok(gltf::buffer_files(&encoding::to_ascii_based(input::bytes(path)?)))
}

/// As [`load`], of a file's bytes; buffers beside a glTF file are looked for beside `path`.
pub fn from_bytes(path: &Path, bytes: Vec<u8>, reading: &MeshReading) -> Result<MeshFile> {
    parse(path, bytes, reading).map_err(|fault| Error::bad_file(path, fault.place, fault.problem))
}

/// Whether the file is a mesh for [`load`], by its first bytes and, for OBJ, its name.
pub fn is_mesh(path: &Path, start: &[u8]) -> bool {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
    let has = |name: &str| extension.eq_ignore_ascii_case(name);
    refused::advice(start).is_some_and(|advice| advice.is_of_mesh)
        || ply::is_ply(start)
        || start.starts_with(b"glTF")
        || ["obj", "stl", "gltf", "glb", "ply"].into_iter().any(has)
}

fn parse(path: &Path, bytes: Vec<u8>, reading: &MeshReading) -> MeshResult<MeshFile> {
    if let Some(advice) = refused::advice(&bytes) {
        return Err(MeshFault::file(advice.problem));
    }
    let contents = contents(path, bytes)?;
    let Contents { format, mut polygons, mut warnings } = contents;
    let chosen = polygons.parts.select(&reading.selection)?;
    if let Some(chosen) = chosen {
        polygons.keep(&chosen);
    }
    let names = |names: &parts::PartNames| names.with_faces().collect();
    let (groups, objects, materials) = (
        names(&polygons.parts.groups),
        names(&polygons.parts.objects),
        names(&polygons.parts.materials),
    );
    let mesh = polygons.into_mesh(reading, &mut warnings)?;
    Ok(MeshFile { mesh, format, groups, objects, materials, warnings })
}

fn contents(path: &Path, bytes: Vec<u8>) -> MeshResult<Contents> {
    let bytes = encoding::to_ascii_based(bytes);
    if ply::is_ply(&bytes) {
        return ply::parse(&bytes);
    }
    let first = bytes.trim_ascii_start();
    if gltf::is_gltf(&bytes) {
        return gltf::parse(&bytes, path.parent().unwrap_or(Path::new("")));
    }
    if stl::is_binary(&bytes) {
        return stl::parse_binary(&bytes);
    }
    if stl::is_ascii(first) {
        return stl::parse_ascii(&bytes);
    }
    if bytes.iter().take(4096).any(|&byte| byte == 0) {
        return match stl::announced(&bytes) {
            Some(problem) => Err(MeshFault::file(problem)),
            None => Err(MeshFault::file("is no mesh: neither OBJ, STL, PLY nor glTF")),
        };
    }
    obj::parse(bytes)
}

#[cfg(test)]
mod tests;
