//! Colors to spectra: three fixed, smooth, non-negative spectra of a gamut's primaries, mixed as the
//! color says.
//!
//! Since the mix is linear it keeps energy, and gives the same XYZ back as exactly as the three
//! spectra have their primaries' colors. Neutral colors come out close to D65.
//!
//! The spectra are D65 times factors t_r, t_g, t_b ≥ 0 at the 5 nm bands, which minimize
//!
//!   Σ |second differences of t_i|² + w Σ (t_r + t_g + t_b − 1)² + p Σ |XYZ(D65 t_i) − XYZ_i|²,
//!
//! found once, when they are first asked for.

use std::sync::LazyLock;

use glam::{DMat3, DVec3};
use nalgebra::{DMatrix, DVector};

use super::{D65_XY, P3_XY, REC709_XY, Xyz, xyz_from_primaries};
use crate::spectrum::{Spectrum, WavelengthGrid, cie};

/// Which triangle of chromaticities colors lie in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColorGamut {
    /// The smoother spectra.
    Rec709,
    /// Primaries of Display P3.
    P3,
}

/// Three spectra, and how colors are mixed from them.
#[derive(Debug)]
pub struct Upsampling {
    rgb_from_xyz: DMat3,
    /// Y of the primaries; they sum to 1.
    luminances: [f64; 3],
    /// Spectra of the primaries, relative.
    pub spectra: [Spectrum; 3],
}

static REC709: LazyLock<Upsampling> = LazyLock::new(|| Upsampling::new(REC709_XY));
static P3: LazyLock<Upsampling> = LazyLock::new(|| Upsampling::new(P3_XY));

impl Upsampling {
    /// The mixing for a gamut's primaries, computed once.
    pub fn of(gamut: ColorGamut) -> &'static Upsampling {
        match gamut {
            ColorGamut::Rec709 => &REC709,
            ColorGamut::P3 => &P3,
        }
    }

    fn new(primaries: [[f64; 2]; 3]) -> Upsampling {
        let xyz_from_rgb = xyz_from_primaries(primaries, D65_XY);
        let d65 = cie::illuminant("D65").unwrap_or_else(|| Spectrum::constant(1.0));
        let factors = smooth_factors(&d65, &xyz_from_rgb);
        let grid = WavelengthGrid::Step5;
        let spectrum = |at: usize| {
            let rows = grid.wavelengths_nm().enumerate();
            let rows = rows.map(|(band, l)| (l, d65.at(l) * factors[at * grid.bands() + band]));
            Spectrum::from_pairs("upsampling", rows).unwrap_or_else(|_| d65.clone())
        };
        Upsampling {
            rgb_from_xyz: xyz_from_rgb.inverse(),
            luminances: [0, 1, 2].map(|at| xyz_from_rgb.col(at).y),
            spectra: [0, 1, 2].map(spectrum),
        }
    }

    /// The smoothest mixing that holds all `colors`, or P3's, and how many it does not hold.
    pub fn holding(colors: impl Iterator<Item = Xyz> + Clone) -> (&'static Upsampling, usize) {
        let [rec709, p3] = [ColorGamut::Rec709, ColorGamut::P3].map(Upsampling::of);
        if colors.clone().all(|color| rec709.holds(color)) {
            return (rec709, 0);
        }
        (p3, colors.filter(|color| !p3.holds(*color)).count())
    }

    /// A primary's spectrum at the bands of `grid`, with a luminance of 1.
    pub fn bands(&self, primary: usize, grid: WavelengthGrid) -> Vec<f64> {
        let spectrum = &self.spectra[primary];
        spectrum.scaled(spectrum.luminous_flux(grid).recip()).on_grid(grid)
    }

    /// Whether the color has no negative part, but for rounding.
    pub fn holds(&self, color: Xyz) -> bool {
        let rgb = self.rgb_from_xyz * DVec3::from(color);
        rgb.min_element() >= -1e-4 * rgb.abs().max_element()
    }

    /// Luminances of the spectra whose mix has this color. A color outside of the gamut is paled to
    /// its border, at the same luminance.
    pub fn mix(&self, color: Xyz) -> [f64; 3] {
        let rgb = self.rgb_from_xyz * DVec3::from(color);
        let gray = color.y.max(0.0);
        let least = rgb.min_element();
        let kept = if least < 0.0 { gray / (gray - least) } else { 1.0 };
        let inside = (gray + (rgb - gray) * kept).max(DVec3::ZERO);
        [0, 1, 2].map(|at| inside[at] * self.luminances[at])
    }

    /// The mix as a spectrum, per nm: its luminous integral is the sum of `luminances`.
    pub fn spectrum(&self, luminances: [f64; 3]) -> Spectrum {
        let part = |at: usize| {
            let spectrum = &self.spectra[at];
            spectrum.scaled(luminances[at] / spectrum.luminous_flux(WavelengthGrid::Step5))
        };
        part(0).sum(&part(1)).sum(&part(2))
    }
}

