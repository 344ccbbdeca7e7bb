//! PNG files that say which colors their digits mean.

use std::borrow::Cow;
use std::io::{self, BufReader, BufWriter};
use std::path::Path;

use super::atomic::write_atomically;
use crate::display::{Developed, Display, DisplayImage, Look};
use crate::error::{Error, Place, Result};
use crate::image::{Metadata, SpectralImage};
use crate::input;

/// Digits with their meaning.
#[derive(Debug, Clone, PartialEq)]
pub struct Raster<'a> {
    /// Pixels of a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Red, green, blue of each pixel, row 0 on top.
    pub samples: Digits<'a>,
    /// What the digits mean.
    pub color_space: ColorSpace,
    /// iTXt chunks.
    pub metadata: Metadata,
}

/// Digits of 8 or 16 bits.
#[derive(Debug, Clone, PartialEq)]
pub enum Digits<'a> {
    /// 0 to 255.
    Eight(Cow<'a, [u8]>),
    /// 0 to 65535.
    Sixteen(Cow<'a, [u16]>),
}

/// What the digits of a picture mean.
#[derive(Debug, Clone, PartialEq)]
pub enum ColorSpace {
    /// The sRGB chunk.
    Srgb,
    /// An ICC profile, as the iCCP chunk.
    Icc(Vec<u8>),
    /// Primaries, transfer, matrix and range of ITU-T H.273, as the cICP chunk of PNG's third
    /// edition, and a profile for those who do not read it.
    CodePoints {
        /// Numbers of the four, in that order.
        points: [u8; 4],
        /// The profile; `None` writes none.
        icc: Option<Vec<u8>>,
    },
}

impl ColorSpace {
    /// The ICC profile, where there is one.
    pub(super) fn profile(&self) -> Option<&[u8]> {
        match self {
            Self::Srgb => None,
            Self::Icc(profile) => Some(profile),
            Self::CodePoints { icc, .. } => icc.as_deref(),
        }
    }
}

/// Writes `raster` to `path`, whole or not at all; equal rasters give equal bytes.
///
/// Errors: [`crate::Error::Io`], also for a raster without pixels or with too few samples.
pub fn write_png(path: &Path, raster: &Raster) -> Result<()> {
    write_atomically(path, |file| encode_png(BufWriter::new(file), raster))
}

/// Develops `image` and writes its picture to `path`, with the image's metadata.
///
/// Errors: as [`Look::develop`] and [`write_png`].
pub fn develop_png(path: &Path, image: &SpectralImage, look: &Look) -> Result<Developed> {
    let (developed, raster) = develop_raster(image, look)?;
    write_png(path, &raster)?;
    Ok(developed)
}

/// The picture of `image` ready to be written, with the image's metadata.
///
/// Errors: as [`Look::develop`].
pub fn develop_raster(image: &SpectralImage, look: &Look) -> Result<(Developed, Raster<'static>)> {
    let developed = look.develop(image)?;
    let mut raster = display_raster(&developed.picture, &look.display)?;
    raster.metadata = image.metadata.clone();
    Ok((developed, raster))
}

/// Writes `raster` as a PNG stream; errors as [`write_png`].
pub fn encode_png(out: impl io::Write, raster: &Raster) -> io::Result<()> {
    let size = |pixels: usize| u32::try_from(pixels).map_err(io::Error::other);
    let mut info = ::png::Info::with_size(size(raster.width)?, size(raster.height)?);
    info.color_type = ::png::ColorType::Rgb;
    info.bit_depth = match raster.samples {
        Digits::Eight(_) => ::png::BitDepth::Eight,
        Digits::Sixteen(_) => ::png::BitDepth::Sixteen,
    };
    info.icc_profile = raster.color_space.profile().map(Cow::Borrowed);
    let mut encoder = ::png::Encoder::with_info(out, info)?;
    if raster.color_space == ColorSpace::Srgb {
        encoder.set_source_srgb(::png::SrgbRenderingIntent::RelativeColorimetric);
    }
    encoder.set_compression(::png::Compression::Balanced);
    for (key, value) in &raster.metadata {
        encoder.add_itxt_chunk(key.clone(), value.clone())?;
    }
    let mut writer = encoder.write_header()?;
    if let ColorSpace::CodePoints { points, .. } = &raster.color_space {
        writer.write_chunk(::png::chunk::ChunkType(*b"cICP"), points)?;
    }
    writer.write_image_data(&raster.samples.bytes())?;
    writer.finish()?;
    Ok(())
}

impl Digits<'_> {
    /// Big-endian, as the file has them.
    fn bytes(&self) -> Cow<'_, [u8]> {
        match self {
            Self::Eight(samples) => Cow::Borrowed(samples),
            Self::Sixteen(samples) => samples.iter().flat_map(|s| s.to_be_bytes()).collect(),
        }
    }
}

