//! Rays, meshes and start surfaces.

use std::sync::Arc;

use super::super::fields::{Cell, Fields, field};
use crate::geometry::import::MeshFile;
use crate::geometry::{Closure, DVec3, Mesh};
use crate::source::surface_fit::{FittedSurface, SurfaceFit};

/// A ray where it is in the scene.
pub struct WorldRay {
    /// Where it starts, mm.
    pub position: DVec3,
    /// Unit vector.
    pub direction: DVec3,
    /// Luminous flux, lm.
    pub flux_lm: f64,
}

/// A ray of a set.
pub const RAY: Fields<WorldRay> = Fields {
    class: "Ray",
    fields: &[
        field("position", "vector", "mm", |ray| ray.position.into()),
        field("direction", "vector", "", |ray| ray.direction.into()),
        field("flux", "number", "lm", |ray| ray.flux_lm.into()),
    ],
};

/// A mesh, and the names of its file's parts that have faces.
#[derive(Debug, Clone)]
pub struct NamedMesh {
    /// In the coordinates of its own, mm.
    pub mesh: Arc<Mesh>,
    /// Groups of the file.
    pub groups: Arc<[String]>,
    /// Objects of the file.
    pub objects: Arc<[String]>,
    /// Materials of the file.
    pub materials: Arc<[String]>,
}

/// A mesh that is from no file.
impl From<Mesh> for NamedMesh {
    fn from(mesh: Mesh) -> Self {
        let none = || Arc::from([]);
        Self { mesh: Arc::new(mesh), groups: none(), objects: none(), materials: none() }
    }
}

impl From<MeshFile> for NamedMesh {
    fn from(file: MeshFile) -> Self {
        Self {
            mesh: Arc::new(file.mesh),
            groups: file.groups.into(),
            objects: file.objects.into(),
            materials: file.materials.into(),
        }
    }
}

/// A mesh, as scripts and `lampyris info` show it.
pub const MESH: Fields<NamedMesh> = Fields {
    class: "Mesh",
    fields: &[
        field("triangle_count", "integer", "", |named| named.mesh.triangles.len().into()),
        field("bounds", "vector[]", "lowest and highest corner, mm", |named| {
            named.mesh.bounds().into()
        }),
        field("area", "number", "mm²", |named| named.mesh.area_mm2().into()),
        field(
            "volume",
            "number",
            "mm³, of a closed mesh; negative if its fronts are inside",
            |named| named.mesh.volume_mm3().into(),
        ),
        field("open_edges", "integer", "0: the mesh is closed", |named| {
            Closure::of(&named.mesh).open_edges.into()
        }),
        field("groups", "string[]", "names of the file's groups that have faces", |named| {
            named.groups.to_vec().into()
        }),
        field("objects", "string[]", "names of its objects that have faces", |named| {
            named.objects.to_vec().into()
        }),
        field("materials", "string[]", "names of its materials that have faces", |named| {
            named.materials.to_vec().into()
        }),
    ],
};

/// What start points lie on, in the set's own coordinates, and whether it is the source's.
pub const START_SURFACE: Fields<(SurfaceFit, bool)> = Fields {
    class: "FittedSurface",
    fields: &[
        field("kind", "\"point\"|\"sphere\"|\"cylinder\"|\"plane\"", "", |(fit, _)| {
            match fit.surface {
                FittedSurface::Point { .. } => "point",
                FittedSurface::Sphere { .. } => "sphere",
                FittedSurface::Cylinder { .. } => "cylinder",
                FittedSurface::Plane { .. } => "plane",
            }
            .into()
        }),
        field("center", "vector", "mm", |(fit, _)| {
            match fit.surface {
                FittedSurface::Point { at } => at,
                FittedSurface::Sphere { center, .. } => center,
                FittedSurface::Cylinder { through, .. } | FittedSurface::Plane { through, .. } => {
                    through
                }
            }
            .into()
        }),
        field("axis", "vector?", "of a cylinder", |(fit, _)| match fit.surface {
            FittedSurface::Cylinder { axis, .. } => axis.into(),
            _ => Cell::Nothing,
        }),
        field("normal", "vector?", "of a plane", |(fit, _)| match fit.surface {
            FittedSurface::Plane { normal, .. } => normal.into(),
            _ => Cell::Nothing,
        }),
        field("radius", "number?", "mm; of a plane: that all starts are within", |(fit, _)| {
            match fit.surface {
                FittedSurface::Point { .. } => Cell::Nothing,
                FittedSurface::Sphere { radius_mm, .. }
                | FittedSurface::Cylinder { radius_mm, .. }
                | FittedSurface::Plane { radius_mm, .. } => radius_mm.into(),
            }
        }),
        field("length", "number?", "mm, of a cylinder", |(fit, _)| match fit.surface {
            FittedSurface::Cylinder { length_mm, .. } => length_mm.into(),
            _ => Cell::Nothing,
        }),
        field("rms", "number", "distance of the starts that it explains, mm", |(fit, _)| {
            fit.rms_mm.into()
        }),
        field("share", "number", "of the starts that it explains, 0 to 1", |(fit, _)| {
            fit.share.into()
        }),
        field("is_source", "boolean", "false where the rays come from inside of it", |c| {
            c.1.into()
        }),
    ],
};