/// t_r, t_g, t_b, one after the other.
///
/// A primal–dual active set: bands that would be negative are held at 0 until the gradient there
/// says that they should not be.
fn smooth_factors(white: &Spectrum, xyz_from_rgb: &DMat3) -> Vec<f64> {
    let (matrix, right) = quadratic(white, xyz_from_rgb);
    let count = right.len();
    let mut is_held = vec![false; count];
    let mut factors = DVector::zeros(count);
    // It settles in less than 20 rounds.
    for _ in 0..60 {
        let (mut reduced, mut free) = (matrix.clone(), right.clone());
        for at in (0..count).filter(|at| is_held[*at]) {
            reduced.row_mut(at).fill(0.0);
            reduced.column_mut(at).fill(0.0);
            reduced[(at, at)] = 1.0;
            free[at] = 0.0;
        }
        let Some(solver) = reduced.cholesky() else { break };
        factors = solver.solve(&free);
        let gradient = &matrix * &factors - &right;
        let held = |at: usize| if is_held[at] { gradient[at] > 0.0 } else { factors[at] < 0.0 };
        let now: Vec<bool> = (0..count).map(held).collect();
        if now == is_held {
            break;
        }
        is_held = now;
    }
    factors.iter().map(|value| value.max(0.0)).collect()
}

/// Matrix and right side of the sum of squares.
fn quadratic(white: &Spectrum, xyz_from_rgb: &DMat3) -> (DMatrix<f64>, DVector<f64>) {
    /// Weight of the sum of the three against 1.
    const WHITENESS: f64 = 0.02;
    /// Weight of a color's error, white having Y = 1: what is left is below 1e-4.
    const COLOR: f64 = 1e6;
    let grid = WavelengthGrid::Step5;
    let bands = grid.bands();
    let white_bands = white.on_grid(grid);
    let luminance: f64 =
        white_bands.iter().enumerate().map(|(b, value)| value * cie::cmf(grid, b)[1]).sum();
    let weight = |band: usize| cie::cmf(grid, band).map(|c| c * white_bands[band] / luminance);
    let mut matrix = DMatrix::zeros(3 * bands, 3 * bands);
    let mut right = DVector::zeros(3 * bands);
    for color in 0..3 {
        let first = color * bands;
        for band in 1..bands - 1 {
            let stencil = [(band - 1, 1.0), (band, -2.0), (band + 1, 1.0)];
            for (a, u) in stencil {
                stencil.iter().for_each(|(b, v)| matrix[(first + a, first + b)] += u * v);
            }
        }
        let target = xyz_from_rgb.col(color);
        for a in 0..bands {
            let of_a = DVec3::from(weight(a));
            right[first + a] += COLOR * of_a.dot(target) + WHITENESS;
            for b in 0..bands {
                matrix[(first + a, first + b)] += COLOR * of_a.dot(DVec3::from(weight(b)));
            }
            for other in 0..3 {
                matrix[(first + a, other * bands + a)] += WHITENESS;
            }
        }
    }
    (matrix, right)
}

