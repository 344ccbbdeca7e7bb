//! Pictures of colors, read for surroundings and comparison: EXR, Radiance, PNG, JPEG and TIFF, told
//! apart by content.

use std::io::{BufRead, BufReader};
use std::path::Path;

use ::exr::prelude::{AnyChannels, FlatSamples, ReadChannels, ReadLayers, read as read_exr};
use glam::{DMat3, DVec3};

use super::{digits, radiance};
use crate::color::{D65_XY, REC709_XY, Xyz, xyz_from_primaries};
use crate::error::{Error, Place, Result};
use crate::input;

/// Linear colors, row by row from the top left.
#[derive(Debug, Clone, PartialEq)]
pub struct ColorPicture {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Red, green and blue; `width` × `height` of them.
    pub pixels: Vec<[f32; 3]>,
    /// Which colors the three are.
    pub primaries: Primaries,
    /// cd/m² of the white (1, 1, 1), or of Y = 1, where the file tells it.
    pub cd_m2_of_one: Option<f64>,
}

/// What the three numbers of a pixel are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Primaries {
    /// Chromaticities of red, green and blue, and of their white.
    Rgb([[f64; 2]; 3], [f64; 2]),
    /// What leads from them to XYZ, Y of (1, 1, 1) being 1.
    Matrix(DMat3),
    /// CIE 1931 X, Y and Z.
    Xyz,
}

impl ColorPicture {
    /// Colors as XYZ; Y of white is 1.
    pub fn colors(&self) -> impl Iterator<Item = Xyz> + Clone {
        let xyz_from_rgb = match self.primaries {
            Primaries::Rgb(primaries, white) => xyz_from_primaries(primaries, white),
            Primaries::Matrix(matrix) => matrix,
            Primaries::Xyz => DMat3::IDENTITY,
        };
        let color = move |pixel: &[f32; 3]| {
            Xyz::from(xyz_from_rgb * DVec3::from_array(pixel.map(f64::from)))
        };
        self.pixels.iter().map(color)
    }
}

/// Reads an EXR picture with channels R, G, B, or X, Y, Z, or Y alone, a Radiance one, or a PNG, JPEG
/// or TIFF one: digits are what its profile says, else sRGB's, and floats linear.
///
/// Errors: [`Error::Io`]; [`Error::BadFile`] for other files, and for pixels that are not finite.
pub fn read_color_picture(path: &Path) -> Result<ColorPicture> {
    let mut file = BufReader::new(input::open(path)?);
    let start = file.fill_buf().map_err(|e| Error::io(path, e))?;
    let picture = if start.starts_with(super::exr::EXR_MAGIC) {
        exr_picture(path)?
    } else if radiance::MAGIC.iter().any(|magic| start.starts_with(magic)) {
        radiance::read(path, file)?
    } else if digits::is_of_digits(start) {
        digits::read(path, file)?
    } else {
        let problem =
            "no OpenEXR, Radiance, PNG, JPEG or TIFF picture (.exr, .hdr, .png, .jpg, .tif)";
        return Err(Error::bad_file(path, Place::File, problem));
    };
    match picture.pixels.iter().position(|pixel| pixel.iter().any(|v| !v.is_finite())) {
        None => Ok(picture),
        Some(at) => {
            let (x, y) = (at % picture.width, at / picture.width);
            let problem = format!("pixel ({x}, {y}) is {:?}", picture.pixels[at]);
            Err(Error::bad_file(path, Place::File, problem))
        }
    }
}

/// Columns and rows of a picture that [`read_color_picture`] reads, where a small file may declare a
/// large one; else none.
///
/// Errors: as [`read_color_picture`].
pub fn declared_size(path: &Path) -> Result<Option<[usize; 2]>> {
    let mut file = BufReader::new(input::open(path)?);
    let start = file.fill_buf().map_err(|e| Error::io(path, e))?;
    digits::is_of_digits(start).then(|| digits::size(path, file)).transpose()
}

