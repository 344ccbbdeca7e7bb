//! A measured spectrum as a table.

use std::path::Path;

use super::cie;
use crate::columns::{Table, TableChoice, WavelengthCurve, built_in_rows};
use crate::error::{self, Error, Result};
use crate::spectrum::WavelengthGrid;

/// Values over wavelength, linear between the rows of a table.
///
/// Outside of its rows a table of a material (a reflectance, a transmittance, an index) is constant,
/// and one of a light is 0: [`Self::at`] and [`Self::light_at`]. A single row is a constant, and
/// covers everything either way.
///
/// Unit: whatever was measured (a ratio, W/nm, or relative).
#[derive(Debug, Clone, PartialEq)]
pub struct Spectrum {
    /// Strictly ascending, finite, > 0, nm; at least one.
    lambda_nm: Vec<f64>,
    /// Finite; one a wavelength.
    values: Vec<f64>,
    /// The values as light, where they differ within the table: of products and sums whose tables
    /// cover different wavelengths.
    light: Option<Vec<f64>>,
    origin: TableOrigin,
}

/// Whether a table is known to be a light's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum TableOrigin {
    /// A table that may be anything.
    Unknown,
    /// A standard illuminant, a radiator, or a product with one.
    Light,
}

impl Spectrum {
    /// The same value at every wavelength.
    pub fn constant(value: f64) -> Self {
        Self::of(vec![560.0], vec![value])
    }

    /// From columns that are known to keep the promises of the fields.
    pub(super) fn from_sorted(lambda_nm: Vec<f64>, values: Vec<f64>) -> Self {
        debug_assert_eq!(fault_in_table(&lambda_nm, &values), None);
        Self::of(lambda_nm, values)
    }

    fn of(lambda_nm: Vec<f64>, values: Vec<f64>) -> Self {
        Self { lambda_nm, values, light: None, origin: TableOrigin::Unknown }
    }

    /// The same table, known to be a light's: in products the other one is held constant.
    pub(super) fn into_light(self) -> Self {
        Self { origin: TableOrigin::Light, ..self }
    }

    /// From rows of wavelength (nm) and value.
    ///
    /// Errors: no rows, a wavelength that is not above the one before, or a value that is not
    /// finite; `what` names the table in the message.
    pub fn from_pairs(what: &str, pairs: impl IntoIterator<Item = (f64, f64)>) -> Result<Self> {
        let (lambda_nm, values): (Vec<f64>, Vec<f64>) = pairs.into_iter().unzip();
        let spectrum = Self::of(lambda_nm, values);
        spectrum.check(what)?;
        Ok(spectrum)
    }

    /// Errors: a value beyond [`error::LARGEST`], as products have them; `what` names the spectrum.
    pub fn check(&self, what: &str) -> Result<()> {
        match fault_in_table(&self.lambda_nm, &self.values) {
            None => Ok(()),
            Some(problem) => Err(Error::inconsistent(what, problem)),
        }
    }

    /// A column of a table of the program's own, which a test reads; wavelengths are column 0.
    pub(crate) fn built_in(csv: &'static str, column: usize) -> Self {
        let pairs = built_in_rows(csv).map(|(_, row)| (row[0], row[column]));
        Self::from_pairs("built-in table", pairs).unwrap_or_else(|_| Self::constant(0.0))
    }

    /// From a file of any kind that [`Table`] reads.
    ///
    /// Errors: those of [`Table::read`] and [`Table::curve`].
    pub fn load(path: &Path, choice: &TableChoice) -> Result<Self> {
        Table::read(path)?.curve(choice).map(Self::from)
    }

    /// Strictly ascending, nm; no less than one.
    pub fn wavelengths_nm(&self) -> &[f64] {
        &self.lambda_nm
    }

    /// One for each of [`Self::wavelengths_nm`].
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// First and last wavelength of the table, nm; `None` of a constant.
    pub fn range_nm(&self) -> Option<[f64; 2]> {
        match self.lambda_nm.as_slice() {
            [first, .., last] => Some([*first, *last]),
            _ => None,
        }
    }

    /// The range, where it leaves out a part of 380 to 780 nm.
    pub fn partial_range_nm(&self) -> Option<[f64; 2]> {
        self.range_nm().filter(|&[first, last]| {
            first > WavelengthGrid::FIRST_NM || last < WavelengthGrid::LAST_NM
        })
    }

    /// The value at a wavelength, held constant outside of the table.
    pub fn at(&self, lambda_nm: f64) -> f64 {
        interpolated(&self.lambda_nm, &self.values, lambda_nm)
    }

    /// The value of a light at a wavelength: 0 outside of the table.
    pub fn light_at(&self, lambda_nm: f64) -> f64 {
        match self.range_nm() {
            Some([first, last]) if !(first..=last).contains(&lambda_nm) => 0.0,
            _ => interpolated(
                &self.lambda_nm,
                self.light.as_deref().unwrap_or(&self.values),
                lambda_nm,
            ),
        }
    }

