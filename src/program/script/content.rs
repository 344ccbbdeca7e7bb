//! What Lua values hold, as one digest: functions with equal contents return the same.

use std::collections::{HashMap, HashSet};
use std::ffi::c_void;
use std::sync::Arc;

use mlua::{Function, Lua, Table, Value};

use super::bytecode::Code;
use super::mesh::LuaMesh;
use super::spectrum::LuaSpectrum;
use crate::geometry::Mesh;
use crate::program::sweep::{Digest, Hasher};

/// What functions say or read beyond their arguments: a function that mentions one of them may not
/// return the same again.
const TELLING: [&str; 13] = [
    "_G",
    "clock",
    "collectgarbage",
    "coroutine",
    "date",
    "load",
    "print",
    "random",
    "randomseed",
    "require",
    "time",
    "warn",
    "write",
];

/// Values that one content may hold; more take longer to look at than to make.
const MOST_VALUES: usize = 200_000;

/// Digest of values, and the meshes whose addresses are in it.
#[derive(Debug)]
pub(super) struct Content {
    pub key: Digest,
    /// As long as these live, no other mesh has their address.
    pub meshes: Vec<Arc<Mesh>>,
}

/// Functions and tables that every state has, by their addresses.
#[derive(Debug, Default)]
pub(super) struct Known {
    names: HashMap<usize, String>,
    /// The library's tables, to which scripts may add.
    libraries: HashSet<usize>,
}

impl Known {
    /// Notes the standard library and the module.
    pub fn of(lua: &Lua, module: &Table) -> mlua::Result<Self> {
        let mut known = Self::default();
        known.add("lampyris", module, true)?;
        known.add("", &lua.globals(), false)?;
        Ok(known)
    }

    /// Tables of the module are never changed; those of the library may be.
    fn add(&mut self, name: &str, table: &Table, is_module: bool) -> mlua::Result<()> {
        let pointer = address(table.to_pointer());
        if is_module {
            self.names.insert(pointer, name.to_owned());
        } else {
            self.libraries.insert(pointer);
        }
        table.for_each(|key: String, value: Value| {
            let name = format!("{name}.{key}");
            match value {
                Value::Function(function) => {
                    // One that has two names is known by the first, in whatever order they come.
                    let known = self.names.entry(address(function.to_pointer()));
                    let known = known.or_insert_with(|| name.clone());
                    if name < *known {
                        *known = name;
                    }
                }
                Value::Table(inner) if key != "_G" => self.add(&name, &inner, is_module)?,
                _ => {}
            }
            Ok(())
        })
    }
}

fn address(pointer: *const c_void) -> usize {
    pointer as usize
}

impl Content {
    /// `None` for what has no content of its own, or more than can be looked at.
    pub fn of<'a>(
        lua: &Lua,
        name: &str,
        values: impl IntoIterator<Item = &'a Value>,
    ) -> Option<Self> {
        let known = lua.app_data_ref::<Known>()?;
        let mut reader = ContentReader {
            lua,
            known: &known,
            hasher: Hasher::new(),
            seen: HashMap::new(),
            values: 0,
            meshes: Vec::new(),
        };
        reader.hasher.text(name);
        for value in values {
            reader.add(value)?;
        }
        Some(Self { key: reader.hasher.finish(), meshes: reader.meshes })
    }
}

struct ContentReader<'a> {
    lua: &'a Lua,
    known: &'a Known,
    hasher: Hasher,
    /// Tables and functions so far, by address, in the order in which they were met.
    seen: HashMap<usize, usize>,
    values: usize,
    meshes: Vec<Arc<Mesh>>,
}

