//! The gain-offset-gamma display model (eq. 5 to 8).

use std::sync::Arc;

use glam::{DMat3, DVec3};

use super::curve::{Curve, PQ_MAX_CD_M2};
use super::measured::MeasuredCurve;
use crate::color::{self, P3_XY, Xyz};
use crate::error::{Error, Result};

/// A display: its tone curves, its primaries and its black.
#[derive(Debug, Clone, PartialEq)]
pub struct Display {
    name: String,
    curves: [Curve; 3],
    /// In place of the curves.
    measured: Option<Arc<[MeasuredCurve; 3]>>,
    /// M of eq. 6, cd/m²: columns are the primaries at full output.
    xyz_from_rgb: DMat3,
    rgb_from_xyz: DMat3,
    black: Xyz,
    bits: u32,
}

/// What [`Display::new`] is made from.
#[derive(Debug, Clone, PartialEq)]
pub struct DisplayParameters {
    /// What the display is called.
    pub name: String,
    /// Tone curves of red, green and blue.
    pub curves: [Curve; 3],
    /// Rows X, Y, Z; columns R, G, B; cd/m².
    pub matrix: [[f64; 3]; 3],
    /// XYZ_black of eq. 6, cd/m².
    pub black: Xyz,
    /// Digital values are 0 to 2^bits − 1; 1 to 16.
    pub bits: u32,
}

impl Display {
    /// Errors: [`Error::OutOfRange`] for a gain or gamma that is not above 0, a black that is
    /// negative, more than 16 bits; [`Error::Inconsistent`] for primaries without an inverse.
    pub fn new(parameters: DisplayParameters) -> Result<Self> {
        let DisplayParameters { name, curves, matrix, black, bits } = parameters;
        for (curve, channel) in curves.iter().zip(CHANNELS) {
            check_curve(curve, channel)?;
        }
        let allowed = "finite and at least 0 cd/m²";
        for (value, what) in <[f64; 3]>::from(black).iter().zip(["X", "Y", "Z"]) {
            check(*value >= 0.0 && value.is_finite(), &format!("black {what}"), *value, allowed)?;
        }
        check((1..=16).contains(&bits), "bits", f64::from(bits), "1 to 16")?;
        let xyz_from_rgb = DMat3::from_cols_array_2d(&matrix).transpose();
        let rgb_from_xyz = xyz_from_rgb.inverse();
        if !(xyz_from_rgb.is_finite() && rgb_from_xyz.is_finite()) {
            let problem = "matrix has no inverse: two primaries have the same chromaticity";
            return Err(Error::inconsistent("display", problem));
        }
        Ok(Self { name, curves, measured: None, xyz_from_rgb, rgb_from_xyz, black, bits })
    }

    /// The paper's EIZO FlexScan T766: Table 2, the matrix of eq. 7, and XYZ_black.
    pub fn eizo_t766() -> Self {
        let rgb_from_xyz = DMat3::from_cols_array_2d(&[
            [0.0304, -0.0129, -0.0048],
            [-0.0097, 0.0178, 0.0004],
            [0.0005, -0.0017, 0.0077],
        ])
        .transpose();
        Self {
            name: "EIZO FlexScan T766".to_owned(),
            curves: [
                Curve::gog(1.0204, -0.0204, 1.9095),
                Curve::gog(1.0220, -0.0220, 1.8642),
                Curve::gog(0.8997, 0.1003, 2.1514),
            ],
            measured: None,
            xyz_from_rgb: rgb_from_xyz.inverse(),
            rgb_from_xyz,
            black: Xyz::new(0.41, 0.53, 0.37),
            bits: 8,
        }
    }

