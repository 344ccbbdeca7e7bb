//! Charts of a view's regions, as SVG.

use serde_json::Value;

use crate::color::Xyz;
use crate::color::signal::SignalColor;
use crate::spectrum::{WavelengthGrid, cie};

/// Line colors of regions, in their order; told apart by people with any color vision (Okabe and
/// Ito 2008).
pub(super) const COLORS: [&str; 7] =
    ["#e69f00", "#56b4e9", "#009e73", "#f0e442", "#0072b2", "#d55e00", "#cc79a7"];

pub(super) fn color(region: usize) -> &'static str {
    COLORS[region % COLORS.len()]
}

/// A plot's area in pixels and what it shows.
struct Axes {
    x: [f64; 2],
    y: [f64; 2],
}

const WIDTH: f64 = 420.0;
const HEIGHT: f64 = 260.0;
const LEFT: f64 = 46.0;
const BOTTOM: f64 = 34.0;
const TOP: f64 = 22.0;
const RIGHT: f64 = 12.0;

impl Axes {
    fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let along = |value: f64, [low, high]: [f64; 2]| (value - low) / (high - low);
        [
            LEFT + along(x, self.x) * (WIDTH - LEFT - RIGHT),
            HEIGHT - BOTTOM - along(y, self.y) * (HEIGHT - BOTTOM - TOP),
        ]
    }

    fn contains(&self, [x, y]: [f64; 2]) -> bool {
        (self.x[0]..=self.x[1]).contains(&x) && (self.y[0]..=self.y[1]).contains(&y)
    }

    fn points(&self, points: impl IntoIterator<Item = [f64; 2]>) -> String {
        let texts = points.into_iter().map(|point| {
            let [x, y] = self.place(point);
            format!("{x:.1},{y:.1}")
        });
        texts.collect::<Vec<_>>().join(" ")
    }

    /// Frame, ticks and titles around `content`, which is cut off at the frame (an inner `svg` does
    /// that without a name, which would have to differ from chart to chart).
    fn chart(&self, titles: [&str; 2], ticks: [&[f64]; 2], content: &str) -> String {
        let mut marks = String::new();
        for &tick in ticks[0] {
            let [x, y] = self.place([tick, self.y[0]]);
            marks += &format!("<path d='M{x:.1} {y:.1}v4'/>");
            marks += &format!("<text x='{x:.1}' y='{:.1}' class='x'>{tick}</text>", y + 16.0);
        }
        for &tick in ticks[1] {
            let [x, y] = self.place([self.x[0], tick]);
            marks += &format!("<path d='M{x:.1} {y:.1}h-4'/>");
            marks +=
                &format!("<text x='{:.1}' y='{:.1}' class='y'>{tick}</text>", x - 7.0, y + 4.0);
        }
        let [left, top] = self.place([self.x[0], self.y[1]]);
        let [right, bottom] = self.place([self.x[1], self.y[0]]);
        let [width, height] = [right - left, bottom - top];
        format!(
            "<svg class='chart' viewBox='0 0 {WIDTH} {HEIGHT}' role='img'>\
             <rect class='frame' x='{left:.1}' y='{top:.1}' width='{width:.1}' \
             height='{height:.1}'/><g class='ticks'>{marks}</g>\
             <svg x='{left:.1}' y='{top:.1}' width='{width:.1}' height='{height:.1}' \
             viewBox='{left:.1} {top:.1} {width:.1} {height:.1}'>{content}</svg>\
             <text x='{:.1}' y='{:.1}' class='x'>{}</text>\
             <text x='4' y='14' class='title'>{}</text></svg>",
            f64::midpoint(left, right),
            HEIGHT - 3.0,
            titles[0],
            titles[1],
        )
    }
}

/// Mean spectra of the regions, relative to the largest value of all of them.
pub(super) fn spectra(regions: &[(&String, &Value)]) -> String {
    let values = |region: &Value| -> Vec<f64> {
        let list = region.get("spectrum").and_then(Value::as_array).into_iter().flatten();
        list.filter_map(Value::as_f64).collect()
    };
    let largest =
        regions.iter().flat_map(|(_, region)| values(region)).fold(f64::MIN_POSITIVE, f64::max);
    let axes = Axes { x: [WavelengthGrid::FIRST_NM, WavelengthGrid::LAST_NM], y: [0.0, 1.05] };
    let lines = regions.iter().enumerate().map(|(at, (_, region))| {
        let step_nm = region.get("wavelength_step").and_then(Value::as_f64).unwrap_or(5.0);
        let rows = values(region).into_iter().enumerate();
        let points =
            rows.map(|(b, v)| [WavelengthGrid::FIRST_NM + step_nm * b as f64, v / largest]);
        format!("<polyline class='line' stroke='{}' points='{}'/>", color(at), axes.points(points))
    });
    let content: String = lines.collect();
    let title = format!("spectrum, relative to {largest:.3e}");
    let ticks: [&[f64]; 2] = [&[400.0, 500.0, 600.0, 700.0], &[0.0, 0.5, 1.0]];
    axes.chart(["wavelength / nm", &title], ticks, &content)
}

/// Chromaticities among the colors of UN R48 and the spectral locus.
pub(super) fn chromaticities(regions: &[(&String, &Value)]) -> String {
    let point = |region: &Value| -> Option<[f64; 2]> {
        let pair = region.get("chromaticity")?.as_array()?;
        Some([pair.first()?.as_f64()?, pair.get(1)?.as_f64()?])
    };
    let points: Vec<(usize, [f64; 2])> = regions
        .iter()
        .enumerate()
        .filter_map(|(at, (_, region))| Some((at, point(region)?)))
        .collect();
    let lamps = Axes { x: [0.25, 0.75], y: [0.2, 0.5] };
    let all = Axes { x: [0.0, 0.8], y: [0.0, 0.9] };
    let fits = points.iter().all(|(_, point)| lamps.contains(*point));
    let axes = if fits { lamps } else { all };
    let mut content = format!("<polygon class='locus' points='{}'/>", axes.points(locus()));
    for color in SignalColor::ALL {
        let corners = axes.points(color.corners().iter().copied());
        let name = color.name();
        content += &format!("<polygon class='box {name}' points='{corners}'/>");
    }
    for (at, place) in points {
        let [x, y] = axes.place(place);
        let color = color(at);
        content += &format!("<circle cx='{x:.1}' cy='{y:.1}' r='4' fill='{color}'/>");
    }
    let ticks: [&[f64]; 2] = if fits {
        [&[0.3, 0.4, 0.5, 0.6, 0.7], &[0.2, 0.3, 0.4, 0.5]]
    } else {
        [&[0.0, 0.2, 0.4, 0.6, 0.8], &[0.0, 0.2, 0.4, 0.6, 0.8]]
    };
    axes.chart(["x (CIE 1931)", "y, with the boxes of UN R48"], ticks, &content)
}

fn locus() -> Vec<[f64; 2]> {
    let grid = WavelengthGrid::Step5;
    let colors = (0..grid.bands()).map(|band| Xyz::from(cie::cmf(grid, band)));
    colors.filter_map(Xyz::chromaticity).collect()
}
