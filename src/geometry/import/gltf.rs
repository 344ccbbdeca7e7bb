//! glTF and GLB: the triangles of the default scene, each node in its place.

use std::path::{Component, Path};

use glam::{DMat3, DMat4};
use gltf::accessor::{DataType, Dimensions};
use gltf::mesh::Mode;
use gltf::{Accessor, Document, Gltf, Node, Primitive, Semantic, buffer};

use super::parts::PolygonRun;
use super::polygons::Polygons;
use super::{Contents, MeshFault, MeshResult};
use crate::geometry::DVec3;
use crate::input;

/// Nodes may repeat a mesh: this many triangles, or one for every 12 bytes of the file if that is
/// more, are what memory in proportion to the file allows.
const MOST_TRIANGLES: usize = 1_000_000;

/// Compressions and other extensions that change where the numbers are, and what to do.
const EXTENSIONS: [(&str, &str); 3] = [
    ("KHR_draco_mesh_compression", "export it without Draco compression"),
    ("EXT_meshopt_compression", "export it without meshopt compression"),
    ("KHR_mesh_quantization", "export it without quantization"),
];

pub(super) fn parse(bytes: &[u8], folder: &Path) -> MeshResult<Contents> {
    let gltf = document(bytes).map_err(|problem| not_read(bytes, &problem))?;
    let buffers = buffers(&gltf, folder)?;
    let mut import = Import {
        buffers: &buffers,
        polygons: Polygons::default(),
        left_out: 0,
        most_triangles: MOST_TRIANGLES.max(bytes.len() / 12),
        is_visited: vec![false; gltf.nodes().count()],
        has_normals: true,
    };
    let scene = gltf.default_scene().or_else(|| gltf.scenes().next());
    let roots: Vec<Node> = scene.map_or_else(|| gltf.nodes().collect(), |s| s.nodes().collect());
    import.walk(roots)?;
    let Import { mut polygons, left_out, has_normals, .. } = import;
    if !has_normals {
        polygons.corner_normals.clear();
    }
    polygons.finish();
    let mut warnings = Vec::new();
    if left_out > 0 {
        warnings.push(format!("{left_out} sets of points or lines are left out"));
    }
    let format = if bytes.starts_with(b"glTF") { "GLB" } else { "glTF" };
    Ok(Contents { format, polygons, warnings })
}

/// Bytes of a GLB header: mark, version, length of the file.
const GLB_HEADER: u32 = 12;

/// The crate's checks trust that a GLB file is no shorter than its header, and that a primitive's
/// accessors are there: that is seen to first.
fn document(bytes: &[u8]) -> std::result::Result<Gltf, String> {
    if let [b'g', b'l', b'T', b'F', _, _, _, _, a, b, c, d, ..] = *bytes {
        let length = u32::from_le_bytes([a, b, c, d]);
        if length < GLB_HEADER {
            return Err(format!("the header says that the file has {length} bytes"));
        }
    }
    let text = |error: gltf::Error| error.to_string();
    let Gltf { document, blob } = Gltf::from_slice_without_validation(bytes).map_err(text)?;
    let json = document.into_json();
    let mut primitives = json.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let is_there = |index: &gltf::json::Index<_>| index.value() < json.accessors.len();
    if !primitives.all(|primitive| primitive.attributes.values().all(is_there)) {
        return Err("a primitive's accessor is not there".to_owned());
    }
    Ok(Gltf { document: Document::from_json(json).map_err(text)?, blob })
}

fn not_read(bytes: &[u8], error: &str) -> MeshFault {
    let holds = |what: &str| bytes.windows(what.len()).any(|window| window == what.as_bytes());
    match EXTENSIONS.iter().find(|(name, _)| holds(name)) {
        Some((name, what_to_do)) => MeshFault::file(format!("uses {name}: {what_to_do}")),
        None => MeshFault::file(format!("glTF: {}", error.replace('\n', " "))),
    }
}

fn buffers(gltf: &Gltf, folder: &Path) -> MeshResult<Vec<Vec<u8>>> {
    gltf.buffers()
        .map(|buffer| match buffer.source() {
            buffer::Source::Bin => match &gltf.blob {
                Some(blob) => Ok(blob.clone()),
                None => Err(MeshFault::file("its binary part is missing")),
            },
            buffer::Source::Uri(uri) => match uri.strip_prefix("data:") {
                Some(data) => from_base64(data),
                None => from_file(uri, folder),
            },
        })
        .collect()
}

/// Whether a file with this beginning is one.
pub(super) fn is_gltf(start: &[u8]) -> bool {
    start.starts_with(b"glTF") || start.trim_ascii_start().starts_with(b"{")
}

/// Names of the files below its own folder that hold its buffers; none of a broken file.
pub(super) fn buffer_files(bytes: &[u8]) -> Vec<String> {
    let Ok(gltf) = document(bytes) else { return Vec::new() };
    let file = |buffer: buffer::Buffer| match buffer.source() {
        buffer::Source::Uri(uri) if !uri.starts_with("data:") => file_name(uri),
        _ => None,
    };
    gltf.buffers().filter_map(file).collect()
}

