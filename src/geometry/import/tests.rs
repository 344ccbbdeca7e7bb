//! What CAD systems write, and what is right for it (facts: "What CAD systems and instruments
//! write").

use super::*;
use crate::geometry::DVec3;
use crate::geometry::mesh::Shading;
use crate::geometry::obj::to_text;

const QUAD: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

fn read_with(bytes: impl AsRef<[u8]>, reading: &MeshReading) -> MeshResult<MeshFile> {
    parse(Path::new("lens.obj"), bytes.as_ref().to_vec(), reading)
}

fn read(bytes: impl AsRef<[u8]>) -> MeshFile {
    read_with(bytes, &MeshReading::default()).unwrap()
}

fn fault(bytes: impl AsRef<[u8]>) -> (Place, String) {
    let fault = read_with(bytes, &MeshReading::default()).unwrap_err();
    (fault.place, fault.problem)
}

fn group(name: impl AsRef<[u8]>) -> MeshReading {
    let selection = Selection { group: Some(name.as_ref().to_vec()), ..Selection::default() };
    MeshReading { selection, ..MeshReading::default() }
}

fn object(name: &str) -> MeshReading {
    let selection = Selection { object: Some(name.into()), ..Selection::default() };
    MeshReading { selection, ..MeshReading::default() }
}

fn material(name: impl AsRef<[u8]>) -> MeshReading {
    let selection = Selection { material: Some(name.as_ref().to_vec()), ..Selection::default() };
    MeshReading { selection, ..MeshReading::default() }
}

/// Largest angle between shading and geometric normal at the triangles' corners, degrees.
fn bend_deg(mesh: &Mesh) -> f64 {
    let bend = |triangle, corner| {
        let n_geom = mesh.geometric_normal(triangle);
        n_geom.dot(mesh.shading_normal(triangle, corner, n_geom)).min(1.0).acos().to_degrees()
    };
    let corners = [[0., 0.], [1., 0.], [0., 1.]];
    (0..mesh.triangles.len())
        .flat_map(|triangle| corners.map(|corner| bend(triangle, corner)))
        .fold(0.0, f64::max)
}

/// Below this, degrees, an angle is 0: acos loses what is closer.
const NO_BEND: f64 = 1e-5;

#[test]
fn quads_and_negative_indices() {
    let mesh = read(format!("{QUAD}f 1 2 3 4\n")).mesh;
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(read(format!("{QUAD}f -4 -3 -2 -1\n")).mesh, mesh);
    // The same again after more vertices: counted back from where they stand.
    let later = format!("{QUAD}f -4 -3 -2 -1\n{QUAD}f -4 -3 -2 -1\n");
    assert_eq!(read(later).mesh.triangles.len(), 4);
}

/// Pieces of any length give the same mesh, wherever they part statements.
#[test]
fn pieces_do_not_show() {
    let mut text = String::from("o a\n# comment \\\n");
    for k in 0..40 {
        let x = f64::from(k);
        text += &format!("v {x} 0 0.5\r\nv {x} 1 0\nv {x} 0 1\nvn 0 0 1\n");
        text += "f -3//-1 -2//-1 \\\n -1//-1\ns 1\nf 1 2 \\\r\n 3\n";
        text += &format!("g part {k}\n");
    }
    let whole = obj::parse(text.clone().into_bytes()).unwrap();
    for piece_bytes in [1, 7, 30, 100] {
        let pieces = obj::parse_pieces(text.as_bytes(), piece_bytes).unwrap();
        assert!(pieces.polygons == whole.polygons, "{piece_bytes}");
    }
    let broken = text.clone() + "v 0 0 0\nf 1 2 999\n";
    let line = broken.lines().count() as u64;
    for piece_bytes in [1, 50, 1 << 20] {
        let fault = obj::parse_pieces(broken.as_bytes(), piece_bytes).err().unwrap();
        assert_eq!(fault.place, Place::Line(line));
        assert_eq!(
            fault.problem,
            "position index is 999, allowed: 1 to 121 above this line, or −121 to −1"
        );
    }
}

