//! Measured displays from tables.

use std::path::Path;

use super::fit::{RampLight, RampPatch};
use super::verify::ColorPatch;
use crate::color::Xyz;
use crate::columns::{Table, TableFormat, TableRow};
use crate::error::{Error, Place, Result};

/// What drives gave, as a table has it.
#[derive(Debug, Clone, Copy)]
struct RampLevel {
    drives: [f64; 3],
    light: RampLight,
}

/// Ramps of the three channels from a file, in digits of `bits` bits.
///
/// Layouts: a channel (`R`, `Red`, `Green` …), its digit, and luminance or X, Y, Z; R, G, B and
/// luminance or X, Y, Z, where rows of one channel alone count, and rows of none are black's; and
/// Argyll's `.ti3`. Digits may be drives of 0 to 1, percent, or digits of 8, 10, 12 or 16 bits, as
/// the largest one tells.
/// Errors: [`Error::Io`]; [`Error::BadFile`] with the line of a row that is not of this form.
pub fn read_ramps(path: &Path, bits: u32) -> Result<[Vec<RampPatch>; 3]> {
    let table = Table::read(path)?;
    let starts_with_number = |row: TableRow| row.number(0).is_ok();
    let levels = if table.rows().next().is_some_and(starts_with_number) {
        triples(&table)?
    } else {
        table.rows().map(|row| labelled(&row)).collect::<Result<_>>()?
    };
    if levels.is_empty() {
        let problem = "no rows, expected channel, digit, luminance or X, Y, Z";
        return Err(Error::bad_file(path, Place::File, problem));
    }
    let scale = digit_scale(&table, levels.iter().flat_map(|level| level.drives), bits);
    let mut ramps: [Vec<RampPatch>; 3] = Default::default();
    for RampLevel { drives, light } in levels {
        for (channel, ramp) in ramps.iter_mut().enumerate() {
            let others = (0..3).filter(|&other| other != channel).all(|other| drives[other] == 0.0);
            // Black is the first level of every ramp.
            if others {
                ramp.push(RampPatch { digit: snapped(drives[channel] * scale, bits), light });
            }
        }
    }
    for ramp in &mut ramps {
        ramp.sort_by(|a, b| a.digit.total_cmp(&b.digit));
        ramp.dedup_by(|next, first| next.digit == 0.0 && first.digit == 0.0);
    }
    Ok(ramps)
}

/// A drive of 1 or of 100 % is full, whatever rounding makes of it.
fn snapped(digit: f64, bits: u32) -> f64 {
    let full = f64::from(bits).exp2() - 1.0;
    if (digit / full - 1.0).abs() < 1e-9 { full } else { digit }
}

/// Patches from a file with the columns R, G, B, X, Y, Z or from Argyll's `.ti3`; digits and errors
/// as [`read_ramps`].
pub fn read_patches(path: &Path, bits: u32) -> Result<Vec<ColorPatch>> {
    let table = Table::read(path)?;
    let levels = triples(&table)?;
    let scale = digit_scale(&table, levels.iter().flat_map(|level| level.drives), bits);
    let rows = levels.into_iter().zip(table.rows());
    rows.map(|(level, row)| match level.light {
        RampLight::Xyz(measured) => Ok(ColorPatch {
            digits: level.drives.map(|drive| snapped(drive * scale, bits)),
            measured,
        }),
        RampLight::Luminance(_) => Err(row.wrong_width("r, g, b, X, Y, Z")),
    })
    .collect()
}

/// A row of a channel's name, its drive, and its light.
fn labelled(row: &TableRow) -> Result<RampLevel> {
    let name = row.cells().next().unwrap_or_default();
    let numbers = row.numbers_from(1)?;
    let light = match numbers[..] {
        [_, y] => RampLight::Luminance(y),
        [_, x, y, z] => RampLight::Xyz(Xyz::new(x, y, z)),
        _ => return Err(row.wrong_width("channel, digit, luminance or X, Y, Z")),
    };
    let channel = channel_of(name)
        .ok_or_else(|| row.bad(format!("channel is \"{name}\", expected R, G or B")))?;
    let drives = match channel {
        Some(channel) => std::array::from_fn(|c| if c == channel { numbers[0] } else { 0.0 }),
        None => [numbers[0]; 3],
    };
    Ok(RampLevel { drives, light })
}

/// Red, green or blue; `Some(None)` for grays, white and black.
fn channel_of(name: &str) -> Option<Option<usize>> {
    let name = name.to_lowercase();
    let first = ["red", "green", "blue"].iter().position(|word| *word == name);
    let short = ["r", "g", "b"].iter().position(|word| *word == name);
    let other = ["rot", "grün", "blau"].iter().position(|word| *word == name);
    let korean = ["빨강", "초록", "파랑"].iter().position(|word| *word == name);
    let gray = ["w", "white", "k", "black", "gray", "grey", "weiß", "schwarz"];
    match first.or(short).or(other).or(korean) {
        Some(channel) => Some(Some(channel)),
        None => gray.contains(&name.as_str()).then_some(None),
    }
}

