//! Speos `.ray`: a header of 28 bytes, then x y z l m n λ energy, 4 bytes each.
//!
//! The format has no mark: it is told by its size and by rays that are rays. Lengths are mm,
//! wavelengths nm. The header's first number is the radiant flux in W, its last the luminous flux
//! in lm; what the five words between them hold is not published.

use super::binary::{ByteOrder, RayBlock};
use super::input::{Header, Input};
use super::record::Layout;
use super::spectral::Tag;
use super::{FileSpectrum, FluxUnit, Format, Parsed, known};
use crate::error::Result;

const HEADER_BYTES: usize = 28;
const RECORD_BYTES: usize = 32;

mod offset {
    pub const RADIANT_FLUX: usize = 0;
    pub const LUMINOUS_FLUX: usize = 24;
}

fn layout() -> Layout {
    let tag = Tag::Wavelength { column: 6, nm_per_unit: 1.0 };
    Layout { columns: 8, flux: 7, tag, ..Layout::seven_columns() }
}

/// Whether the head of a file of `bytes` bytes has two fluxes and then rays, of which a few may be
/// stray.
pub(super) fn is_speos(head: &[u8], bytes: u64) -> bool {
    let Some((header, rows)) = head.split_at_checked(HEADER_BYTES) else { return false };
    let is_whole = (bytes - HEADER_BYTES as u64).is_multiple_of(RECORD_BYTES as u64);
    let header = Header(header.to_vec());
    let is_flux = |at: usize| (0.0..1e12).contains(&header.f32(at));
    let (rows, _) = rows.as_chunks::<RECORD_BYTES>();
    let good = rows.iter().filter(|row| is_ray(row)).count();
    is_whole
        && is_flux(offset::RADIANT_FLUX)
        && is_flux(offset::LUMINOUS_FLUX)
        && good > 0
        && 10 * good >= 9 * rows.len()
}

fn is_ray(row: &[u8; RECORD_BYTES]) -> bool {
    let (words, _) = row.as_chunks::<4>();
    let row: Vec<f32> = words.iter().map(|&word| f32::from_le_bytes(word)).collect();
    layout().record(|column| row[column]).is_ok() && (100.0..1e5).contains(&row[6])
}

pub(super) fn read(input: &mut Input) -> Result<Parsed> {
    let header = Header(input.take(HEADER_BYTES as u64, "the header")?);
    let rays = input.bytes_left() / RECORD_BYTES as u64;
    let (layout, unit) = (layout(), FluxUnit::Watt);
    let block = RayBlock { layout: &layout, unit, rays, order: ByteOrder::Little };
    let mut parsed = Parsed::new(Format::Speos, block.read(input, 0)?, unit);
    parsed.header_flux = known(header.f32(offset::RADIANT_FLUX));
    parsed.header_lm = known(header.f32(offset::LUMINOUS_FLUX));
    parsed.spectrum = FileSpectrum::PerRay;
    Ok(parsed)
}