impl ContentReader<'_> {
    fn add(&mut self, value: &Value) -> Option<()> {
        self.values += 1;
        if self.values > MOST_VALUES {
            return None;
        }
        match value {
            Value::Nil => self.hasher.text("nil"),
            Value::Boolean(value) => self.hasher.text(if *value { "true" } else { "false" }),
            Value::Integer(value) => {
                self.hasher.text("integer");
                self.hasher.bytes(&value.to_le_bytes());
            }
            Value::Number(value) => {
                self.hasher.text("number");
                self.hasher.bytes(&value.to_bits().to_le_bytes());
            }
            Value::String(text) => {
                self.hasher.text("string");
                self.add_bytes(&text.as_bytes());
            }
            Value::Table(table) => self.add_table(table)?,
            Value::Function(function) => self.add_function(function)?,
            Value::UserData(data) => {
                if let Ok(mesh) = data.borrow::<LuaMesh>() {
                    self.hasher.text("mesh");
                    self.hasher.bytes(&(Arc::as_ptr(&mesh.0.mesh) as usize).to_le_bytes());
                    self.meshes.push(Arc::clone(&mesh.0.mesh));
                } else {
                    let spectrum = data.borrow::<LuaSpectrum>().ok()?;
                    self.hasher.text(&format!("{:?}", spectrum.0));
                }
            }
            _ => return None,
        }
        Some(())
    }

    fn add_bytes(&mut self, bytes: &[u8]) {
        self.hasher.bytes(&(bytes.len() as u64).to_le_bytes());
        self.hasher.bytes(bytes);
    }

    /// Says what `pointer` is if that is known: a name, or a value that was met before.
    fn is_met(&mut self, pointer: *const c_void) -> bool {
        let pointer = address(pointer);
        if let Some(name) = self.known.names.get(&pointer) {
            self.hasher.text(name);
            return true;
        }
        let next = self.seen.len();
        match self.seen.get(&pointer) {
            Some(at) => self.hasher.text(&format!("met {at}")),
            None => {
                self.seen.insert(pointer, next);
                return false;
            }
        }
        true
    }

    fn is_known(&self, function: &Function) -> bool {
        self.known.names.contains_key(&address(function.to_pointer()))
    }

    fn add_table(&mut self, table: &Table) -> Option<()> {
        if self.is_met(table.to_pointer()) {
            return Some(());
        }
        self.hasher.text("table");
        if let Some(meta) = table.metatable() {
            self.add_table(&meta)?;
        }
        let mut pairs = Vec::new();
        // `pairs` does not look at metatables.
        for pair in table.pairs::<Value, Value>() {
            let (key, value) = pair.ok()?;
            pairs.push((sortable(&key)?, key, value));
        }
        pairs.sort_by(|a, b| a.0.cmp(&b.0));
        self.hasher.bytes(&(pairs.len() as u64).to_le_bytes());
        let is_library = self.known.libraries.contains(&address(table.to_pointer()));
        for (_, key, value) in &pairs {
            self.add(key)?;
            match value {
                // Being there, it says nothing: who uses it mentions its name.
                Value::Function(function) if is_library && self.is_known(function) => {
                    self.is_met(function.to_pointer());
                }
                value => self.add(value)?,
            }
        }
        Some(())
    }

    /// Its code, and all that it reaches: upvalues, and the globals that it names.
    fn add_function(&mut self, function: &Function) -> Option<()> {
        if let Some(name) = self.known.names.get(&address(function.to_pointer())) {
            let last = name.rsplit('.').next().unwrap_or_default();
            if TELLING.contains(&last) {
                return None;
            }
        }
        if self.is_met(function.to_pointer()) {
            return Some(());
        }
        if function.info().what == "C" {
            return None;
        }
        let code = Code::of(function)?;
        if code.texts.iter().any(|text| TELLING.iter().any(|name| name.as_bytes() == text)) {
            return None;
        }
        self.hasher.text("function");
        self.add_bytes(&code.bytes);
        let globals = self.lua.globals();
        for at in 1..=function.info().num_upvalues {
            match upvalue(self.lua, function, at)? {
                Value::Table(table) if table == globals => self.add_globals(&table, &code)?,
                upvalue => self.add(&upvalue)?,
            }
        }
        Some(())
    }

    fn add_globals(&mut self, globals: &Table, code: &Code) -> Option<()> {
        for name in &code.texts {
            let name = self.lua.create_string(name).ok()?;
            let value: Value = globals.raw_get(name).ok()?;
            self.add(&value)?;
        }
        Some(())
    }
}

/// Keys in an order that does not depend on addresses.
fn sortable(key: &Value) -> Option<(u8, u64, Vec<u8>)> {
    match key {
        Value::Boolean(value) => Some((0, u64::from(*value), Vec::new())),
        Value::Integer(value) => Some((1, *value as u64, Vec::new())),
        Value::Number(value) => Some((2, value.to_bits(), Vec::new())),
        Value::String(text) => Some((3, 0, text.as_bytes().to_vec())),
        _ => None,
    }
}

/// The value of an upvalue, counted from 1.
fn upvalue(lua: &Lua, function: &Function, at: u8) -> Option<Value> {
    // SAFETY: the function is the stack's only value; lua_getupvalue pushes one more, for which
    // there is room, or none, and raises no errors.
    let found: mlua::Result<(Function, Value)> = unsafe {
        lua.exec_raw(function, |state| {
            mlua::ffi::lua_getupvalue(state, 1, at.into());
        })
    };
    Some(found.ok()?.1)
}