/// Rows of three drives and light, by their names or in this order.
fn triples(table: &Table) -> Result<Vec<RampLevel>> {
    let rgb = ["R", "G", "B"].map(|c| table.column(&[&format!("RGB_{c}"), c]));
    let xyz = ["X", "Y", "Z"].map(|c| table.column(&[&format!("XYZ_{c}"), c]));
    if let ([Some(r), Some(g), Some(b)], [Some(x), Some(y), Some(z)]) = (rgb, xyz) {
        let scale = luminance_scale(table);
        return table
            .rows()
            .map(|row| {
                let number = |column: usize| row.number(column);
                let color = Xyz::new(number(x)?, number(y)?, number(z)?) * scale;
                let drives = [number(r)?, number(g)?, number(b)?];
                Ok(RampLevel { drives, light: RampLight::Xyz(color) })
            })
            .collect();
    }
    table
        .rows()
        .map(|row| match row.numbers_from(0)?[..] {
            [r, g, b, y] => Ok(RampLevel { drives: [r, g, b], light: RampLight::Luminance(y) }),
            [r, g, b, x, y, z] => {
                Ok(RampLevel { drives: [r, g, b], light: RampLight::Xyz(Xyz::new(x, y, z)) })
            }
            _ => Err(row.wrong_width("r, g, b, X, Y, Z")),
        })
        .collect()
}

/// Argyll scales its XYZ to a white of 100, and says what white was.
fn luminance_scale(table: &Table) -> f64 {
    let is_scaled = table.keyword("NORMALIZED_TO_Y_100").is_some_and(|value| value == "YES");
    let white = table.keyword("LUMINANCE_XYZ_CDM2");
    let white_y = white.and_then(|xyz| xyz.split_whitespace().nth(1)?.parse::<f64>().ok());
    white_y.filter(|y| is_scaled && *y > 0.0 && y.is_finite()).map_or(1.0, |y| y / 100.0)
}

