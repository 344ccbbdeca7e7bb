//! A display from a monitor's ICC profile, of the kind that has a matrix and tone curves.

use std::path::Path;

use glam::{DMat3, DVec3};
use moxcms::{ColorProfile, DataColorSpace, ToneReprCurve, Xyzd};

use super::curve::Curve;
use super::icc::{D50, d50_from};
use super::measured::MeasuredCurve;
use super::model::{CHANNELS, Display, DisplayParameters};
use crate::color::{D65_XY, Xyz};
use crate::error::{Error, Place, Result};
use crate::input;

/// A display as its profile has it.
#[derive(Debug, Clone, PartialEq)]
pub struct ProfiledDisplay {
    /// Eight bits, no black: profiles do not hold it.
    pub display: Display,
    /// What the profile leaves open, a sentence each.
    pub notes: Vec<String>,
}

/// Luminance of white where neither the profile nor the script says it, cd/m²: sRGB's.
const DEFAULT_WHITE_CD_M2: f64 = 80.0;
/// Levels that a curve is taken at.
const LEVELS: u32 = 1024;
const MOST_BYTES: usize = 64 << 20;

/// Whether bytes are an ICC profile.
pub fn is_icc_profile(head: &[u8]) -> bool {
    // Source: ICC.1:2010, 7.2.10.
    head.get(36..40) == Some(b"acsp")
}

/// Reads a profile; `white_cd_m2` counts before the profile's own luminance.
///
/// Errors: [`Error::Io`]; [`Error::BadFile`] for what is no profile of a display with a matrix.
pub fn read_profile(path: &Path, white_cd_m2: Option<f64>) -> Result<ProfiledDisplay> {
    display_from_profile(path, &input::bytes(path)?, white_cd_m2)
}

/// As [`read_profile`]; `path` only names the bytes in messages.
pub fn display_from_profile(
    path: &Path,
    bytes: &[u8],
    white_cd_m2: Option<f64>,
) -> Result<ProfiledDisplay> {
    let bad = |problem: String| Error::bad_file(path, Place::File, problem);
    if !is_icc_profile(bytes) || bytes.len() > MOST_BYTES {
        return Err(bad("is no ICC profile".to_owned()));
    }
    let profile = ColorProfile::new_from_slice(bytes)
        .map_err(|error| bad(format!("a broken ICC profile: {error:?}")))?;
    if profile.color_space != DataColorSpace::Rgb || profile.pcs != DataColorSpace::Xyz {
        let (space, pcs) = (profile.color_space, profile.pcs);
        return Err(bad(format!(
            "a profile from {space:?} to {pcs:?}, expected RGB to XYZ: a matrix"
        )));
    }
    let mut notes = Vec::new();
    let white_y = white_cd_m2.unwrap_or_else(|| luminance(&profile, &mut notes));
    let matrix = matrix(&profile, white_y, &mut notes);
    let matrix =
        matrix.ok_or_else(|| bad("the profile has no colorants of a matrix".to_owned()))?;
    let measured = curves(&profile).map_err(bad)?;
    let display = Display::new(DisplayParameters {
        name: name(&profile, path),
        curves: [Curve::gog(1.0, 0.0, 2.2); 3],
        matrix: matrix.transpose().to_cols_array_2d(),
        black: Xyz::default(),
        bits: 8,
    });
    let display = display.map_err(|error| bad(error.to_string()))?;
    Ok(ProfiledDisplay { display: display.with_measured_curves(measured), notes })
}

/// From channels to colors, of which full white has `white_y`; `None` without colorants.
fn matrix(profile: &ColorProfile, white_y: f64, notes: &mut Vec<String>) -> Option<DMat3> {
    let native = native_from_d50(profile, notes);
    let colorants = [profile.red_colorant, profile.green_colorant, profile.blue_colorant];
    let columns = colorants.map(|colorant| native * vector(colorant));
    let sum = columns[0] + columns[1] + columns[2];
    let scaled = columns.map(|column| (column * (white_y / sum.y)).to_array());
    (sum.y > 0.0 && sum.is_finite()).then(|| DMat3::from_cols_array_2d(&scaled))
}

/// Errors: what is wrong with a channel's curve.
fn curves(profile: &ColorProfile) -> std::result::Result<[MeasuredCurve; 3], String> {
    let curve = |trc: &Option<ToneReprCurve>, channel: &str| {
        let trc = trc.as_ref().ok_or_else(|| format!("the profile has no curve of {channel}"))?;
        measured(channel, trc).map_err(|error| error.to_string())
    };
    let [red, green, blue] = CHANNELS;
    Ok([
        curve(&profile.red_trc, red)?,
        curve(&profile.green_trc, green)?,
        curve(&profile.blue_trc, blue)?,
    ])
}

fn vector(color: Xyzd) -> DVec3 {
    DVec3::new(color.x, color.y, color.z)
}

fn luminance(profile: &ColorProfile, notes: &mut Vec<String>) -> f64 {
    let stated = profile.luminance.map(|luminance| luminance.y);
    stated.filter(|y| *y > 0.0 && y.is_finite()).unwrap_or_else(|| {
        notes.push(format!(
            "the profile does not say how bright white is: taken as {DEFAULT_WHITE_CD_M2} cd/m²"
        ));
        DEFAULT_WHITE_CD_M2
    })
}

