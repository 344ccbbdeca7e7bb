//! The plain text of LED makers: lines of words, then rows of x y z dx dy dz flux, and a wavelength
//! if there are eight.
//!
//! Lengths are mm, as everywhere among LED makers; the flux has no unit.

use super::input::Input;
use super::lines::{Lines, RowFormat, RowSeparator, decimal_of, number_with};
use super::record::Layout;
use super::spectral::Tag;
use super::{FileSpectrum, FluxUnit, Format, Parsed};
use crate::error::Result;

/// Whether a line is a row of numbers, and of how many.
fn numbers(line: &[u8]) -> Option<usize> {
    let separator = RowSeparator::of(line);
    let decimal = decimal_of(separator, line);
    let cells = separator.split(line);
    cells.map(|cell| number_with(decimal, cell).map(|_| 1)).sum()
}

/// Whether the first line that holds only numbers holds seven or eight.
pub(super) fn is_rays(head: &[u8]) -> bool {
    let mut lines = head.split(|&b| b == b'\n').map(<[u8]>::trim_ascii);
    let count = lines.find_map(|line| numbers(line).filter(|&count| count > 0));
    matches!(count, Some(7 | 8))
}

pub(super) fn read(input: &mut Input) -> Result<Parsed> {
    let mut lines = Lines::new(input);
    let mut words = Vec::new();
    let row = loop {
        match lines.peek_content()? {
            None => return Err(lines.bad("the file ends without a row of numbers")),
            Some(line) if numbers(line).is_some() => break line.to_vec(),
            Some(line) => words.push(String::from_utf8_lossy(line).into_owned()),
        }
        lines.advance();
    };
    let separator = RowSeparator::of(&row);
    let decimal = decimal_of(separator, &row);
    let cells: Vec<f32> = separator.split(&row).filter_map(|c| number_with(decimal, c)).collect();
    let layout = match cells[..] {
        [.., flux, last] if cells.len() == 8 => eight_columns(flux, last).ok_or_else(|| {
            lines.bad(format!(
                "{flux} and {last} may both be a wavelength, or neither: name the columns in a \
                 first line (x,y,z,dx,dy,dz,flux,wavelength)"
            ))
        })?,
        _ => Layout::seven_columns(),
    };
    let unit = FluxUnit::Unstated;
    let rays =
        lines.read_rows(&RowFormat { layout: &layout, unit, separator, decimal, end: None })?;
    let mut parsed = Parsed::new(Format::Columns, rays, unit);
    if matches!(layout.tag, Tag::Wavelength { .. }) {
        parsed.spectrum = FileSpectrum::PerRay;
    }
    parsed.describe("first lines", words.join("; "));
    Ok(parsed)
}

/// Flux and wavelength, or the other way round, as the first row tells.
fn eight_columns(a: f32, b: f32) -> Option<Layout> {
    let nm_per_unit = |value: f32| match value {
        0.3..1.1 => Some(1000.0),
        300.0..1100.0 => Some(1.0),
        _ => None,
    };
    let (flux, column, nm_per_unit) = match (nm_per_unit(a), nm_per_unit(b)) {
        (None, Some(unit)) => (6, 7, unit),
        (Some(unit), None) => (7, 6, unit),
        // Fluxes are rarely as large as wavelengths in nm are.
        (Some(1000.0), Some(1.0)) => (6, 7, 1.0),
        (Some(1.0), Some(1000.0)) => (7, 6, 1.0),
        _ => return None,
    };
    let tag = Tag::Wavelength { column, nm_per_unit };
    Some(Layout { columns: 8, flux, tag, ..Layout::seven_columns() })
}
