//! LightTools ray data: binary of versions 2 and 3, and ASCII.
//!
//! The rays' flux is relative and scaled to the header's total. Polarized records of version 3 are
//! wider than anything published says, and refused by their size.

use super::binary::{ByteOrder, RayBlock};
use super::input::{Header, Input};
use super::lines::{Lines, RowFormat, RowSeparator};
use super::record::Layout;
use super::spectral::Tag;
use super::{FileSpectrum, FluxUnit, Format, Parsed, Warning, known};
use crate::columns::DecimalMark;
use crate::error::Result;

pub(super) const MAGIC: &[u8] = b"LTRF";
const TRAILER: &[u8] = b"LTRFEND";
const HEADER_BYTES: u64 = 44;

mod offset {
    pub const MAJOR: usize = 4;
    pub const DATA_TYPE: usize = 12;
    pub const FAR_FIELD: usize = 16;
    pub const COLOR: usize = 20;
    pub const LENGTH_UNIT: usize = 24;
    pub const ORIGIN: usize = 28;
    pub const FLUX: usize = 40;
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Color {
    None,
    Tristimulus,
    Wavelength,
}

/// What both encodings state.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Heading {
    unit: FluxUnit,
    far_field: bool,
    color: Color,
    /// `None`: the length unit of the model that wrote the file.
    mm_per_unit: Option<f64>,
    origin: [f64; 3],
    flux: Option<f64>,
}

impl Heading {
    fn layout(&self) -> Layout {
        let direction = if self.far_field { 0 } else { 3 };
        let first = direction + 3;
        // Y of X Y Z is the luminous flux.
        let (columns, flux, tag) = match self.color {
            Color::None => (first + 1, first, Tag::None),
            Color::Tristimulus => (first + 3, first + 1, Tag::None),
            Color::Wavelength => {
                (first + 2, first, Tag::Wavelength { column: first + 1, nm_per_unit: 1.0 })
            }
        };
        Layout {
            columns,
            position: (!self.far_field).then_some(0),
            direction,
            flux,
            radiant: None,
            tag,
            mm_per_unit: self.mm_per_unit.unwrap_or(1.0),
        }
    }

    fn fill(&self, parsed: &mut Parsed) {
        parsed.header_flux = self.flux;
        if self.color == Color::Wavelength {
            parsed.spectrum = FileSpectrum::PerRay;
        }
        if self.mm_per_unit.is_none() {
            parsed.warnings.push(Warning::UnstatedLengthUnit);
        }
        if self.origin != [0.0; 3] {
            parsed.warnings.push(Warning::OriginNotApplied { origin: self.origin });
        }
    }
}

pub(super) fn read_binary(input: &mut Input) -> Result<Parsed> {
    let header = Header(input.take(HEADER_BYTES, "the header")?);
    match header.u32(offset::MAJOR) {
        2 => {}
        3 => {
            // Whether the rays are polarized; the size tells whether they are wider for it.
            input.take(4, "the polarization word")?;
        }
        other => return Err(input.bad(format!("LightTools version {other}, allowed: 2 and 3"))),
    }
    let statement = binary_statement(input, &header)?;
    let layout = statement.layout();
    let trailer_bytes = TRAILER.len() as u64;
    let record_bytes = 4 * layout.columns as u64;
    let ray_bytes = input.bytes_left().checked_sub(trailer_bytes);
    let Some(rays) = ray_bytes.filter(|b| b % record_bytes == 0).map(|b| b / record_bytes) else {
        return Err(input.bad(format!(
            "{} bytes after the header are not whole rays of {record_bytes} bytes and \"LTRFEND\"",
            input.bytes_left()
        )));
    };
    let block = RayBlock { layout: &layout, unit: statement.unit, rays, order: ByteOrder::Little };
    let rays = block.read(input, trailer_bytes)?;
    if input.take(trailer_bytes, "the end mark")? != TRAILER {
        return Err(input.bad("the file does not end with \"LTRFEND\""));
    }
    let mut parsed = Parsed::new(Format::LightToolsBinary, rays, statement.unit);
    statement.fill(&mut parsed);
    Ok(parsed)
}

fn binary_statement(input: &Input, header: &Header) -> Result<Heading> {
    let bad = |what: &str, found: u32, allowed: &str| {
        Err(input.bad(format!("{what} {found}, allowed: {allowed}")))
    };
    let unit = match header.u32(offset::DATA_TYPE) {
        0 => FluxUnit::Watt,
        1 => FluxUnit::Lumen,
        other => return bad("data type", other, "0 and 1"),
    };
    let far_field = match header.u32(offset::FAR_FIELD) {
        0 => false,
        1 => true,
        other => return bad("far-field flag", other, "0 and 1"),
    };
    let color = match header.u32(offset::COLOR) {
        0 => Color::None,
        1 => Color::Tristimulus,
        2 => Color::Wavelength,
        other => return bad("color information", other, "0 to 2"),
    };
    let mm_per_unit = match header.u32(offset::LENGTH_UNIT) {
        0 => None,
        1 => Some(1.0),
        2 => Some(10.0),
        3 => Some(1000.0),
        4 => Some(25.4),
        5 => Some(304.8),
        6 => Some(1e-3),
        7 => Some(1e-6),
        other => return bad("length unit", other, "0 to 7"),
    };
    let origin = [0, 4, 8].map(|i| f64::from(header.f32(offset::ORIGIN + i)));
    let flux = known(header.f32(offset::FLUX));
    Ok(Heading { unit, far_field, color, mm_per_unit, origin, flux })
}

