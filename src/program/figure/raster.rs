//! Pictures in panels, and what their colors mean.

use plotters::prelude::DrawingBackend;

use super::brush::{Anchor, Brush, MEDIUM, SMALL, width_of};
use super::ticks::ticks;
use super::{RasterPanel, Scale, ScaleBar};
use crate::error::{Error, Result};

/// Pixels of a figure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rect {
    /// Left edge.
    pub x: f64,
    /// Upper edge.
    pub y: f64,
    /// To the right edge.
    pub width: f64,
    /// To the lower edge.
    pub height: f64,
}

impl Rect {
    /// Without these many pixels at the left, top, right and bottom.
    pub fn inset(self, [left, top, right, bottom]: [f64; 4]) -> Self {
        Self {
            x: self.x + left,
            y: self.y + top,
            width: (self.width - left - right).max(1.0),
            height: (self.height - top - bottom).max(1.0),
        }
    }

    /// Right edge.
    pub fn right(self) -> f64 {
        self.x + self.width
    }

    /// Lower edge.
    pub fn bottom(self) -> f64 {
        self.y + self.height
    }

    /// Halfway from left to right.
    pub fn center_x(self) -> f64 {
        self.x + 0.5 * self.width
    }
}

/// A picture at its place in the figure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlacedRaster<'a> {
    /// What is shown.
    pub panel: &'a RasterPanel,
    /// Whole pixels.
    pub place: Rect,
}

impl PlacedRaster<'_> {
    /// Color of a pixel of the figure, counted from the place's corner: the mean of the picture's
    /// pixels that it covers, or the one in which it lies.
    pub fn color(&self, column: usize, row: usize) -> [u8; 3] {
        let span = |at: usize, pixels: usize, length: f64| {
            let scale = pixels as f64 / length;
            let first = ((at as f64 * scale) as usize).min(pixels - 1);
            let last = (((at + 1) as f64 * scale).ceil() as usize).clamp(first + 1, pixels);
            if scale > 1.0 { first..last } else { first..first + 1 }
        };
        let columns = span(column, self.panel.width, self.place.width);
        let rows = span(row, self.panel.height, self.place.height);
        let count = (columns.len() * rows.len()) as u32;
        let mut sum = [0u32; 3];
        for y in rows {
            for pixel in &self.panel.pixels[y * self.panel.width..][columns.clone()] {
                sum.iter_mut().zip(pixel).for_each(|(s, p)| *s += u32::from(*p));
            }
        }
        sum.map(|s| ((s + count / 2) / count) as u8)
    }
}

/// Draws all but the picture, and says where that goes.
pub fn draw_raster<'a, DB: DrawingBackend>(
    brush: &Brush<DB>,
    panel: &'a RasterPanel,
    rect: Rect,
) -> Result<PlacedRaster<'a>> {
    if panel.pixels.len() != panel.width * panel.height || panel.pixels.is_empty() {
        let (pixels, width, height) = (panel.pixels.len(), panel.width, panel.height);
        let problem = format!("has {pixels} pixels, expected {width} × {height}, at least one");
        return Err(Error::inconsistent("figure: picture", problem));
    }
    let bar_width = panel.scale_bar.as_ref().map_or(0.0, |_| BAR_ROOM);
    let inner = rect.inset([8.0, 34.0, 8.0 + bar_width, 8.0]);
    let scale = (inner.width / panel.width as f64).min(inner.height / panel.height as f64);
    let size = |pixels: usize| (pixels as f64 * scale).floor().max(1.0);
    let (width, height) = (size(panel.width), size(panel.height));
    let x = (inner.center_x() - 0.5 * width).floor();
    let place = Rect { x, y: inner.y.floor(), width, height };
    brush.words(&panel.title, [rect.center_x(), rect.y + 28.0], Anchor::Above, MEDIUM)?;
    if let Some(bar) = &panel.scale_bar {
        let bar_rect = Rect { x: place.right() + 12.0, width: 22.0, ..place };
        draw_bar(brush, bar, bar_rect)?;
    }
    Ok(PlacedRaster { panel, place })
}

/// Pixels that a bar, its marks and its label take.
const BAR_ROOM: f64 = 130.0;

fn draw_bar<DB: DrawingBackend>(brush: &Brush<DB>, bar: &ScaleBar, rect: Rect) -> Result<()> {
    let [low, high] = bar.range;
    let positive = bar.scale == Scale::Linear || low > 0.0;
    if bar.colors.is_empty() || !(low < high && low.is_finite() && high.is_finite() && positive) {
        let problem = format!("range is {low} to {high}, allowed: ascending, above 0 if log");
        return Err(Error::inconsistent("figure: scale bar", problem));
    }
    let count = bar.colors.len() as f64;
    let y_at = |share: f64| rect.bottom() - share * rect.height;
    for (i, &color) in bar.colors.iter().enumerate() {
        let (lower, upper) = (y_at(i as f64 / count), y_at((i + 1) as f64 / count));
        brush.fill([rect.x, upper], [rect.right(), lower], color)?;
    }
    brush.frame([rect.x, rect.y], [rect.right(), rect.bottom()], [0; 3])?;
    let mut widest = 0f64;
    for tick in ticks(bar.scale, bar.range, 6) {
        let share = match bar.scale {
            Scale::Linear => (tick.value - low) / (high - low),
            Scale::Log => (tick.value / low).ln() / (high / low).ln(),
        };
        let length = if tick.label.is_empty() { 3.0 } else { 6.0 };
        let from = [rect.right(), y_at(share)];
        brush.polyline(&[from, [from[0] + length, from[1]]], [0; 3], 1)?;
        brush.words(&tick.label, [from[0] + 10.0, from[1]], Anchor::RightOf, SMALL)?;
        widest = widest.max(width_of(&tick.label, SMALL));
    }
    let label_x = rect.right() + 16.0 + widest;
    brush.words_upward(&bar.label, [label_x, rect.y + 0.5 * rect.height], SMALL)
}
