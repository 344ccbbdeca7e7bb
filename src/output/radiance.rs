//! Radiance pictures (RGBE and XYZE): only reading.
//!
//! Source: Ward, "Real Pixels" (Graphics Gems II, 1991), and the format's own manual.

use std::io::{BufRead, Read};
use std::path::Path;

use super::color_picture::{ColorPicture, Primaries};
use crate::color::{D65_XY, REC709_XY};
use crate::error::{Error, Place, Result};

/// lm/W that Radiance's own luminance counts with.
const LM_PER_W: f64 = 179.0;

/// Longest side that is taken for a picture's.
const LONGEST: usize = 1 << 16;

pub(super) const MAGIC: [&[u8]; 2] = [b"#?RADIANCE", b"#?RGBE"];

/// Errors: [`Error::BadFile`] for what is no whole picture.
pub(super) fn read(path: &Path, mut file: impl BufRead) -> Result<ColorPicture> {
    let bad = |problem: &str| Error::bad_file(path, Place::File, problem.to_owned());
    let mut header = RadianceHeader::default();
    loop {
        match line(&mut file) {
            Some(text) if text.is_empty() => break,
            Some(text) => header.take(&text).map_err(|problem| bad(&problem))?,
            None => return Err(bad("ends in its header")),
        }
    }
    let size = line(&mut file).unwrap_or_default();
    let size: Vec<&str> = size.split(' ').collect();
    let ["-Y", height, "+X", width] = size.as_slice() else {
        let found = size.join(" ");
        return Err(bad(&format!("has the size \"{found}\", expected \"-Y rows +X columns\"")));
    };
    let count = |text: &str| text.parse().ok().filter(|n| (1..=LONGEST).contains(n));
    let (width, height) = count(width)
        .zip(count(height))
        .ok_or_else(|| bad(&format!("has {width} × {height} pixels, allowed: 1 to {LONGEST}")))?;
    let mut pixels = Vec::with_capacity(width * height);
    for row in 0..height {
        let quads = scanline(&mut file, width)
            .ok_or_else(|| bad(&format!("ends, or is broken, in row {row}")))?;
        pixels.extend(quads.into_iter().map(color));
    }
    Ok(ColorPicture {
        width,
        height,
        pixels,
        primaries: header.primaries,
        cd_m2_of_one: Some(LM_PER_W / header.exposure),
    })
}

/// What counts of the header. Pictures that name no primaries have those of Rec. 709 today,
/// whatever the format's manual says.
#[derive(Debug)]
struct RadianceHeader {
    exposure: f64,
    primaries: Primaries,
}

impl Default for RadianceHeader {
    fn default() -> Self {
        Self { exposure: 1.0, primaries: Primaries::Rgb(REC709_XY, D65_XY) }
    }
}

impl RadianceHeader {
    fn take(&mut self, line: &str) -> std::result::Result<(), String> {
        let Some((key, value)) = line.split_once('=') else { return Ok(()) };
        let numbers = || value.split_whitespace().map_while(|text| text.parse::<f64>().ok());
        match key.trim() {
            "FORMAT" if value.trim() == "32-bit_rle_xyze" => self.primaries = Primaries::Xyz,
            "FORMAT" if value.trim() == "32-bit_rle_rgbe" => {}
            "FORMAT" => return Err(format!("has the format \"{}\"", value.trim())),
            // Several multiply.
            "EXPOSURE" => match numbers().next().filter(|e| *e > 0.0 && e.is_finite()) {
                Some(exposure) => self.exposure *= exposure,
                None => return Err(format!("has the exposure \"{}\"", value.trim())),
            },
            "PRIMARIES" => {
                let given: Vec<f64> = numbers().collect();
                if let (Ok([rx, ry, gx, gy, bx, by, wx, wy]), Primaries::Rgb(..)) =
                    (<[f64; 8]>::try_from(given), self.primaries)
                {
                    self.primaries = Primaries::Rgb([[rx, ry], [gx, gy], [bx, by]], [wx, wy]);
                }
            }
            _ => {}
        }
        Ok(())
    }
}

fn color([r, g, b, exponent]: [u8; 4]) -> [f32; 3] {
    if exponent == 0 {
        return [0.0; 3];
    }
    let scale = 2f32.powi(i32::from(exponent) - 136);
    [r, g, b].map(|mantissa| (f32::from(mantissa) + 0.5) * scale)
}

