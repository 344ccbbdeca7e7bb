//! From wavelengths and tables of single rays to the one spectrum of a set (eq. 11–12).
//!
//! Deviation: eq. 12 gives a set one I_norm(λ). Files whose rays carry wavelengths or tables of
//! their own (TM-25 identifiers 2 and 4, Zemax .SDF, LightTools with wavelengths) keep each ray's
//! lumens, and get as I_norm the mean of the rays' spectra, weighted by radiant flux. Color that
//! varies with direction is lost.

use std::sync::Arc;

use super::FluxUnit;
use super::record::{Flaw, Layout, RayRecord};
use crate::light::RaySample;
use crate::spectrum::{Spectrum, WavelengthGrid, cie};

const GRID: WavelengthGrid = WavelengthGrid::Step5;

/// Radiant power at the bands of [`GRID`], W, any scale.
pub(super) type BandPowers = [f64; WavelengthGrid::MAX_BANDS];

/// What a record says about its own spectrum.
#[derive(Debug, Clone)]
pub(super) enum Tag {
    None,
    Wavelength { column: usize, nm_per_unit: f64 },
    Table { column: usize, tables: Arc<[SpectralTable]> },
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum TagFault {
    Wavelength(f64),
    Table { found: f32, tables: usize },
}

impl std::fmt::Display for TagFault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Wavelength(nm) => write!(f, "wavelength is {nm} nm, allowed: finite and above 0"),
            Self::Table { found, tables } => write!(
                f,
                "spectrum index has the bits {:#010x}, allowed: 1 to {tables}",
                found.to_bits()
            ),
        }
    }
}

impl Tag {
    pub fn column(&self) -> Option<usize> {
        match self {
            Self::None => None,
            Self::Wavelength { column, .. } | Self::Table { column, .. } => Some(*column),
        }
    }
}

/// A spectral table of a file, for 1 W.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SpectralTable {
    pub spectrum: Spectrum,
    pub lm_per_w: f64,
    bands: BandPowers,
}

impl SpectralTable {
    /// Errors: `None` if the table carries no power.
    pub fn new(spectrum: Spectrum) -> Option<Self> {
        if let ([lambda_nm], [weight]) = (spectrum.wavelengths_nm(), spectrum.values()) {
            return (*weight > 0.0).then(|| Self::line(*lambda_nm));
        }
        let power = integral(&spectrum, |_| 1.0);
        if !(power > 0.0 && power.is_finite()) {
            return None;
        }
        let mut bands = [0.0; WavelengthGrid::MAX_BANDS];
        let (first, last) = range_nm(&spectrum);
        for (band, lambda_nm) in bands.iter_mut().zip(GRID.wavelengths_nm()) {
            if (first..=last).contains(&lambda_nm) {
                *band = spectrum.at(lambda_nm) / power * GRID.step_nm();
            }
        }
        Some(Self { lm_per_w: luminous_efficacy(&spectrum)?, spectrum, bands })
    }

    /// All power at one wavelength.
    pub fn line(lambda_nm: f64) -> Self {
        let mut bands = [0.0; WavelengthGrid::MAX_BANDS];
        add_line(&mut bands, lambda_nm, 1.0);
        let lm_per_w = cie::K_LM_PER_W * cie::v_lambda(lambda_nm);
        Self { spectrum: from_bands(&bands), lm_per_w, bands }
    }
}

/// Lumens that 1 W spread like `spectrum` makes, or `None` without power.
///
/// The power lies within the table's wavelengths, or within 380 to 780 nm if it is a constant.
/// Trapezoids over the rows and the 5 nm bands.
pub(super) fn luminous_efficacy(spectrum: &Spectrum) -> Option<f64> {
    let power = integral(spectrum, |_| 1.0);
    let luminous = cie::K_LM_PER_W * integral(spectrum, cie::v_lambda);
    (power > 0.0 && luminous.is_finite()).then(|| luminous / power)
}

