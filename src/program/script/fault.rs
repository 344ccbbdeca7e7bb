//! From an error anywhere to one message with the script's line.

use std::path::Path;

use mlua::{Function, IntoLuaMulti, Lua, MultiValue, Table, Value};
use serde_json::json;

use super::host::Host;
use super::shown::shown;
use crate::error::{Error, Hint};
use crate::program::progress::Verbosity;

/// What ends a script, as its user reads it.
#[derive(Debug, thiserror::Error)]
#[error("{message}")]
pub struct ScriptFault {
    /// With the script's line in front, where it has one.
    pub message: String,
    /// Ctrl-C, not a mistake.
    pub interrupted: bool,
}

impl ScriptFault {
    /// A script that Ctrl-C has ended.
    pub fn interrupted() -> Self {
        Self { message: Error::Interrupted.to_string(), interrupted: true }
    }

    /// The message as standard error's reader wants it.
    pub fn report(&self, verbosity: Verbosity) -> String {
        match verbosity {
            Verbosity::Json => {
                let Self { message, interrupted } = self;
                json!({ "event": "error", "message": message, "interrupted": interrupted })
                    .to_string()
            }
            Verbosity::Quiet | Verbosity::Bar => self.message.clone(),
        }
    }
}

impl From<Error> for ScriptFault {
    fn from(error: Error) -> Self {
        Self { message: error.to_string(), interrupted: matches!(error, Error::Interrupted) }
    }
}

impl From<mlua::Error> for ScriptFault {
    fn from(error: mlua::Error) -> Self {
        Self { message: message(&error), interrupted: false }
    }
}

impl ScriptFault {
    pub(super) fn unreadable(script: &Path, error: std::io::Error) -> Self {
        Self { message: Error::io(script, error).to_string(), interrupted: false }
    }
}

/// An error's message with the line of the script that caused it.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
struct Located(String);

impl From<Error> for mlua::Error {
    fn from(error: Error) -> Self {
        mlua::Error::external(error)
    }
}

/// Adds the innermost line of the script, while its stack still stands.
pub(super) fn located(lua: &Lua, error: mlua::Error) -> mlua::Error {
    let mlua::Error::ExternalError(cause) = &error else {
        return error;
    };
    let Some(cause) = cause.downcast_ref::<Error>() else {
        return error;
    };
    let message = match script_line(lua) {
        Some(place) => format!("{place}: {cause}"),
        None => cause.to_string(),
    };
    mlua::Error::external(Located(message))
}

/// `file:line` of the first frame that has one.
fn script_line(lua: &Lua) -> Option<String> {
    (0..).map_while(|level| lua.inspect_stack(level, frame_line)).flatten().next()
}

fn frame_line(frame: &mlua::debug::Debug) -> Option<String> {
    let line = frame.current_line()?;
    let file = frame.source().short_src?;
    // Lua code that is not the script's: the binding library's __index, our pcall.
    (!file.starts_with("__")).then(|| format!("{file}:{line}"))
}

/// The message of an error that left the script, and the lines that led to it.
pub(super) fn from_lua(error: mlua::Error, host: &Host) -> ScriptFault {
    let message = message(&error);
    let trace = traceback(&error).filter(|_| !host.is_interrupted());
    let callers = trace.map_or_else(Vec::new, |trace| callers(&message, &trace));
    let callers = callers.iter().map(|place| format!("\n  from {place}"));
    let message = message + &callers.collect::<String>();
    ScriptFault { interrupted: host.is_interrupted(), message }
}

/// Calls a script's chunk. An error value that is no text becomes one, with the lines that led to it.
pub(super) fn call(lua: &Lua, chunk: Function) -> mlua::Result<()> {
    let handler = lua.create_function(|lua, error: Value| {
        if error.is_error() {
            return Ok(error);
        }
        let text = match (error.is_string(), script_line(lua)) {
            (false, Some(place)) => format!("{place}: {}", shown(&error)), // as Lua does for texts
            _ => shown(&error),
        };
        let trace = lua.traceback(Some(&text), 1)?.to_string_lossy();
        Ok(Value::Error(Box::new(mlua::Error::RuntimeError(trace))))
    })?;
    let xpcall: Function = lua.named_registry_value(XPCALL)?;
    match xpcall.call::<(bool, Value)>((chunk, handler))? {
        (true, _) => Ok(()),
        (false, Value::Error(error)) => Err(*error),
        // Lua asks no handler where memory is short.
        (false, Value::String(text)) if text.as_bytes() == b"not enough memory".as_slice() => {
            Err(mlua::Error::MemoryError(text.to_string_lossy()))
        }
        (false, other) => Err(mlua::Error::RuntimeError(shown(&other))),
    }
}

/// Lua's own, by this name in the registry.
pub(super) const XPCALL: &str = "xpcall";

/// Callers beyond these are not told: a function that calls itself has many.
const MOST_CALLERS: usize = 8;

/// The stack where the error came from.
fn traceback(error: &mlua::Error) -> Option<String> {
    match error {
        mlua::Error::CallbackError { cause, traceback: outer } => {
            traceback(cause).or_else(|| Some(outer.clone()))
        }
        mlua::Error::WithContext { cause, .. } => traceback(cause),
        mlua::Error::RuntimeError(text) => {
            text.split_once(TRACE).map(|(_, trace)| trace.to_owned())
        }
        _ => None,
    }
}

const TRACE: &str = "\nstack traceback:";

