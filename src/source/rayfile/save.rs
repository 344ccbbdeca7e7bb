//! Writing ray sets as IES TM-25 and CSV, so that reading them gives the same bits.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use super::tm25::{self, offset};
use super::{FLUX_TOLERANCE, csv};
use crate::error::{Error, Place, Result};
use crate::light::{RaySample, RaySet};
use crate::spectrum::{Spectrum, WavelengthGrid};

/// A format that can be written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SaveFormat {
    /// Text whose first line names the columns.
    Csv,
    /// IES TM-25, binary.
    Tm25,
}

impl SaveFormat {
    /// By the path's extension, in any case.
    ///
    /// Errors: another extension.
    pub fn of(path: &Path) -> Result<Self> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        match extension.as_deref() {
            Some("csv") => Ok(Self::Csv),
            Some("tm25ray") => Ok(Self::Tm25),
            _ => Err(Error::bad_file(path, Place::File, "rays are saved as .tm25ray or .csv")),
        }
    }
}

/// What writes rays where they are in the world, in mm and lm, to an open file.
///
/// TM-25 takes the spectrum along as its table (f32); CSV has no place for it. `path` is for
/// messages, and `output::save_rays` writes the file as a whole.
///
/// Errors: a set without light, and a start point that f32 cannot hold.
pub fn writer<'a>(
    path: &Path,
    rays: &'a RaySet,
    spectrum: &'a Spectrum,
    format: SaveFormat,
) -> Result<impl FnOnce(&mut File) -> io::Result<()> + 'a> {
    let export = Export::new(path, rays)?;
    Ok(move |file: &mut File| {
        let mut out = BufWriter::with_capacity(1 << 20, file);
        match format {
            SaveFormat::Csv => export.write_csv(&mut out)?,
            SaveFormat::Tm25 => export.write_tm25(&mut out, spectrum)?,
        }
        out.flush()
    })
}

/// Samples with their flux in lm, in world coordinates.
struct Export<'a> {
    rays: &'a RaySet,
    /// Factor to lm; 1 keeps the bits.
    scale: f64,
}

impl<'a> Export<'a> {
    fn new(path: &Path, rays: &'a RaySet) -> Result<Self> {
        let bad = |problem: &str| Err(Error::bad_file(path, Place::File, problem));
        let sum: f64 = rays.samples.iter().map(|s| f64::from(s.flux)).sum();
        let scale = rays.flux_lm / sum;
        if !(scale > 0.0 && scale.is_finite()) {
            return bad("the set to save carries no light");
        }
        // Within this the header's total counts and no reader warns, so that the rays stay as they
        // are.
        let scale = if (scale - 1.0).abs() <= FLUX_TOLERANCE { 1.0 } else { scale };
        let export = Self { rays, scale };
        let is_finite =
            |s: RaySample| s.position.iter().all(|x| x.is_finite()) && s.flux.is_finite();
        if !export.samples().all(is_finite) {
            return bad("the set to save has start points or flux beyond 3e38");
        }
        Ok(export)
    }

    fn samples(&self) -> impl Iterator<Item = RaySample> {
        self.rays.samples.iter().map(|sample| self.placed(sample))
    }

    fn placed(&self, sample: &RaySample) -> RaySample {
        let placement = &self.rays.world_from_local;
        let mut placed = *sample;
        if self.scale != 1.0 {
            placed.flux = (f64::from(sample.flux) * self.scale) as f32;
        }
        if *placement != glam::DAffine3::IDENTITY {
            let direction =
                placement.transform_vector3(sample.unit_direction()).normalize_or_zero();
            placed.position =
                placement.transform_point3(sample.origin()).to_array().map(|x| x as f32);
            placed.direction = direction.to_array().map(|x| x as f32);
        }
        placed
    }

    fn write_csv(&self, out: &mut impl Write) -> io::Result<()> {
        writeln!(out, "# Lampyris {}; mm, lm", env!("CARGO_PKG_VERSION"))?;
        writeln!(out, "{}{}", csv::FLUX_COMMENT, self.rays.flux_lm)?;
        writeln!(out, "{}", csv::HEADER)?;
        for sample in self.samples() {
            let [x, y, z] = sample.position.map(Shortest);
            let [dx, dy, dz] = sample.direction.map(Shortest);
            writeln!(out, "{x},{y},{z},{dx},{dy},{dz},{}", Shortest(sample.flux))?;
        }
        Ok(())
    }

