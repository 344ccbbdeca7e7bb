//! Ray files: one file a format, told apart by content, one common result.
//!
//! Layouts after IES TM-25-13, the help of the programs that write the files, and files of LED
//! makers. What a file does not say is not guessed: see [`RayFile::into_light`].

mod asap;
mod binary;
mod csv;
mod input;
mod lighttools;
mod lines;
mod record;
mod save;
mod spectral;
mod speos;
mod text;
mod tm25;
mod zemax;

use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

pub use self::save::{SaveFormat, writer};

use self::input::Input;
use self::spectral::{SpectralTable, Tally, luminous_efficacy};
use crate::columns;
use crate::error::{self, Error, Place, Result};
use crate::light::{RaySample, RaySet};
use crate::spectrum::Spectrum;

/// Kinds of ray files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// ASAP, binary.
    Asap,
    /// Text with a first line that names its columns.
    Csv,
    /// LightTools, text.
    LightToolsAscii,
    /// LightTools, binary.
    LightToolsBinary,
    /// Text without names of its columns.
    Columns,
    /// Speos, binary.
    Speos,
    /// IES TM-25.
    Tm25,
    /// Zemax, binary.
    ZemaxBinary,
    /// Zemax, text.
    ZemaxText,
}

impl std::fmt::Display for Format {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Asap => "ASAP",
            Self::Csv => "CSV",
            Self::LightToolsAscii => "LightTools ASCII",
            Self::LightToolsBinary => "LightTools binary",
            Self::Columns => "text of columns",
            Self::Speos => "Speos",
            Self::Tm25 => "IES TM-25",
            Self::ZemaxBinary => "Zemax binary",
            Self::ZemaxText => "Zemax text",
        })
    }
}

/// What a file's flux is in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FluxUnit {
    /// Luminous flux.
    Lumen,
    /// Radiant flux.
    Watt,
    /// The format has no word for it; taken as lm, with a warning.
    Unstated,
}

impl std::fmt::Display for FluxUnit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Lumen => "lm",
            Self::Watt => "W",
            Self::Unstated => "(unit not stated)",
        })
    }
}

/// What a file says about the spectrum.
#[derive(Debug, Clone, PartialEq)]
pub enum SpectrumSource {
    /// Nothing.
    None,
    /// One wavelength for all rays, nm.
    Line {
        /// Wavelength, nm.
        nm: f64,
    },
    /// A wavelength a ray, nm: their mean, weighted by radiant flux, stands for all.
    PerRay {
        /// Least wavelength of a ray, nm.
        min_nm: f64,
        /// Largest wavelength of a ray, nm.
        max_nm: f64,
    },
    /// One table for all rays.
    Table,
    /// A table a ray: their mean, weighted by radiant flux, stands for all.
    Mixture {
        /// How many tables.
        tables: usize,
    },
}

/// What silently changes the picture, or should be known.
#[derive(Debug, Clone, PartialEq)]
pub enum Warning {
    /// The sum of the rays was rescaled to the header's flux.
    HeaderFlux {
        /// What the header says, in `unit`.
        header: f64,
        /// Sum of the rays' flux, in `unit`.
        sum: f64,
        /// What both are in.
        unit: FluxUnit,
    },
    /// The file does not say what its flux is in; taken as lm.
    UnstatedUnit,
    /// The file does not say what its lengths are in; taken as mm.
    UnstatedLengthUnit,
    /// The header's origin in the model that wrote the file; start points stay as they are.
    OriginNotApplied {
        /// As the header has it, in the file's unit.
        origin: [f64; 3],
    },
    /// Rays outside of 380 to 780 nm, which make no light.
    InvisibleRays {
        /// How many.
        rays: u64,
    },
    /// Records without a direction, with a negative flux or the like were left out.
    RaysDropped {
        /// How many.
        rays: u64,
        /// What is wrong with the first one.
        flaw: String,
    },
    /// Directions brought to unit length.
    DirectionsNormalized {
        /// How many.
        rays: u64,
        /// Largest difference of a length from 1.
        largest_error: f64,
    },
    /// A version of the format that was not seen yet, read like the known one.
    UnknownVersion {
        /// As the header has it.
        found: String,
    },
}