/// The places beyond the one that the message begins with.
fn callers(message: &str, traceback: &str) -> Vec<String> {
    let mut places: Vec<String> = traced_lines(traceback).collect();
    places.dedup(); // functions that are called on the line where they stand
    let begins = |place: &String| message.starts_with(&format!("{place}:"));
    let first = places.iter().position(begins).map_or(0, |at| at + 1);
    places.into_iter().skip(first).take(MOST_CALLERS).collect()
}

/// Without the stack traceback.
pub(super) fn message(error: &mlua::Error) -> String {
    match error {
        mlua::Error::CallbackError { cause, traceback } => match method_without_self(cause) {
            Some(problem) => match traced_lines(traceback).next() {
                Some(place) => format!("{place}: {problem}"),
                None => problem,
            },
            None => message(cause),
        },
        mlua::Error::RuntimeError(text) => without_traceback(text),
        mlua::Error::SyntaxError { message, .. } => message.clone(),
        mlua::Error::ExternalError(cause) => cause.to_string(),
        mlua::Error::WithContext { cause, .. } => message(cause),
        mlua::Error::MemoryError(_) => "script: out of memory".to_owned(),
        other => without_traceback(&other.to_string()),
    }
}

/// `scene.render(view)`: the binding library refuses it before any code of ours runs.
fn method_without_self(error: &mlua::Error) -> Option<String> {
    match error {
        mlua::Error::BadArgument { to: Some(method), name: Some(name), .. } if name == "self" => {
            let method = method.rsplit('.').next().unwrap_or(method);
            Some(format!("{method}: is a method, to be called with a colon: object:{method}(…)"))
        }
        _ => None,
    }
}

/// `file:line` of the lines of a stack traceback that have one.
fn traced_lines(traceback: &str) -> impl Iterator<Item = String> {
    let frames = traceback.lines().filter_map(|line| line.trim().split_once(": in "));
    let places = frames.map(|(place, _)| place);
    places
        .filter(|place| !place.starts_with('[') && !place.starts_with("__") && place.contains(':'))
        .map(str::to_owned)
}

fn without_traceback(text: &str) -> String {
    text.split(TRACE).next().unwrap_or(text).to_owned()
}

/// What `pcall` hands to the script: the message instead of the error's own object. An interrupt
/// is raised again, so that no script survives Ctrl-C.
pub(super) fn caught(lua: &Lua, error: Value) -> mlua::Result<Value> {
    if super::host::of(lua)?.is_interrupted() {
        return Err(Error::Interrupted.into());
    }
    plain(lua, error)
}

/// The message in the place of an error's own object.
pub(super) fn plain(lua: &Lua, error: Value) -> mlua::Result<Value> {
    match error {
        Value::Error(error) => Ok(Value::String(lua.create_string(message(&error))?)),
        other => Ok(other),
    }
}

/// A Lua function whose errors carry the script's line.
pub(super) fn function<R: IntoLuaMulti>(
    lua: &Lua,
    f: impl Fn(&Lua, MultiValue) -> mlua::Result<R> + Send + Sync + 'static,
) -> mlua::Result<Function> {
    lua.create_function(move |lua, arguments: MultiValue| {
        f(lua, arguments).map_err(|error| located(lua, error))
    })
}

/// Makes reading a name that a handle does not have an error with the nearest one.
pub(super) fn refuse_unknown_fields<T: 'static>(
    methods: &mut impl mlua::UserDataMethods<T>,
    object: &'static str,
    names: impl AsRef<[&'static str]> + Send + 'static,
) {
    methods.add_meta_method(mlua::MetaMethod::Index, move |lua, _, key: Value| {
        let error = unknown_key(object, &key_text(&key), names.as_ref());
        Err::<Value, _>(located(lua, error.into()))
    });
}

/// The same for a table of functions, with the names that it has now.
pub(super) fn refuse_unknown_names(lua: &Lua, table: &Table, object: &str) -> mlua::Result<()> {
    let mut names = Vec::new();
    for pair in table.pairs::<String, Value>() {
        names.push(pair?.0);
    }
    let object = object.to_owned();
    let index = lua.create_function(move |lua, (_, key): (Value, Value)| {
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let error = unknown_key(&object, &key_text(&key), &names);
        Err::<Value, _>(located(lua, error.into()))
    })?;
    let meta = lua.create_table()?;
    meta.set("__index", index)?;
    meta.set("__metatable", false)?;
    table.set_metatable(Some(meta))
}

pub(super) fn key_text(key: &Value) -> String {
    match key {
        Value::String(s) => s.to_string_lossy(),
        other => other.to_string().unwrap_or_else(|_| other.type_name().to_owned()),
    }
}

/// The error for a name that is not among `known`.
pub(super) fn unknown_key(object: &str, key: &str, known: &[&str]) -> Error {
    let mut sorted = known.to_vec();
    sorted.sort_unstable();
    Error::UnknownKey {
        object: object.to_owned(),
        key: key.to_owned(),
        hint: nearest(key, known),
        known: sorted.join(", "),
    }
}

/// The known name that a user most likely meant.
pub(super) fn nearest(name: &str, known: &[&str]) -> Hint {
    /// Below this, names have so little in common that a hint would mislead.
    const ALIKE: f64 = 0.7;
    let score =
        |candidate: &str| strsim::jaro_winkler(&name.to_lowercase(), &candidate.to_lowercase());
    let best = known.iter().map(|&k| (score(k), k)).max_by(|a, b| a.0.total_cmp(&b.0));
    Hint(best.filter(|(score, _)| *score >= ALIKE).map(|(_, name)| name.to_owned()))
}
