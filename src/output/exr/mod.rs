//! Images as OpenEXR files in the spectral layout of Fichet, Pacanowski & Wilkie, JCGT 10(3), 2021.
//!
//! Channels, 32-bit float, ZIP: `R G B` (linear Rec. 709) and `CIE.X CIE.Y CIE.Z` (eq. 4, in a
//! layer of their own: programs that know XYZ channels mean other things by them), one a band
//! (`S0.380,000000nm`, a comma because a dot would part layers), and `error` and `samples` where
//! the image has them. [`ExrBands`] makes files smaller. The layout's one legal unit has no nm⁻¹, yet
//! its reference code integrates the bands over λ: they are samples of a density, and [`DENSITY`] says
//! so.

mod read;
#[cfg(test)]
mod tests;
mod write;

use ::exr::prelude::Text;

pub(super) use read::read_error;
pub use read::{ExrInfo, exr_band_count, read_exr, read_exr_info};
pub use write::{write_exr, write_exr_as};

/// How EXR files begin.
pub(super) const EXR_MAGIC: &[u8] = &[0x76, 0x2f, 0x31, 0x01];

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
    /// Only the colors: what is read back has made-up spectra.
    None,
}

const ERROR: &str = "error";
const SAMPLES: &str = "samples";

fn band_name(lambda_nm: f64) -> String {
    format!("S0.{}nm", format!("{lambda_nm:.6}").replace('.', ","))
}

/// Wavelength of an emissive band in nm, from its channel's name.
fn band_wavelength_nm(channel: &str) -> Option<f64> {
    channel.strip_prefix("S0.")?.strip_suffix("nm")?.replace(',', ".").parse().ok()
}

const PHOTOMETRY: &str = "photometry";
/// What the bands of the file are to be multiplied by.
const BAND_SCALE: &str = "band_scale";

/// UTF-8, as OpenEXR asks for, where the crate's own conversion stops at Latin-1.
fn text(string: &str) -> Text {
    Text::from_bytes_unchecked(string.bytes().collect())
}

fn string(text: &Text) -> String {
    String::from_utf8_lossy(text.as_slice()).into_owned()
}
