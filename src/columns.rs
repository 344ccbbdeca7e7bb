//! Two columns of a table of numbers in a text file.

use std::path::Path;

use crate::error::{Error, Place, Result};

/// Rows of the first and one other column, with the lines they stand in.
#[derive(Debug, Clone, PartialEq)]
pub struct Columns {
    pub rows: Vec<(f64, f64)>,
    /// 1-based, one a row.
    pub lines: Vec<u64>,
}

/// Reads the first column and `column` (1-based) of a file whose cells are parted by commas,
/// semicolons or tabs, in which `#` starts a comment and one row of names may come first.
///
/// Errors: [`Error::Io`], and [`Error::BadFile`] with the line.
pub fn read(path: &Path, column: usize) -> Result<Columns> {
    let text = std::fs::read_to_string(path).map_err(|e| Error::io(path, e))?;
    let mut columns = Columns { rows: Vec::new(), lines: Vec::new() };
    for (number, line) in (1..).zip(text.lines()) {
        let line = line.split('#').next().unwrap_or_default().trim();
        if line.is_empty() {
            continue;
        }
        match parse_row(line, column) {
            Ok(row) => {
                columns.rows.push(row);
                columns.lines.push(number);
            }
            Err(_) if columns.rows.is_empty() && is_header(line) => {}
            Err(problem) => return Err(Error::bad_file(path, Place::Line(number), problem)),
        }
    }
    Ok(columns)
}

fn parse_row(line: &str, column: usize) -> std::result::Result<(f64, f64), String> {
    let cells: Vec<&str> = line.split([',', ';', '\t']).map(str::trim).collect();
    let number = |column: usize| -> std::result::Result<f64, String> {
        let cell = cells.get(column - 1).copied();
        let cell = cell.ok_or_else(|| {
            format!("no column {column}, the row has {} (\"{line}\")", cells.len())
        })?;
        cell.parse().map_err(|_| format!("column {column} is \"{cell}\", expected a number"))
    };
    Ok((number(1)?, number(column)?))
}

fn is_header(line: &str) -> bool {
    line.split([',', ';', '\t']).next().is_some_and(|cell| cell.trim().parse::<f64>().is_err())
}
