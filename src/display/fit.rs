//! A display's model from measured ramps (Table 2).

use super::curve::Curve;
use super::measured::MeasuredCurve;
use super::model::{CHANNELS, Display, DisplayParameters};
use crate::color::{Lab, Xyz};
use crate::error::{Error, Result};
use crate::fit::{Estimate, MeasuredTable, Residual, check_table, minimize};

/// What one digit of one channel was measured to show, black included.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RampPatch {
    /// 0 to 2ⁿ − 1.
    pub digit: f64,
    /// What was measured.
    pub light: RampLight,
}

/// cd/m².
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RampLight {
    /// Y alone, cd/m².
    Luminance(f64),
    /// X, Y and Z, cd/m².
    Xyz(Xyz),
}

impl RampLight {
    /// cd/m².
    pub fn luminance(self) -> f64 {
        match self {
            Self::Luminance(y) => y,
            Self::Xyz(color) => color.y,
        }
    }
}

/// A display as it was measured.
#[derive(Debug, Clone, PartialEq)]
pub struct DisplayMeasurement {
    /// What the display is called.
    pub name: String,
    /// Red, green and blue, each alone, by ascending digit; the last digit is 2ⁿ − 1.
    pub ramps: [Vec<RampPatch>; 3],
    /// M of eq. 6 in rows, cd/m²; `None` takes the ramps' last patches, which must then be XYZ.
    pub matrix: Option<[[f64; 3]; 3]>,
    /// XYZ_black of eq. 6, cd/m², which is in every patch; 0 if it was subtracted from them. `None`
    /// takes what the ramps show at digit 0, or 0 where they do not start there.
    pub black: Option<Xyz>,
    /// Bits of a channel, 1 to 16.
    pub bits: u32,
}

/// What stands for a channel's tone curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum CurveKind {
    /// Eq. 5.
    #[default]
    Gog,
    /// A curve through the measured levels.
    Measured,
}

/// The model of a measured display, and how well its curves fit.
#[derive(Debug, Clone, PartialEq)]
pub struct DisplayFit {
    /// The model.
    pub display: Display,
    /// Eq. 5 for each channel, whatever curves the display has.
    pub channels: [ChannelFit; 3],
    /// The level at which eq. 5 is most wrong.
    pub worst: WorstLevel,
    /// Black that was taken, cd/m².
    pub black: Xyz,
}

/// How far eq. 5 is from a measured level.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorstLevel {
    /// 0 to 2.
    pub channel: usize,
    /// 0 to 2ⁿ − 1.
    pub digit: f64,
    /// L* of the model minus that of the measurement, of the channel's light relative to its full.
    pub lightness_error: f64,
}

/// Steps of L* that a level may be off before eq. 5 does not describe a display: the paper's worst
/// patch is at ΔE*ab 5.4.
const TOLERATED_LIGHTNESS: f64 = 5.4;

impl WorstLevel {
    /// Whether eq. 5 describes the display's ramps.
    pub fn is_described(&self) -> bool {
        self.lightness_error.abs() <= TOLERATED_LIGHTNESS
    }
}

impl std::fmt::Display for WorstLevel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (channel, digit) = (CHANNELS[self.channel], self.digit);
        let error = self.lightness_error.abs();
        if self.is_described() {
            return write!(f, "described by gain-offset-gamma, to {error:.1} L*");
        }
        let word = if self.lightness_error > 0.0 { "light" } else { "dark" };
        write!(
            f,
            "not described by gain-offset-gamma: it makes {channel} {error:.1} L* too {word} at digit \
             {digit:.0}: curves = \"measured\" goes through the measured levels instead"
        )
    }
}

/// k_g and γ of a channel; k_o = 1 − k_g.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChannelFit {
    /// k_g; k_o is 1 − k_g.
    pub gain: f64,
    /// γ.
    pub gamma: f64,
    /// Standard errors, from the covariance.
    pub gain_error: f64,
    /// Standard error of γ.
    pub gamma_error: f64,
    /// Root mean square residual, relative to the channel's maximum.
    pub rms: f64,
}

