//! PLY, ASCII and binary.

use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult,
};

use super::parts::PolygonRun;
use super::polygons::{NONE, Polygons};
use super::{Contents, MeshFault, MeshResult};
use crate::geometry::DVec3;

pub(super) fn is_ply(bytes: &[u8]) -> bool {
    bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r")
}

/// What is of use in an element of any kind.
struct PlyElement {
    position: DVec3,
    normal: DVec3,
    corners: Vec<i64>,
}

impl PropertyAccess for PlyElement {
    fn new() -> Self {
        Self { position: DVec3::NAN, normal: DVec3::NAN, corners: Vec::new() }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let target = match name {
            "x" => &mut self.position.x,
            "y" => &mut self.position.y,
            "z" => &mut self.position.z,
            "nx" => &mut self.normal.x,
            "ny" => &mut self.normal.y,
            "nz" => &mut self.normal.z,
            "vertex_indices" | "vertex_index" => {
                self.corners = whole_numbers(property);
                return PropertyAccessResult::Set;
            }
            _ => return PropertyAccessResult::Ignored,
        };
        *target = number(property).unwrap_or(f64::NAN);
        PropertyAccessResult::Set
    }
}

fn number(property: Property) -> Option<f64> {
    Some(match property {
        Property::Char(n) => n.into(),
        Property::UChar(n) => n.into(),
        Property::Short(n) => n.into(),
        Property::UShort(n) => n.into(),
        Property::Int(n) => n.into(),
        Property::UInt(n) => n.into(),
        Property::Float(n) => n.into(),
        Property::Double(n) => n,
        _ => return None,
    })
}

fn whole_numbers(property: Property) -> Vec<i64> {
    match property {
        Property::ListChar(list) => list.into_iter().map(i64::from).collect(),
        Property::ListUChar(list) => list.into_iter().map(i64::from).collect(),
        Property::ListShort(list) => list.into_iter().map(i64::from).collect(),
        Property::ListUShort(list) => list.into_iter().map(i64::from).collect(),
        Property::ListInt(list) => list.into_iter().map(i64::from).collect(),
        Property::ListUInt(list) => list.into_iter().map(i64::from).collect(),
        _ => Vec::new(),
    }
}

/// The elements of a file, one after the other.
struct Elements<'a> {
    parser: Parser<PlyElement>,
    encoding: Encoding,
    rest: &'a [u8],
}

impl Elements<'_> {
    fn next(&mut self, element: &ElementDef) -> std::result::Result<PlyElement, String> {
        let record = match self.encoding {
            Encoding::Ascii => {
                let line = self.line()?;
                self.parser.read_ascii_element(&line, element)
            }
            Encoding::BinaryBigEndian => {
                self.parser.read_big_endian_element(&mut self.rest, element)
            }
            Encoding::BinaryLittleEndian => {
                self.parser.read_little_endian_element(&mut self.rest, element)
            }
        };
        record.map_err(|e| one_line(&e.to_string()))
    }

    /// The next line that is not empty.
    fn line(&mut self) -> std::result::Result<String, String> {
        loop {
            if self.rest.is_empty() {
                return Err("is missing: the file ends".to_owned());
            }
            let end = self.rest.iter().position(|&b| b == b'\n').unwrap_or(self.rest.len());
            let (line, rest) = self.rest.split_at(end);
            self.rest = rest.get(1..).unwrap_or_default();
            let line = line.trim_ascii();
            if !line.is_empty() {
                return Ok(String::from_utf8_lossy(line).into_owned());
            }
        }
    }
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

pub(super) fn parse(bytes: &[u8]) -> MeshResult<Contents> {
    let parser = Parser::<PlyElement>::new();
    let mut reader = Reader::new(bytes);
    let header = parser
        .read_header(&mut reader)
        .map_err(|e| MeshFault::file(format!("PLY header: {}", one_line(&e.to_string()))))?;
    let mut elements = Elements { parser, encoding: header.encoding, rest: reader.into_inner() };
    let mut polygons = Polygons::default();
    for element in header.elements.values() {
        read_element(element, &mut elements, &mut polygons)?;
        if element.name == "face" && !polygons.positions.is_empty() {
            break;
        }
    }
    check_corners(&polygons)?;
    if polygons.ends.is_empty() {
        return Err(without_faces(&header));
    }
    if polygons.normals.len() == polygons.positions.len() {
        polygons.corner_normals = polygons.corners.clone();
    }
    polygons.parts.push(PolygonRun::START);
    polygons.finish();
    let format = match header.encoding {
        Encoding::Ascii => "ASCII PLY",
        Encoding::BinaryBigEndian | Encoding::BinaryLittleEndian => "binary PLY",
    };
    Ok(Contents { format, polygons, warnings: Vec::new() })
}

fn without_faces(header: &Header) -> MeshFault {
    if header.elements.contains_key("tristrips") {
        return MeshFault::file(
            "has triangle strips and no faces: save it again, in MeshLab for one",
        );
    }
    MeshFault::file("no faces: a cloud of points is no surface")
}

fn read_element(
    element: &ElementDef,
    elements: &mut Elements,
    polygons: &mut Polygons,
) -> MeshResult<()> {
    // Such elements take no bytes, however many there are said to be.
    if element.properties.is_empty() {
        return Ok(());
    }
    for number in 1..=element.count {
        let of = |problem: String| MeshFault::record(number, format!("{} {problem}", element.name));
        let record = elements.next(element).map_err(of)?;
        match element.name.as_str() {
            "vertex" => add_vertex(record, polygons).map_err(of)?,
            "face" => add_face(&record.corners, polygons).map_err(of)?,
            _ => {}
        }
    }
    Ok(())
}

fn add_vertex(record: PlyElement, polygons: &mut Polygons) -> std::result::Result<(), String> {
    if !record.position.is_finite() {
        return Err(format!("is at {}, expected finite x, y and z", record.position));
    }
    if polygons.positions.len() >= NONE as usize {
        return Err("is one more than can be counted".to_owned());
    }
    polygons.positions.push(record.position);
    if record.normal.is_finite() {
        polygons.normals.push(record.normal);
    }
    Ok(())
}

fn add_face(corners: &[i64], polygons: &mut Polygons) -> std::result::Result<(), String> {
    if corners.len() < 3 {
        return Err(format!("has {} corners, expected 3 or more", corners.len()));
    }
    for &corner in corners {
        let place = u32::try_from(corner).ok().filter(|&place| place != NONE);
        let place = place.ok_or_else(|| format!("has corner {corner}, expected 0 or more"))?;
        polygons.corners.push(place);
    }
    polygons.end_polygon();
    Ok(())
}

/// Faces may come before their vertices.
fn check_corners(polygons: &Polygons) -> MeshResult<()> {
    let count = polygons.positions.len();
    let Some(at) = polygons.corners.iter().position(|&corner| corner as usize >= count) else {
        return Ok(());
    };
    let face = polygons.ends.partition_point(|&end| end as usize <= at);
    let problem =
        format!("face has corner {}, allowed: 0 to {}", polygons.corners[at], count as i64 - 1);
    Err(MeshFault::record(face + 1, problem))
}
