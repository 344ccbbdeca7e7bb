//! Figures to pixels and to SVG.

use plotters::prelude::{BitMapBackend, DrawingBackend, IntoDrawingArea, SVGBackend};

use super::brush::{Anchor, Brush, LARGE};
use super::chart::draw_chart;
use super::raster::{PlacedRaster, Rect, draw_raster};
use super::segments::draw_segments;
use super::{Figure, Panel};
use crate::error::{Error, Result};

/// A figure's SVG, but for its pictures.
#[derive(Debug, Clone, PartialEq)]
pub struct SvgFigure<'a> {
    /// Ends in `</svg>`, before which the pictures belong.
    pub text: String,
    /// Pictures and their places.
    pub rasters: Vec<PlacedRaster<'a>>,
}

/// sRGB pixels, row 0 on top.
///
/// Errors: [`Error::Inconsistent`] for a figure without pixels or panels, or with a range or a
/// picture that cannot be drawn.
pub fn to_pixels(figure: &Figure) -> Result<Vec<[u8; 3]>> {
    let (width, height) = (figure.width as usize, figure.height as usize);
    let mut bytes = vec![0; 3 * width * height];
    let rasters = {
        let size = (figure.width, figure.height);
        draw(figure, BitMapBackend::with_buffer(&mut bytes, size))?
    };
    let mut pixels: Vec<[u8; 3]> =
        bytes.chunks_exact(3).map(|rgb| [rgb[0], rgb[1], rgb[2]]).collect();
    for raster in rasters {
        let (x, y) = (raster.place.x as usize, raster.place.y as usize);
        for row in 0..(raster.place.height as usize).min(height.saturating_sub(y)) {
            for column in 0..(raster.place.width as usize).min(width.saturating_sub(x)) {
                pixels[(y + row) * width + x + column] = raster.color(column, row);
            }
        }
    }
    Ok(pixels)
}

/// Errors: as [`to_pixels`].
pub fn to_svg(figure: &Figure) -> Result<SvgFigure<'_>> {
    let mut text = String::new();
    let size = (figure.width, figure.height);
    let rasters = draw(figure, SVGBackend::with_string(&mut text, size))?;
    Ok(SvgFigure { text, rasters })
}

/// How much of each pixel words cover, 0 to 1, in a box of `size` pixels, from its left.
///
/// Errors: [`Error::Inconsistent`] if they cannot be drawn.
pub fn words(text: &str, font_size: u32, [width, height]: [u32; 2]) -> Result<Vec<f64>> {
    let mut bytes = vec![0; 3 * (width * height) as usize];
    {
        let area = BitMapBackend::with_buffer(&mut bytes, (width, height)).into_drawing_area();
        let brush = Brush::new(&area)?;
        brush.words(text, [2.0, 0.5 * f64::from(height)], Anchor::RightOf, font_size)?;
        let presented = area.present();
        presented.map_err(|e| Error::inconsistent("figure", format!("cannot be drawn: {e:?}")))?;
    }
    // Black on white.
    Ok(bytes.chunks_exact(3).map(|rgb| 1.0 - f64::from(rgb[0]) / 255.0).collect())
}

