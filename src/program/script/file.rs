//! `lampyris.write` and `lampyris.read`: text.

use mlua::{Lua, Table};

use super::options::Arguments;
use super::{fault, host};
use crate::error::Error;
use crate::output;

pub(super) fn register(lua: &Lua, module: &Table) -> mlua::Result<()> {
    module.set(
        "write",
        fault::function(lua, |lua, a| {
            let mut arguments = Arguments::new("write", a, 2)?;
            let target = host::of(lua)?.output(&arguments.text("path")?)?;
            Ok(output::write_text(&target, &arguments.text("text")?)?)
        })?,
    )?;
    module.set(
        "read",
        fault::function(lua, |lua, a| {
            let path = host::of(lua)?.input(&Arguments::new("read", a, 1)?.text("path")?)?;
            host::reserve_for_file(lua, "read", &path)?;
            std::fs::read_to_string(&path).map_err(|e| Error::io(&path, e).into())
        })?,
    )
}