/// What turns a file's drives into digits of `bits` bits.
fn digit_scale(table: &Table, drives: impl Iterator<Item = f64>, bits: u32) -> f64 {
    const FULL_DIGITS: [f64; 4] = [255.0, 1023.0, 4095.0, 65535.0];
    let full = f64::from(bits).exp2() - 1.0;
    let largest = drives.fold(0.0, f64::max);
    let is_percent =
        largest == 100.0 && full != 100.0 || table.reading.format == TableFormat::Cgats;
    if largest <= 1.0 {
        full
    } else if is_percent {
        full / 100.0
    } else if largest > full || full > 255.0 {
        FULL_DIGITS.iter().find(|most| largest <= **most).map_or(1.0, |most| full / most)
    } else {
        1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::display::{CurveKind, Display, DisplayMeasurement, fit_display};
    use crate::output::scratch::ScratchFolder;

    fn file(scratch: &ScratchFolder, text: &str) -> std::path::PathBuf {
        let path = scratch.path("t.csv");
        std::fs::write(&path, text).unwrap();
        path
    }

    fn ramps_of(text: &str, bits: u32) -> [Vec<RampPatch>; 3] {
        let scratch = ScratchFolder::new();
        read_ramps(&file(&scratch, text), bits).unwrap()
    }

    #[test]
    fn ramps_in_luminance_and_drives() {
        let [red, green, blue] = ramps_of("# a\nchannel,drive,Y\nR,0.5,2\nB,1,3\nR, 1, 4\n", 8);
        let patch = |digit, y| RampPatch { digit, light: RampLight::Luminance(y) };
        assert_eq!(red, [patch(127.5, 2.0), patch(255.0, 4.0)]);
        assert_eq!((green, blue), (vec![], vec![patch(255.0, 3.0)]));
    }

    #[test]
    fn every_layout_of_ramps_is_the_same_display() {
        let xyz = |r: f64, g: f64, b: f64| {
            let light = |d: f64| (d / 255.0).powf(2.2);
            let color = Xyz::new(41.0, 21.0, 2.0) * light(r)
                + Xyz::new(36.0, 72.0, 12.0) * light(g)
                + Xyz::new(18.0, 7.0, 95.0) * light(b);
            color + Xyz::new(0.3, 0.4, 0.5)
        };
        let levels = [0.0, 51.0, 102.0, 153.0, 204.0, 255.0];
        let channels =
            [("Red", [1.0, 0.0, 0.0]), ("Green", [0.0, 1.0, 0.0]), ("Blue", [0.0, 0.0, 1.0])];
        #[allow(clippy::type_complexity)] // said once
        let rows = |row: &dyn Fn(&str, f64, [f64; 3], Xyz) -> String| -> String {
            let of = |(name, mask): (&str, [f64; 3])| -> String {
                levels
                    .iter()
                    .map(|&d| {
                        let rgb = mask.map(|m| m * d);
                        row(name, d, rgb, xyz(rgb[0], rgb[1], rgb[2]))
                    })
                    .collect()
            };
            channels.into_iter().map(of).collect()
        };
        let percent = rows(&|name, d, _, c| {
            format!("{name};{};{};{};{}\n", d / 2.55, c.x, c.y, c.z).replace('.', ",")
        });
        let ten_bits = rows(&|name, d, _, c| {
            format!("{name},{},{},{},{}\n", d / 255.0 * 1023.0, c.x, c.y, c.z)
        });
        let triples = rows(&|_, _, [r, g, b], c| format!("{r},{g},{b},{},{},{}\n", c.x, c.y, c.z));
        let ti3_rows = rows(&|_, d, rgb, c| {
            let [r, g, b] = rgb.map(|v| v / 2.55);
            format!(
                "{} {r} {g} {b} {} {} {}\n",
                1 + d as u32,
                c.x / 1.004,
                c.y / 1.004,
                c.z / 1.004
            )
        });
        let ti3 = format!(
            "CTI3\n\nKEYWORD \"LUMINANCE_XYZ_CDM2\"\nLUMINANCE_XYZ_CDM2 \"95.3 100.4 109.5\"\n\
             NORMALIZED_TO_Y_100 \"YES\"\nBEGIN_DATA_FORMAT\nSAMPLE_ID RGB_R RGB_G RGB_B XYZ_X XYZ_Y \
             XYZ_Z\nEND_DATA_FORMAT\nBEGIN_DATA\n{ti3_rows}END_DATA\n"
        );
        for text in [
            format!("Kanal;Prozent;X;Y;Z\n{percent}"),
            format!("channel,digit,X,Y,Z\n{ten_bits}"),
            format!("R,G,B,X,Y,Z\n{triples}128,128,128,40,41,42\n"),
            ti3,
        ] {
            let measurement = DisplayMeasurement {
                name: "d".to_owned(),
                ramps: ramps_of(&text, 8),
                matrix: None,
                black: None,
                bits: 8,
            };
            let fit = fit_display(&measurement, CurveKind::Gog).unwrap();
            // The measured black row is the black.
            assert!((fit.black.y - 0.4).abs() < 1e-9, "{text}: {:?}", fit.black);
            for channel in fit.channels {
                assert!(
                    (channel.gamma - 2.2).abs() < 1e-4 && (channel.gain - 1.0).abs() < 1e-4,
                    "{channel:?}"
                );
            }
            let white: Display = fit.display;
            assert!((white.white().y - 100.4).abs() < 1e-6);
            assert!(fit.worst.is_described());
        }
    }

    #[test]
    fn patches_in_digits() {
        let scratch = ScratchFolder::new();
        let path = file(&scratch, "0,128,255,1,2,3\n");
        let measured = Xyz::new(1.0, 2.0, 3.0);
        let expected = ColorPatch { digits: [0.0, 128.0, 255.0], measured };
        assert_eq!(read_patches(&path, 8).unwrap(), [expected]);
    }

    #[test]
    fn bad_rows_are_named() {
        let scratch = ScratchFolder::new();
        let commas =
            ": decimal commas? then write semicolons between the columns, or points in the numbers";
        let ending = |text: &str| {
            let path = file(&scratch, text);
            let error = match text.starts_with("ramp") {
                true => read_ramps(&path, 8).unwrap_err(),
                false => read_patches(&path, 8).unwrap_err(),
            };
            error.to_string().split("t.csv").nth(1).unwrap().to_owned()
        };
        assert_eq!(ending("ramp,d,Y\nR,1,2\nC,1,2\n"), ":3: channel is \"C\", expected R, G or B");
        let wide = ":2: has 4 columns, expected channel, digit, luminance or X, Y, Z";
        assert_eq!(ending("ramp,d,Y\nR,1,2,3\n"), format!("{wide}{commas}"));
        assert_eq!(
            ending("ramp,words\n"),
            ": no rows, expected channel, digit, luminance or X, Y, Z"
        );
        assert_eq!(ending("1,2,x,4,5,6\n"), ":1: column 3 is \"x\", expected a number");
        assert_eq!(
            ending("1,2,3\n"),
            format!(":1: has 3 columns, expected r, g, b, X, Y, Z{commas}")
        );
    }
}