#[test]
fn continued_lines_are_one_statement() {
    let plain = read(format!("{QUAD}f 1 2 3 4\n")).mesh;
    for text in ["f 1 2 \\\n3 4\n", "f 1 2 \\\r\n3 4\r\n", "f 1 2\\\n 3\\\n 4", "f \\ \n1 2 3 4"] {
        assert_eq!(read(format!("{QUAD}{text}")).mesh, plain, "{text:?}");
    }
    // Not in comments, and not after names.
    assert_eq!(read(format!("{QUAD}# a path: C:\\\nf 1 2 3 4\n")).mesh, plain);
    assert_eq!(read(format!("{QUAD}usemtl C:\\lens\\\nf 1 2 3 4\n")).mesh, plain);
    let cut = read(format!("v 0 0 \\\n0\n{}f 1 2 3 4", &QUAD[8..]));
    assert_eq!(cut.mesh, plain);
    let groups = read_with(format!("{QUAD}g a \\\n b\nf 1 2 3 4\n"), &group("b"));
    assert_eq!(groups.unwrap().mesh, plain);
}

#[test]
fn line_ends_of_all_systems() {
    let text = format!("{QUAD}f 1 2 3 4\n");
    let mesh = read(&text).mesh;
    assert_eq!(read(text.replace('\n', "\r\n")).mesh, mesh);
    assert_eq!(read(text.replace('\n', "\r")).mesh, mesh);
    assert_eq!(fault(text.replace('\n', "\r") + "f 1 2\r").0, Place::Line(6));
    assert_eq!(fault(text.replace('\n', "\r\n") + "f 1 2\r\n").0, Place::Line(6));
}

/// 50 × 40 less 30 × 30, and from whichever corner: a fan would add up to 60 %.
#[test]
fn concave_polygons_keep_their_area() {
    let corners = [[0, 0], [50, 0], [50, 40], [40, 40], [40, 10], [10, 10], [10, 40], [0, 40]];
    for first in 0..8 {
        let vertices = corners.map(|[x, y]| format!("v {x} {y} 3\n")).concat();
        let face = (0..8).map(|k| format!(" {}", (k + first) % 8 + 1)).collect::<String>();
        let mesh = read(format!("{vertices}f{face}\n")).mesh;
        assert!((mesh.area_mm2() - 1100.0).abs() < 1e-9, "{first}: {}", mesh.area_mm2());
    }
}

#[test]
fn positions_stay_shared_across_groups_and_materials() {
    let text = format!("{QUAD}g a\nusemtl x\nf 1 2 3\ng b\nusemtl y\nf 1 3 4\n");
    let file = read(&text);
    assert_eq!(file.mesh.positions.len(), 4);
    assert_eq!(
        (file.groups, file.materials),
        (vec!["a".into(), "b".into()], vec!["x".into(), "y".into()])
    );
    let part = read_with(&text, &group("b")).unwrap().mesh;
    assert_eq!((part.triangles.len(), part.positions.len()), (1, 3));
}

#[test]
fn parts_are_chosen_by_any_kind_of_name() {
    let text = format!(
        "{QUAD}o lens\ng default\nusemtl clear red\nf 1 2 3\no the housing\nusemtl black\nf 1 3 4\nf 1 2 4\n"
    );
    let count = |reading: &MeshReading| read_with(&text, reading).unwrap().mesh.triangles.len();
    assert_eq!(count(&object("lens")), 1);
    assert_eq!(count(&object("the housing")), 2);
    assert_eq!(count(&material("clear red")), 1);
    assert_eq!(count(&group("default")), 3);
    // As before, a group's name finds an object.
    assert_eq!(count(&group("lens")), 1);
    let mut both = object("the housing");
    both.selection.group = Some(b"default".to_vec());
    assert_eq!(count(&both), 2);
    let problem = read_with(&text, &material("red")).unwrap_err().problem;
    assert_eq!(
        problem,
        "no faces in material \"red\" (groups: default; objects: lens, the housing; materials: \
         clear red, black)"
    );
    let words = format!("{QUAD}g outer lens\nf 1 2 3\n");
    assert!(read_with(&words, &group("lens")).is_ok());
    assert!(read_with(&words, &group("outer lens")).is_ok());
}

