//! Results as scripts read them.

use mlua::{IntoLua, Lua, UserDataFields, Value};

use crate::program::fields::{Cell, Fields};

impl IntoLua for Cell {
    fn into_lua(self, lua: &Lua) -> mlua::Result<Value> {
        match self {
            Self::Nothing => Ok(Value::Nil),
            Self::Number(number) => number.into_lua(lua),
            Self::Count(count) => count.into_lua(lua),
            Self::Flag(flag) => flag.into_lua(lua),
            Self::Text(text) => text.into_lua(lua),
            Self::List(list) => list.into_lua(lua),
            Self::Record(cells) => lua.create_table_from(cells)?.into_lua(lua),
        }
    }
}

/// Makes a record's fields those of a handle.
pub(super) fn add_fields<H: 'static, T>(
    fields: &mut impl UserDataFields<H>,
    record: &'static Fields<T>,
    of: fn(&H) -> &T,
) {
    for field in record.fields {
        fields.add_field_method_get(field.name, move |_, this| Ok((field.cell)(of(this))));
    }
}
