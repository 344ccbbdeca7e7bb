//! Radiance pictures (`.hdr`), which luminance tools read: RGBE, or XYZE for any color.
//!
//! Source: G. Ward, "Real pixels", Graphics Gems II, 1991, and the format's description in
//! Radiance's `doc/filefmts`. Values are radiances: a luminance in cd/m² over 179 lm/W.

use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::sync::LazyLock;

use glam::{DMat3, DVec3};

use super::atomic::write_atomically;
use crate::color::{Xyz, xyz_from_primaries};
use crate::error::{Error, Result};
use crate::image::SpectralImage;

/// What the four bytes of a pixel stand for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum HdrColors {
    /// Radiance's own primaries. More saturated colors lose saturation and keep their luminance.
    #[default]
    Rgbe,
    /// Tristimulus values: any color.
    Xyze,
}

/// Radiance's lm/W of white light.
const LM_PER_W: f64 = 179.0;
/// Radiance's primaries, about equal-energy white.
const PRIMARIES_XY: [[f64; 2]; 3] = [[0.64, 0.33], [0.29, 0.60], [0.15, 0.06]];
const WHITE_XY: [f64; 2] = [1.0 / 3.0, 1.0 / 3.0];
/// Y of its primaries, as its tools have them.
const LUMINANCE_WEIGHTS: [f64; 3] = [0.265, 0.670, 0.065];

/// What readers add to a mantissa, in steps. Radiance's tools add half a step, OpenImageIO none: RGB is
/// written for the middle, XYZ (which only Radiance's tools read) for them.
const RGBE_ADDED_STEP: f64 = 0.25;
const XYZE_ADDED_STEP: f64 = 0.5;

static RGB_FROM_XYZ: LazyLock<DMat3> =
    LazyLock::new(|| xyz_from_primaries(PRIMARIES_XY, WHITE_XY).inverse());

/// Writes the colors of `image` to `path`, whole or not at all; luminance within
/// 1 % (8 bits of the largest of three values).
///
/// Errors: [`Error::Io`]; a pixel that is not finite, named; an image without pixels.
pub fn write_hdr(path: &Path, image: &SpectralImage, colors: HdrColors) -> Result<()> {
    if image.width == 0 || image.height == 0 {
        return Err(Error::inconsistent("image", "has no pixels"));
    }
    let xyz = image.to_xyz();
    xyz.check_finite()?;
    let values = |color: &Xyz| match colors {
        HdrColors::Rgbe => rgb_within(*color),
        HdrColors::Xyze => DVec3::from(*color).max(DVec3::ZERO),
    };
    let rounding = match colors {
        HdrColors::Rgbe => (LUMINANCE_WEIGHTS, RGBE_ADDED_STEP),
        HdrColors::Xyze => ([0.0, 1.0, 0.0], XYZE_ADDED_STEP),
    };
    let pixel = |color: &Xyz| shared_exponent(values(color) / LM_PER_W, rounding);
    let pixels: Vec<[u8; 4]> = xyz.pixels.iter().map(pixel).collect();
    write_atomically(path, |file| {
        let mut out = BufWriter::new(file);
        write!(out, "{}", header(image, colors))?;
        pixels.chunks(image.width).try_for_each(|row| write_row(&mut out, row))?;
        out.flush()
    })
}

fn header(image: &SpectralImage, colors: HdrColors) -> String {
    let format = match colors {
        HdrColors::Rgbe => "32-bit_rle_rgbe",
        HdrColors::Xyze => "32-bit_rle_xyze",
    };
    let mut lines = format!("#?RADIANCE\nFORMAT={format}\nEXPOSURE=1\n");
    if colors == HdrColors::Rgbe {
        lines += "PRIMARIES=0.6400 0.3300 0.2900 0.6000 0.1500 0.0600 0.3333 0.3333\n";
    }
    for (key, value) in &image.metadata {
        // A comment of one line.
        lines += &format!("# {key}: {}\n", value.replace(['\n', '\r'], " "));
    }
    if let Some(view) = &image.view {
        lines += &radiance_view(view);
    }
    lines + &format!("\n-Y {} +X {}\n", image.height, image.width)
}

