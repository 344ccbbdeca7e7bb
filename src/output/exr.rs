//! Images as OpenEXR files in the spectral layout of Fichet, Pacanowski & Wilkie, JCGT 10(3), 2021.
//!
//! Channels, 32-bit float, ZIP: `R G B` (linear Rec. 709) and `CIE.X CIE.Y CIE.Z` (eq. 4, in a
//! layer of their own: programs that know XYZ channels mean other things by them), one a band
//! (`S0.380,000000nm`, a comma because a dot would part layers), and `error` and `samples` where
//! the image has them. [`ExrBands`] makes files smaller. The layout's one legal unit has no nm⁻¹, yet its reference code
//! integrates the bands over λ: they are samples of a density, and [`DENSITY`] says so.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::path::Path;

use ::exr::image::Blocks;
use ::exr::math::Vec2;
use ::exr::meta::attribute::Chromaticities;
use ::exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Compression, Encoding, FlatSamples, Image,
    ImageAttributes, IntegerBounds, Layer, LayerAttributes, LineOrder, MetaData, ReadChannels,
    ReadLayers, Text, WritableImage, f16, read,
};

use super::atomic::write_atomically;
use crate::color::{D65_XY, Photometry, REC709_XY, Xyz, rec709_from_xyz};
use crate::error::{Error, Place, Result};
use crate::image::{Metadata, SpectralImage};
use crate::input;
use crate::spectrum::WavelengthGrid;

/// Attribute that says what the bands are a density over.
pub const DENSITY: &str = "spectralDensity";
/// Attributes of our own: this before a key of [`Metadata`], or before `photometry`.
pub const PREFIX: &str = "lampyris.";

/// How an EXR file holds the spectra.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ExrBands {
    /// 32-bit floats: the file reads back bit for bit.
    #[default]
    Float,
    /// 16-bit floats, scaled so that the largest value lies near their top: relative error 2⁻¹¹
    /// over nine decades.
    Half,
    /// Floats of 24 bits (PXR24), colors too: relative error 2⁻¹⁶.
    Pxr24,
    /// Only the colors; such a file does not read back.
    None,
}

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

/// Name of the part that holds all light, in a file of several.
const WHOLE: &str = "all";

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

const ERROR: &str = "error";
const SAMPLES: &str = "samples";

fn channel(name: &str, values: Vec<f32>) -> AnyChannel<FlatSamples> {
    AnyChannel::new(name, FlatSamples::F32(values))
}

fn band_name(lambda_nm: f64) -> String {
    format!("S0.{}nm", format!("{lambda_nm:.6}").replace('.', ","))
}

/// Wavelength of an emissive band in nm, from its channel's name.
fn band_wavelength_nm(channel: &str) -> Option<f64> {
    channel.strip_prefix("S0.")?.strip_suffix("nm")?.replace(',', ".").parse().ok()
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

const PHOTOMETRY: &str = "photometry";
/// What the bands of the file are to be multiplied by.
const BAND_SCALE: &str = "band_scale";

fn photometry_name(photometry: Photometry) -> &'static str {
    match photometry {
        Photometry::Relative => "relative",
        Photometry::Absolute => "absolute",
    }
}

/// UTF-8, as OpenEXR asks for, where the crate's own conversion stops at Latin-1.
fn text(string: &str) -> Text {
    Text::from_bytes_unchecked(string.bytes().collect())
}

