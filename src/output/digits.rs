//! Pictures for displays, read as light: PNG, JPEG and TIFF, as their profile tells the digits' colors.

use std::io::{BufRead, Seek};
use std::path::Path;

use ::image::metadata::Orientation;
use ::image::{DynamicImage, ImageDecoder, ImageError, ImageReader};

use super::color_picture::{ColorPicture, Primaries};
use crate::color::{D65_XY, REC709_XY, Xyz, xyz_from_primaries};
use crate::display::{Curve, Display, DisplayParameters, PQ_MAX_CD_M2, display_from_profile};
use crate::error::{Error, Place, Result};
use crate::input;

const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";

/// How JPEG, TIFF and PNG files begin.
const MAGIC: [&[u8]; 4] = [&[0xff, 0xd8, 0xff], b"II*\0", b"MM\0*", PNG];

/// Whether a file with this beginning is one of them.
pub(super) fn is_of_digits(start: &[u8]) -> bool {
    MAGIC.iter().any(|magic| start.starts_with(magic))
}

/// Columns and rows as the header has them.
pub(super) fn size(path: &Path, file: impl BufRead + Seek) -> Result<[usize; 2]> {
    let (width, height) = reader(path, file)?.into_dimensions().map_err(|e| broken(path, &e))?;
    Ok([width, height].map(|side| side as usize))
}

/// Reads a picture upright; alpha is left out.
///
/// Digits are what an ICC profile, PNG's code points or gamma say, else sRGB's; floats are linear.
/// Errors: [`Error::Io`]; [`Error::BadFile`], also for a profile without a matrix.
pub(super) fn read(path: &Path, file: impl BufRead + Seek) -> Result<ColorPicture> {
    // The reader bounds what a header may ask of memory.
    let mut decoder = reader(path, file)?.into_decoder().map_err(|e| broken(path, &e))?;
    let profile = decoder.icc_profile().unwrap_or(None);
    let upright = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    let mut image = DynamicImage::from_decoder(decoder).map_err(|e| broken(path, &e))?;
    image.apply_orientation(upright);
    let display = match profile {
        Some(profile) => display_of(path, &profile)?,
        None => png_colors(path)?.unwrap_or_else(Display::srgb),
    };
    let [width, height] = [image.width() as usize, image.height() as usize];
    let is_absolute = display.is_absolute();
    Ok(ColorPicture {
        width,
        height,
        primaries: Primaries::Matrix(display.matrix() * display.white().y.recip()),
        pixels: light(image, &display),
        cd_m2_of_one: is_absolute.then_some(PQ_MAX_CD_M2),
    })
}

fn display_of(path: &Path, profile: &[u8]) -> Result<Display> {
    display_from_profile(path, profile, Some(1.0)).map(|known| known.display).map_err(|error| {
        let Error::BadFile { problem, .. } = error else { return error };
        let problem = format!("has {problem}: convert the picture to sRGB");
        Error::bad_file(path, Place::File, problem)
    })
}

fn reader<R: BufRead + Seek>(path: &Path, file: R) -> Result<ImageReader<R>> {
    ImageReader::new(file).with_guessed_format().map_err(|e| Error::io(path, e))
}

fn broken(path: &Path, error: &ImageError) -> Error {
    Error::bad_file(path, Place::File, format!("not a readable picture: {error}"))
}

/// Light of the three channels, 1 at the largest digit.
fn light(image: DynamicImage, display: &Display) -> Vec<[f32; 3]> {
    if matches!(image, DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_)) {
        return image.into_rgb32f().pixels().map(|pixel| pixel.0).collect();
    }
    let of_digits = [0, 1, 2].map(|channel| -> Vec<f32> {
        let signals = (0..=u16::MAX).map(|digit| f64::from(digit) / f64::from(u16::MAX));
        signals.map(|signal| display.light(channel, signal) as f32).collect()
    });
    let of_pixel = |pixel: [u16; 3]| [0, 1, 2].map(|c| of_digits[c][usize::from(pixel[c])]);
    image.into_rgb16().pixels().map(|pixel| of_pixel(pixel.0)).collect()
}

