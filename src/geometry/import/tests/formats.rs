//! STL, PLY and glTF.

use super::*;
use crate::output::base64;

/// Triangles of a cube, for the formats that hold nothing else.
fn cube_triangles() -> Vec<[DVec3; 3]> {
    let cube = read(CUBE).mesh;
    (0..12).map(|triangle| cube.corners(triangle)).collect()
}

fn binary_stl(title: &[u8]) -> Vec<u8> {
    let mut bytes = title.to_vec();
    bytes.resize(80, b' ');
    bytes.extend(12u32.to_le_bytes());
    for corners in cube_triangles() {
        bytes.extend([0; 12]);
        bytes.extend(
            corners.iter().flat_map(|c| c.to_array()).flat_map(|x| (x as f32).to_le_bytes()),
        );
        bytes.extend([0; 2]);
    }
    bytes
}

fn ascii_stl(names: [&str; 2]) -> String {
    let mut text = String::new();
    for (part, name) in cube_triangles().chunks(6).zip(names) {
        text += &format!("solid {name}\n");
        for corners in part {
            text += "facet normal 0 0 0\n outer loop\n";
            text += &corners.map(|c| format!("  vertex {:e} {:e} {:e}\n", c.x, c.y, c.z)).concat();
            text += " endloop\nendfacet\n";
        }
        text += &format!("endsolid {name}\n");
    }
    text
}

fn is_cube(mesh: &Mesh) -> bool {
    mesh.positions.len() == 8
        && Closure::of(mesh).is_closed()
        && (mesh.volume_mm3() - 1.0).abs() < 1e-12
        && bend_deg(mesh) < NO_BEND
}

#[test]
fn stl_files_are_welded() {
    for title in [b"from CAD".as_slice(), b"solid lens from SolidWorks"] {
        let file = read(binary_stl(title));
        assert_eq!(file.format, "binary STL");
        assert!(is_cube(&file.mesh));
    }
    let file = read(ascii_stl(["lens", "the housing"]));
    assert_eq!((file.format, file.objects.len()), ("ASCII STL", 2));
    assert!(is_cube(&file.mesh));
    assert!(is_cube(&read(ascii_stl(["", ""]).to_uppercase().replace("E0", "e0")).mesh));
    let half = read_with(ascii_stl(["lens", "the housing"]), &object("the housing")).unwrap();
    assert_eq!(half.mesh.triangles.len(), 6);
}

#[test]
fn broken_stl_files_say_where() {
    let mut bytes = binary_stl(b"");
    bytes.truncate(84 + 50 * 11 + 7);
    assert_eq!(
        fault(&bytes),
        (
            Place::File,
            "if this is an STL file: its header says 12 triangles, but it holds 11".into()
        )
    );
    let mut bytes = binary_stl(b"");
    bytes[84 + 50 + 12..][..4].copy_from_slice(&f32::NAN.to_le_bytes());
    assert_eq!(fault(&bytes).0, Place::Record(2));
    let text = ascii_stl(["a", "b"]).replacen("vertex 0e0", "vertex x", 1);
    assert_eq!(fault(text), (Place::Line(4), "vertex has \"x\", expected a number".into()));
    assert_eq!(
        fault("solid a\nfacet\nvertex 0 0 0\n"),
        (Place::File, "ends inside a facet".into())
    );
}

fn ply_header(format: &str) -> String {
    format!(
        "ply\nformat {format} 1.0\ncomment lens\nelement vertex 8\nproperty double x\n\
         property double y\nproperty double z\nproperty uchar red\nelement face 6\n\
         property list uchar int vertex_indices\nend_header\n"
    )
}

fn cube_quads() -> Vec<[i32; 4]> {
    let faces = CUBE.lines().filter_map(|line| line.strip_prefix("f "));
    faces
        .map(|face| {
            let corners: Vec<i32> =
                face.split(' ').map(|k| k.parse::<i32>().unwrap() - 1).collect();
            corners.try_into().unwrap()
        })
        .collect()
}

fn cube_corners() -> Vec<[f64; 3]> {
    read(CUBE).mesh.positions.iter().map(|p| p.to_array()).collect()
}

fn ascii_ply() -> String {
    let mut text = ply_header("ascii");
    cube_corners().iter().for_each(|[x, y, z]| text += &format!("{x} {y} {z} 255\n"));
    cube_quads().iter().for_each(|[a, b, c, d]| text += &format!("4 {a} {b} {c} {d}\n"));
    text
}

