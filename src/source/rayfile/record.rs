//! One ray as a row of numbers, checked, whatever the file's encoding.

use super::input::Input;
use super::spectral::{Tag, TagFault, Tally};
use crate::error::{Error, Place};
use crate::light::RaySample;

/// Where a format keeps what; columns are 0-based and one f32 wide.
#[derive(Debug, Clone)]
pub(super) struct Layout {
    pub columns: usize,
    /// First of x, y, z; none in far-field files, whose rays start at the origin.
    pub position: Option<usize>,
    /// First of the direction cosines.
    pub direction: usize,
    pub flux: usize,
    /// Radiant flux beside a luminous one.
    pub radiant: Option<usize>,
    pub tag: Tag,
    pub mm_per_unit: f64,
}

impl Layout {
    /// x y z dx dy dz flux, mm.
    pub fn seven_columns() -> Self {
        Self {
            columns: 7,
            position: Some(0),
            direction: 3,
            flux: 6,
            radiant: None,
            tag: Tag::None,
            mm_per_unit: 1.0,
        }
    }
}

/// What makes a record unusable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Flaw {
    Position(f32),
    Direction([f32; 3]),
    Flux(f32),
    RadiantFlux(f32),
    Tag(TagFault),
}

impl Flaw {
    /// Whether a file may have a few such records: rows of zeros that fill it up, a flux that a
    /// difference made negative. What is not finite tells of a broken file.
    pub fn is_stray(self) -> bool {
        match self {
            Self::Position(_) => false,
            Self::Direction(direction) => direction.iter().all(|c| c.is_finite()),
            Self::Flux(flux) | Self::RadiantFlux(flux) => flux.is_finite(),
            Self::Tag(TagFault::Wavelength(nm)) => nm.is_finite(),
            Self::Tag(TagFault::Table { .. }) => false,
        }
    }
}

impl std::fmt::Display for Flaw {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Position(x) => write!(f, "start point has a coordinate {x}, allowed: finite mm"),
            Self::Direction([x, y, z]) => {
                write!(f, "direction is ({x}, {y}, {z}), allowed: unit length within 1 %")
            }
            Self::Flux(flux) => write!(f, "flux is {flux}, allowed: finite and not negative"),
            Self::RadiantFlux(flux) => {
                write!(f, "radiant flux is {flux}, allowed: finite and not negative")
            }
            Self::Tag(fault) => fault.fmt(f),
        }
    }
}

/// The largest share of stray records.
const STRAY_SHARE: f64 = 1e-3;

/// Refuses a file more than 0.1 % of whose records are stray, at the first of them.
pub(super) fn check_stray(
    input: &Input,
    tally: &Tally,
    place: fn(u64) -> Place,
) -> Result<(), Error> {
    let most = STRAY_SHARE * (tally.rays + tally.dropped) as f64;
    match tally.first_dropped {
        Some((at, flaw)) if tally.dropped as f64 > most => {
            Err(input.bad_at(place(at + 1), flaw.to_string()))
        }
        _ => Ok(()),
    }
}

/// A ray as the file has it, in mm and with a unit direction.
#[derive(Debug, Clone, Copy)]
pub(super) struct RayRecord {
    pub sample: RaySample,
    pub radiant: Option<f32>,
    /// The word at the tag's column.
    pub tag: f32,
    /// How far the stored direction was from unit length.
    pub direction_error: f64,
}

impl RayRecord {
    /// Errors: a start point or flux that is not finite, a direction far from unit.
    #[inline(always)]
    pub fn new(position: [f32; 3], direction: [f32; 3], flux: f32) -> Result<Self, Flaw> {
        if let Some(x) = position.into_iter().find(|x| !x.is_finite()) {
            return Err(Flaw::Position(x));
        }
        let (direction, direction_error) = unit(direction)?;
        if !is_flux(flux) {
            return Err(Flaw::Flux(flux));
        }
        let sample = RaySample { position, direction, flux };
        Ok(Self { sample, radiant: None, tag: 0.0, direction_error })
    }
}

impl Layout {
    /// Whether a record is x y z dx dy dz flux in mm and no more.
    pub fn is_seven_columns(&self) -> bool {
        self.columns == 7 && self.position.is_some() && self.mm_per_unit == 1.0
    }

