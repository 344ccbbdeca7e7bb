//! OBJ: statements, parts, units, numbers, faults.

use super::*;

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
