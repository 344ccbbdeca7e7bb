//! Images out of files.

use std::io::BufReader;
use std::path::Path;

use ::exr::prelude::{
    AnyChannels, AttributeValue, FlatSamples, Layer, MetaData, ReadChannels, ReadLayers, Text,
    Vec2, read,
};

use super::{
    BAND_SCALE, ERROR, EXR_MAGIC, PHOTOMETRY, PREFIX, SAMPLES, band_wavelength_nm, string, text,
};
use crate::color::Photometry;
use crate::error::{Error, Place, Result};
use crate::image::{Metadata, SpectralImage};
use crate::input;
use crate::spectrum::WavelengthGrid;

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

/// Bands of an EXR file, 0 if it holds colors alone; `None` for other files.
///
/// Errors: [`Error::Io`]; [`Error::BadFile`] for a broken EXR file.
pub fn exr_band_count(path: &Path) -> Result<Option<usize>> {
    let is_exr = input::head(path, EXR_MAGIC.len() as u64)? == EXR_MAGIC;
    is_exr.then(|| Ok(read_exr_info(path)?.wavelengths_nm.len())).transpose()
}

fn text_attribute((key, value): (&Text, &AttributeValue)) -> Option<(String, String)> {
    match value {
        AttributeValue::Text(value) => Some((string(key), string(value))),
        _ => None,
    }
}

pub(in crate::output) fn read_error(path: &Path, error: ::exr::error::Error) -> Error {
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
