//! `lampyris.optical`.

use std::sync::Arc;

use mlua::{Lua, Table};

use super::fault;
use super::spectrum::LuaSpectrum;
use crate::material::OpticalConstants;

/// A table of materials, each with the spectra `n` and `k`.
pub(super) fn register(lua: &Lua, module: &Table) -> mlua::Result<()> {
    let table = lua.create_table()?;
    let all = [("aluminium", OpticalConstants::aluminium()), ("pmma", OpticalConstants::pmma())];
    for (name, OpticalConstants { n, k }) in all {
        let constants = lua.create_table()?;
        constants.set("n", LuaSpectrum(Arc::new(n)))?;
        constants.set("k", LuaSpectrum(Arc::new(k)))?;
        fault::refuse_unknown_names(lua, &constants, &format!("lampyris.optical.{name}"))?;
        table.set(name, constants)?;
    }
    fault::refuse_unknown_names(lua, &table, "lampyris.optical")?;
    module.set("optical", table)
}