impl std::fmt::Display for Warning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            // Digits beyond f32 are rounding of the sum.
            Self::HeaderFlux { header, sum, unit } => write!(
                f,
                "the header says {} {unit}, the rays sum to {} {unit}: rescaled to the header",
                *header as f32, *sum as f32
            ),
            Self::UnstatedUnit => f.write_str(
                "the file does not say what its flux is in: taken as lm, or give \"flux\"",
            ),
            Self::UnstatedLengthUnit => {
                f.write_str("the file does not say what its lengths are in: taken as mm")
            }
            Self::OriginNotApplied { origin: [x, y, z] } => {
                write!(f, "the header's origin ({x}, {y}, {z}) is not added to the start points")
            }
            Self::InvisibleRays { rays } => {
                write!(f, "{rays} rays have wavelengths outside of 380 to 780 nm and make no light")
            }
            Self::RaysDropped { rays, flaw } => {
                write!(f, "{rays} rays are left out as they are no rays, the first one: {flaw}")
            }
            Self::DirectionsNormalized { rays, largest_error } => write!(
                f,
                "{rays} directions were not unit, the worst off by {:.2} %: normalized",
                100.0 * largest_error
            ),
            Self::UnknownVersion { found } => {
                write!(f, "version {found} of the format is not known, read like the known one")
            }
        }
    }
}

/// A ray file's content.
#[derive(Debug, Clone)]
pub struct RayFile {
    /// The file.
    pub path: PathBuf,
    /// What it was taken for.
    pub format: Format,
    /// In the file's order; flux relative, or in lm where wavelengths or tables made it so.
    pub samples: Arc<[RaySample]>,
    /// What the rays' flux is in.
    pub flux_unit: FluxUnit,
    /// The header's total in `flux_unit`, where it states one.
    pub header_flux: Option<f64>,
    /// Σ of the rays' flux as stored, in `flux_unit`.
    pub flux_sum: f64,
    /// Luminous flux of the set, lm; `None` for watts without a spectrum.
    pub flux_lm: Option<f64>,
    /// Where `spectrum` is from.
    pub spectrum_source: SpectrumSource,
    /// Relative; `None` if the file has none.
    pub spectrum: Option<Spectrum>,
    /// Name and text of the header's descriptions that are not empty.
    pub description: Vec<(String, String)>,
    /// What a user should know.
    pub warnings: Vec<Warning>,
}

/// The format is told by the content.
///
/// Errors: [`Error::Io`], and [`Error::BadFile`] with the line or record.
pub fn read(path: &Path) -> Result<RayFile> {
    let mut file = crate::input::open(path)?;
    let metadata = file.metadata().map_err(|e| Error::io(path, e))?;
    read_from(path, &mut file, metadata.len())
}

/// Reads `bytes` bytes; `path` only names them in messages.
pub fn read_from(path: &Path, reader: &mut dyn Read, bytes: u64) -> Result<RayFile> {
    let mut input = Input::new(path, reader, bytes)?;
    if let Some(hint) = columns::hint_of_content(input.head()) {
        return Err(input.bad(hint));
    }
    if matches!(input.head(), [0xff, 0xfe, ..] | [0xfe, 0xff, ..]) {
        return read_utf16(path, input.take(bytes, "the text")?);
    }
    let parsed = match format_of(input.head(), bytes) {
        Some(Format::Asap) => asap::read(&mut input)?,
        Some(Format::Csv) => csv::read(&mut input)?,
        Some(Format::LightToolsAscii) => lighttools::read_ascii(&mut input)?,
        Some(Format::LightToolsBinary) => lighttools::read_binary(&mut input)?,
        Some(Format::Columns) => text::read(&mut input)?,
        Some(Format::Speos) => speos::read(&mut input)?,
        Some(Format::Tm25) => tm25::read(&mut input)?,
        Some(Format::ZemaxBinary) => zemax::read_binary(&mut input)?,
        Some(Format::ZemaxText) => zemax::read_text(&mut input)?,
        None => {
            return Err(input.bad(
                "not a ray file of a known format (IES TM-25, Zemax, LightTools, ASAP, Speos, CSV, \
                 or rows of seven or eight numbers)",
            ));
        }
    };
    parsed.finish(path, &input)
}

