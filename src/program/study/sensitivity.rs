//! How much of a result's variance each parameter causes.
//!
//! A polynomial that is orthonormal in the parameters' distributions is fitted to the draws as they
//! are; the squares of its coefficients are the parts of the variance (Sudret, Reliab. Eng. Syst.
//! Saf. 93, 2008). So no draws are made for it. Its degree is the one that predicts draws best that
//! were left out of the fit.

use nalgebra::{DMatrix, DVector};

use super::distribution::{Distribution, normal_quantile};
use crate::error::{Error, Result};

/// Shares of a result's variance, one of each parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensitivity {
    /// What vanishes if the parameter alone is held.
    pub first: Vec<f64>,
    /// What is left if all others are held: with all its interactions.
    pub total: Vec<f64>,
    /// Share of the variance that the polynomial predicts at draws left out of its fit, 1 at best.
    /// Where it is far below 1 the shares are not to be trusted.
    pub explained: f64,
}

/// A fit's coefficients stay well below the draws in number.
const DRAWS_PER_TERM: usize = 2;
/// Bounds the time of a fit: draws × terms².
const MOST_WORK: usize = 1 << 31;

/// Shares of the variance of `values`, of draws at `shares` (one row a draw, one share a parameter).
///
/// A result that does not vary has shares 0, all explained.
/// Errors: [`Error::Inconsistent`] for fewer draws than twice the parameters and one.
pub fn sensitivity(
    parameters: &[Distribution],
    shares: &[Vec<f64>],
    values: &[f64],
) -> Result<Sensitivity> {
    let needed = DRAWS_PER_TERM * (parameters.len() + 1);
    if values.len() < needed {
        let problem = format!("{} draws, sensitivities need {needed}", values.len());
        return Err(Error::inconsistent("study", problem));
    }
    let center = values.iter().sum::<f64>() / values.len() as f64;
    let scale = values.iter().map(|v| (v - center).abs()).fold(0.0, f64::max);
    if scale <= 1e-12 * center.abs() {
        let none = vec![0.0; parameters.len()];
        return Ok(Sensitivity { first: none.clone(), total: none, explained: 1.0 });
    }
    let scaled = DVector::from_iterator(values.len(), values.iter().map(|v| (v - center) / scale));
    let fits = (1..).map_while(|degree| {
        let terms = terms(parameters, degree, values.len())?;
        Some(PolynomialFit::new(parameters, shares, &scaled, terms))
    });
    let mut best: Option<PolynomialFit> = None;
    let mut worse = 0;
    for fit in fits {
        let is_better = best.as_ref().is_none_or(|known| fit.error < known.error);
        worse = if is_better { 0 } else { worse + 1 };
        if is_better {
            best = Some(fit);
        }
        // Odd and even degrees take turns in functions that are even or odd.
        if worse == 2 {
            break;
        }
    }
    let best = best.ok_or_else(|| Error::inconsistent("study", "no polynomial fits"))?;
    Ok(best.sensitivity(parameters.len()))
}

/// A product of polynomials: the degree in each parameter.
type Term = Vec<usize>;

/// All of a total degree or less; `None` if they are too many for the draws, or no more than with
/// one degree less.
fn terms(parameters: &[Distribution], degree: usize, draws: usize) -> Option<Vec<Term>> {
    let most = (draws / DRAWS_PER_TERM).min((MOST_WORK / draws).isqrt());
    let mut all: Vec<Term> = vec![vec![]];
    for parameter in parameters {
        let highest = match parameter {
            Distribution::List(values) => values.len() - 1,
            _ => degree,
        };
        let longer = |term: &Term| {
            let left = degree - term.iter().sum::<usize>();
            let term = term.clone();
            (0..=left.min(highest)).map(move |next| {
                let mut longer = term.clone();
                longer.push(next);
                longer
            })
        };
        all = all.iter().flat_map(longer).take(most + 1).collect();
    }
    let is_new = all.iter().any(|term| term.iter().sum::<usize>() == degree);
    (all.len() <= most && is_new).then_some(all)
}

struct PolynomialFit {
    terms: Vec<Term>,
    coefficients: DVector<f64>,
    /// Variance of draws that their own fit did not see, relative to theirs.
    error: f64,
}