/// What a PNG file without a profile says of its digits; `None` for sRGB, and for other files.
fn png_colors(path: &Path) -> Result<Option<Display>> {
    let mut file = std::io::BufReader::new(input::open(path)?);
    if !file.fill_buf().map_err(|e| Error::io(path, e))?.starts_with(PNG) {
        return Ok(None);
    }
    let bad = |problem: String| Error::bad_file(path, Place::File, problem);
    let reader = ::png::Decoder::new(file).read_info();
    let reader = reader.map_err(|e| bad(format!("not a readable PNG file: {e}")))?;
    let info = reader.info();
    if let Some(points) = &info.coding_independent_code_points {
        let (primaries, transfer) = (points.color_primaries, points.transfer_function);
        let problem = || {
            bad(format!(
                "has the code points {primaries} and {transfer} (ITU-T H.273), known: primaries of \
                 Rec. 709 (1), Rec. 2020 (9) and P3 (12) with the curves of sRGB (13) and PQ (16)"
            ))
        };
        return match (primaries, transfer) {
            (1, 13) => Ok(None),
            (9, 13) => Ok(Some(Display::rec2020())),
            (12, 13) => Ok(Some(Display::p3())),
            (9, 16) => Display::rec2020_pq(PQ_MAX_CD_M2).map(Some),
            (12, 16) => Display::p3_pq(PQ_MAX_CD_M2).map(Some),
            _ => Err(problem()),
        };
    }
    match info.gama_chunk {
        Some(gamma) if info.srgb.is_none() => of_gamma(gamma.into_value(), info.chrm_chunk)
            .map(Some)
            .map_err(|error| bad(format!("has no colors in gAMA and cHRM: {error}"))),
        _ => Ok(None),
    }
}