/// The name that a URI stands for; none of what lies elsewhere.
fn file_name(uri: &str) -> Option<String> {
    // Some writers escape nothing.
    let name = without_escapes(uri).unwrap_or_else(|| uri.to_owned());
    let is_below = Path::new(&name).components().all(|part| matches!(part, Component::Normal(_)));
    (is_below && !name.contains(':')).then_some(name)
}

/// A URI with the bytes that its `%20` and the like stand for; none if one stands for nothing, or they
/// are no UTF-8.
fn without_escapes(uri: &str) -> Option<String> {
    let mut parts = uri.split('%');
    let mut bytes = parts.next()?.as_bytes().to_vec();
    for part in parts {
        let (digits, rest) = part.split_at_checked(2)?;
        let is_hex = digits.bytes().all(|digit| digit.is_ascii_hexdigit());
        bytes.push(u8::from_str_radix(digits, 16).ok().filter(|_| is_hex)?);
        bytes.extend(rest.as_bytes());
    }
    String::from_utf8(bytes).ok()
}

fn from_file(uri: &str, folder: &Path) -> MeshResult<Vec<u8>> {
    let Some(name) = file_name(uri) else {
        return Err(MeshFault::file(format!("buffer \"{uri}\" lies outside of the file's folder")));
    };
    input::bytes(&folder.join(&name))
        .map_err(|error| MeshFault::file(format!("buffer \"{uri}\" cannot be read: {error}")))
}

fn from_base64(data: &str) -> MeshResult<Vec<u8>> {
    let (_, text) =
        data.split_once(";base64,").ok_or_else(|| MeshFault::file("a buffer is not in base64"))?;
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3);
    let (mut bits, mut count) = (0u32, 0);
    for letter in text.bytes().filter(|&letter| letter != b'=') {
        let six = match letter {
            b'A'..=b'Z' => letter - b'A',
            b'a'..=b'z' => letter - b'a' + 26,
            b'0'..=b'9' => letter - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            _ => return Err(MeshFault::file("a buffer is not in base64")),
        };
        bits = bits << 6 | u32::from(six);
        count += 6;
        if count >= 8 {
            count -= 8;
            bytes.push((bits >> count) as u8);
        }
    }
    Ok(bytes)
}

struct Import<'a> {
    buffers: &'a [Vec<u8>],
    polygons: Polygons,
    /// Primitives that are no triangles.
    left_out: usize,
    most_triangles: usize,
    is_visited: Vec<bool>,
    /// Whether all primitives so far have normals.
    has_normals: bool,
}

