//! What many numbers are like: one rule each, for images, checks and studies.

/// What `percent` of the values do not exceed, linear between their ranks; `None` without values.
pub fn percentile(values: &mut [f64], percent: f64) -> Option<f64> {
    let last = values.len().checked_sub(1)?;
    let place = percent / 100.0 * last as f64;
    let below = (place as usize).min(last);
    let (_, &mut low, above) = values.select_nth_unstable_by(below, f64::total_cmp);
    let high = above.iter().copied().fold(f64::INFINITY, f64::min);
    let t = place - below as f64;
    Some(if t > 0.0 && high.is_finite() { low + t * (high - low) } else { low })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentile_lies_between_ranks() {
        for (percent, expected) in [(0.0, 0.0), (50.0, 2.0), (99.5, 3.98), (100.0, 4.0)] {
            let value = percentile(&mut [3.0, 0.0, 1.0, 2.0, 4.0], percent).unwrap();
            assert!((value - expected).abs() < 1e-12, "{percent}: {value}");
        }
        assert_eq!(percentile(&mut [7.0], 99.5), Some(7.0));
        assert_eq!(percentile(&mut [], 99.5), None);
    }
}
