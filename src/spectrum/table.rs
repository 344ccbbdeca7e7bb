//! A measured spectrum as a table.

use std::path::Path;

use super::cie;
use crate::columns::{self, Columns};
use crate::error::{Error, Place, Result};
use crate::spectrum::WavelengthGrid;

/// Values over wavelength: linear between the rows of the table, constant outside of them.
///
/// Unit: whatever was measured (a ratio, W/nm, or relative).
#[derive(Debug, Clone, PartialEq)]
pub struct Spectrum {
    /// Strictly ascending, finite, > 0, nm; at least one.
    lambda_nm: Vec<f64>,
    /// Finite; one a wavelength.
    values: Vec<f64>,
}

impl Spectrum {
    pub fn constant(value: f64) -> Self {
        Self { lambda_nm: vec![560.0], values: vec![value] }
    }

    /// From columns that are known to keep the promises of the fields.
    pub(super) fn from_sorted(lambda_nm: Vec<f64>, values: Vec<f64>) -> Self {
        debug_assert_eq!(fault_in_table(&lambda_nm, &values), None);
        Self { lambda_nm, values }
    }

    /// From rows of wavelength (nm) and value.
    ///
    /// Errors: no rows, a wavelength that is not above the one before, or a value that is not
    /// finite; `what` names the table in the message.
    pub fn from_pairs(what: &str, pairs: impl IntoIterator<Item = (f64, f64)>) -> Result<Self> {
        let (lambda_nm, values): (Vec<f64>, Vec<f64>) = pairs.into_iter().unzip();
        match fault_in_table(&lambda_nm, &values) {
            None => Ok(Self { lambda_nm, values }),
            Some((_, problem)) => Err(Error::inconsistent(what, problem)),
        }
    }

    /// Column `column` (1-based; the first holds wavelengths in nm) of a CSV file in which `#`
    /// starts a comment and one row of names may come first.
    ///
    /// Errors: [`Error::Io`], and [`Error::BadFile`] with the line.
    pub fn from_csv(path: &Path, column: usize) -> Result<Self> {
        let Columns { rows, lines } = columns::read(path, column)?;
        let (lambda_nm, values): (Vec<f64>, Vec<f64>) = rows.into_iter().unzip();
        match fault_in_table(&lambda_nm, &values) {
            None => Ok(Self { lambda_nm, values }),
            Some((row, problem)) => {
                let place = lines.get(row).map_or(Place::File, |&n| Place::Line(n));
                Err(Error::bad_file(path, place, problem))
            }
        }
    }

    pub fn wavelengths_nm(&self) -> &[f64] {
        &self.lambda_nm
    }

    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The value at a wavelength.
    pub fn at(&self, lambda_nm: f64) -> f64 {
        let after = self.lambda_nm.partition_point(|&l| l < lambda_nm);
        if after == 0 {
            return self.values[0];
        }
        if after == self.lambda_nm.len() {
            return self.values[after - 1];
        }
        let (l0, l1) = (self.lambda_nm[after - 1], self.lambda_nm[after]);
        let t = (lambda_nm - l0) / (l1 - l0);
        self.values[after - 1] * (1.0 - t) + self.values[after] * t
    }

    /// Sampled at the bands of `grid`.
    pub fn on_grid(&self, grid: WavelengthGrid) -> Vec<f64> {
        grid.wavelengths_nm().map(|l| self.at(l)).collect()
    }

    pub fn min(&self) -> f64 {
        self.values.iter().copied().fold(f64::INFINITY, f64::min)
    }

    pub fn max(&self) -> f64 {
        self.values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
    }

    pub fn scaled(&self, factor: f64) -> Self {
        Self {
            lambda_nm: self.lambda_nm.clone(),
            values: self.values.iter().map(|v| v * factor).collect(),
        }
    }

    /// Scaled to 1 at a wavelength; unchanged where it is 0 there.
    pub fn normalized_at(&self, lambda_nm: f64) -> Self {
        let value = self.at(lambda_nm);
        if value == 0.0 { self.clone() } else { self.scaled(value.recip()) }
    }

