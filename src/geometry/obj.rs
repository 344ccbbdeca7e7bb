//! Meshes as Wavefront OBJ text; [`super::import`] reads it.

use std::fmt::Write as _;

use super::DVec3;
use super::mesh::{Mesh, Shading};

/// The mesh as OBJ text; reading it back gives the same bits.
pub fn to_text(mesh: &Mesh) -> String {
    let mut text = String::from("# lengths in mm\n");
    let mut put = |tag: &str, v: &DVec3| {
        let _ = writeln!(text, "{tag} {} {} {}", v.x, v.y, v.z);
    };
    mesh.positions.iter().for_each(|p| put("v", p));
    let corner_normals = match &mesh.shading {
        Shading::Flat => None,
        Shading::PerPosition(normals) => Some((normals, &mesh.triangles)),
        Shading::PerCorner { normals, triangles } => Some((normals, triangles)),
    };
    match corner_normals {
        Some((normals, _)) => normals.iter().for_each(|n| put("vn", n)),
        None => text.push_str("s off\n"),
    }
    for (at, triangle) in mesh.triangles.iter().enumerate() {
        text.push('f');
        for (k, index) in triangle.iter().enumerate() {
            let _ = match corner_normals {
                Some((_, normals)) => write!(text, " {}//{}", index + 1, normals[at][k] + 1),
                None => write!(text, " {}", index + 1),
            };
        }
        text.push('\n');
    }
    text
}
