//! The filament bulbs of rear lamps, by their UN R37 category.

use glam::DVec3;

use super::coil::Coil;
use super::filament::Filament;
use super::tungsten;
use crate::error::{Error, Result};
use crate::light::RaySet;
use crate::spectrum::Spectrum;

/// One filament of a bulb: what burns when its function is lit.
///
/// Fluxes and places: `data/lamps/light_source_categories.csv`, which states how far each figure
/// was verified. Temperatures: at which tungsten gives the category's flux for 0.9 of its greatest
/// power (a tenth goes into gas and leads), rounded to 50 K. Coils: the wire has the resistance that
/// draws this power at 13.5 V, and the surface that gives the flux at this temperature when half
/// of the light gets out of the coil; coil radius and pitch are chosen so that 21 W filaments are
/// 6 mm long (R37: at most 7, standard lamp 5 to 7).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bulb {
    /// Its name in UN R37.
    pub category: &'static str,
    /// Which of the bulb's filaments it is.
    pub function: Function,
    /// At 13.5 V, through the bulb's glass.
    pub flux_lm: f64,
    /// At 13.5 V, greatest.
    pub power_w: f64,
    /// True temperature of the wire.
    pub temperature_k: f64,
    /// The filament's wire.
    pub coil: Coil,
    /// Offset of the filament's middle from the light center: toward the tip, and sideways.
    pub offset_mm: [f64; 2],
    /// Distance of the light center from the cap's reference plane (R37: e).
    pub light_center_mm: f64,
    /// What the light goes through.
    pub glass: GlassColor,
}

/// Which filament of a bulb; a bulb with one has the major one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Function {
    /// Stop or turn signal.
    Major,
    /// Rear position (tail).
    Minor,
}

/// Color of a bulb's glass.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GlassColor {
    /// Colorless.
    Clear,
    /// As [`amber_glass`] has it.
    Amber,
}

/// Where a bulb sits in a lamp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Socket {
    /// Light center, mm: the middle of the major filament.
    pub center: DVec3,
    /// From cap to tip; any length but 0.
    pub axis: DVec3,
    /// Along the filament; what of it is not along `axis` counts.
    pub filament_axis: DVec3,
}

const COIL_21_W: Coil =
    Coil { wire_radius_mm: 0.0635, turns: 34.0, pitch_mm: 0.1765, coil_radius_mm: 0.5 };
const COIL_5_W_MINOR: Coil =
    Coil { wire_radius_mm: 0.031, turns: 68.0, pitch_mm: 0.09, coil_radius_mm: 0.3 };
const COIL_W5W: Coil =
    Coil { wire_radius_mm: 0.025, turns: 58.0, pitch_mm: 0.0725, coil_radius_mm: 0.25 };

const P21W: Bulb = Bulb {
    category: "P21W",
    function: Function::Major,
    flux_lm: 460.0,
    power_w: 26.5,
    temperature_k: 2750.0,
    coil: COIL_21_W,
    offset_mm: [0.0, 0.0],
    light_center_mm: 31.8,
    glass: GlassColor::Clear,
};

/// The minor filament of P21/5W. R37 gives 2.8 mm along and across from the major one.
///
/// *Decision*: toward the tip; the transcription at hand does not say which way.
const P21_5W_MINOR: Bulb = Bulb {
    category: "P21/5W",
    function: Function::Minor,
    flux_lm: 35.0,
    power_w: 6.6,
    temperature_k: 2250.0,
    coil: COIL_5_W_MINOR,
    offset_mm: [2.8, 2.8],
    light_center_mm: 31.8,
    glass: GlassColor::Clear,
};