impl PolynomialFit {
    fn new(
        parameters: &[Distribution],
        shares: &[Vec<f64>],
        values: &DVector<f64>,
        terms: Vec<Term>,
    ) -> Self {
        let degree = terms.iter().flatten().copied().max().unwrap_or(0);
        let families: Vec<Family> = parameters.iter().map(|p| Family::new(p, degree)).collect();
        let mut matrix = DMatrix::zeros(shares.len(), terms.len());
        for (row, shares) in shares.iter().enumerate() {
            let factors: Vec<Vec<f64>> =
                families.iter().zip(shares).map(|(family, &u)| family.at(u)).collect();
            for (column, term) in terms.iter().enumerate() {
                let product = term.iter().zip(&factors).map(|(&degree, of)| of[degree]);
                matrix[(row, column)] = product.product();
            }
        }
        let qr = matrix.qr();
        let q = qr.q();
        let projected = q.tr_mul(values);
        let coefficients = qr.r().solve_upper_triangular(&projected);
        let Some(coefficients) = coefficients.filter(|c| c.iter().all(|c| c.is_finite())) else {
            let coefficients = DVector::zeros(terms.len());
            return Self { terms, coefficients, error: f64::INFINITY };
        };
        let residuals = values - &q * projected;
        // A draw's error without it in the fit: its residual over 1 minus its leverage.
        let left_out = residuals
            .iter()
            .zip(q.row_iter())
            .map(|(residual, row)| (residual / (1.0 - row.norm_squared()).max(1e-9)).powi(2));
        let mean = values.mean();
        let variance: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
        Self { terms, error: left_out.sum::<f64>() / variance, coefficients }
    }

    fn sensitivity(&self, parameters: usize) -> Sensitivity {
        let varies = |term: &Term| term.iter().any(|&degree| degree > 0);
        let part = |passes: &dyn Fn(&Term) -> bool| -> f64 {
            let parts = self.terms.iter().zip(self.coefficients.iter());
            parts.filter(|(term, _)| varies(term) && passes(term)).map(|(_, c)| c * c).sum()
        };
        let all = part(&|_| true).max(f64::MIN_POSITIVE);
        let alone = |term: &Term, p: usize| term.iter().sum::<usize>() == term[p];
        Sensitivity {
            first: (0..parameters).map(|p| part(&|term| alone(term, p)) / all).collect(),
            total: (0..parameters).map(|p| part(&|term| term[p] > 0) / all).collect(),
            explained: 1.0 - self.error,
        }
    }
}

/// Polynomials orthonormal in one parameter's distribution.
enum Family {
    /// In u, even between 0 and 1.
    Legendre(usize),
    /// In the standard normal variable.
    Hermite(usize),
    /// Values by degree and entry of a list.
    Discrete(Vec<Vec<f64>>),
}

impl Family {
    fn new(parameter: &Distribution, degree: usize) -> Self {
        match parameter {
            Distribution::Uniform { .. } => Self::Legendre(degree),
            Distribution::Normal { .. } => Self::Hermite(degree),
            Distribution::List(values) => Self::Discrete(discrete(values.len(), degree)),
        }
    }

    /// Values of degree 0, 1, … at share `u`.
    fn at(&self, u: f64) -> Vec<f64> {
        match self {
            Self::Legendre(degree) => {
                let x = 2.0 * u - 1.0;
                let next = |n: f64, p: f64, before: f64| {
                    ((2.0 * n + 1.0) * x * p - n * before) / (n + 1.0)
                };
                recurrence(*degree, x, next, |n| (2.0 * n + 1.0).sqrt())
            }
            Self::Hermite(degree) => {
                let x = normal_quantile(u);
                let norm = |n: f64| (1..=n as u32).map(f64::from).product::<f64>().sqrt().recip();
                recurrence(*degree, x, |n, p, before| x * p - n * before, norm)
            }
            Self::Discrete(values) => {
                let entries = values[0].len();
                let entry = ((u * entries as f64) as usize).min(entries - 1);
                values.iter().map(|of| of[entry]).collect()
            }
        }
    }
}

/// p₀ = 1, p₁ = x, p_{n+1} from n, p_n, p_{n−1}, each times its norm.
fn recurrence(
    degree: usize,
    x: f64,
    next: impl Fn(f64, f64, f64) -> f64,
    norm: impl Fn(f64) -> f64,
) -> Vec<f64> {
    let mut values = vec![1.0, x];
    for n in 1..degree {
        values.push(next(n as f64, values[n], values[n - 1]));
    }
    values.truncate(degree + 1);
    values.iter().enumerate().map(|(n, p)| p * norm(n as f64)).collect()
}

