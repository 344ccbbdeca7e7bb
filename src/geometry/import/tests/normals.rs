//! Normals, welding and smoothing.

use super::*;

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
