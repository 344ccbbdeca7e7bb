//! Patches of the sphere of directions, in the coordinates of a latitude–longitude picture.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

/// Where a direction lies in the picture: u from 0 (left) to 1 (right), v from 0 (up) to 1 (down).
///
/// The middle of the picture is −Z, what the viewer of a lamp sees behind it; its right is +X.
pub(crate) fn place(direction: DVec3) -> [f64; 2] {
    let u = (-direction.x).atan2(direction.z) / TAU;
    let across = direction.x.hypot(direction.z);
    [u.rem_euclid(1.0), across.atan2(direction.y) / PI]
}

/// Unit direction of a place in the picture.
pub(crate) fn direction([u, v]: [f64; 2]) -> DVec3 {
    let (sin_theta, cos_theta) = (PI * v).sin_cos();
    let (sin_phi, cos_phi) = (TAU * u).sin_cos();
    DVec3::new(-sin_theta * sin_phi, cos_theta, sin_theta * cos_phi)
}

/// Columns and rows of even cells over the whole sphere.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Cells {
    pub columns: usize,
    pub rows: usize,
}

/// A rectangle of the picture, `low` to `high` in (u, v).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Patch {
    pub low: [f64; 2],
    pub high: [f64; 2],
}

impl Patch {
    pub const SPHERE: Patch = Patch { low: [0.0; 2], high: [1.0; 2] };

    pub fn center(&self) -> DVec3 {
        direction(self.middle())
    }

    fn middle(&self) -> [f64; 2] {
        [0, 1].map(|axis| 0.5 * (self.low[axis] + self.high[axis]))
    }

    fn extent(&self, axis: usize) -> f64 {
        self.high[axis] - self.low[axis]
    }

    /// Angles, rad: half of what it spans in longitude where it is widest, and in latitude.
    fn half_angles(&self) -> [f64; 2] {
        let (top, bottom) = (PI * self.low[1], PI * self.high[1]);
        let widest = PI / 2.0;
        let has_equator = top <= widest && bottom >= widest;
        let sine = if has_equator { 1.0 } else { top.sin().max(bottom.sin()) };
        [sine * PI * self.extent(0), 0.5 * PI * self.extent(1)]
    }

    /// Largest distance of a unit direction in it from that of its center.
    ///
    /// hav c = hav Δθ + sin θ₁ sin θ₂ hav Δφ, and hav x ≤ x²/4.
    pub fn radius(&self) -> f64 {
        let [across, down] = self.half_angles();
        across.hypot(down).min(2.0)
    }

    /// How many whole cells it spans each way, at least one.
    pub fn count(&self, cells: Cells) -> [usize; 2] {
        let along = |axis: usize, of: usize| (self.extent(axis) * of as f64).round().max(1.0);
        [along(0, cells.columns) as usize, along(1, cells.rows) as usize]
    }

    /// Cut in two across its longer side, between cells as long as it has several.
    pub fn halves(&self, cells: Cells) -> [Patch; 2] {
        let [columns, rows] = self.count(cells);
        let [across, down] = self.half_angles();
        let is_wide = match (columns > 1, rows > 1) {
            (true, false) => true,
            (false, true) => false,
            _ => across >= down,
        };
        let (axis, of) = if is_wide { (0, cells.columns) } else { (1, cells.rows) };
        let middle = self.middle()[axis];
        let cut = if self.extent(axis) * of as f64 > 1.5 {
            (middle * of as f64).round() / of as f64
        } else {
            middle
        };
        let (mut first, mut second) = (*self, *self);
        first.high[axis] = cut;
        second.low[axis] = cut;
        [first, second]
    }

    /// Cut into `count` parts each way.
    pub fn parts(self, count: [usize; 2]) -> impl Iterator<Item = Patch> {
        let at = move |axis: usize, i: usize| {
            self.low[axis] + self.extent(axis) * (i as f64 / count[axis] as f64)
        };
        (0..count[1]).flat_map(move |row| {
            (0..count[0]).map(move |column| Patch {
                low: [at(0, column), at(1, row)],
                high: [at(0, column + 1), at(1, row + 1)],
            })
        })
    }

    /// Spread of the directions in it; for patches much smaller than the sphere (the covariance is of
    /// second order in its size).
    pub fn spread(&self) -> DirectionSpread {
        Band::new(self).spread(self.middle()[0])
    }

    pub fn place(&self) -> [f64; 2] {
        self.middle()
    }
}

