//! All views of a sweep as one picture.

use std::path::Path;

use super::look_record::display_of;
use super::manifest::{Entry, Manifest};
use super::page;
use crate::color::{D65_XY, Xyz};
use crate::display::{Display, DisplayImage, GamutReport};
use crate::error::{Error, Result};
use crate::output::{self, Digits, Raster};
use crate::program::figure::words;

const NAME: &str = "contact_sheet.png";
/// Pixels; a view is made smaller, never larger.
const THUMBNAIL_WIDTH: usize = 240;
const MARGIN: usize = 8;
const MOST_COLUMNS: usize = 6;
const LABEL_HEIGHT: usize = 18;
const LABEL_SIZE: u32 = 13;
const LABEL_CD_M2: f64 = 60.0;
/// Of more views every second, third and so on stands for all: a larger picture is none to look at.
const FULL_SHEET: usize = 500;

/// Writes the sheet and returns its name, or `None` for a sweep without views.
///
/// Errors: [`Error::Io`]; a PNG file that does not read back.
pub(super) fn write(folder: &Path, manifest: &Manifest) -> Result<Option<&'static str>> {
    let Some(display) = manifest.pictures.get("look").and_then(display_of) else {
        return Err(Error::inconsistent("sweep", "the manifest's display is none"));
    };
    let stride = manifest.views.len().div_ceil(FULL_SHEET).max(1);
    let linear = LinearTables::new(&display);
    let thumbnail = |entry: &Entry| {
        let (raster, bits) = output::read_png(&folder.join(format!("{}.png", entry.name)))?;
        let label = label(entry, &display)?;
        Ok(linear.thumbnail(&raster, bits, &display).over(label))
    };
    let shown = manifest.views.iter().step_by(stride);
    let thumbnails: Vec<Thumbnail> = shown.map(thumbnail).collect::<Result<_>>()?;
    if thumbnails.is_empty() {
        return Ok(None);
    }
    let raster = output::display_raster(&sheet(&thumbnails), &display)?;
    output::write_png(&folder.join(NAME), &raster)?;
    Ok(Some(NAME))
}

struct Thumbnail {
    width: usize,
    height: usize,
    digits: Vec<[u16; 3]>,
}

impl Thumbnail {
    /// With another below it.
    fn over(mut self, other: Self) -> Self {
        let width = self.width.max(other.width);
        let rows = |part: &Self| -> Vec<[u16; 3]> {
            let padded = |row: &[[u16; 3]]| [row, &vec![[0; 3]; width - row.len()]].concat();
            part.digits.chunks(part.width).flat_map(padded).collect()
        };
        self.digits = [rows(&self), rows(&other)].concat();
        Self { width, height: self.height + other.height, digits: self.digits }
    }
}

/// The view's name and angles in light gray.
fn label(entry: &Entry, display: &Display) -> Result<Thumbnail> {
    let (width, height) = (THUMBNAIL_WIDTH, LABEL_HEIGHT);
    let ink = words(&page::title(entry), LABEL_SIZE, [width as u32, height as u32])?;
    // As bright as sRGB's white at most: HDR displays can do ten times that.
    let gray = Xyz::from_xy(D65_XY, LABEL_CD_M2.min(0.8 * display.white().y));
    let digit = |coverage: f64| {
        display.digits_from_xyz(gray * coverage + display.black()).unwrap_or_default()
    };
    Ok(Thumbnail { width, height, digits: ink.into_iter().map(digit).collect() })
}

/// Light of each sample value, so that thumbnails average light and not digits.
struct LinearTables {
    full: usize,
    light: [Vec<f64>; 3],
}

impl LinearTables {
    fn new(display: &Display) -> Self {
        let full = usize::from(display.full_digit());
        let light = |c: usize| {
            (0..=full).map(|digit| display.light(c, digit as f64 / full as f64)).collect()
        };
        Self { full, light: std::array::from_fn(light) }
    }