    /// IEC 61966-2-1: Rec. 709 primaries, D65 of 80 cd/m², no black.
    pub fn srgb() -> Self {
        let white_cd_m2 = 80.0;
        let xyz_from_rgb = DMat3::from_cols_array_2d(
            &[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
                .map(|rgb| (color::xyz_from_rec709(rgb) * white_cd_m2).into()),
        );
        Self {
            name: "sRGB".to_owned(),
            curves: [Curve::SRGB; 3],
            measured: None,
            xyz_from_rgb,
            rgb_from_xyz: xyz_from_rgb.inverse(),
            black: Xyz::default(),
            bits: 8,
        }
    }

    /// Names of the displays that the program knows.
    pub const NAMES: [&'static str; 6] =
        ["eizo_t766", "p3", "p3_pq", "rec2020", "rec2020_pq", "srgb"];

    /// The display of that name, HDR ones with a peak of [`Display::PEAK_CD_M2`]; `None` for
    /// others than [`Display::NAMES`].
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "eizo_t766" => Some(Self::eizo_t766()),
            "p3" => Some(Self::p3()),
            "p3_pq" => Self::p3_pq(Self::PEAK_CD_M2).ok(),
            "rec2020" => Some(Self::rec2020()),
            "rec2020_pq" => Self::rec2020_pq(Self::PEAK_CD_M2).ok(),
            "srgb" => Some(Self::srgb()),
            _ => None,
        }
    }

    /// Peak of an HDR display of which nothing else is said, cd/m²: HDR10 mastering monitors'.
    pub const PEAK_CD_M2: f64 = 1000.0;

    /// Display P3 (SMPTE EG 432-1's primaries, D65, sRGB's curve) of 80 cd/m², no black.
    pub fn p3() -> Self {
        Self::additive("Display P3", P3_XY, 80.0, Curve::SRGB, 8)
    }

    /// ITU-R BT.2020's primaries with sRGB's curve, D65 of 80 cd/m², no black.
    ///
    /// The curve of BT.2020 itself is a camera's: programs disagree on what it shows.
    pub fn rec2020() -> Self {
        Self::additive("Rec. 2020", REC2020_XY, 80.0, Curve::SRGB, 8)
    }

    /// An HDR display with P3's primaries: PQ up to `peak_cd_m2`, 16 bits.
    ///
    /// Errors: [`Error::OutOfRange`] for a peak that is not above 0 and at most 10,000 cd/m².
    pub fn p3_pq(peak_cd_m2: f64) -> Result<Self> {
        check_peak(peak_cd_m2)?;
        Ok(Self::additive("P3 PQ", P3_XY, peak_cd_m2, Curve::pq(peak_cd_m2), 16))
    }

    /// An HDR display with BT.2020's primaries (HDR10); as [`Display::p3_pq`].
    ///
    /// Errors: as [`Display::p3_pq`].
    pub fn rec2020_pq(peak_cd_m2: f64) -> Result<Self> {
        check_peak(peak_cd_m2)?;
        Ok(Self::additive("Rec. 2020 PQ", REC2020_XY, peak_cd_m2, Curve::pq(peak_cd_m2), 16))
    }

    /// D65 at full output, no black.
    fn additive(name: &str, xy: [[f64; 2]; 3], white_cd_m2: f64, curve: Curve, bits: u32) -> Self {
        let xyz_from_rgb = color::xyz_from_primaries(xy, color::D65_XY) * white_cd_m2;
        Self {
            name: name.to_owned(),
            curves: [curve; 3],
            measured: None,
            xyz_from_rgb,
            rgb_from_xyz: xyz_from_rgb.inverse(),
            black: Xyz::default(),
            bits,
        }
    }

    /// The same display, driven with `bits` bits.
    ///
    /// Errors: [`Error::OutOfRange`] for other than 1 to 16.
    pub fn with_bits(mut self, bits: u32) -> Result<Self> {
        check((1..=16).contains(&bits), "bits", f64::from(bits), "1 to 16")?;
        self.bits = bits;
        Ok(self)
    }

    /// Whether digits stand for luminances and not for shares of the display's white.
    pub fn is_absolute(&self) -> bool {
        self.curves[0].pq_peak_cd_m2.is_some()
    }

