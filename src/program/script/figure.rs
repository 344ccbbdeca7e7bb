//! `lampyris.figure`.

use std::sync::Arc;

use mlua::{Lua, MetaMethod, Table, UserData, UserDataMethods, Value};

use super::image::{self, LuaImage};
use super::options::{self, Arguments, Options, Range};
use super::{fault, host};
use crate::color::Photometry;
use crate::display::{Display, Look};
use crate::error::Error;
use crate::image::Region;
use crate::program::figure::{
    Axis, Chart, FalseColor, Figure, Marks, Panel, RasterPanel, Scale, SegmentsPanel, Series,
    false_color,
};

/// Handle of a figure.
#[derive(Debug, Clone)]
pub struct LuaFigure(Arc<Figure>);

const NAMES: [&str; 2] = ["save", "svg"];

const FIGURE_KEYS: [&str; 5] = ["columns", "height", "panels", "title", "width"];
const CHART_KEYS: [&str; 4] = ["series", "title", "x", "y"];
const SEGMENTS_KEYS: [&str; 4] = ["azimuth", "elevation", "segments", "title"];
pub(super) const FALSE_COLOR_KEYS: [&str; 3] = ["label", "log", "range"];
const IMAGE_KEYS: [&str; 10] = [
    "camera",
    "crop",
    "exposure",
    "false_color",
    "gamut",
    "glare",
    "image",
    "look",
    "title",
    "tone",
];

const DEFAULT_SIZE: [u32; 2] = [800, 600];

/// Pixels a side.
const MAX_SIDE: u64 = 16_384;

pub(super) fn register(lua: &Lua, module: &Table) -> mlua::Result<()> {
    module.set("figure", fault::function(lua, |_, a| figure(Arguments::new("figure", a, 1)?))?)
}

impl LuaFigure {
    /// One panel at the size that [`figure`] gives where a script asks for none.
    pub(super) fn of_panel(panel: Panel) -> Self {
        Self(Arc::new(Figure {
            width: DEFAULT_SIZE[0],
            height: DEFAULT_SIZE[1],
            title: String::new(),
            columns: 1,
            panels: vec![panel],
        }))
    }
}

/// `image:false_color { log =, range =, label = }`.
pub(super) fn false_color_figure(image: &LuaImage, options: &Options) -> mlua::Result<LuaFigure> {
    let panel = false_color(&image.xyz_image(), &colors(options, image)?)?;
    Ok(LuaFigure::of_panel(Panel::Raster(panel)))
}

/// `panels` in a grid, or the keys of one panel beside those of the figure.
fn figure(mut arguments: Arguments) -> mlua::Result<LuaFigure> {
    let value = arguments.value();
    let keys = |own: &[&'static str]| {
        let mut keys = [&FIGURE_KEYS[..], own].concat();
        keys.sort_unstable();
        keys.dedup();
        keys
    };
    let has = |key: &str| {
        value.as_table().is_some_and(|t| t.raw_get::<Value>(key).is_ok_and(|v| !v.is_nil()))
    };
    let options = if has("panels") {
        Options::new("figure", value.clone(), &FIGURE_KEYS)?
    } else {
        Options::new("figure", value.clone(), &keys(panel_keys(&value)))?
    };
    let panels = match options.list("panels", "a list of panels")? {
        None => vec![panel(&options)?],
        Some(list) => (1..).zip(list).map(panel_of_list).collect::<mlua::Result<_>>()?,
    };
    let side = |key, default: u32| -> mlua::Result<u32> {
        Ok(options.count(key, 1, MAX_SIDE)?.map_or(default, |pixels| pixels as u32))
    };
    // A single panel carries the title itself.
    let title =
        if has("panels") { options.text("title")?.unwrap_or_default() } else { String::new() };
    let figure = Figure {
        width: side("width", DEFAULT_SIZE[0])?,
        height: side("height", DEFAULT_SIZE[1])?,
        title,
        columns: options.count("columns", 1, 100)?.unwrap_or(panels.len() as u64) as usize,
        panels,
    };
    Ok(LuaFigure(Arc::new(figure)))
}

fn panel_of_list((number, value): (usize, Value)) -> mlua::Result<Panel> {
    let keys = panel_keys(&value);
    panel(&Options::new(&format!("figure: panel {number}"), value, keys)?)
}

/// The keys of the kind of panel that a table describes: a picture, segments, or else a chart.
fn panel_keys(value: &Value) -> &'static [&'static str] {
    let has = |key: &str| {
        value.as_table().is_some_and(|t| t.raw_get::<Value>(key).is_ok_and(|v| !v.is_nil()))
    };
    if has("image") {
        &IMAGE_KEYS
    } else if has("segments") {
        &SEGMENTS_KEYS
    } else {
        &CHART_KEYS
    }
}

