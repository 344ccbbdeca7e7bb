//! Pictures for programs that take neither EXR nor PNG: TIFF and JPEG.

use std::io::{self, BufWriter};
use std::path::Path;

use ::image::codecs::jpeg::JpegEncoder;
use ::image::codecs::tiff::TiffEncoder;
use ::image::{ExtendedColorType, ImageEncoder};

use super::atomic::write_atomically;
use super::png::{Digits, Raster};
use crate::color::rec709_from_xyz;
use crate::error::{Error, Result};
use crate::image::SpectralImage;

/// Writes digits of 8 bits as a JPEG file, whole or not at all.
///
/// `quality`: 1 to 100. Errors: [`Error::Io`], also for a picture without pixels or larger than
/// 65535 a side; [`Error::Inconsistent`] for digits of more than 8 bits.
pub fn write_jpeg(path: &Path, raster: &Raster, quality: u8) -> Result<()> {
    let Digits::Eight(samples) = &raster.samples else {
        return Err(Error::inconsistent("JPEG", "holds 8 bits a channel: give a display of 8"));
    };
    let [width, height] = sides(raster.width, raster.height);
    write_atomically(path, |file| {
        let mut encoder = JpegEncoder::new_with_quality(BufWriter::new(file), quality);
        if let Some(profile) = raster.color_space.profile() {
            encoder.set_icc_profile(profile.to_vec()).map_err(io::Error::other)?;
        }
        let written = encoder.write_image(samples, width, height, ExtendedColorType::Rgb8);
        written.map_err(io::Error::other)
    })
}

/// Writes digits as a TIFF file of their bits, 8 or 16, whole or not at all.
///
/// Errors: [`Error::Io`], also for a picture without pixels.
pub fn write_tiff(path: &Path, raster: &Raster) -> Result<()> {
    match &raster.samples {
        Digits::Eight(samples) => {
            write_tiff_bytes(path, samples, [raster.width, raster.height], ExtendedColorType::Rgb8)
        }
        Digits::Sixteen(samples) => {
            let bytes: Vec<u8> = samples.iter().flat_map(|s| s.to_ne_bytes()).collect();
            write_tiff_bytes(path, &bytes, [raster.width, raster.height], ExtendedColorType::Rgb16)
        }
    }
}

/// Writes linear Rec. 709 as a TIFF file of 32-bit floats, in the image's unit: Y = 1 is (1, 1, 1).
///
/// Errors: as [`write_tiff`].
pub fn write_float_tiff(path: &Path, image: &SpectralImage) -> Result<()> {
    let pixels = image.to_xyz().pixels;
    let values = pixels.into_iter().flat_map(rec709_from_xyz);
    let bytes: Vec<u8> = values.flat_map(|value| (value as f32).to_ne_bytes()).collect();
    write_tiff_bytes(path, &bytes, [image.width, image.height], ExtendedColorType::Rgb32F)
}

fn write_tiff_bytes(
    path: &Path,
    bytes: &[u8],
    [width, height]: [usize; 2],
    color: ExtendedColorType,
) -> Result<()> {
    let [width, height] = sides(width, height);
    write_atomically(path, |file| {
        let written = TiffEncoder::new(&mut *file).write_image(bytes, width, height, color);
        written.map_err(io::Error::other)
    })
}

/// Images have less than 2³² pixels a side; another size does not match the bytes and is refused.
fn sides(width: usize, height: usize) -> [u32; 2] {
    [width, height].map(|side| u32::try_from(side).unwrap_or(u32::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Photometry;
    use crate::image::Metadata;
    use crate::output::png::ColorSpace;
    use crate::output::scratch::ScratchFolder;
    use crate::spectrum::WavelengthGrid;

    fn raster(samples: Digits<'static>) -> Raster<'static> {
        let (color_space, metadata) = (ColorSpace::Srgb, Metadata::new());
        Raster { width: 2, height: 1, samples, color_space, metadata }
    }

    #[test]
    fn digits_read_back() {
        let scratch = ScratchFolder::new();
        let path = scratch.path("i.tif");
        let sixteen = vec![0u16, 1, 258, 65535, 7, 300];
        write_tiff(&path, &raster(Digits::Sixteen(sixteen.clone().into()))).unwrap();
        assert_eq!(::image::open(&path).unwrap().to_rgb16().into_raw(), sixteen);
        let path = scratch.path("i.jpg");
        let eight = vec![200u8; 6];
        write_jpeg(&path, &raster(Digits::Eight(eight.into())), 95).unwrap();
        let read = ::image::open(&path).unwrap().to_rgb8().into_raw();
        assert!(read.iter().all(|&digit| digit.abs_diff(200) <= 2), "{read:?}");
        let message = write_jpeg(&path, &raster(Digits::Sixteen(vec![0; 6].into())), 95);
        assert_eq!(
            message.unwrap_err().to_string(),
            "JPEG: holds 8 bits a channel: give a display of 8"
        );
    }

    #[test]
    fn floats_are_the_light() {
        let scratch = ScratchFolder::new();
        let path = scratch.path("i.tif");
        let mut image = SpectralImage::new(3, 2, WavelengthGrid::Step20, Photometry::Absolute);
        image.bands.iter_mut().enumerate().for_each(|(at, value)| *value = at as f32);
        write_float_tiff(&path, &image).unwrap();
        let read = ::image::open(&path).unwrap().to_rgb32f().into_raw();
        let expected = image.to_xyz().pixels.into_iter().flat_map(rec709_from_xyz);
        for (value, expected) in read.into_iter().zip(expected) {
            assert_eq!(value, expected as f32);
        }
    }
}
