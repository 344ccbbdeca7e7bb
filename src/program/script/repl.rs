//! The same interface at a prompt.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use mlua::{Lua, MultiValue, Table, Value};
use rustyline::completion::Completer;
use rustyline::error::ReadlineError;
use rustyline::highlight::Highlighter;
use rustyline::hint::Hinter;
use rustyline::history::FileHistory;
use rustyline::validate::Validator;
use rustyline::{Config, Context, Editor, Helper};

use super::fault::{self, ScriptFault};
use super::shown::shown;
use super::{Settings, host, state};

const PROMPT: &str = "> ";
const CONTINUED: &str = ">> ";

/// Reads lines until end of file, and prints what they give. Faults are printed, too, and end
/// nothing.
///
/// Errors: a terminal that cannot be read.
pub fn repl(settings: Settings) -> Result<(), ScriptFault> {
    let lua = state(Path::new("repl"), settings)?;
    let module: Table = lua.load("return require 'lampyris'").call(())?;
    lua.globals().set("lampyris", module)?;
    let mut editor = editor(&lua).map_err(unreadable)?;
    println!("lampyris {}, Lua 5.4; Ctrl-D ends", env!("CARGO_PKG_VERSION"));
    loop {
        match read_chunk(&lua, &mut editor) {
            Ok(Some(chunk)) => evaluate(&lua, &chunk)?,
            Ok(None) => break,
            Err(error) => return Err(unreadable(error)),
        }
    }
    if let Some(path) = history_path() {
        // A history that cannot be kept is no reason to fail.
        let _ = editor.save_history(&path);
    }
    Ok(())
}

fn unreadable(error: ReadlineError) -> ScriptFault {
    ScriptFault { message: format!("repl: {error}"), interrupted: false }
}

fn editor(lua: &Lua) -> rustyline::Result<Editor<Completions, FileHistory>> {
    let mut editor = Editor::with_config(Config::builder().auto_add_history(true).build())?;
    editor.set_helper(Some(Completions(lua.clone())));
    if let Some(path) = history_path() {
        let _ = editor.load_history(&path); // there is none at the first start
    }
    Ok(editor)
}

/// `~/.lampyris_history`.
fn history_path() -> Option<PathBuf> {
    std::env::home_dir().map(|home| home.join(".lampyris_history"))
}

/// Lines until they are a whole chunk; `None` at the end of the input.
fn read_chunk(
    lua: &Lua,
    editor: &mut Editor<Completions, FileHistory>,
) -> rustyline::Result<Option<String>> {
    let mut chunk = String::new();
    loop {
        let prompt = if chunk.is_empty() { PROMPT } else { CONTINUED };
        match editor.readline(prompt) {
            Ok(line) => {
                chunk.push_str(&line);
                if !is_incomplete(lua, &chunk) {
                    return Ok(Some(chunk));
                }
                chunk.push('\n');
            }
            // Ctrl-C takes back what was typed.
            Err(ReadlineError::Interrupted) => chunk.clear(),
            Err(ReadlineError::Eof) => return Ok(None),
            Err(error) => return Err(error),
        }
    }
}

fn is_incomplete(lua: &Lua, chunk: &str) -> bool {
    let kind = |error: &mlua::Error| match error {
        mlua::Error::SyntaxError { incomplete_input, .. } => *incomplete_input,
        _ => false,
    };
    let as_expression = lua.load(format!("return {chunk}")).into_function();
    let as_statement = lua.load(chunk).into_function();
    match (as_expression, as_statement) {
        (Err(expression), Err(statement)) => kind(&expression) || kind(&statement),
        _ => false,
    }
}

