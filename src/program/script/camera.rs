//! `lampyris.camera`.

use mlua::{Lua, MetaMethod, Table, UserData, UserDataMethods, Value};

use super::options::{Arguments, Options, Range};
use super::{fault, figure, image};
use crate::color::D65_XY;
use crate::display::{Camera, Exposure};
use crate::error::Error;

/// Handle of a camera.
#[derive(Debug, Clone)]
pub struct LuaCamera(pub Camera);

const KEYS: [&str; 7] = ["blue", "exposure", "full_well", "green", "name", "red", "white"];

/// A table of cameras that can be called to make one.
pub(super) fn register(lua: &Lua, module: &Table) -> mlua::Result<()> {
    let table = lua.create_table()?;
    table.set("nikon_d5100", LuaCamera(Camera::nikon_d5100()))?;
    table.set("sigma_sd_merrill", LuaCamera(Camera::sigma_sd_merrill()))?;
    fault::refuse_unknown_names(lua, &table, "lampyris.camera")?;
    let call = fault::function(lua, |_, mut a| {
        a.pop_front(); // the table itself
        camera(Arguments::new("camera", a, 1)?)
    })?;
    if let Some(meta) = table.metatable() {
        meta.raw_set("__call", call)?;
    }
    module.set("camera", table)
}

fn camera(mut arguments: Arguments) -> mlua::Result<LuaCamera> {
    let options = arguments.options(&KEYS)?;
    let channel = |key: &str| {
        options.spectrum(key)?.ok_or_else(|| {
            mlua::Error::from(Error::MissingKey {
                object: "camera".to_owned(),
                key: key.to_owned(),
                expected: "expected a spectrum".to_owned(),
            })
        })
    };
    let sensitivities = [channel("red")?, channel("green")?, channel("blue")?];
    let name = options.text("name")?.unwrap_or_else(|| "camera".to_owned());
    let made = Camera {
        exposure: if options.has("exposure")? {
            image::exposure(&options)?
        } else {
            Exposure::Auto
        },
        full_well: options.number_or("full_well", Range::above_zero(""), 1.0)?,
        white_xy: white(&options)?,
        ..Camera::new(&name, sensitivities)
    };
    made.check()?;
    Ok(LuaCamera(made))
}

fn white(options: &Options) -> mlua::Result<[f64; 2]> {
    match options.value("white")? {
        Value::Nil => Ok(D65_XY),
        value => figure::numbers("camera", "\"white\"", &value, Range::between(0.0, 1.0, "")),
    }
}

impl UserData for LuaCamera {
    fn add_methods<M: UserDataMethods<Self>>(methods: &mut M) {
        methods.add_meta_method(MetaMethod::ToString, |_, this, ()| {
            Ok(format!("camera: {}", this.0.name))
        });
        fault::refuse_unknown_fields(methods, "camera", &[]);
    }
}