#[test]
fn names_may_be_of_any_bytes() {
    let text = |name: &[u8]| [QUAD.as_bytes(), b"g ", name, b"\nf 1 2 3\n"].concat();
    let latin = text(b"Gr\xf6\xdfe");
    assert_eq!(read(&latin).groups, ["Größe"]);
    assert!(read_with(&latin, &group("Größe")).is_ok());
    assert!(read_with(&latin, &group(b"Gr\xf6\xdfe")).is_ok());
    // 렌즈 in CP949.
    let korean = text(b"\xb7\xbb\xc1\xee");
    assert_eq!(read(&korean).groups, ["렌즈"]);
    assert!(read_with(&korean, &group("렌즈")).is_ok());
    assert!(read_with(text("렌즈".as_bytes()), &group("렌즈")).is_ok());
}

#[test]
fn marks_of_encodings_are_no_part_of_the_text() {
    let text = format!("{QUAD}g 렌즈\nf 1 2 3 4\n");
    let mesh = read(&text);
    assert_eq!(read([b"\xef\xbb\xbf", text.as_bytes()].concat()), mesh);
    let units: Vec<u16> = text.encode_utf16().collect();
    let little: Vec<u8> = units.iter().flat_map(|unit| unit.to_le_bytes()).collect();
    let big: Vec<u8> = units.iter().flat_map(|unit| unit.to_be_bytes()).collect();
    assert_eq!(read([b"\xff\xfe".as_slice(), &little].concat()), mesh);
    assert_eq!(read([b"\xfe\xff".as_slice(), &big].concat()), mesh);
    assert_eq!(read(&little), mesh);
    assert_eq!(read(&big), mesh);
}

#[test]
fn colors_are_ignored() {
    let mesh = read(format!("{QUAD}f 1 2 3 4\n")).mesh;
    let colored = QUAD.replace("0\n", "0 nan 0.5 nan\n");
    assert_eq!(read(format!("{colored}f 1 2 3 4\n")).mesh, mesh);
    assert_eq!(read(format!("{}f 1 2 3 4\n", QUAD.replace("0\n", "0 1.0\n"))).mesh, mesh);
    let halves = read(format!("{}f 1 2 3 4\n", QUAD.replace("0\n", "0 2\n"))).mesh;
    assert_eq!(halves.positions[2], DVec3::new(0.5, 0.5, 0.0));
}

/// A face without normals between faces with normals gets computed ones, not its neighbor's.
#[test]
fn missing_normals_are_computed_face_by_face() {
    let text = format!("{QUAD}vn 0.6 0 0.8\nf 1//1 2//1 3//1\nf 1 3 4\n");
    let file = read(&text);
    let normal = |t| file.mesh.shading_normal(t, [0.2, 0.2], file.mesh.geometric_normal(t));
    assert!((normal(0) - DVec3::new(0.6, 0.0, 0.8)).length() < 1e-15);
    assert_eq!(normal(1), DVec3::Z);
    assert!(file.warnings.is_empty());
    let dangling = read(text.replace("f 1 3 4", "f 1//1 3//2 4//-3"));
    assert_eq!(dangling.mesh, file.mesh);
    assert_eq!(
        dangling.warnings,
        ["2 corners name a normal that is not there: their faces' normals are made"]
    );
}

/// A sphere of 24 × 12 facets around, as CAD systems write it: each facet with corners of its own.
fn sphere(own_corners: bool) -> String {
    let (around, up) = (24, 12);
    let corner = |i: usize, j: usize| {
        let azimuth = (i % around) as f64 / around as f64 * std::f64::consts::TAU;
        let polar = j as f64 / up as f64 * std::f64::consts::PI;
        let ring = if j == 0 || j == up { 0.0 } else { polar.sin() };
        format!("v {} {} {}\n", ring * azimuth.cos(), ring * azimuth.sin(), polar.cos())
    };
    let mut text = String::new();
    if !own_corners {
        (0..=up).for_each(|j| (0..around).for_each(|i| text += &corner(i, j)));
    }
    for j in 0..up {
        for i in 0..around {
            let places = [[i, j], [i, j + 1], [i + 1, j + 1], [i + 1, j]];
            if own_corners {
                text += &places.map(|[i, j]| corner(i, j)).concat();
                text += "f -4 -3 -2 -1\n";
            } else {
                let [a, b, c, d] = places.map(|[i, j]| 1 + j * around + i % around);
                text += &format!("f {a} {b} {c} {d}\n");
            }
        }
    }
    text
}