/// Fits eq. 5 to each ramp's luminance by least squares under k_g + k_o = 1, black subtracted
/// first, then normalized by the maximum.
///
/// Errors: [`Error::Inconsistent`] for a ramp of fewer than 3 patches, or with the row of it that
/// is unsorted, negative, not finite, or saturated; for a ramp that does not end at full; for a
/// matrix that is neither given nor measured; and what [`Display::new`] refuses.
pub fn fit_display(measurement: &DisplayMeasurement, kind: CurveKind) -> Result<DisplayFit> {
    let DisplayMeasurement { name, ramps, bits, .. } = measurement;
    let black = measurement.black();
    let full = f64::from(*bits).exp2() - 1.0;
    let mut channels = Vec::new();
    for (ramp, channel) in ramps.iter().zip(CHANNELS) {
        channels.push(fit_channel(&format!("display fit: {channel}"), ramp, full, black.y)?);
    }
    let levels = ramps.each_ref().map(|ramp| relative_levels(ramp, full, black.y));
    let [red, green, blue] = [channels[0], channels[1], channels[2]];
    let curve = |fit: ChannelFit| Curve::gog(fit.gain, 1.0 - fit.gain, fit.gamma);
    let display = Display::new(DisplayParameters {
        name: name.clone(),
        curves: [red, green, blue].map(curve),
        matrix: matrix_of(measurement, black)?,
        black,
        bits: *bits,
    })?;
    let worst = worst_level(&display, &levels);
    let display = match kind {
        CurveKind::Gog => display,
        CurveKind::Measured => {
            let [red, green, blue] =
                levels.map(|levels| MeasuredCurve::new("display fit", &levels));
            display.with_measured_curves([red?, green?, blue?])
        }
    };
    Ok(DisplayFit { display, channels: [red, green, blue], worst, black })
}

/// Signals, and light relative to full, black subtracted.
fn relative_levels(ramp: &[RampPatch], full: f64, black_y: f64) -> Vec<(f64, f64)> {
    let lit = |patch: &RampPatch| patch.light.luminance() - black_y;
    let most = ramp.last().map_or(1.0, lit);
    ramp.iter().map(|patch| (patch.digit / full, lit(patch) / most)).collect()
}

fn worst_level(display: &Display, levels: &[Vec<(f64, f64)>; 3]) -> WorstLevel {
    let full = f64::from(display.full_digit());
    let lightness = |light: f64| {
        let gray = Xyz::new(light, light, light) * 100.0;
        Lab::from_xyz(gray, Xyz::new(100.0, 100.0, 100.0)).l
    };
    let all = levels.iter().enumerate().flat_map(|(channel, levels)| {
        levels.iter().map(move |&(signal, light)| (channel, signal, light))
    });
    let errors = all.map(|(channel, signal, light)| WorstLevel {
        channel,
        digit: signal * full,
        lightness_error: lightness(display.light(channel, signal)) - lightness(light.max(0.0)),
    });
    let none = WorstLevel { channel: 0, digit: 0.0, lightness_error: 0.0 };
    errors.fold(none, |worst, error| {
        if error.lightness_error.abs() > worst.lightness_error.abs() { error } else { worst }
    })
}

impl DisplayMeasurement {
    /// The black that counts: what is given, else the mean of the ramps' levels at digit 0.
    pub fn black(&self) -> Xyz {
        let firsts = self.ramps.iter().filter_map(|ramp| ramp.first());
        let dark: Vec<Xyz> = firsts
            .filter(|patch| patch.digit == 0.0)
            .map(|patch| match patch.light {
                RampLight::Xyz(color) => color,
                RampLight::Luminance(y) => Xyz::new(0.0, y, 0.0),
            })
            .collect();
        let sum = dark.iter().fold(Xyz::default(), |sum, color| sum + *color);
        self.black.unwrap_or_else(|| sum * (1.0 / dark.len().max(1) as f64))
    }
}

/// Fewest patches that leave a residual to k_g and γ.
const MIN_PATCHES: usize = 3;

fn fit_channel(object: &str, ramp: &[RampPatch], full: f64, black_y: f64) -> Result<ChannelFit> {
    let rows: Vec<(f64, f64)> = ramp.iter().map(|p| (p.digit, p.light.luminance())).collect();
    let columns = ["digit", "luminance"];
    check_table(&MeasuredTable { object, columns, min_rows: MIN_PATCHES, max_plateau: 1 }, &rows)?;
    let (first, (last, max)) = (rows[0].0, rows[rows.len() - 1]);
    if first < 0.0 || last != full {
        let problem = format!("digits are {first} to {last}, allowed: 0 or above, up to {full}");
        return Err(Error::inconsistent(object, problem));
    }
    if max <= black_y {
        let problem = format!("row {}: luminance {max} is not above black's {black_y}", rows.len());
        return Err(Error::inconsistent(object, problem));
    }
    let signals: Vec<f64> = rows.iter().map(|row| row.0 / full).collect();
    let lights: Vec<f64> = rows.iter().map(|row| (row.1 - black_y) / (max - black_y)).collect();
    let fit = minimize(object, [1.0, 2.2], rows.len(), |parameters, row| {
        gog_residual(parameters, signals[row], lights[row])
    })?;
    Ok(ChannelFit::from(fit))
}

/// (k_g x + 1 − k_g)^γ − y, and its derivatives by k_g and γ.
fn gog_residual(&[gain, gamma]: &[f64; 2], signal: f64, light: f64) -> Residual<2> {
    let base = gain * signal + 1.0 - gain;
    if base <= 0.0 {
        return Residual { value: -light, gradient: [0.0; 2] };
    }
    let model = base.powf(gamma);
    let by_gain = gamma * model / base * (signal - 1.0);
    Residual { value: model - light, gradient: [by_gain, model * base.ln()] }
}

