//! What CAD systems write, and what is right for it.

mod formats;
mod normals;
mod wavefront;

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

const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
                    f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

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
