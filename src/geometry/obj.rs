//! Wavefront OBJ import and export.

use std::fmt::Write as _;
use std::io::Cursor;
use std::path::Path;

use super::DVec3;
use super::mesh::{Mesh, Shading};
use crate::error::{Error, Place, Result};

/// Reads the faces of a file, or of one named group (`g` or `o`) of it, as one mesh.
///
/// Faces share vertices by position index, also across groups and materials. Corners with a `vn`
/// keep it (normalized); the others get the mean of the adjoining faces' normals.
///
/// Errors: [`Error::Io`]; [`Error::BadFile`] with the line; a group that is not there, with the
/// names that are.
pub fn load(path: &Path, group: Option<&str>) -> Result<Mesh> {
    let text = std::fs::read(path).map_err(|e| Error::io(path, e))?;
    let text = String::from_utf8_lossy(&text);
    parse(&text, group).map_err(|fault| Error::bad_file(path, fault.place, fault.problem))
}

/// What is wrong with a text, before it has a path.
#[derive(Debug, PartialEq)]
struct Fault {
    place: Place,
    problem: String,
}

impl Fault {
    fn line(number: usize, problem: impl Into<String>) -> Self {
        Self { place: Place::Line(number as u64), problem: problem.into() }
    }

    fn file(problem: impl Into<String>) -> Self {
        Self { place: Place::File, problem: problem.into() }
    }
}

fn parse(text: &str, group: Option<&str>) -> std::result::Result<Mesh, Fault> {
    let selection = Selection::from_text(text, group)?;
    let mut reader = Cursor::new(selection.text.as_bytes());
    let options = tobj::LoadOptions { triangulate: true, ..Default::default() };
    let loaded = tobj::load_obj_buf(&mut reader, &options, |_| Ok(Default::default()));
    let (models, _) = loaded.map_err(|error| {
        // tobj stops at the line it cannot read: what it has consumed ends there.
        let consumed = (reader.position() as usize).min(selection.text.len());
        let line = selection.text.as_bytes()[..consumed].iter().filter(|&&b| b == b'\n').count();
        Fault::line(line, format!("{error}"))
    })?;
    // One model: the selection has faces, and neither groups nor materials.
    match models.into_iter().next() {
        Some(model) => mesh_from_model(model.mesh, &selection),
        None => Err(Fault::file("no faces")),
    }
}

/// The lines that tobj is to read, one for one with the file's, and what it does not keep.
struct Selection {
    text: String,
    faces: Vec<FaceLine>,
    has_normals: bool,
}

struct FaceLine {
    line: usize,
    triangles: usize,
    has_normals: bool,
}

