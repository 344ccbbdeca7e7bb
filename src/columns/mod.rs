//! Tables of numbers in text files, as instruments, spreadsheets and people write them.
//!
//! One reader serves spectra, lobes, ramps, patches and limits. It finds by content how the text is
//! encoded, what parts the columns, what marks decimals, where the rows start and end, and what
//! the columns are called; [`TableReading`] says what it found. What could mean two things is refused
//! with the line.

mod block;
mod bsdf;
mod built_in;
mod cells;
mod cgats;
mod encoding;
mod foreign;
mod jcamp;
mod spdx;
pub mod units;
mod wavelengths;

use std::fmt;
use std::path::{Path, PathBuf};

pub use bsdf::{Scatter, ScatterKind};
pub(crate) use built_in::built_in_rows;
pub use cells::{DecimalMark, LineCells, Separator, Style};
pub use encoding::Encoding;
pub use foreign::hint_of_content;
pub use wavelengths::{TableChoice, WavelengthCurve};

use crate::error::{Error, Place, Result};
use crate::input;

/// The kind of file that a table was read from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TableFormat {
    /// Rows of cells, whatever stands around them.
    Rows,
    /// CGATS: Argyll's `.sp` and `.ti3`, and what X-Rite's programs write.
    Cgats,
    /// JCAMP-DX.
    Jcamp,
    /// IES TM-27 `.spdx`.
    Spdx,
    /// Zemax `.bsdf`.
    Bsdf,
    /// ASTM E1392.
    Astm,
}

impl fmt::Display for TableFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Rows => "table",
            Self::Cgats => "CGATS table",
            Self::Jcamp => "JCAMP-DX spectrum",
            Self::Spdx => "IES TM-27 spectrum",
            Self::Bsdf => "Zemax BSDF",
            Self::Astm => "ASTM E1392 scatter",
        })
    }
}

/// What a file was taken for.
#[derive(Debug, Clone, PartialEq)]
pub struct TableReading {
    /// Kind of file.
    pub format: TableFormat,
    /// The instrument or program that its header names.
    pub instrument: Option<&'static str>,
    /// How the text is stored.
    pub encoding: Encoding,
    /// How the rows are written.
    pub style: Style,
    /// What was left aside, converted or decided, a sentence each.
    pub notes: Vec<String>,
}

impl TableReading {
    /// For `lampyris info`, a line each.
    pub fn lines(&self) -> Vec<String> {
        let mut lines = vec![match self.instrument {
            Some(instrument) => format!("{} of {instrument}", self.format),
            None => self.format.to_string(),
        }];
        let Style { separator, decimal } = self.style;
        lines.push(format!("{}, columns parted by {separator}, decimal {decimal}", self.encoding));
        lines.extend(self.notes.iter().cloned());
        lines
    }
}

/// A table as a file has it.
#[derive(Debug, Clone)]
pub struct Table {
    path: PathBuf,
    /// What the file was taken for.
    pub reading: TableReading,
    /// Names of the columns, in order; empty where the file has none.
    pub names: Vec<String>,
    /// Keywords of a header and their values, where the format has them.
    keywords: Vec<(String, String)>,
    text: String,
    rows: Vec<Line>,
}

/// A line of a text, by its bytes.
#[derive(Debug, Clone, Copy)]
struct Line {
    start: u32,
    end: u32,
    /// 1-based.
    number: u32,
}

impl Line {
    /// `part` is a part of `text`.
    fn of(text: &str, part: &str, number: u32) -> Self {
        let start = part.as_ptr().addr() - text.as_ptr().addr();
        Self { start: start as u32, end: (start + part.len()) as u32, number }
    }

    fn text<'a>(&self, text: &'a str) -> &'a str {
        &text[self.start as usize..self.end as usize]
    }

    fn problem(&self, what: String) -> TextProblem {
        TextProblem { line: u64::from(self.number), what }
    }
}

/// What is wrong with a text, before it is known which file it is.
#[derive(Debug, Clone, PartialEq)]
struct TextProblem {
    /// 1-based; 0 for the whole.
    line: u64,
    what: String,
}

impl TextProblem {
    fn at(self, path: &Path) -> Error {
        let place = if self.line == 0 { Place::File } else { Place::Line(self.line) };
        Error::bad_file(path, place, self.what)
    }
}

/// What a reader of a format finds.
struct Found {
    format: TableFormat,
    style: Style,
    names: Vec<String>,
    keywords: Vec<(String, String)>,
    rows: Vec<Line>,
    notes: Vec<String>,
    /// In place of the file's text, where rows had to be written anew.
    text: Option<String>,
}

/// More is no table that anyone measured, and lines are counted by 32 bits.
const MOST_BYTES: u64 = 1 << 30;

