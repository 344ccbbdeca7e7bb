//! The plain text of LED makers: lines of words, then rows of x y z dx dy dz flux.
//!
//! Lengths are mm, as everywhere among LED makers; the flux has no unit.

use super::input::Input;
use super::lines::{Lines, Separator, Table, number};
use super::record::Layout;
use super::{FluxUnit, Format, Parsed};
use crate::error::Result;

const COLUMNS: usize = 7;

/// Whether a line is a row of numbers, and of how many.
fn numbers(line: &[u8]) -> Option<usize> {
    let cells = Separator::of(line).split(line);
    cells.map(|cell| number(cell).map(|_| 1)).sum()
}

/// Whether the first line that holds only numbers holds seven.
pub(super) fn is_seven_columns(head: &[u8]) -> bool {
    let mut lines = head.split(|&b| b == b'\n').map(<[u8]>::trim_ascii);
    lines.find_map(|line| numbers(line).filter(|&count| count > 0)) == Some(COLUMNS)
}

pub(super) fn read(input: &mut Input) -> Result<Parsed> {
    let mut lines = Lines::new(input);
    let mut words = Vec::new();
    let separator = loop {
        match lines.peek_content()? {
            None => return Err(lines.bad("the file ends without a row of numbers")),
            Some(line) if numbers(line).is_some() => break Separator::of(line),
            Some(line) => words.push(String::from_utf8_lossy(line).into_owned()),
        }
        lines.advance();
    };
    let (layout, unit) = (Layout::seven_columns(), FluxUnit::Unstated);
    let rays = lines.read_rows(&Table { layout: &layout, unit, separator, end: None })?;
    let mut parsed = Parsed::new(Format::SevenColumns, rays, unit);
    parsed.describe("first lines", words.join("; "));
    Ok(parsed)
}
