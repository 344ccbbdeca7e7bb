//! `lampyris.mesh`.

use std::path::Path;
use std::sync::Arc;

use glam::DQuat;
use mlua::{Function, Lua, Table, UserData, UserDataRegistry, Value};

use super::host;
use super::kinds::{
    Bytes, Callback, Choice, Count, Flag, Kind, List, Naming, Nested, Number, Numbers, Or, Vector,
    vectors,
};
use super::members::{Members, functions};
use super::options::{self, Arguments, Range};
use super::record::options;
use crate::error::Error;
use crate::geometry::import::{self, Interpolation, MeshReading, Selection};
use crate::geometry::mesh::{Axis, Placement, Shading};
use crate::geometry::{DVec3, Mesh, Plane, obj};
use crate::output;
use crate::program::results::{MESH, NamedMesh};

/// Handle of a mesh, and of the names in its file.
#[derive(Debug, Clone)]
pub struct LuaMesh(pub NamedMesh);

impl LuaMesh {
    /// A mesh that came of no file.
    pub(super) fn made(mesh: Mesh) -> Self {
        Self(mesh.into())
    }
}

/// Cells a side of a surface grid.
const MAX_CELLS: u64 = 100_000;

pub(super) fn register(lua: &Lua, module: &Table) -> mlua::Result<()> {
    functions(lua, module, "mesh", |functions| {
        functions.add_kept("load", 2, load)?;
        functions.add("new", 1, from_tables)?;
        functions.add_kept("surface", 1, surface)?;
        functions.add_kept("merge", 1, merge)
    })
}

fn new_handle(mesh: Mesh, smooth: bool) -> LuaMesh {
    LuaMesh::new(if smooth { mesh } else { mesh.into_flat() })
}

/// Room for a mesh with normals, and triangles of its own for them.
fn reserve(lua: &Lua, object: &str, positions: usize, triangles: usize) -> mlua::Result<()> {
    let bytes = 2 * (positions * size_of::<DVec3>() + triangles * size_of::<[u32; 3]>());
    host::reserve(lua, object, bytes, "fewer triangles would fit")
}

impl LuaMesh {
    /// Handle of a mesh that is from no file.
    fn new(mesh: Mesh) -> Self {
        Self(mesh.into())
    }

    /// Another mesh from the same file.
    fn with(&self, mesh: Mesh) -> Self {
        Self(NamedMesh { mesh: Arc::new(mesh), ..self.0.clone() })
    }
}

options! {
    struct MeshLoadOptions {
        /// interpolated normals (eq. 3)
        smooth: bool = Flag.or(true),
        scale: f64 = SCALE,
        /// of the file's lengths
        unit: Option<f64> = Choice(UNITS).optional("\"mm\""),
        /// only this group of the file
        group: Option<Vec<u8>> = Bytes("a group of the file").optional("all"),
        /// only this object (OBJ's `o`, a glTF node, an STL solid)
        object: Option<Vec<u8>> = Bytes("an object of the file").optional("all"),
        /// only what has this material (OBJ's `usemtl`)
        material: Option<Vec<u8>> = Bytes("a material of the file").optional("all"),
        /// vertices this near are one, before normals are made; 0: those exactly equal
        weld: f64 = Number(Range::new(0.0, f64::INFINITY, "mm")).or(0.0),
        /// where the file has no normals and no smoothing groups, sharper edges stay sharp
        crease: f64 = Number(Range::new(0.0, 180.0, "degrees")).or(import::CREASE_DEG),
    }
}

/// mm in each.
const UNITS: &[(&str, f64)] = &[
    ("mm", 1.0),
    ("cm", 10.0),
    ("m", 1000.0),
    ("um", 1e-3),
    ("inch", 25.4),
    ("in", 25.4),
    ("ft", 304.8),
];

const SCALE: Or<Number> = Or { kind: Number(Range::above_zero("")), default: 1.0 };

fn load(lua: &Lua, mut arguments: Arguments) -> mlua::Result<LuaMesh> {
    let path = arguments.text("path")?;
    let options: MeshLoadOptions = arguments.record()?;
    let host = host::of(lua)?;
    let has_unit = options.unit.is_some();
    let found = host.input(&path)?;
    host::reserve_for_file(lua, "mesh.load", &found)?;
    for companion in import::companions(&found)? {
        // What is missing is told by the reader.
        let beside = found.with_file_name(&companion);
        if beside.exists() {
            let name = Path::new(&path).with_file_name(&companion);
            host.note_input(&name.to_string_lossy(), &beside)?;
            host::reserve_for_file(lua, "mesh.load", &beside)?;
        }
    }
    let file = import::load(&found, &options.reading())?;
    let unit = file.unit_warning().filter(|_| !has_unit);
    let warnings = file.warnings.iter().cloned().chain(unit);
    warnings.for_each(|warning| host.warn(format!("{path}: {warning}")));
    Ok(LuaMesh(file.into()))
}