    /// Primaries, transfer, matrix and range by ITU-T H.273, where it has numbers for them.
    pub fn code_points(&self) -> Option<[u8; 4]> {
        let transfer = match self.curves {
            curves if curves == [Curve::SRGB; 3] => 13,
            curves if curves.iter().all(|curve| curve.pq_peak_cd_m2.is_some()) => 16,
            _ => return None,
        };
        let relative = self.xyz_from_rgb * (1.0 / self.white().y);
        let is_of = |xy| {
            let own = color::xyz_from_primaries(xy, color::D65_XY);
            // A manifest's decimals may round once.
            relative.abs_diff_eq(own, 1e-9) && self.black == Xyz::default()
        };
        let primaries = [(9, REC2020_XY), (12, P3_XY)].into_iter().find(|(_, xy)| is_of(*xy));
        primaries.map(|(number, _)| [number, transfer, 0, 1])
    }

    /// What the display is called.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// With curves through measured levels in place of eq. 5 and 8.
    #[must_use]
    pub fn with_measured_curves(self, measured: [MeasuredCurve; 3]) -> Self {
        Self { measured: Some(Arc::new(measured)), ..self }
    }

    /// The curves through measured levels, if there are any.
    pub fn measured_curves(&self) -> Option<&[MeasuredCurve; 3]> {
        self.measured.as_deref()
    }

    /// Light of a channel (0 to 2) relative to full, from its signal, 0 to 1.
    pub fn light(&self, channel: usize, signal: f64) -> f64 {
        match &self.measured {
            Some(measured) => measured[channel].light(signal),
            None => self.curves[channel].light(signal),
        }
    }

    /// Signal of a channel (0 to 2), 0 to 1, from its light relative to full.
    pub fn signal(&self, channel: usize, light: f64) -> f64 {
        match &self.measured {
            Some(measured) => measured[channel].signal(light),
            None => self.curves[channel].signal(light),
        }
    }

    /// Tone curves of red, green and blue.
    pub fn curves(&self) -> &[Curve; 3] {
        &self.curves
    }

    /// M of eq. 6, cd/m².
    pub fn matrix(&self) -> DMat3 {
        self.xyz_from_rgb
    }

    /// XYZ_black of eq. 6, cd/m².
    pub fn black(&self) -> Xyz {
        self.black
    }

    /// Bits of a channel, 1 to 16.
    pub fn bits(&self) -> u32 {
        self.bits
    }

    /// Whether the digits are those of sRGB, so that files may say so without a profile.
    pub fn is_srgb(&self) -> bool {
        let srgb = Self { bits: self.bits, ..Self::srgb() };
        self.curves == [Curve::SRGB; 3] && *self == srgb
    }

    /// 2ⁿ − 1.
    pub fn full_digit(&self) -> u16 {
        ((1u32 << self.bits) - 1) as u16
    }

    /// All channels at full, black included.
    pub fn white(&self) -> Xyz {
        self.xyz_from_digits([f64::from(self.full_digit()); 3])
    }

    /// What digits show, cd/m² (eq. 5 and 6). Fractional digits are allowed.
    pub fn xyz_from_digits(&self, digits: [f64; 3]) -> Xyz {
        let full = f64::from(self.full_digit());
        self.xyz_from_linear(std::array::from_fn(|c| self.light(c, digits[c] / full)))
    }

    /// Eq. 6.
    pub fn xyz_from_linear(&self, rgb: [f64; 3]) -> Xyz {
        Xyz::from(self.xyz_from_rgb * DVec3::from_array(rgb)) + self.black
    }

    /// Light of the channels that shows `color` (eq. 7), not clipped.
    pub fn linear_from_xyz(&self, color: Xyz) -> [f64; 3] {
        (self.rgb_from_xyz * DVec3::from(color - self.black)).to_array()
    }

    /// Digits from light (eq. 8), clipped and rounded to the nearest; `None` for NaN.
    ///
    /// Deviation: a channel without light gets digit 0, where eq. 8 alone would give
    /// −(2ⁿ − 1) k_o/k_g, in the flat part of the forward curve.
    pub fn digits_from_linear(&self, rgb: [f64; 3]) -> Option<[u16; 3]> {
        if rgb.iter().any(|v| v.is_nan()) {
            return None;
        }
        let full = f64::from(self.full_digit());
        Some(std::array::from_fn(|c| (full * self.signal(c, rgb[c])).round() as u16))
    }

