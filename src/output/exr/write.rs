//! Images into files.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom, Write};
use std::path::Path;

use ::exr::image::Blocks;
use ::exr::meta::attribute::Chromaticities;
use ::exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Compression, Encoding, FlatSamples, Image,
    ImageAttributes, IntegerBounds, Layer, LayerAttributes, LineOrder, WritableImage, f16,
};

use super::{BAND_SCALE, DENSITY, ERROR, ExrBands, PHOTOMETRY, PREFIX, SAMPLES, band_name, text};
use crate::color::{D65_XY, Photometry, REC709_XY, Xyz, rec709_from_xyz};
use crate::error::{Error, Result};
use crate::image::SpectralImage;
use crate::output::atomic::write_atomically;

/// Name of the part that holds all light, in a file of several.
const WHOLE: &str = "all";

/// Writes `image` to `path` with all its bits; see [`write_exr_as`].
///
/// Errors: as [`write_exr_as`].
pub fn write_exr(path: &Path, image: &SpectralImage) -> Result<()> {
    write_exr_as(path, image, ExrBands::Float)
}

/// Writes `image` to `path`, whole or not at all; equal images give equal bytes.
///
/// Errors: [`Error::Io`]; [`Error::Inconsistent`] for an image without pixels.
pub fn write_exr_as(path: &Path, image: &SpectralImage, bands: ExrBands) -> Result<()> {
    if image.width == 0 || image.height == 0 {
        return Err(Error::inconsistent("image", "has no pixels"));
    }
    check_finite(image)?;
    let part = |image: &SpectralImage, name: Option<&str>| {
        let mut attributes = attributes(image, bands);
        attributes.layer_name = name.map(text);
        let size = (image.width, image.height);
        let encoding = Encoding {
            compression: match bands {
                ExrBands::Pxr24 => Compression::PXR24,
                _ => Compression::ZIP16,
            },
            blocks: Blocks::ScanLines,
            // In order, whichever thread compressed a block.
            line_order: LineOrder::Increasing,
        };
        let channels = AnyChannels::sort(channels(image, bands).into_iter().collect());
        Layer::new(size, attributes, encoding, channels)
    };
    // A part of its own for each layer; without layers the file has one part, without a name.
    let name = (!image.layers.is_empty()).then_some(WHOLE);
    let layers = image.layers.iter().map(|layer| part(&image.layer(layer), Some(&layer.name)));
    let parts: Vec<_> = std::iter::once(part(image, name)).chain(layers).collect();
    let window = IntegerBounds::from_dimensions((image.width, image.height));
    let mut exr = Image::from_layers(ImageAttributes::new(window), parts);
    exr.attributes.chromaticities = Some(rec709_chromaticities());
    write_atomically(path, |file| {
        exr.write().to_unbuffered(&mut *file).map_err(io_error)?;
        sort_attributes(file)
    })
}

/// Errors: a pixel that the file cannot hold.
fn check_finite(image: &SpectralImage) -> Result<()> {
    let fits = |c: &Xyz| [c.x, c.y, c.z].into_iter().all(|value| (value as f32).is_finite());
    let xyz = image.to_xyz();
    if let Some(at) = xyz.pixels.iter().position(|color| !fits(color)) {
        return Err(xyz.pixel_error(at, "does not fit into the file"));
    }
    let is_bad = |layer: &&crate::image::Layer| layer.bands.iter().any(|value| !value.is_finite());
    image.layers.iter().find(is_bad).map_or(Ok(()), |layer| {
        Err(Error::inconsistent("image", format!("layer \"{}\" is not finite", layer.name)))
    })
}

fn io_error(error: ::exr::error::Error) -> io::Error {
    match error {
        ::exr::error::Error::Io(error) => error,
        other => io::Error::other(other.to_string()),
    }
}

fn rec709_chromaticities() -> Chromaticities {
    let [red, green, blue] = REC709_XY.map(|[x, y]| ::exr::math::Vec2(x as f32, y as f32));
    let [x, y] = D65_XY;
    Chromaticities { red, green, blue, white: ::exr::math::Vec2(x as f32, y as f32) }
}

