//! Comma-separated rays: a row of names, then x,y,z,dx,dy,dz,flux in mm and lm; `#` comments.
//!
//! A comment `# flux_lm = 460` before the row of names states the total, as other formats' headers
//! do.

use super::input::Input;
use super::lines::{Lines, Separator, Table, number};
use super::record::Layout;
use super::{FluxUnit, Format, Parsed, known};
use crate::error::Result;

pub(super) const HEADER: &str = "x,y,z,dx,dy,dz,flux";

/// Before the total flux in lm.
pub(super) const FLUX_COMMENT: &str = "# flux_lm = ";

/// Whether a line names the columns.
pub(super) fn is_header(line: &[u8]) -> bool {
    let names = line.split(|&b| b == b',').map(<[u8]>::trim_ascii);
    let mut expected = HEADER.split(',');
    names.into_iter().all(|name| {
        expected.next().is_some_and(|column| name.eq_ignore_ascii_case(column.as_bytes()))
    }) && expected.next().is_none()
}

pub(super) fn read(input: &mut Input) -> Result<Parsed> {
    let layout = Layout::seven_columns();
    let mut lines = Lines::new(input);
    let header_flux = read_header(&mut lines)?;
    let unit = FluxUnit::Lumen;
    let separator = Separator::Byte(b',');
    let rays = lines.read_rows(&Table { layout: &layout, unit, separator, end: None })?;
    Ok(Parsed { header_flux, ..Parsed::new(Format::Csv, rays, unit) })
}

/// Steps over the row of names; the flux that a comment states.
fn read_header(lines: &mut Lines) -> Result<Option<f64>> {
    let mut flux = None;
    loop {
        match lines.peek()? {
            None => return Err(lines.bad(format!("expected \"{HEADER}\""))),
            Some(line) if is_header(line) => {
                lines.advance();
                return Ok(flux);
            }
            Some(line) => {
                let stated = line.strip_prefix(FLUX_COMMENT.as_bytes());
                flux = stated.and_then(number).and_then(known).or(flux);
            }
        }
        lines.advance();
    }
}
