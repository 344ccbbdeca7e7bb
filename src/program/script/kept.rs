//! What one run of a script keeps for the next in the same process: meshes, rays, and whatever
//! `lampyris.keep` is asked for.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use mlua::{IntoLua, Lua, MultiValue, Table, Value};

use super::content::Content;
use super::fault;
use super::host::{self, Told};
use super::light::LuaLight;
use super::mesh::LuaMesh;
use super::options::{self, Arguments};
use super::spectrum::LuaSpectrum;
use crate::geometry::Mesh;
use crate::program::sweep::Digest;
use crate::scene::Prepared;

/// Runs that a result is kept for without being asked for.
const PATIENCE: u64 = 3;

/// Results by the content of what they were made from.
#[derive(Debug, Default)]
pub struct Kept(Mutex<KeptResults>);

#[derive(Debug, Default)]
struct KeptResults {
    run: u64,
    results: BTreeMap<Digest, KeptEntry>,
    scenes: Vec<Arc<Prepared>>,
}

#[derive(Debug)]
struct KeptEntry {
    things: Vec<Thing>,
    told: Told,
    /// So that their addresses, which are in the key, stay theirs.
    _meshes: Vec<Arc<Mesh>>,
    last_run: u64,
}

impl Kept {
    fn state(&self) -> MutexGuard<'_, KeptResults> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A run has ended: its scenes are kept for the next, and what was not asked for lately is not.
    pub(super) fn end_run(&self, scenes: Vec<Arc<Prepared>>) {
        let mut state = self.state();
        if !scenes.is_empty() {
            state.scenes = scenes;
        }
        state.run += 1;
        let oldest = state.run.saturating_sub(PATIENCE);
        state.results.retain(|_, entry| entry.last_run >= oldest);
    }

    fn find(&self, key: &Digest) -> Option<(Vec<Thing>, Told)> {
        let mut state = self.state();
        let run = state.run;
        let entry = state.results.get_mut(key)?;
        entry.last_run = run;
        Some((entry.things.clone(), entry.told.clone()))
    }

    fn put(&self, content: Content, things: Vec<Thing>, told: Told) {
        let mut state = self.state();
        let entry = KeptEntry { things, told, _meshes: content.meshes, last_run: state.run };
        state.results.insert(content.key, entry);
    }
}

/// A value that another Lua state can have, too.
#[derive(Debug, Clone)]
enum Thing {
    Mesh(LuaMesh),
    Light(LuaLight),
    Spectrum(LuaSpectrum),
    /// Nil, a truth value or a number.
    Plain(Value),
    Text(Vec<u8>),
    Table(Vec<(Thing, Thing)>),
}

impl Thing {
    fn of(value: &Value) -> Option<Self> {
        match value {
            Value::Nil | Value::Boolean(_) | Value::Integer(_) | Value::Number(_) => {
                Some(Self::Plain(value.clone()))
            }
            Value::String(text) => Some(Self::Text(text.as_bytes().to_vec())),
            Value::Table(table) => Self::of_table(table),
            Value::UserData(data) => {
                let mesh = data.borrow::<LuaMesh>().map(|mesh| Self::Mesh(mesh.clone()));
                let light = || data.borrow::<LuaLight>().map(|light| Self::Light(light.clone()));
                let spectrum = || data.borrow::<LuaSpectrum>().map(|s| Self::Spectrum(s.clone()));
                mesh.or_else(|_| light()).or_else(|_| spectrum()).ok()
            }
            _ => None,
        }
    }

    fn of_table(table: &Table) -> Option<Self> {
        if table.metatable().is_some() {
            return None;
        }
        let pair = |pair: mlua::Result<(Value, Value)>| {
            let (key, value) = pair.ok()?;
            Some((Self::of(&key)?, Self::of(&value)?))
        };
        table.pairs().map(pair).collect::<Option<_>>().map(Self::Table)
    }
}

impl IntoLua for Thing {
    fn into_lua(self, lua: &Lua) -> mlua::Result<Value> {
        match self {
            Self::Mesh(mesh) => mesh.into_lua(lua),
            Self::Light(light) => light.into_lua(lua),
            Self::Spectrum(spectrum) => spectrum.into_lua(lua),
            Self::Plain(value) => Ok(value),
            Self::Text(text) => lua.create_string(text)?.into_lua(lua),
            Self::Table(pairs) => lua.create_table_from(pairs)?.into_lua(lua),
        }
    }
}

pub(super) fn register(lua: &Lua, module: &Table) -> mlua::Result<()> {
    module.set("keep", fault::function(lua, keep)?)
}

/// `keep(f, …)`: f(…), or what it returned in an earlier run with the same content.
fn keep(lua: &Lua, arguments: MultiValue) -> mlua::Result<MultiValue> {
    let mut inputs = Arguments::new("keep", arguments.clone(), usize::MAX)?;
    let function = match inputs.value() {
        Value::Function(function) => function,
        other => {
            return Err(options::wrong_type("keep", "argument 1", &other, "a function").into());
        }
    };
    recall(lua, "keep", arguments, |mut arguments| {
        arguments.pop_front();
        function.call::<MultiValue>(arguments)
    })
}

