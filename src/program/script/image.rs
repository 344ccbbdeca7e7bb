//! The image that a render returns.

use std::sync::Arc;

use mlua::{Function, Lua, MetaMethod, Table, UserData, UserDataFields, UserDataMethods, Value};

use super::camera::LuaCamera;
use super::display::LuaDisplay;
use super::host::Host;
use super::options::{self, Arguments, Options, Range};
use super::spectrum::LuaSpectrum;
use super::view::MAX_SIDE;
use super::{fault, figure, host};
use crate::color::Photometry;
use crate::display::{Developed, Exposure, Gamut, GamutReport, Glare, Look, Tone};
use crate::error::Error;
use crate::image::difference::ImageDifference;
use crate::image::{Region, SpectralImage, XyzImage, weighted_sum};
use crate::output::{self, ExrBands};
use crate::program::intensity;
use crate::program::memory;
use crate::render::{RenderStats, TargetReport};
use crate::scene::{BuildSeconds, Prepared};
use crate::spectrum::Spectrum;
use crate::view::View;

/// Handle of a rendered image.
#[derive(Debug, Clone)]
pub struct LuaImage(Arc<Rendered>);

#[derive(Debug)]
struct Rendered {
    image: SpectralImage,
    /// `None` for an image that was not rendered by this script.
    run: Option<Run>,
}

/// How a render went.
#[derive(Debug)]
struct Run {
    stats: RenderStats,
    build: BuildSeconds,
}

const IMAGES: &str = "a list of {image, weight}";

pub(super) fn register(lua: &Lua, module: &Table) -> mlua::Result<()> {
    let table = lua.create_table()?;
    let load = fault::function(lua, |lua, a| {
        let path = Arguments::new("image.load", a, 1)?.text("path")?;
        let path = host::of(lua)?.input(&path)?;
        Ok(LuaImage::of(output::read_exr(&path)?))
    })?;
    table.set("load", load)?;
    table.set("sum", fault::function(lua, |_, a| sum(Arguments::new("image.sum", a, 1)?))?)?;
    fault::refuse_unknown_names(lua, &table, "lampyris.image")?;
    module.set("image", table)
}

/// `{ { a, 0.3 }, b, … }`: an image alone has the weight 1.
fn sum(mut arguments: Arguments) -> mlua::Result<LuaImage> {
    const OBJECT: &str = "image.sum";
    let entries = options::list(OBJECT, "argument 1", &arguments.value(), IMAGES)?;
    let term = |(at, entry): (usize, &Value)| -> mlua::Result<(f64, LuaImage)> {
        let what = format!("entry {at}");
        let (image, weight) = match entry {
            Value::Table(_) => {
                match options::list(OBJECT, &what, entry, "{image, weight}")?.as_slice() {
                    [image] => (image.clone(), 1.0),
                    [image, weight] => {
                        (image.clone(), options::number(OBJECT, &what, weight, Range::ANY)?)
                    }
                    parts => {
                        let problem =
                            format!("{what} has {} parts, expected {{image, weight}}", parts.len());
                        return Err(Error::inconsistent(OBJECT, problem).into());
                    }
                }
            }
            image => (image.clone(), 1.0),
        };
        Ok((weight, options::handle(OBJECT, &what, &image, "an image")?))
    };
    let terms = (1..).zip(&entries).map(term).collect::<mlua::Result<Vec<_>>>()?;
    weighted(&terms)
}

fn weighted(terms: &[(f64, LuaImage)]) -> mlua::Result<LuaImage> {
    let terms: Vec<_> = terms.iter().map(|(weight, i)| (*weight, &i.0.image)).collect();
    Ok(LuaImage::of(weighted_sum(&terms)?))
}

/// A region that need not be that of a known image.
pub(super) fn region(options: &Options) -> mlua::Result<Region> {
    let place = |key, min, default| {
        options.count(key, min, MAX_SIDE).map(|n| n.unwrap_or(default) as usize)
    };
    Ok(Region {
        x: place("x", 0, 0)?,
        y: place("y", 0, 0)?,
        width: place("width", 1, 1)?,
        height: place("height", 1, 1)?,
    })
}

const NAMES: [&str; 11] = [
    "compare",
    "false_color",
    "height",
    "intensity",
    "luminance",
    "luminances",
    "save",
    "spectrum",
    "stats",
    "width",
    "xyz",
];