fn range_nm(spectrum: &Spectrum) -> (f64, f64) {
    match spectrum.wavelengths_nm() {
        [first, .., last] => (*first, *last),
        _ => (WavelengthGrid::FIRST_NM, WavelengthGrid::LAST_NM),
    }
}

/// ∫ S w dλ over the table's range. Both are linear between the table's rows and the 5 nm bands, so
/// that Simpson's rule is exact.
fn integral(spectrum: &Spectrum, weight: impl Fn(f64) -> f64) -> f64 {
    let (first, last) = range_nm(spectrum);
    let rows = spectrum.wavelengths_nm().iter().copied();
    let mut nodes: Vec<f64> = rows.chain(GRID.wavelengths_nm()).collect();
    nodes.retain(|nm| (first..=last).contains(nm));
    nodes.sort_by(f64::total_cmp);
    let value = |nm: f64| spectrum.at(nm) * weight(nm);
    let cell = |a: f64, b: f64| (b - a) / 6.0 * (value(a) + 4.0 * value(0.5 * (a + b)) + value(b));
    nodes.windows(2).map(|nm| cell(nm[0], nm[1])).sum()
}

/// Shares a power between the two nearest bands, so that its mean wavelength and its lumens by the
/// table of V(λ), linear between bands, are kept. Returns false outside of 380 to 780 nm.
fn add_line(bands: &mut BandPowers, lambda_nm: f64, power: f64) -> bool {
    let place = (lambda_nm - WavelengthGrid::FIRST_NM) / GRID.step_nm();
    if !(0.0..=(GRID.bands() - 1) as f64).contains(&place) {
        return false;
    }
    let band = (place as usize).min(GRID.bands() - 2);
    let t = place - band as f64;
    bands[band] += power * (1.0 - t);
    bands[band + 1] += power * t;
    true
}

/// Power a band becomes power a nm.
fn from_bands(bands: &BandPowers) -> Spectrum {
    let rows = GRID.wavelengths_nm().zip(bands.iter().map(|power| power / GRID.step_nm()));
    Spectrum::from_pairs("bands", rows).unwrap_or_else(|_| Spectrum::constant(0.0))
}

/// What reading a run of records sums up. Runs have a fixed length and are merged in the file's
/// order, so that the sums do not depend on the number of threads.
#[derive(Debug, Clone)]
pub(super) struct Tally {
    pub rays: u64,
    /// Σ of the stored flux, in the file's unit.
    pub flux: f64,
    /// Σ of the samples' flux.
    pub sample_flux: f64,
    pub bands: BandPowers,
    pub wavelengths_nm: Option<(f64, f64)>,
    /// Rays with a wavelength outside of 380 to 780 nm.
    pub invisible: u64,
    pub off_unit: u64,
    pub largest_direction_error: f64,
    /// Records that are left out.
    pub dropped: u64,
    /// Where the first of them is, by record or line from 0, and why.
    pub first_dropped: Option<(u64, Flaw)>,
}

impl Default for Tally {
    fn default() -> Self {
        Self {
            rays: 0,
            flux: 0.0,
            sample_flux: 0.0,
            bands: [0.0; WavelengthGrid::MAX_BANDS],
            wavelengths_nm: None,
            invisible: 0,
            off_unit: 0,
            largest_direction_error: 0.0,
            dropped: 0,
            first_dropped: None,
        }
    }
}