    /// Values of a material at the bands of `grid`: see [`Self::at`].
    pub fn on_grid(&self, grid: WavelengthGrid) -> Vec<f64> {
        grid.wavelengths_nm().map(|l| self.at(l)).collect()
    }

    /// Values of a light at the bands of `grid`: see [`Self::light_at`].
    pub fn light_on_grid(&self, grid: WavelengthGrid) -> Vec<f64> {
        grid.wavelengths_nm().map(|l| self.light_at(l)).collect()
    }

    /// The share of its peak that a light has at the end of its table, where that is inside of 380
    /// to 780 nm: what is left out beyond.
    pub fn cut_share(&self) -> f64 {
        let Some([first, last]) = self.partial_range_nm() else { return 0.0 };
        let ends =
            [(first, first > WavelengthGrid::FIRST_NM), (last, last < WavelengthGrid::LAST_NM)];
        let cut = ends.iter().filter(|(_, is_inside)| *is_inside).map(|(nm, _)| self.light_at(*nm));
        let peak = self.max();
        if peak > 0.0 { cut.fold(0.0, f64::max) / peak } else { 0.0 }
    }

    /// Smallest value of the table.
    pub fn min(&self) -> f64 {
        self.values.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// Largest value of the table.
    pub fn max(&self) -> f64 {
        self.values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
    }

    /// Every value times `factor`.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        self.with_values(|_, value| value * factor)
    }

    /// No value outside of `low` to `high`.
    #[must_use]
    pub fn clamped(&self, low: f64, high: f64) -> Self {
        self.with_values(|_, value| value.max(low).min(high))
    }

    /// `f` of wavelength and value at the rows.
    fn with_values(&self, f: impl Fn(f64, f64) -> f64) -> Self {
        let of = |values: &[f64]| -> Vec<f64> {
            self.lambda_nm.iter().zip(values).map(|(&l, &value)| f(l, value)).collect()
        };
        let light = self.light.as_deref().map(of);
        Self { lambda_nm: self.lambda_nm.clone(), values: of(&self.values), light, ..*self }
    }

    /// Scaled to 1 at a wavelength; unchanged where it is 0 there.
    #[must_use]
    pub fn normalized_at(&self, lambda_nm: f64) -> Self {
        let value = self.at(lambda_nm);
        if value == 0.0 { self.clone() } else { self.scaled(value.recip()) }
    }

    /// Band-wise sum, exact at the rows of both tables and at every band of the 5 nm grid; as light,
    /// each is 0 outside of its own table.
    #[must_use]
    pub fn sum(&self, other: &Self) -> Self {
        let sum = |l: f64| self.at(l) + other.at(l);
        self.combined(other, sum, |l| self.light_at(l) + other.light_at(l))
    }

    /// Band-wise product, exact at the rows of both tables and at every band of the 5 nm grid.
    ///
    /// As light it is 0 outside of the light's table. Where it is not known which of the two is the
    /// light, it is 0 outside of either.
    #[must_use]
    pub fn product(&self, other: &Self) -> Self {
        let product = |l: f64| self.at(l) * other.at(l);
        let into_light = |l: f64| match (self.origin, other.origin) {
            (TableOrigin::Light, TableOrigin::Unknown) => self.light_at(l) * other.at(l),
            (TableOrigin::Unknown, TableOrigin::Light) => self.at(l) * other.light_at(l),
            _ => self.light_at(l) * other.light_at(l),
        };
        self.combined(other, product, into_light)
    }

    /// `f` of the value at every wavelength of this table and at the 5 nm bands within it.
    #[must_use]
    pub fn mapped(&self, f: impl Fn(f64, f64) -> f64) -> Self {
        let lambda_nm = union_with_bands(&self.lambda_nm, &[]);
        let values = lambda_nm.iter().map(|&l| f(l, self.at(l))).collect();
        Self { origin: self.origin, ..Self::of(lambda_nm, values) }
    }

    fn combined(
        &self,
        other: &Self,
        f: impl Fn(f64) -> f64,
        into_light: impl Fn(f64) -> f64,
    ) -> Self {
        let lambda_nm = union_with_bands(&self.lambda_nm, &other.lambda_nm);
        let values: Vec<f64> = lambda_nm.iter().map(|&l| f(l)).collect();
        let light: Vec<f64> = lambda_nm.iter().map(|&l| into_light(l)).collect();
        let light = (light != values).then_some(light);
        let origin = match (self.origin, other.origin) {
            (TableOrigin::Unknown, TableOrigin::Unknown) => TableOrigin::Unknown,
            _ => TableOrigin::Light,
        };
        Self { lambda_nm, values, light, origin }
    }