/// A row of a table.
#[derive(Debug, Clone, Copy)]
pub struct TableRow<'a> {
    table: &'a Table,
    line: Line,
}

impl Table {
    /// Reads a file of any of the kinds of [`TableFormat`].
    ///
    /// Errors: [`Error::Io`]; [`Error::BadFile`], with the line where there is one, for text that is
    /// binary, ambiguous or broken. A file without rows is a table without rows.
    pub fn read(path: &Path) -> Result<Self> {
        Self::from_bytes(path, input::head(path, MOST_BYTES + 1)?)
    }

    /// As [`Self::read`]; `path` only names the bytes in messages.
    pub fn from_bytes(path: &Path, bytes: Vec<u8>) -> Result<Self> {
        if bytes.len() as u64 > MOST_BYTES {
            let problem = format!("is larger than {} MiB, which no table is", MOST_BYTES >> 20);
            return Err(Error::bad_file(path, Place::File, problem));
        }
        let (text, encoding) = decoded(path, bytes)?;
        let instrument = instrument_of(&text);
        let found = find(&text).map_err(|problem| problem.at(path))?;
        let Found { format, style, names, keywords, rows, notes, text: anew } = found;
        let reading = TableReading { format, instrument, encoding, style, notes };
        let text = anew.unwrap_or(text);
        Ok(Self { path: path.to_owned(), reading, names, keywords, text, rows })
    }

    /// The file that it was read from.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Number of rows.
    pub fn row_count(&self) -> usize {
        self.rows.len()
    }

    /// In the file's order.
    pub fn rows(&self) -> impl Iterator<Item = TableRow<'_>> {
        self.rows.iter().map(|&line| TableRow { table: self, line })
    }

    /// The value of a keyword of the header, whatever its case.
    pub fn keyword(&self, name: &str) -> Option<&str> {
        let mut found = self.keywords.iter().filter(|(key, _)| key.eq_ignore_ascii_case(name));
        found.next().map(|(_, value)| value.as_str())
    }

    /// The column (0-based) whose name is one of these, whatever its case.
    pub fn column(&self, names: &[&str]) -> Option<usize> {
        let is_name = |name: &String| names.iter().any(|n| n.eq_ignore_ascii_case(name.trim()));
        self.names.iter().position(is_name)
    }

    /// Refuses rows of more than two columns parted by commas, of which no header tells the number,
    /// and whose numbers have no points: 380,0,850 may be 380 and 0.850.
    ///
    /// Errors: [`Error::BadFile`] with the first row's line.
    pub fn check_commas(&self) -> Result<()> {
        let Style { separator, .. } = self.reading.style;
        let width = self.rows().map(|row| row.cells().count()).max().unwrap_or_default();
        let is_clear = width <= 2 || self.names.len() == width;
        if separator == Separator::Comma
            && !is_clear
            && block::may_be_decimal_commas(&self.text, self.reading.style, &self.rows)
            && let Some(row) = self.rows().next()
        {
            let problem = format!("a column too many (\"{}\"){}", row.text(), block::DECIMAL_COMMA);
            return Err(row.bad(problem));
        }
        Ok(())
    }
}

/// The text of a file, whatever its encoding; `path` only names it in messages.
///
/// Errors: [`Error::BadFile`] for packed files and others that are no text.
pub fn text_of(path: &Path, bytes: Vec<u8>) -> Result<String> {
    decoded(path, bytes).map(|(text, _)| text)
}

fn decoded(path: &Path, bytes: Vec<u8>) -> Result<(String, Encoding)> {
    if let Some(hint) = hint_of_content(&bytes) {
        return Err(Error::bad_file(path, Place::File, hint));
    }
    encoding::decode(bytes).map_err(|line| {
        let what = "a control character: the file is no text".to_owned();
        TextProblem { line, what }.at(path)
    })
}

impl<'a> TableRow<'a> {
    /// 1-based.
    pub fn line(&self) -> u64 {
        u64::from(self.line.number)
    }

