//! Linear least squares.

use nalgebra::{DMatrix, DVector};

/// A pivot below this share of the matrix's largest entry says that the rows leave a parameter open.
const SINGULAR: f64 = 1e-13;

/// The x for which |A x − b|² is least, from rows of A with their values of b.
///
/// By the normal equations: rows that are centered and scaled keep those well conditioned. `None` if
/// the rows do not determine x.
pub fn solve_linear<const N: usize>(
    rows: impl Iterator<Item = ([f64; N], f64)>,
) -> Option<[f64; N]> {
    let (mut matrix, mut right) = ([[0.0; N]; N], [0.0; N]);
    for (row, value) in rows {
        for i in 0..N {
            right[i] += row[i] * value;
            (0..N).for_each(|j| matrix[i][j] += row[i] * row[j]);
        }
    }
    let matrix = DMatrix::from_fn(N, N, |i, j| matrix[i][j]);
    let largest = matrix.amax();
    let lu = matrix.lu();
    // NaN is no pivot either.
    let is_determined = lu.u().diagonal().iter().all(|pivot| pivot.abs() > SINGULAR * largest);
    let solution = is_determined.then(|| lu.solve(&DVector::from_row_slice(&right))).flatten()?;
    Some(std::array::from_fn(|i| solution[i]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_through_points_is_the_textbook_one() {
        // y = 1, 3, 2, 5 at x = 0 … 3: by hand, slope 1.1, intercept 1.1.
        let rows = (0..4).zip([1.0, 3.0, 2.0, 5.0]).map(|(x, y)| ([f64::from(x), 1.0], y));
        let [slope, intercept] = solve_linear(rows).unwrap();
        assert!((slope - 1.1).abs() < 1e-12 && (intercept - 1.1).abs() < 1e-12);
    }

    #[test]
    fn rows_that_leave_a_parameter_open_have_no_solution() {
        let alike = (0..4).map(|x| ([f64::from(x), 2.0 * f64::from(x)], 1.0));
        assert_eq!(solve_linear(alike), None);
        assert_eq!(solve_linear([([f64::NAN, 1.0], 1.0)].into_iter()), None);
        assert_eq!(solve_linear::<2>(std::iter::empty()), None);
    }
}
