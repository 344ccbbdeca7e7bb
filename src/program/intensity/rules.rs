//! What UN R148 asks of a lamp beyond its points: a field of visibility, a ratio, a mark.

use super::grid::{Direction, IntensityGrid};
use crate::columns::built_in_rows;
use crate::error::{Error, Result};

const LAMPS: &str = include_str!("../../../data/regulations/un_r148_lamps.csv");

/// A row of `data/regulations/un_r148_lamps.csv`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LampRules {
    /// Greatest intensity of a lamp marked "D", cd; `None` where the data do not tell.
    pub max_d_cd: Option<f64>,
    /// Where the lamp must be visible.
    pub field: VisibilityField,
    /// For stop lamps that are combined with a position lamp.
    pub ratio: Option<StopRatio>,
}

/// Angles to the axis in which a lamp must be visible.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VisibilityField {
    /// cd, in every direction of the field.
    pub min_cd: f64,
    /// Toward the middle of the vehicle.
    pub inward_deg: f64,
    /// Away from the middle of the vehicle.
    pub outward_deg: f64,
    /// Above the axis.
    pub up_deg: f64,
    /// Below the axis.
    pub down_deg: f64,
}

/// How much brighter a stop lamp is than the position lamp it is combined with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StopRatio {
    /// Least ratio of the stop lamp's intensity to the position lamp's.
    pub min: f64,
    /// Within these angles to the axis.
    pub h_deg: f64,
    /// Up and down, degrees.
    pub v_deg: f64,
}

/// Where on the vehicle a lamp is, as an observer behind it sees it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RoadSide {
    /// The left of the vehicle.
    Left,
    /// The right of the vehicle.
    Right,
}

/// The direction that is nearest to failing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weakest {
    /// Where it is.
    pub direction: Direction,
    /// Intensity there, cd, or the ratio.
    pub value: f64,
}

impl LampRules {
    /// `None` for a lamp that is not in the data.
    pub fn un_r148(lamp: &str) -> Option<Self> {
        let (_, row) = built_in_rows(LAMPS).find(|(name, _)| *name == lamp)?;
        let cells: Vec<Option<f64>> = row.iter().map(|n| n.is_finite().then_some(*n)).collect();
        let [_, max_d_cd, min_cd, inward, outward, up, down, ratio, ratio_h, ratio_v] = cells[..]
        else {
            return None;
        };
        let field = VisibilityField {
            min_cd: min_cd?,
            inward_deg: inward?,
            outward_deg: outward?,
            up_deg: up?,
            down_deg: down?,
        };
        let ratio = || Some(StopRatio { min: ratio?, h_deg: ratio_h?, v_deg: ratio_v? });
        Some(Self { max_d_cd, field, ratio: ratio() })
    }
}

impl VisibilityField {
    /// The least intensity in the field of a lamp on `side`.
    ///
    /// Errors: a grid that does not reach all of the field.
    pub fn weakest(&self, grid: &IntensityGrid, side: RoadSide) -> Result<Weakest> {
        let (left, right) = match side {
            RoadSide::Left => (self.outward_deg, self.inward_deg),
            RoadSide::Right => (self.inward_deg, self.outward_deg),
        };
        let area = Area { h_deg: [-left, right], v_deg: [-self.down_deg, self.up_deg] };
        area.weakest(&[grid], |direction| Some(grid.at(direction)?.y))
    }
}

impl StopRatio {
    /// The least ratio of `stop` to `position`; infinite where the latter is dark.
    ///
    /// Errors: a grid that does not reach all of the angles.
    pub fn weakest(&self, stop: &IntensityGrid, position: &IntensityGrid) -> Result<Weakest> {
        let [h_deg, v_deg] = [self.h_deg, self.v_deg].map(|angle| [-angle, angle]);
        Area { h_deg, v_deg }.weakest(&[stop, position], |direction| {
            let (stop, position) = (stop.at(direction)?.y, position.at(direction)?.y);
            Some(if position > 0.0 { stop / position } else { f64::INFINITY })
        })
    }
}

/// Angles from and to.
struct Area {
    h_deg: [f64; 2],
    v_deg: [f64; 2],
}

