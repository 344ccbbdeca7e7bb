//! `lampyris.figure`.

use std::sync::Arc;

use mlua::{Lua, Table, UserData, UserDataRegistry, Value};

use super::host;
use super::image::{LuaImage, RegionOptions};
use super::kinds::{
    Choice, Count, Custom, Flag, Handle, Kind, List, Naming, Nested, Number, Numbers, Or, Text,
    any, nested, numbers,
};
use super::look::{LOOK, RenditionOptions};
use super::members::{Functions, Members};
use super::options::{self, Arguments, Options, Range};
use super::record::{Record, options};
use crate::color::Photometry;
use crate::display::{Display, Look};
use crate::error::Error;
use crate::geometry::DVec3;
use crate::image::Region;
use crate::program::figure::{
    self, Chart, ChartAxis, FalseColor, Figure, Marks, Panel, RasterPanel, Scale, SegmentMarks,
    Series, false_color,
};

/// Handle of a figure.
#[derive(Debug, Clone)]
pub struct LuaFigure(Arc<Figure>);

/// Pixels a side.
const MAX_SIDE: u64 = 16_384;

pub(super) fn register(lua: &Lua, module: &Table) -> mlua::Result<()> {
    Functions::of_module(lua, module).add("figure", 1, |_, a| new(a))
}

impl LuaFigure {
    /// One panel at the size that [`new`] gives where a script asks for none.
    pub(super) fn of_panel(panel: Panel) -> Self {
        Self::of_panels(vec![panel])
    }

    /// Panels side by side.
    pub(super) fn of_panels(panels: Vec<Panel>) -> Self {
        Self(Arc::new(Figure {
            width: Figure::DEFAULT_SIZE[0],
            height: Figure::DEFAULT_SIZE[1] / panels.len().max(1) as u32,
            title: String::new(),
            columns: panels.len(),
            panels,
        }))
    }
}

/// The luminance of an image in false colors.
pub(super) fn false_color_figure(
    image: &LuaImage,
    given: FalseColorOptions,
) -> mlua::Result<LuaFigure> {
    let panel = false_color(&image.xyz_image(), &given.colors(image))?;
    Ok(LuaFigure::of_panel(Panel::Raster(panel)))
}

options! {
    struct FigureOptions {
        /// instead of the keys of one panel
        panels: Option<Vec<Value>> = List {
            entry: any("ChartPanel|PicturePanel|SegmentsPanel"),
            expected: "a list of panels",
            naming: Naming::Key,
        }.optional(""),
        /// of panels
        columns: Option<usize> = Count::new(1, 100).optional("all in one row"),
        width: u32 = Count::new(1, MAX_SIDE).of("pixels").or(Figure::DEFAULT_SIZE[0]),
        height: u32 = Count::new(1, MAX_SIDE).of("pixels").or(Figure::DEFAULT_SIZE[1]),
        title: String = title(),
    }
}

fn title() -> Or<Text> {
    Text("a title").or(String::new())
}

/// `panels` in a grid, or the keys of one panel beside those of the figure.
fn new(mut arguments: Arguments) -> mlua::Result<LuaFigure> {
    let value = arguments.value();
    let kind = Kinds::of(&value);
    let has_panels = has(&value, "panels");
    let own = if has_panels { Vec::new() } else { kind.keys() };
    let mut keys = [FigureOptions::keys(), own].concat();
    keys.sort_unstable();
    keys.dedup();
    let options = Options::new("figure", value, &keys)?;
    let given = FigureOptions::from_options(&options)?;
    let panels = match given.panels {
        None => vec![kind.panel(&options)?],
        Some(list) => (1..).zip(list).map(panel_of_list).collect::<mlua::Result<_>>()?,
    };
    let figure = Figure {
        width: given.width,
        height: given.height,
        // A single panel carries the title itself.
        title: if has_panels { given.title } else { String::new() },
        columns: given.columns.unwrap_or(panels.len()),
        panels,
    };
    Ok(LuaFigure(Arc::new(figure)))
}

fn has(value: &Value, key: &str) -> bool {
    value.as_table().is_some_and(|t| t.raw_get::<Value>(key).is_ok_and(|v| !v.is_nil()))
}

fn panel_of_list((number, value): (usize, Value)) -> mlua::Result<Panel> {
    let kind = Kinds::of(&value);
    kind.panel(&Options::new(&format!("figure: panel {number}"), value, &kind.keys())?)
}

/// What a panel may show.
#[derive(Clone, Copy)]
enum Kinds {
    Picture,
    Segments,
    Chart,
}

impl Kinds {
    /// Kind of panel that a table describes: a picture, segments, or else a chart.
    fn of(value: &Value) -> Self {
        if has(value, "image") {
            Self::Picture
        } else if has(value, "segments") {
            Self::Segments
        } else {
            Self::Chart
        }
    }