fn draw<DB: DrawingBackend>(figure: &Figure, backend: DB) -> Result<Vec<PlacedRaster<'_>>> {
    if figure.width == 0 || figure.height == 0 || figure.panels.is_empty() || figure.columns == 0 {
        return Err(Error::inconsistent("figure", "has no pixels, panels or columns"));
    }
    let area = backend.into_drawing_area();
    let brush = Brush::new(&area)?;
    let title_height = if figure.title.is_empty() { 0.0 } else { 44.0 };
    let (width, height) = (f64::from(figure.width), f64::from(figure.height));
    brush.words(&figure.title, [0.5 * width, 36.0], Anchor::Above, LARGE)?;
    let rows = figure.panels.len().div_ceil(figure.columns);
    let size = [width / figure.columns as f64, (height - title_height) / rows as f64];
    let mut rasters = Vec::new();
    for (at, panel) in figure.panels.iter().enumerate() {
        let (column, row) = ((at % figure.columns) as f64, (at / figure.columns) as f64);
        let (x, y) = (column * size[0], title_height + row * size[1]);
        let rect = Rect { x, y, width: size[0], height: size[1] };
        match panel {
            Panel::Chart(chart) => draw_chart(&brush, chart, rect)?,
            Panel::Segments(segments) => draw_segments(&brush, segments, rect)?,
            Panel::Raster(raster) => rasters.push(draw_raster(&brush, raster, rect)?),
        }
    }
    let presented = area.present();
    presented.map_err(|e| Error::inconsistent("figure", format!("cannot be drawn: {e:?}")))?;
    Ok(rasters)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::figure::{
        Chart, ChartAxis, Marks, RasterPanel, Scale, ScaleBar, SegmentDrawing, Series,
    };

    fn chart() -> Chart {
        let curve = (0..100).map(|i| [f64::from(i) / 10.0, 1e-3 * 2f64.powf(f64::from(i) / 10.0)]);
        let mut points = Series::scatter("measured", vec![[1.0, 0.002], [5.0, 0.03]]);
        points.errors = Some(vec![0.001, 0.01]);
        let mut dashed = Series::line("limit", vec![[0.0, 0.1], [f64::NAN, 1.0], [10.0, 0.1]]);
        dashed.marks = Marks::Dashes;
        Chart {
            title: "BRDF of aluminium".to_owned(),
            x: ChartAxis::linear("angle from specular (°)"),
            y: ChartAxis::log("BRDF (sr⁻¹)"),
            series: vec![Series::line("fit", curve.collect()), points, dashed],
        }
    }

    fn figure() -> Figure {
        let pixels = (0..64 * 48).map(|i| [(i % 64 * 4) as u8, (i / 64 * 5) as u8, 99]).collect();
        let raster = RasterPanel {
            title: "luminance".to_owned(),
            width: 64,
            height: 48,
            pixels,
            scale_bar: Some(ScaleBar {
                label: "cd/m²".to_owned(),
                scale: Scale::Log,
                range: [0.1, 1e4],
                colors: (0..=255).map(|i| [i, i, 128]).collect(),
            }),
        };
        let spiral = |i: u32| {
            let t = f64::from(i) / 10.0;
            [t.cos(), t.sin(), 0.1 * t]
        };
        let segments = SegmentDrawing {
            title: "rays".to_owned(),
            segments: (0..99).map(|i| [spiral(i), spiral(i + 1)]).collect(),
            marks: super::super::SegmentMarks::LinesAndDots,
            azimuth_deg: 30.0,
            elevation_deg: 20.0,
        };
        Figure {
            width: 1200,
            height: 900,
            title: "A figure".to_owned(),
            panels: vec![Panel::Chart(chart()), Panel::Raster(raster), Panel::Segments(segments)],
            columns: 2,
        }
    }

    #[test]
    fn pixels_hold_axes_words_and_pictures() {
        let pixels = to_pixels(&figure()).unwrap();
        assert_eq!(pixels.len(), 1200 * 900);
        let has = |color: [u8; 3]| pixels.iter().filter(|p| **p == color).count();
        assert!(has([0; 3]) > 1000 && has([255; 3]) > 500_000);
        assert!(has(crate::program::figure::COLORS[0]) > 100);
        assert!(has([252, 235, 99]) > 10, "the last pixel of the picture");
    }

    #[test]
    fn svg_holds_every_word() {
        let figure = figure();
        let svg = to_svg(&figure).unwrap();
        for word in ["A figure", "BRDF of aluminium", "BRDF (sr⁻¹)", "measured", "cd/m²", "10"]
        {
            assert!(svg.text.contains(word), "{word}");
        }
        assert!(svg.text.trim_end().ends_with("</svg>"));
        assert_eq!(svg.rasters.len(), 1);
    }

    #[test]
    fn figures_are_the_same_each_time() {
        assert!(to_pixels(&figure()).unwrap() == to_pixels(&figure()).unwrap());
        assert_eq!(to_svg(&figure()).unwrap().text, to_svg(&figure()).unwrap().text);
    }

    #[test]
    fn extremes_are_drawn_or_refused() {
        let mut empty = chart();
        empty.series.clear();
        to_pixels(&Figure::new(Panel::Chart(empty.clone()))).unwrap();
        empty.series = vec![Series::line("", vec![[1e300, 1e300], [-1e300, 1e-300]])];
        to_pixels(&Figure::new(Panel::Chart(empty.clone()))).unwrap();
        empty.y.range = Some([0.0, 1.0]);
        assert_eq!(
            to_pixels(&Figure::new(Panel::Chart(empty))).unwrap_err().to_string(),
            "figure: axis \"BRDF (sr⁻¹)\": range is Some([0.0, 1.0]), allowed: ascending, \
             above 0 if log"
        );
        let none = Figure { panels: vec![], ..figure() };
        assert!(to_svg(&none).is_err());
    }
}