/// An expression's values are printed.
fn evaluate(lua: &Lua, chunk: &str) -> Result<(), ScriptFault> {
    let host = host::of(lua)?;
    let as_expression = lua.load(format!("return {chunk}")).set_name("=repl").into_function();
    let function = as_expression.or_else(|_| lua.load(chunk).set_name("=repl").into_function());
    match function.and_then(|function| function.call::<MultiValue>(())) {
        Ok(values) if values.is_empty() => {}
        Ok(values) => {
            let print: mlua::Function = lua.globals().get("print")?;
            let texts = values.iter().map(|value| match value {
                Value::Table(_) => Ok(Value::String(lua.create_string(shown(value))?)),
                other => Ok(other.clone()),
            });
            print.call::<()>(texts.collect::<mlua::Result<MultiValue>>()?)?;
        }
        Err(error) => eprintln!("{}", fault::from_lua(error, &host)),
    }
    // Ctrl-C has ended what ran; the prompt goes on.
    host.settings.interrupted.store(false, std::sync::atomic::Ordering::Relaxed);
    host.print_warnings();
    host.forget_warnings();
    Ok(())
}

/// Completes names of tables that can be reached from the globals.
struct Completions(Lua);

impl Completions {
    /// Where the last name begins, and the names that it may become.
    fn candidates(&self, line: &str) -> (usize, Vec<String>) {
        let of_name = |c: char| c.is_alphanumeric() || matches!(c, '_' | '.');
        let start = line.rfind(|c| !of_name(c)).map_or(0, |at| at + 1);
        // A character beyond ASCII may be longer than one byte.
        let start = (start..=line.len()).find(|&at| line.is_char_boundary(at)).unwrap_or(0);
        let mut path: Vec<&str> = line[start..].split('.').collect();
        let last = path.pop().unwrap_or_default();
        let mut table = self.0.globals();
        for name in path {
            match table.raw_get::<Value>(name) {
                Ok(Value::Table(inner)) => table = inner,
                _ => return (line.len(), Vec::new()),
            }
        }
        let names = table.pairs::<Value, Value>().filter_map(|pair| match pair {
            Ok((Value::String(name), _)) => Some(name.to_string_lossy()),
            _ => None,
        });
        let mut names: Vec<String> =
            names.filter(|name| name.starts_with(last) && name != "_G").collect();
        names.sort();
        (line.len() - last.len(), names)
    }
}

impl Completer for Completions {
    type Candidate = String;

    fn complete(
        &self,
        line: &str,
        position: usize,
        _: &Context<'_>,
    ) -> rustyline::Result<(usize, Vec<String>)> {
        Ok(self.candidates(&line[..position]))
    }
}

impl Hinter for Completions {
    type Hint = String;
}

impl Highlighter for Completions {
    fn highlight<'l>(&self, line: &'l str, _: usize) -> Cow<'l, str> {
        Cow::Borrowed(line)
    }
}

impl Validator for Completions {}
impl Helper for Completions {}

#[cfg(test)]
mod tests {
    use super::*;

    fn names() -> Completions {
        let lua = state(Path::new("repl"), Settings::default()).unwrap();
        let module: Table = lua.load("return require 'lampyris'").call(()).unwrap();
        lua.globals().set("lampyris", module).unwrap();
        Completions(lua)
    }

    #[test]
    fn names_complete_through_tables() {
        let names = names();
        assert_eq!(names.candidates("lampy"), (0, vec!["lampyris".to_owned()]));
        let (start, candidates) = names.candidates("x = lampyris.spectrum.bl");
        assert_eq!((start, candidates), (22, vec!["blackbody".to_owned()]));
        assert!(names.candidates("lampyris.mesh.").1.contains(&"load".to_owned()));
        assert!(names.candidates("nothing.here").1.is_empty());
        assert!(!names.candidates("").1.contains(&"_G".to_owned()));
        assert!(names.candidates("\"ü\" .. pri").1.contains(&"print".to_owned()));
    }

    #[test]
    fn chunks_go_on_until_they_are_whole() {
        let lua = names().0;
        for incomplete in ["for i = 1, 3 do", "x = {", "lampyris.view {", "return"] {
            let expected = incomplete != "return";
            assert_eq!(is_incomplete(&lua, incomplete), expected, "{incomplete}");
        }
        for whole in ["1 + 1", "x = 3", "print 'a'", "x = = 3", ")"] {
            assert!(!is_incomplete(&lua, whole), "{whole}");
        }
    }
}
