//! The Lua side: state, sandbox, option tables, one binding file a topic.
//!
//! Bindings turn Lua values into the plain types of the other modules, call one function, and hand
//! back an immutable handle. They are the only place that knows Lua.
//!
//! To add an option: write its row into the record of the binding (`options! { … }`; `record` shows
//! what comes from it) and use the field. Its kind (`kinds`) reads it, with the message that a
//! wrong value gets. To add a result: write its row into the list in `program::results`. Then
//! `MAKE_REF=1 cargo test --lib annotations` writes the annotations and `docs/options.md` anew. To
//! add a method or function: write it into its handle's or table's list (`members`), which also
//! names it in messages, and its annotation by hand: a test compares the two.

mod annotations;
mod bytecode;
mod cell;
mod content;
mod far_field;
mod fault;
mod host;
mod kept;
mod kinds;
mod members;
mod optical;
mod options;
mod record;
mod repl;
mod sandbox;
mod starter;

mod camera;
mod display;
mod display_fit;
mod emitter;
mod environment;
mod figure;
mod file;
mod grid_check;
mod image;
mod light;
mod lobe_fit;
mod look;
mod material;
mod measured;
mod mesh;
mod paths;
mod photometry;
mod quality;
mod scene;
mod shown;
mod spectrum;
mod study;
mod sweep;
mod uncertainty;
mod view;
mod views;

use std::io::Write;
use std::path::Path;

use mlua::{Lua, Table};

pub use annotations::describe_options;
pub use fault::ScriptFault;
pub use host::{Host, Reads, Settings};
pub use kept::Kept;
pub use repl::repl;
pub use starter::write_starter;

/// Runs a script file.
///
/// Errors: [`ScriptFault`], one message for the script's user.
pub fn run(script: &Path, settings: Settings) -> Result<(), ScriptFault> {
    let lua = state(script, settings)?;
    let host = host::of(&lua)?;
    host.note_script();
    let source = std::fs::read(script).map_err(|e| ScriptFault::unreadable(script, e))?;
    let chunk_name = format!("@{}", script.display());
    let chunk = lua.load(source).set_name(chunk_name).set_mode(mlua::chunk::ChunkMode::Text);
    let done = chunk.into_function().and_then(|chunk| fault::call(&lua, chunk));
    host.print_warnings();
    if let Some(kept) = &host.settings.kept {
        kept.end_run(host.settings.in_use.all());
    }
    let printed = std::io::stdout().flush();
    done.map_err(|error| fault::from_lua(error, &host))?;
    printed.map_err(|e| ScriptFault::unreadable(Path::new("standard output"), e))
}

/// A sandboxed state with the module `lampyris` ready to be required.
fn state(script: &Path, settings: Settings) -> Result<Lua, ScriptFault> {
    let lua = sandbox::new_state()?;
    let host = Host::new(script, settings);
    sandbox::limit(&lua, &host)?;
    lua.set_app_data(host);
    let module = module(&lua)?;
    lua.set_app_data(content::Known::of(&lua, &module)?);
    sandbox::install_require(&lua, module)?;
    Ok(lua)
}

/// The table that `require "lampyris"` returns.
fn module(lua: &Lua) -> mlua::Result<Table> {
    let module = lua.create_table()?;
    module.set("version", env!("CARGO_PKG_VERSION"))?;
    spectrum::register(lua, &module)?;
    mesh::register(lua, &module)?;
    material::register(lua, &module)?;
    optical::register(lua, &module)?;
    light::register(lua, &module)?;
    emitter::register(lua, &module)?;
    view::register(lua, &module)?;
    environment::register(lua, &module)?;
    scene::register(lua, &module)?;
    camera::register(lua, &module)?;
    display::register(lua, &module)?;
    image::register(lua, &module)?;
    sweep::register(lua, &module)?;
    study::register(lua, &module)?;
    photometry::register(lua, &module)?;
    lobe_fit::register(lua, &module)?;
    figure::register(lua, &module)?;
    file::register(lua, &module)?;
    kept::register(lua, &module)?;
    fault::refuse_unknown_names(lua, &module, "lampyris")?;
    Ok(module)
}
