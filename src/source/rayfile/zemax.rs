//! Zemax OpticStudio sources: binary `.DAT` and `.SDF`, and text.
//!
//! The program that defines the format reads only the number of rays, the length unit and the two
//! types. The header's flux is used here too, as the total of the rays in their unit, since makers
//! state it and the rays' sum is often a mere count.

use super::binary::{ByteOrder, RayBlock};
use super::input::{Header, Input};
use super::lines::{Lines, RowFormat, RowSeparator, number};
use super::record::Layout;
use super::spectral::{SpectralTable, Tag};
use super::{FileSpectrum, FluxUnit, Format, Parsed, known};
use crate::columns::DecimalMark;
use crate::error::Result;

/// The current identifier, and the one of older files.
const IDENTIFIERS: [i32; 2] = [1010, 8_675_309];
const HEADER_BYTES: u64 = 208;
const NM_PER_UM: f64 = 1000.0;

mod offset {
    pub const RAYS: usize = 4;
    pub const DESCRIPTION: usize = 8;
    pub const SOURCE_FLUX: usize = 108;
    pub const RAY_SET_FLUX: usize = 112;
    pub const WAVELENGTH: usize = 116;
    pub const LENGTH_UNIT: usize = 136;
    pub const RAY_FORMAT: usize = 192;
    pub const FLUX_TYPE: usize = 196;
}

const DESCRIPTION_BYTES: usize = 100;

pub(super) fn is_binary(head: &[u8]) -> bool {
    let identifier = head.first_chunk::<4>().map(|&word| i32::from_le_bytes(word));
    identifier.is_some_and(|found| IDENTIFIERS.contains(&found))
}

/// A first line "rays unit 0 0 …": as a ray it would have no direction.
pub(super) fn is_text(first_line: &[u8]) -> bool {
    text_header(first_line).is_some()
}

fn mm_per_unit(code: u32) -> Option<f64> {
    [1000.0, 25.4, 10.0, 304.8, 1.0].get(code as usize).copied()
}

pub(super) fn read_binary(input: &mut Input) -> Result<Parsed> {
    let header = Header(input.take(HEADER_BYTES, "the header")?);
    let unit_code = header.u32(offset::LENGTH_UNIT);
    let mm_per_unit = mm_per_unit(unit_code)
        .ok_or_else(|| input.bad(format!("length unit {unit_code}, allowed: 0 to 4")))?;
    let spectral = match header.i32(offset::RAY_FORMAT) {
        0 => false,
        2 => true,
        other => return Err(input.bad(format!("ray format {other}, allowed: 0 and 2"))),
    };
    let unit = match (spectral, header.i32(offset::FLUX_TYPE)) {
        (true, _) | (false, 0) => FluxUnit::Watt,
        (false, 1) => FluxUnit::Lumen,
        (false, other) => return Err(input.bad(format!("flux type {other}, allowed: 0 and 1"))),
    };
    let layout = if spectral { spectral_layout() } else { Layout::seven_columns() };
    let layout = Layout { mm_per_unit, ..layout };
    let rays = u64::from(header.u32(offset::RAYS));
    let rays = RayBlock { layout: &layout, unit, rays, order: ByteOrder::Little }.read(input, 0)?;

    let mut parsed = Parsed::new(Format::ZemaxBinary, rays, unit);
    parsed.header_flux =
        known(header.f32(offset::RAY_SET_FLUX)).or_else(|| known(header.f32(offset::SOURCE_FLUX)));
    if spectral {
        parsed.spectrum = FileSpectrum::PerRay;
    } else if let (FluxUnit::Watt, Some(um)) = (unit, known(header.f32(offset::WAVELENGTH))) {
        // A photometric file is composite light, whatever its header's wavelength.
        let nm = um * NM_PER_UM;
        parsed.spectrum = FileSpectrum::Line { table: SpectralTable::line(nm), nm };
    }
    parsed.describe("description", header.text(offset::DESCRIPTION, DESCRIPTION_BYTES));
    Ok(parsed)
}

/// x y z l m n W, µm.
fn spectral_layout() -> Layout {
    Layout {
        columns: 8,
        tag: Tag::Wavelength { column: 7, nm_per_unit: NM_PER_UM },
        ..Layout::seven_columns()
    }
}

struct TextHeader {
    rays: u64,
    mm_per_unit: f64,
}

fn text_header(line: &[u8]) -> Option<TextHeader> {
    let cells: Option<Vec<f32>> = RowSeparator::Blank.split(line).map(number).collect();
    let cells = cells?;
    let (&[_, unit], rest) = cells.split_first_chunk::<2>()?;
    // The count may exceed what an f32 holds exactly.
    let count = RowSeparator::Blank.split(line).next()?;
    let rays: f64 = std::str::from_utf8(count).ok()?.parse().ok()?;
    let is_header = rays >= 1.0
        && rays.fract() == 0.0
        && rays < 1e15
        && unit.fract() == 0.0
        && (0.0..=4.0).contains(&unit)
        && rest.iter().all(|&cell| cell == 0.0);
    is_header
        .then(|| mm_per_unit(unit as u32))?
        .map(|mm_per_unit| TextHeader { rays: rays as u64, mm_per_unit })
}

pub(super) fn read_text(input: &mut Input) -> Result<Parsed> {
    let mut lines = Lines::new(input);
    let Some(header) = lines.peek_content()?.and_then(text_header) else {
        return Err(lines.bad("expected the number of rays and the length unit"));
    };
    lines.advance();
    let columns = lines.peek_content()?.map_or(0, |line| RowSeparator::Blank.split(line).count());
    // Seven columns do not say what the flux is in; eight are watts and µm, as in `.SDF`.
    let (layout, unit) = match columns {
        8 => (spectral_layout(), FluxUnit::Watt),
        _ => (Layout::seven_columns(), FluxUnit::Unstated),
    };
    let layout = Layout { mm_per_unit: header.mm_per_unit, ..layout };
    let table = RowFormat {
        layout: &layout,
        unit,
        separator: RowSeparator::Blank,
        decimal: DecimalMark::Point,
        end: None,
    };
    let rays = lines.read_rows(&table)?;
    if rays.tally.rays != header.rays {
        return Err(input.bad(format!(
            "the first line promises {} rays, the file holds {}",
            header.rays, rays.tally.rays
        )));
    }
    let mut parsed = Parsed::new(Format::ZemaxText, rays, unit);
    if columns == 8 {
        parsed.spectrum = FileSpectrum::PerRay;
    }
    Ok(parsed)
}