/// Every category and filament.
pub const BULBS: [Bulb; 7] = [
    P21W,
    Bulb { category: "PY21W", flux_lm: 280.0, glass: GlassColor::Amber, ..P21W },
    Bulb { category: "P21/5W", flux_lm: 440.0, ..P21W },
    P21_5W_MINOR,
    Bulb {
        category: "PY21/5W",
        flux_lm: 270.0,
        light_center_mm: 28.6,
        glass: GlassColor::Amber,
        ..P21W
    },
    Bulb {
        category: "PY21/5W",
        flux_lm: 21.0,
        light_center_mm: 28.6,
        glass: GlassColor::Amber,
        ..P21_5W_MINOR
    },
    // 50 lm and 12.7 mm are often quoted; not verified in R37's text.
    Bulb {
        category: "W5W",
        flux_lm: 50.0,
        power_w: 5.5,
        temperature_k: 2450.0,
        coil: COIL_W5W,
        light_center_mm: 12.7,
        ..P21W
    },
];

impl Bulb {
    /// Errors: [`Error::OutOfRange`] for a category that is not in [`BULBS`], or has no such
    /// filament.
    pub fn find(category: &str, function: Function) -> Result<&'static Self> {
        let mut of_category = BULBS.iter().filter(|b| b.category == category).peekable();
        if of_category.peek().is_none() {
            let mut known: Vec<_> = BULBS.iter().map(|b| b.category).collect();
            known.dedup();
            let quoted = format!("\"{category}\"");
            return Err(Error::out_of_range("bulb", "category", quoted, known.join(", ")));
        }
        of_category
            .find(|b| b.function == function)
            .ok_or_else(|| Error::inconsistent("bulb", format!("{category} has no minor filament")))
    }

    /// The filament in its place, with the category's flux.
    ///
    /// Errors: as [`Filament::rayset`], and a filament axis along the bulb's axis.
    pub fn rayset(&self, socket: &Socket, samples: usize, seed: u64) -> Result<RaySet> {
        self.filament(socket, samples, seed)?.rayset()
    }

    /// The filament in its place.
    ///
    /// Errors: a filament axis along the bulb's axis.
    pub fn filament(&self, socket: &Socket, samples: usize, seed: u64) -> Result<Filament> {
        let unit = |what: &str, v: DVec3| {
            v.try_normalize().ok_or_else(|| Error::out_of_range("bulb", what, v, "finite, not 0"))
        };
        let axis = unit("axis", socket.axis)?;
        let along = unit("filament_axis", socket.filament_axis)?.reject_from_normalized(axis);
        // 1e-6: what is left of a unit vector along the axis after rounding, many times over
        if along.length() < 1e-6 {
            let problem = "filament_axis is along axis, expected it across";
            return Err(Error::inconsistent("bulb", problem));
        }
        let filament_axis = along.normalize();
        let [toward_tip, sideways] = self.offset_mm;
        let offset = axis * toward_tip + axis.cross(filament_axis) * sideways;
        Ok(Filament {
            coil: self.coil,
            center: socket.center + offset,
            axis: filament_axis,
            flux_lm: self.flux_lm,
            samples,
            seed,
        })
    }

    /// I_norm(λ) of eq. 12, relative.
    pub fn spectrum(&self) -> Spectrum {
        let wire = tungsten::spectrum(self.temperature_k);
        match self.glass {
            GlassColor::Clear => wire,
            GlassColor::Amber => wire.mapped(|lambda_nm, s| s * amber_glass(lambda_nm)),
        }
    }
}

