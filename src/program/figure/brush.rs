//! Lines and words on a drawing area, the same for both kinds of file.

use std::sync::LazyLock;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontTransform, register_font};

use crate::error::{Error, Result};

const FONT: &[u8] = include_bytes!("../../../data/fonts/DejaVuSans.ttf");
const FAMILY: &str = "sans-serif";

/// Whether the crate could read the font, which is embedded.
static FONT_IS_READY: LazyLock<bool> =
    LazyLock::new(|| register_font(FAMILY, FontStyle::Normal, FONT).is_ok());

/// Font size of numbers, pixels.
pub const SMALL: u32 = 16;
/// Font size of labels, pixels.
pub const MEDIUM: u32 = 18;
/// Font size of titles, pixels.
pub const LARGE: u32 = 22;

/// Where words stand relative to their point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// Their foot is at the point.
    Above,
    /// Their top is at the point.
    Below,
    /// They end at the point.
    LeftOf,
    /// They begin at the point.
    RightOf,
    /// The point is in their middle.
    Middle,
}

/// Draws in pixels from the upper left corner of the figure.
pub struct Brush<'a, DB: DrawingBackend> {
    area: &'a DrawingArea<DB, Shift>,
}

/// Pixels to the right and down.
pub type Point = [f64; 2];

impl<'a, DB: DrawingBackend> Brush<'a, DB> {
    /// Errors: [`Error::Inconsistent`] if the font or the area cannot be used.
    pub fn new(area: &'a DrawingArea<DB, Shift>) -> Result<Self> {
        if !*FONT_IS_READY {
            return Err(Error::inconsistent("figure", "its font does not read"));
        }
        area.fill(&WHITE).map_err(failed)?;
        Ok(Self { area })
    }

    /// Straight lines from point to point.
    pub fn polyline(&self, points: &[Point], color: [u8; 3], width: u32) -> Result<()> {
        let style = rgb(color).stroke_width(width);
        let points: Vec<(i32, i32)> = points.iter().map(|&p| pixel(p)).collect();
        self.area.draw(&PathElement::new(points, style)).map_err(failed)
    }

    /// A filled circle.
    pub fn dot(&self, at: Point, color: [u8; 3], radius: u32) -> Result<()> {
        self.area.draw(&Circle::new(pixel(at), radius, rgb(color).filled())).map_err(failed)
    }

    /// A filled rectangle.
    pub fn fill(&self, from: Point, to: Point, color: [u8; 3]) -> Result<()> {
        let corners = [pixel(from), pixel(to)];
        self.area.draw(&Rectangle::new(corners, rgb(color).filled())).map_err(failed)
    }

    /// A rectangle's outline.
    pub fn frame(&self, from: Point, to: Point, color: [u8; 3]) -> Result<()> {
        let corners = [from, [to[0], from[1]], to, [from[0], to[1]], from];
        self.polyline(&corners, color, 1)
    }

    /// Words in black.
    pub fn words(&self, text: &str, at: Point, anchor: Anchor, size: u32) -> Result<()> {
        self.colored_words(text, at, anchor, size, [0; 3])
    }

    /// Words in a color.
    pub fn colored_words(
        &self,
        text: &str,
        at: Point,
        anchor: Anchor,
        size: u32,
        color: [u8; 3],
    ) -> Result<()> {
        let (h, v) = match anchor {
            Anchor::Above => (HPos::Center, VPos::Bottom),
            Anchor::Below => (HPos::Center, VPos::Top),
            Anchor::LeftOf => (HPos::Right, VPos::Center),
            Anchor::RightOf => (HPos::Left, VPos::Center),
            Anchor::Middle => (HPos::Center, VPos::Center),
        };
        let font = (FAMILY, size).into_font();
        let style = font.color(&rgb(color)).pos(Pos::new(h, v));
        self.area.draw(&Text::new(text, pixel(at), style)).map_err(failed)
    }

    /// Words that run upward, centered on their point.
    pub fn words_upward(&self, text: &str, at: Point, size: u32) -> Result<()> {
        let font = (FAMILY, size).into_font().transform(FontTransform::Rotate270);
        let style = font.color(&BLACK).pos(Pos::new(HPos::Center, VPos::Top));
        self.area.draw(&Text::new(text, pixel(at), style)).map_err(failed)
    }
}

/// Width of words in pixels, by the embedded font.
pub fn width_of(text: &str, size: u32) -> f64 {
    let measured = (FAMILY, size).into_font().box_size(text);
    measured.map_or(0.6 * f64::from(size) * text.chars().count() as f64, |(w, _)| f64::from(w))
}

fn rgb([r, g, b]: [u8; 3]) -> RGBColor {
    RGBColor(r, g, b)
}

fn pixel([x, y]: Point) -> (i32, i32) {
    // Saturating: a point far outside stays outside.
    (x.round() as i32, y.round() as i32)
}

fn failed<E: std::fmt::Debug>(error: E) -> Error {
    Error::inconsistent("figure", format!("cannot be drawn: {error:?}"))
}
