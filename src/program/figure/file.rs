//! Figures as PNG and SVG files.

use std::borrow::Cow;
use std::path::Path;

use super::{Figure, PlacedRaster, to_pixels, to_svg};
use crate::error::{Error, Result};
use crate::image::Metadata;
use crate::output::{ColorSpace, Digits, Raster, base64, encode_png, write_png, write_text};

/// Errors: [`Error::Io`], and [`Error::Inconsistent`] for a figure that cannot be drawn.
pub fn write_figure_png(path: &Path, figure: &Figure) -> Result<()> {
    let pixels = to_pixels(figure)?;
    write_png(path, &raster(figure.width as usize, figure.height as usize, pixels.as_flattened()))
}

/// Errors: as [`write_figure_png`].
pub fn write_figure_svg(path: &Path, figure: &Figure) -> Result<()> {
    write_text(path, &figure_svg(figure)?)
}

/// A figure's SVG with its pictures embedded as PNG.
///
/// Errors: [`Error::Inconsistent`] for a figure that cannot be drawn.
pub fn figure_svg(figure: &Figure) -> Result<String> {
    let svg = to_svg(figure)?;
    let mut pictures = String::new();
    for placed in &svg.rasters {
        let refused = |e| Error::inconsistent("figure", format!("a picture has no PNG: {e}"));
        pictures += &picture(placed).map_err(refused)?;
    }
    Ok(svg.text.replacen("</svg>", &(pictures + "</svg>"), 1))
}

fn raster(width: usize, height: usize, rgb: &[u8]) -> Raster<'_> {
    let samples = Digits::Eight(Cow::Borrowed(rgb));
    Raster { width, height, samples, color_space: ColorSpace::Srgb, metadata: Metadata::new() }
}

fn picture(placed: &PlacedRaster) -> std::io::Result<String> {
    let (panel, place) = (placed.panel, placed.place);
    let mut png = Vec::new();
    encode_png(&mut png, &raster(panel.width, panel.height, panel.pixels.as_flattened()))?;
    Ok(format!(
        "<image x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" image-rendering=\"optimizeSpeed\" \
         href=\"data:image/png;base64,{}\"/>\n",
        place.x,
        place.y,
        place.width,
        place.height,
        base64(&png)
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::scratch::ScratchFolder;
    use crate::program::figure::{Panel, RasterPanel};

    #[test]
    fn both_files_hold_the_picture() {
        let scratch = ScratchFolder::new();
        let panel = RasterPanel {
            title: "two".to_owned(),
            width: 2,
            height: 1,
            pixels: vec![[255, 0, 0], [0, 0, 255]],
            scale_bar: None,
        };
        let figure = Figure::new(Panel::Raster(panel));
        write_figure_png(&scratch.path("f.png"), &figure).unwrap();
        write_figure_svg(&scratch.path("f.svg"), &figure).unwrap();
        let svg = std::fs::read_to_string(scratch.path("f.svg")).unwrap();
        assert!(svg.contains("href=\"data:image/png;base64,iVBORw0KGgo"), "{svg}");
        assert!(svg.trim_end().ends_with("</svg>"));
        assert!(std::fs::read(scratch.path("f.png")).unwrap().starts_with(b"\x89PNG"));
    }
}