    pub fn sum(&self, other: &Self) -> Self {
        self.combined(other, |a, b| a + b)
    }

    /// Band-wise product, exact at the rows of both tables and at every band of the 5 nm grid.
    pub fn product(&self, other: &Self) -> Self {
        self.combined(other, |a, b| a * b)
    }

    /// `f` of the value at every wavelength of this table and at the 5 nm bands within it.
    pub fn mapped(&self, f: impl Fn(f64, f64) -> f64) -> Self {
        let lambda_nm = union_with_bands(&self.lambda_nm, &[]);
        let values = lambda_nm.iter().map(|&l| f(l, self.at(l))).collect();
        Self { lambda_nm, values }
    }

    fn combined(&self, other: &Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let lambda_nm = union_with_bands(&self.lambda_nm, &other.lambda_nm);
        let values = lambda_nm.iter().map(|&l| f(self.at(l), other.at(l))).collect();
        Self { lambda_nm, values }
    }

    /// 683 Σ S(λ) V(λ) Δλ on `grid`: lm, if the values are W/nm.
    pub fn luminous_flux(&self, grid: WavelengthGrid) -> f64 {
        cie::luminous(grid, &self.on_grid(grid))
    }
}

/// The union of two tables' wavelengths and, between the first and last of them, the 5 nm bands.
fn union_with_bands(a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut all: Vec<f64> = a.iter().chain(b).copied().collect();
    if a.len() > 1 || b.len() > 1 {
        all.extend(WavelengthGrid::Step5.wavelengths_nm());
    }
    all.sort_by(f64::total_cmp);
    all.dedup();
    all
}

/// The first row (0-based) that breaks the table's promises, and why.
fn fault_in_table(lambda_nm: &[f64], values: &[f64]) -> Option<(usize, String)> {
    if lambda_nm.is_empty() {
        return Some((0, "no rows, expected wavelength in nm and value".to_owned()));
    }
    for (row, (&l, &v)) in lambda_nm.iter().zip(values).enumerate() {
        if !(l.is_finite() && l > 0.0) {
            return Some((row, format!("wavelength is {l}, allowed: finite and above 0 nm")));
        }
        if !v.is_finite() {
            return Some((row, format!("value at {l} nm is {v}, allowed: finite numbers")));
        }
        if row > 0 && l <= lambda_nm[row - 1] {
            let before = lambda_nm[row - 1];
            return Some((row, format!("wavelength {l} nm follows {before} nm, must ascend")));
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp() -> Spectrum {
        Spectrum::from_pairs("s", [(400.0, 1.0), (500.0, 3.0)]).unwrap()
    }

    #[test]
    fn linear_inside_constant_outside() {
        assert_eq!(ramp().at(450.0), 2.0);
        assert_eq!(ramp().at(380.0), 1.0);
        assert_eq!(ramp().at(780.0), 3.0);
        assert_eq!(Spectrum::constant(0.4).at(700.0), 0.4);
    }

    #[test]
    fn product_is_exact_at_every_band() {
        let product = ramp().product(&ramp());
        for lambda_nm in WavelengthGrid::Step5.wavelengths_nm() {
            assert_eq!(product.at(lambda_nm), ramp().at(lambda_nm).powi(2));
        }
    }

    #[test]
    fn bad_tables_are_refused() {
        let problem = |pairs: &[(f64, f64)]| {
            Spectrum::from_pairs("spectrum", pairs.iter().copied()).unwrap_err().to_string()
        };
        assert_eq!(problem(&[]), "spectrum: no rows, expected wavelength in nm and value");
        assert_eq!(
            problem(&[(400.0, 1.0), (400.0, 2.0)]),
            "spectrum: wavelength 400 nm follows 400 nm, must ascend"
        );
        assert_eq!(
            problem(&[(400.0, f64::NAN)]),
            "spectrum: value at 400 nm is NaN, allowed: finite numbers"
        );
    }
}
