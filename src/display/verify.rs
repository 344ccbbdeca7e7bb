//! A display's model against measured patches (Table 3).

use std::fmt;

use super::model::Display;
use crate::color::{Lab, Xyz, delta_e_2000, delta_e_ab};
use crate::error::{Error, Result};

/// What three digits were measured to show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ColorPatch {
    /// 0 to 2ⁿ − 1.
    pub digits: [f64; 3],
    /// cd/m², black included.
    pub measured: Xyz,
}

/// A patch, and what the model says of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PatchError {
    /// Digits, and what was measured.
    pub patch: ColorPatch,
    /// What the model shows for the digits, cd/m².
    pub predicted: Xyz,
    /// CIE 1976 difference of prediction and measurement.
    pub delta_e_ab: f64,
    /// CIEDE2000 difference of prediction and measurement.
    pub delta_e_2000: f64,
    /// L* predicted minus measured.
    pub lightness_error: f64,
}

/// How well a model describes a display; CIELAB is relative to the model's own white.
#[derive(Debug, Clone, PartialEq)]
pub struct Verification {
    /// ΔE*ab, as in Table 3.
    pub mean: f64,
    /// Largest ΔE*ab.
    pub max: f64,
    /// Mean CIEDE2000.
    pub mean_2000: f64,
    /// Largest CIEDE2000.
    pub max_2000: f64,
    /// In the order of the patches.
    pub patches: Vec<PatchError>,
    /// What the differences say about the model.
    pub verdict: Verdict,
}

/// Whether the model is good for work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Mean and maximum below twice those of the paper's Table 3.
    Describes,
    /// Mean below [`ROUGH_MEAN`].
    Roughly,
    /// Neither; the tone curve is of another kind.
    Fails(MisfitCause),
}

/// Where a model that fails is wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MisfitCause {
    /// Some grays are predicted too light, others too dark, as for the S-shaped curve of an LCD.
    ToneCurve,
    /// Grays are predicted too light.
    TooLight,
    /// Grays are predicted too dark.
    TooDark,
    /// Lightness is less than a third of the error.
    Color,
}

/// Mean and maximum ΔE*ab of the paper's Table 3.
pub const TABLE_3: [f64; 2] = [1.9592, 5.3923];
/// Mean ΔE*ab at which colors are taken for different at a glance.
pub const ROUGH_MEAN: f64 = 6.0;

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Describes => "the model describes this display",
            Self::Roughly => "the model describes this display only roughly",
            Self::Fails(MisfitCause::ToneCurve) => {
                "the model does not describe this display: its tone curve is of another kind, \
                 such as the S-shape of an LCD"
            }
            Self::Fails(MisfitCause::TooLight) => {
                "the model does not describe this display: it predicts colors too light"
            }
            Self::Fails(MisfitCause::TooDark) => {
                "the model does not describe this display: it predicts colors too dark"
            }
            Self::Fails(MisfitCause::Color) => {
                "the model does not describe this display: its primaries do not add up"
            }
        })
    }
}

impl Verification {
    /// The `count` patches of the largest ΔE*ab, worst first.
    pub fn worst(&self, count: usize) -> Vec<PatchError> {
        let mut sorted = self.patches.clone();
        sorted.sort_by(|p, q| q.delta_e_ab.total_cmp(&p.delta_e_ab));
        sorted.truncate(count);
        sorted
    }
}

/// Compares what `display` predicts with what was measured.
///
/// Errors: [`Error::Inconsistent`] for no patches, or with the row (from 1) of a patch whose
/// digits are out of range or whose XYZ is negative or not finite.
pub fn verify(display: &Display, patches: &[ColorPatch]) -> Result<Verification> {
    if patches.is_empty() {
        return Err(Error::inconsistent("display verification", "has no patches"));
    }
    for (number, patch) in (1..).zip(patches) {
        check_patch(display, number, patch)?;
    }
    let white = display.white();
    let patches: Vec<PatchError> =
        patches.iter().map(|patch| compare(display, white, *patch)).collect();
    let [mean, mean_2000] = [mean(&patches, |p| p.delta_e_ab), mean(&patches, |p| p.delta_e_2000)];
    let max = |of: fn(&PatchError) -> f64| patches.iter().map(of).fold(0.0, f64::max);
    let [max, max_2000] = [max(|p| p.delta_e_ab), max(|p| p.delta_e_2000)];
    let verdict = judge([mean, max], &patches);
    Ok(Verification { mean, max, mean_2000, max_2000, patches, verdict })
}