impl From<Estimate<2>> for ChannelFit {
    fn from(fit: Estimate<2>) -> Self {
        let ([gain, gamma], [gain_error, gamma_error]) = (fit.parameters, fit.standard_errors);
        Self { gain, gamma, gain_error, gamma_error, rms: fit.rms }
    }
}

fn matrix_of(measurement: &DisplayMeasurement, black: Xyz) -> Result<[[f64; 3]; 3]> {
    if let Some(matrix) = measurement.matrix {
        return Ok(matrix);
    }
    let mut matrix = [[0.0; 3]; 3];
    for (c, ramp) in measurement.ramps.iter().enumerate() {
        let Some(RampLight::Xyz(color)) = ramp.last().map(|patch| patch.light) else {
            return Err(Error::MissingKey {
                object: "display fit".to_owned(),
                key: "matrix".to_owned(),
                expected: format!("or X, Y, Z in the last patch of {}", CHANNELS[c]),
            });
        };
        let primary: [f64; 3] = (color - black).into();
        for (row, value) in primary.into_iter().enumerate() {
            matrix[row][c] = value;
        }
    }
    Ok(matrix)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ramps that `display` would show, in `count` even steps from digit 0.
    fn ramps(display: &Display, count: usize) -> [Vec<RampPatch>; 3] {
        let full = f64::from(display.full_digit());
        [0, 1, 2].map(|channel| {
            let patch = |i: usize| {
                let digit = full * i as f64 / (count - 1) as f64;
                let rgb = [0, 1, 2].map(|c| {
                    if c == channel { display.curves()[c].light(digit / full) } else { 0.0 }
                });
                RampPatch { digit, light: RampLight::Xyz(display.xyz_from_linear(rgb)) }
            };
            (0..count).map(patch).collect()
        })
    }

    fn measurement(count: usize) -> DisplayMeasurement {
        let display = Display::eizo_t766();
        DisplayMeasurement {
            name: "copy".to_owned(),
            ramps: ramps(&display, count),
            matrix: None,
            black: Some(display.black()),
            bits: 8,
        }
    }

    #[test]
    fn a_display_is_recovered_from_its_own_ramps() {
        for count in [4, 5, 256] {
            let fit = fit_display(&measurement(count), CurveKind::Gog).unwrap();
            let t766 = Display::eizo_t766();
            for (found, curve) in fit.channels.iter().zip(t766.curves()) {
                // The data are exact.
                assert!((found.gain - curve.gain).abs() < 1e-7, "{count}: {found:?}");
                assert!((found.gamma - curve.gamma).abs() < 1e-6, "{count}: {found:?}");
            }
            let difference = fit.display.matrix() - t766.matrix();
            assert!(difference.to_cols_array().iter().all(|d| d.abs() < 1e-10));
        }
    }

    #[test]
    fn luminances_need_a_matrix() {
        let mut bare = measurement(5);
        for patch in bare.ramps.iter_mut().flatten() {
            patch.light = RampLight::Luminance(patch.light.luminance());
        }
        assert_eq!(
            fit_display(&bare, CurveKind::Gog).unwrap_err().to_string(),
            "display fit: missing \"matrix\", or X, Y, Z in the last patch of red"
        );
        bare.matrix = Some(Display::eizo_t766().matrix().transpose().to_cols_array_2d());
        assert!(fit_display(&bare, CurveKind::Gog).is_ok());
    }

    #[test]
    fn bad_ramps_are_refused_with_channel_and_row() {
        let message = |change: fn(&mut Vec<RampPatch>)| {
            let mut bad = measurement(5);
            change(&mut bad.ramps[1]);
            fit_display(&bad, CurveKind::Gog).unwrap_err().to_string()
        };
        assert_eq!(
            message(|ramp| ramp.truncate(2)),
            "display fit: green: has 2 rows, needs at least 3"
        );
        assert_eq!(
            message(|ramp| ramp.swap(1, 2)),
            "display fit: green: row 3: digit 63.75 follows 127.5, must ascend"
        );
        assert_eq!(
            message(|ramp| ramp[2].light = RampLight::Luminance(f64::NAN)),
            "display fit: green: row 3: luminance is NaN, allowed: finite, at least 0"
        );
        let saturated = message(|ramp| ramp[3].light = ramp[4].light);
        let start = "display fit: green: rows 4 to 5: luminance stays at its maximum 74.78";
        assert!(saturated.starts_with(start), "{saturated}");
        assert_eq!(
            message(|ramp| ramp.truncate(4)),
            "display fit: green: digits are 0 to 191.25, allowed: 0 or above, up to 255"
        );
        assert_eq!(
            message(|ramp| ramp
                .iter_mut()
                .for_each(|p| p.light = RampLight::Luminance(p.digit * 1e-4))),
            "display fit: green: row 5: luminance 0.025500000000000002 is not above black's 0.53"
        );
    }
}
