//! The glare that a bright lamp makes in the eye.
//!
//! Source: the CIE total glare function, Vos & van den Berg, "Report on disability glare", CIE
//! Collection 135, 1999. It integrates to a few percent more than 1 over the hemisphere (1.005 at
//! age 20 and no pigment, 1.12 at 70 and 1); here it is divided by its integral, so that glare
//! moves light about without making any.

use std::f64::consts::PI;

use super::convolve::{Convolver, Kernel};
use crate::color::Xyz;
use crate::error::{Error, Result};
use crate::image::XyzImage;
use crate::statistics::percentile;

/// Whose eye, and how much of its glare.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Glare {
    /// Years, 0 to 120.
    pub age: f64,
    /// Iris: 0 black-brown, 0.5 brown, 1 blue-green, 1.2 very light.
    pub pigment: f64,
    /// 0 none, 1 the eye's.
    pub strength: f64,
}

impl Default for Glare {
    fn default() -> Self {
        Self { age: 25.0, pigment: 0.5, strength: 1.0 }
    }
}

impl Glare {
    fn check(&self) -> Result<()> {
        let checks = [
            ("age", self.age, 0.0..=120.0, "0 to 120 years"),
            ("pigment", self.pigment, 0.0..=1.2, "0 to 1.2"),
            ("strength", self.strength, 0.0..=1.0, "0 to 1"),
        ];
        match checks.iter().find(|(_, value, range, _)| !range.contains(value)) {
            None => Ok(()),
            Some((what, value, _, allowed)) => {
                Err(Error::out_of_range("glare", what, value, *allowed))
            }
        }
    }

    /// Veiling luminance (cd/m²) for an illuminance at the eye of 1 lx, at `theta_deg` from its
    /// source, as published, before normalization.
    ///
    /// Unit: sr⁻¹. Range: 0° to 90°.
    pub fn point_spread(&self, theta_deg: f64) -> f64 {
        let age_4 = (self.age / 70.0).powi(4);
        // 1 + (θ/width)².
        let widened = |width: f64| 1.0 + (theta_deg / width).powi(2);
        // x^1.5 by operations that round the same on every machine.
        let power_1_5 = |x: f64| x * x.sqrt();
        let core = 9.2e6 / power_1_5(widened(0.0046)) + 1.5e5 / power_1_5(widened(0.045));
        let skirt = 400.0 / widened(0.1) + 3e-8 * theta_deg * theta_deg;
        let iris = 1300.0 / power_1_5(widened(0.1)) + 0.8 / widened(0.1).sqrt();
        (1.0 - 0.08 * age_4) * core
            + (1.0 + 1.6 * age_4) * (skirt + self.pigment * iris)
            + 2.5e-3 * self.pigment
    }

    /// ∫ PSF dΩ over the hemisphere before the eye.
    pub fn integral(&self) -> f64 {
        let ring = |theta: f64| self.point_spread(theta.to_degrees()) * 2.0 * PI * theta.sin();
        // From a hundredth of the core's width on, in steps of a twentieth.
        let (first, ratio): (f64, f64) = (4e-5f64.to_radians(), 1.05);
        let steps = ((0.5 * PI / first).ln() / ratio.ln()).ceil() as i32;
        let edge = |step: i32| if step == steps { 0.5 * PI } else { first * ratio.powi(step) };
        gauss(0.0, first, ring)
            + (0..steps).map(|step| gauss(edge(step), edge(step + 1), ring)).sum::<f64>()
    }
}

/// What became of the light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GlareReport {
    /// Share of the image's luminance that is scattered out of the frame, 0 to 1.
    pub lost_share: f64,
}

