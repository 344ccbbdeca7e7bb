//! Units, as headers name them and as ranges of numbers give them away.

/// What a column of wavelengths is in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WavelengthUnit {
    /// nm
    Nanometer,
    /// µm
    Micrometer,
    /// Å
    Angstrom,
    /// cm⁻¹
    PerCentimeter,
    /// eV
    ElectronVolt,
    /// THz
    Terahertz,
}

/// h c/e, eV nm (CODATA 2018, exact).
const EV_NM: f64 = 1_239.841_984;
/// c, THz nm (exact).
const THZ_NM: f64 = 299_792.458;

/// Where light is visible, nm.
const VISIBLE_NM: [f64; 2] = [380.0, 780.0];

impl WavelengthUnit {
    const ALL: [Self; 6] = [
        Self::Nanometer,
        Self::Micrometer,
        Self::Angstrom,
        Self::PerCentimeter,
        Self::ElectronVolt,
        Self::Terahertz,
    ];

    /// As in a message.
    pub fn name(self) -> &'static str {
        match self {
            Self::Nanometer => "nm",
            Self::Micrometer => "µm",
            Self::Angstrom => "Å",
            Self::PerCentimeter => "cm⁻¹",
            Self::ElectronVolt => "eV",
            Self::Terahertz => "THz",
        }
    }

    /// The wavelength in nm.
    pub fn to_nm(self, value: f64) -> f64 {
        match self {
            Self::Nanometer => value,
            Self::Micrometer => value * 1000.0,
            Self::Angstrom => value / 10.0,
            Self::PerCentimeter => 1e7 / value,
            Self::ElectronVolt => EV_NM / value,
            Self::Terahertz => THZ_NM / value,
        }
    }

    /// The unit that a header's cell names.
    pub fn of_header(name: &str) -> Option<Self> {
        let name = name.to_lowercase();
        let has = |marks: &[&str]| marks.iter().any(|mark| name.contains(mark));
        if has(&["cm-1", "cm⁻¹", "cm^-1", "cm**-1", "1/cm", "wavenumber", "wellenzahl"]) {
            return Some(Self::PerCentimeter);
        }
        if has(&["å", "angstrom", "ångstr", "ångström"]) {
            return Some(Self::Angstrom);
        }
        let words = name.split(|c: char| !c.is_alphanumeric());
        words.into_iter().find_map(|word| match word {
            "nm" | "nanometer" | "nanometers" | "nanometre" | "nanometres" => Some(Self::Nanometer),
            "um" | "µm" | "μm" | "micron" | "microns" | "micrometer" | "micrometers"
            | "micrometre" | "micrometres" => Some(Self::Micrometer),
            "ev" => Some(Self::ElectronVolt),
            "thz" => Some(Self::Terahertz),
            _ => None,
        })
    }

    /// The unit in which numbers from `low` to `high` share most with the visible wavelengths, of
    /// the length of the visible; nm where they share a part of it in nm.
    pub fn of_range(low: f64, high: f64) -> Option<Self> {
        let shared = |unit: Self| {
            let (a, b) = (unit.to_nm(low), unit.to_nm(high));
            a.max(b).min(VISIBLE_NM[1]) - a.min(b).max(VISIBLE_NM[0])
        };
        if shared(Self::Nanometer) >= 0.0 {
            return Some(Self::Nanometer);
        }
        let best = Self::ALL.into_iter().max_by(|&a, &b| shared(a).total_cmp(&shared(b)))?;
        (shared(best) > 0.0).then_some(best)
    }
}

/// Whether a header's cell says that its numbers are hundredths.
pub fn is_percent(name: &str) -> bool {
    let name = name.to_lowercase();
    name.contains('%') || name.contains("percent") || name.contains("prozent")
}

/// Whether a header's cell says that its numbers are decadic logarithms.
pub fn is_logarithm(name: &str) -> bool {
    let name = name.to_lowercase();
    let words: Vec<&str> = name.split(|c: char| !c.is_alphanumeric()).collect();
    words.iter().any(|word| matches!(*word, "log" | "log10" | "lg" | "logbrdf" | "logbsdf"))
}

/// Whether a header's cell names a wavelength, or what takes its place.
pub fn is_wavelength(name: &str) -> bool {
    let name = name.to_lowercase();
    ["wavelength", "wellenl", "wavenumber", "lambda", "λ", "파장", "波長", "longueur d"]
        .iter()
        .any(|word| name.contains(word))
        || matches!(name.trim_matches(['(', ')', '[', ']']), "nm" | "wave" | "wl" | "um" | "µm")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_name_units() {
        for (name, unit) in [
            ("wavelength_nm", Some(WavelengthUnit::Nanometer)),
            ("Wavelength (µm)", Some(WavelengthUnit::Micrometer)),
            ("lambda [um]", Some(WavelengthUnit::Micrometer)),
            ("Wellenlänge/Å", Some(WavelengthUnit::Angstrom)),
            ("Wavenumber", Some(WavelengthUnit::PerCentimeter)),
            ("1/CM", Some(WavelengthUnit::PerCentimeter)),
            ("Energy (eV)", Some(WavelengthUnit::ElectronVolt)),
            ("wavelength", None),
            ("sample", None),
        ] {
            assert_eq!(WavelengthUnit::of_header(name), unit, "{name}");
        }
    }

    #[test]
    fn ranges_give_units_away() {
        for (low, high, unit) in [
            (380.0, 780.0, Some(WavelengthUnit::Nanometer)),
            (250.0, 2500.0, Some(WavelengthUnit::Nanometer)),
            (0.38, 0.78, Some(WavelengthUnit::Micrometer)),
            (0.3, 2.5, Some(WavelengthUnit::Micrometer)),
            (3800.0, 7800.0, Some(WavelengthUnit::Angstrom)),
            (4000.0, 7000.0, Some(WavelengthUnit::Angstrom)),
            (12_000.0, 27_000.0, Some(WavelengthUnit::PerCentimeter)),
            (1.6, 3.2, Some(WavelengthUnit::ElectronVolt)),
            (900.0, 1700.0, None),
        ] {
            assert_eq!(WavelengthUnit::of_range(low, high), unit, "{low} {high}");
        }
    }

    #[test]
    fn units_agree_about_a_line() {
        for (unit, value) in [
            (WavelengthUnit::Micrometer, 0.5),
            (WavelengthUnit::Angstrom, 5000.0),
            (WavelengthUnit::PerCentimeter, 20_000.0),
            (WavelengthUnit::ElectronVolt, 2.479_683_968),
            (WavelengthUnit::Terahertz, 599.584_916),
        ] {
            assert!((unit.to_nm(value) - 500.0).abs() < 1e-6, "{unit:?}");
        }
    }
}