    fn keys(self) -> Vec<&'static str> {
        match self {
            Self::Picture => PicturePanel::keys(),
            Self::Segments => SegmentsPanel::keys(),
            Self::Chart => ChartPanel::keys(),
        }
    }

    fn panel(self, options: &Options) -> mlua::Result<Panel> {
        match self {
            Self::Picture => picture(options).map(Panel::Raster),
            Self::Segments => segments(options).map(Panel::Segments),
            Self::Chart => chart(options).map(Panel::Chart),
        }
    }
}

options! {
    struct ChartPanel {
        series: Vec<Value> = List {
            entry: any("FigureSeries"),
            expected: "a list of {points =, name =, style =}",
            naming: Naming::Key,
        },
        x: FigureAxis = Nested::new(),
        y: FigureAxis = Nested::new(),
        title: String = title(),
    }
}

options! {
    struct FigureAxis {
        /// with its unit
        label: String = Text("a label").or(String::new()),
        log: bool = Flag.or(false),
        range: Option<[f64; 2]> = ENDS.optional("what the series need"),
    }
}

/// Ends of an axis or a scale.
const ENDS: Numbers<2> = Numbers { range: Range::ANY, expected: "a list of 2 numbers" };

fn chart(options: &Options) -> mlua::Result<Chart> {
    let given = ChartPanel::from_options(options)?;
    let object = options.object();
    Ok(Chart {
        title: given.title,
        x: given.x.axis(),
        y: given.y.axis(),
        series: (1..).zip(given.series).map(|s| series(object, s)).collect::<mlua::Result<_>>()?,
    })
}

impl FigureAxis {
    fn axis(self) -> ChartAxis {
        ChartAxis { label: self.label, scale: scale(self.log), range: self.range }
    }
}

fn scale(is_log: bool) -> Scale {
    if is_log { Scale::Log } else { Scale::Linear }
}

options! {
    struct FigureSeries {
        /// {{x, y}, …}; {} parts a line
        points: Vec<[f64; 2]> = List {
            entry: POINT,
            expected: "a list of {x, y}",
            naming: Naming::Row,
        },
        /// for the legend
        name: String = Text("a name").or(String::new()),
        style: Marks = Choice(&[
            ("line", Marks::Line),
            ("dashes", Marks::Dashes),
            ("points", Marks::Points),
            ("both", Marks::LineAndPoints),
        ]).or(Marks::Line),
        /// half lengths of error bars, one for each point
        errors: Option<Vec<f64>> = numbers(Range::ANY).optional(""),
        /// {red, green, blue}
        color: Option<[f64; 3]> = Numbers {
            range: Range::new(0.0, 255.0, ""),
            expected: "a list of 3 numbers",
        }.optional(""),
    }
}

fn series(object: &str, (number, value): (usize, Value)) -> mlua::Result<Series> {
    let FigureSeries { points, name, style, errors, color } =
        Record::read(&format!("{object}: series {number}"), value)?;
    let color = color.map(|rgb| rgb.map(|part| part as u8));
    Ok(Series { name, marks: style, points, errors, color })
}

/// `{x, y}`, or `{}` where a line is to be parted.
const POINT: Custom<[f64; 2]> = Custom {
    lua_type: "number[]",
    allowed: "",
    read: |object, what, value| {
        if value.as_table().is_some_and(|table| table.raw_len() == 0) {
            return Ok([f64::NAN; 2]);
        }
        ENDS.read(object, what, value)
    },
    shown: |_| String::new(),
};

options! {
    struct SegmentsPanel {
        /// {{from, to}, …}, mm
        segments: Vec<[DVec3; 2]> = List {
            entry: SEGMENT,
            expected: "a list of {{x, y, z}, {x, y, z}}",
            naming: Naming::Row,
        },
        /// green dots where segments start, white lines on dark ground
        dots: bool = Flag.or(false),
        /// degrees
        azimuth: f64 = Number(Range::ANY).or(30.0),
        /// degrees
        elevation: f64 = Number(Range::ANY).or(20.0),
        title: String = title(),
    }
}

const SEGMENT: Custom<[DVec3; 2]> =
    Custom { lua_type: "vector[]", allowed: "", read: segment, shown: |_| String::new() };

fn segment(object: &str, what: &str, value: &Value) -> mlua::Result<[DVec3; 2]> {
    let end = |_, value: &Value| options::vector(object, what, value);
    let ends = options::each(object, what, value, "{{x, y, z}, {x, y, z}}", end)?;
    <[DVec3; 2]>::try_from(ends).map_err(|ends| {
        let problem = format!("{what} has {} ends, expected 2", ends.len());
        Error::inconsistent(object, problem).into()
    })
}