/// How far colors are from themselves after the round trip to spectra and back under D65: mean and
/// largest ΔE00 over an even grid of a gamut's encoded colors, `steps` a side.
pub fn round_trip(gamut: ColorGamut, steps: usize) -> [f64; 2] {
    let primaries = match gamut {
        ColorGamut::Rec709 => REC709_XY,
        ColorGamut::P3 => P3_XY,
    };
    let xyz_from_rgb = xyz_from_primaries(primaries, D65_XY);
    let white = Xyz::from_xy(D65_XY, 1.0);
    let level = |at: usize| super::srgb_decode(at as f64 / (steps - 1) as f64);
    let (mut sum, mut largest, mut count) = (0.0, 0.0f64, 0);
    for at in 0..steps.pow(3) {
        let rgb =
            DVec3::new(level(at % steps), level(at / steps % steps), level(at / (steps * steps)));
        let color = Xyz::from(xyz_from_rgb * rgb);
        // A picture takes one set of spectra for all of its colors.
        let upsampling = Upsampling::of(gamut);
        let back = upsampling.spectrum(upsampling.mix(color)).xyz();
        let lab = |xyz: Xyz| super::Lab::from_xyz(xyz, white);
        let difference = super::delta_e_2000(lab(color), lab(back));
        sum += difference;
        largest = largest.max(difference);
        count += 1;
    }
    [sum / f64::from(count), largest]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colors_come_back() {
        let [mean, largest] = round_trip(ColorGamut::Rec709, 9);
        assert!(mean < 1e-3 && largest < 0.01, "{mean} {largest}");
        // P3's red has x + y = 1, which no spectrum reaches.
        let [mean, largest] = round_trip(ColorGamut::P3, 9);
        assert!(mean < 0.01 && largest < 0.2, "{mean} {largest}");
    }

    /// P3's red takes what is longer than 595 nm, its green what is shorter than 580: white lacks
    /// some of what is between.
    #[test]
    fn spectra_are_smooth_and_white_is_daylight() {
        let d65 = cie::illuminant("D65").unwrap();
        for (gamut, steepest, from_white) in
            [(ColorGamut::Rec709, 0.25, 0.2), (ColorGamut::P3, 0.6, 0.7)]
        {
            let upsampling = Upsampling::of(gamut);
            let factor = |s: &Spectrum, l: f64| s.at(l) / d65.at(l);
            for spectrum in &upsampling.spectra {
                assert!(spectrum.min() >= 0.0);
                for l in WavelengthGrid::Step5.wavelengths_nm().skip(1) {
                    let step = factor(spectrum, l) - factor(spectrum, l - 5.0);
                    assert!(step.abs() < steepest, "{gamut:?} at {l} nm: {step}");
                }
            }
            for l in WavelengthGrid::Step5.wavelengths_nm() {
                let sum: f64 = upsampling.spectra.iter().map(|s| factor(s, l)).sum();
                assert!((sum - 1.0).abs() < from_white, "{gamut:?} at {l} nm: {sum}");
            }
        }
    }

    #[test]
    fn colors_outside_keep_their_luminance() {
        let upsampling = Upsampling::of(ColorGamut::Rec709);
        let laser = Xyz::new(0.3, 0.5, 0.0);
        assert!(!upsampling.holds(laser) && upsampling.holds(Xyz::from_xy(D65_XY, 3.0)));
        let mix = upsampling.mix(laser);
        assert!(mix.iter().all(|value| *value >= 0.0));
        assert!((mix.iter().sum::<f64>() - 0.5).abs() < 1e-12);
        assert_eq!(upsampling.mix(Xyz::default()), [0.0; 3]);
    }
}
