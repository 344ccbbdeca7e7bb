//! `lampyris.sweep`.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use mlua::{Lua, Table, Value};
use serde_json::json;

use super::host::{self, Host};
use super::image::{PNG_KEYS, look};
use super::options::{self, Arguments, Options};
use super::quality::{ASKED_KEYS, asked};
use super::scene::LuaScene;
use super::view::LuaView;
use super::views::Views;
use super::{fault, image};
use crate::error::Error;
use crate::image::Region;
use crate::program::sweep::{self, Digest, FileDigest, Plan, Shot, Source};

const KEYS: [&str; 6] = ["output", "png", "quality", "regions", "scene", "views"];

pub(super) fn register(lua: &Lua, module: &Table) -> mlua::Result<()> {
    module.set("sweep", fault::function(lua, |lua, a| sweep(lua, Arguments::new("sweep", a, 1)?))?)
}

fn sweep(lua: &Lua, mut arguments: Arguments) -> mlua::Result<Table> {
    let options = arguments.options(&KEYS)?;
    let host = host::of(lua)?;
    let output = options.required_text("output", "a folder below the output folder")?;
    let scene = options.handle::<LuaScene>("scene", "a scene")?;
    let mut views = Views::new(options.value("views")?, scene)?;
    let quality = Options::new("sweep: quality", options.value("quality")?, &ASKED_KEYS)?;
    let png = Options::new("sweep: png", options.value("png")?, &PNG_KEYS)?;
    let shard = host.settings.shard;
    let ours = |index| shard.is_none_or(|shard| shard.has(index));
    let digests = RefCell::default();
    let plan = Plan {
        asked: asked(quality)?,
        look: look(&png)?,
        regions: regions(options.value("regions")?)?,
        shard,
        script: script_name(&host),
        source: &|| source(&host, &mut digests.borrow_mut()),
        progress: &host.progress(views.pixels_where(ours)),
        warn: &|warning| host.warn(warning),
    };
    let path = host.output_folder(&output)?;
    let count = views.count();
    let shots = (1..).map_while(|index| views.next(lua, index).transpose());
    let done = plan.run(&path, shots, count)?;
    image::warn_of_gamut(&host, &format!("{output}/*.png"), &done.gamut);
    let table = lua.create_table()?;
    table.set("folder", path.display().to_string())?;
    table.set("views", done.rendered + done.kept)?;
    table.set("rendered", done.rendered)?;
    table.set("kept", done.kept)?;
    Ok(table)
}

fn script_name(host: &Host) -> String {
    host.script.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// What the script is and has read so far.
pub(super) fn source(host: &Host, digests: &mut Digests) -> crate::Result<Source> {
    let seeds = host.seeds();
    Ok(Source {
        program: sweep::program(),
        executable: sweep::executable().cloned(),
        script: Some(digests.of(&script_name(host), &host.script)?),
        arguments: host.settings.arguments.clone(),
        inputs: host
            .inputs()
            .iter()
            .map(|input| digests.of(&input.name, &input.path))
            .collect::<crate::Result<_>>()?,
        seeds: seeds
            .iter()
            .map(|(object, seed)| json!({ "object": object, "seed": seed }))
            .collect(),
    })
}

/// `{ name = {x =, y =, width = 1, height = 1}, … }`.
fn regions(value: Value) -> mlua::Result<Vec<(String, Region)>> {
    const EXPECTED: &str = "a table of regions by name";
    let table = match value {
        Value::Nil => return Ok(Vec::new()),
        Value::Table(table) => table,
        other => {
            return Err(options::wrong_type("sweep", "\"regions\"", &other, EXPECTED).into());
        }
    };
    let mut regions = BTreeMap::new();
    for pair in table.pairs::<Value, Value>() {
        let (name, value) = pair?;
        let name = options::text("sweep: regions", "name", &name)?;
        let options =
            Options::new(&format!("sweep: region \"{name}\""), value, &image::REGION_KEYS)?;
        regions.insert(name, image::region(&options)?);
    }
    Ok(regions.into_iter().collect())
}

/// A view, or `{ view =, scene =, name = }`.
pub(super) fn shot(
    index: usize,
    view: &Value,
    scene: &Value,
    default: Option<&LuaScene>,
) -> mlua::Result<Shot> {
    let object = format!("sweep: view {index}");
    let given = Options::new(
        &object,
        match view {
            table @ Value::Table(_) => table.clone(),
            _ => Value::Nil,
        },
        &["name", "scene", "view"],
    )?;
    let view = if view.is_table() { given.value("view")? } else { view.clone() };
    let view: LuaView =
        options::handle(&object, "entry", &view, "a view, or {view =, scene =, name =}")?;
    let scene = match scene {
        Value::Nil => given.handle::<LuaScene>("scene", "a scene")?,
        scene => Some(options::handle(&object, "scene", scene, "a scene")?),
    };
    let scene = scene.or_else(|| default.cloned()).ok_or_else(|| Error::MissingKey {
        object: "sweep".to_owned(),
        key: "scene".to_owned(),
        expected: format!("expected a scene for all views, or one for view {index}"),
    })?;
    let name = given.text("name")?.unwrap_or_else(|| format!("view_{index:04}"));
    sweep::check_name(&object, &name)?;
    Ok(Shot { name, view: view.0, stage: Arc::clone(&scene.0) })
}

/// Digests of files, each read once.
#[derive(Default)]
pub(super) struct Digests(BTreeMap<PathBuf, Digest>);

impl Digests {
    fn of(&mut self, name: &str, path: &Path) -> crate::Result<FileDigest> {
        if !self.0.contains_key(path) {
            self.0.insert(path.to_owned(), Digest::of_file(path)?);
        }
        Ok(FileDigest { path: name.to_owned(), digest: self.0[path].clone() })
    }
}