/// Gram and Schmidt's on 0, 1, … `entries` − 1, each met alike.
fn discrete(entries: usize, degree: usize) -> Vec<Vec<f64>> {
    let mean_product = |a: &[f64], b: &[f64]| -> f64 {
        a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / entries as f64
    };
    let place = |entry: usize| 2.0 * entry as f64 / (entries.max(2) - 1) as f64 - 1.0;
    let mut family: Vec<Vec<f64>> = vec![vec![1.0; entries]];
    for n in 1..=degree.min(entries - 1) {
        let mut next: Vec<f64> = (0..entries).map(|e| place(e) * family[n - 1][e]).collect();
        for _ in 0..2 {
            for known in &family {
                let share = mean_product(&next, known);
                next.iter_mut().zip(known).for_each(|(value, k)| *value -= share * k);
            }
        }
        let norm = mean_product(&next, &next).sqrt();
        family.push(next.iter().map(|value| value / norm).collect());
    }
    family
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::super::design::{Design, Draws};
    use super::*;

    fn of(parameters: &[Distribution], draws: usize, f: impl Fn(&[f64]) -> f64) -> Sensitivity {
        let plan = Draws::new(Design::Sobol, parameters, draws, 1);
        let shares: Vec<Vec<f64>> = (0..plan.count())
            .map(|draw| (0..parameters.len()).map(|p| plan.share(draw, p)).collect())
            .collect();
        let value = |shares: &Vec<f64>| {
            let at: Vec<f64> = parameters.iter().zip(shares).map(|(p, &u)| p.quantile(u)).collect();
            f(&at)
        };
        let values: Vec<f64> = shares.iter().map(value).collect();
        sensitivity(parameters, &shares, &values).unwrap()
    }

    fn assert_near(found: &[f64], expected: &[f64], tolerance: f64) {
        for (f, e) in found.iter().zip(expected) {
            assert!((f - e).abs() < tolerance, "{found:?}, expected {expected:?}");
        }
    }

    /// Ishigami and Homma's function, a = 7, b = 0.1: closed shares (Saltelli et al. 2008).
    #[test]
    fn ishigami() {
        let parameter = Distribution::Uniform { low: -PI, high: PI };
        let found = of(&vec![parameter; 3], 1000, |x| {
            x[0].sin() + 7.0 * x[1].sin().powi(2) + 0.1 * x[2].powi(4) * x[0].sin()
        });
        assert_near(&found.first, &[0.3139, 0.4424, 0.0], 0.002);
        assert_near(&found.total, &[0.5576, 0.4424, 0.2437], 0.002);
        assert!(found.explained > 0.999, "{found:?}");
    }

    /// A sum's shares are those of the variances, whatever the distributions.
    #[test]
    fn sums_of_all_distributions() {
        let parameters = [
            Distribution::Normal { mean: 5.0, sd: 2.0 },
            Distribution::Uniform { low: 0.0, high: 6.0 },
            Distribution::List(vec![0.0, 1.0, 5.0]),
        ];
        let variances = [4.0, 3.0, 14.0 / 3.0];
        let all: f64 = variances.iter().sum();
        let expected = variances.map(|v| v / all);
        // 500 draws: discrete ones are met 167, 167 and 166 times.
        let found = of(&parameters, 500, |x| x.iter().sum());
        assert_near(&found.first, &expected, 1e-9);
        assert_near(&found.total, &expected, 1e-9);
    }

    /// x y of two standard normal variables: no first order at all.
    #[test]
    fn a_product_is_all_interaction() {
        let parameter = Distribution::Normal { mean: 0.0, sd: 1.0 };
        let found = of(&vec![parameter; 2], 200, |x| x[0] * x[1]);
        assert_near(&found.first, &[0.0, 0.0], 1e-9);
        assert_near(&found.total, &[1.0, 1.0], 1e-9);
    }

    #[test]
    fn noise_is_not_explained() {
        let parameter = Distribution::Uniform { low: 0.0, high: 1.0 };
        let found = of(&[parameter], 300, |x| (x[0] * 1e7).sin());
        assert!(found.explained < 0.1, "{found:?}");
    }

    #[test]
    fn constants_and_too_few_draws() {
        let parameter = [Distribution::Uniform { low: 0.0, high: 1.0 }];
        assert_eq!(of(&parameter, 8, |_| 3.0).first, [0.0]);
        let few = sensitivity(&parameter, &vec![vec![0.5]; 3], &[1.0, 2.0, 3.0]).unwrap_err();
        assert_eq!(few.to_string(), "study: 3 draws, sensitivities need 4");
    }
}
