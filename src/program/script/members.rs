//! What a handle and a table of functions have: one list registers the members, and names them where
//! a script asks for another.

use std::sync::Arc;

use mlua::{IntoLua, IntoLuaMulti, Lua, MetaMethod, MultiValue, Table, UserDataFields, Value};
use mlua::{UserDataMethods, UserDataRegistry};

use super::options::Arguments;
use super::{fault, kept};
use crate::program::fields::Fields;

/// The fields and methods of the handle `T`, as they are registered.
pub(super) struct Members<'r, T> {
    registry: &'r mut UserDataRegistry<T>,
    object: &'static str,
    names: Vec<&'static str>,
}

impl<'r, T: 'static> Members<'r, T> {
    /// `object` names the handle in messages: "mesh", whose method is `mesh:save`.
    pub fn new(registry: &'r mut UserDataRegistry<T>, object: &'static str) -> Self {
        Self { registry, object, names: Vec::new() }
    }

    pub fn field<R: IntoLua>(
        &mut self,
        name: &'static str,
        value: impl Fn(&Lua, &T) -> mlua::Result<R> + Send + Sync + 'static,
    ) {
        self.names.push(name);
        self.registry.add_field_method_get(name, value);
    }

    /// A field for each field of a record.
    pub fn record<R>(&mut self, record: &'static Fields<R>, of: fn(&T) -> &R) {
        for field in record.fields {
            self.field(field.name, move |_, this| Ok((field.cell)(of(this))));
        }
    }

    /// A method of at most `most` arguments; its errors carry the script's line.
    pub fn method<R: IntoLuaMulti>(
        &mut self,
        name: &'static str,
        most: usize,
        f: impl Fn(&Lua, &T, Arguments) -> mlua::Result<R> + Send + Sync + 'static,
    ) {
        self.names.push(name);
        let object: Arc<str> = format!("{}:{name}", self.object).into();
        self.registry.add_method(name, move |lua, this, arguments: MultiValue| {
            let arguments = Arguments::new(Arc::clone(&object), arguments, most);
            let done = arguments.and_then(|arguments| f(lua, this, arguments));
            done.map_err(|error| fault::located(lua, error))
        });
    }

    /// What `print` and `tostring` show.
    pub fn text(&mut self, text: impl Fn(&T) -> mlua::Result<String> + Send + Sync + 'static) {
        self.registry.add_meta_method(MetaMethod::ToString, move |_, this, ()| text(this));
    }

    /// A binary operator, of which either side may be the handle.
    pub fn operator<R: IntoLua>(
        &mut self,
        operator: MetaMethod,
        f: impl Fn(&Lua, [Value; 2]) -> mlua::Result<R> + Send + Sync + 'static,
    ) {
        self.registry.add_meta_function(operator, move |lua, (a, b): (Value, Value)| {
            f(lua, [a, b]).map_err(|error| fault::located(lua, error))
        });
    }

    /// What `#handle` is.
    pub fn length(&mut self, length: impl Fn(&T) -> usize + Send + Sync + 'static) {
        self.registry.add_meta_method(MetaMethod::Len, move |_, this, ()| Ok(length(this)));
    }

    /// Ends the list: to read any other name is an error with the nearest one.
    pub fn no_others(self) {
        let Self { registry, object, names } = self;
        fault::refuse_unknown_fields(registry, object, names);
    }
}

/// The functions of a table, as they are registered.
pub(super) struct Functions<'l> {
    lua: &'l Lua,
    table: Table,
    /// Stands before a function's name in messages: "mesh." of `mesh.load`.
    prefix: String,
}

impl<'l> Functions<'l> {
    /// The module itself.
    pub fn of_module(lua: &'l Lua, module: &Table) -> Self {
        Self { lua, table: module.clone(), prefix: String::new() }
    }

    /// Adds a function of at most `most` arguments; its errors carry the script's line.
    pub fn add<R: IntoLuaMulti>(
        &self,
        name: &str,
        most: usize,
        f: impl Fn(&Lua, Arguments) -> mlua::Result<R> + Send + Sync + 'static,
    ) -> mlua::Result<()> {
        let object: Arc<str> = format!("{}{name}", self.prefix).into();
        let function = fault::function(self.lua, move |lua, arguments| {
            f(lua, Arguments::new(Arc::clone(&object), arguments, most)?)
        })?;
        self.table.set(name, function)
    }

    /// As [`Functions::add`], for what takes long and gives the same for the same arguments and
    /// files: results may be kept from run to run.
    pub fn add_kept<R: IntoLuaMulti>(
        &self,
        name: &str,
        most: usize,
        f: impl Fn(&Lua, Arguments) -> mlua::Result<R> + Send + Sync + 'static,
    ) -> mlua::Result<()> {
        let object: Arc<str> = format!("{}{name}", self.prefix).into();
        let function = fault::function(self.lua, move |lua, arguments| {
            kept::recall(lua, &object, arguments, |arguments| {
                f(lua, Arguments::new(Arc::clone(&object), arguments, most)?)?.into_lua_multi(lua)
            })
        })?;
        self.table.set(name, function)
    }

    /// Adds a value that is there already.
    pub fn add_value(&self, name: &str, value: impl IntoLua) -> mlua::Result<()> {
        self.table.set(name, value)
    }
}

/// Puts a table of functions into the module; to read any other name of it is an error with the
/// nearest one.
pub(super) fn functions(
    lua: &Lua,
    module: &Table,
    name: &str,
    list: impl FnOnce(&Functions) -> mlua::Result<()>,
) -> mlua::Result<()> {
    let table = lua.create_table()?;
    list(&Functions { lua, table: table.clone(), prefix: format!("{name}.") })?;
    fault::refuse_unknown_names(lua, &table, &format!("lampyris.{name}"))?;
    module.set(name, table)
}