/// `image` as an eye sees it whose view of it is `fov_deg` high.
///
/// The point-spread is taken at the angles of a source in the middle of the image. Light that it
/// sends out of the frame is counted and gone; from beyond comes that of a field as bright as the
/// border mostly is (by its medians), so that a background does not darken toward the border.
/// Errors: [`Error::OutOfRange`] for an age, pigment, strength or field of view that no eye has; a
/// pixel that is not finite, named.
pub fn apply_glare(
    image: &XyzImage,
    fov_deg: f64,
    glare: &Glare,
) -> Result<(XyzImage, GlareReport)> {
    glare.check()?;
    if !(fov_deg > 0.0 && fov_deg < 180.0) {
        let allowed = "above 0 and below 180 degrees";
        return Err(Error::out_of_range("glare", "field of view", fov_deg, allowed));
    }
    image.check_finite()?;
    if image.pixels.is_empty() {
        return Ok((image.clone(), GlareReport { lost_share: 0.0 }));
    }
    let convolver = Convolver::new(&glare_kernel(image, fov_deg, glare));
    let [x, y, z] = [0, 1, 2].map(|c| {
        let plane: Vec<f64> =
            image.pixels.iter().map(|&color| <[f64; 3]>::from(color)[c]).collect();
        convolver.apply(&plane)
    });
    let pixels = x.iter().zip(&y).zip(&z).map(|((&x, &y), &z)| Xyz::new(x, y, z)).collect();
    let mut seen = XyzImage { width: image.width, height: image.height, pixels };
    let luminance = |image: &XyzImage| image.pixels.iter().map(|c| c.y).sum::<f64>();
    let (before, after) = (luminance(image), luminance(&seen));
    let lost_share = if before > 0.0 { 1.0 - after / before } else { 0.0 };
    add_from_beyond(&mut seen, border(image), &convolver);
    Ok((seen, GlareReport { lost_share }))
}

/// Light from a field beyond the frame: of a field that goes on, a pixel gets as much as it sends
/// away, so what is missing from within comes from beyond.
fn add_from_beyond(seen: &mut XyzImage, beyond: Xyz, convolver: &Convolver) {
    if beyond == Xyz::default() {
        return;
    }
    let from_within = convolver.apply(&vec![1.0; seen.pixels.len()]);
    for (pixel, within) in seen.pixels.iter_mut().zip(from_within) {
        *pixel = *pixel + beyond * (1.0 - within).max(0.0);
    }
}

/// Medians of the pixels along the frame: a lamp that is cut off does not go on.
fn border(image: &XyzImage) -> Xyz {
    let (width, height) = (image.width, image.height);
    let is_border = |at: usize| {
        let (x, y) = (at % width, at / width);
        x == 0 || y == 0 || x + 1 == width || y + 1 == height
    };
    let pixels: Vec<[f64; 3]> = (0..image.pixels.len())
        .filter(|&at| is_border(at))
        .map(|at| image.pixels[at].into())
        .collect();
    let median = |c: usize| {
        let mut values: Vec<f64> = pixels.iter().map(|pixel| pixel[c]).collect();
        percentile(&mut values, 50.0).unwrap_or(0.0)
    };
    Xyz::new(median(0), median(1), median(2))
}

/// Light that a pixel sends to the pixels around it, one quadrant.
fn glare_kernel(image: &XyzImage, fov_deg: f64, glare: &Glare) -> Kernel {
    let cell = PixelSquare {
        glare,
        pitch: 2.0 * (0.5 * fov_deg).to_radians().tan() / image.height as f64,
        share: glare.strength / glare.integral(),
    };
    let mut kernel =
        Kernel::from_fn(image.width, image.height, |dx, dy| cell.pixel(dx as f64, dy as f64));
    kernel.quadrant[0] += 1.0 - glare.strength;
    kernel
}

/// Integrates the point-spread over squares of the image plane, in pixels from the source.
struct PixelSquare<'a> {
    glare: &'a Glare,
    /// Side of a pixel where the image plane is at distance 1.
    pitch: f64,
    share: f64,
}

impl PixelSquare<'_> {
    fn pixel(&self, dx: f64, dy: f64) -> f64 {
        if (dx, dy) == (0.0, 0.0) {
            return 4.0 * self.square(0.0, 0.0, 0.5);
        }
        self.square(dx - 0.5, dy - 0.5, 1.0)
    }

    /// ∫ PSF dΩ over a square that begins at (x, y).
    ///
    /// The core is narrower than a pixel: squares are quartered until they are small beside their
    /// distance from the source, or beside the core.
    fn square(&self, x: f64, y: f64, size: f64) -> f64 {
        // Of [x, x + size] the point nearest to 0.
        let nearest = |start: f64| start.max(0.0) + (start + size).min(0.0);
        let distance = nearest(x).hypot(nearest(y)) * self.pitch;
        let core = 0.5 * 0.0046f64.to_radians();
        if size * self.pitch > 0.5 * distance.max(core) {
            let half = 0.5 * size;
            let quarters = [(x, y), (x + half, y), (x, y + half), (x + half, y + half)];
            return quarters.iter().map(|&(x, y)| self.square(x, y, half)).sum();
        }
        let density = |x: f64, y: f64| self.density(x.hypot(y) * self.pitch);
        gauss(y, y + size, |y| gauss(x, x + size, |x| density(x, y)))
    }

    /// PSF dΩ/dA at a distance from the source on the image plane, per square pixel.
    fn density(&self, tangent: f64) -> f64 {
        // dΩ = cos³θ dA at distance 1.
        let cos = 1.0 / (1.0 + tangent * tangent).sqrt();
        let spread = self.glare.point_spread(tangent.atan().to_degrees());
        spread * cos * cos * cos * self.pitch * self.pitch * self.share
    }
}