impl LuaImage {
    pub(super) fn new(image: SpectralImage, stats: RenderStats, prepared: &Prepared) -> Self {
        let run = Some(Run { stats, build: prepared.seconds });
        Self(Arc::new(Rendered { image, run }))
    }

    /// An image that no render of this script has made.
    fn of(image: SpectralImage) -> Self {
        Self(Arc::new(Rendered { image, run: None }))
    }

    /// Errors: nobody knows from where the image was seen.
    fn view(&self, object: &str) -> mlua::Result<View> {
        let problem = "the image does not say from where it was seen";
        self.0.image.view.ok_or_else(|| Error::inconsistent(object, problem).into())
    }

    pub(super) fn xyz_image(&self) -> XyzImage {
        self.0.image.to_xyz()
    }

    pub(super) fn spectral(&self) -> &SpectralImage {
        &self.0.image
    }

    pub(super) fn photometry(&self) -> Photometry {
        self.0.image.photometry
    }

    /// Y of every pixel.
    pub(super) fn luminances(&self) -> Vec<f64> {
        self.xyz_image().pixels.iter().map(|color| color.y).collect()
    }

    /// `{x =, y =, width = 1, height = 1}`, or the whole image for nil.
    pub(super) fn region(&self, options: Options) -> mlua::Result<Region> {
        let image = &self.0.image;
        let most = |side: usize| side.max(1) as u64;
        let x = options.count("x", 0, most(image.width))?;
        let y = options.count("y", 0, most(image.height))?;
        let width = options.count("width", 1, most(image.width))?;
        let height = options.count("height", 1, most(image.height))?;
        if (x, y, width, height) == (None, None, None, None) {
            return Ok(Region { x: 0, y: 0, width: image.width, height: image.height });
        }
        Ok(Region {
            x: x.unwrap_or(0) as usize,
            y: y.unwrap_or(0) as usize,
            width: width.unwrap_or(1) as usize,
            height: height.unwrap_or(1) as usize,
        })
    }
}

pub(super) const REGION_KEYS: [&str; 4] = ["height", "width", "x", "y"];

impl UserData for LuaImage {
    fn add_fields<F: UserDataFields<Self>>(fields: &mut F) {
        fields.add_field_method_get("width", |_, this| Ok(this.0.image.width));
        fields.add_field_method_get("height", |_, this| Ok(this.0.image.height));
        fields.add_field_method_get("stats", |lua, this| {
            this.0.run.as_ref().map(|run| stats(lua, run)).transpose()
        });
    }

