//! `lampyris.mesh`.

use std::sync::Arc;

use glam::DQuat;
use mlua::{Function, Lua, MetaMethod, Table, UserData, UserDataFields, UserDataMethods, Value};

use super::options::{self, Arguments, Options, Range};
use super::{fault, host};
use crate::error::Error;
use crate::geometry::mesh::{Placement, Shading};
use crate::geometry::{DVec3, Mesh, Plane, obj};
use crate::output;

/// Handle of a mesh.
#[derive(Debug, Clone)]
pub struct LuaMesh(pub Arc<Mesh>);

const NAMES: [&str; 6] = ["transform", "save", "triangle_count", "bounds", "flat", "section"];

/// Cells a side of a surface grid.
const MAX_CELLS: u64 = 100_000;

pub(super) fn register(lua: &Lua, module: &Table) -> mlua::Result<()> {
    let table = lua.create_table()?;
    table.set(
        "load",
        fault::function(lua, |lua, a| load(lua, Arguments::new("mesh.load", a, 2)?))?,
    )?;
    table
        .set("new", fault::function(lua, |_, a| from_tables(Arguments::new("mesh.new", a, 1)?))?)?;
    table.set(
        "surface",
        fault::function(lua, |_, a| surface(Arguments::new("mesh.surface", a, 1)?))?,
    )?;
    table.set("merge", fault::function(lua, |_, a| merge(Arguments::new("mesh.merge", a, 1)?))?)?;
    fault::refuse_unknown_names(lua, &table, "lampyris.mesh")?;
    module.set("mesh", table)
}

fn new_handle(mesh: Mesh, smooth: bool) -> LuaMesh {
    LuaMesh(Arc::new(if smooth { mesh } else { mesh.into_flat() }))
}

fn load(lua: &Lua, mut arguments: Arguments) -> mlua::Result<LuaMesh> {
    let path = arguments.text("path")?;
    let options = arguments.options(&["group", "scale", "smooth"])?;
    let scale = options.number_or("scale", Range::above_zero(""), 1.0)?;
    let smooth = options.flag("smooth", true)?;
    let path = host::of(lua)?.input(&path)?;
    let mesh = obj::load(&path, options.text("group")?.as_deref())?;
    let placed = if scale == 1.0 {
        mesh
    } else {
        mesh.transformed(&Placement { scale, ..Default::default() })
    };
    Ok(new_handle(placed, smooth))
}

fn from_tables(mut arguments: Arguments) -> mlua::Result<LuaMesh> {
    let options = arguments.options(&["normals", "positions", "smooth", "triangles"])?;
    let positions = options.required_vectors("positions")?;
    let triangles = triangles(&options, positions.len())?;
    let smooth = options.flag("smooth", true)?;
    let mesh = Mesh::smooth(options.object(), positions, triangles)?;
    let Some(normals) = options.vectors("normals")? else {
        return Ok(new_handle(mesh, smooth));
    };
    if normals.len() != mesh.positions.len() {
        let problem = format!(
            "{} normals for {} positions, expected one each",
            normals.len(),
            mesh.positions.len()
        );
        return Err(Error::inconsistent(options.object(), problem).into());
    }
    let unit = normals.iter().map(|n| n.try_normalize().unwrap_or(DVec3::ZERO)).collect();
    Ok(new_handle(Mesh { shading: Shading::PerPosition(unit), ..mesh }, smooth))
}

fn triangles(options: &Options, positions: usize) -> mlua::Result<Vec<[u32; 3]>> {
    const EXPECTED: &str = "a list of {i, j, k}";
    let entry = |what: &str, value: &Value| -> mlua::Result<[u32; 3]> {
        let corners = options::list(options.object(), what, value, "{i, j, k}")?;
        let [a, b, c] = corners.as_slice() else {
            let problem = format!("{what} has {} entries, expected {{i, j, k}}", corners.len());
            return Err(Error::inconsistent(options.object(), problem).into());
        };
        let index = |value: &Value| {
            options::count(options.object(), what, value, 1, positions as u64)
                .map(|i| (i - 1) as u32)
        };
        Ok([index(a)?, index(b)?, index(c)?])
    };
    options.required_list_of("triangles", EXPECTED, entry)
}

fn surface(mut arguments: Arguments) -> mlua::Result<LuaMesh> {
    let options = arguments.options(&["keep", "nu", "nv", "point", "smooth"])?;
    let cells =
        |key, default| options.count(key, 1, MAX_CELLS).map(|n| n.unwrap_or(default) as usize);
    let (nu, nv) = (cells("nu", 100)?, cells("nv", 100)?);
    let point = options.required_function("point", "a function of u, v that returns x, y, z")?;
    let keep = options.function("keep")?;
    let mut points = Vec::with_capacity((nu + 1) * (nv + 1));
    for j in 0..=nv {
        for i in 0..=nu {
            let place = [i as f64 / nu as f64, j as f64 / nv as f64];
            points.push(surface_point(&options, &point, keep.as_ref(), place)?);
        }
    }
    let mesh = Mesh::from_grid(options.object(), nu, nv, &points)?;
    Ok(new_handle(mesh, options.flag("smooth", true)?))
}

