//! CGATS: keywords, the names of the fields, and rows of cells parted by blanks.
//!
//! Argyll's `.sp` (spectra) and `.ti3` (patches of a display), and the exports of X-Rite's programs.
//! Where a file has several tables, the first counts.

use super::cells::{DecimalMark, Separator, Style};
use super::{Found, Line, TableFormat, TextProblem};

/// Whether a line of the text starts the data as the format has it.
pub(super) fn is_cgats(text: &str) -> bool {
    let words = text.lines().filter_map(|line| line.split_whitespace().next());
    words.take(500).any(|word| word == "BEGIN_DATA_FORMAT")
}

/// Where the reader is in the file.
enum CgatsPart {
    Header,
    Names,
    Between,
    Rows,
}

pub(super) fn read(text: &str) -> Result<Found, TextProblem> {
    let blank = Style::new(Separator::Blank, DecimalMark::Point);
    let (mut keywords, mut names, mut rows) = (Vec::new(), Vec::new(), Vec::new());
    let mut notes = Vec::new();
    let mut part = CgatsPart::Header;
    for (number, line) in (1..).zip(text.lines()) {
        let content = match part {
            CgatsPart::Rows => line.trim(),
            _ => line.split('#').next().unwrap_or_default().trim(),
        };
        if content.is_empty() {
            continue;
        }
        match (&part, content) {
            (CgatsPart::Header, "BEGIN_DATA_FORMAT") => part = CgatsPart::Names,
            (CgatsPart::Names, "END_DATA_FORMAT") => part = CgatsPart::Between,
            (CgatsPart::Header | CgatsPart::Between, "BEGIN_DATA") => part = CgatsPart::Rows,
            (CgatsPart::Rows, "END_DATA") => {
                if text.lines().skip(number as usize).any(|line| line.trim() == "BEGIN_DATA") {
                    notes.push(format!("further tables from line {} on", number + 1));
                }
                let style = Style { decimal: decimal(text, &rows), ..blank };
                let format = TableFormat::Cgats;
                return Ok(Found { format, style, names, keywords, rows, notes, text: None });
            }
            (CgatsPart::Names, _) => names.extend(blank.cells(content).map(str::to_owned)),
            (CgatsPart::Header | CgatsPart::Between, _) => keywords.extend(keyword(blank, content)),
            (CgatsPart::Rows, _) => {
                let row = Line::of(text, content, number);
                let (found, expected) = (blank.cells(content).count(), names.len());
                if found != expected {
                    return Err(row.problem(format!(
                        "has {found} cells, the format names {expected} fields"
                    )));
                }
                rows.push(row);
            }
        }
    }
    Err(TextProblem { line: 0, what: "the CGATS file ends without \"END_DATA\"".to_owned() })
}

/// A keyword and its value, without quotes.
fn keyword(style: Style, line: &str) -> Option<(String, String)> {
    let mut cells = style.cells(line);
    Some((cells.next()?.to_owned(), cells.next()?.to_owned()))
}

/// Commas, where all decimals of the rows stand behind them.
fn decimal(text: &str, rows: &[Line]) -> DecimalMark {
    let commas = Style::new(Separator::Blank, DecimalMark::Comma);
    let points = Style::new(Separator::Blank, DecimalMark::Point);
    let numbers = |style: Style| -> usize {
        let cells = rows.iter().take(100).flat_map(|row| style.cells(row.text(text)));
        cells.filter(|cell| style.number(cell).is_some()).count()
    };
    if numbers(commas) > numbers(points) { DecimalMark::Comma } else { DecimalMark::Point }
}