fn channels(image: &SpectralImage, bands: ExrBands) -> Vec<AnyChannel<FlatSamples>> {
    let xyz: Vec<[f64; 3]> = image.to_xyz().pixels.into_iter().map(Into::into).collect();
    let rgb: Vec<[f64; 3]> = xyz.iter().map(|&c| rec709_from_xyz(c.into())).collect();
    let mut channels = Vec::new();
    for (names, pixels) in [(["CIE.X", "CIE.Y", "CIE.Z"], &xyz), (["R", "G", "B"], &rgb)] {
        for (c, name) in names.into_iter().enumerate() {
            channels.push(channel(name, pixels.iter().map(|p| p[c] as f32).collect()));
        }
    }
    let stride = image.grid.bands();
    let scale = half_scale(image);
    for (band, lambda_nm) in image.grid.wavelengths_nm().enumerate() {
        let values = image.bands.iter().skip(band).step_by(stride).copied();
        let name = band_name(lambda_nm);
        match bands {
            ExrBands::None => break,
            ExrBands::Float | ExrBands::Pxr24 => channels.push(channel(&name, values.collect())),
            ExrBands::Half => {
                let halves = values.map(|value| f16::from_f32(value / scale)).collect();
                channels.push(AnyChannel::new(name.as_str(), FlatSamples::F16(halves)));
            }
        }
    }
    for (name, values) in [(ERROR, &image.error), (SAMPLES, &image.samples)] {
        channels.extend(values.as_ref().map(|values| channel(name, values.clone())));
    }
    channels
}

/// The power of two that brings the largest band below 2¹⁵, half of what a half can hold.
fn half_scale(image: &SpectralImage) -> f32 {
    let largest = image.bands.iter().fold(0f32, |most, &value| most.max(value.abs()));
    if !(largest > 0.0 && largest.is_finite()) {
        return 1.0;
    }
    (largest.log2().ceil().clamp(-110.0, 120.0) - 15.0).exp2()
}

fn channel(name: &str, values: Vec<f32>) -> AnyChannel<FlatSamples> {
    AnyChannel::new(name, FlatSamples::F32(values))
}

fn attributes(image: &SpectralImage, bands: ExrBands) -> LayerAttributes {
    let density = match image.photometry {
        Photometry::Absolute => "per nm",
        Photometry::Relative => "per nm, relative: without an absolute unit",
    };
    let mut attributes = LayerAttributes::default();
    if image.photometry == Photometry::Absolute {
        // RGB (1, 1, 1) is Y = 1 cd/m².
        attributes.white_luminance = Some(1.0);
    }
    let mut set = |key: &str, value: &str| {
        attributes.other.insert(text(key), AttributeValue::Text(text(value)));
    };
    set("spectralLayoutVersion", "1.0");
    set("emissiveUnits", "W.m^-2.sr^-1");
    set(DENSITY, density);
    set(&format!("{PREFIX}{PHOTOMETRY}"), photometry_name(image.photometry));
    if bands == ExrBands::Half {
        set(&format!("{PREFIX}{BAND_SCALE}"), &half_scale(image).to_string());
    }
    for (key, value) in &image.metadata {
        set(&format!("{PREFIX}{key}"), value);
    }
    attributes
}

fn photometry_name(photometry: Photometry) -> &'static str {
    match photometry {
        Photometry::Relative => "relative",
        Photometry::Absolute => "absolute",
    }
}

/// Puts the header's attributes in the order of their names.
///
/// The crate keeps ours in a hash map, so that their order, and with it the bytes of the file,
/// would differ from run to run. Sorting moves nothing that follows the header.
fn sort_attributes(file: &mut File) -> io::Result<()> {
    const MAGIC_AND_VERSION: u64 = 8;
    /// A bit of the version's second byte.
    const MULTIPART: u8 = 0x10;
    let mut version = [0; MAGIC_AND_VERSION as usize];
    file.seek(SeekFrom::Start(0))?;
    file.read_exact(&mut version)?;
    let mut start = MAGIC_AND_VERSION;
    loop {
        file.seek(SeekFrom::Start(start))?;
        let mut attributes = Vec::new();
        let mut input = BufReader::new(&mut *file);
        while let Some(attribute) = read_attribute(&mut input)? {
            attributes.push(attribute);
        }
        attributes.sort();
        let header = attributes.concat();
        file.seek(SeekFrom::Start(start))?;
        file.write_all(&header)?;
        // The last header of several is an empty one.
        if version[5] & MULTIPART == 0 || header.is_empty() {
            return Ok(());
        }
        start += header.len() as u64 + 1;
    }
}

/// The bytes of one attribute: name, type, size, value; `None` at the header's end.
fn read_attribute(input: &mut impl Read) -> io::Result<Option<Vec<u8>>> {
    let mut bytes = Vec::new();
    read_string(input, &mut bytes)?;
    if bytes == [0] {
        return Ok(None);
    }
    read_string(input, &mut bytes)?;
    let mut size = [0; 4];
    input.read_exact(&mut size)?;
    bytes.extend(size);
    let start = bytes.len();
    bytes.resize(start + u32::from_le_bytes(size) as usize, 0);
    input.read_exact(&mut bytes[start..])?;
    Ok(Some(bytes))
}

/// Appends a NUL-terminated string with its NUL.
fn read_string(input: &mut impl Read, bytes: &mut Vec<u8>) -> io::Result<()> {
    let mut byte = [1];
    while byte != [0] {
        input.read_exact(&mut byte)?;
        bytes.extend(byte);
    }
    Ok(())
}