/// The text again as UTF-8.
fn read_utf16(path: &Path, bytes: Vec<u8>) -> Result<RayFile> {
    let text = columns::text_of(path, bytes)?;
    read_from(path, &mut text.as_bytes(), text.len() as u64)
}

/// The format that the first bytes of a file of `bytes` bytes tell.
fn format_of(head: &[u8], bytes: u64) -> Option<Format> {
    if head.starts_with(tm25::MAGIC) {
        return Some(Format::Tm25);
    }
    if head.starts_with(lighttools::MAGIC) {
        return Some(Format::LightToolsBinary);
    }
    if zemax::is_binary(head) {
        return Some(Format::ZemaxBinary);
    }
    if asap::byte_order(head).is_some() {
        return Some(Format::Asap);
    }
    if speos::is_speos(head, bytes) {
        return Some(Format::Speos);
    }
    text_format_of(head)
}

fn text_format_of(head: &[u8]) -> Option<Format> {
    let head = lines::without_bom(head);
    if lighttools::is_ascii(head) {
        return Some(Format::LightToolsAscii);
    }
    let mut content = head.split(|&b| b == b'\n').map(<[u8]>::trim_ascii);
    let first = content.find(|line| !lines::is_skipped(line))?;
    if csv::is_header(first) {
        Some(Format::Csv)
    } else if zemax::is_text(first) {
        Some(Format::ZemaxText)
    } else {
        text::is_rays(head).then_some(Format::Columns)
    }
}

/// `None` where a header leaves its flux or wavelength open: 0, NaN, or NaN with its bytes swapped,
/// as one LED maker writes it.
fn known(value: f32) -> Option<f64> {
    let swapped = f32::from_bits(value.to_bits().swap_bytes());
    (value > 0.0 && value.is_finite() && !swapped.is_nan()).then_some(f64::from(value))
}

/// What a block of rays yields.
struct Rays {
    samples: Arc<[RaySample]>,
    tally: Tally,
}

/// A reader's finding about the spectrum.
enum FileSpectrum {
    None,
    Line { table: SpectralTable, nm: f64 },
    PerRay,
    Table { table: SpectralTable },
    Mixture { tables: usize },
}

/// What a reader finds, before what is common to all formats is worked out.
struct Parsed {
    format: Format,
    rays: Rays,
    unit: FluxUnit,
    header_flux: Option<f64>,
    /// Luminous flux that the header states beside one in another unit.
    header_lm: Option<f64>,
    spectrum: FileSpectrum,
    description: Vec<(String, String)>,
    warnings: Vec<Warning>,
}

/// Header and sum that agree to this were the same number before a maker rounded it.
const FLUX_TOLERANCE: f64 = 1e-3;

/// Directions of files with three decimals are off by this much.
const DIRECTION_WARNING: f64 = 1e-3;

impl Parsed {
    fn new(format: Format, rays: Rays, unit: FluxUnit) -> Self {
        Self {
            format,
            rays,
            unit,
            header_flux: None,
            header_lm: None,
            spectrum: FileSpectrum::None,
            description: Vec::new(),
            warnings: Vec::new(),
        }
    }

    fn describe(&mut self, name: &str, text: String) {
        if !text.is_empty() {
            self.description.push((name.to_owned(), text));
        }
    }

    fn finish(mut self, path: &Path, input: &Input) -> Result<RayFile> {
        let tally = &self.rays.tally;
        if self.rays.samples.is_empty() {
            return Err(input.bad("the file holds no rays"));
        }
        if tally.flux == 0.0 {
            return Err(input.bad("no ray carries flux"));
        }
        self.warn();
        let flux_lm = self.flux_lm();
        if flux_lm == Some(0.0) {
            return Err(input.bad("the rays make no light between 380 and 780 nm"));
        }
        let tally = &self.rays.tally;
        let (spectrum_source, spectrum) = match self.spectrum {
            FileSpectrum::None => (SpectrumSource::None, None),
            FileSpectrum::Line { table, nm } => (SpectrumSource::Line { nm }, Some(table.spectrum)),
            FileSpectrum::Table { table } => (SpectrumSource::Table, Some(table.spectrum)),
            FileSpectrum::PerRay => {
                let (min_nm, max_nm) = tally.wavelengths_nm.unwrap_or_default();
                (SpectrumSource::PerRay { min_nm, max_nm }, tally.mean_spectrum())
            }
            FileSpectrum::Mixture { tables } => {
                (SpectrumSource::Mixture { tables }, tally.mean_spectrum())
            }
        };
        Ok(RayFile {
            path: path.to_owned(),
            format: self.format,
            flux_unit: self.unit,
            header_flux: self.header_flux,
            flux_sum: tally.flux,
            flux_lm,
            spectrum_source,
            spectrum,
            description: self.description,
            warnings: self.warnings,
            samples: self.rays.samples,
        })
    }

