//! From a pixel to a ray.

use std::fmt;
use std::str::FromStr;

use crate::geometry::{DVec3, Ray};

/// A pinhole camera that turns about its target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Turns the eye about +Y; 0 is the front view, positive toward +X.
    pub azimuth_deg: f64,
    /// Lifts the eye toward +Y.
    pub elevation_deg: f64,
    /// Distance from eye to target, > 0.
    pub distance_mm: f64,
    /// What the camera looks at, mm; it is in the middle of the picture.
    pub target: DVec3,
    /// Full vertical angle, 0 to 180, both excluded.
    pub fov_deg: f64,
    /// Pixels of a row.
    pub width: usize,
    /// Rows of pixels.
    pub height: usize,
}

/// Turns image positions into rays: the camera's axes, and half the image plane's extent at unit distance.
#[derive(Debug, Clone, Copy)]
pub struct Camera {
    eye: DVec3,
    forward: DVec3,
    right: DVec3,
    up: DVec3,
    tan_half_fov: f64,
    size: [f64; 2],
}

impl View {
    /// From 3 m before the origin, 6° high, 640 × 480 pixels: what a script gets that says nothing.
    pub const FRONT: Self = Self {
        azimuth_deg: 0.0,
        elevation_deg: 0.0,
        distance_mm: 3000.0,
        target: DVec3::ZERO,
        fov_deg: 6.0,
        width: 640,
        height: 480,
    };

    /// Eye and axes: model.md, "camera".
    pub fn camera(&self) -> Camera {
        let (sin_a, cos_a) = self.azimuth_deg.to_radians().sin_cos();
        let (sin_e, cos_e) = self.elevation_deg.to_radians().sin_cos();
        let backward = DVec3::new(sin_a * cos_e, sin_e, cos_a * cos_e);
        let right = DVec3::new(cos_a, 0.0, -sin_a);
        Camera {
            eye: self.target + self.distance_mm * backward,
            forward: -backward,
            right,
            up: right.cross(-backward),
            tan_half_fov: (0.5 * self.fov_deg.to_radians()).tan(),
            size: [self.width as f64, self.height as f64],
        }
    }

    /// Number of pixels.
    pub fn pixels(&self) -> usize {
        self.width * self.height
    }
}

impl Default for View {
    fn default() -> Self {
        Self::FRONT
    }
}

impl fmt::Display for View {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { azimuth_deg, elevation_deg, distance_mm, target, fov_deg, width, height } = self;
        write!(
            f,
            "azimuth {azimuth_deg}°, elevation {elevation_deg}°, {distance_mm} mm from {target}, \
             fov {fov_deg}°, {width} × {height}"
        )
    }
}

/// Text that is no view; see [`View`]'s `Display`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NotAView;

impl FromStr for View {
    type Err = NotAView;

    /// Reads what `Display` writes, exactly.
    fn from_str(text: &str) -> Result<Self, NotAView> {
        let number = |text: &str| text.trim().parse::<f64>().map_err(|_| NotAView);
        let count = |text: &str| text.trim().parse::<usize>().map_err(|_| NotAView);
        let (azimuth, rest) = between(text, "azimuth ", "°, elevation ")?;
        let (elevation, rest) = rest.split_once("°, ").ok_or(NotAView)?;
        let (distance, rest) = rest.split_once(" mm from [").ok_or(NotAView)?;
        let (target, rest) = rest.split_once("], fov ").ok_or(NotAView)?;
        let (fov, size) = rest.split_once("°, ").ok_or(NotAView)?;
        let (width, height) = size.split_once(" × ").ok_or(NotAView)?;
        let target: Vec<f64> = target.split(',').map(number).collect::<Result<_, _>>()?;
        let [x, y, z] = target[..] else { return Err(NotAView) };
        Ok(Self {
            azimuth_deg: number(azimuth)?,
            elevation_deg: number(elevation)?,
            distance_mm: number(distance)?,
            target: DVec3::new(x, y, z),
            fov_deg: number(fov)?,
            width: count(width)?,
            height: count(height)?,
        })
    }
}