impl Import<'_> {
    fn walk(&mut self, roots: Vec<Node>) -> MeshResult<()> {
        let mut pending: Vec<(Node, DMat4)> =
            roots.into_iter().rev().map(|node| (node, DMat4::IDENTITY)).collect();
        while let Some((node, parent)) = pending.pop() {
            if std::mem::replace(&mut self.is_visited[node.index()], true) {
                return Err(MeshFault::file(format!("node {} has two parents", node.index())));
            }
            let columns = node.transform().matrix().map(|column| column.map(f64::from));
            let world = parent * DMat4::from_cols_array_2d(&columns);
            if let Some(mesh) = node.mesh() {
                let name = node.name().or(mesh.name());
                let object = name.map(|name| self.polygons.parts.objects.number(name.as_bytes()));
                for primitive in mesh.primitives() {
                    self.add(&primitive, world, object)?;
                }
            }
            let children: Vec<_> = node.children().map(|child| (child, world)).collect();
            pending.extend(children.into_iter().rev());
        }
        Ok(())
    }

    fn add(&mut self, primitive: &Primitive, world: DMat4, object: Option<u32>) -> MeshResult<()> {
        let Some(accessor) = primitive.get(&Semantic::Positions) else {
            return Ok(());
        };
        let first = self.polygons.positions.len();
        let local = self.vectors(&accessor)?;
        let count = local.len();
        let world_positions = local.into_iter().map(|p| world.transform_point3(p));
        self.polygons.positions.extend(world_positions);
        if let Some(at) = self.polygons.positions[first..].iter().position(|p| !p.is_finite()) {
            return Err(MeshFault::record(at + 1, "position is not finite"));
        }
        let corners = match primitive.indices() {
            Some(accessor) => self.indices(&accessor, count)?,
            None => (0..count as u32).collect(),
        };
        let material = primitive.material().name().map(str::as_bytes);
        let material = material.map(|name| self.polygons.parts.materials.number(name));
        let run = PolygonRun {
            first: self.polygons.ends.len() as u32,
            object,
            material,
            ..PolygonRun::START
        };
        self.polygons.parts.push(run);
        self.add_normals(primitive, world, count)?;
        self.add_triangles(primitive.mode(), &corners, first as u32, world.determinant() < 0.0)
    }

    fn add_normals(&mut self, primitive: &Primitive, world: DMat4, count: usize) -> MeshResult<()> {
        let Some(accessor) = primitive.get(&Semantic::Normals) else {
            self.has_normals = false;
            return Ok(());
        };
        let across = DMat3::from_mat4(world).inverse().transpose();
        let normals = self.vectors(&accessor)?;
        self.has_normals &= normals.len() == count;
        let turned = normals.into_iter().map(|normal| {
            let turned = across * normal;
            if turned.is_finite() { turned } else { DVec3::ZERO }
        });
        self.polygons.normals.extend(turned);
        Ok(())
    }

    /// A mirrored node's triangles are turned over, so that their fronts stay outside.
    fn add_triangles(
        &mut self,
        mode: Mode,
        corners: &[u32],
        first: u32,
        is_mirrored: bool,
    ) -> MeshResult<()> {
        let strip =
            |k: usize| if k.is_multiple_of(2) { [k, k + 1, k + 2] } else { [k + 1, k, k + 2] };
        let places: Vec<[usize; 3]> = match mode {
            Mode::Triangles => {
                (0..corners.len() / 3).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect()
            }
            Mode::TriangleStrip => (0..corners.len().saturating_sub(2)).map(strip).collect(),
            Mode::TriangleFan => (2..corners.len()).map(|k| [0, k - 1, k]).collect(),
            Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => {
                self.left_out += 1;
                return Ok(());
            }
        };
        if self.polygons.ends.len() + places.len() > self.most_triangles {
            return Err(MeshFault::file(format!(
                "its nodes repeat meshes to more than {} triangles: export it without instances",
                self.most_triangles
            )));
        }
        for [a, b, c] in places {
            let [b, c] = if is_mirrored { [c, b] } else { [b, c] };
            let triangle = [a, b, c].map(|k| first + corners[k]);
            self.polygons.corners.extend(triangle);
            if self.has_normals {
                self.polygons.corner_normals.extend(triangle);
            }
            self.polygons.end_polygon();
        }
        Ok(())
    }

    fn vectors(&self, accessor: &Accessor) -> MeshResult<Vec<DVec3>> {
        if (accessor.data_type(), accessor.dimensions()) != (DataType::F32, Dimensions::Vec3) {
            return Err(MeshFault::file(
                "has vertices that are not three floats: export it without quantization",
            ));
        }
        let number =
            |bytes: &[u8]| f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]).into();
        let vector = |b: &[u8]| DVec3::new(number(b), number(&b[4..]), number(&b[8..]));
        Ok(self.items(accessor, 12)?.map(vector).collect())
    }

    fn indices(&self, accessor: &Accessor, count: usize) -> MeshResult<Vec<u32>> {
        let size = accessor.data_type().size();
        let index = |b: &[u8]| match size {
            1 => b[0].into(),
            2 => u16::from_le_bytes([b[0], b[1]]).into(),
            _ => u32::from_le_bytes([b[0], b[1], b[2], b[3]]),
        };
        let indices: Vec<u32> = self.items(accessor, size)?.map(index).collect();
        match indices.iter().position(|&index| index as usize >= count) {
            None => Ok(indices),
            Some(at) => {
                let problem =
                    format!("index is {}, allowed: 0 to {}", indices[at], count as i64 - 1);
                Err(MeshFault::record(at + 1, problem))
            }
        }
    }

    /// The bytes of each item. The crate's own iterators trust the lengths that a file gives.
    fn items(&self, accessor: &Accessor, size: usize) -> MeshResult<impl Iterator<Item = &[u8]>> {
        let outside =
            || MeshFault::file(format!("accessor {} lies outside of its buffer", accessor.index()));
        if accessor.sparse().is_some() {
            return Err(MeshFault::file(format!(
                "accessor {} is sparse: export it without",
                accessor.index()
            )));
        }
        let view = accessor.view().ok_or_else(outside)?;
        let buffer = self.buffers.get(view.buffer().index()).ok_or_else(outside)?;
        let end = view.offset().checked_add(view.length()).ok_or_else(outside)?;
        let bytes = buffer.get(view.offset()..end).ok_or_else(outside)?;
        let bytes = bytes.get(accessor.offset()..).ok_or_else(outside)?;
        let stride = view.stride().unwrap_or(size).max(size);
        let whole = accessor.count().checked_sub(1).and_then(|n| n.checked_mul(stride));
        let whole = whole.and_then(|n| n.checked_add(size)).ok_or_else(outside)?;
        if whole > bytes.len() {
            return Err(outside());
        }
        Ok((0..accessor.count()).map(move |k| &bytes[k * stride..k * stride + size]))
    }
}

#[cfg(test)]
mod tests {
    use super::file_name;

    #[test]
    fn names_of_buffers_stay_below_the_folder() {
        let names = ["a%20b.bin", "sub/a.bin", "%EB%A0%8C%EC%A6%88.bin"];
        assert_eq!(names.map(|uri| file_name(uri).unwrap()), ["a b.bin", "sub/a.bin", "렌즈.bin"]);
        let as_they_are = ["a b.bin", "a%2", "100%.bin", "a%+f", "%ff", "a%é"];
        assert_eq!(as_they_are.map(|uri| file_name(uri).unwrap()), as_they_are);
        let elsewhere = ["../a.bin", "%2e%2e/a.bin", "/a.bin", "https://a/b.bin"];
        assert!(elsewhere.iter().all(|uri| file_name(uri).is_none()));
    }
}
