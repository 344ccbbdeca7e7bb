//! Measured displays as CSV files; `#` starts a comment.

use std::fs::File;
use std::path::Path;

use super::fit::{Light, RampPatch};
use super::verify::Patch;
use crate::color::Xyz;
use crate::error::{Error, Place, Result};

/// Ramps of the three channels from a file with the columns channel (`R`, `G`, `B`), digit, and
/// luminance or X, Y, Z.
///
/// A file whose largest digit is at most 1 gives drives, which become digits of `bits` bits.
/// Errors: [`Error::Io`]; [`Error::BadFile`] with the line of a row that is not of this form.
pub fn read_ramps(path: &Path, bits: u32) -> Result<[Vec<RampPatch>; 3]> {
    let mut ramps: [Vec<RampPatch>; 3] = Default::default();
    for row in read_rows(path)? {
        let channel = match row.cells[0].as_str() {
            "R" | "r" | "red" => 0,
            "G" | "g" | "green" => 1,
            "B" | "b" | "blue" => 2,
            other => {
                let problem = format!("channel is \"{other}\", expected R, G or B");
                return Err(Error::bad_file(path, Place::Line(row.line), problem));
            }
        };
        let numbers = row.numbers(path, 1)?;
        let light = match numbers[..] {
            [_, y] => Light::Luminance(y),
            [_, x, y, z] => Light::Xyz(Xyz::new(x, y, z)),
            _ => return Err(row.wrong_width(path, "channel, digit, luminance or X, Y, Z")),
        };
        ramps[channel].push(RampPatch { digit: numbers[0], light });
    }
    let scale = digit_scale(ramps.iter().flatten().map(|patch| patch.digit), bits);
    ramps.iter_mut().flatten().for_each(|patch| patch.digit *= scale);
    Ok(ramps)
}

/// Patches from a file with the columns r, g, b, X, Y, Z; digits or drives and errors as
/// [`read_ramps`].
pub fn read_patches(path: &Path, bits: u32) -> Result<Vec<Patch>> {
    let mut patches = Vec::new();
    for row in read_rows(path)? {
        let [r, g, b, x, y, z] = row.numbers(path, 0)?[..] else {
            return Err(row.wrong_width(path, "r, g, b, X, Y, Z"));
        };
        patches.push(Patch { digits: [r, g, b], measured: Xyz::new(x, y, z) });
    }
    let scale = digit_scale(patches.iter().flat_map(|patch| patch.digits), bits);
    patches.iter_mut().flat_map(|patch| &mut patch.digits).for_each(|digit| *digit *= scale);
    Ok(patches)
}

fn digit_scale(digits: impl Iterator<Item = f64>, bits: u32) -> f64 {
    let is_drive = digits.fold(0.0, f64::max) <= 1.0;
    if is_drive { f64::from(bits).exp2() - 1.0 } else { 1.0 }
}

struct Row {
    line: u64,
    cells: Vec<String>,
}

impl Row {
    /// The cells from `first` on.
    fn numbers(&self, path: &Path, first: usize) -> Result<Vec<f64>> {
        let number = |(column, cell): (usize, &String)| {
            cell.parse().map_err(|_| {
                let problem = format!("column {} is \"{cell}\", expected a number", column + 1);
                Error::bad_file(path, Place::Line(self.line), problem)
            })
        };
        self.cells.iter().enumerate().skip(first).map(number).collect()
    }

    fn wrong_width(&self, path: &Path, expected: &str) -> Error {
        let problem = format!("has {} columns, expected {expected}", self.cells.len());
        Error::bad_file(path, Place::Line(self.line), problem)
    }
}

/// All rows but a first one without numbers, the header.
fn read_rows(path: &Path) -> Result<Vec<Row>> {
    let file = File::open(path).map_err(|e| Error::io(path, e))?;
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .has_headers(false)
        .flexible(true)
        .trim(csv::Trim::All)
        .from_reader(file);
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|e| csv_error(path, e))?;
        let line = record.position().map_or(0, csv::Position::line);
        rows.push(Row { line, cells: record.iter().map(str::to_owned).collect() });
    }
    let is_header = |row: &Row| row.cells.iter().all(|cell| cell.parse::<f64>().is_err());
    if rows.first().is_some_and(is_header) {
        rows.remove(0);
    }
    Ok(rows)
}

fn csv_error(path: &Path, error: csv::Error) -> Error {
    let place = error.position().map_or(Place::File, |p| Place::Line(p.line()));
    match error.into_kind() {
        csv::ErrorKind::Io(error) => Error::io(path, error),
        other => Error::bad_file(path, place, format!("not a CSV table: {other:?}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::scratch::Scratch;

    fn file(scratch: &Scratch, text: &str) -> std::path::PathBuf {
        let path = scratch.path("t.csv");
        std::fs::write(&path, text).unwrap();
        path
    }

    #[test]
    fn ramps_in_luminance_and_drives() {
        let scratch = Scratch::new();
        let path = file(&scratch, "# a\nchannel,drive,Y\nR,0.5,2\nB,1,3\nR, 1, 4\n");
        let [red, green, blue] = read_ramps(&path, 8).unwrap();
        let patch = |digit, y| RampPatch { digit, light: Light::Luminance(y) };
        assert_eq!(red, [patch(127.5, 2.0), patch(255.0, 4.0)]);
        assert_eq!((green, blue), (vec![], vec![patch(255.0, 3.0)]));
    }

    #[test]
    fn patches_in_digits() {
        let scratch = Scratch::new();
        let path = file(&scratch, "0,128,255,1,2,3\n");
        let measured = Xyz::new(1.0, 2.0, 3.0);
        let expected = Patch { digits: [0.0, 128.0, 255.0], measured };
        assert_eq!(read_patches(&path, 8).unwrap(), [expected]);
    }

    #[test]
    fn bad_rows_are_named() {
        let scratch = Scratch::new();
        let ending = |text: &str| {
            let path = file(&scratch, text);
            let error = match text.starts_with("ramp") {
                true => read_ramps(&path, 8).unwrap_err(),
                false => read_patches(&path, 8).unwrap_err(),
            };
            error.to_string().split("t.csv").nth(1).unwrap().to_owned()
        };
        assert_eq!(ending("ramp,d,Y\nR,1,2\nC,1,2\n"), ":3: channel is \"C\", expected R, G or B");
        assert_eq!(
            ending("ramp,d,Y\nR,1\n"),
            ":2: has 2 columns, expected channel, digit, luminance or X, Y, Z"
        );
        assert_eq!(ending("1,2,x,4,5,6\n"), ":1: column 3 is \"x\", expected a number");
        assert_eq!(ending("1,2,3\n"), ":1: has 3 columns, expected r, g, b, X, Y, Z");
    }
}
