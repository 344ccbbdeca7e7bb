//! Segments in space.

use plotters::prelude::DrawingBackend;

use super::brush::{Anchor, Brush, MEDIUM, SMALL};
use super::raster::Rect;
use super::{COLORS, SegmentDrawing, SegmentMarks};
use crate::error::Result;

/// Behind white lines.
const GROUND: [u8; 3] = [38, 42, 50];
/// Where a segment starts.
const START: [u8; 3] = [0, 210, 90];

/// Onto the plane across the line of sight: to the right, up.
fn project(panel: &SegmentDrawing, [x, y, z]: [f64; 3]) -> [f64; 2] {
    let (sin_a, cos_a) = panel.azimuth_deg.to_radians().sin_cos();
    let (sin_e, cos_e) = panel.elevation_deg.to_radians().sin_cos();
    let right = x * cos_a - z * sin_a;
    let toward = x * sin_a + z * cos_a;
    [right, y * cos_e - toward * sin_e]
}

/// Draws the segments as large as they fit, with the directions of the axes.
pub fn draw_segments<DB: DrawingBackend>(
    brush: &Brush<DB>,
    panel: &SegmentDrawing,
    rect: Rect,
) -> Result<()> {
    brush.words(&panel.title, [rect.center_x(), rect.y + 28.0], Anchor::Above, MEDIUM)?;
    let plot = rect.inset([12.0, 36.0, 12.0, 12.0]);
    let room = if panel.marks == SegmentMarks::LinesAndDots { 12.0 } else { 0.0 };
    let inner = plot.inset([room; 4]);
    let flat: Vec<[[f64; 2]; 2]> =
        panel.segments.iter().map(|ends| ends.map(|end| project(panel, end))).collect();
    let ends = || flat.iter().flatten().filter(|p| p.iter().all(|v| v.is_finite()));
    let bounds = |i: usize| {
        ends().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], p| {
            [low.min(p[i]), high.max(p[i])]
        })
    };
    let [[left, right], [low, high]] = [bounds(0), bounds(1)];
    // A millionth, lest a point divide by 0.
    let scale = (inner.width / (right - left).max(1e-6)).min(inner.height / (high - low).max(1e-6));
    let center = [0.5 * (left + right), 0.5 * (low + high)];
    let place = |[u, v]: [f64; 2]| {
        let middle = plot.y + 0.5 * plot.height;
        [plot.center_x() + scale * (u - center[0]), middle - scale * (v - center[1])]
    };
    let dots = panel.marks == SegmentMarks::LinesAndDots;
    if dots {
        brush.fill([plot.x, plot.y], [plot.right(), plot.bottom()], GROUND)?;
    }
    let finite = || flat.iter().filter(|ends| ends.iter().flatten().all(|v| v.is_finite()));
    for ends in finite() {
        brush.polyline(&ends.map(place), if dots { [255; 3] } else { COLORS[0] }, 1)?;
    }
    for [start, _] in finite().filter(|_| dots) {
        brush.dot(place(*start), START, 3)?;
    }
    let ink = if dots { [255; 3] } else { [0; 3] };
    draw_axes(brush, panel, [plot.x + 50.0, plot.bottom() - 50.0], ink)
}

/// The directions of x, y and z.
fn draw_axes<DB: DrawingBackend>(
    brush: &Brush<DB>,
    panel: &SegmentDrawing,
    origin: [f64; 2],
    ink: [u8; 3],
) -> Result<()> {
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let mut unit = [0.0; 3];
        unit[axis] = 1.0;
        let [u, v] = project(panel, unit);
        let at = |length: f64| [origin[0] + length * u, origin[1] - length * v];
        brush.polyline(&[origin, at(32.0)], ink, 2)?;
        brush.colored_words(name, at(44.0), Anchor::Middle, SMALL, ink)?;
    }
    Ok(())
}
