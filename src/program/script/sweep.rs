//! `lampyris.sweep`.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::time::Instant;

use mlua::{Lua, Table, Value};
use serde_json::{Map, json};

use super::display::LuaDisplay;
use super::host::{self, Host};
use super::image::{PNG_KEYS, save_png};
use super::options::{self, Arguments, Options};
use super::quality::{ASKED_KEYS, asked, warn_of_target};
use super::scene::{LuaScene, warn_of_view};
use super::view::LuaView;
use super::views::Views;
use super::{fault, image};
use crate::display::{Display, GamutReport};
use crate::error::Error;
use crate::image::{Region, SpectralImage};
use crate::output;
use crate::program::progress::Progress;
use crate::program::sweep::{
    self, Digest, Entry, FileDigest, Folder, Hasher, LuminanceScale, Reading,
};
use crate::render::{self, Asked, RenderStats};
use crate::view::View;

const KEYS: [&str; 6] = ["output", "png", "quality", "regions", "scene", "views"];

pub(super) fn register(lua: &Lua, module: &Table) -> mlua::Result<()> {
    module.set("sweep", fault::function(lua, |lua, a| sweep(lua, Arguments::new("sweep", a, 1)?))?)
}

/// One view as the script gives it.
pub(super) struct Item {
    pub name: String,
    pub view: View,
    pub scene: LuaScene,
}

/// What all views of a sweep share.
struct Plan {
    host: Host,
    asked: Asked,
    png: Value,
    display: Display,
    regions: Vec<(String, Region)>,
    digests: Digests,
    /// Of all views rendered so far.
    gamut: GamutReport,
}

fn sweep(lua: &Lua, mut arguments: Arguments) -> mlua::Result<Table> {
    let options = arguments.options(&KEYS)?;
    let host = host::of(lua)?;
    let output = options.required_text("output", "a folder below the output folder")?;
    let scene = options.handle::<LuaScene>("scene", "a scene")?;
    let views = Views::new(options.value("views")?, scene)?;
    let mut plan = Plan::new(host, &options)?;
    let path = plan.host.output_folder(&output)?;
    let shard = plan.host.settings.shard;
    let mut folder = Folder::open(&path, shard, plan.source()?)?;
    folder.set_display(sweep::display_record(&plan.display));
    let counts = plan.run(lua, views, &mut folder)?;
    image::warn_of_gamut(&plan.host, &format!("{output}/*.png"), &plan.gamut);
    folder.set_source(plan.source()?);
    folder.finish()?;
    let table = lua.create_table()?;
    table.set("folder", path.display().to_string())?;
    table.set("views", counts.rendered + counts.kept)?;
    table.set("rendered", counts.rendered)?;
    table.set("kept", counts.kept)?;
    Ok(table)
}

#[derive(Default)]
struct Counts {
    rendered: usize,
    kept: usize,
}

impl Plan {
    fn new(host: Host, options: &Options) -> mlua::Result<Self> {
        let quality_options =
            Options::new("sweep: quality", options.value("quality")?, &ASKED_KEYS)?;
        let png = options.value("png")?;
        let png_options = Options::new("sweep: png", png.clone(), &PNG_KEYS)?;
        let display = png_options.handle::<LuaDisplay>("display", "a display")?;
        Ok(Self {
            host,
            asked: asked(quality_options)?,
            png,
            display: display.map_or_else(Display::srgb, |handle| Display::clone(&handle.display)),
            regions: regions(options.value("regions")?)?,
            digests: Digests::default(),
            gamut: GamutReport::default(),
        })
    }

    fn run(&mut self, lua: &Lua, mut views: Views, folder: &mut Folder) -> mlua::Result<Counts> {
        let progress = self.host.progress(0);
        progress.more_pixels(views.pixels_where(|index| folder.is_ours(index)));
        let mut counts = Counts::default();
        let mut names = BTreeSet::new();
        for index in 1.. {
            let Some(item) = views.next(lua, index)? else {
                break;
            };
            if !names.insert(item.name.clone()) {
                let problem = format!("two views are named \"{}\"", item.name);
                return Err(Error::inconsistent("sweep: views", problem).into());
            }
            if !folder.is_ours(index) {
                continue;
            }
            let key = self.key(&item)?;
            if folder.keep(index, &item.name, &key) {
                counts.kept += 1;
                render::Watch::pixels_done(&progress, item.view.pixels());
                continue;
            }
            if views.count().is_none() {
                progress.more_pixels(item.view.pixels());
            }
            folder.remove_unfinished_of(&item.name)?;
            progress.begin_view(index, views.count());
            let start = Instant::now();
            let entry = self.render(folder.path(), index, &item, key, &progress)?;
            folder.set_source(self.source()?);
            folder.add(entry, start.elapsed().as_secs_f64())?;
            counts.rendered += 1;
        }
        Ok(counts)
    }

    /// Of everything that the files of a view depend on.
    fn key(&mut self, item: &Item) -> mlua::Result<Digest> {
        let mut hasher = Hasher::new();
        hasher.text(&sweep::program());
        hasher.text(sweep::executable().map_or("", Digest::as_str));
        hasher.text(&self.script_name());
        hasher.text(item.scene.fingerprint().as_str());
        hasher.text(&format!("{:?} {:?} {:?}", item.view, self.asked, self.regions));
        hasher.text(&self.describe(&self.png.clone())?);
        Ok(hasher.finish())
    }