/// The surface at (u, v), or `None` where it is not to be kept.
fn surface_point(
    options: &Options,
    point: &Function,
    keep: Option<&Function>,
    [u, v]: [f64; 2],
) -> mlua::Result<Option<DVec3>> {
    let (x, y, z): (Value, Value, Value) = point.call((u, v))?;
    let part = |value: &Value| {
        let what = format!("\"point\" at u = {u}, v = {v}");
        options::number(options.object(), &what, value, Range::ANY)
    };
    let position = DVec3::new(part(&x)?, part(&y)?, part(&z)?);
    match keep {
        Some(keep) if !keep.call::<bool>((position.x, position.y, position.z))? => Ok(None),
        _ => Ok(Some(position)),
    }
}

/// One mesh of several, each with its own positions and normals.
fn merge(mut arguments: Arguments) -> mlua::Result<LuaMesh> {
    const OBJECT: &str = "mesh.merge";
    let list = options::list(OBJECT, "argument", &arguments.value(), "a list of meshes")?;
    let handle = |value: &Value| options::handle::<LuaMesh>(OBJECT, "entry", value, "a mesh");
    let meshes: Vec<LuaMesh> = list.iter().map(handle).collect::<mlua::Result<_>>()?;
    let meshes: Vec<&Mesh> = meshes.iter().map(|mesh| mesh.0.as_ref()).collect();
    Ok(LuaMesh(Arc::new(Mesh::merged(OBJECT, &meshes)?)))
}

/// `translate`, `rotate = {axis =, angle =}` and `scale` of a transform.
pub(super) fn placement(object: &str, value: Value) -> mlua::Result<Placement> {
    let options = Options::new(object, value, &["rotate", "scale", "translate"])?;
    let rotation = match options.value("rotate")? {
        Value::Nil => DQuat::IDENTITY,
        value => rotation(&format!("{object}: rotate"), value)?,
    };
    Ok(Placement {
        scale: options.number_or("scale", Range::above_zero(""), 1.0)?,
        rotation,
        translation: options.vector("translate")?.unwrap_or(DVec3::ZERO),
    })
}

fn rotation(object: &str, value: Value) -> mlua::Result<DQuat> {
    let options = Options::new(object, value, &["angle", "axis"])?;
    let axis = options.vector("axis")?.unwrap_or(DVec3::Y);
    let angle_deg = options.required_number("angle", Range::ANY)?;
    match axis.try_normalize() {
        Some(axis) => Ok(DQuat::from_axis_angle(axis, angle_deg.to_radians())),
        None => Err(Error::out_of_range(object, "\"axis\"", axis, "any direction").into()),
    }
}

/// The segments in which the plane `{normal = {1, 0, 0}, through = {0, 0, 0}}` cuts a mesh.
fn section(mesh: &Mesh, mut arguments: Arguments) -> mlua::Result<Vec<[[f64; 3]; 2]>> {
    let options = arguments.options(&["normal", "through"])?;
    let normal = options.vector("normal")?.unwrap_or(DVec3::X);
    let Some(normal) = normal.try_normalize() else {
        let object = options.object();
        return Err(Error::out_of_range(object, "\"normal\"", normal, "any direction").into());
    };
    let point = options.vector("through")?.unwrap_or(DVec3::ZERO);
    let segments = mesh.section(&Plane { point, normal });
    Ok(segments.into_iter().map(|ends| ends.map(|end| end.to_array())).collect())
}

impl UserData for LuaMesh {
    fn add_fields<F: UserDataFields<Self>>(fields: &mut F) {
        fields.add_field_method_get("triangle_count", |_, this| Ok(this.0.triangles.len()));
        fields.add_field_method_get("bounds", |_, this| {
            let [low, high] = this.0.bounds();
            Ok([low.to_array(), high.to_array()])
        });
    }

    fn add_methods<M: UserDataMethods<Self>>(methods: &mut M) {
        fault::method(methods, "transform", |_, this: &Self, a| {
            let value = Arguments::new("mesh:transform", a, 1)?.value();
            let placement = placement("mesh:transform", value)?;
            Ok(LuaMesh(Arc::new(this.0.transformed(&placement))))
        });
        fault::method(methods, "save", |lua, this: &Self, a| {
            let path = Arguments::new("mesh:save", a, 1)?.text("path")?;
            let path = host::of(lua)?.output(&path)?;
            Ok(output::write_text(&path, &obj::to_text(&this.0))?)
        });
        fault::method(methods, "flat", |_, this: &Self, _| {
            Ok(Self(Arc::new(Mesh::clone(&this.0).into_flat())))
        });
        fault::method(methods, "section", |_, this: &Self, a| {
            section(&this.0, Arguments::new("mesh:section", a, 1)?)
        });
        methods.add_meta_method(MetaMethod::Len, |_, this, ()| Ok(this.0.triangles.len()));
        methods.add_meta_method(MetaMethod::ToString, |_, this, ()| {
            let [low, high] = this.0.bounds();
            Ok(format!("mesh: {} triangles, {low} to {high} mm", this.0.triangles.len()))
        });
        fault::refuse_unknown_fields(methods, "mesh", &NAMES);
    }
}
