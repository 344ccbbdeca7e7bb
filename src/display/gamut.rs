//! Colors that a display cannot show.

use super::model::Display;
use crate::color::{Lab, Xyz, delta_e_2000};

/// What becomes of a color outside of the gamut.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Gamut {
    /// Each channel is clipped by itself (eq. 7).
    #[default]
    Clip,
    /// Moved toward the display's neutral at constant luminance and CIELAB hue until it fits.
    Desaturate,
}

/// How much of an image is out of gamut, and how far.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GamutReport {
    /// All pixels, inside and outside.
    pub pixels: usize,
    /// Outside: darker than the display's black.
    pub too_dark: usize,
    /// Outside: brighter than its white.
    pub too_bright: usize,
    /// Outside: neither, but more saturated than its primaries allow at that luminance.
    pub too_saturated: usize,
    /// Mean over the pixels outside, between the color wanted and shown; 0 if there are none.
    pub mean_delta_e_2000: f64,
    /// Largest over the pixels outside; 0 if there are none.
    pub max_delta_e_2000: f64,
}

impl GamutReport {
    /// Pixels whose color the display does not have.
    pub fn outside(&self) -> usize {
        self.too_dark + self.too_bright + self.too_saturated
    }

    /// The report on two sets of pixels.
    pub fn merge(self, other: Self) -> Self {
        let outside = (self.outside() + other.outside()).max(1) as f64;
        let sum = |r: Self| r.mean_delta_e_2000 * r.outside() as f64;
        Self {
            pixels: self.pixels + other.pixels,
            too_dark: self.too_dark + other.too_dark,
            too_bright: self.too_bright + other.too_bright,
            too_saturated: self.too_saturated + other.too_saturated,
            mean_delta_e_2000: (sum(self) + sum(other)) / outside,
            max_delta_e_2000: self.max_delta_e_2000.max(other.max_delta_e_2000),
        }
    }
}

/// Rounding of eq. 7 that does not count as outside.
const TOLERANCE: f64 = 1e-9;

/// Brings colors into one display's gamut.
pub struct GamutMap<'a> {
    display: &'a Display,
    gamut: Gamut,
    white: Xyz,
    black: Xyz,
    /// Light of each channel at digit 0 and at full.
    range: [[f64; 2]; 3],
}

impl<'a> GamutMap<'a> {
    /// Works out what the display can show.
    pub fn new(display: &'a Display, gamut: Gamut) -> Self {
        let black = display.xyz_from_digits([0.0; 3]);
        let range = [0, 1, 2].map(|c| [0.0, 1.0].map(|signal| display.light(c, signal)));
        Self { display, gamut, white: display.white(), black, range }
    }

    fn is_inside(&self, rgb: [f64; 3]) -> bool {
        let mut channels = rgb.iter().zip(self.range);
        channels.all(|(v, [low, high])| (low - TOLERANCE..=high + TOLERANCE).contains(v))
    }

