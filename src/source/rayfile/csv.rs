//! Rays under a row of names: x,y,z,dx,dy,dz,flux and, if there is one, wavelength, in any order.
//!
//! Without units the lengths are mm, the flux lm and wavelengths nm. A comment `# flux_lm = 460`
//! before the row of names states the total, as other formats' headers do.

use super::input::Input;
use super::lines::{Lines, MAX_COLUMNS, RowFormat, RowSeparator, decimal_of, number};
use super::record::Layout;
use super::spectral::Tag;
use super::{FileSpectrum, FluxUnit, Format, Parsed, known};
use crate::error::Result;

pub(super) const HEADER: &str = "x,y,z,dx,dy,dz,flux";

/// Before the total flux in lm.
pub(super) const FLUX_COMMENT: &str = "# flux_lm = ";

/// What the row of names says.
#[derive(Debug)]
struct CsvHeader {
    layout: Layout,
    unit: FluxUnit,
    separator: RowSeparator,
}

/// Whether a line names the columns.
pub(super) fn is_header(line: &[u8]) -> bool {
    names(line).is_some()
}

/// Names of the columns, in small letters without blanks and marks.
const X: [&str; 6] = ["x", "xpos", "posx", "px", "positionx", "startx"];
const DX: [&str; 8] = ["dx", "l", "xvec", "vx", "dirx", "directionx", "kx", "cosx"];
const FLUX: [&str; 9] =
    ["flux", "luminousflux", "radiantflux", "power", "lumen", "lumens", "watt", "watts", "energy"];
const WAVELENGTH: [&str; 4] = ["wavelength", "lambda", "wl", "λ"];

/// The same name for another axis.
fn axis(names: &[&str], to: [&str; 2]) -> Vec<String> {
    names.iter().map(|name| name.replace('x', to[0]).replace('l', to[1])).collect()
}

fn names(line: &[u8]) -> Option<CsvHeader> {
    let line = std::str::from_utf8(line).ok()?;
    let mark = [b';', b'\t', b','].into_iter().find(|mark| line.as_bytes().contains(mark));
    let separator = mark.map_or(RowSeparator::Blank, RowSeparator::Byte);
    let cells: Vec<Column> = separator
        .split(line.as_bytes())
        .map(|cell| Column::of(std::str::from_utf8(cell).unwrap_or_default()))
        .collect();
    let at = |wanted: &dyn Fn(&str) -> bool| cells.iter().position(|cell| wanted(&cell.name));
    let of = |names: Vec<String>| at(&move |name| names.iter().any(|n| n == name));
    let all = |names: &[&str]| -> Option<[usize; 3]> {
        // "l", "m", "n" are the cosines; in other names there is no lonely "l".
        let y: Vec<String> = axis(names, ["y", "m"]);
        let z: Vec<String> = axis(names, ["z", "n"]);
        let x: Vec<String> = names.iter().map(|&name| name.to_owned()).collect();
        Some([of(x)?, of(y)?, of(z)?])
    };
    let follow = |[a, b, c]: [usize; 3]| (b == a + 1 && c == a + 2).then_some(a);
    let (position, direction) = (follow(all(&X)?)?, follow(all(&DX)?)?);
    let flux = at(&|name| FLUX.contains(&name))?;
    let wavelength = at(&|name| WAVELENGTH.contains(&name));
    let tag = wavelength.map_or(Tag::None, |column| Tag::Wavelength {
        column,
        nm_per_unit: cells[column].nm_per_unit(),
    });
    let layout = Layout {
        columns: cells.len(),
        position: Some(position),
        direction,
        flux,
        radiant: None,
        tag,
        mm_per_unit: cells[position].mm_per_unit(),
    };
    let unit = if cells[flux].is_radiant() { FluxUnit::Watt } else { FluxUnit::Lumen };
    // Rows parted by blanks are the plain text of LED makers, unless a wavelength is named.
    let is_named = separator != RowSeparator::Blank || wavelength.is_some();
    (is_named && cells.len() <= MAX_COLUMNS).then_some(CsvHeader { layout, unit, separator })
}

/// A column's name, and the unit behind or in brackets.
struct Column {
    name: String,
    unit: String,
}

impl Column {
    fn of(cell: &str) -> Self {
        let cell = cell.trim_matches(['"', ' ']).to_lowercase();
        let (name, unit) = match cell.split_once(['(', '[', '/']) {
            Some((name, unit)) => (name, unit.trim_end_matches([')', ']'])),
            None => match cell.rsplit_once(['_', ' ']) {
                Some((name, unit)) if UNITS.contains(&unit) => (name, unit),
                _ => (cell.as_str(), ""),
            },
        };
        let name = name.chars().filter(|c| c.is_alphanumeric()).collect();
        Self { name, unit: unit.trim().to_owned() }
    }

    fn nm_per_unit(&self) -> f64 {
        if self.is_in(&["um", "µm", "μm", "micron"]) { 1000.0 } else { 1.0 }
    }

    fn is_radiant(&self) -> bool {
        matches!(self.name.as_str(), "radiantflux" | "power" | "watt" | "watts")
            || self.is_in(&["w", "watt", "mw"])
    }

    fn is_in(&self, units: &[&str]) -> bool {
        units.contains(&self.unit.as_str())
    }

    fn mm_per_unit(&self) -> f64 {
        match self.unit.as_str() {
            "m" => 1000.0,
            "cm" => 10.0,
            "in" | "inch" => 25.4,
            "um" | "µm" | "μm" => 1e-3,
            _ => 1.0,
        }
    }
}

/// Units that may stand behind a name without brackets.
const UNITS: [&str; 10] = ["mm", "m", "cm", "lm", "w", "nm", "um", "µm", "watt", "in"];

pub(super) fn read(input: &mut Input) -> Result<Parsed> {
    let mut lines = Lines::new(input);
    let (names, header_flux) = read_header(&mut lines)?;
    let CsvHeader { layout, unit, separator } = names;
    let decimal = lines
        .peek_content()?
        .map_or_else(|| decimal_of(separator, b""), |row| decimal_of(separator, row));
    let rays =
        lines.read_rows(&RowFormat { layout: &layout, unit, separator, decimal, end: None })?;
    let mut parsed = Parsed { header_flux, ..Parsed::new(Format::Csv, rays, unit) };
    if matches!(layout.tag, Tag::Wavelength { .. }) {
        parsed.spectrum = FileSpectrum::PerRay;
    }
    Ok(parsed)
}

/// Steps over the row of names; the flux that a comment states.
fn read_header(lines: &mut Lines) -> Result<(CsvHeader, Option<f64>)> {
    let mut flux = None;
    loop {
        match lines.peek()? {
            None => return Err(lines.bad(format!("expected \"{HEADER}\""))),
            Some(line) => {
                if let Some(names) = names(line) {
                    lines.advance();
                    return Ok((names, flux));
                }
                let stated = line.strip_prefix(FLUX_COMMENT.as_bytes());
                flux = stated.and_then(number).and_then(known).or(flux);
            }
        }
        lines.advance();
    }
}
