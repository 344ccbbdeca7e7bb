//! What an option's value may be: how it is read, and what is said of it.

mod custom;
mod handles;
mod lists;
mod numbers;
mod words;

use mlua::Value;

use crate::error::Error;

pub(super) use custom::{Any, Custom, any};
pub(super) use handles::{Callback, Handle, SpectrumOrNumber};
pub(super) use lists::{List, Naming, Nested, Numbers, nested, numbers, vectors};
pub(super) use numbers::{Count, Number, Vector, Whole};
pub(super) use words::{Bytes, Choice, Flag, Name, Text};

/// A kind of value. A row's kind is required unless it is made [`Kind::or`] or [`Kind::optional`].
pub(super) trait Kind: Sized {
    type Read;

    /// Reads a value that is there; `what` names it in messages.
    fn read(&self, object: &str, what: &str, value: &Value) -> mlua::Result<Self::Read>;

    /// For the Lua language server.
    fn lua_type(&self) -> String;

    /// What a message about a missing key expects.
    fn expected(&self) -> String;

    /// What stands for an option that the script does not give.
    fn absent(&self, object: &str, key: &str) -> mlua::Result<Self::Read> {
        Err(missing(object, key, &self.expected()))
    }

    fn is_required(&self) -> bool {
        true
    }

    /// Range and unit in words; empty if the type says it.
    fn allowed(&self) -> String {
        String::new()
    }

    /// A default as scripts would write it, or in words.
    fn default_text(&self) -> String {
        String::new()
    }

    /// A value as scripts would write it.
    fn shown(&self, _value: &Self::Read) -> String {
        String::new()
    }

    /// With a value for scripts that give none.
    fn or(self, default: Self::Read) -> Or<Self> {
        Or { kind: self, default }
    }

    /// `None` for scripts that give none, which `default` puts in words.
    fn optional(self, default: &'static str) -> Optional<Self> {
        Optional { kind: self, default }
    }
}

pub(super) fn missing(object: &str, key: &str, expected: &str) -> mlua::Error {
    Error::MissingKey {
        object: object.to_owned(),
        key: key.to_owned(),
        expected: format!("expected {expected}"),
    }
    .into()
}

/// A kind with a default.
pub(super) struct Or<K: Kind> {
    pub kind: K,
    pub default: K::Read,
}

impl<K: Kind<Read: Clone>> Kind for Or<K> {
    type Read = K::Read;

    fn read(&self, object: &str, what: &str, value: &Value) -> mlua::Result<K::Read> {
        self.kind.read(object, what, value)
    }

    fn lua_type(&self) -> String {
        self.kind.lua_type()
    }

    fn expected(&self) -> String {
        self.kind.expected()
    }

    fn absent(&self, _: &str, _: &str) -> mlua::Result<K::Read> {
        Ok(self.default.clone())
    }

    fn is_required(&self) -> bool {
        false
    }

    fn allowed(&self) -> String {
        self.kind.allowed()
    }

    fn default_text(&self) -> String {
        self.kind.shown(&self.default)
    }
}

/// A kind that may be left out.
pub(super) struct Optional<K> {
    kind: K,
    default: &'static str,
}

impl<K: Kind> Kind for Optional<K> {
    type Read = Option<K::Read>;

    fn read(&self, object: &str, what: &str, value: &Value) -> mlua::Result<Self::Read> {
        self.kind.read(object, what, value).map(Some)
    }

    fn lua_type(&self) -> String {
        self.kind.lua_type()
    }

    fn expected(&self) -> String {
        self.kind.expected()
    }

    fn absent(&self, _: &str, _: &str) -> mlua::Result<Self::Read> {
        Ok(None)
    }

    fn is_required(&self) -> bool {
        false
    }

    fn allowed(&self) -> String {
        self.kind.allowed()
    }
    fn default_text(&self) -> String {
        self.default.to_owned()
    }
}