    fn thumbnail(&self, raster: &Raster, bits: u32, display: &Display) -> Thumbnail {
        let width = raster.width.min(THUMBNAIL_WIDTH);
        let height = (raster.height * width / raster.width.max(1)).max(1);
        let span = |at: usize, count: usize, of: usize| {
            let start = at * of / count;
            start..((at + 1) * of / count).max(start + 1)
        };
        let mut digits = Vec::with_capacity(width * height);
        for y in 0..height {
            for x in 0..width {
                let mut sum = [0.0; 3];
                let mut count = 0.0;
                for row in span(y, height, raster.height) {
                    for column in span(x, width, raster.width) {
                        self.add(&mut sum, raster, bits, row * raster.width + column);
                        count += 1.0;
                    }
                }
                let mean = sum.map(|s| s / count);
                digits.push(display.digits_from_linear(mean).unwrap_or_default());
            }
        }
        Thumbnail { width, height, digits }
    }

    fn add(&self, sum: &mut [f64; 3], raster: &Raster, bits: u32, pixel: usize) {
        let file_full = (1usize << bits) - 1;
        for (c, sum) in sum.iter_mut().enumerate() {
            let sample = match &raster.samples {
                Digits::Eight(samples) => usize::from(samples[3 * pixel + c]),
                Digits::Sixteen(samples) => usize::from(samples[3 * pixel + c]),
            };
            *sum += self.light[c][(sample * self.full + file_full / 2) / file_full];
        }
    }
}

/// Row by row, each in a cell of the largest thumbnail's size.
fn sheet(thumbnails: &[Thumbnail]) -> DisplayImage {
    let largest = |side: fn(&Thumbnail) -> usize| thumbnails.iter().map(side).max().unwrap_or(0);
    let (cell_width, cell_height) = (largest(|t| t.width), largest(|t| t.height));
    let columns = thumbnails.len().min(MOST_COLUMNS);
    let rows = thumbnails.len().div_ceil(columns);
    let width = columns * (cell_width + MARGIN) + MARGIN;
    let height = rows * (cell_height + MARGIN) + MARGIN;
    let mut digits = vec![[0; 3]; width * height];
    for (at, thumbnail) in thumbnails.iter().enumerate() {
        let left = MARGIN + at % columns * (cell_width + MARGIN);
        let top = MARGIN + at / columns * (cell_height + MARGIN);
        for (y, row) in thumbnail.digits.chunks(thumbnail.width).enumerate() {
            let start = (top + y) * width + left;
            digits[start..start + row.len()].copy_from_slice(row);
        }
    }
    DisplayImage { width, height, digits, exposure_factor: 1.0, gamut: GamutReport::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thumbnails_average_light() {
        let display = Display::srgb();
        let stripes: Vec<u8> = (0..480 * 2).flat_map(|p| [(p % 2 * 255) as u8; 3]).collect();
        let raster = Raster {
            width: 480,
            height: 2,
            samples: Digits::Eight(stripes.into()),
            color_space: output::ColorSpace::Srgb,
            metadata: Default::default(),
        };
        let small = LinearTables::new(&display).thumbnail(&raster, 8, &display);
        assert_eq!((small.width, small.height), (240, 1));
        // Half the light of white is digit 188, not 128.
        assert!(small.digits.iter().all(|d| *d == [188; 3]));
    }

    #[test]
    fn labels_are_light_on_black() {
        let name = "view_0001".to_owned();
        let label = label(&Entry { name, ..Entry::new() }, &Display::srgb()).unwrap();
        let bright = label.digits.iter().filter(|digit| digit[0] > 150).count();
        assert!(bright > 50 && bright < label.digits.len() / 4, "{bright}");
        let thumbnail = Thumbnail { width: 300, height: 1, digits: vec![[9; 3]; 300] };
        let both = thumbnail.over(label);
        assert_eq!((both.width, both.height), (300, 1 + LABEL_HEIGHT));
        assert_eq!(both.digits.len(), 300 * (1 + LABEL_HEIGHT));
    }

    #[test]
    fn sheets_fill_rows_of_six() {
        let thumbnail = |_| Thumbnail { width: 2, height: 1, digits: vec![[9; 3]; 2] };
        let sheet = sheet(&(0..7).map(thumbnail).collect::<Vec<_>>());
        assert_eq!((sheet.width, sheet.height), (6 * 10 + 8, 2 * 9 + 8));
        assert_eq!(sheet.digits.iter().filter(|d| d[0] == 9).count(), 14);
        assert_eq!(sheet.digits[17 * sheet.width + 8], [9; 3]);
    }
}
