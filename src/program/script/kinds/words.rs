//! Flags, strings and choices.

use mlua::Value;

use super::super::options::{self, wrong_type};
use super::Kind;

/// `true` or `false`.
pub struct Flag;

impl Kind for Flag {
    type Read = bool;

    fn read(&self, object: &str, what: &str, value: &Value) -> mlua::Result<bool> {
        match value {
            Value::Boolean(flag) => Ok(*flag),
            other => Err(wrong_type(object, what, other, &self.expected()).into()),
        }
    }

    fn lua_type(&self) -> String {
        "boolean".to_owned()
    }

    fn expected(&self) -> String {
        "true or false".to_owned()
    }

    fn shown(&self, value: &bool) -> String {
        value.to_string()
    }
}

/// A string, and what a message expects where it is missing.
pub struct Text(pub &'static str);

impl Kind for Text {
    type Read = String;

    fn read(&self, object: &str, what: &str, value: &Value) -> mlua::Result<String> {
        options::text(object, what, value)
    }

    fn lua_type(&self) -> String {
        "string".to_owned()
    }

    fn expected(&self) -> String {
        self.0.to_owned()
    }

    fn shown(&self, value: &String) -> String {
        format!("\"{value}\"")
    }
}

/// A name, or a number from 1 in its place.
pub struct Name;

impl Kind for Name {
    type Read = String;

    fn read(&self, object: &str, what: &str, value: &Value) -> mlua::Result<String> {
        match value {
            Value::String(_) => options::text(object, what, value),
            _ => Ok(options::count(object, what, value, 1, u64::from(u32::MAX))?.to_string()),
        }
    }

    fn lua_type(&self) -> String {
        "integer|string".to_owned()
    }

    fn expected(&self) -> String {
        "a name or a number".to_owned()
    }
}

/// A name of any bytes, as files have them.
pub struct Bytes(pub &'static str);

impl Kind for Bytes {
    type Read = Vec<u8>;

    fn read(&self, object: &str, what: &str, value: &Value) -> mlua::Result<Vec<u8>> {
        match value {
            Value::String(name) => Ok(name.as_bytes().to_vec()),
            other => Err(wrong_type(object, what, other, "a string").into()),
        }
    }

    fn lua_type(&self) -> String {
        "string".to_owned()
    }

    fn expected(&self) -> String {
        self.0.to_owned()
    }
}

/// One of a fixed set of words.
pub struct Choice<T: 'static>(pub &'static [(&'static str, T)]);

impl<T: Copy + PartialEq> Kind for Choice<T> {
    type Read = T;

    fn read(&self, object: &str, what: &str, value: &Value) -> mlua::Result<T> {
        options::choice(object, what, &options::text(object, what, value)?, self.0)
    }

    fn lua_type(&self) -> String {
        let words: Vec<String> = self.0.iter().map(|(word, _)| format!("\"{word}\"")).collect();
        words.join("|")
    }

    fn expected(&self) -> String {
        self.lua_type().replace('|', ", ")
    }

    fn shown(&self, value: &T) -> String {
        let word = self.0.iter().find(|(_, choice)| choice == value);
        word.map_or_else(String::new, |(word, _)| format!("\"{word}\""))
    }
}