    /// A value of the PNG options, as far as it decides on the picture.
    fn describe(&mut self, value: &Value) -> mlua::Result<String> {
        match value {
            Value::Table(table) => {
                let mut fields = BTreeMap::new();
                for pair in table.pairs::<Value, Value>() {
                    let (key, value) = pair?;
                    fields.insert(self.describe(&key)?, self.describe(&value)?);
                }
                Ok(format!("{fields:?}"))
            }
            // What a function does is in the script and in what it reads.
            Value::Function(_) => Ok(format!("{:?}", self.source()?)),
            Value::UserData(data) => match data.borrow::<LuaDisplay>() {
                Ok(handle) => Ok(format!("{:?}", handle.display)),
                Err(_) => Ok(options::describe(value)),
            },
            other => Ok(options::describe(other)),
        }
    }

    fn script_name(&self) -> String {
        let name = self.host.script.file_name().unwrap_or_default();
        name.to_string_lossy().into_owned()
    }

    fn source(&mut self) -> mlua::Result<sweep::Source> {
        let script = self.host.script.clone();
        let inputs = self.host.inputs();
        let seeds = self.host.seeds();
        Ok(sweep::Source {
            program: sweep::program(),
            executable: sweep::executable().cloned(),
            script: Some(self.digests.of(&self.script_name(), &script)?),
            arguments: self.host.settings.arguments.clone(),
            inputs: inputs
                .iter()
                .map(|input| self.digests.of(&input.name, &input.path))
                .collect::<crate::Result<_>>()?,
            seeds: seeds
                .iter()
                .map(|(object, seed)| json!({ "object": object, "seed": seed }))
                .collect(),
        })
    }

    fn render(
        &mut self,
        folder: &Path,
        index: usize,
        item: &Item,
        key: Digest,
        progress: &Progress,
    ) -> mlua::Result<Entry> {
        let prepared = item.scene.prepared(&self.host)?;
        warn_of_view(&self.host, &prepared, &item.view);
        let (mut image, stats) = self.asked.render(&prepared, &item.view, progress)?;
        warn_of_target(&self.host, &stats);
        image.metadata.insert("script".to_owned(), self.script_name());
        let name = &item.name;
        let exr = format!("{name}.exr");
        output::write_exr(&folder.join(&exr), &image)?;
        let png = format!("{name}.png");
        let png_options = Options::new("sweep: png", self.png.clone(), &PNG_KEYS)?;
        let shown = save_png(&folder.join(&png), &image, &item.view, &png_options)?.image;
        self.gamut = self.gamut.merge(shown.gamut);
        let xyz = image.to_xyz();
        let scale = LuminanceScale::of(&xyz);
        let luminance = sweep::luminance_name(name);
        output::write_png(&folder.join(&luminance), &sweep::luminance_raster(&xyz, scale)?)?;
        let mut details = self.details(item, &image, &stats)?;
        details.insert("exposure".to_owned(), json!(shown.exposure_factor));
        details.insert("luminance".to_owned(), json!({ "top": scale.top, "max": scale.max }));
        let outputs = [exr, png, luminance];
        let outputs = outputs.iter().map(|name| FileDigest::of(folder, name));
        let outputs = outputs.collect::<crate::Result<_>>()?;
        Ok(Entry { index, name: name.clone(), key, outputs, details })
    }

    fn details(
        &self,
        item: &Item,
        image: &SpectralImage,
        stats: &RenderStats,
    ) -> mlua::Result<Map<String, serde_json::Value>> {
        let mut readings = Map::new();
        for (name, region) in &self.regions {
            readings.insert(name.clone(), Reading::of(image, *region)?.record());
        }
        let photometry = format!("{:?}", image.photometry).to_lowercase();
        let rows = [
            ("view", sweep::view_record(&item.view)),
            ("quality", sweep::asked_record(&self.asked)),
            ("stats", sweep::stats_record(stats)),
            ("scene", json!(item.scene.fingerprint().as_str())),
            ("photometry", json!(photometry)),
            ("regions", readings.into()),
        ];
        Ok(rows.map(|(key, value)| (key.to_owned(), value)).into_iter().collect())
    }
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

/// Digests of files, each read once.
#[derive(Default)]
struct Digests(BTreeMap<PathBuf, Digest>);

impl Digests {
    fn of(&mut self, name: &str, path: &Path) -> crate::Result<FileDigest> {
        if !self.0.contains_key(path) {
            self.0.insert(path.to_owned(), Digest::of_file(path)?);
        }
        Ok(FileDigest { path: name.to_owned(), digest: self.0[path].clone() })
    }
}

impl Item {
    /// A view, or `{ view =, scene =, name = }`.
    pub(super) fn new(
        index: usize,
        view: &Value,
        scene: &Value,
        default: Option<&LuaScene>,
    ) -> mlua::Result<Self> {
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
        check_name(&object, &name)?;
        Ok(Self { name, view: view.0, scene })
    }
}

/// Names of views become names of files.
fn check_name(object: &str, name: &str) -> mlua::Result<()> {
    let plain = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-' | '.' | '+');
    let reserved = ["manifest", "index", "contact_sheet", "timings"];
    if !name.is_empty()
        && name.len() <= 200
        && !name.starts_with('.')
        && name.chars().all(plain)
        && !reserved.contains(&name)
    {
        return Ok(());
    }
    let allowed = "letters, digits and _ - + ., not a dot first, no name of the sweep's own files";
    Err(Error::out_of_range(object, "\"name\"", format!("\"{name}\""), allowed).into())
}
