//! How a parameter of a study varies.

use std::f64::consts::{PI, SQRT_2};

use crate::error::{Error, Result};

/// What values a parameter takes, and how often.
#[derive(Debug, Clone, PartialEq)]
pub enum Distribution {
    /// Gauss's, with mean and standard deviation.
    Normal {
        /// Any finite number.
        mean: f64,
        /// Above 0.
        sd: f64,
    },
    /// Every value between two ends alike.
    Uniform {
        /// The lower end.
        low: f64,
        /// The upper end, above `low`.
        high: f64,
    },
    /// Each of some values alike.
    List(Vec<f64>),
}

impl Distribution {
    /// Checks the numbers; `parameter` is its name, for the message.
    ///
    /// Errors: [`Error::OutOfRange`] for a spread that is not above 0, an empty list, and numbers
    /// that are not finite.
    pub fn check(&self, parameter: &str) -> Result<()> {
        let refuse = |what: &str, value: String, allowed: &str| {
            Err(Error::out_of_range(
                &format!("study: parameter \"{parameter}\""),
                what,
                value,
                allowed,
            ))
        };
        match self {
            Self::Normal { mean, sd } if !(mean.is_finite() && sd.is_finite() && *sd > 0.0) => {
                refuse("normal", format!("{{{mean}, {sd}}}"), "a finite mean, a deviation above 0")
            }
            Self::Uniform { low, high } if !((high - low).is_finite() && low < high) => {
                refuse("uniform", format!("{{{low}, {high}}}"), "finite ends, the lower one first")
            }
            Self::List(values) if values.is_empty() || values.iter().any(|v| !v.is_finite()) => {
                refuse("list", format!("{values:?}"), "one or more finite numbers")
            }
            _ => Ok(()),
        }
    }

    /// The value that a share `u` of all draws does not exceed; `u` lies between 0 and 1.
    pub fn quantile(&self, u: f64) -> f64 {
        match self {
            Self::Normal { mean, sd } => mean + sd * normal_quantile(u),
            Self::Uniform { low, high } => low + u * (high - low),
            Self::List(values) => values[self.entry(u)],
        }
    }

    /// The place in the list that `u` stands for; 0 for the other distributions.
    pub(super) fn entry(&self, u: f64) -> usize {
        match self {
            Self::List(values) => ((u * values.len() as f64) as usize).min(values.len() - 1),
            _ => 0,
        }
    }
}

/// The argument at which the standard normal distribution reaches `u`, within 1e-14 of its size.
///
/// Range: 0 < u < 1. Source: Abramowitz & Stegun 26.2.23 as a start (4.5e-4), then Halley's steps.
pub fn normal_quantile(u: f64) -> f64 {
    if u > 0.5 {
        return -normal_quantile(1.0 - u); // exact: 1 − u is, for u ≥ 0.5
    }
    let t = (-2.0 * u.ln()).sqrt();
    let numerator = 2.515517 + t * (0.802853 + t * 0.010328);
    let denominator = 1.0 + t * (1.432788 + t * (0.189269 + t * 0.001308));
    let mut x = numerator / denominator - t;
    for _ in 0..3 {
        let excess = (normal_share(x) - u) * (2.0 * PI).sqrt() * (0.5 * x * x).exp();
        x -= excess / (1.0 + 0.5 * x * excess);
    }
    x
}

/// Share of a standard normal distribution below `x`.
fn normal_share(x: f64) -> f64 {
    0.5 * libm::erfc(-x / SQRT_2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_printed_tables() {
        // Abramowitz & Stegun, table 26.5: x where Q(x) = 1 − P(x).
        for (u, x) in [(0.5, 0.0), (0.975, 1.959_963_984_54), (0.999, 3.090_232_306_17)] {
            assert!((normal_quantile(u) - x).abs() < 1e-10, "{u}");
            assert!((normal_quantile(1.0 - u) + x).abs() < 1e-10, "{u}");
        }
    }

    #[test]
    fn quantile_and_share_undo_each_other_far_out() {
        for exponent in 1..300 {
            let u = 10f64.powi(-exponent);
            let back = normal_share(normal_quantile(u));
            assert!((back / u - 1.0).abs() < 1e-11, "{u}: {back}"); // erfc's own error grows as x²
        }
    }

    #[test]
    fn a_list_is_met_evenly() {
        let list = Distribution::List(vec![3.0, 1.0, 2.0]);
        let met: Vec<f64> = [0.0, 0.4, 0.99].map(|u| list.quantile(u)).to_vec();
        assert_eq!(met, [3.0, 1.0, 2.0]);
    }

    #[test]
    fn spreads_that_are_none_are_refused() {
        let bad = Distribution::Normal { mean: 0.0, sd: 0.0 };
        assert_eq!(
            bad.check("shift").unwrap_err().to_string(),
            "study: parameter \"shift\": normal is {0, 0}, allowed: a finite mean, a deviation above 0"
        );
        assert!(Distribution::Uniform { low: 2.0, high: 1.0 }.check("x").is_err());
        assert!(Distribution::List(vec![]).check("x").is_err());
        assert!(Distribution::List(vec![f64::NAN]).check("x").is_err());
    }
}
