//! A Lua state that cannot reach the system.

use std::path::PathBuf;

use mlua::chunk::ChunkMode;
use mlua::{HookTriggers, Lua, LuaOptions, LuaString, MultiValue, StdLib, Table, Value, VmState};

use super::fault;
use super::host::{self, Host};
use crate::error::Error;
use crate::input;

/// Names that stay in `os` and `io`; the rest runs programs or opens files.
const OS_KEPT: [&str; 4] = ["clock", "date", "difftime", "time"];
const IO_KEPT: [&str; 1] = ["write"];
/// Globals that read files.
const GLOBALS_REMOVED: [&str; 2] = ["dofile", "loadfile"];

/// Instructions between two looks for Ctrl-C: far below what a person notices, far above what the
/// look costs.
const INTERRUPT_INTERVAL: u32 = 10_000;

/// A state with the harmless part of the standard library.
pub(super) fn new_state() -> mlua::Result<Lua> {
    let libraries = StdLib::COROUTINE
        | StdLib::TABLE
        | StdLib::STRING
        | StdLib::UTF8
        | StdLib::MATH
        | StdLib::OS
        | StdLib::IO;
    // A panic is a fault of ours: no script's pcall may go on after it.
    let lua = Lua::new_with(libraries, LuaOptions::new().catch_rust_panics(false))?;
    let globals = lua.globals();
    keep_only(&globals.get("os")?, &OS_KEPT)?;
    keep_only(&globals.get("io")?, &IO_KEPT)?;
    for name in GLOBALS_REMOVED {
        globals.set(name, Value::Nil)?;
    }
    globals.get::<Table>("string")?.set("dump", Value::Nil)?;
    globals.set("load", lua.create_function(load_text)?)?;
    // Lua seeds itself from the clock and an address: the same script would draw other numbers.
    globals.get::<Table>("math")?.get::<mlua::Function>("randomseed")?.call::<()>(0)?;
    replace_pcall(&lua)?;
    replace_setmetatable(&lua)?;
    replace_output(&lua)?;
    Ok(lua)
}

/// `setmetatable` without finalizers.
///
/// Lua runs those that are left when the state closes. By then the binding library has let go of
/// what its callbacks use, and a finalizer that calls one reads freed memory (mlua 0.12, Lua 5.4).
/// Lua looks for `__gc` only here, so that it never runs one that is not there at this moment.
fn replace_setmetatable(lua: &Lua) -> mlua::Result<()> {
    const WRAPPER: &str = r#"
        local raw, rawget, rawset, type, pcall, error, warn = ...
        return function(object, meta)
            local finalizer = type(meta) == "table" and rawget(meta, "__gc")
            if not finalizer then return raw(object, meta) end
            warn()
            rawset(meta, "__gc", nil)
            local ok, problem = pcall(raw, object, meta)
            rawset(meta, "__gc", finalizer)
            if not ok then error(problem, 2) end
            return object
        end
    "#;
    let warn = lua.create_function(|lua, ()| {
        host::of(lua)?.warn("setmetatable: finalizers (__gc) are never run; <close> is");
        Ok(())
    })?;
    let globals = lua.globals();
    let names = ["setmetatable", "rawget", "rawset", "type", "pcall", "error"];
    let mut raw = names
        .map(|name| globals.get::<Value>(name))
        .into_iter()
        .collect::<mlua::Result<Vec<_>>>()?;
    raw.push(Value::Function(warn));
    let chunk = lua.load(WRAPPER).set_name("=__setmetatable");
    globals.set("setmetatable", chunk.call::<Value>(MultiValue::from_vec(raw))?)
}

/// Makes `io.write`, and returns `print`, from what puts a text out and Lua's own functions.
const OUTPUT: &str = r#"
    local put, io, tostring, pack, concat, type, integer, format, error = ...
    local out = setmetatable({}, { __metatable = false, __name = "FILE*" })
    function out.write(_, ...)
        local parts = pack(...)
        for at = 1, parts.n do
            local part = parts[at]
            if type(part) == "number" then
                parts[at] = format(integer(part) == "integer" and "%d" or "%.14g", part)
            elseif type(part) ~= "string" then
                error("bad argument #" .. at .. " to 'write' (string expected, got " .. type(part) .. ")", 2)
            end
        end
        put(concat(parts))
        return out
    end
    io.write = function(...) return out.write(out, ...) end
    io.stdout = nil
    return function(...)
        local parts = pack(...)
        for at = 1, parts.n do parts[at] = tostring(parts[at]) end
        put(concat(parts, "\t") .. "\n")
    end