/// Reads a file of [`write_png`]: red, green, blue of each pixel, with their bits (8 or 16).
///
/// Errors: [`Error::Io`]; [`Error::BadFile`] for another kind of file.
pub fn read_png(path: &Path) -> Result<(Raster<'static>, u32)> {
    let bad = |problem: String| Error::bad_file(path, Place::File, problem);
    let file = input::open(path)?;
    let broken = |e: ::png::DecodingError| bad(format!("not a readable PNG file: {e}"));
    let mut reader = ::png::Decoder::new(BufReader::new(file)).read_info().map_err(broken)?;
    let size = reader.output_buffer_size().ok_or_else(|| bad("is too large".to_owned()))?;
    let mut bytes = vec![0; size];
    reader.next_frame(&mut bytes).map_err(broken)?;
    let info = reader.info();
    let (samples, bits) = match (info.color_type, info.bit_depth) {
        (::png::ColorType::Rgb, ::png::BitDepth::Eight) => (Digits::Eight(bytes.into()), 8),
        (::png::ColorType::Rgb, ::png::BitDepth::Sixteen) => {
            let pairs = bytes.chunks_exact(2).map(|b| u16::from_be_bytes([b[0], b[1]]));
            (Digits::Sixteen(pairs.collect()), 16)
        }
        (kind, depth) => {
            return Err(bad(format!("holds {kind:?} of {depth:?}, expected RGB of 8 or 16 bits")));
        }
    };
    let icc = info.icc_profile.as_ref().map(|profile| profile.to_vec());
    let color_space = match (&info.coding_independent_code_points, icc) {
        (Some(points), icc) => ColorSpace::CodePoints {
            points: [
                points.color_primaries,
                points.transfer_function,
                points.matrix_coefficients,
                u8::from(points.is_video_full_range_image),
            ],
            icc,
        },
        (None, Some(icc)) => ColorSpace::Icc(icc),
        (None, None) => ColorSpace::Srgb,
    };
    let (width, height) = (info.width as usize, info.height as usize);
    Ok((Raster { width, height, samples, color_space, metadata: Metadata::new() }, bits))
}

