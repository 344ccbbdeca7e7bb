//! What the draws of a study tell of one result, with how well they tell it.

use crate::statistics::percentile;

/// An estimate with the ends of its 95 % confidence interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// The estimate.
    pub value: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// Standard deviations on either side of the mean that hold 95 % of a normal distribution.
const Z_95: f64 = 1.959_963_984_540_054;

/// Mean of the values; NaN without any.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Standard deviation of what the values are drawn from (n − 1); 0 of a single one.
pub fn standard_deviation(values: &[f64]) -> f64 {
    let mean = mean(values);
    let square: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (square / (values.len().max(2) - 1) as f64).sqrt()
}

/// What `percent` of all draws do not exceed; `None` without values.
///
/// The interval is that of independent draws: the ranks which the binomial distribution, taken as a
/// normal one, gives in 95 % of all studies. Even designs do better.
pub fn percentile_interval(values: &[f64], percent: f64) -> Option<Interval> {
    let share = percent / 100.0;
    let spread = 100.0 * Z_95 * (share * (1.0 - share) / values.len() as f64).sqrt();
    let at = |percent: f64| percentile(&mut values.to_vec(), percent.clamp(0.0, 100.0));
    Some(Interval { value: at(percent)?, low: at(percent - spread)?, high: at(percent + spread)? })
}

/// Share of draws that pass, with Wilson's interval (1927); `None` without draws.
pub fn probability(passed: usize, draws: usize) -> Option<Interval> {
    let n = draws as f64;
    let value = (draws > 0).then(|| passed as f64 / n)?;
    let shrink = 1.0 + Z_95 * Z_95 / n;
    let center = (value + Z_95 * Z_95 / (2.0 * n)) / shrink;
    let half = Z_95 / shrink * (value * (1.0 - value) / n + Z_95 * Z_95 / (4.0 * n * n)).sqrt();
    Some(Interval { value, low: (center - half).max(0.0), high: (center + half).min(1.0) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::study::normal_quantile;
    use crate::source::sequence::random;

    #[test]
    fn moments_by_hand() {
        let values = [1.0, 2.0, 3.0, 6.0];
        assert_eq!(mean(&values), 3.0);
        assert!((standard_deviation(&values) - (14.0f64 / 3.0).sqrt()).abs() < 1e-15);
        assert_eq!(standard_deviation(&[5.0]), 0.0);
    }

    /// Wilson's interval of 81 of 263 (Newcombe 1998, table I: 0.2553 to 0.3662).
    #[test]
    fn probability_is_the_printed_one() {
        let found = probability(81, 263).unwrap();
        assert!((found.low - 0.2553).abs() < 5e-5 && (found.high - 0.3662).abs() < 5e-5);
        assert_eq!(probability(0, 10).unwrap().low, 0.0);
        assert_eq!(probability(0, 0), None);
    }

    /// Among 400 sets of 200 draws some 95 % hold the true percentile: 380 ± 3 · 4.4.
    #[test]
    fn percentiles_lie_in_their_interval() {
        let truth = normal_quantile(0.9);
        let holds = |set: u64| {
            let values: Vec<f64> =
                (0..200).map(|i| normal_quantile(random(set, i, 0).max(1e-12))).collect();
            let found = percentile_interval(&values, 90.0).unwrap();
            (found.low..=found.high).contains(&truth)
        };
        let held = (0..400).filter(|&set| holds(set)).count();
        assert!((366..=393).contains(&held), "{held}");
    }
}