impl MeshLoadOptions {
    fn reading(self) -> MeshReading {
        let Self { smooth, scale, unit, group, object, material, weld, crease } = self;
        MeshReading {
            selection: Selection { group, object, material },
            unit_mm: unit.unwrap_or(1.0) * scale,
            weld_mm: weld,
            crease_deg: crease,
            interpolation: if smooth { Interpolation::Smooth } else { Interpolation::Flat },
        }
    }
}

options! {
    struct MeshNewOptions {
        positions: Vec<DVec3> = vectors("mm"),
        /// {{i, j, k}, …}, 1-based, counter-clockwise from the front
        triangles: Vec<[f64; 3]> = List {
            entry: Numbers { range: Range::ANY, expected: "{i, j, k}" },
            expected: "a list of {i, j, k}",
            naming: Naming::Entry,
        },
        /// one for each position
        normals: Option<Vec<DVec3>> = vectors("").optional("means of the adjoining faces' normals"),
        smooth: bool = Flag.or(true),
    }
}

fn from_tables(lua: &Lua, mut arguments: Arguments) -> mlua::Result<LuaMesh> {
    const OBJECT: &str = "mesh.new";
    let MeshNewOptions { positions, triangles, normals, smooth } = arguments.record()?;
    reserve(lua, OBJECT, positions.len(), triangles.len())?;
    let triangles = (1..).zip(&triangles).map(|row| triangle(OBJECT, row, positions.len()));
    let triangles = triangles.collect::<mlua::Result<_>>()?;
    let mesh = Mesh::smooth(OBJECT, positions, triangles)?;
    let Some(normals) = normals else {
        return Ok(new_handle(mesh, smooth));
    };
    if normals.len() != mesh.positions.len() {
        let problem = format!(
            "{} normals for {} positions, expected one each",
            normals.len(),
            mesh.positions.len()
        );
        return Err(Error::inconsistent(OBJECT, problem).into());
    }
    let unit = normals.iter().map(|n| n.try_normalize().unwrap_or(DVec3::ZERO)).collect();
    Ok(new_handle(Mesh { shading: Shading::PerPosition(unit), ..mesh }, smooth))
}

/// Three positions by their numbers, from 1.
fn triangle(
    object: &str,
    (row, corners): (usize, &[f64; 3]),
    positions: usize,
) -> mlua::Result<[u32; 3]> {
    let what = format!("\"triangles\" entry {row}");
    let index = |number: f64| {
        options::whole(object, &what, number, 1, positions as u64).map(|i| (i - 1) as u32)
    };
    let [a, b, c] = *corners;
    Ok([index(a)?, index(b)?, index(c)?])
}

options! {
    struct MeshSurfaceOptions {
        /// u, v from 0 to 1; x, y, z in mm
        point: Function = Callback {
            lua_type: "fun(u: number, v: number): number, number, number",
            expected: "a function of u, v that returns x, y, z",
        },
        keep: Option<Function> = Callback {
            lua_type: "fun(x: number, y: number, z: number): boolean",
            expected: "a function of x, y, z that returns true or false",
        }.optional("everything"),
        /// along u
        nu: usize = Count::new(1, MAX_CELLS).of("cells").or(100),
        /// along v
        nv: usize = Count::new(1, MAX_CELLS).of("cells").or(100),
        smooth: bool = Flag.or(true),
    }
}

fn surface(lua: &Lua, mut arguments: Arguments) -> mlua::Result<LuaMesh> {
    let given: MeshSurfaceOptions = arguments.record()?;
    let MeshSurfaceOptions { nu, nv, .. } = given;
    /// Memory of a grid's point: its mesh's position and normal, and two triangles.
    const BYTES_A_POINT: usize = 128;
    let bytes = (nu + 1).saturating_mul(nv + 1).saturating_mul(BYTES_A_POINT);
    host::reserve(lua, SURFACE, bytes, "fewer cells, nu and nv, would fit")?;
    let mut points = Vec::with_capacity((nu + 1) * (nv + 1));
    for j in 0..=nv {
        for i in 0..=nu {
            points.push(given.at([i as f64 / nu as f64, j as f64 / nv as f64])?);
        }
    }
    let mesh = Mesh::from_grid(SURFACE, nu, nv, &points)?;
    Ok(new_handle(mesh, given.smooth))
}

const SURFACE: &str = "mesh.surface";

impl MeshSurfaceOptions {
    /// The surface at (u, v), or `None` where it is not to be kept.
    fn at(&self, [u, v]: [f64; 2]) -> mlua::Result<Option<DVec3>> {
        let (x, y, z): (Value, Value, Value) = self.point.call((u, v))?;
        let part = |value: &Value| {
            let what = format!("\"point\" at u = {u}, v = {v}");
            options::number(SURFACE, &what, value, Range::ANY)
        };
        let position = DVec3::new(part(&x)?, part(&y)?, part(&z)?);
        match &self.keep {
            Some(keep) if !keep.call::<bool>((position.x, position.y, position.z))? => Ok(None),
            _ => Ok(Some(position)),
        }
    }
}

