//! Values that a function of the binding reads.

use mlua::Value;

use super::Kind;

/// A value that is read by a function of its own.
pub struct Custom<T> {
    /// For the annotations.
    pub lua_type: &'static str,
    /// Which values are allowed, in words; empty if the type says it.
    pub allowed: &'static str,
    /// As [`Kind::read`].
    pub read: fn(&str, &str, &Value) -> mlua::Result<T>,
    /// As [`Kind::shown`].
    pub shown: fn(&T) -> String,
}

impl<T> Kind for Custom<T> {
    type Read = T;

    fn read(&self, object: &str, what: &str, value: &Value) -> mlua::Result<T> {
        (self.read)(object, what, value)
    }

    fn lua_type(&self) -> String {
        self.lua_type.to_owned()
    }

    fn expected(&self) -> String {
        self.allowed.to_owned()
    }

    fn allowed(&self) -> String {
        self.allowed.to_owned()
    }

    fn shown(&self, value: &T) -> String {
        (self.shown)(value)
    }
}

/// Any value, read by the caller: its type in the annotations, and what messages expect.
pub struct Any {
    pub lua_type: &'static str,
    pub expected: &'static str,
}

/// Any value that need not be there.
pub const fn any(lua_type: &'static str) -> Any {
    Any { lua_type, expected: "" }
}

impl Kind for Any {
    type Read = Value;

    fn read(&self, _: &str, _: &str, value: &Value) -> mlua::Result<Value> {
        Ok(value.clone())
    }

    fn lua_type(&self) -> String {
        self.lua_type.to_owned()
    }

    fn expected(&self) -> String {
        self.expected.to_owned()
    }
}
