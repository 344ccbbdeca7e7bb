//! Intensity over horizontal and vertical angles.

use crate::color::Xyz;
use crate::error::{Error, Result};

/// A direction in the lamp's frame, as regulations give it.
///
/// (sin h cos v, sin v, cos h cos v): `h_deg` turns about the lamp's vertical axis (a view's
/// azimuth), `v_deg` lifts (its elevation). Goniometers with this polar axis are of type A.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Direction {
    /// Turned about the lamp's vertical axis, degrees; positive toward +X.
    pub h_deg: f64,
    /// Lifted toward +Y, degrees.
    pub v_deg: f64,
}

/// Intensities at every pair of the angles.
#[derive(Debug, Clone, PartialEq)]
pub struct IntensityGrid {
    /// Strictly ascending, one at least.
    h_deg: Vec<f64>,
    /// Strictly ascending, one at least.
    v_deg: Vec<f64>,
    /// cd; row by row: of `v_deg[j]`, `h_deg[i]` at j · (number of h) + i.
    values: Vec<Xyz>,
    /// Flux of the scene's lights, lm.
    pub flux_lm: f64,
}

impl IntensityGrid {
    /// Measures each direction with `intensity`, row by row.
    ///
    /// Errors: angles that do not ascend, or none; whatever `intensity` fails with.
    pub fn sweep<E: From<Error>>(
        h_deg: Vec<f64>,
        v_deg: Vec<f64>,
        flux_lm: f64,
        mut intensity: impl FnMut(Direction) -> std::result::Result<Xyz, E>,
    ) -> std::result::Result<Self, E> {
        check_ascending("h", &h_deg)?;
        check_ascending("v", &v_deg)?;
        let mut values = Vec::with_capacity(h_deg.len() * v_deg.len());
        for &v_deg in &v_deg {
            for &h_deg in &h_deg {
                values.push(intensity(Direction { h_deg, v_deg })?);
            }
        }
        Ok(Self { h_deg, v_deg, values, flux_lm })
    }

    /// The horizontal angles, strictly ascending.
    pub fn h_deg(&self) -> &[f64] {
        &self.h_deg
    }

    /// The vertical angles, strictly ascending.
    pub fn v_deg(&self) -> &[f64] {
        &self.v_deg
    }

    /// Directions and intensities, row by row.
    pub fn rows(&self) -> impl Iterator<Item = (Direction, Xyz)> {
        let directions = self
            .v_deg
            .iter()
            .flat_map(|&v_deg| self.h_deg.iter().map(move |&h_deg| Direction { h_deg, v_deg }));
        directions.zip(self.values.iter().copied())
    }

    /// Linear between the angles in both directions; `None` outside of them.
    pub fn at(&self, direction: Direction) -> Option<Xyz> {
        let (i, s) = place(&self.h_deg, direction.h_deg)?;
        let (j, t) = place(&self.v_deg, direction.v_deg)?;
        let width = self.h_deg.len();
        // A weight of zero may stand beyond the last angle.
        let value = |i: usize, j: usize, weight: f64| match weight {
            0.0 => Xyz::default(),
            _ => self.values[j * width + i] * weight,
        };
        let low = value(i, j, (1.0 - s) * (1.0 - t)) + value(i + 1, j, s * (1.0 - t));
        Some(low + value(i, j + 1, (1.0 - s) * t) + value(i + 1, j + 1, s * t))
    }

    /// Header and rows for a CSV file.
    pub fn table(&self) -> (&'static [&'static str], Vec<[f64; 5]>) {
        let row = |(direction, xyz): (Direction, Xyz)| {
            let [x, y] = xyz.chromaticity().unwrap_or([0.0; 2]);
            [direction.h_deg, direction.v_deg, xyz.y, x, y]
        };
        (&["h_deg", "v_deg", "intensity_cd", "x", "y"], self.rows().map(row).collect())
    }
}

fn check_ascending(what: &str, angles: &[f64]) -> Result<()> {
    let fine = !angles.is_empty() && angles.windows(2).all(|pair| pair[0] < pair[1]);
    let problem = format!("\"{what}\" has to be ascending angles, one at least");
    if fine { Ok(()) } else { Err(Error::inconsistent("photometry.grid", problem)) }
}

/// The angle below, and how far to the next one, 0 to 1.
fn place(angles: &[f64], angle: f64) -> Option<(usize, f64)> {
    let after = angles.partition_point(|&a| a <= angle);
    let below = after.checked_sub(1)?;
    match angles.get(after) {
        Some(&next) => Some((below, (angle - angles[below]) / (next - angles[below]))),
        None => (angles[below] == angle).then_some((below, 0.0)),
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A grid of `f(h, v)` cd.
    pub fn grid(h_deg: &[f64], v_deg: &[f64], f: impl Fn(f64, f64) -> f64) -> IntensityGrid {
        let intensity =
            |d: Direction| Ok::<_, Error>(Xyz::new(1.0, 1.0, 1.0) * f(d.h_deg, d.v_deg));
        IntensityGrid::sweep(h_deg.to_vec(), v_deg.to_vec(), 1000.0, intensity).unwrap()
    }

    #[test]
    fn bilinear_functions_come_back() {
        let f = |h: f64, v: f64| 3.0 + h - 2.0 * v + 0.5 * h * v;
        let grid = grid(&[-20.0, -5.0, 0.0, 20.0], &[-10.0, 10.0], f);
        for (h, v) in [(-20.0, -10.0), (20.0, 10.0), (-7.0, 3.0), (0.0, 0.0), (20.0, -9.0)] {
            let value = grid.at(Direction { h_deg: h, v_deg: v }).unwrap().y;
            assert!((value - f(h, v)).abs() < 1e-12, "{h} {v}: {value}");
        }
        for (h_deg, v_deg) in [(-20.1, 0.0), (20.1, 0.0), (0.0, 10.1), (0.0, -11.0)] {
            assert_eq!(grid.at(Direction { h_deg, v_deg }), None);
        }
    }

    #[test]
    fn one_direction_is_a_grid() {
        let grid = grid(&[0.0], &[0.0], |_, _| 7.0);
        assert_eq!(grid.at(Direction { h_deg: 0.0, v_deg: 0.0 }).unwrap().y, 7.0);
        assert_eq!(grid.at(Direction { h_deg: 1.0, v_deg: 0.0 }), None);
    }

    #[test]
    fn angles_have_to_ascend() {
        let sweep = |h: Vec<f64>| {
            IntensityGrid::sweep(h, vec![0.0], 1.0, |_| Ok::<_, Error>(Xyz::default())).is_err()
        };
        assert!(sweep(vec![]) && sweep(vec![0.0, 0.0]) && sweep(vec![f64::NAN, 1.0]));
    }
}
