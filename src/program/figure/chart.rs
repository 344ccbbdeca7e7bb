//! Curves and points over two axes.

use plotters::prelude::DrawingBackend;

use super::brush::{Anchor, Brush, MEDIUM, Point, SMALL, width_of};
use super::raster::Rect;
use super::ticks::{Tick, ticks};
use super::{COLORS, Chart, ChartAxis, Marks, Scale, Series};
use crate::error::{Error, Result};

const BLACK: [u8; 3] = [0; 3];
const GRID: [u8; 3] = [225; 3];

/// From an axis to pixels.
struct Ruler {
    scale: Scale,
    /// Ends of the axis, after its scale.
    range: [f64; 2],
    /// Ends of the axis in the figure.
    pixels: [f64; 2],
}

impl Ruler {
    /// `None` for what the scale cannot show.
    fn place(&self, value: f64) -> Option<f64> {
        let scaled = scaled(self.scale, value)?;
        let share = (scaled - self.range[0]) / (self.range[1] - self.range[0]);
        Some(self.pixels[0] + share * (self.pixels[1] - self.pixels[0]))
    }
}

fn scaled(scale: Scale, value: f64) -> Option<f64> {
    let scaled = match scale {
        Scale::Linear => value,
        Scale::Log if value > 0.0 => value.log10(),
        Scale::Log => return None,
    };
    scaled.is_finite().then_some(scaled)
}

/// The axis's own range, or that of `values` with a little room, after the scale.
fn range_of(axis: &ChartAxis, values: impl Iterator<Item = f64>) -> Result<[f64; 2]> {
    let shown = values.filter_map(|value| scaled(axis.scale, value));
    let given = axis.range.map(|range| range.map(|value| scaled(axis.scale, value)));
    match given {
        Some([Some(from), Some(to)]) if from < to => Ok([from, to]),
        Some(_) => {
            let problem = format!("range is {:?}, allowed: ascending, above 0 if log", axis.range);
            Err(Error::inconsistent(&format!("figure: axis \"{}\"", axis.label), problem))
        }
        None => {
            let bounds = shown.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
                [low.min(value), high.max(value)]
            });
            Ok(with_room(bounds))
        }
    }
}

fn with_room([low, high]: [f64; 2]) -> [f64; 2] {
    if low > high {
        return [0.0, 1.0];
    }
    let room = if high > low { 0.04 * (high - low) } else { 0.5 * high.abs().max(1.0) };
    [low - room, high + room]
}

/// Draws axes, series and legend; errors for a range that does not ascend.
pub fn draw_chart<DB: DrawingBackend>(brush: &Brush<DB>, chart: &Chart, rect: Rect) -> Result<()> {
    let points = || chart.series.iter().flat_map(|series| &series.points);
    let x_range = range_of(&chart.x, points().map(|p| p[0]))?;
    let y_range = range_of(&chart.y, points().map(|p| p[1]))?;
    let y_ticks = ticks(chart.y.scale, unscaled(chart.y.scale, y_range), 6);
    let widest = y_ticks.iter().map(|tick| width_of(&tick.label, SMALL)).fold(0.0, f64::max);
    let plot = rect.inset([widest + 46.0, 36.0, 18.0, 58.0]);
    let x = Ruler { scale: chart.x.scale, range: x_range, pixels: [plot.x, plot.right()] };
    let y = Ruler { scale: chart.y.scale, range: y_range, pixels: [plot.bottom(), plot.y] };
    let count = (plot.width / 70.0) as usize;
    let x_ticks = ticks(x.scale, unscaled(x.scale, x_range), count);
    let upright = |x| ([[x, plot.y], [x, plot.bottom()]], [x, plot.bottom() + 8.0]);
    draw_axis(brush, &x, &x_ticks, upright, Anchor::Below)?;
    let level = |y| ([[plot.x, y], [plot.right(), y]], [plot.x - 8.0, y]);
    draw_axis(brush, &y, &y_ticks, level, Anchor::LeftOf)?;
    let mut colors = COLORS.into_iter().cycle();
    let mut legend = Vec::new();
    for series in &chart.series {
        let color = series.color.or_else(|| colors.next()).unwrap_or(BLACK);
        draw_series(brush, series, color, [&x, &y])?;
        legend.push((series, color));
    }
    brush.frame([plot.x, plot.y], [plot.right(), plot.bottom()], BLACK)?;
    let placed = points().filter_map(|p| Some([x.place(p[0])?, y.place(p[1])?]));
    draw_legend(brush, &legend, plot, &placed.collect::<Vec<_>>())?;
    brush.words(&chart.title, [plot.center_x(), plot.y - 8.0], Anchor::Above, MEDIUM)?;
    let below = [plot.center_x(), plot.bottom() + 32.0];
    brush.words(&chart.x.label, below, Anchor::Below, MEDIUM)?;
    brush.words_upward(&chart.y.label, [rect.x + 6.0, plot.y + 0.5 * plot.height], MEDIUM)
}