fn panel(options: &Options) -> mlua::Result<Panel> {
    if options.has("image")? {
        picture(options).map(Panel::Raster)
    } else if options.has("segments")? {
        segments(options).map(Panel::Segments)
    } else {
        chart(options).map(Panel::Chart)
    }
}

fn title(options: &Options) -> mlua::Result<String> {
    Ok(options.text("title")?.unwrap_or_default())
}

fn chart(options: &Options) -> mlua::Result<Chart> {
    let list = options.required_list("series", "a list of {points =, name =, style =}")?;
    Ok(Chart {
        title: title(options)?,
        x: axis(options, "x")?,
        y: axis(options, "y")?,
        series: (1..).zip(list).map(|s| series(options, s)).collect::<mlua::Result<_>>()?,
    })
}

/// `{label =, log = false, range = {from, to}}`.
fn axis(options: &Options, key: &str) -> mlua::Result<Axis> {
    let object = format!("{}: {key}", options.object());
    let axis = Options::new(&object, options.value(key)?, &["label", "log", "range"])?;
    Ok(Axis {
        label: axis.text("label")?.unwrap_or_default(),
        scale: scale(&axis, Scale::Linear)?,
        range: range(&axis)?,
    })
}

fn scale(options: &Options, default: Scale) -> mlua::Result<Scale> {
    let is_log = options.flag("log", default == Scale::Log)?;
    Ok(if is_log { Scale::Log } else { Scale::Linear })
}

fn range(options: &Options) -> mlua::Result<Option<[f64; 2]>> {
    match options.value("range")? {
        Value::Nil => Ok(None),
        value => {
            let what = "\"range\"";
            numbers(options.object(), what, &value, Range::ANY).map(Some)
        }
    }
}

/// A list of N numbers.
pub(super) fn numbers<const N: usize>(
    object: &str,
    what: &str,
    value: &Value,
    range: Range,
) -> mlua::Result<[f64; N]> {
    let list = options::list(object, what, value, &format!("a list of {N} numbers"))?;
    let entries: Vec<f64> = list
        .iter()
        .map(|entry| options::number(object, what, entry, range))
        .collect::<mlua::Result<_>>()?;
    <[f64; N]>::try_from(entries).map_err(|entries| {
        let problem = format!("{what} has {} entries, expected {N} numbers", entries.len());
        Error::inconsistent(object, problem).into()
    })
}

fn series(options: &Options, (number, value): (usize, Value)) -> mlua::Result<Series> {
    let object = format!("{}: series {number}", options.object());
    let series = Options::new(&object, value, &["color", "errors", "name", "points", "style"])?;
    let points = series.required_list("points", "a list of {x, y}")?;
    let points = (1..).zip(&points).map(|(row, value)| point(&object, row, value));
    let styles = [
        ("line", Marks::Line),
        ("dashes", Marks::Dashes),
        ("points", Marks::Points),
        ("both", Marks::LineAndPoints),
    ];
    let errors = series.list("errors", "a list of numbers")?.map(|list| {
        let error = |value: &Value| options::number(&object, "\"errors\"", value, Range::ANY);
        list.iter().map(error).collect::<mlua::Result<Vec<f64>>>()
    });
    let color = match series.value("color")? {
        Value::Nil => None,
        value => Some(numbers(&object, "\"color\"", &value, Range::new(0.0, 255.0, ""))?),
    };
    Ok(Series {
        name: series.text("name")?.unwrap_or_default(),
        marks: series.choice("style", &styles)?.unwrap_or(Marks::Line),
        points: points.collect::<mlua::Result<_>>()?,
        errors: errors.transpose()?,
        color: color.map(|rgb: [f64; 3]| rgb.map(|part| part as u8)),
    })
}

/// `{x, y}`, or `{}` where a line is to be parted.
fn point(object: &str, row: usize, value: &Value) -> mlua::Result<[f64; 2]> {
    if value.as_table().is_some_and(|table| table.raw_len() == 0) {
        return Ok([f64::NAN; 2]);
    }
    numbers(object, &format!("\"points\" row {row}"), value, Range::ANY)
}