fn check_patch(display: &Display, number: usize, patch: &ColorPatch) -> Result<()> {
    let full = f64::from(display.full_digit());
    let refuse = |what: &str, value: f64, allowed: String| {
        let problem = format!("row {number}: {what} is {value}, allowed: {allowed}");
        Err(Error::inconsistent("display verification", problem))
    };
    for (digit, name) in patch.digits.into_iter().zip(["r", "g", "b"]) {
        if !(0.0..=full).contains(&digit) {
            return refuse(name, digit, format!("0 to {full}"));
        }
    }
    for (value, name) in <[f64; 3]>::from(patch.measured).into_iter().zip(["X", "Y", "Z"]) {
        if !(value >= 0.0 && value.is_finite()) {
            return refuse(name, value, "finite, at least 0 cd/m²".to_owned());
        }
    }
    Ok(())
}

fn compare(display: &Display, white: Xyz, patch: ColorPatch) -> PatchError {
    let predicted = display.xyz_from_digits(patch.digits);
    let [p, q] = [predicted, patch.measured].map(|color| Lab::from_xyz(color, white));
    PatchError {
        patch,
        predicted,
        delta_e_ab: delta_e_ab(p, q),
        delta_e_2000: delta_e_2000(p, q),
        lightness_error: p.l - q.l,
    }
}

fn mean<'a>(
    patches: impl IntoIterator<Item = &'a PatchError>,
    of: impl Fn(&PatchError) -> f64,
) -> f64 {
    let (sum, count) =
        patches.into_iter().fold((0.0, 0u32), |(sum, count), p| (sum + of(p), count + 1));
    if count == 0 { 0.0 } else { sum / f64::from(count) }
}

