//! Checks of measured tables.

use crate::error::{Error, Result};

/// A measured table, as a message names it.
pub struct MeasuredTable<'a> {
    /// What is fitted, and the table's name if there are several.
    pub object: &'a str,
    /// Names of the two columns.
    pub columns: [&'a str; 2],
    /// Fewest rows that can be fitted.
    pub min_rows: usize,
    /// Rows in a row that may share the largest value before the instrument counts as saturated.
    pub max_plateau: usize,
}

/// Checks that `rows` of (abscissa, value) can be fitted.
///
/// Errors: [`Error::Inconsistent`] for too few rows, and with the first row (counted from 1) whose
/// number is not finite, whose abscissa is not above the one before, whose value is negative, or
/// with which the values stay at their maximum.
pub fn check_table(table: &MeasuredTable, rows: &[(f64, f64)]) -> Result<()> {
    let refuse = |problem: String| Err(Error::inconsistent(table.object, problem));
    let [abscissa, value] = table.columns;
    for (number, &(x, y)) in (1..).zip(rows) {
        if !x.is_finite() {
            return refuse(format!("row {number}: {abscissa} is {x}, allowed: finite numbers"));
        }
        if !(y.is_finite() && y >= 0.0) {
            return refuse(format!("row {number}: {value} is {y}, allowed: finite, at least 0"));
        }
    }
    for (number, pair) in (2..).zip(rows.windows(2)) {
        let (before, x) = (pair[0].0, pair[1].0);
        if x <= before {
            return refuse(format!("row {number}: {abscissa} {x} follows {before}, must ascend"));
        }
    }
    if rows.len() < table.min_rows {
        let (has, needs) = (rows.len(), table.min_rows);
        return refuse(format!("has {has} rows, needs at least {needs}"));
    }
    match plateau(rows, table.max_plateau) {
        None => Ok(()),
        Some([first, last]) => refuse(format!(
            "rows {first} to {last}: {value} stays at its maximum {}, the instrument is saturated",
            rows[first - 1].1
        )),
    }
}

/// First and last row, from 1, of a run longer than `allowed` at the largest value.
fn plateau(rows: &[(f64, f64)], allowed: usize) -> Option<[usize; 2]> {
    let max = rows.iter().map(|row| row.1).fold(f64::NEG_INFINITY, f64::max);
    let mut length = 0;
    for (number, row) in (1..).zip(rows) {
        length = if row.1 == max { length + 1 } else { 0 };
        let ends = rows.get(number).is_none_or(|next| next.1 != max);
        if length > allowed && ends {
            return Some([number + 1 - length, number]);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: MeasuredTable = MeasuredTable {
        object: "fit",
        columns: ["digit", "luminance"],
        min_rows: 3,
        max_plateau: 1,
    };

    fn problem(rows: &[(f64, f64)]) -> String {
        check_table(&TABLE, rows).unwrap_err().to_string()
    }

    #[test]
    fn good_tables_pass() {
        check_table(&TABLE, &[(0.0, 0.0), (1.0, 0.5), (2.0, 3.0)]).unwrap();
        let wide = MeasuredTable { max_plateau: 2, ..TABLE };
        check_table(&wide, &[(-1.0, 3.0), (1.0, 3.0), (2.0, 0.0)]).unwrap();
    }

    #[test]
    fn bad_rows_are_named() {
        assert_eq!(problem(&[(0.0, 0.0), (1.0, 1.0)]), "fit: has 2 rows, needs at least 3");
        assert_eq!(problem(&[]), "fit: has 0 rows, needs at least 3");
        assert_eq!(
            problem(&[(0.0, 0.0), (2.0, 1.0), (1.0, 3.0)]),
            "fit: row 3: digit 1 follows 2, must ascend"
        );
        assert_eq!(
            problem(&[(0.0, 0.0), (1.0, -1.0), (2.0, 3.0)]),
            "fit: row 2: luminance is -1, allowed: finite, at least 0"
        );
        assert_eq!(
            problem(&[(0.0, f64::NAN), (1.0, 1.0), (2.0, 3.0)]),
            "fit: row 1: luminance is NaN, allowed: finite, at least 0"
        );
        assert_eq!(
            problem(&[(f64::INFINITY, 0.0), (1.0, 1.0), (2.0, 3.0)]),
            "fit: row 1: digit is inf, allowed: finite numbers"
        );
        assert_eq!(
            problem(&[(0.0, 0.0), (1.0, 3.0), (2.0, 3.0), (3.0, 3.0)]),
            "fit: rows 2 to 4: luminance stays at its maximum 3, the instrument is saturated"
        );
    }
}