const START: &[u8] = b"lt_startofdata";
const END: &str = "lt_endofdata";

/// Whether one of the first lines has a key of the format.
pub(super) fn is_ascii(head: &[u8]) -> bool {
    head.split(|&b| b == b'\n').any(|line| {
        let line = line.trim_ascii();
        line.starts_with(b"lt_rdf_version") || line.starts_with(b"lt_datatype") || line == START
    })
}

pub(super) fn read_ascii(input: &mut Input) -> Result<Parsed> {
    let mut lines = Lines::new(input);
    let (statement, name) = ascii_statement(&mut lines)?;
    let layout = statement.layout();
    let rays = lines.read_rows(&RowFormat {
        layout: &layout,
        unit: statement.unit,
        separator: RowSeparator::Blank,
        decimal: DecimalMark::Point,
        end: Some(END),
    })?;
    let mut parsed = Parsed::new(Format::LightToolsAscii, rays, statement.unit);
    statement.fill(&mut parsed);
    parsed.describe("data name", name);
    Ok(parsed)
}

/// The lines up to the start of the data: what they state, and the data's name.
fn ascii_statement(lines: &mut Lines) -> Result<(Heading, String)> {
    let mut name = String::new();
    let mut statement = Heading {
        unit: FluxUnit::Unstated,
        far_field: false,
        color: Color::None,
        mm_per_unit: None,
        origin: [0.0; 3],
        flux: None,
    };
    loop {
        let Some(line) = lines.peek_content()? else {
            return Err(lines.bad("the file ends without \"lt_startofdata\""));
        };
        let is_start = line.starts_with(START);
        let line = String::from_utf8_lossy(line).into_owned();
        let (key, value) = line.split_once(':').unwrap_or((&line, ""));
        let (key, value) = (key.trim(), value.trim());
        if key == "dataname" {
            name = value.to_owned();
        }
        if statement.state(key, &value.to_ascii_lowercase()).is_none() {
            return Err(lines.bad(format!("\"{key}\" is \"{value}\", which is not known")));
        }
        lines.advance();
        if is_start {
            return Ok((statement, name));
        }
    }
}

impl Heading {
    /// Takes in a header line; `None` if its value is not known. Other keys change nothing.
    fn state(&mut self, key: &str, word: &str) -> Option<()> {
        match key {
            "lt_datatype" => self.unit = data_type(word)?,
            "lt_far_field_data" => self.far_field = yes_or_no(word)?,
            "lt_color_info" => self.color = color(word)?,
            "lt_length_units" => self.mm_per_unit = length_unit(word)?,
            "lt_data_origin" => self.origin = origin(word)?,
            "lt_radiant_flux" | "lt_luminous_flux" => self.flux = known(word.parse().ok()?),
            _ => {}
        }
        Some(())
    }
}

fn yes_or_no(word: &str) -> Option<bool> {
    match word {
        "yes" => Some(true),
        "no" => Some(false),
        _ => None,
    }
}

fn data_type(word: &str) -> Option<FluxUnit> {
    match word {
        "radiant_power" | "radiant_flux" => Some(FluxUnit::Watt),
        "luminous_flux" | "luminous_power" => Some(FluxUnit::Lumen),
        _ => None,
    }
}

fn color(word: &str) -> Option<Color> {
    match word {
        "none" => Some(Color::None),
        "tristimulus" | "cie_tristimulus" => Some(Color::Tristimulus),
        "wavelength" => Some(Color::Wavelength),
        _ => None,
    }
}

/// `Some(None)` for the unit of the writing model.
fn length_unit(word: &str) -> Option<Option<f64>> {
    match word {
        "system" => Some(None),
        "millimeters" | "mm" => Some(Some(1.0)),
        "centimeters" | "cm" => Some(Some(10.0)),
        "meters" | "m" => Some(Some(1000.0)),
        "inches" | "in" => Some(Some(25.4)),
        "feet" | "ft" => Some(Some(304.8)),
        "microns" | "micrometers" => Some(Some(1e-3)),
        "nanometers" | "nm" => Some(Some(1e-6)),
        _ => None,
    }
}

fn origin(words: &str) -> Option<[f64; 3]> {
    let cells: Option<Vec<f64>> = words.split_whitespace().map(|cell| cell.parse().ok()).collect();
    cells?.try_into().ok()
}