    /// `word` yields the number in a column.
    #[inline]
    pub fn record(&self, word: impl Fn(usize) -> f32) -> Result<RayRecord, Flaw> {
        let triple = |first| [word(first), word(first + 1), word(first + 2)];
        let position = self.in_mm(self.position.map_or([0.0; 3], triple));
        let mut record = RayRecord::new(position, triple(self.direction), word(self.flux))?;
        record.radiant = self.radiant.map(&word);
        if let Some(radiant) = record.radiant.filter(|&r| !is_flux(r)) {
            return Err(Flaw::RadiantFlux(radiant));
        }
        record.tag = self.tag.column().map_or(0.0, word);
        Ok(record)
    }

    /// In mm the stored bits are kept; other units are scaled in f64 and rounded once.
    #[inline]
    fn in_mm(&self, stored: [f32; 3]) -> [f32; 3] {
        match self.mm_per_unit {
            1.0 => stored,
            scale => stored.map(|x| (f64::from(x) * scale) as f32),
        }
    }
}

#[inline]
fn is_flux(flux: f32) -> bool {
    flux.is_finite() && flux >= 0.0
}

/// A unit vector rounded to f32 has |d|² within 1.2e-7 of 1: half a unit in the last place of each
/// component, 6e-8 relative, twice. Those keep their bits.
const UNIT_SQUARED_TOLERANCE: f64 = 2e-7;

/// A length this far from 1 is no direction any more.
const DIRECTION_TOLERANCE: f64 = 0.01;

/// The direction with unit length, and how far it was from that.
#[inline]
fn unit(stored: [f32; 3]) -> Result<([f32; 3], f64), Flaw> {
    let [x, y, z] = stored.map(f64::from);
    let squared = x * x + y * y + z * z;
    if (squared - 1.0).abs() <= UNIT_SQUARED_TOLERANCE {
        return Ok((stored, 0.0));
    }
    let length = squared.sqrt();
    let error = (length - 1.0).abs();
    // NaN compares false and is refused too.
    if error <= DIRECTION_TOLERANCE {
        return Ok(([x, y, z].map(|c| (c / length) as f32), error));
    }
    Err(Flaw::Direction(stored))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(row: [f32; 7]) -> Result<RaySample, Flaw> {
        Layout::seven_columns().record(|column| row[column]).map(|record| record.sample)
    }

    #[test]
    fn directions_within_one_percent_become_unit_and_stay_so() {
        let sample = read([0.0, 0.0, 0.0, 0.0, 0.6, 0.807, 1.0]).unwrap();
        let length: f64 = sample.direction.iter().map(|&d| f64::from(d).powi(2)).sum();
        assert!((length - 1.0).abs() < UNIT_SQUARED_TOLERANCE);
        let [x, y, z] = sample.direction;
        assert_eq!(read([0.0, 0.0, 0.0, x, y, z, 1.0]).unwrap(), sample);
        assert_eq!(
            read([0.0, 0.0, 0.0, 0.0, 0.0, 1.02, 1.0]),
            Err(Flaw::Direction([0.0, 0.0, 1.02]))
        );
        assert!(read([0.0; 7]).is_err());
    }

    #[test]
    fn what_is_not_finite_or_negative_is_refused() {
        for column in 0..7 {
            for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
                let mut row = [1.0, 2.0, 3.0, 0.0, 0.0, 1.0, 1.0];
                row[column] = bad;
                assert!(read(row).is_err(), "column {column} = {bad}");
            }
        }
        assert_eq!(read([0.0, 0.0, 0.0, 0.0, 0.0, 1.0, -1.0]), Err(Flaw::Flux(-1.0)));
    }

    #[test]
    fn lengths_are_scaled_once() {
        let layout = Layout { mm_per_unit: 25.4, ..Layout::seven_columns() };
        let row = [1.0, -2.0, 1e30, 0.0, 0.0, 1.0, 1.0];
        assert_eq!(layout.record(|c| row[c]).unwrap().sample.position, [25.4, -50.8, 2.54e31]);
        let row = [1.0, 3e38, 0.0, 0.0, 0.0, 1.0, 1.0];
        assert!(matches!(layout.record(|c| row[c]), Err(Flaw::Position(_))));
    }
}