fn unscaled(scale: Scale, range: [f64; 2]) -> [f64; 2] {
    match scale {
        Scale::Linear => range,
        Scale::Log => range.map(|value| 10f64.powf(value)),
    }
}

/// Grid lines at the marks, with their labels; `line_and_label` says where those of a place along
/// the ruler are.
fn draw_axis<DB: DrawingBackend>(
    brush: &Brush<DB>,
    ruler: &Ruler,
    marks: &[Tick],
    line_and_label: impl Fn(f64) -> ([Point; 2], Point),
    anchor: Anchor,
) -> Result<()> {
    for tick in marks {
        let Some(place) = ruler.place(tick.value) else { continue };
        let (line, label) = line_and_label(place);
        brush.polyline(&line, GRID, 1)?;
        brush.words(&tick.label, label, anchor, SMALL)?;
    }
    Ok(())
}

fn draw_series<DB: DrawingBackend>(
    brush: &Brush<DB>,
    series: &Series,
    color: [u8; 3],
    [x, y]: [&Ruler; 2],
) -> Result<()> {
    let place = |[px, py]: [f64; 2]| Some([x.place(px)?, y.place(py)?]);
    let clip = Rect {
        x: x.pixels[0],
        y: y.pixels[1],
        width: x.pixels[1] - x.pixels[0],
        height: y.pixels[0] - y.pixels[1],
    };
    let places: Vec<Option<Point>> = series.points.iter().map(|&p| place(p)).collect();
    if series.marks != Marks::Points {
        draw_line(brush, &places, series.marks, color, clip)?;
    }
    if matches!(series.marks, Marks::Points | Marks::LineAndPoints) {
        for &center in places.iter().flatten().filter(|p| contains(clip, **p)) {
            brush.dot(center, color, 4)?;
        }
    }
    for (point, error) in series.points.iter().zip(series.errors.iter().flatten()) {
        let ends = [-error, *error].map(|offset| place([point[0], point[1] + offset]));
        if let [Some(from), Some(to)] = ends
            && let Some(bar) = clipped(from, to, clip)
        {
            brush.polyline(&bar, color, 1)?;
        }
    }
    Ok(())
}

fn contains(rect: Rect, [x, y]: Point) -> bool {
    (rect.x..=rect.right()).contains(&x) && (rect.y..=rect.bottom()).contains(&y)
}

/// Dashes and gaps in pixels.
const DASH: f64 = 9.0;

fn draw_line<DB: DrawingBackend>(
    brush: &Brush<DB>,
    places: &[Option<Point>],
    marks: Marks,
    color: [u8; 3],
    clip: Rect,
) -> Result<()> {
    let mut walked = 0.0;
    let mut run: Vec<Point> = Vec::new();
    for pair in places.windows(2) {
        let [Some(from), Some(to)] = pair else { continue };
        if let Some(segment) = clipped(*from, *to, clip) {
            match marks {
                Marks::Dashes => draw_dashes(brush, segment, walked, color)?,
                _ => extend_run(brush, &mut run, segment, color)?,
            }
        }
        walked += (to[0] - from[0]).hypot(to[1] - from[1]);
    }
    brush.polyline(&run, color, 2)
}

/// Adds a segment to the run that it continues; draws a run that it does not.
fn extend_run<DB: DrawingBackend>(
    brush: &Brush<DB>,
    run: &mut Vec<Point>,
    [from, to]: [Point; 2],
    color: [u8; 3],
) -> Result<()> {
    if run.last() != Some(&from) {
        brush.polyline(run, color, 2)?;
        *run = vec![from];
    }
    run.push(to);
    Ok(())
}

fn draw_dashes<DB: DrawingBackend>(
    brush: &Brush<DB>,
    segment: [Point; 2],
    walked: f64,
    color: [u8; 3],
) -> Result<()> {
    dashes(segment, walked).iter().try_for_each(|dash| brush.polyline(dash, color, 2))
}

/// The drawn parts of a segment whose line has run for `walked` pixels.
fn dashes([from, to]: [Point; 2], walked: f64) -> Vec<[Point; 2]> {
    let length = (to[0] - from[0]).hypot(to[1] - from[1]);
    let at = |s: f64| [0, 1].map(|i| from[i] + (to[i] - from[i]) * (s / length).clamp(0.0, 1.0));
    let mut drawn = Vec::new();
    let mut start = -(walked.rem_euclid(2.0 * DASH));
    while start < length && length > 0.0 {
        if start + DASH > 0.0 {
            drawn.push([at(start), at(start + DASH)]);
        }
        start += 2.0 * DASH;
    }
    drawn
}