    fn add_methods<M: UserDataMethods<Self>>(methods: &mut M) {
        fault::method(methods, "spectrum", |_, this: &Self, a| {
            let region = Arguments::new("image:spectrum", a, 1)?.options(&REGION_KEYS)?;
            let image = &this.0.image;
            let bands = image.mean_bands(this.region(region)?)?;
            let rows = image.grid.wavelengths_nm().zip(bands);
            Ok(LuaSpectrum(Arc::new(Spectrum::from_pairs("image:spectrum", rows)?)))
        });
        fault::method(methods, "xyz", |_, this: &Self, a| {
            let region = Arguments::new("image:xyz", a, 1)?.options(&REGION_KEYS)?;
            let xyz = this.0.image.mean_xyz(this.region(region)?)?;
            Ok((xyz.x, xyz.y, xyz.z))
        });
        fault::method(methods, "luminance", |_, this: &Self, a| {
            let region = Arguments::new("image:luminance", a, 1)?.options(&REGION_KEYS)?;
            Ok(this.0.image.mean_xyz(this.region(region)?)?.y)
        });
        fault::method(methods, "intensity", |lua, this: &Self, a| {
            Arguments::new("image:intensity", a, 0)?;
            let view = this.view("image:intensity")?;
            warn_of_cut_off(&host::of(lua)?, &this.0.image, &view);
            Ok(intensity::intensity(&this.0.image, &view)?.y)
        });
        fault::method(methods, "luminances", |_, this: &Self, a| {
            let options = Arguments::new("image:luminances", a, 1)?.options(&REGION_KEYS)?;
            let region = this.region(options)?;
            region.check(this.0.image.width, this.0.image.height)?;
            let image = this.xyz_image();
            let luminance = |(x, y): (usize, usize)| image.pixels[y * image.width + x].y;
            Ok(region.pixels().map(luminance).collect::<Vec<_>>())
        });
        fault::method(methods, "compare", |lua, this: &Self, a| {
            let value = Arguments::new("image:compare", a, 1)?.value();
            let reference: Self =
                options::handle("image:compare", "argument 1", &value, "an image")?;
            let difference = ImageDifference::between(&this.0.image, &reference.0.image)?;
            difference_table(lua, &difference)
        });
        fault::method(methods, "false_color", |_, this: &Self, a| {
            let keys = &figure::FALSE_COLOR_KEYS;
            let options = Arguments::new("image:false_color", a, 1)?.options(keys)?;
            figure::false_color_figure(this, &options)
        });
        fault::method(methods, "save", |lua, this: &Self, a| {
            save(lua, &this.0, Arguments::new("image:save", a, 2)?)
        });
        methods.add_meta_method(MetaMethod::ToString, |_, this, ()| {
            let Rendered { image, run } = this.0.as_ref();
            let (width, height, bands) = (image.width, image.height, image.grid.bands());
            let seconds = run.as_ref().map(|run| format!(", {:.2} s", run.stats.seconds));
            Ok(format!("image: {width} × {height}, {bands} bands{}", seconds.unwrap_or_default()))
        });
        methods.add_meta_function(MetaMethod::Add, |lua, (a, b): (Value, Value)| {
            let image =
                |value: &Value| options::handle("image + image", "operand", value, "an image");
            let terms = || Ok([(1.0, image(&a)?), (1.0, image(&b)?)]);
            let sum = terms().and_then(|terms: [(f64, LuaImage); 2]| weighted(&terms));
            sum.map_err(|error| fault::located(lua, error))
        });
        methods.add_meta_function(MetaMethod::Mul, |lua, (a, b): (Value, Value)| {
            const OBJECT: &str = "number * image";
            let (image, weight) = if a.is_userdata() { (a, b) } else { (b, a) };
            let term = || -> mlua::Result<(f64, LuaImage)> {
                let weight = options::number(OBJECT, "operand", &weight, Range::ANY)?;
                Ok((weight, options::handle(OBJECT, "operand", &image, "an image")?))
            };
            let scaled = term().and_then(|term| weighted(&[term]));
            scaled.map_err(|error| fault::located(lua, error))
        });
        fault::refuse_unknown_fields(methods, "image", &NAMES);
    }
}

/// Keys of a look's table.
pub(super) const LOOK_KEYS: [&str; 7] =
    ["bits", "camera", "display", "exposure", "gamut", "glare", "tone"];

pub(super) const PNG_KEYS: [&str; 8] =
    ["bits", "camera", "display", "exposure", "gamut", "glare", "look", "tone"];

/// The kind of file follows from the path's ending.
fn save(lua: &Lua, rendered: &Rendered, mut arguments: Arguments) -> mlua::Result<Table> {
    let path = arguments.text("path")?;
    let host = host::of(lua)?;
    let target = host.output(&path)?;
    match target.extension().and_then(|e| e.to_str()) {
        Some("exr") => {
            let options = arguments.options(&["bands"])?;
            let bands = [
                ("float", ExrBands::Float),
                ("half", ExrBands::Half),
                ("pxr24", ExrBands::Pxr24),
                ("none", ExrBands::None),
            ];
            let bands = options.choice("bands", &bands)?.unwrap_or_default();
            output::write_exr_as(&target, &rendered.image, bands)?;
            lua.create_table()
        }
        Some("png") => {
            let options = arguments.options(&PNG_KEYS)?;
            let look = look(&options)?;
            let shown = output::develop_png(&target, &rendered.image, &look)?;
            warn_of_gamut(&host, &path, &shown.picture.gamut);
            png_stats(lua, &shown)
        }
        _ => {
            let found = format!("\"{path}\"");
            Err(Error::out_of_range("image:save", "path", found, "names ending in .exr or .png")
                .into())
        }
    }
}

/// Light beyond the image is not in its intensity.
pub(super) fn warn_of_cut_off(host: &Host, image: &SpectralImage, view: &View) {
    if intensity::is_cut_off(image) {
        host.warn(format!("intensity: light reaches the border of the image ({view})"));
    }
}