#[test]
fn facets_with_corners_of_their_own_are_welded() {
    let (own, shared) = (read(sphere(true)).mesh, read(sphere(false)).mesh);
    assert_eq!(own.positions.len(), 11 * 24 + 2);
    assert_eq!(Closure::of(&own).open_edges, 0);
    assert_eq!(own.triangles.len(), shared.triangles.len());
    for triangle in 0..own.triangles.len() {
        let normal = |mesh: &Mesh| {
            mesh.shading_normal(triangle, [0.2, 0.3], mesh.geometric_normal(triangle))
        };
        assert!((normal(&own) - normal(&shared)).length() < 1e-14);
        let [a, b, c] = own.corners(triangle);
        let outward = (a * 0.5 + b * 0.2 + c * 0.3).normalize();
        // Facets are 15° wide: flat, they would be off by 7.5° and more.
        assert!(normal(&own).angle_between(outward).to_degrees() < 1.5);
    }
    assert!(own.volume_mm3() > 0.0);
}

/// As after rounding to a thousandth.
#[test]
fn near_vertices_are_welded_on_request() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1.0004 0 0\nv 1 1 0\nv 0 1.0004 0\nf 1 2 3\nf 4 5 6\n";
    assert_eq!(Closure::of(&read(text).mesh).open_edges, 6);
    let welded =
        read_with(text, &MeshReading { weld_mm: 1e-3, ..MeshReading::default() }).unwrap().mesh;
    assert_eq!((Closure::of(&welded).open_edges, welded.positions.len()), (4, 4));
}

const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
                    f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

#[test]
fn a_cube_without_normals_is_flat() {
    let cube = read(CUBE).mesh;
    assert!(bend_deg(&cube) < NO_BEND);
    assert!((cube.volume_mm3() - 1.0).abs() < 1e-12 && (cube.area_mm2() - 6.0).abs() < 1e-12);
    let smooth =
        read_with(CUBE, &MeshReading { crease_deg: 180.0, ..MeshReading::default() }).unwrap().mesh;
    assert!((bend_deg(&smooth) - 54.7).abs() < 0.1);
    let flat = MeshReading { interpolation: Interpolation::Flat, ..MeshReading::default() };
    assert_eq!(read_with(CUBE, &flat).unwrap().mesh.shading, Shading::Flat);
}

#[test]
fn smoothing_groups_are_honored() {
    assert!(bend_deg(&read(CUBE.replacen("f 1 4", "s 1\nf 1 4", 1)).mesh) > 50.0);
    assert!(bend_deg(&read(CUBE.replacen("f 1 4", "s off\nf 1 4", 1)).mesh) < NO_BEND);
    // A group a face: sharp, however small the angle.
    let mut group = 0;
    let split = sphere(true).replace("f -4", "s N\nf -4");
    let numbered = split.split('N').map(|part| {
        group += 1;
        format!("{part}{group}")
    });
    assert!(
        bend_deg(&read(numbered.collect::<String>().trim_end_matches(char::is_numeric)).mesh)
            < NO_BEND
    );
    assert!(bend_deg(&read(sphere(true).replacen("f -4", "s off\nf -4", 1)).mesh) < NO_BEND);
}

#[test]
fn units_and_scales_are_lengths_in_mm() {
    let inches = MeshReading { unit_mm: 25.4, ..MeshReading::default() };
    assert_eq!(read_with(CUBE, &inches).unwrap().mesh.bounds()[1], DVec3::splat(25.4));
    let huge = MeshReading { unit_mm: 1e308, ..MeshReading::default() };
    let text = QUAD.replace('1', "10") + "f 1 2 3\n";
    assert!(read_with(text, &huge).unwrap_err().problem.contains("not finite once it is scaled"));
}