"#;

/// `print` and `io.write` whose errors are errors: a full disk or a closed pipe loses nothing
/// without a word.
fn replace_output(lua: &Lua) -> mlua::Result<()> {
    let globals = lua.globals();
    let put = fault::function(lua, |lua, arguments| {
        let Some(Value::String(text)) = arguments.into_iter().next() else {
            return Ok(());
        };
        Ok(host::of(lua)?.print(&text.as_bytes())?)
    })?;
    let (table, string): (Table, Table) = (globals.get("table")?, globals.get("string")?);
    let raw = (
        put,
        globals.get::<Value>("io")?,
        globals.get::<Value>("tostring")?,
        table.get::<Value>("pack")?,
        table.get::<Value>("concat")?,
        globals.get::<Value>("type")?,
        globals.get::<Table>("math")?.get::<Value>("type")?,
        string.get::<Value>("format")?,
        globals.get::<Value>("error")?,
    );
    let print: Value = lua.load(OUTPUT).set_name("=__print").call(raw)?;
    globals.set("print", print)
}

/// `pcall` and `xpcall` that give scripts a plain message, and let Ctrl-C through.
fn replace_pcall(lua: &Lua) -> mlua::Result<()> {
    const WRAPPERS: &str = r#"
        local raw_pcall, raw_xpcall, caught, plain = ...
        local function checked(ok, ...)
            if ok then return true, ... end
            return false, caught((...))
        end
        local function finished(ok, ...)
            if not ok then caught(nil) end
            return ok, ...
        end
        local function pcall(f, ...) return checked(raw_pcall(f, ...)) end
        local function xpcall(f, handler, ...)
            -- An error of the handler's would be swallowed, so that Ctrl-C is looked for after it.
            return finished(raw_xpcall(f, function(e) return handler(plain(e)) end, ...))
        end
        return pcall, xpcall
    "#;
    let globals = lua.globals();
    let caught = lua.create_function(fault::caught)?;
    let plain = lua.create_function(fault::plain)?;
    let raw_xpcall: Value = globals.get("xpcall")?;
    lua.set_named_registry_value(fault::XPCALL, &raw_xpcall)?;
    let raw = (globals.get::<Value>("pcall")?, raw_xpcall, caught, plain);
    let (pcall, xpcall): (Value, Value) = lua.load(WRAPPERS).set_name("=__pcall").call(raw)?;
    globals.set("pcall", pcall)?;
    globals.set("xpcall", xpcall)
}

fn keep_only(table: &Table, kept: &[&str]) -> mlua::Result<()> {
    let mut removed = Vec::new();
    for pair in table.pairs::<String, Value>() {
        let (name, _) = pair?;
        if !kept.contains(&name.as_str()) {
            removed.push(name);
        }
    }
    removed.into_iter().try_for_each(|name| table.set(name, Value::Nil))
}

/// `load` of text only: a binary chunk could break out of the virtual machine.
fn load_text(lua: &Lua, arguments: MultiValue) -> mlua::Result<MultiValue> {
    let mut arguments = arguments.into_iter();
    let chunk = arguments.next().unwrap_or(Value::Nil);
    let name = arguments.next().and_then(|v| v.as_string().map(|s| s.to_string_lossy()));
    let environment = arguments.nth(1);
    let source = chunk_text(lua, chunk)?;
    let mut chunk = lua.load(source).set_mode(ChunkMode::Text);
    chunk = chunk.set_name(name.unwrap_or_else(|| "=(load)".to_owned()));
    if let Some(Value::Table(environment)) = environment {
        chunk = chunk.set_environment(environment);
    }
    let results = match chunk.into_function() {
        Ok(function) => vec![Value::Function(function)],
        Err(error) => {
            let message = error.to_string();
            vec![Value::Nil, Value::String(lua.create_string(message)?)]
        }
    };
    Ok(MultiValue::from_vec(results))
}

