//! IES LM-63-2002 files.

use super::grid::{Direction, IntensityGrid};
use crate::error::{Error, Result};

/// Photometry of type A in LM-63's numbering, and lengths in m.
const TYPE_A: u32 = 3;
const METERS: u32 = 2;

impl IntensityGrid {
    /// The grid as an IES LM-63-2002 file, in absolute candela, photometric type A.
    ///
    /// The standard's horizontal angles turn clockwise as seen from above, against the azimuth of
    /// views: h = 20° is written as −20°. `issued` is the file's date of issue, in the script's words.
    ///
    /// Deviation: the standard's type A runs over ±90°; this holds the angles that were swept and
    /// invents nothing beyond them.
    /// Errors: a grid that does not reach from below 0° to above it: readers would take a file that
    /// starts at 0° for one side of a symmetric lamp.
    pub fn to_ies(&self, name: &str, issued: Option<&str>) -> Result<String> {
        let v = self.v_deg();
        let h: Vec<f64> = self.h_deg().iter().rev().map(|&h_deg| -h_deg + 0.0).collect();
        if !(h[0] < 0.0 && h[h.len() - 1] > 0.0) {
            let problem = "h has to reach from below 0° to above 0°: a file of one side is read as \
                           half of a symmetric lamp";
            return Err(Error::inconsistent("grid:save", problem));
        }
        let mut lines = vec![
            "IESNA:LM-63-2002".to_owned(),
            "[TEST] computed, not measured".to_owned(),
            "[TESTLAB] none".to_owned(),
        ];
        lines.extend(issued.map(|date| format!("[ISSUEDATE] {}", one_line(date))));
        lines.extend([
            "[MANUFAC] none".to_owned(),
            format!("[LUMINAIRE] {}", one_line(name)),
            format!("[OTHER] computed by lampyris {}", env!("CARGO_PKG_VERSION")),
            "TILT=NONE".to_owned(),
        ]);
        // Lamps, lumens a lamp, multiplier, numbers of angles, type, unit, width, length, height.
        let (n_v, n_h) = (v.len(), h.len());
        lines.push(format!("1 {} 1 {n_v} {n_h} {TYPE_A} {METERS} 0 0 0", self.flux_lm));
        lines.push("1 1 0".to_owned()); // ballast factor, future use, watts: not known
        lines.push(joined(v.iter().copied()));
        lines.push(joined(h.iter().copied()));
        for &written_deg in &h {
            let h_deg = -written_deg;
            let column = v.iter().filter_map(|&v_deg| self.at(Direction { h_deg, v_deg }));
            lines.push(joined(column.map(|xyz| xyz.y)));
        }
        Ok(lines.join("\r\n") + "\r\n")
    }
}

/// Numbers in lines of at most the 132 characters that the standard allows.
fn joined(values: impl Iterator<Item = f64>) -> String {
    const LONGEST: usize = 132;
    let (mut text, mut length) = (String::new(), 0);
    for number in values.map(number) {
        if length + 1 + number.len() > LONGEST {
            text.push_str("\r\n");
            length = 0;
        } else if length > 0 {
            text.push(' ');
            length += 1;
        }
        length += number.len();
        text.push_str(&number);
    }
    text
}

/// Seven significant digits, without an exponent, which not every reader knows.
fn number(value: f64) -> String {
    let rounded = format!("{value:.6e}").parse().unwrap_or(value);
    rounded.to_string()
}

pub(super) fn one_line(text: &str) -> String {
    text.chars().filter(|c| !c.is_control()).take(70).collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::geometry::DVec3;
    use crate::program::intensity::grid::tests::grid;
    use crate::source::photometric;

    #[test]
    fn angles_come_before_the_columns_of_candela() {
        let grid = grid(&[-10.0, 0.0, 20.0], &[-5.0, 5.0], |h, v| 100.0 + h + 10.0 * v);
        let text = grid.to_ies("tail\nlamp", None).unwrap();
        let lines: Vec<&str> = text.split("\r\n").collect();
        assert_eq!(lines[0], "IESNA:LM-63-2002");
        assert_eq!(lines[4], "[LUMINAIRE] taillamp");
        assert!(!text.contains("ISSUEDATE"));
        assert_eq!(lines[7], "1 1000 1 2 3 3 2 0 0 0");
        assert_eq!(lines[9], "-5 5");
        // Clockwise from above: the grid's 20° comes first, as −20°.
        assert_eq!(lines[10], "-20 0 10");
        assert_eq!(lines[11], "70 170");
        assert_eq!(lines[13], "40 140");
        let dated = grid.to_ies("x", Some("2026-11-25")).unwrap();
        assert!(dated.contains("\r\n[ISSUEDATE] 2026-11-25\r\n"));
    }

    /// A lamp brighter to the viewer's right (+X) is so again when the file is read as a source.
    #[test]
    fn read_back_it_shines_the_same_way() {
        let shape = |h: f64, v: f64| 100.0 + 2.0 * h + v;
        let grid = grid(&[-30.0, -10.0, 0.0, 10.0, 30.0], &[-20.0, 0.0, 20.0], shape);
        let text = grid.to_ies("x", None).unwrap();
        let file = photometric::from_bytes(Path::new("x.ies"), text.into_bytes()).unwrap();
        for (h, v) in [(0.0f64, 0.0f64), (10.0, 0.0), (-30.0, 20.0), (5.0, -10.0)] {
            let ((sin_h, cos_h), (sin_v, cos_v)) =
                (h.to_radians().sin_cos(), v.to_radians().sin_cos());
            let toward = DVec3::new(sin_h * cos_v, sin_v, cos_h * cos_v);
            let found = file.solid.intensity_cd(toward);
            assert!((found - shape(h, v)).abs() < 1e-6, "{h} {v}: {found}");
        }
    }

    #[test]
    fn one_side_alone_is_refused() {
        for h in [&[0.0, 10.0][..], &[-10.0, 0.0], &[0.0], &[5.0, 10.0]] {
            let error = grid(h, &[-5.0, 5.0], |_, _| 1.0).to_ies("x", None).unwrap_err();
            assert!(
                error.to_string().starts_with("grid:save: h has to reach from below 0°"),
                "{h:?}"
            );
        }
    }

    #[test]
    fn lines_stay_short() {
        let angles: Vec<f64> = (0..200).map(|i| f64::from(i) * 0.9 - 89.0).collect();
        for size_cd in [1.234567e-12, 1e6, 1e18] {
            let text = grid(&angles, &angles, |_, _| size_cd).to_ies("x", None).unwrap();
            assert!(text.lines().all(|line| line.len() <= 132));
            // 7 lines of text, then 13 numbers about the lamp, 400 angles and 40,000 candela.
            let numbers = text.lines().skip(7).flat_map(str::split_whitespace);
            assert_eq!(numbers.clone().count(), 13 + 400 + 40_000);
            assert_eq!(numbers.last().and_then(|n| n.parse().ok()), Some(size_cd));
        }
    }
}