impl Tally {
    /// Counts a record in and returns its sample, in lm if its spectrum allows.
    #[inline]
    pub fn add(
        &mut self,
        layout: &Layout,
        unit: FluxUnit,
        record: RayRecord,
    ) -> Result<RaySample, Flaw> {
        let mut sample = record.sample;
        match &layout.tag {
            Tag::None => {}
            Tag::Wavelength { nm_per_unit, .. } => {
                let lambda_nm = wavelength(record.tag, *nm_per_unit).map_err(Flaw::Tag)?;
                let lm_per_w = cie::K_LM_PER_W * cie::v_lambda(lambda_nm);
                let watts = self.weigh(&mut sample, &record, unit, lm_per_w);
                self.add_wavelength(lambda_nm, watts);
            }
            Tag::Table { tables, .. } => {
                let table = table_of(record.tag, tables).map_err(Flaw::Tag)?;
                let watts = self.weigh(&mut sample, &record, unit, table.lm_per_w);
                for (sum, band) in self.bands.iter_mut().zip(&table.bands) {
                    *sum += watts * band;
                }
            }
        }
        self.count(&record, sample);
        Ok(sample)
    }

    /// Counts in a record without a spectrum of its own.
    #[inline(always)]
    pub fn add_untagged(&mut self, record: &RayRecord) -> RaySample {
        self.count(record, record.sample);
        record.sample
    }

    #[inline(always)]
    fn count(&mut self, record: &RayRecord, sample: RaySample) {
        self.rays += 1;
        self.flux += f64::from(record.sample.flux);
        self.sample_flux += f64::from(sample.flux);
        if record.direction_error > 0.0 {
            self.off_unit += 1;
            self.largest_direction_error = self.largest_direction_error.max(record.direction_error);
        }
    }

    /// The ray's watts; turns the sample's flux into lumens if the file's are watts.
    fn weigh(
        &self,
        sample: &mut RaySample,
        record: &RayRecord,
        unit: FluxUnit,
        lm_per_w: f64,
    ) -> f64 {
        let stored = f64::from(sample.flux);
        if unit == FluxUnit::Watt {
            sample.flux = (stored * lm_per_w) as f32;
            return stored;
        }
        match record.radiant {
            Some(watts) => f64::from(watts),
            None if lm_per_w > 0.0 => stored / lm_per_w,
            None => 0.0,
        }
    }

    fn add_wavelength(&mut self, lambda_nm: f64, watts: f64) {
        let (min, max) = self.wavelengths_nm.unwrap_or((lambda_nm, lambda_nm));
        self.wavelengths_nm = Some((min.min(lambda_nm), max.max(lambda_nm)));
        if !add_line(&mut self.bands, lambda_nm, watts) {
            self.invisible += 1;
        }
    }

    /// Leaves out the record at `place`.
    #[cold]
    pub fn drop(&mut self, place: u64, flaw: Flaw) {
        self.dropped += 1;
        self.first_dropped = self.first_dropped.or(Some((place, flaw)));
    }

    /// Adds a run that starts at `place`.
    pub fn merge(&mut self, place: u64, next: &Self) {
        let first = next.first_dropped.map(|(at, flaw)| (place + at, flaw));
        self.first_dropped = self.first_dropped.or(first);
        self.dropped += next.dropped;
        self.rays += next.rays;
        self.flux += next.flux;
        self.sample_flux += next.sample_flux;
        for (sum, band) in self.bands.iter_mut().zip(&next.bands) {
            *sum += band;
        }
        self.wavelengths_nm = match (self.wavelengths_nm, next.wavelengths_nm) {
            (Some((a, b)), Some((c, d))) => Some((a.min(c), b.max(d))),
            (one, other) => one.or(other),
        };
        self.invisible += next.invisible;
        self.off_unit += next.off_unit;
        self.largest_direction_error =
            self.largest_direction_error.max(next.largest_direction_error);
    }

    /// The rays' mean spectrum, or `None` if no ray has power in 380 to 780 nm.
    pub fn mean_spectrum(&self) -> Option<Spectrum> {
        let total: f64 = self.bands.iter().sum();
        (total > 0.0).then(|| from_bands(&self.bands.map(|band| band / total)))
    }
}

fn wavelength(stored: f32, nm_per_unit: f64) -> Result<f64, TagFault> {
    let lambda_nm = f64::from(stored) * nm_per_unit;
    if lambda_nm.is_finite() && lambda_nm > 0.0 {
        Ok(lambda_nm)
    } else {
        Err(TagFault::Wavelength(lambda_nm))
    }
}