fn binary_ply(is_little: bool) -> Vec<u8> {
    let mut bytes =
        ply_header(if is_little { "binary_little_endian" } else { "binary_big_endian" })
            .into_bytes();
    for corner in cube_corners() {
        let number = |x: f64| if is_little { x.to_le_bytes() } else { x.to_be_bytes() };
        bytes.extend(corner.into_iter().flat_map(number));
        bytes.push(255);
    }
    for quad in cube_quads() {
        bytes.push(4);
        let number = |k: i32| if is_little { k.to_le_bytes() } else { k.to_be_bytes() };
        bytes.extend(quad.into_iter().flat_map(number));
    }
    bytes
}

#[test]
fn ply_files_of_each_encoding() {
    for bytes in [ascii_ply().into_bytes(), binary_ply(true), binary_ply(false)] {
        let file = read(&bytes);
        assert!(is_cube(&file.mesh), "{}", file.format);
    }
    assert!(is_cube(&read(ascii_ply().replace('\n', "\r\n")).mesh));
    assert_eq!(
        fault(ascii_ply().replace("4 0 3 2 1", "4 0 3 2 8")),
        (Place::Record(1), "face has corner 8, allowed: 0 to 7".into())
    );
    assert_eq!(fault(ascii_ply().replace("4 0 3 2 1", "4 0 3 2 -1")).0, Place::Record(1));
    let cloud = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n\
                 property float z\nend_header\n0 0 0\n";
    assert_eq!(fault(cloud), (Place::File, "no faces: a cloud of points is no surface".into()));
}

/// A cube whose node is moved by 10 and, with −1, mirrored; the buffer inside the file.
fn gltf_text(scale_x: i32) -> String {
    let mut buffer: Vec<u8> = Vec::new();
    cube_triangles().iter().flatten().flat_map(|c| c.to_array()).for_each(|x| {
        buffer.extend((x as f32).to_le_bytes());
    });
    let data = base64(&buffer);
    let length = buffer.len();
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
        "nodes":[{{"name":"lens","mesh":0,"translation":[10,0,0],"scale":[{scale_x},1,1]}}],
        "materials":[{{"name":"clear red"}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"material":0}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":36,"type":"VEC3","min":[0,0,0],"max":[1,1,1]}}],
        "bufferViews":[{{"buffer":0,"byteLength":{length}}}],
        "buffers":[{{"byteLength":{length},"uri":"data:application/octet-stream;base64,{data}"}}]}}"#
    )
}

#[test]
fn gltf_nodes_are_placed() {
    let file = read(gltf_text(1));
    assert!(is_cube(&file.mesh));
    assert_eq!(file.mesh.bounds()[0], DVec3::new(10.0, 0.0, 0.0));
    assert_eq!((file.objects, file.materials), (vec!["lens".into()], vec!["clear red".into()]));
    let mirrored = read(gltf_text(-1)).mesh;
    assert!(is_cube(&mirrored));
    assert_eq!(mirrored.bounds()[0], DVec3::new(9.0, 0.0, 0.0));
    let text = gltf_text(1).replace("\"count\":36", "\"count\":360000");
    assert_eq!(fault(text), (Place::File, "accessor 0 lies outside of its buffer".into()));
    let text = gltf_text(1).replace("data:application/octet-stream;base64,", "../");
    assert!(fault(text).1.contains("lies outside of the file's folder"));
    let text = gltf_text(1)
        .replace("\"scene\":0,", "\"extensionsRequired\":[\"KHR_draco_mesh_compression\"],");
    assert_eq!(
        fault(text).1,
        "uses KHR_draco_mesh_compression: export it without Draco compression"
    );
}

#[test]
fn other_formats_are_refused_with_advice() {
    let iges = format!("{:72}S      1\n", "CATIA part");
    for (bytes, words) in [
        (b"ISO-10303-21;\nHEADER;".as_slice(), "is a STEP file: exact surfaces: export a mesh"),
        (iges.as_bytes(), "is an IGES file"),
        (b"PK\x03\x04....[Content_Types].xml....3D/3dmodel.model", "is a 3MF file"),
        (b"PK\x03\x04....lens.obj", "is compressed with ZIP: unpack it first (unzip)"),
        (b"\x1f\x8b\x08", "is compressed with gzip: unpack it first (gunzip)"),
        (b"Kaydara FBX Binary  \0", "is an FBX file: export it as OBJ"),
        (b"version https://git-lfs.github.com/spec/v1\n", "git lfs pull"),
        (b"<!DOCTYPE html><html>", "is a web page"),
        (b"<?xml version=\"1.0\"?><COLLADA>", "is a COLLADA file"),
        (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", "a CAD system's own part"),
        (b"  0\r\nSECTION\r\n", "is a DXF file"),
        (b"\x00\x01\x02\x03\x04", "is no mesh: neither OBJ, STL, PLY nor glTF"),
    ] {
        let problem = fault(bytes).1;
        assert!(problem.contains(words), "{problem}");
    }
}