/// Solid angle, mean and covariance of the directions in a patch.
pub(crate) struct DirectionSpread {
    /// sr.
    pub solid_angle: f64,
    pub mean: DVec3,
    /// Their outer products sum to the covariance.
    pub axes: [DVec3; 2],
}

/// What patches of one size and height have in common.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Band {
    solid_angle: f64,
    /// Level and upward components of the mean direction, and of the axis along the meridian.
    mean: [f64; 2],
    along: [f64; 2],
    across: f64,
}

impl Band {
    pub fn new(patch: &Patch) -> Band {
        let (theta, a) = (PI * patch.middle()[1], 0.5 * PI * patch.extent(1));
        let phi_half = PI * patch.extent(0);
        let (sin_theta, cos_theta) = theta.sin_cos();
        // ∫ sin θ, ∫ sin² θ and ∫ sin θ cos θ over θ ± a.
        let area = 2.0 * sin_theta * a.sin();
        let sines = a - 0.5 * (2.0 * theta).cos() * (2.0 * a).sin();
        let cosines = 0.5 * (2.0 * theta).sin() * (2.0 * a).sin();
        // Standard deviation of an even spread.
        let even = |half: f64| half / 3f64.sqrt();
        Band {
            solid_angle: area * 2.0 * phi_half,
            mean: [sines / area * phi_half.sin() / phi_half, cosines / area],
            along: [cos_theta * even(a), -sin_theta * even(a)],
            across: sin_theta * even(phi_half),
        }
    }

    /// Spread of the patch whose middle is at longitude u.
    pub fn spread(&self, u: f64) -> DirectionSpread {
        let (sin, cos) = (TAU * u).sin_cos();
        self.spread_toward([sin, cos])
    }

    /// The same, with sine and cosine of the longitude.
    pub fn spread_toward(&self, [sin, cos]: [f64; 2]) -> DirectionSpread {
        let turned = |[level, up]: [f64; 2]| DVec3::new(-sin * level, up, cos * level);
        DirectionSpread {
            solid_angle: self.solid_angle,
            mean: turned(self.mean),
            axes: [turned(self.along), DVec3::new(-cos, 0.0, -sin) * self.across],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn place_and_direction_are_inverse() {
        for place_in in [[0.1, 0.3], [0.5, 0.5], [0.93, 0.8], [0.0, 0.01]] {
            let there = direction(place_in);
            let back = place(there);
            let error = (back[0] - place_in[0]).abs() + (back[1] - place_in[1]).abs();
            assert!(error < 1e-14, "{place_in:?} {back:?}");
        }
        assert!((direction([0.5, 0.5]) - DVec3::NEG_Z).length() < 1e-15);
        assert!((direction([0.75, 0.5]) - DVec3::X).length() < 1e-15, "right of the middle is +X");
        assert_eq!(direction([0.3, 0.0]).y, 1.0);
    }

    #[test]
    fn halves_meet_between_cells() {
        let cells = Cells { columns: 5, rows: 3 };
        let [left, right] = Patch::SPHERE.halves(cells);
        assert_eq!((left.high[0], right.low[0]), (0.6, 0.6));
        assert_eq!((left.low, right.high), ([0.0; 2], [1.0; 2]));
    }

    /// Solid angles sum to 4π, means to nothing, and mean squares to 1/3 each way.
    #[test]
    fn patches_fill_the_sphere() {
        let (mut area, mut mean, mut square) = (0.0, DVec3::ZERO, DVec3::ZERO);
        for patch in Patch::SPHERE.parts([72, 36]) {
            let spread = patch.spread();
            area += spread.solid_angle;
            mean += spread.mean * spread.solid_angle;
            let squares = spread.mean * spread.mean
                + spread.axes[0] * spread.axes[0]
                + spread.axes[1] * spread.axes[1];
            square += squares * spread.solid_angle;
        }
        assert!((area / (4.0 * PI) - 1.0).abs() < 1e-12);
        assert!(mean.length() < 1e-13);
        assert!((square / (4.0 * PI) - 1.0 / 3.0).abs().max_element() < 1e-5, "{square}");
    }

    #[test]
    fn radius_holds_the_patch() {
        for patch in Patch::SPHERE.parts([7, 5]) {
            let (center, radius) = (patch.center(), patch.radius());
            for part in patch.parts([9, 9]) {
                assert!(center.distance(part.center()) <= radius, "{patch:?}");
            }
        }
    }
}