/// The digits of a display as a raster that carries its profile.
///
/// Displays of 8 bits give 8-bit files; all others 16-bit ones, digits stretched to 0 to 65535.
pub fn display_raster(image: &DisplayImage, display: &Display) -> Result<Raster<'static>> {
    let digits = image.digits.iter().flatten();
    let full = u32::from(display.full_digit());
    let samples = match display.bits() {
        8 => Digits::Eight(digits.map(|&d| d as u8).collect()),
        _ => Digits::Sixteen(
            digits.map(|&d| ((u32::from(d) * 65535 + full / 2) / full) as u16).collect(),
        ),
    };
    let color_space = match display.code_points() {
        _ if display.is_srgb() => ColorSpace::Srgb,
        None => ColorSpace::Icc(display.icc_profile()?),
        // No curve of an ICC profile means absolute luminance.
        Some(points) if display.is_absolute() => ColorSpace::CodePoints { points, icc: None },
        Some(points) => ColorSpace::CodePoints { points, icc: Some(display.icc_profile()?) },
    };
    let (width, height) = (image.width, image.height);
    Ok(Raster { width, height, samples, color_space, metadata: Metadata::new() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::display::GamutReport;
    use crate::output::scratch::ScratchFolder;

    fn image(digits: Vec<[u16; 3]>) -> DisplayImage {
        let gamut = GamutReport::default();
        DisplayImage { width: digits.len(), height: 1, digits, exposure_factor: 1.0, gamut }
    }

    fn decode(path: &Path) -> (::png::Info<'static>, Vec<u8>) {
        let file = BufReader::new(input::open(path).unwrap());
        let mut reader = ::png::Decoder::new(file).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut bytes).unwrap();
        reader.finish().unwrap();
        (reader.info().clone(), bytes)
    }

    #[test]
    fn srgb_files_have_the_srgb_chunk_and_no_profile() {
        let scratch = ScratchFolder::new();
        let path = scratch.path("i.png");
        let mut raster =
            display_raster(&image(vec![[0, 128, 255], [1, 2, 3]]), &Display::srgb()).unwrap();
        raster.metadata.insert("script".to_owned(), "전조등.lua".to_owned());
        write_png(&path, &raster).unwrap();
        let (info, bytes) = decode(&path);
        assert_eq!(bytes, [0, 128, 255, 1, 2, 3]);
        assert_eq!(info.srgb, Some(::png::SrgbRenderingIntent::RelativeColorimetric));
        assert_eq!(info.icc_profile, None);
        assert_eq!(info.utf8_text[0].keyword, "script");
        assert_eq!(info.utf8_text[0].get_text().unwrap(), "전조등.lua");
    }

    #[test]
    fn display_files_carry_the_profile() {
        let scratch = ScratchFolder::new();
        let path = scratch.path("i.png");
        let display = Display::eizo_t766();
        write_png(&path, &display_raster(&image(vec![[9, 8, 7]]), &display).unwrap()).unwrap();
        let (info, bytes) = decode(&path);
        assert_eq!(bytes, [9, 8, 7]);
        let (read, bits) = read_png(&path).unwrap();
        assert_eq!((read.samples, bits), (Digits::Eight(vec![9, 8, 7].into()), 8));
        assert_eq!(read.color_space, ColorSpace::Icc(display.icc_profile().unwrap()));
        assert_eq!(info.srgb, None);
        assert_eq!(*info.icc_profile.unwrap(), display.icc_profile().unwrap());
    }

    #[test]
    fn wide_gamut_files_carry_code_points() {
        let scratch = ScratchFolder::new();
        let path = scratch.path("i.png");
        for (display, points, has_profile) in [
            (Display::p3(), [12, 13, 0, 1], true),
            (Display::rec2020_pq(1000.0).unwrap(), [9, 16, 0, 1], false),
        ] {
            write_png(&path, &display_raster(&image(vec![[9, 8, 7]]), &display).unwrap()).unwrap();
            let (raster, bits) = read_png(&path).unwrap();
            assert_eq!(bits, display.bits());
            let ColorSpace::CodePoints { points: read, icc } = raster.color_space else {
                panic!("no cICP chunk");
            };
            assert_eq!((read, icc.is_some()), (points, has_profile));
        }
    }

    #[test]
    fn ten_bit_digits_fill_sixteen() {
        let scratch = ScratchFolder::new();
        let path = scratch.path("i.png");
        let parameters = crate::display::DisplayParameters {
            name: "ten bit".to_owned(),
            curves: *Display::eizo_t766().curves(),
            matrix: Display::srgb().matrix().transpose().to_cols_array_2d(),
            black: Default::default(),
            bits: 10,
        };
        let display = Display::new(parameters).unwrap();
        let raster = display_raster(&image(vec![[0, 512, 1023]]), &display).unwrap();
        write_png(&path, &raster).unwrap();
        // 512 · 65535 / 1023 = 32799.5, rounded up.
        assert_eq!(decode(&path).1, [0, 0, 0x80, 0x20, 0xff, 0xff]);
    }

    #[test]
    fn a_raster_of_the_wrong_size_writes_nothing() {
        let scratch = ScratchFolder::new();
        let path = scratch.path("i.png");
        let raster = Raster {
            width: 2,
            height: 2,
            samples: Digits::Eight(Cow::Borrowed(&[0; 11])),
            color_space: ColorSpace::Srgb,
            metadata: Metadata::new(),
        };
        assert!(write_png(&path, &raster).is_err());
        assert!(!path.exists());
    }
}