#[test]
fn numbers_are_exact_however_they_are_written() {
    let written = [
        "1.5",
        "-0.1",
        "+2",
        ".5",
        "5.",
        "1e3",
        "1E-3",
        "1e+02",
        "0.1e1",
        "123456789012345678",
        "3.3333333333333335",
        "1e-300",
        "1.7976931348623157e308",
        "0.000000000000000000000001",
        "9007199254740993",
        "1e23",
        "8.41e21",
        "4.9e-324",
        "0e999",
        "00012.50",
    ];
    for number in written {
        let mesh = read(format!("v {number} 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n")).mesh;
        assert_eq!(
            mesh.positions[0].x.to_bits(),
            number.parse::<f64>().unwrap().to_bits(),
            "{number}"
        );
    }
}

#[test]
fn faults_name_their_line() {
    let line = |number, problem: &str| (Place::Line(number), problem.to_owned());
    assert_eq!(fault("v 0 0 nan\n"), line(1, "position has NaN, expected finite numbers"));
    assert_eq!(fault("# x\nv 0 zero 0\n"), line(2, "position has \"zero\", expected a number"));
    assert_eq!(
        fault("v 0,5 1,0 2,0\n"),
        line(1, "position has \"0,5\", expected a number (with a decimal point, not a comma)")
    );
    assert_eq!(fault("v 0 0\n"), line(1, "position has 2 numbers, expected x y z"));
    assert_eq!(fault("vn 0 inf 0\n"), line(1, "normal has inf, expected finite numbers"));
    assert_eq!(
        fault(format!("{QUAD}f 1 2 7\n")),
        line(5, "position index is 7, allowed: 1 to 4 above this line, or −4 to −1")
    );
    assert_eq!(
        fault(format!("{QUAD}f 1 2 -5\nv 0 0 0\n")),
        line(5, "position index is -5, allowed: 1 to 5, or −4 to −1")
    );
    assert_eq!(
        fault(format!("{QUAD}f 1 2 x\n")),
        line(5, "position index is \"x\", expected a number")
    );
    assert_eq!(
        fault(format!("{QUAD}f 1 2 3//1.5\n")),
        line(5, "normal index is \"1.5\", expected a number")
    );
    assert_eq!(fault(format!("{QUAD}f 1 2\n")), line(5, "face has 2 corners, expected 3 or more"));
    assert_eq!(fault("v 0 0 0\n"), (Place::File, "no faces".into()));
    assert_eq!(fault(""), (Place::File, "is empty".into()));
    let problem =
        read_with(format!("{QUAD}g lens\nf 1 2 3\n"), &group("lense")).unwrap_err().problem;
    assert_eq!(
        problem,
        "no faces in group \"lense\" (groups: lens; objects: none; materials: none)"
    );
}

#[test]
fn degenerate_faces_are_left_out() {
    let file = read(format!("{QUAD}f 1 1 2\nf 1 2 2 3 4 4\nf 1 2 1\n"));
    assert_eq!(file.mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(file.warnings, ["at least 1 faces have shrunk to an edge and are left out"]);
    assert!(
        fault("v 0 0 0\nv 0 0 0\nv 1 0 0\nf 1 2 3\n").1.starts_with("all faces have fewer than 3")
    );
}

#[test]
fn writing_and_reading_gives_the_same_bits() {
    let text = format!(
        "{QUAD}v 0.1 1e-300 3.3333333333333335\nvn 0.6 0 0.8\n\
         f 1//1 2//1 3//1\nf 1//1 3//1 5//1\nf 1//1 5//1 4//1\n"
    );
    for mesh in [read(&text).mesh, read(CUBE).mesh, read(sphere(true)).mesh] {
        assert_eq!(read(to_text(&mesh)).mesh, mesh);
        assert!(matches!(
            read(to_text(&mesh.clone().into_flat())).mesh.shading,
            Shading::PerCorner { .. }
        ));
        assert!(bend_deg(&read(to_text(&mesh.into_flat())).mesh) < NO_BEND);
    }
}

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

const BASE64: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

fn base64(bytes: &[u8]) -> String {
    let letters = bytes.chunks(3).flat_map(|part| {
        let bits =
            part.iter().fold(0u32, |bits, &b| bits << 8 | u32::from(b)) << (8 * (3 - part.len()));
        (0..=part.len()).map(move |k| BASE64[(bits >> (18 - 6 * k)) as usize & 63] as char)
    });
    letters.collect()
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
