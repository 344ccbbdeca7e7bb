//! A display as an ICC profile.

use glam::{DMat3, DVec3};
use moxcms::{
    ColorProfile, DataColorSpace, LocalizableString, Matrix3d, ProfileClass, ProfileText,
    RenderingIntent, ToneReprCurve, Xyzd,
};

use super::curve::Curve;
use super::model::Display;
use crate::color::{D65_XY, Xyz};
use crate::error::{Error, Result};

/// White of the profile connection space. Source: ICC.1:2010, 7.2.16.
pub(super) const D50: DVec3 = DVec3::new(0.9642, 1.0, 0.8249);

/// Bradford's cone responses, in rows. Source: ICC.1:2010, E.3.
const BRADFORD_ROWS: [[f64; 3]; 3] =
    [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];

impl Display {
    /// The bytes of an ICC v4 matrix/TRC profile that holds this model.
    ///
    /// A channel's curve (eq. 5) is ICC's parametric curve exactly, up to its 16 fractional bits,
    /// and XYZ_black (eq. 6) goes into the curves' constant terms. Only digit 0 means no light at
    /// all: eq. 7 gives it to everything darker than the display's black, as sRGB does; and
    /// programs that match blacks (by default those with v4 profiles and perceptual intent) would
    /// otherwise darken every shadow.
    ///
    /// Deviation: ICC would map the display's own white to D50. The digits of eq. 7 and 8 show
    /// colors as they are, to an eye that is not adapted to the display's white; so D65 is the
    /// white that goes to D50, as it is for sRGB. A color-managed program then turns the digits
    /// into those that sRGB has for the same color, under every rendering intent.
    /// Errors: [`Error::Inconsistent`] if the profile cannot be encoded.
    pub fn icc_profile(&self) -> Result<Vec<u8>> {
        let adaptation = d50_from_d65();
        let black = self.matrix().inverse() * DVec3::from(self.black());
        let white_cd_m2 = self.white().y;
        let colorant = |c: usize| {
            let lit = adaptation * self.matrix().col(c) * ((1.0 + black[c]) / white_cd_m2);
            xyzd(lit.into())
        };
        let first_digit = 1.0 / f64::from(self.full_digit());
        let curve = |c: usize| {
            Some(match self.measured_curves() {
                Some(_) => sampled(self, c, black[c]),
                None => parametric(&self.curves()[c], black[c], first_digit),
            })
        };
        let mut profile = blank_profile(adaptation);
        [profile.red_colorant, profile.green_colorant, profile.blue_colorant] =
            [0, 1, 2].map(colorant);
        [profile.red_trc, profile.green_trc, profile.blue_trc] = [0, 1, 2].map(curve);
        profile.description = Some(text(self.name()));
        let encoded = profile.encode();
        let refused = |e| Error::inconsistent("display", format!("has no ICC profile: {e:?}"));
        let mut bytes = encoded.map_err(refused)?;
        // The encoder writes the hour at which it runs, whatever the profile says.
        bytes[DATE_PLACE].copy_from_slice(&DATE.map(u16::to_be_bytes).concat());
        Ok(bytes)
    }
}

/// A display profile without colors.
fn blank_profile(adaptation: DMat3) -> ColorProfile {
    let mut profile = ColorProfile::default();
    profile.profile_class = ProfileClass::DisplayDevice;
    profile.rendering_intent = RenderingIntent::RelativeColorimetric;
    profile.color_space = DataColorSpace::Rgb;
    profile.pcs = DataColorSpace::Xyz;
    profile.white_point = xyzd(D50.into());
    profile.media_white_point = Some(xyzd(D50.into()));
    let v = [0, 1, 2].map(|row| adaptation.row(row).to_array());
    profile.chromatic_adaptation = Some(Matrix3d { v });
    profile.copyright = Some(text("No copyright, use freely"));
    profile
}

/// Year, month, day, hour, minute, second: the same for every run, so that files are.
const DATE: [u16; 6] = [2006, 1, 1, 0, 0, 0];
/// Source: ICC.1:2010, 7.2.1: the date in the header.
const DATE_PLACE: std::ops::Range<usize> = 24..36;

fn xyzd(color: Xyz) -> Xyzd {
    Xyzd { x: color.x, y: color.y, z: color.z }
}

fn text(value: &str) -> ProfileText {
    let value = value.to_owned();
    let (language, country) = ("en".to_owned(), "US".to_owned());
    ProfileText::Localizable(vec![LocalizableString { language, country, value }])
}

/// Source: ICC.1:2010, annex E.
fn d50_from_d65() -> DMat3 {
    d50_from(DVec3::from(Xyz::from_xy(D65_XY, 1.0)))
}

/// Bradford's adaptation of a white, Y = 1, to D50.
pub(super) fn d50_from(white: DVec3) -> DMat3 {
    let cones = DMat3::from_cols_array_2d(&BRADFORD_ROWS).transpose();
    let gain = (cones * D50) / (cones * white);
    cones.inverse() * DMat3::from_diagonal(gain) * cones
}

