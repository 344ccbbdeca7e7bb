//! IES TM-25-13: a header of fixed offsets, spectral tables, names, text, then rows of f32.

use super::binary::{ByteOrder, RayBlock};
use super::input::{Header, Input};
use super::record::Layout;
use super::spectral::{SpectralTable, Tag};
use super::{FileSpectrum, FluxUnit, Format, Parsed, Warning, known};
use crate::error::Result;
use crate::spectrum::Spectrum;

pub(super) const MAGIC: &[u8] = b"TM25";

/// Up to the spectral tables.
pub(super) const HEADER_BYTES: usize = 36_288;
pub(super) const VERSION: i32 = 2013;

/// Byte offsets of the header's fields.
pub(super) mod offset {
    pub const VERSION: usize = 4;
    pub const METHOD: usize = 8;
    pub const LUMINOUS_FLUX: usize = 12;
    pub const RADIANT_FLUX: usize = 16;
    pub const RAYS: usize = 20;
    pub const DATE: usize = 28;
    pub const SPECTRAL_ID: usize = 60;
    pub const WAVELENGTHS: usize = 64;
    pub const TABLES: usize = 76;
    pub const ADDITIONAL_ITEMS: usize = 80;
    pub const TEXT_BYTES: usize = 84;
    pub const FLAGS: usize = 256;
    pub const DESCRIPTIONS: usize = 288;
}

pub(super) const DATE_BYTES: usize = 28;
pub(super) const DESCRIPTION_BYTES: usize = 4000;
/// Index of the file creator among the descriptions.
pub(super) const FILE_CREATOR: usize = 3;
const DESCRIPTIONS: [&str; 9] = [
    "source name",
    "source maker",
    "model creator",
    "file creator",
    "equipment or software",
    "camera",
    "operation",
    "more information",
    "geometry reference",
];

/// UTF-32 characters of an additional column's name, 4 bytes each.
const ITEM_NAME_BYTES: u64 = 512;

/// Spectral tables are padded to a multiple of this.
pub(super) const TABLE_BLOCK_BYTES: u64 = 32;

/// A table of one row takes 12 bytes in the file and about 2 kB here; the bound keeps a small file
/// from asking for much memory.
const MOST_TABLES: u64 = 10_000;

/// Which columns follow position and direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Flags {
    radiant: bool,
    wavelength: bool,
    luminous: bool,
    stokes: bool,
    tristimulus: bool,
    spectrum_index: bool,
}

impl Flags {
    fn read(input: &Input, header: &Header) -> Result<Self> {
        let mut flags = [false; 8];
        for (i, flag) in flags.iter_mut().enumerate() {
            *flag = match header.i32(offset::FLAGS + 4 * i) {
                0 => false,
                1 => true,
                other => {
                    let problem = format!("column flag {} is {other}, allowed: 0 or 1", i + 1);
                    return Err(input.bad(problem));
                }
            };
        }
        let [position, direction, radiant, wavelength, luminous, stokes, tristimulus, index] =
            flags;
        if !(position && direction) {
            return Err(input.bad("the rays have no start points or no directions"));
        }
        if !(radiant || luminous) {
            return Err(input.bad("the rays have no flux, neither radiant nor luminous"));
        }
        Ok(Self { radiant, wavelength, luminous, stokes, tristimulus, spectrum_index: index })
    }
}

/// Column numbers of a record.
#[derive(Debug, Default)]
struct Tm25Columns {
    radiant: Option<usize>,
    wavelength: Option<usize>,
    luminous: Option<usize>,
    spectrum_index: Option<usize>,
    count: usize,
}