fn exr_picture(path: &Path) -> Result<ColorPicture> {
    let image = read_exr()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(BufReader::new(input::open(path)?))
        .map_err(|e| super::exr::read_error(path, e))?;
    let channels = &image.layer_data.channel_data;
    let found = [["R", "G", "B"], ["X", "Y", "Z"], ["CIE.X", "CIE.Y", "CIE.Z"], ["Y", "Y", "Y"]]
        .into_iter()
        .find_map(|names| Some((names[0], three(channels, names)?)));
    let Some((first, samples)) = found else {
        let problem = "has no channels R, G, B, nor X, Y, Z, nor Y";
        return Err(Error::bad_file(path, Place::File, problem));
    };
    let shared = &image.attributes;
    let primaries = match shared.chromaticities {
        _ if first.ends_with('X') => Primaries::Xyz,
        None => Primaries::Rgb(REC709_XY, D65_XY),
        Some(given) => {
            let xy = |at: ::exr::math::Vec2<f32>| [f64::from(at.0), f64::from(at.1)];
            let primaries = [given.red, given.green, given.blue].map(xy);
            Primaries::Rgb(primaries, xy(given.white))
        }
    };
    let (width, height) = (image.layer_data.size.0, image.layer_data.size.1);
    let value = |at: usize, channel: usize| value(samples[channel], at);
    let pixels = (0..width * height).map(|at| [0, 1, 2].map(|c| value(at, c))).collect();
    let white = image.layer_data.attributes.white_luminance;
    let cd_m2_of_one = white.map(f64::from).filter(|white| *white > 0.0 && white.is_finite());
    Ok(ColorPicture { width, height, pixels, primaries, cd_m2_of_one })
}

fn three<'a>(
    channels: &'a AnyChannels<FlatSamples>,
    names: [&str; 3],
) -> Option<[&'a FlatSamples; 3]> {
    let find = |name: &str| {
        let found = channels.list.iter().find(|channel| channel.name.eq_case_insensitive(name));
        found.map(|channel| &channel.sample_data)
    };
    Some([find(names[0])?, find(names[1])?, find(names[2])?])
}

fn value(samples: &FlatSamples, at: usize) -> f32 {
    match samples {
        FlatSamples::F16(values) => values[at].to_f32(),
        FlatSamples::F32(values) => values[at],
        FlatSamples::U32(values) => values[at] as f32,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Photometry;
    use crate::image::{Metadata, SpectralImage};
    use crate::output::scratch::ScratchFolder;
    use crate::output::{ColorSpace, Digits, Raster, write_float_tiff, write_jpeg, write_tiff};
    use crate::spectrum::WavelengthGrid;

    #[test]
    fn digits_are_srgb_and_floats_linear() {
        let scratch = ScratchFolder::new();
        let raster = |samples| {
            let (color_space, metadata) = (ColorSpace::Srgb, Metadata::new());
            Raster { width: 2, height: 1, samples, color_space, metadata }
        };
        // The digit 188 of sRGB is half as bright as its white: 0.5029.
        let path = scratch.path("i.tif");
        write_tiff(&path, &raster(Digits::Eight(vec![188, 0, 255, 188, 0, 255].into()))).unwrap();
        let read = read_color_picture(&path).unwrap();
        assert_eq!((read.width, read.height), (2, 1));
        let [half, black, white] = read.pixels[1];
        assert!((half - 0.5029).abs() < 1e-4 && black == 0.0 && white == 1.0, "{half}");
        let path = scratch.path("i.jpg");
        write_jpeg(&path, &raster(Digits::Eight(vec![188; 6].into())), 100).unwrap();
        let [red, ..] = read_color_picture(&path).unwrap().pixels[0];
        // One digit more or less is 0.006.
        assert!((red - 0.5029).abs() < 0.01, "{red}");
        let path = scratch.path("f.tif");
        let mut image = SpectralImage::new(2, 1, WavelengthGrid::Step20, Photometry::Absolute);
        image.bands.fill(0.01);
        write_float_tiff(&path, &image).unwrap();
        let color = read_color_picture(&path).unwrap().colors().next().unwrap();
        let expected = image.to_xyz().pixels[0];
        assert!(expected.y > 100.0 && (color.y / expected.y - 1.0).abs() < 1e-6, "{color:?}");
        std::fs::write(&path, b"II*\0cut off").unwrap();
        let message = read_color_picture(&path).unwrap_err().to_string();
        assert!(message.contains("f.tif: not a readable picture"), "{message}");
    }
}
