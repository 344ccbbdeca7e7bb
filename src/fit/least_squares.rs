//! Levenberg–Marquardt with standard errors.

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt, TerminationReason};
use nalgebra::{DMatrix, DVector, Dyn, storage::Owned};

use crate::error::{Error, Result};

/// One row's residual and its derivatives by the parameters.
pub struct Residual<const N: usize> {
    /// Model minus measurement, weighted.
    pub value: f64,
    /// Derivative of `value` by each parameter.
    pub gradient: [f64; N],
}

/// Parameters that minimize a sum of squares.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate<const N: usize> {
    /// Where the sum is least.
    pub parameters: [f64; N],
    /// Square roots of the diagonal of s² (JᵀJ)⁻¹, where s² is the sum of squares over rows minus
    /// parameters; infinite where the rows do not determine a parameter or its error.
    pub standard_errors: [f64; N],
    /// Root of the mean square residual.
    pub rms: f64,
}

/// The minimum of Σ residual² over `rows` rows, from `start`.
///
/// Errors: [`Error::Inconsistent`], naming `object`, if the iteration does not converge.
pub fn minimize<const N: usize>(
    object: &str,
    start: [f64; N],
    rows: usize,
    residual: impl Fn(&[f64; N], usize) -> Residual<N>,
) -> Result<Estimate<N>> {
    let problem = Problem { parameters: start, rows, residual };
    let (problem, report) = LevenbergMarquardt::new().minimize(problem);
    match report.termination {
        // The last one: the step is below f64's resolution.
        TerminationReason::ResidualsZero
        | TerminationReason::Orthogonal
        | TerminationReason::Converged { .. }
        | TerminationReason::NoImprovementPossible(_) => Ok(problem.estimate()),
        other => Err(Error::inconsistent(object, format!("the fit does not converge: {other:?}"))),
    }
}

struct Problem<const N: usize, F> {
    parameters: [f64; N],
    rows: usize,
    residual: F,
}

impl<const N: usize, F: Fn(&[f64; N], usize) -> Residual<N>> Problem<N, F> {
    fn row(&self, row: usize) -> Residual<N> {
        (self.residual)(&self.parameters, row)
    }

    fn jacobian_matrix(&self) -> DMatrix<f64> {
        let mut matrix = DMatrix::zeros(self.rows, N);
        for row in 0..self.rows {
            for (column, value) in self.row(row).gradient.into_iter().enumerate() {
                matrix[(row, column)] = value;
            }
        }
        matrix
    }

    fn estimate(&self) -> Estimate<N> {
        let squares: f64 = (0..self.rows).map(|row| self.row(row).value.powi(2)).sum();
        let jacobian = self.jacobian_matrix();
        let covariance = (jacobian.transpose() * &jacobian).try_inverse();
        let spare = self.rows.saturating_sub(N);
        let standard_error = |i: usize| match (&covariance, spare) {
            // Rounding alone inverts what has no inverse, and gives what is no variance.
            (Some(covariance), 1..) if covariance[(i, i)] > 0.0 => {
                (covariance[(i, i)] * squares / spare as f64).sqrt()
            }
            _ => f64::INFINITY,
        };
        Estimate {
            parameters: self.parameters,
            standard_errors: std::array::from_fn(standard_error),
            rms: (squares / self.rows as f64).sqrt(),
        }
    }
}

impl<const N: usize, F> LeastSquaresProblem<f64, Dyn, Dyn> for Problem<N, F>
where
    F: Fn(&[f64; N], usize) -> Residual<N>,
{
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, x: &DVector<f64>) {
        self.parameters.copy_from_slice(x.as_slice());
    }

    fn params(&self) -> DVector<f64> {
        DVector::from_row_slice(&self.parameters)
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        Some(DVector::from_fn(self.rows, |row, _| self.row(row).value))
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        Some(self.jacobian_matrix())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_has_its_textbook_errors() {
        // y = 1, 3, 2, 5 at x = 0 … 3: by hand, slope 1.1, intercept 1.1, RSS 2.7, s² = 1.35,
        // σ_slope = √(1.35/5), σ_intercept = √(1.35 · 14/20).
        let y = [1.0, 3.0, 2.0, 5.0];
        let fit = minimize("line", [0.0, 0.0], 4, |[slope, intercept], row| {
            let x = row as f64;
            Residual { value: slope * x + intercept - y[row], gradient: [x, 1.0] }
        })
        .unwrap();
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        close(fit.parameters[0], 1.1);
        close(fit.parameters[1], 1.1);
        close(fit.standard_errors[0], (1.35f64 / 5.0).sqrt());
        close(fit.standard_errors[1], (1.35f64 * 14.0 / 20.0).sqrt());
        close(fit.rms, (2.7f64 / 4.0).sqrt());
    }

    #[test]
    fn as_many_rows_as_parameters_have_no_errors() {
        let fit =
            minimize("point", [5.0], 1, |[a], _| Residual { value: a - 2.0, gradient: [1.0] });
        let fit = fit.unwrap();
        assert!((fit.parameters[0] - 2.0).abs() < 1e-15);
        assert_eq!(fit.standard_errors, [f64::INFINITY]);
    }

    #[test]
    fn nonsense_does_not_converge() {
        let fit =
            minimize("object", [1.0], 3, |_, _| Residual { value: f64::NAN, gradient: [f64::NAN] });
        assert!(fit.unwrap_err().to_string().starts_with("object: the fit does not converge"));
    }
}
