//! Values over wavelength out of a table: two of its columns, or one row under a row of wavelengths.

use super::cells::Style;
use super::units::{self, WavelengthUnit};
use super::{Line, Table, TableRow, block};
use crate::error::{self, Error, Place, Result};

/// Which part of a table is wanted.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TableChoice {
    /// Column of the values, 1-based; else the one after the wavelengths.
    pub column: Option<usize>,
    /// Where samples stand in rows, the number (from 1) or the name of one.
    pub row: Option<String>,
}

/// Values over wavelength.
#[derive(Debug, Clone, PartialEq)]
pub struct WavelengthCurve {
    /// Strictly ascending, finite, > 0, nm; no less than one.
    pub lambda_nm: Vec<f64>,
    /// Finite, one a wavelength.
    pub values: Vec<f64>,
    /// What was converted or turned, a sentence each.
    pub notes: Vec<String>,
}

/// A wavelength, its value, and their line.
type SpectrumEntry = (f64, f64, u64);

/// Fewest columns of wavelengths that are told as such.
const MIN_WAVELENGTHS: usize = 8;
/// The widest step of a spectrometer, nm.
const MAX_STEP_NM: f64 = 50.0;
/// Lines above which a row of wavelengths stands.
const HEADER_LINES: usize = 300;

impl Table {
    /// Values over wavelength.
    ///
    /// Errors: [`Error::BadFile`] with the line for a cell that is no number, for wavelengths that
    /// are in another unit than the header says or in another than nm where it says nothing, twice
    /// there, or neither ascending nor descending; for several samples of which none is chosen.
    pub fn curve(&self, choice: &TableChoice) -> Result<WavelengthCurve> {
        let mut notes = Vec::new();
        let entries = match sample_columns(&self.names) {
            Some(columns) => self.sample(&columns, choice, &mut notes)?,
            None if choice.row.is_some() => {
                let problem = "samples are not in rows, but \"row\" is given: give \"column\"";
                return Err(Error::bad_file(self.path(), Place::File, problem));
            }
            None => self.two_columns(choice, &mut notes)?,
        };
        if entries.is_empty() {
            let problem = "no rows, expected wavelength in nm and value";
            return Err(Error::bad_file(self.path(), Place::File, problem));
        }
        let entries = self.ascending(entries, &mut notes)?;
        let (lambda_nm, values) = entries.into_iter().map(|(nm, value, _)| (nm, value)).unzip();
        Ok(WavelengthCurve { lambda_nm, values, notes })
    }

    fn two_columns(
        &self,
        choice: &TableChoice,
        notes: &mut Vec<String>,
    ) -> Result<Vec<SpectrumEntry>> {
        self.check_commas()?;
        let of_wavelength = self.names.iter().position(|name| units::is_wavelength(name));
        let lambda = of_wavelength.unwrap_or(0);
        let column = choice.column.map_or(lambda + 1, |column| column - 1);
        let mut entries = Vec::with_capacity(self.row_count());
        for row in self.rows() {
            let (nm, value) = (row.number(lambda)?, row.number(column)?);
            if !(nm.is_finite() && nm > 0.0) {
                let allowed = "allowed: finite and above 0 nm";
                return Err(row.bad(format!("wavelength is {nm}, {allowed}")));
            }
            entries.push((nm, value, row.line()));
        }
        self.to_nm(lambda, &mut entries, notes)?;
        if self.names.get(column).is_some_and(|name| units::is_percent(name)) {
            entries.iter_mut().for_each(|entry| entry.1 /= 100.0);
            notes.push(format!("column {} is in percent: divided by 100", column + 1));
        }
        Ok(entries)
    }

    /// Converts wavelengths by the header's unit, and refuses those that are no nm without one.
    fn to_nm(
        &self,
        column: usize,
        entries: &mut [SpectrumEntry],
        notes: &mut Vec<String>,
    ) -> Result<()> {
        let Some(&(_, _, line)) = entries.first() else { return Ok(()) };
        let low = entries.iter().map(|entry| entry.0).fold(f64::INFINITY, f64::min);
        let high = entries.iter().map(|entry| entry.0).fold(0.0, f64::max);
        let stated = self.names.get(column).and_then(|name| WavelengthUnit::of_header(name));
        let unit = stated.unwrap_or(WavelengthUnit::Nanometer);
        let likely = WavelengthUnit::of_range(low, high);
        let fits = {
            let (a, b) = (unit.to_nm(low), unit.to_nm(high));
            WavelengthUnit::of_range(a.min(b), a.max(b)) == Some(WavelengthUnit::Nanometer)
        };
        if let (false, Some(likely)) = (fits, likely.filter(|likely| *likely != unit)) {
            let range = format!("wavelengths are {low} to {high}");
            let problem = match stated {
                Some(unit) => {
                    format!("{range} by a header that says {}: {}?", unit.name(), likely.name())
                }
                None => format!(
                    "{range}: {}? then say so in the header (\"wavelength ({})\"), or write nm",
                    likely.name(),
                    likely.name()
                ),
            };
            return Err(Error::bad_file(self.path(), Place::Line(line), problem));
        }
        if unit != WavelengthUnit::Nanometer {
            entries.iter_mut().for_each(|entry| entry.0 = unit.to_nm(entry.0));
            notes.push(format!("wavelengths in {} by the header: converted to nm", unit.name()));
        }
        Ok(())
    }