impl Tm25Columns {
    fn new(flags: Flags, additional: usize) -> Self {
        let mut count = 6;
        let mut next = |present: bool, width: usize| {
            let column = present.then_some(count);
            count += if present { width } else { 0 };
            column
        };
        let radiant = next(flags.radiant, 1);
        let wavelength = next(flags.wavelength, 1);
        let luminous = next(flags.luminous, 1);
        // S1 S2 S3 and the axis of the polarization ellipse.
        next(flags.stokes, 6);
        // X and Z; Y is the luminous flux.
        next(flags.tristimulus, 2);
        let spectrum_index = next(flags.spectrum_index, 1);
        next(additional > 0, additional);
        Self { radiant, wavelength, luminous, spectrum_index, count }
    }
}

pub(super) fn read(input: &mut Input) -> Result<Parsed> {
    let header = Header(input.take(HEADER_BYTES as u64, "the header")?);
    check_version(input, &header)?;
    let flags = Flags::read(input, &header)?;
    let tables = read_tables(input, &header)?;
    let additional = count(input, &header, offset::ADDITIONAL_ITEMS, "additional items")?;
    let names = input.take(additional * ITEM_NAME_BYTES, "the names of additional items")?;
    let text_bytes = count(input, &header, offset::TEXT_BYTES, "bytes of additional text")?;
    let text = input.take(text_bytes, "the additional text")?;

    let columns = Tm25Columns::new(flags, additional as usize);
    let (tag, spectrum) = spectrum_of(input, &header, &columns, tables)?;
    let unit = if flags.luminous { FluxUnit::Lumen } else { FluxUnit::Watt };
    let flux = columns.luminous.or(columns.radiant).unwrap_or_default();
    let layout = Layout {
        columns: columns.count,
        flux,
        radiant: columns.radiant.filter(|&radiant| flux != radiant && tag.column().is_some()),
        tag,
        ..Layout::seven_columns()
    };
    let rays = header.u64(offset::RAYS);
    let rays = RayBlock { layout: &layout, unit, rays, order: ByteOrder::Little }.read(input, 0)?;

    let mut parsed = Parsed::new(Format::Tm25, rays, unit);
    let header_lm = flux_field(input, &header, offset::LUMINOUS_FLUX)?;
    let header_w = flux_field(input, &header, offset::RADIANT_FLUX)?;
    parsed.header_flux = if flags.luminous { header_lm } else { header_w };
    parsed.header_lm = header_lm;
    parsed.spectrum = spectrum;
    parsed.description = description(&header, &names, &text);
    let version = header.i32(offset::VERSION);
    if version != VERSION {
        parsed.warnings.push(Warning::UnknownVersion { found: version.to_string() });
    }
    Ok(parsed)
}

fn check_version(input: &Input, header: &Header) -> Result<()> {
    match header.i32(offset::VERSION) {
        2013..=2099 => Ok(()),
        other => Err(input.bad(format!("TM-25 version {other}, expected {VERSION}"))),
    }
}

fn count(input: &Input, header: &Header, at: usize, what: &str) -> Result<u64> {
    let value = header.i32(at);
    u64::try_from(value).map_err(|_| input.bad(format!("{value} {what}, allowed: 0 or more")))
}

fn flux_field(input: &Input, header: &Header, at: usize) -> Result<Option<f64>> {
    match header.f32(at) {
        flux if flux.is_infinite() => Err(input.bad(format!("the header's flux is {flux}"))),
        flux => Ok(known(flux)),
    }
}

fn read_tables(input: &mut Input, header: &Header) -> Result<Vec<SpectralTable>> {
    let count = count(input, header, offset::TABLES, "spectral tables")?;
    if count > MOST_TABLES {
        return Err(input.bad(format!("{count} spectral tables, allowed: up to {MOST_TABLES}")));
    }
    let mut tables = Vec::new();
    let mut bytes = 0;
    for number in 1..=count {
        let what = format!("spectral table {number}");
        let rows = Header(input.take(4, &what)?).i32(0);
        let rows = u64::try_from(rows)
            .map_err(|_| input.bad(format!("{what} has {rows} rows, allowed: 1 or more")))?;
        let cells = Header(input.take(8 * rows, &what)?);
        bytes += 4 + 8 * rows;
        let pairs = (0..rows as usize)
            .map(|row| (f64::from(cells.f32(8 * row)), f64::from(cells.f32(8 * row + 4))));
        tables.push(table(input, &what, pairs.collect())?);
    }
    input.take(bytes.next_multiple_of(TABLE_BLOCK_BYTES) - bytes, "the padding of the tables")?;
    Ok(tables)
}