    fn clip(&self, rgb: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|c| rgb[c].clamp(self.range[c][0], self.range[c][1]))
    }

    /// Light of the channels that the display has (NaN stays NaN), and whether the color was
    /// outside.
    pub fn map(&self, color: Xyz) -> ([f64; 3], GamutReport) {
        let rgb = self.display.linear_from_xyz(color);
        if self.is_inside(rgb) {
            return (self.clip(rgb), GamutReport { pixels: 1, ..Default::default() });
        }
        let mapped = match self.gamut {
            Gamut::Clip => self.clip(rgb),
            Gamut::Desaturate => self.desaturate(color),
        };
        (mapped, self.report(color, mapped))
    }

    fn report(&self, wanted: Xyz, rgb: [f64; 3]) -> GamutReport {
        let shown = self.display.xyz_from_linear(rgb);
        let [p, q] = [wanted, shown].map(|color| Lab::from_xyz(color, self.white));
        let delta = delta_e_2000(p, q);
        let too_bright = wanted.y > self.white.y;
        let too_dark = wanted.y < self.black.y;
        GamutReport {
            pixels: 1,
            too_dark: usize::from(too_dark),
            too_bright: usize::from(too_bright),
            too_saturated: usize::from(!too_dark && !too_bright),
            mean_delta_e_2000: delta,
            max_delta_e_2000: delta,
        }
    }

    /// The most saturated color of the same L* and hue that fits.
    fn desaturate(&self, color: Xyz) -> [f64; 3] {
        if color.y >= self.white.y {
            return self.range.map(|[_, high]| high);
        }
        let lab = Lab::from_xyz(color, self.white);
        let at = |share: f64| {
            let paler = Lab { l: lab.l, a: share * lab.a, b: share * lab.b };
            self.display.linear_from_xyz(paler.to_xyz(self.white))
        };
        let (mut fits, mut too_far) = (0.0, 1.0);
        // 40 halvings leave 1e-12 of the chroma.
        for _ in 0..40 {
            let middle = 0.5 * (fits + too_far);
            if self.is_inside(at(middle)) { fits = middle } else { too_far = middle }
        }
        self.clip(at(fits))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// UN R48 red at half of white's luminance share of the red primary.
    fn signal_red(luminance: f64) -> Xyz {
        Xyz::from_xy([0.69, 0.309], luminance)
    }

    fn lab(display: &Display, rgb: [f64; 3]) -> Lab {
        Lab::from_xyz(display.xyz_from_linear(rgb), display.white())
    }

    #[test]
    fn desaturate_keeps_luminance_and_hue() {
        for display in [Display::srgb(), Display::eizo_t766()] {
            let map = GamutMap::new(&display, Gamut::Desaturate);
            for luminance in [3.0, 10.0, 30.0, 60.0] {
                let wanted = signal_red(luminance);
                let (rgb, report) = map.map(wanted);
                assert_eq!(report.too_saturated, 1);
                let (p, q) = (Lab::from_xyz(wanted, display.white()), lab(&display, rgb));
                // The bisection's tolerance of 1e-9 in rgb.
                assert!((p.l - q.l).abs() < 1e-5, "{p:?} {q:?}");
                assert!((p.b.atan2(p.a) - q.b.atan2(q.a)).abs() < 1e-6, "{p:?} {q:?}");
                // It stops at the gamut's surface.
                let inner = map.range.map(|[low, high]| low + 1e-6..=high - 1e-6);
                let at_surface = inner.iter().zip(rgb).any(|(inner, v)| !inner.contains(&v));
                assert!(at_surface && q.chroma() < p.chroma(), "{rgb:?}");
            }
        }
    }

    #[test]
    fn clip_cuts_each_channel() {
        let display = Display::srgb();
        let wanted = signal_red(10.0);
        let before = display.linear_from_xyz(wanted);
        let (rgb, report) = GamutMap::new(&display, Gamut::Clip).map(wanted);
        assert_eq!(rgb, [before[0], 0.0, 0.0]);
        assert!(report.max_delta_e_2000 > 1.0);
    }

    #[test]
    fn inside_is_untouched_and_not_counted() {
        let display = Display::eizo_t766();
        for gamut in [Gamut::Clip, Gamut::Desaturate] {
            let map = GamutMap::new(&display, gamut);
            let (rgb, report) = map.map(display.white());
            assert!(rgb.iter().all(|v| (v - 1.0).abs() < 1e-9));
            assert_eq!((report.pixels, report.outside()), (1, 0));
        }
    }

    #[test]
    fn too_dark_and_too_bright_are_told_apart() {
        let display = Display::eizo_t766();
        for gamut in [Gamut::Clip, Gamut::Desaturate] {
            let map = GamutMap::new(&display, gamut);
            let (rgb, report) = map.map(Xyz::default());
            assert_eq!(display.digits_from_linear(rgb), Some([0; 3]));
            assert_eq!(report.too_dark, 1);
            let (rgb, report) = map.map(display.white() * 5.0);
            assert_eq!(display.digits_from_linear(rgb), Some([255; 3]));
            assert_eq!(report.too_bright, 1);
        }
    }

    #[test]
    fn reports_add_up() {
        let a = GamutReport {
            pixels: 3,
            too_dark: 1,
            mean_delta_e_2000: 2.0,
            max_delta_e_2000: 2.0,
            ..Default::default()
        };
        let b = GamutReport {
            pixels: 4,
            too_saturated: 3,
            mean_delta_e_2000: 6.0,
            max_delta_e_2000: 9.0,
            ..Default::default()
        };
        let sum = a.merge(b);
        assert_eq!((sum.pixels, sum.outside()), (7, 4));
        assert_eq!((sum.mean_delta_e_2000, sum.max_delta_e_2000), (5.0, 9.0));
        assert_eq!(GamutReport::default().merge(GamutReport::default()), GamutReport::default());
    }
}