    /// The values of one row under the wavelengths of `columns`.
    fn sample(
        &self,
        columns: &[(usize, f64)],
        choice: &TableChoice,
        notes: &mut Vec<String>,
    ) -> Result<Vec<SpectrumEntry>> {
        let Some(row) = self.chosen_row(choice)? else { return Ok(Vec::new()) };
        let norm = self.keyword("SPECTRAL_NORM").and_then(|norm| norm.parse::<f64>().ok());
        let norm = norm.filter(|norm| *norm > 0.0 && norm.is_finite()).unwrap_or(1.0);
        if norm != 1.0 {
            notes.push(format!("divided by the header's SPECTRAL_NORM {norm}"));
        }
        let named = columns.iter().map(|(_, nm)| *nm);
        let wavelengths: Vec<f64> = match self.stated_wavelengths(columns.len()) {
            Some(stated) => stated,
            None => named.collect(),
        };
        let entry = |(&(column, _), nm): (&(usize, f64), f64)| {
            Ok((nm, row.number(column)? / norm, row.line()))
        };
        columns.iter().zip(wavelengths).map(entry).collect()
    }

    /// Even steps from the header's first to its last wavelength: names are often rounded.
    fn stated_wavelengths(&self, bands: usize) -> Option<Vec<f64>> {
        let number = |name: &str| self.keyword(name)?.parse::<f64>().ok();
        let (first, last) = (number("SPECTRAL_START_NM")?, number("SPECTRAL_END_NM")?);
        let agrees = number("SPECTRAL_BANDS")? == bands as f64 && bands > 1;
        let step = (last - first) / (bands.max(2) - 1) as f64;
        agrees.then(|| (0..bands).map(|band| first + step * band as f64).collect())
    }

    fn chosen_row(&self, choice: &TableChoice) -> Result<Option<TableRow<'_>>> {
        let refuse = |problem: String| Err(Error::bad_file(self.path(), Place::File, problem));
        let count = self.row_count();
        let named = |name: &str| self.rows().find(|row| row.cells().any(|cell| cell == name));
        match choice.row.as_deref() {
            None if count > 1 => refuse(format!(
                "{count} samples in rows, give \"row\", 1 to {count}{}",
                self.sample_names()
            )),
            None => Ok(self.rows().next()),
            Some(row) => match (row.parse::<usize>(), named(row)) {
                (Ok(number), _) if (1..=count).contains(&number) => Ok(self.rows().nth(number - 1)),
                (_, Some(row)) => Ok(Some(row)),
                _ => refuse(format!("no row \"{row}\", give 1 to {count}{}", self.sample_names())),
            },
        }
    }

    /// ` or "a", "b", …`, as many as fit a message.
    fn sample_names(&self) -> String {
        const MOST: usize = 6;
        let style = self.reading.style;
        let name = |row: TableRow| -> Option<String> {
            let cell = row.cells().find(|cell| !cell.is_empty() && style.number(cell).is_none());
            cell.map(|cell| format!("\"{cell}\""))
        };
        let names: Vec<String> = self.rows().filter_map(name).take(MOST).collect();
        match names.as_slice() {
            [] => String::new(),
            names if self.row_count() > MOST => format!(" or {}, …", names.join(", ")),
            names => format!(" or {}", names.join(", ")),
        }
    }

    /// Rows that descend throughout are turned.
    fn ascending(
        &self,
        mut entries: Vec<SpectrumEntry>,
        notes: &mut Vec<String>,
    ) -> Result<Vec<SpectrumEntry>> {
        let bad = |line, problem| Err(Error::bad_file(self.path(), Place::Line(line), problem));
        if let Some(&(nm, value, line)) = entries.iter().find(|entry| !error::may_enter(entry.1)) {
            let allowed = error::NUMBERS;
            return bad(line, format!("value at {nm} nm is {value:?}, allowed: {allowed}"));
        }
        if entries.len() > 1 && entries[0].0 > entries[entries.len() - 1].0 {
            entries.reverse();
            notes.push("wavelengths descend: turned".to_owned());
        }
        for pair in entries.windows(2) {
            let ((before, _, line_before), (nm, _, line)) = (pair[0], pair[1]);
            if nm == before {
                let (first, second) = (line_before.min(line), line_before.max(line));
                return bad(second, format!("wavelength {nm} nm is twice there, see line {first}"));
            }
            if nm < before {
                let problem = "neither ascending nor descending";
                return bad(
                    line.max(line_before),
                    format!("wavelength {nm} nm beside {before} nm, {problem}"),
                );
            }
        }
        Ok(entries)
    }
}