impl Selection {
    /// Keeps `v`, `vn` and the wanted `f` lines. Groups and materials would make tobj split the
    /// mesh and forget which faces share a position.
    fn from_text(text: &str, wanted: Option<&str>) -> std::result::Result<Self, Fault> {
        let mut selection =
            Self { text: String::with_capacity(text.len()), faces: Vec::new(), has_normals: false };
        let mut names: Vec<&str> = Vec::new();
        let (mut in_group, mut counts) = (wanted.is_none(), [0, 0]);
        for (number, line) in (1..).zip(text.lines()) {
            let line = line.trim();
            let (tag, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
            match tag {
                "v" => {
                    counts[0] += 1;
                    selection.push_vertex(number, rest)?;
                }
                "vn" => {
                    counts[1] += 1;
                    selection.has_normals = true;
                    check_numbers(number, "normal", rest)?;
                    selection.text.push_str(line);
                }
                "g" | "o" => {
                    names.push(rest.trim());
                    in_group = wanted.is_none_or(|name| {
                        name == rest.trim() || rest.split_whitespace().any(|n| n == name)
                    });
                }
                "f" if in_group => {
                    selection.faces.push(FaceLine::checked(number, rest, counts)?);
                    selection.text.push_str("f ");
                    selection.push_corners(rest);
                }
                _ => {}
            }
            selection.text.push('\n');
        }
        match wanted {
            Some(name) if selection.faces.is_empty() => Err(unknown_group(name, &names)),
            None if selection.faces.is_empty() => Err(Fault::file("no faces")),
            _ => Ok(selection),
        }
    }

    /// x y z and the optional w; colors are of no use here.
    fn push_vertex(&mut self, line: usize, rest: &str) -> std::result::Result<(), Fault> {
        check_numbers(line, "position", rest)?;
        let fields: Vec<&str> = rest.split_whitespace().collect();
        let keep = if fields.len() == 4 { 4 } else { 3 };
        self.text.push_str("v ");
        self.text.push_str(&fields[..keep].join(" "));
        Ok(())
    }

    /// Corners as `position//normal`: texture coordinates are of no use here.
    fn push_corners(&mut self, rest: &str) {
        for corner in rest.split_whitespace() {
            let mut fields = corner.split('/');
            let position = fields.next().unwrap_or_default();
            match fields.nth(1) {
                Some(normal) if !normal.is_empty() => {
                    let _ = write!(self.text, "{position}//{normal} ");
                }
                _ => {
                    let _ = write!(self.text, "{position} ");
                }
            }
        }
    }
}

impl FaceLine {
    /// `counts`: positions and normals read so far, which relative (negative) indices count from.
    fn checked(line: usize, rest: &str, counts: [usize; 2]) -> std::result::Result<Self, Fault> {
        let (mut corners, mut with_normal) = (0, 0);
        for corner in rest.split_whitespace() {
            let mut fields = corner.split('/');
            check_index(line, "position", fields.next().unwrap_or_default(), counts[0])?;
            if let Some(normal) = fields.nth(1).filter(|field| !field.is_empty()) {
                check_index(line, "normal", normal, counts[1])?;
                with_normal += 1;
            }
            corners += 1;
        }
        if corners < 3 {
            return Err(Fault::line(
                line,
                format!("face has {corners} corners, expected 3 or more"),
            ));
        }
        Ok(Self { line, triangles: corners - 2, has_normals: with_normal == corners })
    }
}

/// At least three finite numbers.
fn check_numbers(line: usize, what: &str, rest: &str) -> std::result::Result<(), Fault> {
    let mut count = 0;
    for field in rest.split_whitespace().take(4) {
        match field.parse::<f64>() {
            Ok(value) if value.is_finite() => count += 1,
            Ok(value) => {
                return Err(Fault::line(
                    line,
                    format!("{what} has {value}, expected finite numbers"),
                ));
            }
            Err(_) => {
                return Err(Fault::line(
                    line,
                    format!("{what} has \"{field}\", expected a number"),
                ));
            }
        }
    }
    if count < 3 {
        return Err(Fault::line(line, format!("{what} has {count} numbers, expected x y z")));
    }
    Ok(())
}

/// 1 to `count`, or −count to −1.
fn check_index(
    line: usize,
    what: &str,
    field: &str,
    count: usize,
) -> std::result::Result<(), Fault> {
    let index: i64 = field.parse().map_err(|_| {
        Fault::line(line, format!("{what} index is \"{field}\", expected a number"))
    })?;
    if index == 0 || index.unsigned_abs() > count as u64 {
        return Err(Fault::line(
            line,
            format!(
                "{what} index is {index}, allowed: 1 to {count} above this line, or −{count} to −1"
            ),
        ));
    }
    Ok(())
}

fn unknown_group(wanted: &str, names: &[&str]) -> Fault {
    let mut names: Vec<&str> = names.to_vec();
    names.sort_unstable();
    names.dedup();
    Fault::file(format!("no faces in group \"{wanted}\" (groups: {})", names.join(", ")))
}

fn mesh_from_model(model: tobj::Mesh, selection: &Selection) -> std::result::Result<Mesh, Fault> {
    let triples = |indices: &[u32]| -> Vec<[u32; 3]> { indices.as_chunks().0.to_vec() };
    let vectors = |values: &[f64]| -> Vec<DVec3> {
        values.as_chunks().0.iter().map(|&v| DVec3::from_array(v)).collect()
    };
    let positions = vectors(&model.positions);
    if let Some(bad) = positions.iter().find(|p| !p.is_finite()) {
        return Err(Fault::file(format!("position {bad} is not finite after its division by w")));
    }
    let mesh = Mesh::smooth("mesh", positions, triples(&model.indices))
        .map_err(|e| Fault::file(e.to_string()))?;
    if !selection.has_normals || selection.faces.iter().all(|face| !face.has_normals) {
        return Ok(mesh);
    }
    let shading = per_corner_shading(
        &mesh,
        vectors(&model.normals),
        triples(&model.normal_indices),
        &selection.faces,
    )?;
    Ok(Mesh { shading, ..mesh })
}

/// The file's normals where a face has them, the computed ones where it has none.
fn per_corner_shading(
    mesh: &Mesh,
    mut normals: Vec<DVec3>,
    mut corners: Vec<[u32; 3]>,
    faces: &[FaceLine],
) -> std::result::Result<Shading, Fault> {
    let Shading::PerPosition(computed) = &mesh.shading else {
        return Ok(mesh.shading.clone());
    };
    for normal in &mut normals {
        *normal = normal.try_normalize().unwrap_or(DVec3::ZERO);
    }
    let first_computed = normals.len() as u32;
    if faces.iter().any(|face| !face.has_normals) {
        normals.extend(computed);
    }
    let mut next = 0;
    for face in faces {
        for triangle in next..next + face.triangles {
            let (Some(corner), Some(positions)) =
                (corners.get_mut(triangle), mesh.triangles.get(triangle))
            else {
                return Err(Fault::line(face.line, "face could not be triangulated"));
            };
            if !face.has_normals {
                *corner = positions.map(|position| first_computed + position);
            }
        }
        next += face.triangles;
    }
    Ok(Shading::PerCorner { normals, triangles: corners })
}

/// The mesh as OBJ text; reading it back gives the same bits.
pub fn to_text(mesh: &Mesh) -> String {
    let mut text = String::from("# lengths in mm\n");
    let mut put = |tag: &str, v: &DVec3| {
        let _ = writeln!(text, "{tag} {} {} {}", v.x, v.y, v.z);
    };
    mesh.positions.iter().for_each(|p| put("v", p));
    let corner_normals = match &mesh.shading {
        Shading::Flat | Shading::PerPosition(_) => None,
        Shading::PerCorner { normals, triangles } => {
            normals.iter().for_each(|n| put("vn", n));
            Some(triangles)
        }
    };
    for (at, triangle) in mesh.triangles.iter().enumerate() {
        text.push('f');
        for (k, index) in triangle.iter().enumerate() {
            let _ = match corner_normals {
                Some(normals) => write!(text, " {}//{}", index + 1, normals[at][k] + 1),
                None => write!(text, " {}", index + 1),
            };
        }
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    const QUAD: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

    fn problem(text: &str, group: Option<&str>) -> (Place, String) {
        let fault = parse(text, group).unwrap_err();
        (fault.place, fault.problem)
    }

    #[test]
    fn quads_and_negative_indices() {
        let mesh = parse(&format!("{QUAD}f 1 2 3 4\n"), None).unwrap();
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
        let relative = parse(&format!("{QUAD}f -4 -3 -2 -1\n"), None).unwrap();
        assert_eq!(relative, mesh);
    }

    #[test]
    fn positions_stay_shared_across_groups_and_materials() {
        let text = format!("{QUAD}g a\nusemtl x\nf 1 2 3\ng b\nusemtl y\nf 1 3 4\n");
        let mesh = parse(&text, None).unwrap();
        assert_eq!(mesh.positions.len(), 4);
        assert_eq!(parse(&text, Some("b")).unwrap().triangles.len(), 1);
    }

    /// A face without normals between faces with normals gets computed ones, not its neighbor's.
    #[test]
    fn missing_normals_are_computed_face_by_face() {
        let text = format!("{QUAD}vn 0.6 0 0.8\nf 1//1 2//1 3//1\nf 1 3 4\n");
        let mesh = parse(&text, None).unwrap();
        let normal = |t| mesh.shading_normal(t, [0.2, 0.2], mesh.geometric_normal(t));
        assert!((normal(0) - DVec3::new(0.6, 0.0, 0.8)).length() < 1e-15);
        assert_eq!(normal(1), DVec3::Z);
    }

    #[test]
    fn faults_name_their_line() {
        assert_eq!(
            problem("v 0 0 nan\n", None),
            (Place::Line(1), "position has NaN, expected finite numbers".into())
        );
        assert_eq!(
            problem("# x\nv 0 zero 0\n", None),
            (Place::Line(2), "position has \"zero\", expected a number".into())
        );
        assert_eq!(
            problem("v 0 0\n", None),
            (Place::Line(1), "position has 2 numbers, expected x y z".into())
        );
        assert_eq!(
            problem(&format!("{QUAD}f 1 2 7\n"), None),
            (
                Place::Line(5),
                "position index is 7, allowed: 1 to 4 above this line, or −4 to −1".into()
            )
        );
        assert_eq!(
            problem(&format!("{QUAD}f 1 2\n"), None),
            (Place::Line(5), "face has 2 corners, expected 3 or more".into())
        );
        assert_eq!(problem("", None), (Place::File, "no faces".into()));
        assert_eq!(
            problem(&format!("{QUAD}g lens\nf 1 2 3\n"), Some("lense")),
            (Place::File, "no faces in group \"lense\" (groups: lens)".into())
        );
    }

    #[test]
    fn writing_and_reading_gives_the_same_bits() {
        let text = format!(
            "{QUAD}v 0.1 1e-300 3.3333333333333335\nvn 0.6 0 0.8\n\
             f 1//1 2//1 3//1\nf 1//1 3//1 5//1\nf 1//1 5//1 4//1\n"
        );
        let mesh = parse(&text, None).unwrap();
        assert_eq!(parse(&to_text(&mesh), None).unwrap(), mesh);
    }
}