fn string(text: &Text) -> String {
    String::from_utf8_lossy(text.as_slice()).into_owned()
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

/// What an EXR file holds, without its pixels.
#[derive(Debug, Clone, PartialEq)]
pub struct ExrInfo {
    /// Pixels of a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Names of the first part's channels, in the file's order.
    pub channels: Vec<String>,
    /// Bands of the spectral layout, nm, ascending.
    pub wavelengths_nm: Vec<f64>,
    /// Text attributes.
    pub attributes: Metadata,
}

/// How EXR files begin.
pub(super) const EXR_MAGIC: &[u8] = &[0x76, 0x2f, 0x31, 0x01];

/// Errors: [`Error::Io`]; [`Error::BadFile`] if it is no EXR file.
pub fn read_exr_info(path: &Path) -> Result<ExrInfo> {
    let file = BufReader::new(input::open(path)?);
    let meta = MetaData::read_from_buffered(file, false).map_err(|e| read_error(path, e))?;
    let header = meta.headers.first();
    let header = header.ok_or_else(|| Error::bad_file(path, Place::File, "has no layer"))?;
    let channels: Vec<String> = header.channels.list.iter().map(|c| string(&c.name)).collect();
    let mut wavelengths_nm: Vec<f64> =
        channels.iter().filter_map(|c| band_wavelength_nm(c)).collect();
    wavelengths_nm.sort_by(f64::total_cmp);
    let (own, shared) = (&header.own_attributes.other, &header.shared_attributes.other);
    let attributes = own.iter().chain(shared).filter_map(text_attribute).collect();
    let (width, height) = (header.layer_size.0, header.layer_size.1);
    Ok(ExrInfo { width, height, channels, wavelengths_nm, attributes })
}

/// Whether a file is an EXR one with bands; an EXR file with colors alone is none.
///
/// Errors: [`Error::Io`]; [`Error::BadFile`] for a broken EXR file.
pub fn is_spectral_exr(path: &Path) -> Result<bool> {
    let mut start = BufReader::new(input::open(path)?);
    let start = start.fill_buf().map_err(|e| Error::io(path, e))?;
    Ok(start.starts_with(EXR_MAGIC) && {
        let info = read_exr_info(path)?;
        let has_colors = ["R", "X", "CIE.X", "Y"]
            .iter()
            .any(|name| info.channels.iter().any(|channel| channel.eq_ignore_ascii_case(name)));
        !(info.wavelengths_nm.is_empty() && has_colors)
    })
}

fn text_attribute((key, value): (&Text, &AttributeValue)) -> Option<(String, String)> {
    match value {
        AttributeValue::Text(value) => Some((string(key), string(value))),
        _ => None,
    }
}

pub(super) fn read_error(path: &Path, error: ::exr::error::Error) -> Error {
    match error {
        ::exr::error::Error::Io(error) => Error::io(path, error),
        other => Error::bad_file(path, Place::File, format!("not a readable EXR file: {other}")),
    }
}

/// Reads a file of [`write_exr`], bit for bit; with its view, where the metadata tells it.
///
/// Errors: [`Error::Io`]; [`Error::BadFile`] if it is no EXR file, or its bands are not 380 to
/// 780 nm in steps of 5, 10 or 20 nm.
pub fn read_exr(path: &Path) -> Result<SpectralImage> {
    let info = read_exr_info(path)?;
    let grid = grid_of(&info.wavelengths_nm).ok_or_else(|| {
        let found = describe_bands(&info.wavelengths_nm);
        let problem = format!("has {found}, expected 380 to 780 nm in steps of 5, 10 or 20 nm");
        Error::bad_file(path, Place::File, problem)
    })?;
    let exr = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_buffered(BufReader::new(input::open(path)?))
        .map_err(|e| read_error(path, e))?;
    let mut image = SpectralImage::new(info.width, info.height, grid, photometry_of(&info));
    image.metadata = own_metadata(&info);
    image.view = image.metadata.get("view").and_then(|view| view.parse().ok());
    let mut parts = exr.layer_data.into_iter();
    if let Some(whole) = parts.next() {
        place_part(&mut image, whole, path)?;
    }
    for part in parts {
        let name = part.attributes.layer_name.as_ref().map(string).unwrap_or_default();
        let mut layer = SpectralImage::new(info.width, info.height, grid, image.photometry);
        if part.size != Vec2(info.width, info.height) {
            let problem = format!("part \"{name}\" is of another size");
            return Err(Error::bad_file(path, Place::File, problem));
        }
        place_part(&mut layer, part, path)?;
        image.layers.push(crate::image::Layer { name, bands: layer.bands });
    }
    Ok(image)
}

fn place_part(
    image: &mut SpectralImage,
    part: Layer<AnyChannels<FlatSamples>>,
    path: &Path,
) -> Result<()> {
    for channel in part.channel_data.list {
        place_channel(image, &string(&channel.name), &channel.sample_data);
    }
    let bad = |problem| Error::bad_file(path, Place::File, problem);
    let key = format!("{PREFIX}{BAND_SCALE}");
    if let Some(AttributeValue::Text(scale)) = part.attributes.other.get(&text(&key)) {
        let scale = string(scale).parse::<f32>();
        let scale = scale.map_err(|_| bad(format!("{key} is no number")))?;
        image.bands.iter_mut().for_each(|value| *value *= scale);
    }
    match image.bands.iter().position(|value| !value.is_finite()) {
        None => Ok(()),
        Some(at) => {
            let pixel = at / image.grid.bands();
            let (x, y) = (pixel % image.width, pixel / image.width);
            Err(bad(format!("pixel ({x}, {y}) is not finite")))
        }
    }
}

fn describe_bands(wavelengths_nm: &[f64]) -> String {
    match wavelengths_nm {
        [] => "no spectral bands".to_owned(),
        [first, .., last] => format!("{} bands, {first} to {last} nm", wavelengths_nm.len()),
        [one] => format!("one band, {one} nm"),
    }
}

fn grid_of(wavelengths_nm: &[f64]) -> Option<WavelengthGrid> {
    let grids = [WavelengthGrid::Step5, WavelengthGrid::Step10, WavelengthGrid::Step20];
    grids.into_iter().find(|grid| grid.wavelengths_nm().eq(wavelengths_nm.iter().copied()))
}

fn photometry_of(info: &ExrInfo) -> Photometry {
    match info.attributes.get(&format!("{PREFIX}{PHOTOMETRY}")).map(String::as_str) {
        Some("relative") => Photometry::Relative,
        // The layout's unit says radiance.
        _ => Photometry::Absolute,
    }
}

fn own_metadata(info: &ExrInfo) -> Metadata {
    let own = info.attributes.iter();
    own.filter_map(|(key, value)| Some((key.strip_prefix(PREFIX)?.to_owned(), value.clone())))
        .filter(|(key, _)| key != PHOTOMETRY && key != BAND_SCALE)
        .collect()
}

fn place_channel(image: &mut SpectralImage, name: &str, samples: &FlatSamples) {
    match name {
        ERROR => image.error = Some(samples.values_as_f32().collect()),
        SAMPLES => image.samples = Some(samples.values_as_f32().collect()),
        _ => {
            let lambda_nm = band_wavelength_nm(name);
            let band = image.grid.wavelengths_nm().position(|l| Some(l) == lambda_nm);
            let stride = image.grid.bands();
            let places = image.bands.iter_mut().skip(band.unwrap_or(usize::MAX)).step_by(stride);
            places.zip(samples.values_as_f32()).for_each(|(place, value)| *place = value);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Region;
    use crate::output::scratch::ScratchFolder;

    /// Values from subnormal to 1e31, whose tristimulus values fit too.
    fn image(grid: WavelengthGrid) -> SpectralImage {
        let mut image = SpectralImage::new(37, 21, grid, Photometry::Relative);
        let mut state = 1u32;
        for value in &mut image.bands {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            *value = f32::from_bits(state % 0x7300_0000);
        }
        image.error = Some((0..37 * 21).map(|i| i as f32 * 0.1).collect());
        image.samples = Some(vec![4.0; 37 * 21]);
        for (key, value) in [("script", "전조등.lua"), ("view", "azimuth 15°"), ("version", "0.1")]
        {
            image.metadata.insert(key.to_owned(), value.to_owned());
        }
        image
    }

    #[test]
    fn reads_back_bit_for_bit() {
        let scratch = ScratchFolder::new();
        for grid in [WavelengthGrid::Step5, WavelengthGrid::Step10, WavelengthGrid::Step20] {
            let path = scratch.path("i.exr");
            let written = image(grid);
            write_exr(&path, &written).unwrap();
            assert_eq!(read_exr(&path).unwrap(), written);
        }
    }

    #[test]
    fn layers_read_back_in_parts() {
        let scratch = ScratchFolder::new();
        let (path, again) = (scratch.path("i.exr"), scratch.path("again.exr"));
        let mut written = image(WavelengthGrid::Step20);
        for (name, value) in [("light 1", 0.25f32), ("빛 2", 3.0)] {
            let bands = vec![value; written.bands.len()];
            written.layers.push(crate::image::Layer { name: name.to_owned(), bands });
        }
        for bands in [ExrBands::Float, ExrBands::Half] {
            write_exr_as(&path, &written, bands).unwrap();
            let read = read_exr(&path).unwrap();
            assert_eq!(read.layers, written.layers);
            assert_eq!(read.metadata, written.metadata);
        }
        write_exr(&path, &written).unwrap();
        assert_eq!(read_exr(&path).unwrap(), written);
        write_exr(&again, &read_exr(&path).unwrap()).unwrap();
        assert!(std::fs::read(&path).unwrap() == std::fs::read(&again).unwrap());
    }

    #[test]
    fn equal_images_give_equal_bytes() {
        let scratch = ScratchFolder::new();
        let bytes = |name: &str| {
            let path = scratch.path(name);
            write_exr(&path, &image(WavelengthGrid::Step20)).unwrap();
            std::fs::read(path).unwrap()
        };
        // The crate's hash map would give two orders in all but one run of 5040.
        assert!(bytes("a.exr") == bytes("b.exr"));
    }

    #[test]
    fn layout_is_the_spectral_one() {
        let scratch = ScratchFolder::new();
        let path = scratch.path("i.exr");
        write_exr(&path, &image(WavelengthGrid::Step5)).unwrap();
        let info = read_exr_info(&path).unwrap();
        assert_eq!((info.width, info.height, info.channels.len()), (37, 21, 6 + 81 + 2));
        for name in ["CIE.X", "CIE.Y", "CIE.Z", "R", "G", "B", "S0.380,000000nm", "S0.555,000000nm"]
        {
            assert!(info.channels.iter().any(|c| c == name), "{name}");
        }
        assert_eq!(info.wavelengths_nm.len(), 81);
        let attribute = |key: &str| info.attributes[key].as_str();
        assert_eq!(attribute("spectralLayoutVersion"), "1.0");
        assert_eq!(attribute("emissiveUnits"), "W.m^-2.sr^-1");
        assert_eq!(attribute("spectralDensity"), "per nm, relative: without an absolute unit");
        assert_eq!(attribute("lampyris.photometry"), "relative");
        assert_eq!(attribute("lampyris.script"), "전조등.lua");
    }

    #[test]
    fn xyz_channels_are_the_sums_of_the_bands() {
        let scratch = ScratchFolder::new();
        let path = scratch.path("i.exr");
        let mut flat = SpectralImage::new(2, 1, WavelengthGrid::Step5, Photometry::Absolute);
        flat.bands[81..].fill(0.01);
        write_exr(&path, &flat).unwrap();
        let exr = ::exr::prelude::read_first_flat_layer_from_file(&path).unwrap();
        let value = |name: &str| {
            let channels = &exr.layer_data.channel_data.list;
            let channel = channels.iter().find(|c| string(&c.name) == name).unwrap();
            channel.sample_data.values_as_f32().nth(1).unwrap()
        };
        let xyz = flat.mean_xyz(Region::pixel(1, 0)).unwrap();
        let rgb = rec709_from_xyz(xyz);
        let names = ["CIE.X", "CIE.Y", "CIE.Z", "G"];
        for (name, expected) in names.into_iter().zip([xyz.x, xyz.y, xyz.z, rgb[1]]) {
            // One rounding to f32.
            assert!((f64::from(value(name)) - expected).abs() <= 1e-7 * expected, "{name}");
        }
    }

    #[test]
    fn colors_say_what_they_are() {
        let scratch = ScratchFolder::new();
        let path = scratch.path("i.exr");
        for (photometry, luminance) in
            [(Photometry::Absolute, Some(1.0)), (Photometry::Relative, None)]
        {
            let image = SpectralImage::new(2, 1, WavelengthGrid::Step20, photometry);
            write_exr(&path, &image).unwrap();
            let exr = ::exr::prelude::read_first_flat_layer_from_file(&path).unwrap();
            assert_eq!(exr.layer_data.attributes.white_luminance, luminance);
            let chromaticities = exr.attributes.chromaticities.unwrap();
            assert_eq!(chromaticities.red, ::exr::math::Vec2(0.64, 0.33));
        }
    }

    #[test]
    fn small_files_keep_what_they_say() {
        let scratch = ScratchFolder::new();
        let path = scratch.path("i.exr");
        let mut written = SpectralImage::new(31, 9, WavelengthGrid::Step20, Photometry::Absolute);
        for (at, value) in written.bands.iter_mut().enumerate() {
            *value = 3e-9 * 1.013f32.powi((at % 1500) as i32);
        }
        for (bands, tolerance) in [(ExrBands::Half, 4.9e-4), (ExrBands::Pxr24, 1.54e-5)] {
            write_exr_as(&path, &written, bands).unwrap();
            let read = read_exr(&path).unwrap();
            let largest = written.bands.iter().copied().fold(0.0, f32::max);
            for (read, value) in read.bands.iter().zip(&written.bands) {
                // Below its normal numbers a half has fewer bits.
                let allowed = tolerance * value.max(largest * 2e-9);
                assert!((read - value).abs() <= allowed, "{bands:?}: {value} became {read}");
            }
            assert_eq!(read.metadata, written.metadata);
        }
        write_exr_as(&path, &written, ExrBands::None).unwrap();
        assert!(read_exr(&path).unwrap_err().to_string().contains("has no spectral bands"));
    }

    #[test]
    fn other_files_are_refused() {
        let scratch = ScratchFolder::new();
        let path = scratch.path("i.exr");
        std::fs::write(&path, "not an image").unwrap();
        let message = read_exr(&path).unwrap_err().to_string();
        assert!(message.contains("i.exr: not a readable EXR file"), "{message}");
        ::exr::prelude::write_rgb_file(&path, 2, 2, |_, _| (0.0f32, 0.0f32, 0.0f32)).unwrap();
        let message = read_exr(&path).unwrap_err().to_string();
        assert!(
            message.ends_with(
                "has no spectral bands, expected 380 to 780 nm in steps of 5, 10 or 20 nm"
            )
        );
        let empty = SpectralImage::new(0, 4, WavelengthGrid::Step5, Photometry::Relative);
        assert!(write_exr(&path, &empty).is_err());
    }
}