/// A display whose signals are light to the power `gamma`: PNG's gAMA and cHRM chunks.
fn of_gamma(gamma: f32, chromaticities: Option<::png::SourceChromaticities>) -> Result<Display> {
    /// What sRGB's curve is near to, with which writers mean it.
    const SRGB: f32 = 1.0 / 2.2;
    let xy = |(x, y): (::png::ScaledFloat, ::png::ScaledFloat)| {
        [f64::from(x.into_value()), f64::from(y.into_value())]
    };
    let given =
        chromaticities.map(|given| ([given.red, given.green, given.blue].map(xy), xy(given.white)));
    let (primaries, white) = given.unwrap_or((REC709_XY, D65_XY));
    let curve = if (gamma - SRGB).abs() < 1e-3 {
        Curve::SRGB
    } else {
        Curve::gog(1.0, 0.0, f64::from(gamma).recip())
    };
    let parameters = DisplayParameters {
        name: "PNG's gamma".to_owned(),
        curves: [curve; 3],
        matrix: xyz_from_primaries(primaries, white).transpose().to_cols_array_2d(),
        black: Xyz::default(),
        bits: 16,
    };
    Display::new(parameters)
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;
    use crate::color::{Lab, delta_e_2000};
    use crate::display::{DisplayImage, GamutReport};
    use crate::output::scratch::ScratchFolder;
    use crate::output::{declared_size, display_raster, read_color_picture, write_jpeg, write_png};

    /// Digits of all parts of the cube, each channel's light among them.
    const DIGITS: [[u16; 3]; 5] =
        [[255, 255, 255], [200, 30, 20], [20, 220, 40], [30, 40, 240], [90, 90, 90]];

    fn picture_of(display: &Display) -> DisplayImage {
        // PQ's digits stop at the peak, which the file does not tell: 1000 cd/m² is 0.75.
        let most = if display.is_absolute() { 0.7 } else { 1.0 } * f64::from(display.full_digit());
        let stretch = |digit: u16| (f64::from(digit) / 255.0 * most).round() as u16;
        let digits = DIGITS.map(|digits| digits.map(stretch)).to_vec();
        let gamut = GamutReport::default();
        DisplayImage { width: 5, height: 1, digits, exposure_factor: 1.0, gamut }
    }

    #[test]
    fn pictures_have_the_colors_of_their_display() {
        let scratch = ScratchFolder::new();
        let path = scratch.path("i.png");
        let pq = Display::p3_pq(1000.0).unwrap();
        let displays =
            [Display::srgb(), Display::p3(), Display::rec2020(), pq, Display::eizo_t766()];
        for display in displays {
            let picture = picture_of(&display);
            write_png(&path, &display_raster(&picture, &display).unwrap()).unwrap();
            let read = read_color_picture(&path).unwrap();
            assert_eq!(declared_size(&path).unwrap(), Some([5, 1]));
            assert_eq!(read.cd_m2_of_one, display.is_absolute().then_some(10_000.0));
            let white = display.white();
            let of_one = read.cd_m2_of_one.unwrap_or(white.y);
            for (digits, color) in picture.digits.iter().zip(read.colors()) {
                let expected = display.xyz_from_digits(digits.map(f64::from));
                let lab = |color: Xyz| Lab::from_xyz(color, Xyz::from_xy(D65_XY, white.y));
                let difference = delta_e_2000(lab(color * of_one), lab(expected));
                // A profile's numbers have 16 fractional bits.
                assert!(difference < 0.1, "{} {digits:?}: {difference}", display.name());
            }
        }
    }

    /// `image` as a PNG stream of the `png` crate's settings.
    fn png(set: impl Fn(&mut ::png::Info), bytes: &[u8]) -> Vec<u8> {
        let mut info = ::png::Info::with_size(2, 1);
        set(&mut info);
        let mut out = Vec::new();
        let mut writer = ::png::Encoder::with_info(&mut out, info).unwrap().write_header().unwrap();
        writer.write_image_data(bytes).unwrap();
        writer.finish().unwrap();
        out
    }

    #[test]
    fn gray_palettes_alpha_and_gamma_are_read() {
        let scratch = ScratchFolder::new();
        let path = scratch.path("i.png");
        let second = |bytes: Vec<u8>| {
            std::fs::write(&path, bytes).unwrap();
            read_color_picture(&path).unwrap().pixels[1]
        };
        let half = 0.5029; // sRGB's digit 188
        let near = |found: [f32; 3], expected: [f32; 3]| {
            let is_near = found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-4);
            assert!(is_near, "{found:?}, expected {expected:?}");
        };
        let gray = |info: &mut ::png::Info| info.color_type = ::png::ColorType::Grayscale;
        near(second(png(gray, &[0, 188])), [half; 3]);
        let palette = |info: &mut ::png::Info| {
            info.color_type = ::png::ColorType::Indexed;
            info.palette = Some([0, 0, 0, 255, 188, 0].as_slice().to_vec().into());
        };
        near(second(png(palette, &[0, 1])), [1.0, half, 0.0]);
        let alpha = |info: &mut ::png::Info| info.color_type = ::png::ColorType::Rgba;
        near(second(png(alpha, &[0, 0, 0, 255, 188, 0, 255, 7])), [half, 0.0, 1.0]);
        let linear = |info: &mut ::png::Info| {
            info.color_type = ::png::ColorType::Grayscale;
            info.source_gamma = Some(::png::ScaledFloat::new(1.0));
        };
        near(second(png(linear, &[0, 51])), [0.2; 3]);
        let one_color = |info: &mut ::png::Info| {
            let same = (0.3, 0.3);
            linear(info);
            info.source_chromaticities =
                Some(::png::SourceChromaticities::new(same, same, same, same));
        };
        let message = |bytes: Vec<u8>| {
            std::fs::write(&path, bytes).unwrap();
            read_color_picture(&path).unwrap_err().to_string()
        };
        let refused = message(png(one_color, &[0, 51]));
        assert!(refused.contains("i.png: has no colors in gAMA and cHRM"), "{refused}");
        let profile = moxcms::ColorProfile::new_gray_with_gamma(2.2).encode().unwrap();
        let of_gray = |info: &mut ::png::Info| {
            gray(info);
            info.icc_profile = Some(profile.clone().into());
        };
        let refused = message(png(of_gray, &[0, 51]));
        assert!(refused.contains("convert the picture to sRGB"), "{refused}");
        // Code points that nobody here knows, as BT.709's curve.
        let mut bytes = png(gray, &[0, 188]);
        let chunk = [&b"cICP"[..], &[1, 1, 0, 1]].concat();
        let mut crc = flate_crc(&chunk).to_be_bytes().to_vec();
        let mut inserted = [&4u32.to_be_bytes()[..], &chunk].concat();
        inserted.append(&mut crc);
        bytes.splice(33..33, inserted);
        let refused = message(bytes);
        assert!(refused.contains("code points 1 and 1"), "{refused}");
    }

    /// PNG's check of a chunk. Source: PNG, annex D.
    fn flate_crc(bytes: &[u8]) -> u32 {
        let step = |crc: u32, byte: &u8| {
            (0..8).fold(crc ^ u32::from(*byte), |c, _| {
                if c & 1 == 1 { 0xedb8_8320 ^ (c >> 1) } else { c >> 1 }
            })
        };
        !bytes.iter().fold(!0, step)
    }

    #[test]
    fn photographs_stand_upright() {
        let scratch = ScratchFolder::new();
        let path = scratch.path("i.jpg");
        let picture = picture_of(&Display::srgb());
        write_jpeg(&path, &display_raster(&picture, &Display::srgb()).unwrap(), 95).unwrap();
        let mut bytes = std::fs::read(&path).unwrap();
        // Exif's orientation (tag 0x112, a short) is 6: a quarter turn to the right.
        let exif = b"Exif\0\0II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\x06\0\0\0\0\0\0\0";
        let length = (exif.len() as u16 + 2).to_be_bytes();
        bytes.splice(2..2, [&[0xff, 0xe1][..], &length, exif].concat());
        std::fs::write(&path, &bytes).unwrap();
        let read = read_color_picture(&path).unwrap();
        assert_eq!((read.width, read.height), (1, 5));
        assert!(read.pixels[0].iter().all(|v| *v > 0.9), "white is on top: {:?}", read.pixels);
    }

    #[test]
    fn broken_pictures_are_refused() {
        for bytes in [&b"II*\0cut off"[..], PNG, &[0xff, 0xd8, 0xff, 0xe0]] {
            assert!(read(Path::new("p"), Cursor::new(bytes)).is_err());
            assert!(size(Path::new("p"), Cursor::new(bytes)).is_err());
        }
    }
}
