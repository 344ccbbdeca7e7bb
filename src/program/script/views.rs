//! The views of a sweep: a list, or a function that gives one after the other.

use std::sync::Arc;

use mlua::thread::ThreadStatus;
use mlua::{Lua, MultiValue, Thread, Value};

use super::options;
use super::scene::{LuaScene, reserve_picture};
use super::sweep::shot;
use super::view::LuaView;
use crate::program::sweep::Shot;
use crate::render::Asked;

/// Where the views come from.
pub(super) struct Views {
    scene: Option<LuaScene>,
    asked: Asked,
    from: From,
}

enum From {
    List(Vec<Value>),
    /// Called with 1, 2, … until it returns nil; or it yields its views.
    Function(mlua::Function),
    /// A function that has yielded.
    Yielding(Thread),
}

impl Views {
    pub(super) fn new(value: Value, scene: Option<LuaScene>, asked: Asked) -> mlua::Result<Self> {
        const EXPECTED: &str = "a list of views, or a function that returns them one by one";
        let from = match value {
            Value::Function(function) => From::Function(function),
            value => From::List(options::list("sweep", "\"views\"", &value, EXPECTED)?),
        };
        Ok(Self { scene, asked, from })
    }

    /// How many there are, if that is known.
    pub(super) fn count(&self) -> Option<usize> {
        match &self.from {
            From::List(list) => Some(list.len()),
            From::Function(_) | From::Yielding(_) => None,
        }
    }

    /// Pixels of the views of a list whose index passes; 0 for a function.
    pub(super) fn pixels_where(&self, passes: impl Fn(usize) -> bool) -> usize {
        let From::List(list) = &self.from else {
            return 0;
        };
        let pixels = |value: &Value| -> Option<usize> {
            let view = match value {
                Value::Table(table) => table.raw_get("view").ok()?,
                other => other.clone(),
            };
            let view = view.as_userdata()?.borrow::<LuaView>().ok()?.0;
            Some(view.pixels())
        };
        (1..).zip(list).filter(|(index, _)| passes(*index)).filter_map(|(_, v)| pixels(v)).sum()
    }

    /// View `index`, 1-based and asked for in order; `None` after the last.
    pub(super) fn next(&mut self, lua: &Lua, index: usize) -> mlua::Result<Option<Shot>> {
        let values = match &self.from {
            From::List(list) => match list.get(index - 1) {
                Some(view) => MultiValue::from_vec(vec![view.clone()]),
                None => return Ok(None),
            },
            From::Yielding(thread) if thread.status() != ThreadStatus::Resumable => {
                return Ok(None);
            }
            From::Yielding(thread) => thread.resume::<MultiValue>(())?,
            From::Function(function) => {
                let thread = lua.create_thread(function.clone())?;
                let values = thread.resume::<MultiValue>(index)?;
                if thread.status() == ThreadStatus::Resumable {
                    self.from = From::Yielding(thread);
                }
                values
            }
        };
        let mut values = values.into_iter();
        let view = values.next().unwrap_or(Value::Nil);
        let scene = values.next().unwrap_or(Value::Nil);
        if view.is_nil() {
            return Ok(None);
        }
        let shot = shot(index, &view, &scene, self.scene.as_ref())?;
        reserve_picture(lua, &format!("sweep: view {index}"), &shot.view, &self.asked)?;
        LuaScene(Arc::clone(&shot.stage)).reserve(lua)?;
        Ok(Some(shot))
    }
}
