//! IES LM-63-2002 files.

use super::grid::{Direction, Grid};

/// Photometry of type A in LM-63's numbering, and lengths in m.
const TYPE_A: u32 = 3;
const METERS: u32 = 2;

impl Grid {
    /// The grid as an IES LM-63-2002 file, in absolute candela, photometric type A.
    ///
    /// Deviation: the standard's type A runs over ±90°; this holds the angles that were swept and
    /// invents nothing beyond them.
    pub fn to_ies(&self, name: &str) -> String {
        let (h, v) = (self.h_deg(), self.v_deg());
        let mut lines = vec![
            "IESNA:LM-63-2002".to_owned(),
            "[TEST] computed, not measured".to_owned(),
            "[TESTLAB] none".to_owned(),
            format!("[ISSUEDATE] lampyris {}", env!("CARGO_PKG_VERSION")),
            "[MANUFAC] none".to_owned(),
            format!("[LUMINAIRE] {}", one_line(name)),
            "TILT=NONE".to_owned(),
        ];
        // Lamps, lumens a lamp, multiplier, numbers of angles, type, unit, width, length, height.
        let (n_v, n_h) = (v.len(), h.len());
        lines.push(format!("1 {} 1 {n_v} {n_h} {TYPE_A} {METERS} 0 0 0", self.flux_lm));
        lines.push("1 1 0".to_owned()); // ballast factor, future use, watts: not known
        lines.push(joined(v.iter().copied()));
        lines.push(joined(h.iter().copied()));
        for &h_deg in h {
            let column = v.iter().filter_map(|&v_deg| self.at(Direction { h_deg, v_deg }));
            lines.push(joined(column.map(|xyz| xyz.y)));
        }
        lines.join("\r\n") + "\r\n"
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
    use crate::program::intensity::grid::tests::grid;

    #[test]
    fn angles_come_before_the_columns_of_candela() {
        let grid = grid(&[-10.0, 0.0, 10.0], &[-5.0, 5.0], |h, v| 100.0 + h + 10.0 * v);
        let text = grid.to_ies("tail\nlamp");
        let lines: Vec<&str> = text.split("\r\n").collect();
        assert_eq!(lines[0], "IESNA:LM-63-2002");
        assert_eq!(lines[5], "[LUMINAIRE] taillamp");
        assert_eq!(lines[7], "1 1000 1 2 3 3 2 0 0 0");
        assert_eq!(lines[9], "-5 5");
        assert_eq!(lines[10], "-10 0 10");
        assert_eq!(lines[11], "40 140");
        assert_eq!(lines[13], "60 160");
    }

    #[test]
    fn lines_stay_short() {
        let angles: Vec<f64> = (0..200).map(|i| f64::from(i) * 0.9 - 89.0).collect();
        for size_cd in [1.234567e-12, 1e6, 1e18] {
            let text = grid(&angles, &angles, |_, _| size_cd).to_ies("x");
            assert!(text.lines().all(|line| line.len() <= 132));
            // 7 lines of text, then 13 numbers about the lamp, 400 angles and 40,000 candela.
            let numbers = text.lines().skip(7).flat_map(str::split_whitespace);
            assert_eq!(numbers.clone().count(), 13 + 400 + 40_000);
            assert_eq!(numbers.last().and_then(|n| n.parse().ok()), Some(size_cd));
        }
    }
}