impl Area {
    /// The least of `value` at the angles of the grids in the area and on its border: between
    /// them intensity is linear.
    fn weakest(
        &self,
        grids: &[&IntensityGrid],
        value: impl Fn(Direction) -> Option<f64>,
    ) -> Result<Weakest> {
        let inside = |[from, to]: [f64; 2], angles: fn(&IntensityGrid) -> &[f64]| {
            let all = grids.iter().flat_map(move |grid| angles(grid)).copied();
            all.filter(move |angle| (from..=to).contains(angle)).chain([from, to])
        };
        let mut weakest: Option<Weakest> = None;
        for v_deg in inside(self.v_deg, IntensityGrid::v_deg) {
            for h_deg in inside(self.h_deg, IntensityGrid::h_deg) {
                let direction = Direction { h_deg, v_deg };
                let value = value(direction).ok_or_else(|| self.not_reached())?;
                if weakest.is_none_or(|so_far| value < so_far.value) {
                    weakest = Some(Weakest { direction, value });
                }
            }
        }
        weakest.ok_or_else(|| self.not_reached())
    }

    fn not_reached(&self) -> Error {
        let ([left, right], [down, up]) = (self.h_deg, self.v_deg);
        let area = format!("h from {left}° to {right}°, v from {down}° to {up}°");
        Error::inconsistent("grid:check", format!("the grid has to reach over {area}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::intensity::grid::tests::grid;

    #[test]
    fn lamps_have_the_rules_of_the_data() {
        let rules = LampRules::un_r148("S2").unwrap();
        assert_eq!(rules.max_d_cd, Some(365.0));
        assert_eq!(rules.ratio, Some(StopRatio { min: 5.0, h_deg: 10.0, v_deg: 5.0 }));
        let amber = LampRules::un_r148("2b").unwrap();
        assert_eq!((amber.max_d_cd, amber.ratio), (None, None));
        assert_eq!(amber.field.outward_deg, 80.0);
        assert_eq!(LampRules::un_r148("S9"), None);
        let rows = LAMPS.lines().filter(|line| !line.starts_with('#')).skip(1);
        assert!(rows.clone().count() == 8);
        assert!(rows.filter_map(|row| row.split(',').next()).all(|lamp| {
            LampRules::un_r148(lamp).is_some()
                && crate::program::intensity::Limits::un_r148(lamp).is_ok()
        }));
    }

    #[test]
    fn fields_reach_outward_on_their_side() {
        let field = LampRules::un_r148("R1").unwrap().field;
        let wide: Vec<f64> = (-9..=9).map(|i| f64::from(i) * 10.0).collect();
        // Falls to 0 at 90° to the right.
        let grid = grid(&wide, &[-20.0, 20.0], |h, _| 0.9 - h / 100.0);
        let [left, right] =
            [RoadSide::Left, RoadSide::Right].map(|s| field.weakest(&grid, s).unwrap());
        assert_eq!((left.direction.h_deg, right.direction.h_deg), (45.0, 80.0));
        assert!((left.value - 0.45).abs() < 1e-12 && (right.value - 0.1).abs() < 1e-12);
    }

    #[test]
    fn grids_have_to_reach_the_field() {
        let field = LampRules::un_r148("S1").unwrap().field;
        let narrow = grid(&[-20.0, 20.0], &[-10.0, 10.0], |_, _| 100.0);
        assert_eq!(
            field.weakest(&narrow, RoadSide::Left).unwrap_err().to_string(),
            "grid:check: the grid has to reach over h from -45° to 45°, v from -15° to 15°"
        );
    }

    #[test]
    fn ratios_are_the_least_of_both_grids() {
        let ratio = LampRules::un_r148("S1").unwrap().ratio.unwrap();
        let stop = grid(&[-20.0, 20.0], &[-10.0, 10.0], |_, _| 60.0);
        let position =
            grid(&[-20.0, 4.0, 20.0], &[-10.0, 10.0], |h, _| if h == 4.0 { 20.0 } else { 4.0 });
        let found = ratio.weakest(&stop, &position).unwrap();
        assert_eq!((found.direction.h_deg, found.value), (4.0, 3.0));
        let dark = grid(&[-20.0, 20.0], &[-10.0, 10.0], |_, _| 0.0);
        assert_eq!(ratio.weakest(&stop, &dark).unwrap().value, f64::INFINITY);
    }
}
