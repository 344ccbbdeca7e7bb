//! Files: EXR, PNG, tables and text, each written whole or not at all.

mod atomic;
mod base64;
mod color_picture;
mod digits;
mod exchange;
mod exr;
mod hdr;
mod png;
mod radiance;
#[cfg(test)]
pub(crate) mod scratch;

use std::path::Path;

use crate::error::Result;
use crate::light::RaySet;
use crate::source::rayfile::{self, SaveFormat};
use crate::spectrum::Spectrum;

pub use atomic::{
    confine, create, make_folder, write_atomically, write_csv, write_text, write_unsynced,
};
pub use base64::base64;
pub use color_picture::{ColorPicture, Primaries, declared_size, read_color_picture};
pub use exchange::{write_float_tiff, write_jpeg, write_tiff};
pub use exr::{
    ExrBands, ExrInfo, exr_band_count, read_exr, read_exr_info, write_exr, write_exr_as,
};
pub use hdr::{HdrColors, write_hdr};
pub use png::{
    ColorSpace, Digits, Raster, develop_png, develop_raster, display_raster, encode_png, read_png,
    write_png,
};

/// Writes a ray file, whole or not at all.
///
/// Errors: [`crate::Error::Io`]; as [`rayfile::writer`].
pub fn save_rays(
    path: &Path,
    rays: &RaySet,
    spectrum: &Spectrum,
    format: SaveFormat,
) -> Result<()> {
    write_atomically(path, rayfile::writer(path, rays, spectrum, format)?)
}