/// The 1-based index is an i32 by the standard and an f32 in files of the reference program. The
/// bits tell which: as an f32, an i32 up to the number of tables is a denormal number.
fn table_of(word: f32, tables: &[SpectralTable]) -> Result<&SpectralTable, TagFault> {
    let fault = TagFault::Table { found: word, tables: tables.len() };
    let bits = word.to_bits() as usize;
    let index = if (1..=tables.len()).contains(&bits) { bits } else { word as usize };
    if index != bits && index as f32 != word {
        return Err(fault);
    }
    index.checked_sub(1).and_then(|i| tables.get(i)).ok_or(fault)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle() -> Spectrum {
        Spectrum::from_pairs("t", [(500.0, 0.0), (550.0, 2.0), (600.0, 0.0)]).unwrap()
    }

    #[test]
    fn efficacy_of_a_line_is_683_v() {
        let line = SpectralTable::line(555.0);
        assert!((line.lm_per_w - 683.0).abs() < 1e-9);
        assert_eq!(SpectralTable::line(900.0).lm_per_w, 0.0);
    }

    /// ∫ S V of a triangle by a 0.01 nm midpoint sum.
    #[test]
    fn efficacy_of_a_table_is_its_integral() {
        let s = triangle();
        let (mut luminous, mut power) = (0.0, 0.0);
        for i in 0..10_000 {
            let nm = 500.005 + 0.01 * f64::from(i);
            luminous += 683.0 * s.at(nm) * cie::v_lambda(nm) * 0.01;
            power += s.at(nm) * 0.01;
        }
        let expected = luminous / power;
        // The midpoint sum errs by 1e-4 nm² of curvature, which sits in the kinks at the bands.
        assert!((luminous_efficacy(&s).unwrap() / expected - 1.0).abs() < 1e-7);
        assert!((SpectralTable::new(s).unwrap().lm_per_w / expected - 1.0).abs() < 1e-7);
    }

    #[test]
    fn a_constant_spectrum_spreads_over_the_visible() {
        let sum: f64 = GRID.wavelengths_nm().map(cie::v_lambda).sum();
        let expected = 683.0 * sum * 5.0 / 400.0;
        let found = luminous_efficacy(&Spectrum::constant(0.3)).unwrap();
        // V is below 4e-5 at both ends, where sum and trapezoid differ.
        assert!((found / expected - 1.0).abs() < 1e-5, "{found} {expected}");
    }

    #[test]
    fn a_table_without_power_is_none() {
        let dark = Spectrum::from_pairs("t", [(500.0, 0.0), (550.0, 0.0)]).unwrap();
        assert_eq!(SpectralTable::new(dark), None);
    }

    #[test]
    fn lines_keep_their_lumens_and_mean_wavelength() {
        for lambda_nm in [380.0, 383.7, 555.0, 612.3, 777.5, 780.0] {
            let line = SpectralTable::line(lambda_nm);
            let lumens = line.spectrum.luminous_flux(GRID);
            assert!((lumens - line.lm_per_w).abs() <= 1e-9 * line.lm_per_w.max(1e-3));
            let mean: f64 = GRID.wavelengths_nm().zip(line.bands).map(|(l, w)| l * w).sum();
            assert!((mean - lambda_nm).abs() < 1e-9);
        }
    }

    #[test]
    fn table_index_as_integer_or_float() {
        let tables = [SpectralTable::line(450.0), SpectralTable::line(600.0)];
        assert_eq!(table_of(2.0, &tables), Ok(&tables[1]));
        assert_eq!(table_of(f32::from_bits(1), &tables), Ok(&tables[0]));
        for bad in [0.0, 3.0, 1.5, -1.0, f32::NAN, f32::INFINITY, f32::from_bits(3)] {
            assert!(table_of(bad, &tables).is_err(), "{bad}");
        }
    }
}