/// Without its end; None where the file ends, or no text comes.
fn line(file: &mut impl BufRead) -> Option<String> {
    const LONGEST_LINE: u64 = 10_000;
    let mut bytes = Vec::new();
    let read = file.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut bytes).ok()?;
    let has_end = bytes.last() == Some(&b'\n');
    (read > 0 && has_end).then(|| String::from_utf8_lossy(&bytes).trim_end().to_owned())
}

fn scanline(file: &mut impl Read, width: usize) -> Option<Vec<[u8; 4]>> {
    let first = quad(file)?;
    let is_packed = first[0] == 2 && first[1] == 2 && first[2] < 128;
    if is_packed && usize::from(first[2]) << 8 | usize::from(first[3]) == width {
        return packed(file, width);
    }
    let mut quads = Vec::with_capacity(width);
    let (mut next, mut shift) = (Some(first), 0);
    while let Some(quad) = next {
        // The old way: (1, 1, 1, n) repeats what was before.
        if quad[..3] == [1, 1, 1] {
            let count = usize::from(quad[3]) << shift;
            let last = *quads.last()?;
            quads.extend(std::iter::repeat_n(last, count.min(width + 1)));
            shift += 8;
        } else {
            quads.push(quad);
            shift = 0;
        }
        if quads.len() >= width || shift > 24 {
            break;
        }
        next = self::quad(file);
    }
    (quads.len() == width).then_some(quads)
}

fn quad(file: &mut impl Read) -> Option<[u8; 4]> {
    let mut quad = [0; 4];
    file.read_exact(&mut quad).ok()?;
    Some(quad)
}

/// One component after the other, in runs.
fn packed(file: &mut impl Read, width: usize) -> Option<Vec<[u8; 4]>> {
    let mut quads = vec![[0; 4]; width];
    let mut byte = || {
        let mut byte = [0];
        file.read_exact(&mut byte).ok().map(|()| byte[0])
    };
    for component in 0..4 {
        let mut at = 0;
        while at < width {
            let code = usize::from(byte()?);
            let (count, is_run) = if code > 128 { (code - 128, true) } else { (code, false) };
            let mut value = if is_run { byte()? } else { 0 };
            for quad in quads.get_mut(at..at + count).filter(|_| count > 0)? {
                if !is_run {
                    value = byte()?;
                }
                quad[component] = value;
            }
            at += count;
        }
    }
    Some(quads)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_bytes(bytes: &[u8]) -> Result<ColorPicture> {
        read(Path::new("p.hdr"), bytes)
    }

    #[test]
    fn flat_packed_and_old_runs_are_the_same() {
        let header =
            b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=2\nEXPOSURE= 0.25\n\n-Y 1 +X 8\n";
        let quad = [200, 100, 50, 130];
        let flat: Vec<u8> = [header.as_slice(), &quad.repeat(8)].concat();
        let packed: Vec<u8> = [
            header.as_slice(),
            &[2, 2, 0, 8],
            &[136, 200, 136, 100, 136, 50, 4, 130, 130, 130, 130, 132, 130],
        ]
        .concat();
        let old: Vec<u8> = [header.as_slice(), &quad, &[1, 1, 1, 7]].concat();
        let expected = read_bytes(&flat).unwrap();
        assert_eq!(expected.pixels.len(), 8);
        // (200 + ½)/256 · 2^(130 − 128)
        assert_eq!(expected.pixels[7], [200.5f32, 100.5, 50.5].map(|m| m / 256.0 * 4.0));
        assert_eq!(expected.cd_m2_of_one, Some(179.0 / 0.5));
        for other in [packed, old] {
            assert_eq!(read_bytes(&other).unwrap().pixels, expected.pixels);
        }
    }

    #[test]
    fn broken_files_are_refused() {
        let problem = |bytes: &[u8]| read_bytes(bytes).unwrap_err().to_string();
        assert_eq!(problem(b"#?RADIANCE\n"), "p.hdr: ends in its header");
        assert_eq!(problem(b"#?RADIANCE\nFORMAT=8-bit\n\n"), "p.hdr: has the format \"8-bit\"");
        assert_eq!(
            problem(b"#?RADIANCE\n\n-Y 1 +X 0\n"),
            "p.hdr: has 0 × 1 pixels, allowed: 1 to 65536"
        );
        assert_eq!(
            problem(b"#?RADIANCE\n\n-Y 2 +X 1\n\x01\x02\x03\x80"),
            "p.hdr: ends, or is broken, in row 1"
        );
    }
}
