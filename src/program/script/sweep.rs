//! `lampyris.sweep`.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use mlua::{Lua, Table, Value};
use serde_json::json;

use super::host::{self, Host, ScriptInput};
use super::image::RegionOptions;
use super::kinds::{Choice, Custom, Handle, Kind, Nested, Text, any, missing};
use super::look::PngOptions;
use super::members::Functions;
use super::options::{self, Arguments};
use super::quality::QUALITY;
use super::record::{Record, options};
use super::scene::LuaScene;
use super::view::LuaView;
use super::views::Views;
use crate::display::{Look, Tone};
use crate::image::Region;
use crate::program::fields::Cell;
use crate::program::results::SWEPT;
use crate::program::sweep::{
    self, Digest, FileDigest, Pictures, Plan, Share, Shot, Source, SweepOutcome,
};
use crate::render::{Asked, Quality};

options! {
    struct SweepOptions {
        /// of all views that name none
        scene: Option<LuaScene> = Handle::new("Scene", "a scene").optional(""),
        /// a list; or a function that returns one view (and scene) after the other, or yields them
        views: Value = any(
            "(View|SweepView)[]|fun(index: integer): View|SweepView|nil, Scene|nil",
        ).or(Value::Nil),
        /// a folder below the output folder
        output: String = Text("a folder below the output folder"),
        quality: Asked = QUALITY.or(Asked::Quality(Quality::default())),
        png: PngOptions = Nested::new(),
        /// whose spectra and chromaticities manifest and page show
        regions: Vec<(String, Region)> = REGIONS.or(Vec::new()),
        /// automatic exposure of the pictures: the brightest view's for all, or each view's own
        exposure: Share = SHARE.or(Share::One),
        /// range of the pictures of luminance
        false_color: Share = SHARE.or(Share::One),
    }
}

options! {
    struct SweepView {
        view: Value = any("View").or(Value::Nil),
        scene: Option<LuaScene> = Handle::new("Scene", "a scene").optional("the sweep's"),
        /// of the view's files: letters, digits and _ - + .
        name: Option<String> = Text("a name").optional("view_0001, …"),
    }
}

const SHARE: Choice<Share> = Choice(&[("one", Share::One), ("each", Share::Each)]);

pub(super) fn register(lua: &Lua, module: &Table) -> mlua::Result<()> {
    Functions::of_module(lua, module).add("sweep", 1, sweep)
}

fn sweep(lua: &Lua, mut arguments: Arguments) -> mlua::Result<Cell> {
    let given: SweepOptions = arguments.record()?;
    let host = host::of(lua)?;
    let mut views = Views::new(given.views, given.scene, given.quality)?;
    let shard = host.settings.shard;
    let ours = |index| shard.is_none_or(|shard| shard.has(index));
    let digests = RefCell::default();
    let look = given.png.look()?;
    let plan = Plan {
        asked: given.quality,
        pictures: Pictures {
            read_by_look: read_by_look(&look, &host, &mut digests.borrow_mut())?,
            look,
            exposure: given.exposure,
            false_color: given.false_color,
        },
        regions: given.regions,
        shard,
        script: host.script_name(),
        source: &|| source(&host, &mut digests.borrow_mut()),
        progress: &host.progress(views.pixels_where(ours)),
        warn: &|warning| host.warn(warning),
        screen: host.settings.screen.as_deref(),
        is_dry_run: host.settings.is_dry_run,
    };
    let output = given.output;
    let path = host.claim_folder("sweep", &output)?;
    let count = views.count();
    let shots = (1..).map_while(|index| views.next(lua, index).transpose());
    let done = plan.run(&path, shots, count)?;
    if plan.is_dry_run {
        tell_dry_run(&host, &path, &done);
    }
    host.note_clipped(&plan.pictures.look, &done.gamut, done.rendered + done.kept);
    let mut report = vec![("folder", path.display().to_string().as_str().into())];
    report.extend(SWEPT.cells(&done));
    Ok(Cell::Record(report))
}