/// One mesh of several, each with its own positions and normals.
fn merge(lua: &Lua, mut arguments: Arguments) -> mlua::Result<LuaMesh> {
    const OBJECT: &str = "mesh.merge";
    let list = options::list(OBJECT, "argument", &arguments.value(), "a list of meshes")?;
    let handle = |value: &Value| options::handle::<LuaMesh>(OBJECT, "entry", value, "a mesh");
    let meshes: Vec<LuaMesh> = list.iter().map(handle).collect::<mlua::Result<_>>()?;
    let meshes: Vec<&Mesh> = meshes.iter().map(|mesh| mesh.0.mesh.as_ref()).collect();
    let positions = meshes.iter().map(|mesh| mesh.positions.len()).sum();
    reserve(lua, OBJECT, positions, meshes.iter().map(|mesh| mesh.triangles.len()).sum())?;
    Ok(LuaMesh::new(Mesh::merged(OBJECT, &meshes)?))
}

options! {
    /// Mirrored, then scaled, then turned, then moved.
    struct Transform {
        /// this coordinate changes its sign; fronts stay fronts
        mirror: Option<Axis> = Choice(AXES).optional("none"),
        translate: DVec3 = Vector("mm").or(DVec3::ZERO),
        rotate: Option<Rotation> = Nested::<Rotation>::new().optional(""),
        scale: f64 = SCALE,
    }
}

const AXES: &[(&str, Axis)] = &[("x", Axis::X), ("y", Axis::Y), ("z", Axis::Z)];

options! {
    struct Rotation {
        axis: DVec3 = Vector("").or(DVec3::Y),
        /// degrees, right-handed
        angle: f64 = Number(Range::ANY),
    }
}

impl Transform {
    pub(super) fn placement(&self, object: &str) -> mlua::Result<Placement> {
        let rotation = match &self.rotate {
            None => DQuat::IDENTITY,
            Some(Rotation { axis, angle }) => {
                let axis = direction(&format!("{object}: rotate"), "axis", *axis)?;
                DQuat::from_axis_angle(axis, angle.to_radians())
            }
        };
        Ok(Placement {
            mirror: self.mirror,
            scale: self.scale,
            rotation,
            translation: self.translate,
        })
    }
}

/// The vector at length 1.
fn direction(object: &str, key: &str, vector: DVec3) -> mlua::Result<DVec3> {
    vector.try_normalize().ok_or_else(|| {
        Error::out_of_range(object, &format!("\"{key}\""), vector, "any direction").into()
    })
}

options! {
    struct SectionOptions {
        through: DVec3 = Vector("mm").or(DVec3::ZERO),
        normal: DVec3 = Vector("").or(DVec3::X),
    }
}

/// The segments in which a plane cuts a mesh.
fn section(mesh: &Mesh, mut arguments: Arguments) -> mlua::Result<Vec<[[f64; 3]; 2]>> {
    let SectionOptions { through, normal } = arguments.record()?;
    let plane = Plane { point: through, normal: direction("mesh:section", "normal", normal)? };
    let segments = mesh.section(&plane);
    Ok(segments.into_iter().map(|ends| ends.map(|end| end.to_array())).collect())
}

impl UserData for LuaMesh {
    fn register(registry: &mut UserDataRegistry<Self>) {
        let mut members = Members::new(registry, "mesh");
        members.record(&MESH, |this| &this.0);
        members.method("transform", 1, |lua, this, mut a| {
            let transform: Transform = a.record()?;
            let placement = transform.placement("mesh:transform")?;
            reserve(
                lua,
                "mesh:transform",
                this.0.mesh.positions.len(),
                this.0.mesh.triangles.len(),
            )?;
            let mesh = this.0.mesh.transformed(&placement);
            mesh.check_positions("mesh:transform")?;
            Ok(this.with(mesh))
        });
        members.method("save", 1, |lua, this, mut a| {
            let path = a.text("path")?;
            let path = host::of(lua)?.output(&path)?;
            Ok(output::write_text(&path, &obj::to_text(&this.0.mesh))?)
        });
        members.method("flat", 0, |lua, this, _| {
            reserve(lua, "mesh:flat", this.0.mesh.positions.len(), this.0.mesh.triangles.len())?;
            Ok(this.with(Mesh::clone(&this.0.mesh).into_flat()))
        });
        members.method("section", 1, |_, this, a| section(&this.0.mesh, a));
        members.length(|this| this.0.mesh.triangles.len());
        members.text(|this| {
            let [low, high] = this.0.mesh.bounds();
            Ok(format!("mesh: {} triangles, {low} to {high} mm", this.0.mesh.triangles.len()))
        });
        members.no_others();
    }
}