/// (`curve` + `black`)/(1 + `black`) as (a X + b)^g + e from d on, and c X below
/// (parameters g a b c d e f of ICC.1:2010, 10.18, type 4).
///
/// The line is sRGB's toe, or leads from no light at digit 0 to where the curve starts: the
/// first digit, or the end of the dead zone.
fn parametric(curve: &Curve, black: f64, first_digit: f64) -> ToneReprCurve {
    let share = 1.0 / (1.0 + black);
    let inside = share.powf(1.0 / curve.gamma);
    let (a, b, e) = (curve.gain * inside, curve.offset * inside, black * share);
    // A little beyond the dead zone, lest the rounding to 2⁻¹⁶ make a d + b negative, for which
    // some programs refuse a profile.
    let start = || first_digit.max(curve.dead_zone() + 1e-4);
    let d = curve.toe.map_or_else(start, |toe| toe.end);
    let c = (curve.light(d) + black) * share / d;
    ToneReprCurve::Parametric([curve.gamma, a, b, c, d, e, 0.0].map(|p| p as f32).to_vec())
}

/// (curve + `black`)/(1 + `black`) as a table; digit 0 has no light.
fn sampled(display: &Display, channel: usize, black: f64) -> ToneReprCurve {
    const ENTRIES: u16 = 4096;
    let entry = |k: u16| {
        let light = display.light(channel, f64::from(k) / f64::from(ENTRIES - 1));
        let share = if k == 0 { 0.0 } else { (light + black) / (1.0 + black) };
        (share.clamp(0.0, 1.0) * 65535.0).round() as u16
    };
    ToneReprCurve::Lut((0..ENTRIES).map(entry).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::{Lab, delta_e_2000};
    use crate::display::{DisplayParameters, Gamut, GamutMap};
    use lcms2::{Flags, Intent, PixelFormat, Profile, Transform};

    /// Without the optimization that replaces the curves by coarse tables.
    const EXACT: Flags<lcms2::AllowCache> = Flags::NO_OPTIMIZE;

    fn convert(digits: &[[u8; 3]], from: &Profile, to: &Profile, intent: Intent) -> Vec<[u8; 3]> {
        let format = PixelFormat::RGB_8;
        let transform = Transform::new_flags(from, format, to, format, intent, EXACT).unwrap();
        let mut out = vec![[0; 3]; digits.len()];
        transform.transform_pixels(digits, &mut out);
        out
    }

    /// The same with 16 bits.
    fn convert_fine(digits: &[[u16; 3]], from: &Profile, intent: Intent) -> Vec<[u16; 3]> {
        let (to, format) = (Profile::new_srgb(), PixelFormat::RGB_16);
        let transform = Transform::new_flags(from, format, &to, format, intent, EXACT).unwrap();
        let mut out = vec![[0; 3]; digits.len()];
        transform.transform_pixels(digits, &mut out);
        out
    }

    fn profile(display: &Display) -> Profile {
        Profile::new_icc(&display.icc_profile().unwrap()).unwrap()
    }

    const INTENTS: [Intent; 2] = [Intent::Perceptual, Intent::RelativeColorimetric];

    fn narrow(digits: [u16; 3]) -> [u8; 3] {
        digits.map(|d| d as u8)
    }

    fn lab(srgb: &Display, digits: [u8; 3]) -> Lab {
        Lab::from_xyz(srgb.xyz_from_digits(digits.map(f64::from)), srgb.white())
    }

    /// Colors over sRGB, in steps of 15 digits, relative to its white, that `display` can show
    /// with light in every channel.
    fn common_colors(display: &Display) -> Vec<Xyz> {
        let srgb = Display::srgb();
        let map = GamutMap::new(display, Gamut::Clip);
        let steps = || (0..=255).step_by(15).map(f64::from);
        let all = steps().flat_map(|r| steps().flat_map(move |g| steps().map(move |b| [r, g, b])));
        all.map(|digits| srgb.xyz_from_digits(digits) * (1.0 / srgb.white().y))
            .filter(|&color| {
                let target = color * display.white().y;
                let lit = display.digits_from_xyz(target).unwrap().iter().all(|&d| d > 0);
                lit && map.map(target).1.outside() == 0
            })
            .collect()
    }

    fn digits(display: &Display, colors: &[Xyz]) -> Vec<[u8; 3]> {
        let white = display.white().y;
        let of = |color: &Xyz| narrow(display.digits_from_xyz(*color * white).unwrap());
        colors.iter().map(of).collect()
    }

    /// The T766 with digits so fine that rounding to them is invisible.
    fn fine_t766() -> Display {
        let t766 = Display::eizo_t766();
        Display::new(DisplayParameters {
            name: "T766, 16 bits".to_owned(),
            curves: *t766.curves(),
            matrix: t766.matrix().transpose().to_cols_array_2d(),
            black: t766.black(),
            bits: 16,
        })
        .unwrap()
    }

    /// What the profile itself does to colors: 16 bits on both sides leave no rounding to speak of.
    #[test]
    fn littlecms_finds_the_colors_that_the_model_shows() {
        let (t766, srgb) = (fine_t766(), Display::srgb());
        let colors = common_colors(&Display::eizo_t766());
        let white = t766.white().y;
        let shown: Vec<[u16; 3]> =
            colors.iter().map(|color| t766.digits_from_xyz(*color * white).unwrap()).collect();
        for intent in INTENTS {
            let theirs = convert_fine(&shown, &profile(&t766), intent);
            for (color, digits) in colors.iter().zip(&theirs) {
                let digits = digits.map(|d| f64::from(d) / 257.0);
                let found = Lab::from_xyz(srgb.xyz_from_digits(digits), srgb.white());
                let wanted = Lab::from_xyz(*color * srgb.white().y, srgb.white());
                let delta = delta_e_2000(found, wanted);
                // The 16 fractional bits of the profile's numbers.
                assert!(delta < 0.02, "{intent:?} {color:?}: {delta}");
            }
        }
    }

    /// Two files of 8 bits: within ΔE00 1 wherever their rounding leaves it possible.
    ///
    /// The floor is what the model itself says of the rounded digits, rounded to sRGB's. It is
    /// above 1 in one of these 3711 colors: (15, 45, 60) is nearest to T766 (19, 37, 30), which
    /// shows sRGB (14.29, 45.55, 60.04), so that its nearest sRGB digits are ΔE00 1.02 away.
    #[test]
    fn littlecms_turns_t766_digits_into_our_srgb_digits() {
        let (t766, srgb) = (Display::eizo_t766(), Display::srgb());
        let colors = common_colors(&t766);
        assert!(colors.len() > 1000, "{}", colors.len());
        let ours = digits(&srgb, &colors);
        let shown = digits(&t766, &colors);
        let white = t766.white().y;
        let model = |digits: &[u8; 3]| t766.xyz_from_digits(digits.map(f64::from)) * (1.0 / white);
        let best = digits(&srgb, &shown.iter().map(model).collect::<Vec<_>>());
        let delta = |p: [u8; 3], q: [u8; 3]| delta_e_2000(lab(&srgb, p), lab(&srgb, q));
        for intent in INTENTS {
            let theirs = convert(&shown, &profile(&t766), &Profile::new_srgb(), intent);
            let above = (0..ours.len()).filter(|&i| {
                let (found, floor) = (delta(ours[i], theirs[i]), delta(ours[i], best[i]));
                assert!(found <= floor.max(1.0), "{intent:?} {:?}: {found} {floor}", ours[i]);
                found > 1.0
            });
            assert!(above.count() <= 1);
            let differ = theirs.iter().zip(&best).filter(|(p, q)| p != q).count();
            // Within 0.003 digits of half way littlecms may round the other way: 6 in 1000 channels.
            assert!(differ * 50 < best.len(), "{intent:?}: {differ} of {}", best.len());
        }
    }

    #[test]
    fn littlecms_turns_our_srgb_digits_into_t766_digits() {
        let (t766, srgb) = (Display::eizo_t766(), Display::srgb());
        let colors = common_colors(&t766);
        let ours = digits(&t766, &colors);
        let shown = digits(&srgb, &colors);
        let theirs =
            convert(&shown, &Profile::new_srgb(), &profile(&t766), Intent::RelativeColorimetric);
        let lab = |digits: [u8; 3]| {
            Lab::from_xyz(t766.xyz_from_digits(digits.map(f64::from)), t766.white())
        };
        for (p, q) in ours.iter().zip(&theirs) {
            let delta = delta_e_2000(lab(*p), lab(*q));
            assert!(delta < 1.0, "{p:?} {q:?}: {delta}");
        }
    }

    #[test]
    fn black_stays_black() {
        let t766 = profile(&Display::eizo_t766());
        for intent in INTENTS {
            let black = convert(&[[0; 3]], &t766, &Profile::new_srgb(), intent);
            assert_eq!(black, [[0; 3]], "{intent:?}");
        }
    }

    #[test]
    fn our_srgb_profile_is_littlecms_srgb() {
        let digits: Vec<[u8; 3]> = (0..=255u8).map(|d| [d, 255 - d, d.wrapping_mul(7)]).collect();
        for intent in INTENTS {
            let ours = profile(&Display::srgb());
            let back = convert(&digits, &ours, &Profile::new_srgb(), intent);
            for (p, q) in digits.iter().zip(&back) {
                assert!(p.iter().zip(q).all(|(a, b)| a.abs_diff(*b) <= 1), "{p:?} {q:?}");
            }
        }
    }

    #[test]
    fn profiles_are_the_same_each_time() {
        let display = Display::eizo_t766();
        let profile = display.icc_profile().unwrap();
        assert_eq!(profile, display.icc_profile().unwrap());
        // The clock is not in it, which a comparison within the same second would not show.
        assert_eq!(profile[DATE_PLACE], [7, 214, 0, 1, 0, 1, 0, 0, 0, 0, 0, 0]);
    }
}