    fn write_tm25(&self, out: &mut impl Write, spectrum: &Spectrum) -> io::Result<()> {
        out.write_all(&tm25_header(self.rays, spectrum))?;
        for sample in self.samples() {
            let mut record = [0; 28];
            let values = sample.position.into_iter().chain(sample.direction).chain([sample.flux]);
            for (bytes, value) in record.chunks_exact_mut(4).zip(values) {
                bytes.copy_from_slice(&value.to_le_bytes());
            }
            out.write_all(&record)?;
        }
        Ok(())
    }
}

/// The fewest digits that read back as the same f32.
struct Shortest(f32);

impl std::fmt::Display for Shortest {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // Without an exponent, 1e-30 would take 30 zeros.
        match self.0.abs() {
            0.0 | 1e-4..1e7 => write!(f, "{}", self.0),
            _ => write!(f, "{:e}", self.0),
        }
    }
}

/// Up to the rays: position, direction and luminous flux, and one spectral table.
fn tm25_header(rays: &RaySet, spectrum: &Spectrum) -> Vec<u8> {
    const UNKNOWN: f32 = f32::NAN;
    const TABLE_FOR_ALL: i32 = 3;
    let rows = table_rows(spectrum);
    let mut header = vec![0; tm25::HEADER_BYTES];
    let mut put = |at: usize, bytes: &[u8]| header[at..at + bytes.len()].copy_from_slice(bytes);
    put(0, tm25::MAGIC);
    put(offset::VERSION, &tm25::VERSION.to_le_bytes());
    put(offset::LUMINOUS_FLUX, &(rays.flux_lm as f32).to_le_bytes());
    put(offset::RADIANT_FLUX, &UNKNOWN.to_le_bytes());
    put(offset::RAYS, &(rays.samples.len() as u64).to_le_bytes());
    put(offset::SPECTRAL_ID, &TABLE_FOR_ALL.to_le_bytes());
    put(offset::WAVELENGTHS, &UNKNOWN.to_le_bytes());
    let (first, last) = (rows.first(), rows.last());
    put(offset::WAVELENGTHS + 4, &first.map_or(UNKNOWN, |row| row[0]).to_le_bytes());
    put(offset::WAVELENGTHS + 8, &last.map_or(UNKNOWN, |row| row[0]).to_le_bytes());
    put(offset::TABLES, &1i32.to_le_bytes());
    for flag in [0, 1, 4] {
        put(offset::FLAGS + 4 * flag, &1i32.to_le_bytes());
    }
    let creator = format!("Lampyris {}", env!("CARGO_PKG_VERSION"));
    let creator: Vec<u8> = creator.chars().flat_map(|c| u32::from(c).to_le_bytes()).collect();
    put(offset::DESCRIPTIONS + tm25::FILE_CREATOR * tm25::DESCRIPTION_BYTES, &creator);

    header.extend((rows.len() as i32).to_le_bytes());
    header.extend(rows.iter().flatten().flat_map(|value| value.to_le_bytes()));
    let end =
        (header.len() - tm25::HEADER_BYTES).next_multiple_of(tm25::TABLE_BLOCK_BYTES as usize);
    header.resize(tm25::HEADER_BYTES + end, 0);
    header
}

/// Wavelength and weight; a constant as two rows, since one would be a line.
fn table_rows(spectrum: &Spectrum) -> Vec<[f32; 2]> {
    let row = |nm: f64| [nm as f32, spectrum.at(nm).max(0.0) as f32];
    if spectrum.wavelengths_nm().len() == 1 {
        return [WavelengthGrid::FIRST_NM, WavelengthGrid::LAST_NM].map(row).to_vec();
    }
    let mut rows: Vec<_> = spectrum.wavelengths_nm().iter().map(|&nm| row(nm)).collect();
    // Wavelengths that f32 cannot tell apart would not ascend.
    rows.dedup_by_key(|row| row[0]);
    rows
}