/// Columns (0-based) whose names are wavelengths in steps that go one way, or `None`.
fn sample_columns(names: &[String]) -> Option<Vec<(usize, f64)>> {
    wavelength_columns(names.iter().map(String::as_str))
}

fn wavelength_columns<'a>(names: impl Iterator<Item = &'a str>) -> Option<Vec<(usize, f64)>> {
    let numbered = names.enumerate().filter_map(|(at, name)| Some((at, wavelength_in(name)?)));
    let columns: Vec<(usize, f64)> = numbered.collect();
    let steps: Vec<f64> = columns.windows(2).map(|pair| pair[1].1 - pair[0].1).collect();
    let one_way = steps.iter().all(|&s| s * steps[0] > 0.0 && s.abs() <= MAX_STEP_NM);
    let are_neighbors = columns.windows(2).all(|pair| pair[1].0 == pair[0].0 + 1);
    (columns.len() >= MIN_WAVELENGTHS && one_way && are_neighbors).then_some(columns)
}

/// The wavelength in "380", "380 nm", "SPEC_380" or "R380[nm]".
fn wavelength_in(name: &str) -> Option<f64> {
    const MOST_LETTERS: usize = 24;
    let is_part = |c: char| c.is_ascii_digit() || c == '.' || c == ',';
    let start = name.find(|c: char| c.is_ascii_digit())?;
    let end = name[start..].find(|c| !is_part(c)).map_or(name.len(), |length| start + length);
    let rest = &name[end..];
    let is_name = start <= MOST_LETTERS
        && rest.len() <= MOST_LETTERS
        && !rest.contains(|c: char| c.is_ascii_digit())
        && !name[..start].ends_with('-');
    let nm: f64 = name[start..end].replace(',', ".").parse().ok()?;
    (is_name && (100.0..=3000.0).contains(&nm)).then_some(nm)
}

/// Rows under a row of wavelengths: their style, they themselves, and the row of wavelengths.
pub(super) fn in_a_header(text: &str) -> Option<(Style, Vec<Line>, Line)> {
    let lines = block::content_lines(text);
    let head = &lines[..lines.len().min(HEADER_LINES)];
    for style in Style::ALL {
        let Some(at) = head.iter().position(|line| {
            wavelength_columns(style.cells(line.text(text)))
                .is_some_and(|columns| 2 * columns.len() > style.cells(line.text(text)).count())
        }) else {
            continue;
        };
        let columns = wavelength_columns(style.cells(lines[at].text(text)))?;
        let is_sample = |line: &&Line| {
            let filled = columns.iter().filter(|(column, _)| {
                let cell = style.cells(line.text(text)).nth(*column);
                cell.is_some_and(|cell| style.number(cell).is_some())
            });
            2 * filled.count() > columns.len()
        };
        let rows: Vec<Line> = lines[at + 1..].iter().take_while(is_sample).copied().collect();
        if !rows.is_empty() && !starts_with_wavelengths(style, text, &rows) {
            return Some((style, rows, lines[at]));
        }
    }
    None
}

/// Whether the rows' first cells are wavelengths themselves, under names that are mere numbers.
fn starts_with_wavelengths(style: Style, text: &str, rows: &[Line]) -> bool {
    let first = |row: &Line| style.number(style.cells(row.text(text)).next()?);
    let firsts: Vec<f64> = rows.iter().map_while(first).collect();
    firsts.len() == rows.len()
        && rows.len() >= MIN_WAVELENGTHS
        && firsts.windows(2).all(|pair| pair[0] < pair[1])
        && firsts.iter().all(|nm| (100.0..=3000.0).contains(nm))
}