fn table(input: &Input, what: &str, rows: Vec<(f64, f64)>) -> Result<SpectralTable> {
    if let Some((nm, weight)) = rows.iter().find(|(_, weight)| *weight < 0.0) {
        return Err(input.bad(format!("{what} is {weight} at {nm} nm, allowed: 0 or more")));
    }
    let spectrum = Spectrum::from_pairs(what, rows).map_err(|e| input.bad(e.to_string()))?;
    SpectralTable::new(spectrum).ok_or_else(|| input.bad(format!("{what} carries no power")))
}

/// What the rays' tag is, and what the header says for all rays.
fn spectrum_of(
    input: &Input,
    header: &Header,
    columns: &Tm25Columns,
    tables: Vec<SpectralTable>,
) -> Result<(Tag, FileSpectrum)> {
    let radiant = columns.radiant.is_some();
    match header.i32(offset::SPECTRAL_ID) {
        0 => Ok((Tag::None, FileSpectrum::None)),
        1 => match known(header.f32(offset::WAVELENGTHS)) {
            Some(nm) => Ok((Tag::None, FileSpectrum::Line { table: SpectralTable::line(nm), nm })),
            None => Err(input.bad("spectral identifier 1 without a wavelength")),
        },
        2 => match columns.wavelength {
            Some(column) if radiant => {
                Ok((Tag::Wavelength { column, nm_per_unit: 1.0 }, FileSpectrum::PerRay))
            }
            _ => Err(input.bad("spectral identifier 2 without wavelengths or radiant flux")),
        },
        3 => match tables.into_iter().next() {
            Some(table) => Ok((Tag::None, FileSpectrum::Table { table })),
            None => Err(input.bad("spectral identifier 3 without a spectral table")),
        },
        4 => match columns.spectrum_index {
            Some(column) if !tables.is_empty() => {
                let found = FileSpectrum::Mixture { tables: tables.len() };
                Ok((Tag::Table { column, tables: tables.into() }, found))
            }
            _ => Err(input.bad("spectral identifier 4 without spectral tables or indices")),
        },
        other => Err(input.bad(format!("spectral identifier {other}, allowed: 0 to 4"))),
    }
}

fn description(header: &Header, names: &[u8], text: &[u8]) -> Vec<(String, String)> {
    let fields = (0..).zip(DESCRIPTIONS).map(|(i, name)| {
        let start = offset::DESCRIPTIONS + i * DESCRIPTION_BYTES;
        (name, utf32(&header.0[start..start + DESCRIPTION_BYTES]))
    });
    let method = match header.i32(offset::METHOD) {
        0 => "simulation",
        1 => "measurement",
        _ => "",
    };
    let names = names.chunks(ITEM_NAME_BYTES as usize).map(utf32).collect::<Vec<_>>().join(", ");
    let mut all =
        vec![("created", header.text(offset::DATE, DATE_BYTES)), ("method", method.to_owned())];
    all.extend(fields);
    all.push(("additional columns", names));
    all.push(("additional text", utf32(text)));
    all.into_iter().filter(|(_, v)| !v.is_empty()).map(|(k, v)| (k.to_owned(), v)).collect()
}

/// Characters up to the first NUL.
fn utf32(bytes: &[u8]) -> String {
    let (words, _) = bytes.as_chunks::<4>();
    let codes = words.iter().map(|&word| u32::from_le_bytes(word)).take_while(|&code| code != 0);
    let text: String = codes.map(|c| char::from_u32(c).unwrap_or('\u{fffd}')).collect();
    text.trim().to_owned()
}