fn segments(options: &Options) -> mlua::Result<SegmentsPanel> {
    const EXPECTED: &str = "a list of {{x, y, z}, {x, y, z}}";
    let object = options.object();
    let segment = |(row, value): (usize, &Value)| -> mlua::Result<[[f64; 3]; 2]> {
        let what = format!("\"segments\" row {row}");
        let ends = options::list(object, &what, value, "{{x, y, z}, {x, y, z}}")?;
        let [from, to] = ends.as_slice() else {
            let problem = format!("{what} has {} ends, expected 2", ends.len());
            return Err(Error::inconsistent(object, problem).into());
        };
        let end = |value| options::vector(object, &what, value).map(|end| end.to_array());
        Ok([end(from)?, end(to)?])
    };
    let list = options.required_list("segments", EXPECTED)?;
    Ok(SegmentsPanel {
        title: title(options)?,
        segments: (1..).zip(&list).map(segment).collect::<mlua::Result<_>>()?,
        azimuth_deg: options.number_or("azimuth", Range::ANY, 30.0)?,
        elevation_deg: options.number_or("elevation", Range::ANY, 20.0)?,
    })
}

/// An image as sRGB shows it, or its luminance in false colors; a part of it with `crop`.
fn picture(options: &Options) -> mlua::Result<RasterPanel> {
    let image: LuaImage = options.required_handle("image", "an image")?;
    let panel = match false_colors(options, &image)? {
        Some(colors) => false_color(&image.xyz_image(), &colors)?,
        None => {
            // A figure is an sRGB picture.
            let look = Look { display: Display::srgb(), ..image::look(options)? };
            let shown = look.develop(image.spectral())?.picture;
            let pixels = shown.digits.iter().map(|digits| digits.map(|digit| digit as u8));
            RasterPanel {
                title: String::new(),
                width: shown.width,
                height: shown.height,
                pixels: pixels.collect(),
                scale_bar: None,
            }
        }
    };
    let panel = RasterPanel { title: title(options)?, ..panel };
    if !options.has("crop")? {
        return Ok(panel);
    }
    let object = format!("{}: crop", options.object());
    let region = Options::new(&object, options.value("crop")?, &image::REGION_KEYS)?;
    Ok(cropped(panel, image.region(region)?)?)
}

/// `true`, or `{log = true, range =, label =}`.
fn false_colors(options: &Options, image: &LuaImage) -> mlua::Result<Option<FalseColor>> {
    let value = match options.value("false_color")? {
        Value::Nil | Value::Boolean(false) => return Ok(None),
        Value::Boolean(true) => Value::Nil,
        value => value,
    };
    let object = format!("{}: false_color", options.object());
    colors(&Options::new(&object, value, &FALSE_COLOR_KEYS)?, image).map(Some)
}

fn colors(options: &Options, image: &LuaImage) -> mlua::Result<FalseColor> {
    let default = FalseColor::default();
    let label = match image.photometry() {
        Photometry::Absolute => default.label,
        Photometry::Relative => "luminance (relative)".to_owned(),
    };
    Ok(FalseColor {
        scale: scale(options, default.scale)?,
        range: range(options)?,
        label: options.text("label")?.unwrap_or(label),
    })
}

fn cropped(panel: RasterPanel, region: Region) -> crate::Result<RasterPanel> {
    region.check(panel.width, panel.height)?;
    let pixels = region.pixels().map(|(x, y)| panel.pixels[y * panel.width + x]).collect();
    Ok(RasterPanel { width: region.width, height: region.height, pixels, ..panel })
}

impl UserData for LuaFigure {
    fn add_methods<M: UserDataMethods<Self>>(methods: &mut M) {
        fault::method(methods, "save", |lua, this: &Self, a| {
            let path = Arguments::new("figure:save", a, 1)?.text("path")?;
            let target = host::of(lua)?.output(&path)?;
            match target.extension().and_then(|e| e.to_str()) {
                Some("png") => Ok(crate::program::figure::write_figure_png(&target, &this.0)?),
                Some("svg") => Ok(crate::program::figure::write_figure_svg(&target, &this.0)?),
                _ => {
                    let found = format!("\"{path}\"");
                    let allowed = "names ending in .png or .svg";
                    Err(Error::out_of_range("figure:save", "path", found, allowed).into())
                }
            }
        });
        fault::method(methods, "svg", |_, this: &Self, _| {
            Ok(crate::program::figure::figure_svg(&this.0)?)
        });
        methods.add_meta_method(MetaMethod::ToString, |_, this, ()| {
            let Figure { width, height, panels, .. } = this.0.as_ref();
            Ok(format!("figure: {width} × {height}, {} panels", panels.len()))
        });
        fault::refuse_unknown_fields(methods, "figure", &NAMES);
    }
}
