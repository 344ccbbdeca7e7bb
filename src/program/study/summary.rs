//! What the draws of a study tell of one result, with how well they tell it.

use crate::statistics::percentile;

/// An estimate with the ends of a confidence interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// The estimate.
    pub value: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// Share of studies whose interval holds the truth.
    pub confidence: f64,
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
/// The interval lies between two of the values in their order, as the binomial distribution gives it
/// for independent draws whatever they are drawn from (David & Nagaraja, Order statistics, 7.1);
/// even designs do better. It holds 95 %, or what so few draws allow, out to the least and the largest.
pub fn percentile_interval(values: &[f64], percent: f64) -> Option<Interval> {
    let value = percentile(&mut values.to_vec(), percent)?;
    let [low, high] = ranks(values.len(), percent / 100.0);
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let confidence = (low..high).map(|below| binomial(values.len(), percent / 100.0, below)).sum();
    Some(Interval { value, low: sorted[low - 1], high: sorted[high - 1], confidence })
}

/// Ranks (from 1) of the values between which the percentile lies: no more than 2.5 % beyond either,
/// as far as there are values.
fn ranks(n: usize, share: f64) -> [usize; 2] {
    let mut below = 0.0;
    let mut ranks = [0, n];
    for count in 0..n {
        below += binomial(n, share, count);
        if below <= 0.5 * BEYOND {
            ranks[0] = count + 1;
        }
        if below >= 1.0 - 0.5 * BEYOND {
            ranks[1] = count + 1;
            break;
        }
    }
    [ranks[0].max(1), ranks[1]]
}

/// Share of intervals that may miss the truth.
const BEYOND: f64 = 0.05;

/// Probability of `count` among `n` draws of a share.
fn binomial(n: usize, share: f64, count: usize) -> f64 {
    let [all, some] = [n as f64, count as f64];
    // 0 ln 0 is 0.
    let power = |exponent: f64, base: f64| if exponent == 0.0 { 0.0 } else { exponent * base.ln() };
    let choose =
        libm::lgamma(all + 1.0) - libm::lgamma(some + 1.0) - libm::lgamma(all - some + 1.0);
    (choose + power(some, share) + power(all - some, 1.0 - share)).exp()
}

/// Share of draws that pass, with Wilson's interval (1927); `None` without draws.
pub fn probability(passed: usize, draws: usize) -> Option<Interval> {
    let n = draws as f64;
    let value = (draws > 0).then(|| passed as f64 / n)?;
    let shrink = 1.0 + Z_95 * Z_95 / n;
    let center = (value + Z_95 * Z_95 / (2.0 * n)) / shrink;
    let half = Z_95 / shrink * (value * (1.0 - value) / n + Z_95 * Z_95 / (4.0 * n * n)).sqrt();
    let [low, high] = [(center - half).max(0.0), (center + half).min(1.0)];
    Some(Interval { value, low, high, confidence: 1.0 - BEYOND })
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

    /// Among ten values the median lies between the 2nd and the 9th with 1 − 2 (1 + 10)/2¹⁰; the largest
    /// of 20 lies above the 95th percentile with 1 − 0.95²⁰, and nothing lies above the 100th.
    #[test]
    fn ranks_are_those_of_the_binomial_distribution() {
        let values = |n: usize| (1..=n).map(|v| v as f64).collect::<Vec<_>>();
        let found = percentile_interval(&values(10), 50.0).unwrap();
        assert_eq!([found.low, found.high], [2.0, 9.0]);
        assert!((found.confidence - (1.0 - 22.0 / 1024.0)).abs() < 1e-12);
        let few = percentile_interval(&values(20), 95.0).unwrap();
        assert_eq!([few.low, few.high], [17.0, 20.0]);
        assert!((0.62..1.0 - 0.95f64.powi(20) + 1e-12).contains(&few.confidence), "{few:?}");
        let most = percentile_interval(&values(20), 100.0).unwrap();
        assert_eq!([most.low, most.high, most.confidence], [20.0, 20.0, 0.0]);
        let many = percentile_interval(&values(65_536), 99.9).unwrap();
        assert!((0.95..0.96).contains(&many.confidence), "{many:?}");
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