/// What is too dark shows as the display's black, as anyone expects.
pub(super) fn warn_of_gamut(host: &Host, path: &str, gamut: &GamutReport) {
    let (bright, saturated) = (gamut.too_bright, gamut.too_saturated);
    if bright + saturated > 0 {
        host.warn(format!(
            "{path}: the display cannot show {bright} pixels that are brighter than its white and \
             {saturated} that are more saturated than its primaries, of {}; up to ΔE00 {:.1}",
            gamut.pixels, gamut.max_delta_e_2000
        ));
    }
}

/// How a picture is shown: `look`, a name or a table, and what the options say beside it.
pub(super) fn look(options: &Options) -> mlua::Result<Look> {
    let look = match options.value("look")? {
        Value::Nil => Look::paper(),
        table @ Value::Table(_) => {
            let object = format!("{}: look", options.object());
            changed(Look::paper(), &Options::new(&object, table, &LOOK_KEYS)?)?
        }
        _ => {
            let names = Look::NAMES.map(|name| (name, name));
            let name = options.choice("look", &names)?.unwrap_or("paper");
            Look::named(name).unwrap_or_default()
        }
    };
    changed(look, options)
}

/// A look with what options of its keys say.
fn changed(look: Look, options: &Options) -> mlua::Result<Look> {
    let display = options.handle::<LuaDisplay>("display", "a display")?;
    let display = display.map_or(look.display, |d| Arc::unwrap_or_clone(d.display));
    let gamuts = [("clip", Gamut::Clip), ("desaturate", Gamut::Desaturate)];
    let camera = match options.value("camera")? {
        Value::Nil => look.camera,
        Value::Boolean(false) => None,
        _ => options.handle::<LuaCamera>("camera", "a camera")?.map(|camera| camera.0),
    };
    Ok(Look {
        display: match options.count("bits", 1, 16)? {
            Some(bits) => display.with_bits(bits as u32)?,
            None => display,
        },
        exposure: if options.has("exposure")? { exposure(options)? } else { look.exposure },
        tone: if options.has("tone")? { tone(options)? } else { look.tone },
        gamut: options.choice("gamut", &gamuts)?.unwrap_or(look.gamut),
        glare: if options.has("glare")? { glare(options)? } else { look.glare },
        camera,
    })
}

/// A curve's name, or a function.
fn tone(options: &Options) -> mlua::Result<Tone> {
    if let Value::Function(curve) = options.value("tone")? {
        return Ok(Tone::Curve(Arc::new(move |luminance| curve_value(&curve, luminance))));
    }
    let tones = [("linear", 0), ("reinhard", 1), ("photographic", 2)];
    Ok(match options.choice("tone", &tones)? {
        Some(1) => Tone::Reinhard,
        Some(2) => Tone::Photographic,
        _ => Tone::Linear,
    })
}

/// `{age =, pigment =, strength =}`, or `true` for the default eye.
fn glare(options: &Options) -> mlua::Result<Option<Glare>> {
    let value = match options.value("glare")? {
        Value::Nil | Value::Boolean(false) => return Ok(None),
        Value::Boolean(true) => return Ok(Some(Glare::default())),
        value => value,
    };
    let object = format!("{}: glare", options.object());
    let eye = Options::new(&object, value, &["age", "pigment", "strength"])?;
    let default = Glare::default();
    Ok(Some(Glare {
        age: eye.number_or("age", Range::new(0.0, 120.0, "years"), default.age)?,
        pigment: eye.number_or("pigment", Range::new(0.0, 1.2, ""), default.pigment)?,
        strength: eye.number_or("strength", Range::RATIO, default.strength)?,
    }))
}

/// A script's tone curve, from and to luminance relative to display white.
fn curve_value(curve: &Function, luminance: f64) -> crate::Result<f64> {
    let failed = |problem: String| Error::inconsistent("image:save: tone", problem);
    match curve.call::<Value>(luminance) {
        Ok(Value::Number(value)) => Ok(value),
        Ok(Value::Integer(value)) => Ok(value as f64),
        Ok(other) => {
            Err(failed(format!("returned {}, expected a number", options::describe(&other))))
        }
        Err(error) => Err(failed(fault::message(&error))),
    }
}

