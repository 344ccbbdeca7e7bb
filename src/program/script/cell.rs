//! Results as scripts read them.

use mlua::{IntoLua, Lua, Value};

use crate::program::fields::Cell;

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