fn segments(options: &Options) -> mlua::Result<figure::SegmentDrawing> {
    let SegmentsPanel { segments, dots, azimuth, elevation, title } =
        Record::from_options(options)?;
    Ok(figure::SegmentDrawing {
        title,
        segments: segments.iter().map(|ends| ends.map(|end| end.to_array())).collect(),
        marks: if dots { SegmentMarks::LinesAndDots } else { SegmentMarks::Lines },
        azimuth_deg: azimuth,
        elevation_deg: elevation,
    })
}

options! {
    struct PicturePanel {
        image: LuaImage = Handle::new("Image", "an image"),
        crop: Option<RegionOptions> = Nested::new().optional(""),
        /// instead of the picture: its luminance
        false_color: Option<FalseColorOptions> = FALSE_COLOR.or(None),
        title: String = title(),
        look: Look = LOOK.or(Look::paper()),
        ..rendition: RenditionOptions,
    }
}

options! {
    #[derive(Clone)]
    struct FalseColorOptions {
        log: bool = Flag.or(true),
        range: Option<[f64; 2]> = ENDS.optional("what the image needs"),
        /// of the scale bar
        label: Option<String> = Text("a label").optional("luminance, in cd/m² or relative as the scene is"),
    }
}

/// An image as sRGB shows it, or its luminance in false colors; a part of it with `crop`.
fn picture(options: &Options) -> mlua::Result<RasterPanel> {
    let given = PicturePanel::from_options(options)?;
    let panel = match &given.false_color {
        Some(colors) => false_color(&given.image.xyz_image(), &colors.colors(&given.image))?,
        // A figure is an sRGB picture.
        None => shown(
            &given.image,
            &Look { display: Display::srgb(), ..given.rendition.change(given.look) },
        )?,
    };
    let panel = RasterPanel { title: given.title, ..panel };
    match given.crop {
        None => Ok(panel),
        Some(crop) => Ok(cropped(panel, given.image.region(&crop))?),
    }
}

fn shown(image: &LuaImage, look: &Look) -> crate::Result<RasterPanel> {
    let shown = look.develop(image.spectral())?.picture;
    let pixels = shown.digits.iter().map(|digits| digits.map(|digit| digit as u8));
    Ok(RasterPanel {
        title: String::new(),
        width: shown.width,
        height: shown.height,
        pixels: pixels.collect(),
        scale_bar: None,
    })
}

/// `true`, or `{log = true, range =, label =}`.
const FALSE_COLOR: Custom<Option<FalseColorOptions>> = Custom {
    lua_type: "boolean|FalseColorOptions",
    allowed: "",
    read: |object, what, value| {
        let given = match value {
            Value::Boolean(false) => return Ok(None),
            Value::Boolean(true) => Value::Nil,
            value => value.clone(),
        };
        FalseColorOptions::read(&nested(object, what), given).map(Some)
    },
    shown: |_| "false".to_owned(),
};

impl FalseColorOptions {
    fn colors(&self, image: &LuaImage) -> FalseColor {
        let label = || match image.photometry() {
            Photometry::Absolute => FalseColor::default().label,
            Photometry::Relative => "luminance (relative)".to_owned(),
        };
        let label = self.label.clone().unwrap_or_else(label);
        FalseColor { scale: scale(self.log), range: self.range, label }
    }
}

fn cropped(panel: RasterPanel, region: Region) -> crate::Result<RasterPanel> {
    region.check(panel.width, panel.height)?;
    let pixels = region.pixels().map(|(x, y)| panel.pixels[y * panel.width + x]).collect();
    Ok(RasterPanel { width: region.width, height: region.height, pixels, ..panel })
}

impl UserData for LuaFigure {
    fn register(registry: &mut UserDataRegistry<Self>) {
        let mut members = Members::new(registry, "figure");
        members.method("save", 1, |lua, this, mut a| {
            let path = a.text("path")?;
            let target = host::of(lua)?.output(&path)?;
            match target.extension().and_then(|e| e.to_str()) {
                Some("png") => Ok(figure::write_figure_png(&target, &this.0)?),
                Some("svg") => Ok(figure::write_figure_svg(&target, &this.0)?),
                _ => {
                    let found = format!("\"{path}\"");
                    let allowed = "names ending in .png or .svg";
                    Err(Error::out_of_range("figure:save", "path", found, allowed).into())
                }
            }
        });
        members.method("svg", 0, |_, this, _| Ok(figure::figure_svg(&this.0)?));
        members.text(|this| {
            let Figure { width, height, panels, .. } = this.0.as_ref();
            Ok(format!("figure: {width} × {height}, {} panels", panels.len()))
        });
        members.no_others();
    }
}