/// A string, or the pieces that a function returns until it returns nothing.
///
/// Errors: pieces without end, beyond the memory that Lua may use.
fn chunk_text(lua: &Lua, chunk: Value) -> mlua::Result<Vec<u8>> {
    match chunk {
        Value::String(text) => Ok(text.as_bytes().to_vec()),
        Value::Function(reader) => {
            let mut text = Vec::new();
            while let Some(piece) = reader.call::<Option<LuaString>>(())? {
                if piece.as_bytes().is_empty() {
                    break;
                }
                host::reserve(lua, "load", piece.as_bytes().len(), "a chunk that ends")?;
                text.extend_from_slice(&piece.as_bytes());
            }
            Ok(text)
        }
        other => Err(mlua::Error::runtime(format!(
            "load: chunk is a {}, expected a string or a function",
            other.type_name()
        ))),
    }
}

/// Limits the memory, ends the script at Ctrl-C, and hands it its arguments.
pub(super) fn limit(lua: &Lua, host: &Host) -> mlua::Result<()> {
    if let Some(bytes) = host.settings.max_memory {
        lua.set_memory_limit(bytes)?;
    }
    let interrupted = host.settings.interrupted.clone();
    let triggers = HookTriggers::new().every_nth_instruction(INTERRUPT_INTERVAL);
    lua.set_global_hook(triggers, move |_, _| {
        if interrupted.load(std::sync::atomic::Ordering::Relaxed) {
            return Err(Error::Interrupted.into());
        }
        Ok(VmState::Continue)
    })?;
    let arguments = lua.create_sequence_from(host.settings.arguments.iter().map(String::as_str))?;
    arguments.set(0, host.script.display().to_string())?;
    lua.globals().set("arg", arguments)
}

/// `require`: the module `lampyris`, and Lua files next to the script or in a folder of `--read`.
pub(super) fn install_require(lua: &Lua, module: Table) -> mlua::Result<()> {
    let loaded = lua.create_table()?;
    loaded.set("lampyris", module)?;
    let require = fault::function(lua, move |lua, arguments| {
        let name = match arguments.into_iter().next() {
            Some(Value::String(name)) => name.to_string_lossy(),
            other => {
                return Err(Error::WrongType {
                    object: "require".to_owned(),
                    what: "name".to_owned(),
                    found: other.map_or("nil", |v| v.type_name()).to_owned(),
                    expected: "a string".to_owned(),
                }
                .into());
            }
        };
        let known: Value = loaded.get(name.as_str())?;
        if !known.is_nil() {
            return Ok(known);
        }
        let value = load_module(lua, &name)?;
        let value = if value.is_nil() { Value::Boolean(true) } else { value };
        loaded.set(name, &value)?;
        Ok(value)
    })?;
    lua.globals().set("require", require)
}

/// Beside the script, else in the first folder of `--read` that has it.
fn module_path(host: &Host, file: &str) -> PathBuf {
    let beside = host.script_folder().join(file);
    let others = host.settings.read.iter().map(|folder| folder.join(file));
    std::iter::once(beside.clone()).chain(others).find(|path| path.exists()).unwrap_or(beside)
}

fn load_module(lua: &Lua, name: &str) -> mlua::Result<Value> {
    let plain = name.split('.').all(|part| {
        !part.is_empty() && part.chars().all(|c| c.is_alphanumeric() || c == '_' || c == '-')
    });
    if !plain {
        let allowed = "names of letters, digits, _ and -, joined by dots";
        return Err(Error::out_of_range("require", "name", format!("\"{name}\""), allowed).into());
    }
    let host = host::of(lua)?;
    let file = format!("{}.lua", name.replace('.', "/"));
    let path = module_path(&host, &file);
    host.check_readable(name, &path)?;
    if path.exists() {
        host.note_input(&file, &path)?;
    }
    let source = input::bytes(&path)?;
    let chunk = lua.load(source).set_name(format!("@{}", path.display()));
    chunk.set_mode(ChunkMode::Text).call(name)
}