/// What `make` returns, or what it returned when it was called by this name with the same.
pub(super) fn recall(
    lua: &Lua,
    name: &str,
    arguments: MultiValue,
    make: impl FnOnce(MultiValue) -> mlua::Result<MultiValue>,
) -> mlua::Result<MultiValue> {
    let host = host::of(lua)?;
    let Some(kept) = host.settings.kept.clone() else { return make(arguments) };
    let Some(content) = Content::of(lua, name, &arguments) else { return make(arguments) };
    if let Some((things, told)) = kept.find(&content.key)
        && told.still_holds()
    {
        host.tell_again(&told)?;
        return things.into_iter().map(|thing| thing.into_lua(lua)).collect();
    }
    let (results, told) = host.listened_to(|| make(arguments.clone()))?;
    let things = results.iter().map(Thing::of).collect::<Option<Vec<_>>>();
    let after = Content::of(lua, name, &arguments);
    if let (Some(things), Some(after)) = (things, after)
        && after.key == content.key
    // else the function has changed what it works on
    {
        kept.put(after, things, told);
    }
    Ok(results)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::scratch::ScratchFolder;
    use crate::program::script::{Settings, run};

    /// What is kept after these scripts have run one after the other.
    fn kept_after(scripts: &[&str]) -> usize {
        let scratch = ScratchFolder::new();
        let kept = Arc::new(Kept::default());
        for script in scripts {
            let path = scratch.path("script.lua");
            std::fs::write(&path, format!("local lampyris = require 'lampyris'\n{script}"))
                .unwrap();
            let settings = Settings { kept: Some(Arc::clone(&kept)), ..Settings::default() };
            run(&path, settings).unwrap();
        }
        kept.state().results.len()
    }

    const BASE: &str = "local k = { a = 1, b = { 2 } }
        function scale(x) return x * k.b[1] end
        local function f(x) return math.floor(scale(x)) + 3 end
        assert(lampyris.keep(f, 5) == 13)";

    #[test]
    fn what_is_the_same_is_made_once() {
        assert_eq!(kept_after(&[BASE]), 1);
        assert_eq!(kept_after(&[BASE, BASE]), 1);
        let moved = BASE.replace("function scale", "-- a comment\n\n function scale");
        let with_others = format!("local material = 3\n{BASE}\nlocal other = 4");
        assert_eq!(kept_after(&[BASE, &moved]), 1, "moved");
        assert_eq!(kept_after(&[BASE, &with_others]), 1, "others");
    }

    #[test]
    fn all_that_a_function_reaches_counts() {
        for (from, to) in [
            ("{ a = 1", "{ a = 2"),
            ("{ 2 }", "{ 2.0 }"),
            ("x * k", "1.0 * x * k"),
            ("+ 3", "+ x - 2"),
            ("math.floor", "math.ceil"),
            ("(f, 5)", "(f, 5.0)"),
        ] {
            assert_eq!(kept_after(&[BASE, &BASE.replace(from, to)]), 2, "{from} → {to}");
        }
    }

    #[test]
    fn functions_that_say_or_change_something_are_called_each_time() {
        let bodies = [
            "if false then print(1) end",
            "return math.random()",
            "count = count + 1",
            "list[1] = (list[1] or 0) + 1",
            "return function() end",
            "return require 'lampyris'",
            "return shuffled()",
        ];
        for body in bodies {
            let script = format!(
                "count = 0 local list = {{}} local shuffled = math.random
                lampyris.keep(function() {body} end)"
            );
            assert_eq!(kept_after(&[&script]), 0, "{body}");
        }
    }

    #[test]
    fn meshes_and_lights_are_kept_without_being_asked() {
        let script = "local lens = lampyris.mesh.surface { nu = 2, nv = 2,
                point = function(u, v) return u, v, u * v end }
            local both = lampyris.mesh.merge { lens, lens }
            local light = lampyris.cylinder { center = { 0, 0, 3 }, axis = { 0, 1, 0 }, radius = 1,
                length = 4, samples = 50, flux = 100, spectrum = lampyris.spectrum.blackbody(2856) }
            assert(#both == 16 and light.count == 50)";
        assert_eq!(kept_after(&[script, script]), 3);
        // Another lens is merged into another mesh; the light stays.
        assert_eq!(kept_after(&[script, &script.replace("u * v end", "u end")]), 5);
    }

    #[test]
    fn a_file_that_has_changed_is_read_again() {
        let scratch = ScratchFolder::new();
        let kept = Arc::new(Kept::default());
        let path = scratch.path("script.lua");
        let load = "local m = require 'lampyris'.mesh.load 'm.obj' assert(#m == tonumber(arg[1]))";
        std::fs::write(&path, load).unwrap();
        let faces = ["f 1 2 3\n", "f 1 2 3\nf 1 2 4\n"];
        for (count, faces) in [(1, faces[0]), (2, faces[1])] {
            let obj = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n{faces}");
            std::fs::write(scratch.path("m.obj"), obj).unwrap();
            for _ in 0..2 {
                let arguments = vec![count.to_string()];
                let kept = Some(Arc::clone(&kept));
                run(&path, Settings { kept, arguments, ..Settings::default() }).unwrap();
            }
        }
    }
}