/// The part of a segment inside `clip` (Liang & Barsky).
fn clipped(from: Point, to: Point, clip: Rect) -> Option<[Point; 2]> {
    let (mut enter, mut leave) = (0.0f64, 1.0f64);
    let bounds = [[clip.x, clip.right()], [clip.y, clip.bottom()]];
    for (i, [low, high]) in bounds.into_iter().enumerate() {
        let d = to[i] - from[i];
        for (distance, step) in [(from[i] - low, -d), (high - from[i], d)] {
            if step == 0.0 && distance < 0.0 {
                return None;
            }
            if step > 0.0 {
                leave = leave.min(distance / step);
            } else if step < 0.0 {
                enter = enter.max(distance / step);
            }
        }
    }
    let at = |t: f64| [0, 1].map(|i| from[i] + t * (to[i] - from[i]));
    (enter <= leave).then(|| [at(enter), at(leave)])
}

fn draw_legend<DB: DrawingBackend>(
    brush: &Brush<DB>,
    series: &[(&Series, [u8; 3])],
    plot: Rect,
    points: &[Point],
) -> Result<()> {
    let named: Vec<_> = series.iter().filter(|(series, _)| !series.name.is_empty()).collect();
    let widest = named.iter().map(|(s, _)| width_of(&s.name, SMALL)).fold(0.0, f64::max);
    if named.is_empty() {
        return Ok(());
    }
    let line_height = 22.0;
    let size = [widest + 62.0, line_height * named.len() as f64 + 8.0];
    let place = emptiest_corner(plot, size, points);
    let (left, top) = (place.x, place.y);
    brush.fill([left, top], [place.right(), place.bottom()], [255; 3])?;
    brush.frame([left, top], [place.right(), place.bottom()], [160; 3])?;
    for (row, (series, color)) in named.into_iter().enumerate() {
        let y = top + 4.0 + line_height * (row as f64 + 0.5);
        let sample = [[left + 8.0, y], [left + 40.0, y]];
        match series.marks {
            Marks::Points => brush.dot([left + 24.0, y], *color, 4)?,
            Marks::Dashes => draw_dashes(brush, sample, 0.0, *color)?,
            Marks::Line => brush.polyline(&sample, *color, 2)?,
            Marks::LineAndPoints => {
                brush.polyline(&sample, *color, 2)?;
                brush.dot([left + 24.0, y], *color, 4)?;
            }
        }
        brush.words(&series.name, [left + 50.0, y], Anchor::RightOf, SMALL)?;
    }
    Ok(())
}

/// The corner of `plot` in which a box of `size` covers the fewest points; the upper right if
/// none is better.
fn emptiest_corner(plot: Rect, [width, height]: [f64; 2], points: &[Point]) -> Rect {
    let (left, right) = (plot.x + 8.0, plot.right() - width - 8.0);
    let (top, bottom) = (plot.y + 8.0, plot.bottom() - height - 8.0);
    let corners = [(right, top), (left, top), (right, bottom), (left, bottom)];
    let boxes = corners.map(|(x, y)| Rect { x, y, width, height });
    let covered = |corner: &Rect| points.iter().filter(|p| contains(*corner, **p)).count();
    boxes.into_iter().min_by_key(covered).unwrap_or(boxes[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOX: Rect = Rect { x: 0.0, y: 0.0, width: 100.0, height: 50.0 };

    #[test]
    fn segments_end_at_the_frame() {
        assert_eq!(clipped([-50.0, 25.0], [150.0, 25.0], BOX), Some([[0.0, 25.0], [100.0, 25.0]]));
        assert_eq!(clipped([10.0, 10.0], [10.0, 90.0], BOX), Some([[10.0, 10.0], [10.0, 50.0]]));
        assert_eq!(clipped([-5.0, 0.0], [-5.0, 50.0], BOX), None);
        assert_eq!(clipped([-10.0, 40.0], [10.0, 70.0], BOX), None);
    }

    #[test]
    fn dashes_go_on_from_segment_to_segment() {
        let drawn = dashes([[0.0, 0.0], [20.0, 0.0]], 0.0);
        assert_eq!(drawn, [[[0.0, 0.0], [9.0, 0.0]], [[18.0, 0.0], [20.0, 0.0]]]);
        let drawn = dashes([[0.0, 0.0], [20.0, 0.0]], 20.0);
        assert_eq!(drawn, [[[0.0, 0.0], [7.0, 0.0]], [[16.0, 0.0], [20.0, 0.0]]]);
    }

    #[test]
    fn the_legend_goes_where_no_points_are() {
        let points = [[80.0, 12.0], [80.0, 35.0]];
        let corner = emptiest_corner(BOX, [20.0, 10.0], &points);
        assert_eq!((corner.x, corner.y), (8.0, 8.0));
        assert_eq!(emptiest_corner(BOX, [20.0, 10.0], &[]).x, 72.0);
    }
}