/// `"auto"`, a factor, `{ev = stops}` or `{adaptation = cd/m²}`.
pub(super) fn exposure(options: &Options) -> mlua::Result<Exposure> {
    match options.value("exposure")? {
        Value::Nil => Ok(Exposure::Auto),
        Value::Table(table) => {
            let object = format!("{}: exposure", options.object());
            let given = Options::new(&object, Value::Table(table), &["adaptation", "ev"])?;
            match given.number("adaptation", Range::above_zero("cd/m²"))? {
                Some(luminance) => Ok(Exposure::Adapted(luminance)),
                None => {
                    let stops = Range::new(-100.0, 100.0, "stops");
                    Ok(Exposure::Stops(given.required_number("ev", stops)?))
                }
            }
        }
        Value::String(word) if word == "auto" => Ok(Exposure::Auto),
        Value::String(_) => {
            let allowed = "\"auto\", a factor above 0, {ev = stops}";
            let found = format!("\"{}\"", options.text("exposure")?.unwrap_or_default());
            Err(Error::out_of_range(options.object(), "\"exposure\"", found, allowed).into())
        }
        _ => {
            let factor = options.required_number("exposure", Range::above_zero(""))?;
            Ok(Exposure::Factor(factor))
        }
    }
}

fn png_stats(lua: &Lua, shown: &Developed) -> mlua::Result<Table> {
    let table = lua.create_table()?;
    table.set("glare_lost", shown.glare.map(|glare| glare.lost_share))?;
    let shown = &shown.picture;
    table.set("exposure", shown.exposure_factor)?;
    table.set("outside_gamut", shown.gamut.outside())?;
    table.set("too_dark", shown.gamut.too_dark)?;
    table.set("too_bright", shown.gamut.too_bright)?;
    table.set("too_saturated", shown.gamut.too_saturated)?;
    table.set("mean_delta_e_2000", shown.gamut.mean_delta_e_2000)?;
    table.set("max_delta_e_2000", shown.gamut.max_delta_e_2000)?;
    Ok(table)
}

fn difference_table(lua: &Lua, difference: &ImageDifference) -> mlua::Result<Table> {
    let table = lua.create_table()?;
    table.set("lit_pixels", difference.lit_pixels)?;
    table.set("relative_rms", difference.relative_rms)?;
    table.set("worst", difference.worst)?;
    table.set("mean_delta_e_2000", difference.mean_delta_e_2000)?;
    table.set("percentile_95_delta_e_2000", difference.percentile_95_delta_e_2000)?;
    table.set("spectral_rms", difference.spectral_rms)?;
    Ok(table)
}

fn stats(lua: &Lua, run: &Run) -> mlua::Result<Table> {
    let Run { stats, build } = run;
    let counts = &stats.counts;
    let table = lua.create_table()?;
    let per_sum = |count: u64| count as f64 / counts.light_sums.max(1) as f64;
    let numbers = [
        ("camera_rays", counts.camera_rays as f64),
        ("mirror_rays", counts.mirror_rays as f64),
        ("transmitted_rays", counts.transmitted_rays as f64),
        ("shadow_rays", counts.shadow_rays as f64),
        ("light_sums", counts.light_sums as f64),
        ("nodes_per_sum", per_sum(counts.light_nodes)),
        ("samples_per_sum", per_sum(counts.light_samples)),
        ("light_error", stats.mean_light_error),
        ("largest_light_error", stats.largest_light_error),
        ("seconds", stats.seconds),
        ("bvh_seconds", build.bvh),
        ("light_tree_seconds", build.light_trees),
    ];
    for (name, value) in numbers {
        table.set(name, value)?;
    }
    table.set("peak_memory_mb", memory::peak_mb())?;
    table.set("target", stats.target.map(|report| target_table(lua, &report)).transpose()?)?;
    Ok(table)
}

/// What `target_error` chose, and the errors that it estimates.
fn target_table(lua: &Lua, report: &TargetReport) -> mlua::Result<Table> {
    let table = lua.create_table()?;
    let numbers = [
        ("error", report.error()),
        ("sampling_error", report.sampling_error),
        ("light_sum_error", report.light_sum_error),
        ("truncation_error", report.truncation_error),
        ("samples", report.mean_samples),
        ("min_throughput", report.limits.min_throughput),
        ("light_error", report.limits.light_error),
        ("wavelength_step", report.grid.step_nm()),
    ];
    for (name, value) in numbers {
        table.set(name, value)?;
    }
    table.set("reached", report.is_reached())?;
    table.set("most_samples", report.most_samples)?;
    table.set("max_depth", report.limits.max_depth)?;
    Ok(table)
}