/// From the profile's adapted colors to those that the display shows.
fn native_from_d50(profile: &ColorProfile, notes: &mut Vec<String>) -> DMat3 {
    if let Some(adaptation) = &profile.chromatic_adaptation {
        let native = DMat3::from_cols_array_2d(&adaptation.v).transpose().inverse();
        if native.is_finite() {
            return native;
        }
    }
    let white = profile.media_white_point.map(vector).filter(|white| {
        white.min_element() > 0.0 && white.is_finite() && (*white - D50).abs().max_element() > 0.01
    });
    let white = white.unwrap_or_else(|| {
        notes.push(
            "the profile does not say which white it was adapted from: taken as D65".to_owned(),
        );
        DVec3::from(Xyz::from_xy(D65_XY, 1.0))
    });
    d50_from(white / white.y).inverse()
}

fn name(profile: &ColorProfile, path: &Path) -> String {
    use moxcms::ProfileText;
    let text = match &profile.description {
        Some(ProfileText::PlainString(text)) => Some(text.clone()),
        Some(ProfileText::Localizable(texts)) => texts.first().map(|text| text.value.clone()),
        _ => None,
    };
    let name = text.map(|text| text.trim().to_owned()).filter(|text| !text.is_empty());
    let file = || path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
    name.unwrap_or_else(file)
}

/// A profile's curve as levels; what lies below 0 or rests there is no light.
fn measured(channel: &str, trc: &ToneReprCurve) -> Result<MeasuredCurve> {
    let level = |k: u32| {
        let x = f64::from(k) / f64::from(LEVELS - 1);
        (x, light(trc, x))
    };
    let levels: Vec<(f64, f64)> = (0..LEVELS).map(level).collect();
    MeasuredCurve::new(channel, &levels)
}

/// The light of a signal x, both 0 to 1.
fn light(trc: &ToneReprCurve, x: f64) -> f64 {
    match trc {
        ToneReprCurve::Lut(entries) => light_by_table(entries, x),
        ToneReprCurve::Parametric(p) => {
            light_by_parameters(&p.iter().map(|&p| f64::from(p)).collect::<Vec<_>>(), x)
        }
    }
}

/// Source: ICC.1:2010, 10.5.
fn light_by_table(entries: &[u16], x: f64) -> f64 {
    match entries {
        [] => x,
        [gamma] => x.powf(f64::from(*gamma) / 256.0),
        entries => {
            let place = x * (entries.len() - 1) as f64;
            let below = (place as usize).min(entries.len() - 2);
            let t = place - below as f64;
            (f64::from(entries[below]) * (1.0 - t) + f64::from(entries[below + 1]) * t) / 65535.0
        }
    }
}

/// Source: ICC.1:2010, 10.18.
fn light_by_parameters(parameters: &[f64], x: f64) -> f64 {
    let power = |g: f64, a: f64, b: f64| (a * x + b).max(0.0).powf(g);
    let either = |is_first: bool, first: f64, second: f64| if is_first { first } else { second };
    match *parameters {
        [g] => x.powf(g),
        [g, a, b] => either(a * x + b >= 0.0, power(g, a, b), 0.0),
        [g, a, b, c] => either(a * x + b >= 0.0, power(g, a, b) + c, c),
        [g, a, b, c, d] => either(x >= d, power(g, a, b), c * x),
        [g, a, b, c, d, e, f, ..] => either(x >= d, power(g, a, b) + e, c * x + f),
        _ => f64::NAN,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::mutation;

    fn loaded(display: &Display) -> ProfiledDisplay {
        let bytes = display.icc_profile().unwrap();
        display_from_profile(Path::new("m.icc"), &bytes, Some(display.white().y)).unwrap()
    }

    /// 16 bits of the profile's numbers, and 1024 levels of its curves.
    #[test]
    fn a_saved_display_comes_back() {
        let srgb = Display::srgb();
        let found = loaded(&srgb);
        assert!(found.notes.is_empty());
        for digits in
            [[255.0, 255.0, 255.0], [200.0, 100.0, 50.0], [0.0, 0.0, 255.0], [12.0, 13.0, 14.0]]
        {
            let [a, b] = [&found.display, &srgb].map(|d| d.xyz_from_digits(digits));
            assert!(
                (a.x - b.x).abs() < 0.02 && (a.y - b.y).abs() < 0.02 && (a.z - b.z).abs() < 0.02,
                "{digits:?}: {a:?} {b:?}"
            );
        }
        for digits in [[255u16, 0, 128], [1, 2, 3], [250, 200, 90]] {
            let color = srgb.xyz_from_digits(digits.map(f64::from));
            let back = found.display.digits_from_xyz(color).unwrap();
            assert!(
                back.iter().zip(digits).all(|(a, b)| a.abs_diff(b) <= 1),
                "{back:?} {digits:?}"
            );
        }
    }

    #[test]
    fn other_files_are_refused() {
        let message = |bytes: &[u8]| {
            display_from_profile(Path::new("m.icc"), bytes, None).unwrap_err().to_string()
        };
        assert_eq!(message(b"no profile"), "m.icc: is no ICC profile");
        let mut cut = Display::srgb().icc_profile().unwrap();
        cut.truncate(200);
        assert!(message(&cut).starts_with("m.icc: "), "{}", message(&cut));
        let without =
            display_from_profile(Path::new("m.icc"), &Display::srgb().icc_profile().unwrap(), None);
        assert_eq!(
            without.unwrap().notes,
            ["the profile does not say how bright white is: taken as 80 cd/m²"]
        );
    }

    /// Cuts and changed bytes of a profile are read or refused.
    #[test]
    fn mutated_profiles_neither_panic_nor_hang() {
        let seeds = [Display::eizo_t766().icc_profile().unwrap()];
        for bytes in mutation::broken(&seeds, 3000, &[0, 1, 255]) {
            let _ = display_from_profile(Path::new("m.icc"), &bytes, None);
        }
    }
}