/// Transmittance of amber bulb glass, a long-pass model.
///
/// 0.92 is clear glass with its two surfaces; the absorbance falls by e every 20 nm, and where it
/// is 1 (541.5 nm) is such that a 2750 K filament's flux falls from a P21W's to a PY21W's (460 lm
/// to 280 lm; 61.1 % by the model, 60.9 % asked).
pub fn amber_glass(lambda_nm: f64) -> f64 {
    0.92 * (-((541.5 - lambda_nm) / 20.0).exp()).exp()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::signal::SignalColor;
    use crate::columns::{TableChoice, built_in_rows};
    use crate::light::RaySample;
    use crate::spectrum::WavelengthGrid;
    use std::f64::consts::PI;

    const SOCKET: Socket = Socket { center: DVec3::ZERO, axis: DVec3::Z, filament_axis: DVec3::X };

    fn chromaticity(spectrum: &Spectrum) -> [f64; 2] {
        spectrum.xyz().chromaticity().unwrap()
    }

    #[test]
    fn fluxes_are_those_of_the_table() {
        let csv = include_str!("../../data/lamps/light_source_categories.csv");
        let mut rows = 0;
        for (name, row) in built_in_rows(csv).filter(|(name, _)| name.starts_with('P')) {
            let category = name.split(' ').next().unwrap();
            let minor = name.contains("minor");
            let function = if minor { Function::Minor } else { Function::Major };
            let bulb = Bulb::find(category, function).unwrap();
            assert_eq!(bulb.power_w, row[3], "{name}");
            assert_eq!(bulb.flux_lm, row[4], "{name}");
            assert_eq!(bulb.light_center_mm, row[6], "{name}");
            assert!(bulb.coil.length_mm() <= 7.0);
            rows += 1;
        }
        assert_eq!(rows, 6);
    }

    /// The wire of each coil draws its power and gives its flux, as [`Bulb`] says.
    ///
    /// Resistivity of tungsten 56.7 · (T/2000 K)^1.2 µΩ cm within 2 % (Jones and Langmuir 1927).
    /// 12 %: coils and temperatures are rounded, and 50 K are 20 % of the light.
    #[test]
    fn coils_draw_the_power_and_give_the_flux() {
        for bulb in BULBS.iter().filter(|b| b.glass == GlassColor::Clear) {
            let t = bulb.temperature_k;
            let resistivity_ohm_mm = 56.7e-5 * (t / 2000.0).powf(1.2);
            let section_mm2 = PI * bulb.coil.wire_radius_mm.powi(2);
            let ohm = resistivity_ohm_mm * bulb.coil.wire_length_mm() / section_mm2;
            let power = 13.5f64.powi(2) / ohm / bulb.power_w;
            let flux_lm = 0.5 * bulb.coil.surface_mm2() * luminous_exitance_lm_mm2(t);
            let flux = flux_lm / bulb.flux_lm;
            let message = format!("{} {:?}: {power:.3} {flux:.3}", bulb.category, bulb.function);

            assert!((power - 1.0).abs() < 0.12 && (flux - 1.0).abs() < 0.12, "{message}");
        }
    }

    /// 683 Σ ε(λ) M(λ) V(λ) Δλ, with M = c₁ λ⁻⁵/(e^(c₂/λT) − 1).
    fn luminous_exitance_lm_mm2(temperature_k: f64) -> f64 {
        let planck_560 = 3.741_771_85e-16
            / 560e-9f64.powi(5)
            / (1.438_776_877e-2 / (560e-9 * temperature_k)).exp_m1();
        let w_per_m2_nm = planck_560 * 1e-9 * tungsten::emissivity(560.0, temperature_k);
        tungsten::spectrum(temperature_k).luminous_flux(WavelengthGrid::Step5) * w_per_m2_nm * 1e-6
    }

    /// The share that the coil lets out, which the coils' sizes assume.
    #[test]
    fn half_of_the_light_gets_out_of_the_coils() {
        for coil in [COIL_21_W, COIL_5_W_MINOR, COIL_W5W] {
            let share = super::super::filament::free_share(&coil);
            assert!((share - 0.5).abs() < 0.02, "{coil:?}: {share}");
        }
    }

    #[test]
    fn amber_bulbs_are_amber() {
        for bulb in BULBS.iter().filter(|b| b.glass == GlassColor::Amber) {
            let xy = chromaticity(&bulb.spectrum());
            assert!(
                SignalColor::Amber.contains(xy),
                "{} {:?}: {xy:?}",
                bulb.category,
                bulb.function
            );
        }
        let clear = tungsten::spectrum(2750.0);
        let amber = clear.mapped(|lambda_nm, s| s * amber_glass(lambda_nm));
        let flux = |s: &Spectrum| s.luminous_flux(WavelengthGrid::Step5);
        // 280/460, to the rounding of the glass' two figures
        assert!((flux(&amber) / flux(&clear) / (280.0 / 460.0) - 1.0).abs() < 0.005);
    }

    fn material(file: &str) -> Spectrum {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("data/materials");
        Spectrum::load(&folder.join(file), &TableChoice::default()).unwrap()
    }

    /// Bulb × aluminium × lens, for the paths that light takes through a 3 mm lens with pillows.
    #[test]
    fn lenses_have_regulation_colors() {
        let aluminium = material("aluminium_mcpeak2015.csv");
        let through = |bulb: &Bulb, lens: &Spectrum, path_mm: f64| {
            let lens = lens.mapped(|_, t| t.powf(path_mm / 3.0));
            chromaticity(&bulb.spectrum().product(&aluminium).product(&lens))
        };
        let red = material("pmma_red_3mm.csv");
        let amber = material("pmma_amber_3mm.csv");
        let light_amber = material("pmma_light_amber_3mm.csv");
        for path_mm in [2.0, 3.0, 4.0, 5.0, 6.0] {
            for bulb in &BULBS {
                let xy = through(bulb, &red, path_mm);
                assert!(SignalColor::Red.contains(xy), "{} red {path_mm}: {xy:?}", bulb.category);
            }
            for bulb in [&BULBS[0], &BULBS[1]] {
                let xy = through(bulb, &light_amber, path_mm);
                assert!(
                    SignalColor::Amber.contains(xy),
                    "{} light amber {path_mm}: {xy:?}",
                    bulb.category
                );
            }
        }
        for path_mm in [2.0, 3.0, 4.0] {
            let xy = through(&P21W, &amber, path_mm);
            assert!(SignalColor::Amber.contains(xy), "amber {path_mm}: {xy:?}");
        }
    }

    /// The tables are what their headers say: edge and slope in nm.
    #[test]
    fn lens_tables_follow_their_formula() {
        for (file, edge_nm, slope_nm) in [
            ("pmma_red_3mm.csv", 625.0, 17.75),
            ("pmma_amber_3mm.csv", 552.0, 14.25),
            ("pmma_light_amber_3mm.csv", 541.0, 9.0),
        ] {
            let table = material(file);
            for lambda_nm in WavelengthGrid::Step5.wavelengths_nm() {
                let expected = (-f64::exp((edge_nm - lambda_nm) / slope_nm)).exp();
                let got = table.at(lambda_nm);
                // six digits, and 0 for what nobody sees
                assert!(
                    (got - expected).abs() <= 5e-6 * expected + 1e-60,
                    "{file} {lambda_nm}: {got}"
                );
            }
        }
    }

    #[test]
    fn aluminium_has_its_reflectance() {
        // Fresnel at normal incidence for n, k of McPeak et al.
        let aluminium = material("aluminium_mcpeak2015.csv");
        for (lambda_nm, r) in [(450.0, 0.921_881), (550.0, 0.915_678), (650.0, 0.904_127)] {
            assert!((aluminium.at(lambda_nm) - r).abs() < 1e-6, "{lambda_nm}");
        }
    }

    #[test]
    fn two_filaments_lie_where_r37_says() {
        let center = |function| {
            let bulb = Bulb::find("P21/5W", function).unwrap();
            let set = bulb.rayset(&SOCKET, 5000, 0).unwrap();
            let sum: DVec3 = set
                .samples
                .iter()
                .map(RaySample::origin)
                .map(|p| set.world_from_local.transform_point3(p))
                .sum();
            sum / 5000.0
        };
        // even samples of a symmetric coil
        assert!(center(Function::Major).length() < 0.02);
        assert!(center(Function::Minor).distance(DVec3::new(0.0, 2.8, 2.8)) < 0.02);
    }

    #[test]
    fn unknown_bulbs_are_refused() {
        let problem = |category, function| Bulb::find(category, function).unwrap_err().to_string();
        assert_eq!(
            problem("P27W", Function::Major),
            "bulb: category is \"P27W\", allowed: P21W, PY21W, P21/5W, PY21/5W, W5W"
        );
        assert_eq!(problem("P21W", Function::Minor), "bulb: P21W has no minor filament");
        let along = Socket { filament_axis: DVec3::Z, ..SOCKET };
        assert_eq!(
            P21W.rayset(&along, 1, 0).unwrap_err().to_string(),
            "bulb: filament_axis is along axis, expected it across"
        );
    }
}
