//! The working wavelengths.

/// 380 to 780 nm in even steps; every spectrum of a render lives on one of these.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum WavelengthGrid {
    /// 81 bands.
    Step5,
    /// 41 bands.
    Step10,
    /// 21 bands.
    Step20,
}

impl WavelengthGrid {
    /// Every grid, the finest first: at the index that `grid as usize` gives.
    pub const ALL: [Self; 3] = [Self::Step5, Self::Step10, Self::Step20];
    /// The shortest wavelength.
    pub const FIRST_NM: f64 = 380.0;
    /// The longest wavelength.
    pub const LAST_NM: f64 = 780.0;
    /// The most bands that any grid has.
    pub const MAX_BANDS: usize = 81;

    /// Distance of neighboring bands.
    pub fn step_nm(self) -> f64 {
        match self {
            Self::Step5 => 5.0,
            Self::Step10 => 10.0,
            Self::Step20 => 20.0,
        }
    }

    /// How many there are: 81, 41 or 21.
    pub fn bands(self) -> usize {
        match self {
            Self::Step5 => 81,
            Self::Step10 => 41,
            Self::Step20 => 21,
        }
    }

    /// The wavelength of a band.
    pub fn lambda_nm(self, band: usize) -> f64 {
        Self::FIRST_NM + self.step_nm() * band as f64
    }

    /// The wavelengths of all bands, ascending.
    pub fn wavelengths_nm(self) -> impl Iterator<Item = f64> {
        (0..self.bands()).map(move |band| self.lambda_nm(band))
    }
}