/// Angles of the picture, for tools that weigh pixels by solid angle.
fn radiance_view(view: &crate::view::View) -> String {
    let tangent = (0.5 * view.fov_deg.to_radians()).tan();
    let across = tangent * view.width as f64 / view.height as f64;
    let across_deg = 2.0 * across.atan().to_degrees();
    format!("VIEW= -vtv -vh {across_deg} -vv {}\n", view.fov_deg)
}

/// Radiance's RGB; a color outside of them moves toward white at its luminance.
fn rgb_within(color: Xyz) -> DVec3 {
    let rgb = *RGB_FROM_XYZ * DVec3::from(color);
    let luminance = color.y.max(0.0);
    let lowest = rgb.min_element();
    if lowest >= 0.0 {
        return rgb;
    }
    // (1 − t) rgb + t Y is 0 in the lowest channel, and has luminance Y for any t.
    let t = lowest / (lowest - luminance);
    ((1.0 - t) * rgb + DVec3::splat(t * luminance)).max(DVec3::ZERO)
}

/// Three mantissas of 8 bits and an exponent, rounded so that the luminance by `weights` is kept:
/// of a saturated red the 0.67 of a step of green would be more than a percent.
fn shared_exponent(values: DVec3, (weights, added_step): ([f64; 3], f64)) -> [u8; 4] {
    let largest = values.max_element();
    let exponent = largest.log2().floor() + 1.0;
    if !(largest > 0.0 && exponent > -127.0) {
        return [0; 4];
    }
    let exponent = exponent.min(127.0);
    let steps = (values * (8.0 - exponent).exp2()).to_array();
    let mut mantissas = steps.map(|step| step.floor().min(255.0));
    let missing = |c: usize, mantissas: &[f64; 3]| steps[c] - (mantissas[c] + added_step);
    let mut luminance: f64 = (0..3).map(|c| weights[c] * missing(c, &mantissas)).sum();
    for c in [1, 0, 2].into_iter().filter(|&c| weights[c] > 0.0) {
        let change = (luminance / weights[c]).round().clamp(-1.0, 1.0);
        let changed = (mantissas[c] + change).clamp(0.0, 255.0);
        luminance -= weights[c] * (changed - mantissas[c]);
        mantissas[c] = changed;
    }
    let [r, g, b] = mantissas.map(|mantissa| mantissa as u8);
    [r, g, b, (exponent + 128.0) as u8]
}

/// Shortest and longest rows that the run-length form can hold.
const RLE_WIDTHS: std::ops::Range<usize> = 8..0x8000;

fn write_row(out: &mut impl Write, row: &[[u8; 4]]) -> io::Result<()> {
    if !RLE_WIDTHS.contains(&row.len()) {
        return row.iter().try_for_each(|pixel| out.write_all(pixel));
    }
    out.write_all(&[2, 2, (row.len() >> 8) as u8, row.len() as u8])?;
    for part in 0..4 {
        let bytes: Vec<u8> = row.iter().map(|pixel| pixel[part]).collect();
        write_runs(out, &bytes)?;
    }
    Ok(())
}