    fn text(&self) -> &'a str {
        self.line.text(&self.table.text)
    }

    /// In order.
    pub fn cells(&self) -> LineCells<'a> {
        self.table.reading.style.cells(self.text())
    }

    /// The number in a column (0-based).
    ///
    /// Errors: [`Error::BadFile`] with the line.
    pub fn number(&self, column: usize) -> Result<f64> {
        let Some(cell) = self.cells().nth(column) else {
            let (has, text) = (self.cells().count(), self.text());
            return Err(
                self.bad(format!("no column {}, the row has {has} (\"{text}\")", column + 1))
            );
        };
        let number = self.table.reading.style.number(cell);
        number.ok_or_else(|| {
            self.bad(format!("column {} is \"{cell}\", expected a number", column + 1))
        })
    }

    /// The numbers from a column (0-based) on.
    ///
    /// Errors: [`Error::BadFile`] with the line.
    pub fn numbers_from(&self, first: usize) -> Result<Vec<f64>> {
        (first..self.width()).map(|column| self.number(column)).collect()
    }

    /// Number of cells, without empty ones at the end.
    pub fn width(&self) -> usize {
        let filled = self.cells().enumerate().filter(|(_, cell)| !cell.is_empty());
        filled.last().map_or(0, |(at, _)| at + 1)
    }

    /// The row has another number of cells than is expected.
    pub fn wrong_width(&self, expected: &str) -> Error {
        let table = self.table;
        let commas = block::may_be_decimal_commas(&table.text, table.reading.style, &table.rows);
        let hint = if commas { block::DECIMAL_COMMA } else { "" };
        self.bad(format!("has {} columns, expected {expected}{hint}", self.width()))
    }

    /// An error at this line.
    pub fn bad(&self, problem: impl Into<String>) -> Error {
        Error::bad_file(&self.table.path, Place::Line(self.line()), problem)
    }
}

fn find(text: &str) -> std::result::Result<Found, TextProblem> {
    let start = text.trim_start();
    if start.starts_with('<') {
        return spdx::read(text);
    }
    if start.starts_with("##") {
        return jcamp::read(text);
    }
    if cgats::is_cgats(text) {
        return cgats::read(text);
    }
    if bsdf::is_zemax(text) {
        return bsdf::read_zemax(text);
    }
    if bsdf::is_astm(text) {
        return bsdf::read_astm(text);
    }
    rows(text)
}

/// A text without a format of its own.
fn rows(text: &str) -> std::result::Result<Found, TextProblem> {
    let format = TableFormat::Rows;
    let (keywords, notes) = (Vec::new(), Vec::new());
    if let Some((style, rows, header)) = wavelengths::in_a_header(text) {
        let names = style.cells(header.text(text)).map(str::to_owned).collect();
        return Ok(Found { format, style, names, keywords, rows, notes, text: None });
    }
    let Some(block) = block::find(text)? else {
        let style = Style::ALL[0];
        let (names, rows) = (Vec::new(), Vec::new());
        return Ok(Found { format, style, names, keywords, rows, notes, text: None });
    };
    let names = names(text, &block);
    let mut notes = Vec::new();
    if block.above > 0 {
        notes.push(format!("{} lines above the rows", block.above));
    }
    if let Some(end) = block.end {
        let (count, line) = (block.below, end.number);
        notes.push(format!("{count} lines below, from \"{}\" in line {line}", end.text(text)));
    }
    Ok(Found { format, style: block.style, names, keywords, rows: block.rows, notes, text: None })
}

/// Names of the columns from the lines above the rows: words, as many as there are columns or more;
/// of two such lines the lower one holds units.
fn names(text: &str, block: &block::NumberBlock) -> Vec<String> {
    let width = block.rows.first().map_or(0, |row| block.style.cells(row.text(text)).count());
    let mut names: Vec<String> = Vec::new();
    for line in &block.header {
        let cells: Vec<&str> = block.style.cells(line.text(text)).collect();
        let words = cells.iter().filter(|cell| block.style.number(cell).is_none()).count();
        if cells.len() < width.min(2) || 2 * words < cells.len() {
            continue;
        }
        if names.is_empty() {
            names = cells.iter().map(|cell| (*cell).to_owned()).collect();
        } else if names.iter().all(|unit| unit.is_empty() || unit.starts_with('[')) {
            for (at, cell) in cells.iter().enumerate().take(names.len()) {
                names[at] = format!("{cell} {}", names[at]).trim().to_owned();
            }
        }
    }
    names
}

/// Programs and instruments that say who they are above their rows.
const INSTRUMENTS: [(&str, &str); 12] = [
    ("CS-1000", "Konica Minolta CS-1000"),
    ("CS-2000", "Konica Minolta CS-2000"),
    ("CM-3600", "Konica Minolta CM-3600"),
    ("CM-S100w", "Konica Minolta SpectraMagic"),
    ("SpectraMagic", "Konica Minolta SpectraMagic"),
    ("SpectraSuite", "Ocean Optics SpectraSuite"),
    ("OceanView", "Ocean Optics OceanView"),
    ("OOIBase", "Ocean Optics OOIBase"),
    ("Begin Spectral Data", "Ocean Optics"),
    ("AvaSoft", "Avantes AvaSoft"),
    ("Avantes", "Avantes"),
    ("Argyll", "Argyll"),
];

fn instrument_of(text: &str) -> Option<&'static str> {
    let end = text.char_indices().nth(4096).map_or(text.len(), |(at, _)| at);
    let head = &text[..end];
    INSTRUMENTS.iter().find(|(mark, _)| head.contains(mark)).map(|(_, name)| *name)
}

#[cfg(test)]
mod tests;
