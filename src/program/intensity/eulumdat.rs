//! EULUMDAT files.

use super::grid::{Direction, IntensityGrid};
use super::ies::one_line;
use crate::error::{Error, Result};

/// Half planes about the lamp's axis, and their step in degrees.
const PLANES: usize = 24;
const PLANE_STEP_DEG: f64 = 15.0;
/// Step of the angle to the axis, degrees.
const GAMMA_STEP_DEG: f64 = 1.0;
/// Direct ratios for ten room indices, which mean nothing for a lamp on a car.
const ROOM_INDICES: usize = 10;

impl IntensityGrid {
    /// The grid as an EULUMDAT file: cd/klm about the lamp's axis, +Z.
    ///
    /// C planes turn from −X (C = 0°) over +Y (90°): counter-clockwise for one who looks out of the
    /// lamp, as CIE has it. γ is the angle to +Z. Values lie linearly between those of the grid, out
    /// to the largest γ that the grid holds in all planes.
    /// Errors: a grid that does not reach around the axis, so that no γ but 0° is in all planes.
    pub fn to_eulumdat(&self, name: &str) -> Result<String> {
        let name = one_line(name);
        let gammas = self.gammas_deg();
        if gammas.len() < 2 {
            let problem =
                "EULUMDAT goes around the axis: h and v have to reach from -1° to 1° at least";
            return Err(Error::inconsistent("grid:save", problem));
        }
        let per_klm = |value: f64| value * 1000.0 / self.flux_lm;
        let mut lines: Vec<String> = [
            "lampyris, computed",
            "3", // a point source without symmetry about its axis
            "0", // no symmetry
        ]
        .map(str::to_owned)
        .into();
        lines.push(PLANES.to_string());
        lines.push(PLANE_STEP_DEG.to_string());
        lines.push(gammas.len().to_string());
        lines.push(GAMMA_STEP_DEG.to_string());
        lines.extend(["", &name, "", &name, ""].map(str::to_owned)); // report, name, number, file, date
        lines.extend((0..9).map(|_| "0".to_owned())); // lengths of the luminaire, mm: not known
        // Downward and output fraction %, factor, tilt, sets of lamps, lamps, type.
        lines.extend(["100", "100", "1", "0", "1", "1", "lamp"].map(str::to_owned));
        lines.push(self.flux_lm.to_string());
        lines.extend(["", "", "0"].map(str::to_owned)); // color, rendering, W: not known
        lines.extend((0..ROOM_INDICES).map(|_| "0".to_owned()));
        lines.extend((0..PLANES).map(|c| (c as f64 * PLANE_STEP_DEG).to_string()));
        lines.extend(gammas.iter().map(f64::to_string));
        for c in 0..PLANES {
            for &gamma in &gammas {
                let value = self.at(direction(c, gamma)).map_or(0.0, |xyz| per_klm(xyz.y));
                lines.push(format!("{value:.4}"));
            }
        }
        Ok(lines.join("\r\n") + "\r\n")
    }

    /// The angles to +Z that the grid holds in all planes, from 0.
    fn gammas_deg(&self) -> Vec<f64> {
        (0..)
            .map(|k| f64::from(k) * GAMMA_STEP_DEG)
            .take_while(|&gamma| (0..PLANES).all(|c| self.at(direction(c, gamma)).is_some()))
            .take_while(|&gamma| gamma <= 180.0)
            .collect()
    }
}

fn direction(plane: usize, gamma_deg: f64) -> Direction {
    let (sin_c, cos_c) = (plane as f64 * PLANE_STEP_DEG).to_radians().sin_cos();
    let (sin_g, cos_g) = gamma_deg.to_radians().sin_cos();
    let (x, y, z) = (-sin_g * cos_c, sin_g * sin_c, cos_g);
    Direction { h_deg: x.atan2(z).to_degrees(), v_deg: y.clamp(-1.0, 1.0).asin().to_degrees() }
}

#[cfg(test)]
mod tests {
    use crate::program::intensity::grid::tests::grid;

    #[test]
    fn values_stand_where_readers_look_for_them() {
        let grid = grid(&[-20.0, 0.0, 20.0], &[-10.0, 10.0], |h, v| 200.0 + h + 2.0 * v);
        let text = grid.to_eulumdat("tail lamp").unwrap();
        let lines: Vec<&str> = text.split("\r\n").collect();
        // 24 planes and γ to 9°: 10° is out of the grid by rounding, at most.
        let gammas: usize = lines[5].parse().unwrap();
        assert!((10..=11).contains(&gammas), "{gammas}");
        assert_eq!((lines[3], lines[8]), ("24", "tail lamp"));
        assert_eq!(lines[28], "1000", "flux");
        let first = 26 + 6 + 10 + 24 + gammas;
        assert_eq!(lines[42], "0", "first plane");
        assert_eq!(lines[43], "15", "second plane");
        assert_eq!(lines[first], "200.0000");
        assert_eq!(lines[first + 5], "195.0000", "5° toward −X");
        assert_eq!(lines[first + 6 * gammas + 5], "210.0000", "5° up");
        assert_eq!(lines.len(), first + 24 * gammas + 1);
    }
    #[test]
    fn a_quadrant_is_not_enough() {
        for h in [[0.0, 20.0], [10.0, 20.0]] {
            let error = grid(&h, &[-10.0, 10.0], |_, _| 1.0).to_eulumdat("x").unwrap_err();
            assert!(error.to_string().contains("have to reach from -1° to 1°"), "{error}");
        }
    }
}
