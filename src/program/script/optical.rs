//! `lampyris.optical`.

use std::sync::Arc;

use mlua::{Lua, Table};

use super::fault;
use super::members::functions;
use super::spectrum::LuaSpectrum;
use crate::material::OpticalConstants;

/// A table of materials, each with the spectra `n` and `k`.
pub(super) fn register(lua: &Lua, module: &Table) -> mlua::Result<()> {
    let constants = |name: &str, OpticalConstants { n, k }: OpticalConstants| {
        let table = lua.create_table()?;
        table.set("n", LuaSpectrum(Arc::new(n)))?;
        table.set("k", LuaSpectrum(Arc::new(k)))?;
        fault::refuse_unknown_names(lua, &table, &format!("lampyris.optical.{name}"))?;
        mlua::Result::Ok(table)
    };
    functions(lua, module, "optical", |functions| {
        let aluminium = constants("aluminium", OpticalConstants::aluminium())?;
        functions.add_value("aluminium", aluminium)?;
        functions.add_value("pmma", constants("pmma", OpticalConstants::pmma())?)
    })
}