/// On standard output, which is what a dry run is for.
fn tell_dry_run(host: &Host, folder: &Path, done: &SweepOutcome) {
    let (folder, SweepOutcome { rendered, kept, .. }) = (folder.display(), done);
    host.say(&format!("{folder}: {rendered} views would be rendered, {kept} are there"));
    for (view, cause) in &done.causes {
        host.say(&format!("  {view}: {}", cause.unwrap_or("is not there yet")));
    }
    for view in &done.left_over {
        host.say(&format!("  {view}: is not of this sweep, its files would be moved aside"));
    }
}

/// What a function does is in the script and in what it reads.
fn read_by_look(look: &Look, host: &Host, digests: &mut Digests) -> crate::Result<String> {
    match look.tone {
        Tone::Curve(_) => Ok(format!("{:?}", source(host, digests)?)),
        _ => Ok(String::new()),
    }
}

/// What the script is and has read so far.
///
/// Errors: a file that has changed since it was read.
pub(super) fn source(host: &Host, digests: &mut Digests) -> crate::Result<Source> {
    let seeds = host.seeds();
    let script = host.script_input().map(|script| digests.of(script)).transpose()?;
    Ok(Source {
        program: sweep::program(),
        executable: sweep::executable().cloned(),
        build: sweep::build(),
        script,
        arguments: host.settings.arguments.clone(),
        inputs: host
            .inputs()
            .iter()
            .map(|input| digests.of(input))
            .collect::<crate::Result<_>>()?,
        seeds: seeds
            .iter()
            .map(|(object, seed)| json!({ "object": object, "seed": seed }))
            .collect(),
    })
}

const REGIONS: Custom<Vec<(String, Region)>> = Custom {
    lua_type: "table<string, RegionOptions>",
    allowed: "",
    read: regions,
    shown: |_| "none".to_owned(),
};

/// `{ name = {x =, y =, width = 1, height = 1}, … }`.
fn regions(object: &str, what: &str, value: &Value) -> mlua::Result<Vec<(String, Region)>> {
    let Value::Table(table) = value else {
        let expected = "a table of regions by name";
        return Err(options::wrong_type(object, what, value, expected).into());
    };
    let mut regions = BTreeMap::new();
    for pair in table.pairs::<Value, Value>() {
        let (name, value) = pair?;
        let name = options::text("sweep: regions", "name", &name)?;
        let given = RegionOptions::read(&format!("sweep: region \"{name}\""), value)?;
        regions.insert(name, given.region());
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
    const EXPECTED: &str = "a view, or {view =, scene =, name =}";
    let object = format!("sweep: view {index}");
    let given = match view {
        Value::Table(_) => SweepView::read(&object, view.clone())?,
        view => SweepView { view: view.clone(), scene: None, name: None },
    };
    let view: LuaView = options::handle(&object, "entry", &given.view, EXPECTED)?;
    let scene = match scene {
        Value::Nil => given.scene,
        scene => Some(options::handle(&object, "scene", scene, "a scene")?),
    };
    let scene = scene.or_else(|| default.cloned()).ok_or_else(|| {
        missing("sweep", "scene", &format!("a scene for all views, or one for view {index}"))
    })?;
    let name = given.name.unwrap_or_else(|| format!("view_{index:04}"));
    sweep::check_name(&object, &name)?;
    Ok(Shot { name, view: view.0, stage: Arc::clone(&scene.0) })
}

/// Digests of files, each read once.
#[derive(Default)]
pub(super) struct Digests(BTreeMap<PathBuf, Digest>);

impl Digests {
    /// Checks on both sides of reading, so that the digest is of what the script read.
    fn of(&mut self, input: &ScriptInput) -> crate::Result<FileDigest> {
        input.check()?;
        if !self.0.contains_key(&input.path) {
            self.0.insert(input.path.clone(), Digest::of_file(&input.path)?);
            input.check()?;
        }
        Ok(FileDigest { path: input.name.clone(), digest: self.0[&input.path].clone() })
    }
}
