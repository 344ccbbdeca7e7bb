//! Charts of a view's regions.

use serde_json::Value;

use crate::color::Xyz;
use crate::color::signal::SignalColor;
use crate::error::Result;
use crate::program::figure::{Chart, ChartAxis, Figure, Marks, Panel, Series, figure_svg};
use crate::spectrum::{WavelengthGrid, cie};

/// Line colors of regions, in their order; told apart by people with any color vision (Okabe and
/// Ito 2008).
const COLORS: [[u8; 3]; 7] = [
    [230, 159, 0],
    [86, 180, 233],
    [0, 158, 115],
    [240, 228, 66],
    [0, 114, 178],
    [213, 94, 0],
    [204, 121, 167],
];

fn rgb(region: usize) -> [u8; 3] {
    COLORS[region % COLORS.len()]
}

/// The color of a region, for a style sheet.
pub(super) fn color(region: usize) -> String {
    let [r, g, b] = rgb(region);
    format!("#{r:02x}{g:02x}{b:02x}")
}

fn svg(chart: Chart) -> Result<String> {
    let figure = Figure { width: 640, height: 420, ..Figure::new(Panel::Chart(chart)) };
    // Inside HTML the name space goes without saying.
    Ok(figure_svg(&figure)?.replacen(" xmlns=\"http://www.w3.org/2000/svg\"", "", 1))
}

fn line(points: Vec<[f64; 2]>, color: [u8; 3]) -> Series {
    Series { color: Some(color), ..Series::line("", points) }
}

/// Mean spectra of the regions, relative to the largest value of all of them.
///
/// Errors: a chart that cannot be drawn.
pub(super) fn spectra(regions: &[(&String, &Value)]) -> Result<String> {
    let values = |region: &Value| -> Vec<f64> {
        let list = region.get("spectrum").and_then(Value::as_array).into_iter().flatten();
        list.filter_map(Value::as_f64).collect()
    };
    let largest =
        regions.iter().flat_map(|(_, region)| values(region)).fold(f64::MIN_POSITIVE, f64::max);
    let series = regions.iter().enumerate().map(|(at, (_, region))| {
        let step_nm = region.get("wavelength_step").and_then(Value::as_f64).unwrap_or(5.0);
        let rows = values(region).into_iter().enumerate();
        let points =
            rows.map(|(b, v)| [WavelengthGrid::FIRST_NM + step_nm * b as f64, v / largest]);
        line(points.collect(), rgb(at))
    });
    let range = [WavelengthGrid::FIRST_NM, WavelengthGrid::LAST_NM];
    svg(Chart {
        title: "spectra of the regions".to_owned(),
        x: ChartAxis { range: Some(range), ..ChartAxis::linear("wavelength (nm)") },
        y: ChartAxis {
            range: Some([0.0, 1.05]),
            ..ChartAxis::linear(&format!("relative to {largest:.3e}"))
        },
        series: series.collect(),
    })
}

/// Chromaticities among the colors of UN R48 and the spectral locus.
///
/// Errors: a chart that cannot be drawn.
pub(super) fn chromaticities(regions: &[(&String, &Value)]) -> Result<String> {
    let point = |region: &Value| -> Option<[f64; 2]> {
        let pair = region.get("chromaticity")?.as_array()?;
        Some([pair.first()?.as_f64()?, pair.get(1)?.as_f64()?])
    };
    let points: Vec<(usize, [f64; 2])> = regions
        .iter()
        .enumerate()
        .filter_map(|(at, (_, region))| Some((at, point(region)?)))
        .collect();
    let lamps = [[0.25, 0.75], [0.2, 0.5]];
    let is_lamp = |[x, y]: [f64; 2]| (0.25..=0.75).contains(&x) && (0.2..=0.5).contains(&y);
    let fits = points.iter().all(|(_, point)| is_lamp(*point));
    let [x, y] = if fits { lamps } else { [[0.0, 0.8], [0.0, 0.9]] };
    let mut series = vec![line(locus(), [138; 3])];
    for signal in SignalColor::ALL {
        let corners = signal.corners();
        let closed = corners.iter().chain(corners.first()).copied();
        series.push(line(closed.collect(), signal_rgb(signal)));
    }
    series.extend(
        points
            .iter()
            .map(|&(at, place)| Series { marks: Marks::Points, ..line(vec![place], rgb(at)) }),
    );
    svg(Chart {
        title: "colors, among those of UN R48".to_owned(),
        x: ChartAxis { range: Some(x), ..ChartAxis::linear("x (CIE 1931)") },
        y: ChartAxis { range: Some(y), ..ChartAxis::linear("y") },
        series,
    })
}

/// Near to what it stands for, and seen on white.
fn signal_rgb(color: SignalColor) -> [u8; 3] {
    match color {
        SignalColor::Red => [220, 30, 30],
        SignalColor::Amber => [230, 140, 0],
        SignalColor::White => [120, 120, 120],
    }
}

/// The spectral locus and the line of purples.
fn locus() -> Vec<[f64; 2]> {
    let grid = WavelengthGrid::Step5;
    let colors = (0..grid.bands()).map(|band| Xyz::from(cie::cmf(grid, band)));
    let mut points: Vec<[f64; 2]> = colors.filter_map(Xyz::chromaticity).collect();
    points.extend(points.first().copied());
    points
}

/// A quantity over the views' angle, one point a view.
///
/// Errors: a chart that cannot be drawn.
pub(super) fn over_angle(label: &str, angle: &str, points: Vec<[f64; 2]>) -> Result<String> {
    svg(Chart {
        title: String::new(),
        x: ChartAxis::linear(angle),
        y: ChartAxis::linear(label),
        series: vec![Series { marks: Marks::LineAndPoints, ..line(points, [213, 94, 0]) }],
    })
}