    /// Digits that show `color`, cd/m², or what the display has nearest to it in each channel.
    pub fn digits_from_xyz(&self, color: Xyz) -> Option<[u16; 3]> {
        self.digits_from_linear(self.linear_from_xyz(color))
    }
}

/// ITU-R BT.2020-2.
const REC2020_XY: [[f64; 2]; 3] = [[0.708, 0.292], [0.17, 0.797], [0.131, 0.046]];

fn check_peak(peak_cd_m2: f64) -> Result<()> {
    let good = peak_cd_m2 > 0.0 && peak_cd_m2 <= PQ_MAX_CD_M2;
    check(good, "peak", peak_cd_m2, "above 0, to 10000 cd/m²")
}

/// Names of the channels, in order.
pub const CHANNELS: [&str; 3] = ["red", "green", "blue"];

fn check(good: bool, what: &str, value: f64, allowed: &str) -> Result<()> {
    if good { Ok(()) } else { Err(Error::out_of_range("display", what, value, allowed)) }
}

fn check_curve(curve: &Curve, channel: &str) -> Result<()> {
    let positive = |value: f64| value > 0.0 && value.is_finite();
    check(positive(curve.gain), &format!("{channel} gain"), curve.gain, "finite and above 0")?;
    check(positive(curve.gamma), &format!("{channel} gamma"), curve.gamma, "finite and above 0")?;
    let good = curve.offset.is_finite() && curve.gain + curve.offset > 0.0;
    check(good, &format!("{channel} offset"), curve.offset, "finite and above −gain")
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayon::prelude::*;

    #[test]
    fn t766_has_its_published_white_and_primaries() {
        let display = Display::eizo_t766();
        let white = display.white();
        let [x, y] = white.chromaticity().unwrap();
        // model.md: white about 109 cd/m² at (0.286, 0.304).
        assert!((white.y - 109.0).abs() < 0.5, "{}", white.y);
        assert!((x - 0.286).abs() < 5e-4 && (y - 0.304).abs() < 5e-4, "{x} {y}");
        let primaries = [(0.625, 0.340), (0.276, 0.608), (0.151, 0.065)];
        for (c, (px, py)) in primaries.into_iter().enumerate() {
            let [x, y] = Xyz::from(display.matrix().col(c)).chromaticity().unwrap();
            assert!((x - px).abs() < 1e-3 && (y - py).abs() < 1e-3, "{c}: {x} {y}");
        }
    }

    #[test]
    fn t766_black_has_the_light_of_its_blue_offset() {
        let Xyz { x, y, z } = Display::eizo_t766().xyz_from_digits([0.0; 3]);
        // model.md: (0.589, 0.607, 1.298), to its three decimals.
        assert!((x - 0.589).abs() < 5e-4 && (y - 0.607).abs() < 5e-4 && (z - 1.298).abs() < 5e-4);
    }

    #[test]
    fn srgb_white_is_255_at_80_cd_m2() {
        let srgb = Display::srgb();
        let d65 = Xyz::from_xy(color::D65_XY, 80.0);
        assert_eq!(srgb.digits_from_xyz(d65), Some([255; 3]));
        assert_eq!(srgb.digits_from_xyz(Xyz::default()), Some([0; 3]));
        assert!(srgb.is_srgb() && !Display::eizo_t766().is_srgb());
    }

    #[test]
    fn displays_of_today_have_their_code_points_and_white() {
        let pq = |display: Result<Display>| display.unwrap();
        let displays = [
            (Display::p3(), [12, 13, 0, 1], 80.0),
            (Display::rec2020(), [9, 13, 0, 1], 80.0),
            (pq(Display::p3_pq(1000.0)), [12, 16, 0, 1], 1000.0),
            (pq(Display::rec2020_pq(600.0)), [9, 16, 0, 1], 600.0),
        ];
        for (display, code_points, white_cd_m2) in displays {
            assert_eq!(display.code_points(), Some(code_points), "{}", display.name());
            let white = display.white();
            assert!((white.y / white_cd_m2 - 1.0).abs() < 1e-12, "{}: {white:?}", display.name());
            let [x, y] = white.chromaticity().unwrap();
            assert!((x - 0.3127).abs() < 1e-12 && (y - 0.329).abs() < 1e-12, "{x} {y}");
        }
        assert_eq!(Display::srgb().code_points(), None, "the sRGB chunk says it");
        assert_eq!(
            Display::p3_pq(10_001.0).unwrap_err().to_string(),
            "display: peak is 10001, allowed: above 0, to 10000 cd/m²"
        );
    }

    /// Absolute luminance goes through 16 bits of PQ within 0.05 %, from 0.1 cd/m² to the peak.
    #[test]
    fn pq_keeps_luminance() {
        let display = Display::rec2020_pq(1000.0).unwrap();
        for luminance in [0.1, 1.0, 10.0, 100.0, 999.0] {
            let wanted = Xyz::from_xy(color::D65_XY, luminance);
            let digits = display.digits_from_xyz(wanted).unwrap().map(f64::from);
            let shown = display.xyz_from_digits(digits);
            assert!((shown.y / luminance - 1.0).abs() < 5e-4, "{luminance}: {}", shown.y);
        }
    }

    #[test]
    fn nan_has_no_digits_and_infinity_is_clipped() {
        let display = Display::eizo_t766();
        assert_eq!(display.digits_from_linear([0.1, f64::NAN, 0.0]), None);
        assert_eq!(
            display.digits_from_linear([f64::INFINITY, -1e300, 0.5]).unwrap()[..2],
            [255, 0]
        );
    }

    /// All 2²⁴ colors; where a channel's curve is flat the inverse gives 0.
    fn worst_round_trip(display: &Display) -> i32 {
        let light: Vec<[f64; 3]> = (0..=255)
            .map(|d| display.curves.map(|curve| curve.light(f64::from(d) / 255.0)))
            .collect();
        let flat = display.curves.map(|curve| (curve.dead_zone() * 255.0).floor() as i32);
        let error = |digit: i32, back: u16, channel: usize| {
            let wanted = if digit <= flat[channel] { 0 } else { digit };
            (wanted - i32::from(back)).abs()
        };
        let of_red = |r: usize| {
            let mut worst = 0;
            for (g, b) in (0..256).flat_map(|g| (0..256).map(move |b| (g, b))) {
                let rgb = [light[r][0], light[g][1], light[b][2]];
                let back = display.digits_from_xyz(display.xyz_from_linear(rgb)).unwrap();
                for (channel, digit) in [r, g, b].into_iter().enumerate() {
                    worst = worst.max(error(digit as i32, back[channel], channel));
                }
            }
            worst
        };
        (0..256).into_par_iter().map(of_red).max().unwrap()
    }

    #[test]
    fn every_color_returns_within_a_digit() {
        assert!(worst_round_trip(&Display::eizo_t766()) <= 1);
        assert!(worst_round_trip(&Display::srgb()) <= 1);
    }

    #[test]
    fn bad_parameters_are_refused() {
        let good = DisplayParameters {
            name: "d".to_owned(),
            curves: [Curve::gog(1.0, 0.0, 2.2); 3],
            matrix: [[40.0, 35.0, 18.0], [20.0, 70.0, 7.0], [2.0, 11.0, 95.0]],
            black: Xyz::default(),
            bits: 8,
        };
        assert!(Display::new(good.clone()).is_ok());
        let message = |change: fn(&mut DisplayParameters)| {
            let mut bad = good.clone();
            change(&mut bad);
            Display::new(bad).unwrap_err().to_string()
        };
        assert_eq!(
            message(|p| p.curves[1].gamma = 0.0),
            "display: green gamma is 0, allowed: finite and above 0"
        );
        assert_eq!(
            message(|p| p.black.z = f64::NAN),
            "display: black Z is NaN, allowed: finite and at least 0 cd/m²"
        );
        assert_eq!(message(|p| p.bits = 17), "display: bits is 17, allowed: 1 to 16");
        assert_eq!(
            message(|p| p.matrix = [[1.0; 3]; 3]),
            "display: matrix has no inverse: two primaries have the same chromaticity"
        );
    }
}
