//! Comma-separated rays: a row of names, then x,y,z,dx,dy,dz,flux in mm and lm; `#` comments.

use super::input::Input;
use super::lines::{Lines, Separator, Table};
use super::record::Layout;
use super::{FluxUnit, Format, Parsed};
use crate::error::Result;

pub(super) const HEADER: &str = "x,y,z,dx,dy,dz,flux";

/// Whether a line names the columns.
pub(super) fn is_header(line: &[u8]) -> bool {
    let names = line.split(|&b| b == b',').map(|name| name.trim_ascii().to_ascii_lowercase());
    names.eq(HEADER.bytes().collect::<Vec<_>>().split(|&b| b == b',').map(<[u8]>::to_vec))
}

pub(super) fn read(input: &mut Input) -> Result<Parsed> {
    let layout = Layout::seven_columns();
    let mut lines = Lines::new(input);
    lines.peek_content()?;
    lines.advance();
    let unit = FluxUnit::Lumen;
    let rays = lines.read_rows(&Table {
        layout: &layout,
        unit,
        separator: Separator::Byte(b','),
        end: None,
    })?;
    Ok(Parsed::new(Format::Csv, rays, unit))
}
