//! Numbers and vectors.

use std::marker::PhantomData;

use mlua::Value;

use super::super::options::{self, Range};
use super::Kind;
use crate::error::Error;
use crate::geometry::DVec3;

/// A number in a range.
pub struct Number(pub Range);

impl Kind for Number {
    type Read = f64;

    fn read(&self, object: &str, what: &str, value: &Value) -> mlua::Result<f64> {
        options::number(object, what, value, self.0)
    }

    fn lua_type(&self) -> String {
        "number".to_owned()
    }

    fn expected(&self) -> String {
        format!("a number, {}", self.0)
    }

    fn allowed(&self) -> String {
        self.0.in_words()
    }

    fn shown(&self, value: &f64) -> String {
        value.to_string()
    }
}

/// A whole number, both ends included.
pub struct Count<T> {
    min: u64,
    max: u64,
    unit: &'static str,
    of: PhantomData<T>,
}

impl<T> Count<T> {
    pub const fn new(min: u64, max: u64) -> Self {
        Self { min, max, unit: "", of: PhantomData }
    }

    pub const fn of(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }
}

impl<T: TryFrom<u64> + ToString> Kind for Count<T> {
    type Read = T;

    fn read(&self, object: &str, what: &str, value: &Value) -> mlua::Result<T> {
        let count = options::count(object, what, value, self.min, self.max)?;
        T::try_from(count)
            .map_err(|_| Error::out_of_range(object, what, count, "smaller numbers").into())
    }

    fn lua_type(&self) -> String {
        "integer".to_owned()
    }

    fn expected(&self) -> String {
        format!("a whole number, {} to {}", self.min, self.max)
    }

    fn allowed(&self) -> String {
        format!("{} to {} {}", self.min, self.max, self.unit).trim_end().to_owned()
    }

    fn shown(&self, value: &T) -> String {
        value.to_string()
    }
}

/// A whole number that may be negative, both ends included.
pub struct Whole {
    min: i32,
    max: i32,
}

impl Whole {
    pub const fn new(min: i32, max: i32) -> Self {
        Self { min, max }
    }
}

impl Kind for Whole {
    type Read = i32;

    fn read(&self, object: &str, what: &str, value: &Value) -> mlua::Result<i32> {
        let number = options::number(object, what, value, Range::ANY)?;
        let is_whole = number.fract() == 0.0;
        if is_whole && (f64::from(self.min)..=f64::from(self.max)).contains(&number) {
            return Ok(number as i32);
        }
        Err(Error::out_of_range(object, what, number, self.expected()).into())
    }

    fn lua_type(&self) -> String {
        "integer".to_owned()
    }

    fn expected(&self) -> String {
        format!("whole numbers, {} to {}", self.min, self.max)
    }

    fn allowed(&self) -> String {
        format!("{} to {}", self.min, self.max)
    }

    fn shown(&self, value: &i32) -> String {
        value.to_string()
    }
}

/// `{x, y, z}` with its unit.
pub struct Vector(pub &'static str);

impl Kind for Vector {
    type Read = DVec3;

    fn read(&self, object: &str, what: &str, value: &Value) -> mlua::Result<DVec3> {
        options::vector(object, what, value)
    }

    fn lua_type(&self) -> String {
        "vector".to_owned()
    }

    fn expected(&self) -> String {
        "{x, y, z}".to_owned()
    }

    fn allowed(&self) -> String {
        self.0.to_owned()
    }

    fn shown(&self, DVec3 { x, y, z }: &DVec3) -> String {
        format!("{{{x}, {y}, {z}}}")
    }
}
