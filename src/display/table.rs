//! Measured displays from tables.

use std::path::Path;

use super::fit::{Light, RampPatch};
use super::verify::Patch;
use crate::color::Xyz;
use crate::columns::Table;
use crate::error::Result;

/// Ramps of the three channels from a file with the columns channel (`R`, `G`, `B`), digit, and
/// luminance or X, Y, Z.
///
/// A file whose largest digit is at most 1 gives drives, which become digits of `bits` bits.
/// Errors: [`crate::Error::Io`]; [`crate::Error::BadFile`] with the line of a row that is not of
/// this form.
pub fn read_ramps(path: &Path, bits: u32) -> Result<[Vec<RampPatch>; 3]> {
    let mut ramps: [Vec<RampPatch>; 3] = Default::default();
    for row in Table::read(path)?.rows() {
        let channel = match row.cells().next().unwrap_or_default() {
            "R" | "r" | "red" => 0,
            "G" | "g" | "green" => 1,
            "B" | "b" | "blue" => 2,
            other => return Err(row.bad(format!("channel is \"{other}\", expected R, G or B"))),
        };
        let numbers = row.numbers_from(1)?;
        let light = match numbers[..] {
            [_, y] => Light::Luminance(y),
            [_, x, y, z] => Light::Xyz(Xyz::new(x, y, z)),
            _ => return Err(row.wrong_width("channel, digit, luminance or X, Y, Z")),
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
    for row in Table::read(path)?.rows() {
        let [r, g, b, x, y, z] = row.numbers_from(0)?[..] else {
            return Err(row.wrong_width("r, g, b, X, Y, Z"));
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
            ending("ramp,d,Y\nR,1,2,3\n"),
            ":2: has 4 columns, expected channel, digit, luminance or X, Y, Z: decimal commas? then \
             write semicolons between the columns, or points in the numbers"
        );
        assert_eq!(ending("1,2,x,4,5,6\n"), ":1: column 3 is \"x\", expected a number");
        assert_eq!(
            ending("1,2,3\n"),
            ":1: has 3 columns, expected r, g, b, X, Y, Z: decimal commas? then write semicolons \
             between the columns, or points in the numbers"
        );
    }
}