/// What stands between `start`, which begins the text, and `end`; and what follows.
fn between<'a>(text: &'a str, start: &str, end: &str) -> Result<(&'a str, &'a str), NotAView> {
    text.strip_prefix(start).and_then(|rest| rest.split_once(end)).ok_or(NotAView)
}

impl Camera {
    /// The ray through image position (x, y) in pixels, (0, 0) being the top left corner of the
    /// top left pixel.
    pub fn ray(&self, x: f64, y: f64) -> Ray {
        let [width, height] = self.size;
        // Square pixels: both axes scale with the height.
        let right = (2.0 * x - width) / height * self.tan_half_fov;
        let up = (height - 2.0 * y) / height * self.tan_half_fov;
        let direction = self.forward + right * self.right + up * self.up;
        Ray { origin: self.eye, direction: direction.normalize() }
    }

    /// Cosine of the angle between the ray through image position (x, y) and the view's axis.
    pub fn cos_to_axis(&self, x: f64, y: f64) -> f64 {
        self.ray(x, y).direction.dot(self.forward)
    }

    /// Solid angle of the pixel whose center is (x, y), sr.
    pub fn pixel_solid_angle_sr(&self, x: f64, y: f64) -> f64 {
        let side = 2.0 * self.tan_half_fov / self.size[1];
        let cos = self.cos_to_axis(x, y);
        side * side * cos.powi(3)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view() -> View {
        View {
            azimuth_deg: 0.0,
            elevation_deg: 0.0,
            distance_mm: 100.0,
            target: DVec3::ZERO,
            fov_deg: 90.0,
            width: 4,
            height: 2,
        }
    }

    #[test]
    fn text_reads_back_exactly() {
        let odd = View {
            azimuth_deg: -0.1,
            elevation_deg: 1e-17,
            distance_mm: 1.0 / 3.0,
            target: DVec3::new(-0.3, 1e300, 5.0),
            fov_deg: 6.800000000000001,
            ..view()
        };
        assert_eq!(odd.to_string().parse(), Ok(odd));
        for text in ["", "azimuth 1°, elevation 2°, 3 mm from [1, 2], fov 4°, 5 × 6"] {
            assert_eq!(text.parse::<View>(), Err(NotAView), "{text}");
        }
    }

    #[test]
    fn front_view_has_x_to_the_right_and_y_up() {
        let camera = view().camera();
        assert_eq!(camera.ray(2.0, 1.0).direction, DVec3::NEG_Z);
        let corner = camera.ray(4.0, 0.0).direction;
        assert!((corner / -corner.z - DVec3::new(2.0, 1.0, -1.0)).length() < 1e-15);
    }

    #[test]
    fn azimuth_turns_the_eye_toward_x_and_elevation_lifts_it() {
        let side = View { azimuth_deg: 90.0, ..view() }.camera();
        assert!((side.eye - DVec3::new(100.0, 0.0, 0.0)).length() < 1e-13);
        let above = View { elevation_deg: 90.0, ..view() }.camera();
        assert!((above.eye - DVec3::new(0.0, 100.0, 0.0)).length() < 1e-13);
        assert!((above.up - DVec3::NEG_Z).length() < 1e-15);
    }

    /// The solid angles of all pixels add up to the frustum's: 4 asin(ab / √((1+a²)(1+b²))).
    #[test]
    fn solid_angles_fill_the_frame() {
        let view = View { width: 400, height: 200, ..view() };
        let camera = view.camera();
        let sum: f64 = (0..view.pixels())
            .map(|p| {
                let (x, y) = (p % view.width, p / view.width);
                camera.pixel_solid_angle_sr(x as f64 + 0.5, y as f64 + 0.5)
            })
            .sum();
        let (a, b) = (2.0f64, 1.0f64);
        let exact = 4.0 * (a * b / ((1.0 + a * a) * (1.0 + b * b)).sqrt()).asin();
        // Midpoint rule: second order in the pixel's side, 1/200.
        assert!((sum / exact - 1.0).abs() < 2e-5, "{sum} {exact}");
    }
}