    fn warn(&mut self) {
        let tally = &self.rays.tally;
        if let Some(header) = self.header_flux
            && (header / tally.flux - 1.0).abs() > FLUX_TOLERANCE
        {
            let (sum, unit) = (tally.flux, self.unit);
            self.warnings.push(Warning::HeaderFlux { header, sum, unit });
        }
        if self.unit == FluxUnit::Unstated {
            self.warnings.push(Warning::UnstatedUnit);
        }
        if let Some((_, flaw)) = tally.first_dropped {
            let (rays, flaw) = (tally.dropped, flaw.to_string());
            self.warnings.push(Warning::RaysDropped { rays, flaw });
        }
        if tally.invisible > 0 {
            self.warnings.push(Warning::InvisibleRays { rays: tally.invisible });
        }
        if tally.largest_direction_error > DIRECTION_WARNING {
            let (rays, largest_error) = (tally.off_unit, tally.largest_direction_error);
            self.warnings.push(Warning::DirectionsNormalized { rays, largest_error });
        }
    }

    /// The header's word counts before the sum of the rays.
    fn flux_lm(&self) -> Option<f64> {
        let tally = &self.rays.tally;
        let stated = self.header_flux.unwrap_or(tally.flux);
        if self.unit != FluxUnit::Watt {
            return Some(stated);
        }
        self.header_lm.or(match &self.spectrum {
            FileSpectrum::None => None,
            FileSpectrum::Line { table, .. } | FileSpectrum::Table { table } => {
                Some(stated * table.lm_per_w)
            }
            FileSpectrum::PerRay | FileSpectrum::Mixture { .. } => {
                Some(tally.sample_flux * (stated / tally.flux))
            }
        })
    }
}

/// What a script may say beside a file.
#[derive(Debug, Clone, Default)]
pub struct LightOptions {
    /// I_norm(λ), relative; instead of the file's own.
    pub spectrum: Option<Spectrum>,
    /// Total, lm; instead of the file's own.
    pub flux_lm: Option<f64>,
}

impl RayFile {
    /// The light source of eq. 9 to 12, and its I_norm(λ).
    ///
    /// Radiant flux becomes luminous through the file's spectrum or, where it has none, the given
    /// one.
    ///
    /// Errors: no spectrum anywhere.
    pub fn into_light(self, options: LightOptions) -> Result<(RaySet, Spectrum)> {
        let own_flux_lm = self.flux_lm;
        let Some(spectrum) = options.spectrum.or(self.spectrum) else {
            let problem = "the file has no spectrum, give \"spectrum\"";
            return Err(Error::bad_file(&self.path, Place::File, problem));
        };
        let watts = self.header_flux.unwrap_or(self.flux_sum);
        let from_watts = || luminous_efficacy(&spectrum).map(|lm_per_w| watts * lm_per_w);
        let flux_lm = options.flux_lm.or(own_flux_lm).or_else(from_watts).unwrap_or_default();
        if flux_lm > error::LARGEST {
            let problem = format!("the flux is {flux_lm:e} lm, allowed: {}", error::NUMBERS);
            return Err(Error::bad_file(&self.path, Place::File, problem));
        }
        if !(flux_lm > 0.0 && flux_lm.is_finite()) {
            let problem = "the spectrum makes no light between 380 and 780 nm";
            return Err(Error::bad_file(&self.path, Place::File, problem));
        }
        Ok((RaySet::new(self.samples, flux_lm), spectrum))
    }
}
