//! Intensity limits by direction, as data.

use std::path::Path;

use super::grid::{Direction, IntensityGrid};
use crate::color::signal::{self, SignalColor};
use crate::columns::{Table, TableRow};
use crate::error::{Error, Result};

const UN_R148: &str = include_str!("../../../data/regulations/un_r148.csv");

/// What a regulation asks of one lamp.
#[derive(Debug, Clone, PartialEq)]
pub struct Limits {
    /// The color of the light.
    pub color: SignalColor,
    /// Where intensity is limited.
    pub points: Vec<Requirement>,
}

/// Least and greatest intensity in a direction, cd.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Requirement {
    /// Where it holds.
    pub direction: Direction,
    /// Least intensity, cd.
    pub min_cd: f64,
    /// Greatest intensity, cd.
    pub max_cd: f64,
}

/// How a lamp does at one point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointCheck {
    /// What is asked there.
    pub requirement: Requirement,
    /// `None` where the grid does not reach.
    pub intensity_cd: Option<f64>,
    /// The signal color of what was measured; `None` where it is none of them.
    pub color: Option<SignalColor>,
    /// Intensity within its limits, and color as asked for.
    pub passes: bool,
}

impl Limits {
    /// A lamp of UN R148: "R1", "R2", "S1", "S2", "S3", "S4", "2a" or "2b".
    ///
    /// Errors: another name.
    pub fn un_r148(lamp: &str) -> Result<Self> {
        let path = Path::new("data/regulations/un_r148.csv");
        Self::of_lamp(&Table::from_bytes(path, UN_R148.into())?, lamp)
    }

    /// From a table with the columns of `data/regulations/un_r148.csv`.
    ///
    /// Errors: [`Error::Io`]; a row that is none, with its line; a lamp that is not in the file.
    pub fn load(path: &Path, lamp: &str) -> Result<Self> {
        Self::of_lamp(&Table::read(path)?, lamp)
    }

    fn of_lamp(table: &Table, lamp: &str) -> Result<Self> {
        let mut limits: Option<Self> = None;
        let mut lamps: Vec<&str> = Vec::new();
        for row in table.rows() {
            let (name, color, requirement) = parse_row(&row)?;
            if !lamps.contains(&name) {
                lamps.push(name);
            }
            if name == lamp {
                let limits = limits.get_or_insert_with(|| Self { color, points: Vec::new() });
                limits.points.push(requirement);
            }
        }
        limits.ok_or_else(|| {
            Error::out_of_range("limits", "lamp", format!("\"{lamp}\""), lamps.join(", "))
        })
    }

    /// The same points with another greatest intensity.
    #[must_use]
    pub fn with_max(mut self, max_cd: f64) -> Self {
        self.points.iter_mut().for_each(|point| point.max_cd = max_cd);
        self
    }

    /// Every point, in the order of the data.
    pub fn check(&self, grid: &IntensityGrid) -> Vec<PointCheck> {
        self.points.iter().map(|point| self.check_point(*point, grid)).collect()
    }

    fn check_point(&self, requirement: Requirement, grid: &IntensityGrid) -> PointCheck {
        let xyz = grid.at(requirement.direction);
        let color = xyz.and_then(|xyz| xyz.chromaticity()).and_then(signal::color_of);
        let intensity_cd = xyz.map(|xyz| xyz.y);
        let within =
            intensity_cd.is_some_and(|i| (requirement.min_cd..=requirement.max_cd).contains(&i));
        let passes = within && color == Some(self.color);
        PointCheck { requirement, intensity_cd, color, passes }
    }
}

fn parse_row<'a>(row: &TableRow<'a>) -> Result<(&'a str, SignalColor, Requirement)> {
    const EXPECTED: &str = "expected lamp,color,h_deg,v_deg,min_cd,max_cd";
    let mut cells = row.cells();
    let (lamp, color) = (cells.next().unwrap_or_default(), cells.next().unwrap_or_default());
    let color = SignalColor::ALL.into_iter().find(|c| c.name() == color);
    let color = color.ok_or_else(|| row.bad(EXPECTED))?;
    let numbers = row.numbers_from(2)?;
    let finite = numbers.iter().all(|n| n.is_finite());
    let ([h_deg, v_deg, min_cd, max_cd], true) = (&numbers[..], finite) else {
        return Err(row.bad(EXPECTED));
    };
    let direction = Direction { h_deg: *h_deg, v_deg: *v_deg };
    Ok((lamp, color, Requirement { direction, min_cd: *min_cd, max_cd: *max_cd }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Xyz;

    fn even(color: [f64; 2], intensity_cd: f64) -> IntensityGrid {
        let (h, v) = (vec![-20.0, 20.0], vec![-10.0, 10.0]);
        IntensityGrid::sweep(h, v, 1.0, |_| Ok::<_, Error>(Xyz::from_xy(color, intensity_cd)))
            .unwrap()
    }

    const RED: [f64; 2] = [0.70, 0.295];

    #[test]
    fn every_lamp_of_the_regulation_is_there() {
        for (lamp, points, axis_cd) in [
            ("R1", 19, 4.0),
            ("R2", 19, 4.0),
            ("S1", 19, 60.0),
            ("S2", 19, 60.0),
            ("S3", 18, 25.0),
            ("S4", 18, 25.0),
            ("2a", 19, 50.0),
            ("2b", 19, 50.0),
        ] {
            let limits = Limits::un_r148(lamp).unwrap();
            assert_eq!(limits.points.len(), points, "{lamp}");
            let axis = Direction { h_deg: 0.0, v_deg: 0.0 };
            let point = limits.points.iter().find(|p| p.direction == axis).unwrap();
            assert_eq!(point.min_cd, axis_cd, "{lamp}");
            // The grids are symmetric, and ask nowhere for more than on the axis.
            for p in &limits.points {
                let mirrored = Direction { h_deg: -p.direction.h_deg, ..p.direction };
                let twin = limits.points.iter().find(|q| q.direction == mirrored).unwrap();
                assert_eq!(twin.min_cd, p.min_cd);
                assert!(p.min_cd <= axis_cd && p.max_cd == point.max_cd);
            }
        }
        assert_eq!(
            Limits::un_r148("S9").unwrap_err().to_string(),
            "limits: lamp is \"S9\", allowed: R1, R2, S1, S2, 2a, 2b, S3, S4"
        );
    }

    #[test]
    fn points_pass_by_intensity_and_color() {
        let limits = Limits::un_r148("S1").unwrap();
        let failed = |grid: &IntensityGrid| limits.check(grid).iter().filter(|p| !p.passes).count();
        assert_eq!(failed(&even(RED, 100.0)), 0);
        assert_eq!(failed(&even(RED, 59.0)), 1, "the axis");
        assert_eq!(failed(&even(RED, 53.9)), 3, "the axis and ±5°");
        assert_eq!(failed(&even(RED, 261.0)), 19, "too bright");
        assert_eq!(failed(&even([0.57, 0.42], 100.0)), 19, "amber");
        let narrow = IntensityGrid::sweep(vec![-5.0, 5.0], vec![-10.0, 10.0], 1.0, |_| {
            Ok::<_, Error>(Xyz::from_xy(RED, 100.0))
        });
        let checks = limits.check(&narrow.unwrap());
        assert_eq!(checks.iter().filter(|p| p.intensity_cd.is_none()).count(), 10);
    }
}