    /// 683 Σ S(λ) V(λ) Δλ on `grid`, as light: lm, if the values are W/nm.
    pub fn luminous_flux(&self, grid: WavelengthGrid) -> f64 {
        cie::luminous(grid, &self.light_on_grid(grid))
    }
}

impl From<WavelengthCurve> for Spectrum {
    fn from(curve: WavelengthCurve) -> Self {
        Self::from_sorted(curve.lambda_nm, curve.values)
    }
}

/// Linear between the rows, constant outside of them.
fn interpolated(lambda_nm: &[f64], values: &[f64], at_nm: f64) -> f64 {
    let after = lambda_nm.partition_point(|&l| l < at_nm);
    if after == 0 {
        return values[0];
    }
    if after == lambda_nm.len() {
        return values[after - 1];
    }
    let (l0, l1) = (lambda_nm[after - 1], lambda_nm[after]);
    let t = (at_nm - l0) / (l1 - l0);
    values[after - 1] * (1.0 - t) + values[after] * t
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

/// Why a table breaks its promises.
fn fault_in_table(lambda_nm: &[f64], values: &[f64]) -> Option<String> {
    if lambda_nm.is_empty() {
        return Some("no rows, expected wavelength in nm and value".to_owned());
    }
    for (row, (&l, &v)) in lambda_nm.iter().zip(values).enumerate() {
        if !(l.is_finite() && l > 0.0) {
            return Some(format!("wavelength is {l}, allowed: finite and above 0 nm"));
        }
        if !error::may_enter(v) {
            return Some(format!("value at {l} nm is {v:?}, allowed: {}", error::NUMBERS));
        }
        if row > 0 && l <= lambda_nm[row - 1] {
            let before = lambda_nm[row - 1];
            return Some(format!("wavelength {l} nm follows {before} nm, must ascend"));
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
            "spectrum: value at 400 nm is NaN, allowed: finite numbers up to 1e32"
        );
    }

    fn table(rows: &[(f64, f64)]) -> Spectrum {
        Spectrum::from_pairs("s", rows.iter().copied()).unwrap()
    }

    /// model.md: an LED's table of 580 to 680 nm, held constant, moves from x = 0.704 to 0.675.
    #[test]
    fn a_light_is_dark_outside_of_its_table() {
        let rows: Vec<(f64, f64)> = (0..=20)
            .map(|i| (580.0 + 5.0 * f64::from(i), (-((f64::from(i) - 11.0) / 4.0).powi(2)).exp()))
            .collect();
        let led = table(&rows);
        assert_eq!(
            (led.light_at(579.9), led.light_at(680.1), led.light_at(700.0)),
            (0.0, 0.0, 0.0)
        );
        assert_eq!(led.light_at(680.0), led.at(680.0));
        assert_eq!(led.light_on_grid(WavelengthGrid::Step5)[80], 0.0);
        let constant = Spectrum::constant(2.0);
        assert_eq!((constant.light_at(380.0), constant.range_nm()), (2.0, None));
    }

    #[test]
    fn products_and_sums_of_lights_stay_dark() {
        let led = table(&[(580.0, 1.0), (680.0, 1.0)]);
        let blue = table(&[(440.0, 1.0), (480.0, 1.0)]);
        let filter = table(&[(380.0, 0.5), (780.0, 0.5)]);
        let narrow = table(&[(450.0, 0.5), (650.0, 0.5)]);
        let seen = led.product(&filter);
        assert_eq!((seen.light_at(400.0), seen.light_at(600.0), seen.at(400.0)), (0.0, 0.5, 0.5));
        let both = led.sum(&blue);
        assert_eq!([450.0, 520.0, 600.0, 700.0].map(|l| both.light_at(l)), [1.0, 0.0, 1.0, 0.0]);
        assert_eq!(both.product(&filter).light_at(520.0), 0.0);
        assert_eq!(both.scaled(3.0).clamped(0.0, 2.0).light_at(600.0), 2.0);
        // A light that is known as one shines through what is constant outside of its table.
        let a = cie::illuminant("A").unwrap();
        assert_eq!(a.product(&narrow).light_at(700.0), 0.5 * a.at(700.0));
        assert_eq!(narrow.product(&a).light_at(400.0), 0.5 * a.at(400.0));
        assert_eq!(Spectrum::constant(2.0).product(&led).light_at(500.0), 0.0);
    }

    #[test]
    fn tables_that_end_early_are_told() {
        let led = table(&[(580.0, 0.2), (620.0, 1.0), (680.0, 0.02)]);
        assert_eq!((led.partial_range_nm(), led.cut_share()), (Some([580.0, 680.0]), 0.2));
        let wide = table(&[(300.0, 1.0), (900.0, 1.0)]);
        assert_eq!((wide.partial_range_nm(), wide.cut_share()), (None, 0.0));
        assert_eq!(Spectrum::constant(1.0).cut_share(), 0.0);
    }
}