fn judge([mean_ab, max_ab]: [f64; 2], patches: &[PatchError]) -> Verdict {
    if mean_ab <= 2.0 * TABLE_3[0] && max_ab <= 2.0 * TABLE_3[1] {
        return Verdict::Describes;
    }
    if mean_ab <= ROUGH_MEAN {
        return Verdict::Roughly;
    }
    // Grays, if there are any, since a wrong tone curve shifts the hue of all other colors.
    let is_gray = |p: &&PatchError| p.patch.digits.iter().all(|&d| d == p.patch.digits[0]);
    let grays: Vec<PatchError> = patches.iter().filter(is_gray).copied().collect();
    let judged = if grays.len() < 3 { patches } else { &grays };
    let size = mean(judged, |p| p.lightness_error.abs());
    let visible = 1.0;
    let some_too_light = judged.iter().any(|p| p.lightness_error > visible);
    let some_too_dark = judged.iter().any(|p| p.lightness_error < -visible);
    Verdict::Fails(if size < 0.3 * mean_ab {
        MisfitCause::Color
    } else if some_too_light && some_too_dark {
        MisfitCause::ToneCurve
    } else if some_too_light {
        MisfitCause::TooLight
    } else {
        MisfitCause::TooDark
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::columns::TableChoice;
    use std::path::PathBuf;

    use crate::display::{Curve, DisplayFit, DisplayMeasurement, DisplayParameters};
    use crate::display::{CurveKind, RampLight, RampPatch, fit_display, read_patches, read_ramps};
    use crate::spectrum::Spectrum;

    fn data(name: &str) -> PathBuf {
        let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("data/displays");
        folder.join(format!("ptb_crt_75hz_2006_{name}.csv"))
    }

    /// The measured CRT's light at digit 0, which its other tables have been freed of.
    fn crt_black() -> Xyz {
        // W·m⁻²·sr⁻¹ per 4 nm.
        Spectrum::load(&data("ambient_spectrum"), &TableChoice::default())
            .unwrap()
            .scaled(0.25)
            .xyz()
    }

    /// Levels of the measured CRT at `thirtieths` of full drive, black included.
    fn crt(thirtieths: &[usize]) -> DisplayMeasurement {
        let black = crt_black();
        let mut ramps = read_ramps(&data("xyz_rgb_ramps"), 8).unwrap();
        for ramp in &mut ramps {
            ramp.insert(0, RampPatch { digit: 0.0, light: RampLight::Xyz(Xyz::default()) });
            *ramp = thirtieths.iter().map(|&level| ramp[level]).collect();
            for patch in ramp.iter_mut() {
                if let RampLight::Xyz(color) = &mut patch.light {
                    *color = *color + black;
                }
            }
        }
        let name = "CRT, 75 Hz, 2006".to_owned();
        DisplayMeasurement { name, ramps, matrix: None, black: Some(black), bits: 8 }
    }

    fn fit(thirtieths: &[usize]) -> DisplayFit {
        fit_display(&crt(thirtieths), CurveKind::Gog).unwrap()
    }

    /// SciPy 1.17.1: `curve_fit(lambda x, kg, g: np.maximum(0, kg*x + 1 - kg)**g, x, Y/Y[-1],
    /// p0=[1, 2.2], xtol=1e-14, ftol=1e-14, gtol=1e-14)` on the Y of levels 0.2, 0.4, 0.6, 0.8
    /// and 1, and on all 30, of data/displays/ptb_crt_75hz_2006_xyz_rgb_ramps.csv; σ from
    /// `np.sqrt(np.diag(pcov))`. Columns k_g, γ, σ of k_g, σ of γ.
    #[test]
    fn fits_agree_with_scipy() {
        let five = [
            [0.87117153, 2.15788917, 0.014994, 0.05130857],
            [0.88352935, 2.02803079, 0.01419606, 0.04583641],
            [0.91338047, 1.99520541, 0.01363242, 0.04238196],
        ];
        let thirty = [
            [0.91068527, 2.02173809, 0.00800719, 0.02545469],
            [0.91694075, 1.91460841, 0.00545778, 0.01663577],
            [0.93373436, 1.92935671, 0.00588698, 0.01774273],
        ];
        let all: Vec<usize> = (1..=30).collect();
        for (levels, expected) in [(&[6, 12, 18, 24, 30][..], five), (&all[..], thirty)] {
            for (found, [gain, gamma, gain_error, gamma_error]) in
                fit(levels).channels.iter().zip(expected)
            {
                assert!((found.gain - gain).abs() < 1e-6, "{found:?}");
                assert!((found.gamma - gamma).abs() < 1e-6, "{found:?}");
                // SciPy's Jacobian is by finite differences.
                assert!((found.gain_error - gain_error).abs() < 1e-4 * gain_error, "{found:?}");
                assert!((found.gamma_error - gamma_error).abs() < 1e-4 * gamma_error, "{found:?}");
            }
        }
    }

    fn crt_patches() -> Vec<ColorPatch> {
        let mut patches = read_patches(&data("SEMISYNTHETIC_216_patches"), 8).unwrap();
        patches.iter_mut().for_each(|patch| patch.measured = patch.measured + crt_black());
        patches
    }

    /// Table 3 on the measured CRT: five even levels from digit 0 (the nearest that were
    /// measured), 216 patches.
    #[test]
    fn crt_is_described_better_than_the_papers_display() {
        let display = fit(&[0, 7, 15, 23, 30]).display;
        let found = verify(&display, &crt_patches()).unwrap();
        assert_eq!(found.patches.len(), 216);
        // NumPy on the same fit and colors, black by 1 nm CMFs: 1.0465 and 4.0424.
        assert!((found.mean - 1.0465).abs() < 2e-3, "{}", found.mean);
        assert!((found.max - 4.0424).abs() < 1e-2, "{}", found.max);
        assert!(found.mean < TABLE_3[0] && found.max < TABLE_3[1]);
        assert!(found.mean_2000 < found.mean && found.max_2000 < found.max);
        assert_eq!(found.verdict, Verdict::Describes);
        let worst = found.worst(10);
        assert_eq!((worst.len(), worst[0].delta_e_ab), (10, found.max));
    }

    #[test]
    fn a_display_describes_itself() {
        let display = Display::eizo_t766();
        let digits = [[0.0; 3], [10.0, 200.0, 30.0], [255.0; 3]];
        let patch = |digits| ColorPatch { digits, measured: display.xyz_from_digits(digits) };
        let found = verify(&display, &digits.map(patch)).unwrap();
        assert_eq!((found.mean, found.max, found.max_2000), (0.0, 0.0, 0.0));
        assert_eq!(found.verdict, Verdict::Describes);
    }

    /// An LCD's tone curve as a smooth step with γ 2 at its foot.
    #[test]
    fn an_s_curve_is_called_one() {
        let s_curve = |x: f64| x * x / (x * x + 3.0 * (1.0 - x).powi(2));
        let display = Display::srgb();
        let shown = |digits: [f64; 3]| display.xyz_from_linear(digits.map(|d| s_curve(d / 255.0)));
        let ramp = |channel: usize| {
            (0..=4).map(move |i| {
                let digit = 63.75 * f64::from(i);
                let mut digits = [0.0; 3];
                digits[channel] = digit;
                RampPatch { digit, light: RampLight::Xyz(shown(digits)) }
            })
        };
        let lcd = DisplayMeasurement {
            name: "LCD".to_owned(),
            ramps: [0, 1, 2].map(|c| ramp(c).collect()),
            matrix: None,
            black: None,
            bits: 8,
        };
        let fit = fit_display(&lcd, CurveKind::Gog);
        let verdict = fit.as_ref().unwrap().worst.to_string();
        assert!(verdict.starts_with("not described by gain-offset-gamma: it makes "), "{verdict}");
        let measured = fit_display(&lcd, CurveKind::Measured).unwrap().display;
        let levels = || (0..6).map(|i| 51.0 * f64::from(i));
        let all =
            levels().flat_map(|r| levels().flat_map(move |g| levels().map(move |b| [r, g, b])));
        let patches: Vec<ColorPatch> =
            all.map(|digits| ColorPatch { digits, measured: shown(digits) }).collect();
        let found = verify(&fit.unwrap().display, &patches).unwrap();
        assert_eq!(found.verdict, Verdict::Fails(MisfitCause::ToneCurve));
        assert!(found.verdict.to_string().ends_with("the S-shape of an LCD"));
        // Through five levels, the curve is off between them; through 17 it is not.
        let through = verify(&measured, &patches).unwrap();
        assert!(through.mean < 0.5 * found.mean, "{} {}", through.mean, found.mean);
    }

    #[test]
    fn wrong_primaries_are_a_matter_of_color() {
        let display = Display::srgb();
        let turned = |digits: [f64; 3]| display.xyz_from_digits([digits[1], digits[0], digits[2]]);
        let reds = (1..=5).map(|i| [51.0 * f64::from(i), 0.0, 0.0]);
        let pairs = reds.flat_map(|[r, g, b]| [[r, g, b], [g, r, b]]);
        let patches: Vec<ColorPatch> =
            pairs.map(|digits| ColorPatch { digits, measured: turned(digits) }).collect();
        let found = verify(&display, &patches).unwrap();
        assert_eq!(found.verdict, Verdict::Fails(MisfitCause::Color));
    }

    #[test]
    fn a_wrong_gamma_is_told_by_its_sign() {
        let of_gamma = |gamma| {
            Display::new(DisplayParameters {
                name: "d".to_owned(),
                curves: [Curve::gog(1.0, 0.0, gamma); 3],
                matrix: Display::srgb().matrix().transpose().to_cols_array_2d(),
                black: Xyz::default(),
                bits: 8,
            })
            .unwrap()
        };
        let truth = of_gamma(2.2);
        let grays = (1..=5).map(|i| [51.0 * f64::from(i); 3]);
        let patches: Vec<ColorPatch> = grays
            .map(|digits| ColorPatch { digits, measured: truth.xyz_from_digits(digits) })
            .collect();
        for (gamma, fault) in [(1.2, MisfitCause::TooLight), (4.0, MisfitCause::TooDark)] {
            let found = verify(&of_gamma(gamma), &patches).unwrap();
            assert_eq!(found.verdict, Verdict::Fails(fault));
        }
    }

    #[test]
    fn bad_patches_are_named() {
        let display = Display::srgb();
        let message = |digits, measured| {
            verify(&display, &[ColorPatch { digits, measured }]).unwrap_err().to_string()
        };
        assert_eq!(
            message([0.0, 256.0, 0.0], Xyz::default()),
            "display verification: row 1: g is 256, allowed: 0 to 255"
        );
        assert_eq!(
            message([0.0; 3], Xyz::new(0.0, 0.0, -1.0)),
            "display verification: row 1: Z is -1, allowed: finite, at least 0 cd/m²"
        );
        assert_eq!(
            verify(&display, &[]).unwrap_err().to_string(),
            "display verification: has no patches"
        );
    }
}
