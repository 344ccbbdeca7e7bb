//! Figures as plain data, drawn alike to pixels and to SVG.

mod brush;
mod chart;
mod draw;
mod false_color;
mod file;
mod raster;
mod segments;
mod ticks;

pub use draw::{SvgFigure, to_pixels, to_svg, words};
pub use false_color::{FalseColor, false_color, scale_colors};
pub use file::{figure_svg, write_figure_png, write_figure_svg};
pub use raster::{PlacedRaster, Rect};

/// Panels in a grid.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Stands above; may be empty.
    pub title: String,
    /// Row by row.
    pub panels: Vec<Panel>,
    /// Panels a row, ≥ 1.
    pub columns: usize,
}

impl Figure {
    /// Width and height that a figure has unless it is told another, pixels.
    pub const DEFAULT_SIZE: [u32; 2] = [800, 600];

    /// One panel of [`Figure::DEFAULT_SIZE`] under no title but its own.
    pub fn new(panel: Panel) -> Self {
        let [width, height] = Self::DEFAULT_SIZE;
        Self { width, height, title: String::new(), panels: vec![panel], columns: 1 }
    }
}

/// What a figure consists of.
#[derive(Debug, Clone, PartialEq)]
pub enum Panel {
    /// Curves and points.
    Chart(Chart),
    /// A picture.
    Raster(RasterPanel),
    /// Lines in space.
    Segments(SegmentDrawing),
}

/// Curves and points over two axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// Stands above; may be empty.
    pub title: String,
    /// To the right.
    pub x: ChartAxis,
    /// Upward.
    pub y: ChartAxis,
    /// Drawn in their order.
    pub series: Vec<Series>,
}

/// What an axis shows.
#[derive(Debug, Clone, PartialEq)]
pub struct ChartAxis {
    /// With its unit.
    pub label: String,
    /// How values are spread.
    pub scale: Scale,
    /// `None` takes what the series need.
    pub range: Option<[f64; 2]>,
}

impl ChartAxis {
    /// An even axis as long as needed.
    pub fn linear(label: &str) -> Self {
        Self { label: label.to_owned(), scale: Scale::Linear, range: None }
    }

    /// A logarithmic axis as long as needed.
    pub fn log(label: &str) -> Self {
        Self { label: label.to_owned(), scale: Scale::Log, range: None }
    }
}

/// How values are spread along an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Scale {
    /// Evenly.
    #[default]
    Linear,
    /// Values ≤ 0 are left out.
    Log,
}

/// Values that are not finite part a line.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Stands in the legend unless empty.
    pub name: String,
    /// How points are drawn.
    pub marks: Marks,
    /// x and y.
    pub points: Vec<[f64; 2]>,
    /// Half lengths of vertical error bars, one a point.
    pub errors: Option<Vec<f64>>,
    /// `None` takes the next of [`COLORS`].
    pub color: Option<[u8; 3]>,
}

impl Series {
    /// A line through points, in the next color.
    pub fn line(name: &str, points: Vec<[f64; 2]>) -> Self {
        Self { name: name.to_owned(), marks: Marks::Line, points, errors: None, color: None }
    }

    /// Points alone, in the next color.
    pub fn scatter(name: &str, points: Vec<[f64; 2]>) -> Self {
        Self { marks: Marks::Points, ..Self::line(name, points) }
    }
}

/// How the points of a series are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Marks {
    /// A line.
    Line,
    /// A dashed line.
    Dashes,
    /// A dot each.
    Points,
    /// Both.
    LineAndPoints,
}

/// Okabe & Ito's colors, which remain apart for eyes that confuse red and green; yellow, which
/// is too light for lines, left out.
pub const COLORS: [[u8; 3]; 7] = [
    [0, 114, 178],
    [213, 94, 0],
    [0, 158, 115],
    [204, 121, 167],
    [230, 159, 0],
    [86, 180, 233],
    [0, 0, 0],
];

/// A picture, scaled into its panel with square pixels.
#[derive(Debug, Clone, PartialEq)]
pub struct RasterPanel {
    /// Stands above; may be empty.
    pub title: String,
    /// Pixels of a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// sRGB, row 0 on top.
    pub pixels: Vec<[u8; 3]>,
    /// Stands to the right.
    pub scale_bar: Option<ScaleBar>,
}

/// What the colors of a picture mean.
#[derive(Debug, Clone, PartialEq)]
pub struct ScaleBar {
    /// With its unit.
    pub label: String,
    /// How values are spread.
    pub scale: Scale,
    /// Values at both ends.
    pub range: [f64; 2],
    /// From the lower end of the range to the upper, evenly on its scale.
    pub colors: Vec<[u8; 3]>,
}

/// How segments are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SegmentMarks {
    /// Blue lines.
    #[default]
    Lines,
    /// White lines on dark ground with green dots at their starts, as the paper draws rays.
    LinesAndDots,
}

/// Segments in space, seen from afar in parallel projection.
#[derive(Debug, Clone, PartialEq)]
pub struct SegmentDrawing {
    /// Stands above; may be empty.
    pub title: String,
    /// Right-handed, +Y up, mm.
    pub segments: Vec<[[f64; 3]; 2]>,
    /// How each is drawn.
    pub marks: SegmentMarks,
    /// Where the eye is: turned about +Y from +Z, and lifted.
    pub azimuth_deg: f64,
    /// Lifts the eye toward +Y.
    pub elevation_deg: f64,
}
