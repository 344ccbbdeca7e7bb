//! `lampyris.write` and `lampyris.read`: text.

use mlua::{Lua, Table};

use super::host;
use super::members::Functions;
use crate::input;
use crate::output;

pub(super) fn register(lua: &Lua, module: &Table) -> mlua::Result<()> {
    let functions = Functions::of_module(lua, module);
    functions.add("write", 2, |lua, mut arguments| {
        let target = host::of(lua)?.output(&arguments.text("path")?)?;
        Ok(output::write_text(&target, &arguments.text("text")?)?)
    })?;
    functions.add("read", 1, |lua, mut arguments| {
        let path = host::of(lua)?.input(&arguments.text("path")?)?;
        host::reserve_for_file(lua, "read", &path)?;
        // Bytes, as Lua's strings are.
        lua.create_string(input::bytes(&path)?)
    })
}