/// Runs of 4 and more equal bytes as count and byte, the rest as they are.
fn write_runs(out: &mut impl Write, bytes: &[u8]) -> io::Result<()> {
    let run = |at: usize| bytes[at..].iter().take(127).take_while(|b| **b == bytes[at]).count();
    let mut at = 0;
    while at < bytes.len() {
        let count = run(at);
        if count >= 4 {
            out.write_all(&[128 + count as u8, bytes[at]])?;
            at += count;
            continue;
        }
        let start = at;
        while at < bytes.len() && at - start < 128 && run(at) < 4 {
            at += 1;
        }
        out.write_all(&[(at - start) as u8])?;
        out.write_all(&bytes[start..at])?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Photometry;
    use crate::output::scratch::ScratchFolder;
    use crate::spectrum::WavelengthGrid;

    /// A reader of the run-length form, written apart from the writer, that adds `added_step`.
    fn read(bytes: &[u8], [width, height]: [usize; 2], added_step: f64) -> Vec<[f64; 3]> {
        let start = bytes.windows(2).position(|w| w == b"\n\n").unwrap() + 2;
        let size_line = bytes[start..].iter().position(|&b| b == b'\n').unwrap();
        let mut rest = &bytes[start + size_line + 1..];
        let mut pixels = Vec::new();
        for _ in 0..height {
            assert_eq!(rest[..4], [2, 2, (width >> 8) as u8, width as u8]);
            rest = &rest[4..];
            let mut parts = vec![Vec::new(); 4];
            for part in &mut parts {
                while part.len() < width {
                    let count = usize::from(rest[0]);
                    if count > 128 {
                        part.extend(vec![rest[1]; count - 128]);
                        rest = &rest[2..];
                    } else {
                        part.extend(&rest[1..=count]);
                        rest = &rest[1 + count..];
                    }
                }
            }
            #[allow(clippy::needless_range_loop)] // four arrays side by side
            for x in 0..width {
                let scale = 2f64.powi(i32::from(parts[3][x]) - 128 - 8);
                let value = |c: usize| (f64::from(parts[c][x]) + added_step) * scale;
                pixels.push([value(0), value(1), value(2)]);
            }
        }
        assert!(rest.is_empty());
        pixels
    }

    fn image() -> SpectralImage {
        let mut image = SpectralImage::new(300, 4, WavelengthGrid::Step20, Photometry::Absolute);
        let bands = 21;
        for pixel in 0..1200 {
            // Red light of five decades, with runs of black and of equal pixels.
            let strength = match pixel % 100 {
                0..=30 => 0.0,
                31..=60 => 1.0,
                rest => 10f64.powf(rest as f64 / 20.0 - 4.0),
            };
            for band in 13..bands {
                image.bands[pixel * bands + band] = strength as f32;
            }
        }
        image
    }

    #[test]
    fn luminance_reads_back_within_a_percent() {
        let scratch = ScratchFolder::new();
        let path = scratch.path("i.hdr");
        let image = image();
        // Radiance's readers, and those that add nothing.
        for (colors, added_step) in
            [(HdrColors::Rgbe, 0.5), (HdrColors::Rgbe, 0.0), (HdrColors::Xyze, 0.5)]
        {
            write_hdr(&path, &image, colors).unwrap();
            let pixels = read(&std::fs::read(&path).unwrap(), [300, 4], added_step);
            for (value, color) in pixels.iter().zip(image.to_xyz().pixels) {
                let luminance = 179.0
                    * match colors {
                        // Radiance's own weights.
                        HdrColors::Rgbe => 0.265 * value[0] + 0.670 * value[1] + 0.065 * value[2],
                        HdrColors::Xyze => value[1],
                    };
                let allowed = 0.01 * color.y + 1e-30;
                assert!(
                    (luminance - color.y).abs() <= allowed,
                    "{colors:?}: {luminance} {color:?}"
                );
            }
        }
    }

    #[test]
    fn narrow_pictures_are_flat_and_headers_say_what_they_hold() {
        let scratch = ScratchFolder::new();
        let path = scratch.path("i.hdr");
        let mut small = SpectralImage::new(3, 2, WavelengthGrid::Step20, Photometry::Absolute);
        small.bands.fill(1.0);
        small.metadata.insert("script".to_owned(), "a\nFORMAT=none".to_owned());
        write_hdr(&path, &small, HdrColors::Xyze).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let text = String::from_utf8_lossy(&bytes);
        assert!(text.starts_with("#?RADIANCE\nFORMAT=32-bit_rle_xyze\nEXPOSURE=1\n"));
        assert!(text.contains("# script: a FORMAT=none\n") && text.contains("\n\n-Y 2 +X 3\n"));
        let end = text.find("+X 3\n").unwrap() + 5;
        assert_eq!(bytes.len() - end, 4 * 6);
    }
}
