//! STL, binary and ASCII: triangles without anything in common.
//!
//! Read here and not by a crate: the one that is kept stops at the end of an ASCII file's first
//! solid, and takes a binary file whose title begins with "solid " for ASCII (SolidWorks writes it).

use super::obj::{Scanner, line_of};
use super::parts::PolygonRun;
use super::polygons::Polygons;
use super::{Contents, MeshFault, MeshResult};
use crate::error::Place;
use crate::geometry::DVec3;

const HEADER: usize = 84;
const RECORD: usize = 50;

fn count(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(80..HEADER)?;
    Some(u32::from_le_bytes(count.try_into().ok()?) as usize)
}

/// Whether the file is as long as its header says.
pub(super) fn is_binary(bytes: &[u8]) -> bool {
    count(bytes).is_some_and(|count| count > 0 && bytes.len() == HEADER + RECORD * count)
}

pub(super) fn is_ascii(text: &[u8]) -> bool {
    let start = &text[..text.len().min(1024)];
    let holds = |what: &[u8]| start.windows(what.len()).any(|w| w.eq_ignore_ascii_case(what));
    text.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"))
        && (holds(b"facet") || holds(b"endsolid"))
        && !start.contains(&0)
}

/// What is wrong with a binary file that would be an STL if it were of another length.
pub(super) fn announced(bytes: &[u8]) -> Option<String> {
    let announced = count(bytes)?;
    let held = (bytes.len() - HEADER) / RECORD;
    let is_like = announced > 0 && announced < 1 << 28 && announced / 4 <= held + 1;
    is_like.then(|| {
        format!(
            "if this is an STL file: its header says {announced} triangles, but it holds {held}"
        )
    })
}

pub(super) fn parse_binary(bytes: &[u8]) -> MeshResult<Contents> {
    let mut polygons = Polygons::default();
    let records = bytes[HEADER..].as_chunks::<RECORD>().0;
    if records.len() > (u32::MAX / 3) as usize {
        return Err(MeshFault::file("has more triangles than can be counted"));
    }
    polygons.positions.reserve_exact(3 * records.len());
    for (at, record) in records.iter().enumerate() {
        // 12 bytes of normal come first: the corners' order says the same.
        for corner in record[12..48].as_chunks::<12>().0 {
            let number =
                |k| f32::from_le_bytes([corner[k], corner[k + 1], corner[k + 2], corner[k + 3]]);
            let position = DVec3::new(number(0).into(), number(4).into(), number(8).into());
            if !position.is_finite() {
                let problem = format!("corner is {position}, expected finite numbers");
                return Err(MeshFault::record(at + 1, problem));
            }
            polygons.positions.push(position);
        }
        polygons.ends.push(3 * (at as u32 + 1));
    }
    polygons.corners = (0..polygons.positions.len() as u32).collect();
    polygons.parts.push(PolygonRun::START);
    polygons.finish();
    Ok(Contents { format: "binary STL", polygons, warnings: Vec::new() })
}

pub(super) fn parse_ascii(bytes: &[u8]) -> MeshResult<Contents> {
    let mut polygons = Polygons::default();
    let mut scanner = Scanner::new(bytes);
    let mut first = 0;
    while !scanner.is_at_end() {
        let start = scanner.at();
        let word = scanner.word().to_ascii_lowercase();
        let fault = |problem| MeshFault { place: Place::Line(line_of(bytes, start)), problem };
        match word.as_slice() {
            b"solid" => {
                let object = Some(polygons.parts.objects.number(scanner.rest_of_line()));
                polygons.parts.push(PolygonRun {
                    first: polygons.ends.len() as u32,
                    object,
                    ..PolygonRun::START
                });
            }
            b"vertex" => {
                polygons.positions.push(scanner.vector("vertex").map_err(fault)?);
                polygons.corners.push(polygons.corners.len() as u32);
            }
            b"endloop" => {
                let corners = polygons.corners.len() - first;
                if corners < 3 {
                    return Err(fault(format!("facet has {corners} corners, expected 3")));
                }
                first = polygons.corners.len();
                polygons.end_polygon();
            }
            _ => {}
        }
        scanner.skip_line();
    }
    if first != polygons.corners.len() {
        return Err(MeshFault::file("ends inside a facet"));
    }
    polygons.finish();
    Ok(Contents { format: "ASCII STL", polygons, warnings: Vec::new() })
}