/// ∫ f by Gauss's four points.
fn gauss(from: f64, to: f64, f: impl Fn(f64) -> f64) -> f64 {
    const POINTS: [(f64, f64); 4] = [
        (-0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
        (-0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
        (0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
        (0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
    ];
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    POINTS.iter().map(|(point, weight)| weight * f(middle + half * point)).sum::<f64>() * half
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integrals_are_the_published_functions() {
        // Quadrature beside the project: age 20: 1.005, 1.031, 1.058; age 70: 1.011, 1.066, 1.122.
        for (age, expected) in [(20.0, [1.005, 1.031, 1.058]), (70.0, [1.011, 1.066, 1.122])] {
            for (pigment, value) in [0.0, 0.5, 1.0].into_iter().zip(expected) {
                let integral = Glare { age, pigment, strength: 1.0 }.integral();
                assert!((integral - value).abs() < 6e-4, "{age} {pigment}: {integral}");
            }
        }
    }

    /// CIE 146:2002, general disability glare equation, 0.1° to 100°: an approximation by other
    /// terms, which stays within half of the total function.
    #[test]
    fn veil_agrees_with_the_general_equation() {
        for (age, pigment) in [(25.0f64, 0.5), (70.0, 0.0), (40.0, 1.2)] {
            let glare = Glare { age, pigment, strength: 1.0 };
            for theta in [0.3f64, 1.0, 3.0, 10.0, 30.0, 60.0] {
                let general = 10.0 / theta.powi(3)
                    + (5.0 / theta.powi(2) + 0.1 * pigment / theta) * (1.0 + (age / 62.5).powi(4))
                    + 0.0025 * pigment;
                let ratio = glare.point_spread(theta) / general;
                assert!((0.75..1.5).contains(&ratio), "{age} {pigment} {theta}°: {ratio}");
            }
        }
    }

    fn point(width: usize, height: usize, at: [usize; 2]) -> XyzImage {
        let mut pixels = vec![Xyz::default(); width * height];
        pixels[at[1] * width + at[0]] = Xyz::new(2.0, 1.0, 0.5);
        XyzImage { width, height, pixels }
    }

    /// The share of a point's light within a square around it, by rings: independent of the cells
    /// and their quartering.
    fn share_in_square(glare: &Glare, half_width: f64) -> f64 {
        let eighth = |phi: f64| {
            let end = (half_width / phi.cos()).atan();
            let ring = |t: f64| {
                let theta = t.exp();
                glare.point_spread(theta.to_degrees()) * theta.sin() * theta
            };
            let (start, steps) = (1e-7f64.ln(), 400);
            let step = (end.ln() - start) / f64::from(steps);
            let edge = |i: i32| start + step * f64::from(i);
            (0..steps).map(|i| gauss(edge(i), edge(i + 1), ring)).sum::<f64>()
        };
        let steps = 16;
        let edge = |i: i32| 0.25 * PI * f64::from(i) / f64::from(steps);
        let sum: f64 = (0..steps).map(|i| gauss(edge(i), edge(i + 1), eighth)).sum();
        8.0 * sum / glare.integral()
    }

    #[test]
    fn energy_is_kept_to_what_leaves_the_frame() {
        for fov_deg in [0.05, 1.0, 6.0, 60.0, 150.0] {
            for glare in [Glare::default(), Glare { age: 70.0, pigment: 1.2, strength: 1.0 }] {
                let (seen, report) =
                    apply_glare(&point(31, 31, [15, 15]), fov_deg, &glare).unwrap();
                let half_width = (0.5 * fov_deg).to_radians().tan();
                let inside = share_in_square(&glare, half_width);
                let error = (1.0 - report.lost_share) - inside;
                assert!(error.abs() < 1e-6, "{fov_deg}°: {error}");
                let sum: f64 = seen.pixels.iter().map(|c| c.z).sum();
                assert!((sum - 0.5 * inside).abs() < 1e-6, "{fov_deg}°: {sum}");
            }
        }
    }

    #[test]
    fn spread_is_symmetric_and_falls() {
        let glare = Glare::default();
        let (seen, _) = apply_glare(&point(15, 9, [7, 4]), 2.0, &glare).unwrap();
        let at = |x: usize, y: usize| seen.pixels[y * 15 + x].y;
        for d in 1..5 {
            assert!(at(7 + d, 4) < at(6 + d, 4));
            // FFT rounding, relative to the peak.
            for other in [at(7 - d, 4), at(7, 4 + d), at(7, 4 - d)] {
                assert!((at(7 + d, 4) - other).abs() < 1e-14);
            }
        }
        // Far from the source a pixel gets density times area.
        let pitch = 2.0 * 1f64.to_radians().tan() / 9.0;
        let density = glare.point_spread((4.0 * pitch).atan().to_degrees()) / glare.integral();
        let ratio = at(11, 4) / (density * pitch * pitch);
        // The spread is convex over the pixel, hence 1.5 % more than in its middle.
        assert!((1.0..1.05).contains(&ratio), "{ratio}");
    }

    #[test]
    fn an_even_field_stays_even() {
        let field = Xyz::new(2.0, 3.0, 0.5);
        let image = XyzImage { width: 23, height: 11, pixels: vec![field; 23 * 11] };
        for fov_deg in [0.5, 20.0] {
            let (seen, report) = apply_glare(&image, fov_deg, &Glare::default()).unwrap();
            for pixel in &seen.pixels {
                // FFT rounding.
                assert!(
                    (pixel.y - 3.0).abs() < 1e-12 && (pixel.z - 0.5).abs() < 1e-12,
                    "{pixel:?}"
                );
            }
            assert!(report.lost_share > 0.0);
        }
    }

    #[test]
    fn corners_do_not_wrap_around() {
        let (seen, _) = apply_glare(&point(16, 16, [0, 0]), 4.0, &Glare::default()).unwrap();
        let far = seen.pixels[15 * 16 + 15].y;
        let beside = seen.pixels[1].y;
        assert!(far > 0.0 && far < 1e-2 * beside, "{far} {beside}");
    }

    #[test]
    fn strength_mixes_and_nothing_is_changed_without_it() {
        let image = point(8, 5, [3, 2]);
        let with = |strength| {
            apply_glare(&image, 3.0, &Glare { strength, ..Default::default() }).unwrap().0
        };
        let [none, half, full] = [with(0.0), with(0.5), with(1.0)];
        for (at, original) in image.pixels.iter().enumerate() {
            assert!((none.pixels[at].y - original.y).abs() < 1e-15);
            let mixed = 0.5 * (original.y + full.pixels[at].y);
            assert!((half.pixels[at].y - mixed).abs() < 1e-15);
        }
    }

    #[test]
    fn empty_black_and_bad() {
        let empty = XyzImage { width: 0, height: 0, pixels: vec![] };
        assert!(apply_glare(&empty, 6.0, &Glare::default()).is_ok());
        let black = XyzImage { width: 1, height: 1, pixels: vec![Xyz::default()] };
        let (seen, report) = apply_glare(&black, 6.0, &Glare::default()).unwrap();
        assert_eq!((seen, report.lost_share), (black.clone(), 0.0));
        let message = |fov, glare: Glare| apply_glare(&black, fov, &glare).unwrap_err().to_string();
        assert_eq!(
            message(6.0, Glare { age: 200.0, ..Default::default() }),
            "glare: age is 200, allowed: 0 to 120 years"
        );
        assert_eq!(
            message(180.0, Glare::default()),
            "glare: field of view is 180, allowed: above 0 and below 180 degrees"
        );
        assert!(message(6.0, Glare { pigment: f64::NAN, ..Default::default() }).contains("NaN"));
    }
}
