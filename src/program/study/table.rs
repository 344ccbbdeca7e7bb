//! `draws.csv`: the draws of a study, one a line, which grows while the study runs.

use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};

use crate::error::{Error, Place, Result};

/// The draws made so far, in the order in which they were made.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DrawTable {
    /// Names of the parameters, then of the results.
    pub columns: Vec<String>,
    /// Index of each draw (from 0), and a value for each column.
    pub rows: Vec<(usize, Vec<f64>)>,
}

impl DrawTable {
    /// The values of a column; `None` if there is none of this name.
    pub fn column(&self, name: &str) -> Option<Vec<f64>> {
        let at = self.columns.iter().position(|column| column == name)?;
        Some(self.rows.iter().map(|(_, values)| values[at]).collect())
    }

    fn header(&self) -> String {
        format!("draw,{}\n", self.columns.join(","))
    }

    /// The whole file.
    pub fn to_csv(&self) -> String {
        self.rows.iter().fold(self.header(), |text, (index, values)| text + &line(*index, values))
    }

    /// What a file holds, up to its last whole line; nothing if it is not there.
    ///
    /// Errors: [`Error::Io`]; [`Error::BadFile`] for a line that is not of the table.
    pub fn read(path: &Path) -> Result<Self> {
        match fs::read_to_string(path) {
            Ok(text) => Self::parse(path, &text),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(Self::default()),
            Err(error) => Err(Error::io(path, error)),
        }
    }

    fn parse(path: &Path, text: &str) -> Result<Self> {
        let bad =
            |number: u64, problem: String| Error::bad_file(path, Place::Line(number), problem);
        let whole = text.rfind('\n').map_or("", |end| &text[..end]);
        let mut lines = (1..).zip(whole.lines());
        let Some((_, header)) = lines.next() else {
            return Ok(Self::default());
        };
        let columns: Vec<String> = header.split(',').skip(1).map(str::to_owned).collect();
        let mut table = Self { columns, rows: Vec::new() };
        for (number, line) in lines {
            let row = row(line).filter(|(_, values)| values.len() == table.columns.len());
            table.rows.push(row.ok_or_else(|| bad(number, format!("\"{line}\" is no draw")))?);
        }
        Ok(table)
    }
}

fn row(line: &str) -> Option<(usize, Vec<f64>)> {
    let (index, values) = line.split_once(',')?;
    let values = values.split(',').map(|cell| cell.parse().ok().filter(|v: &f64| v.is_finite()));
    Some((index.parse().ok()?, values.collect::<Option<_>>()?))
}

/// Numbers in the shortest form that reads back the same.
fn line(index: usize, values: &[f64]) -> String {
    let cells: Vec<String> = values.iter().map(|value| format!("{value:?}")).collect();
    format!("{index},{}\n", cells.join(","))
}

/// A table in a file that takes one draw after the other, at the same cost each.
pub struct Writer {
    path: PathBuf,
    file: File,
    table: DrawTable,
}

impl Writer {
    /// Goes on with what the file holds; a line that a kill cut off goes.
    ///
    /// Errors: as [`DrawTable::read`].
    pub fn open(path: &Path) -> Result<Self> {
        let table = DrawTable::read(path)?;
        let io = |e| Error::io(path, e);
        let file = File::options().append(true).create(true).open(path).map_err(io)?;
        let whole = if table.columns.is_empty() { 0 } else { table.to_csv().len() };
        file.set_len(whole as u64).map_err(io)?;
        Ok(Self { path: path.to_owned(), file, table })
    }

    /// The draws so far.
    pub fn table(&self) -> &DrawTable {
        &self.table
    }

    /// The draws, by index.
    pub fn into_table(mut self) -> DrawTable {
        self.table.rows.sort_by_key(|(index, _)| *index);
        self.table
    }

    /// Adds a draw; the first one names the columns.
    ///
    /// Errors: [`Error::Io`]; [`Error::Inconsistent`] for other columns than before, and for values
    /// that are not finite.
    pub fn add(&mut self, index: usize, cells: Vec<(String, f64)>) -> Result<()> {
        let object = || format!("study: draw {}", index + 1);
        if let Some((name, value)) = cells.iter().find(|(_, value)| !value.is_finite()) {
            return Err(Error::out_of_range(&object(), name, value, "finite numbers"));
        }
        let (names, values): (Vec<String>, Vec<f64>) = cells.into_iter().unzip();
        let mut text = String::new();
        if self.table.columns.is_empty() {
            self.table.columns = names;
            text = self.table.header();
        } else if self.table.columns != names {
            let [found, expected] = [&names, &self.table.columns].map(|names| names.join(", "));
            let problem = format!("has the values {found}, the draws before it {expected}");
            return Err(Error::inconsistent(&object(), problem));
        }
        text += &line(index, &values);
        // One call, so that a kill leaves whole lines and at most one part of a line.
        self.file.write_all(text.as_bytes()).map_err(|e| Error::io(&self.path, e))?;
        self.table.rows.push((index, values));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::scratch::ScratchFolder;

    fn cells(x: f64, y: f64) -> Vec<(String, f64)> {
        vec![("x".to_owned(), x), ("y".to_owned(), y)]
    }

    /// Cut off anywhere, the table goes on to the same bytes.
    #[test]
    fn a_kill_at_any_byte_loses_at_most_a_draw() {
        let scratch = ScratchFolder::new();
        let path = scratch.path("draws.csv");
        let values = |index: usize| cells(index as f64 / 3.0, -1e-300 * index as f64);
        let fill = |path: &Path| {
            let mut writer = Writer::open(path).unwrap();
            for index in 0..4 {
                if writer.table().rows.iter().all(|(known, _)| *known != index) {
                    writer.add(index, values(index)).unwrap();
                }
            }
            writer.table().clone()
        };
        let table = fill(&path);
        let whole = fs::read(&path).unwrap();
        assert_eq!(String::from_utf8(whole.clone()).unwrap(), table.to_csv());
        for cut in 0..whole.len() {
            fs::write(&path, &whole[..cut]).unwrap();
            assert_eq!(fill(&path), table);
            assert_eq!(fs::read(&path).unwrap(), whole, "cut at {cut}");
        }
    }

    #[test]
    fn other_columns_and_infinities_are_refused() {
        let scratch = ScratchFolder::new();
        let path = scratch.path("draws.csv");
        let mut writer = Writer::open(&path).unwrap();
        writer.add(0, cells(1.0, 2.0)).unwrap();
        let other = writer.add(1, vec![("x".to_owned(), 1.0)]).unwrap_err();
        assert_eq!(other.to_string(), "study: draw 2: has the values x, the draws before it x, y");
        let infinite = writer.add(1, cells(1.0, f64::INFINITY)).unwrap_err();
        assert_eq!(infinite.to_string(), "study: draw 2: y is inf, allowed: finite numbers");
        fs::write(&path, "draw,x\n0,1\nnonsense\n").unwrap();
        let broken = Writer::open(&path).err().unwrap().to_string();
        assert!(broken.ends_with("draws.csv:3: \"nonsense\" is no draw"), "{broken}");
    }
}
