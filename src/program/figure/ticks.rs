//! Where an axis is marked, and how.

use super::Scale;

/// A mark on an axis; labels of minor marks are empty.
#[derive(Debug, Clone, PartialEq)]
pub struct Tick {
    /// Where it is on the axis.
    pub value: f64,
    /// What stands beside it.
    pub label: String,
}

/// Marks of an axis over `range`, about `count` of them labeled.
pub fn ticks(scale: Scale, range: [f64; 2], count: usize) -> Vec<Tick> {
    match scale {
        Scale::Linear => linear(range, count),
        Scale::Log => log(range, count),
    }
}

/// At multiples of 1, 2 or 5 times a power of ten.
fn linear([from, to]: [f64; 2], count: usize) -> Vec<Tick> {
    if !(to - from).is_finite() {
        return Vec::new();
    }
    let rough = (to - from) / count.max(1) as f64;
    let power = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|s| *s >= rough * 0.999);
    let step = step.unwrap_or(rough);
    let decimals = (-step.log10().floor()).clamp(0.0, 12.0) as usize;
    let (first, last) = ((from / step - 1e-9).ceil() as i64, (to / step + 1e-9).floor() as i64);
    (first..=last)
        .map(|i| {
            let value = i as f64 * step;
            Tick { value, label: label(value, decimals) }
        })
        .collect()
}

fn label(value: f64, decimals: usize) -> String {
    let large = value.abs() >= 1e6 || (decimals > 5 && value != 0.0);
    if large { format!("{value:.1e}") } else { format!("{value:.decimals$}") }
}

/// At powers of ten, or where there are fewer than two of them at 1, 2 and 5 times; minor marks
/// between.
fn log([from, to]: [f64; 2], count: usize) -> Vec<Tick> {
    // What room at the ends makes of the outermost numbers may be 0 or infinite.
    let (from, to) = (from.max(f64::MIN_POSITIVE), to.min(1e308));
    let (first, last) = (from.log10().floor() as i32, to.log10().ceil() as i32);
    let inside = |value: f64| (from * (1.0 - 1e-9)..=to * (1.0 + 1e-9)).contains(&value);
    let powers = (first..=last).filter(|&p| inside(10f64.powi(p))).count();
    let every = powers.div_ceil(count.max(1)).max(1) as i32;
    let mut ticks = Vec::new();
    for power in first..=last {
        for digit in 1..10 {
            let value = f64::from(digit) * 10f64.powi(power);
            let labeled = match powers {
                0 | 1 => matches!(digit, 1 | 2 | 5),
                _ => digit == 1 && power.rem_euclid(every) == 0,
            };
            if inside(value) && (labeled || every == 1) {
                let label = if labeled { power_label(digit, power) } else { String::new() };
                ticks.push(Tick { value, label });
            }
        }
    }
    ticks
}

fn power_label(digit: i32, power: i32) -> String {
    if (-3..=4).contains(&power) {
        let decimals = (-power).max(0) as usize;
        return format!("{:.decimals$}", f64::from(digit) * 10f64.powi(power));
    }
    let superscripts = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let digits = power.unsigned_abs().to_string();
    let raised: String = digits.bytes().map(|b| superscripts[usize::from(b - b'0')]).collect();
    let sign = if power < 0 { "⁻" } else { "" };
    let factor = if digit == 1 { String::new() } else { format!("{digit}·") };
    format!("{factor}10{sign}{raised}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(scale: Scale, range: [f64; 2]) -> Vec<String> {
        let all = ticks(scale, range, 5);
        all.into_iter().map(|tick| tick.label).filter(|label| !label.is_empty()).collect()
    }

    #[test]
    fn linear_marks_are_round() {
        assert_eq!(labels(Scale::Linear, [0.0, 1.0]), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(labels(Scale::Linear, [-30.0, 255.0]), ["0", "100", "200"]);
        assert_eq!(labels(Scale::Linear, [380.0, 780.0]), ["400", "500", "600", "700"]);
    }

    #[test]
    fn log_marks_are_powers() {
        assert_eq!(labels(Scale::Log, [0.01, 100.0]), ["0.01", "0.1", "1", "10", "100"]);
        assert_eq!(labels(Scale::Log, [1.5, 9.0]), ["2", "5"]);
        assert_eq!(labels(Scale::Log, [1e-6, 1e-5]), ["10⁻⁶", "10⁻⁵"]);
        for range in [[1e-30, 1e30], [0.0, f64::INFINITY]] {
            assert!((3..=6).contains(&labels(Scale::Log, range).len()));
        }
    }
}
