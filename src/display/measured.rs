//! A tone curve through measured levels, for displays that eq. 5 does not describe.

use crate::error::{Error, Result};

/// Light of a channel, relative to its full output, from its signal, through measured levels.
///
/// A monotone cubic (Fritsch & Carlson, SIAM J. Numer. Anal. 17 (1980) 238) of light to the power of
/// 1/2.2, which is nearly straight for a display, so that a few levels do. Levels that noise makes
/// fall are held.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredCurve {
    /// Strictly ascending, from 0 to 1; two at least.
    signals: Vec<f64>,
    /// Light to the power of 1/[`POWER`], ascending, from 0 to 1; one for each signal.
    heights: Vec<f64>,
    slopes: Vec<f64>,
}

const POWER: f64 = 2.2;
/// Halvings that find a signal to 1e-9.
const HALVINGS: u32 = 30;

impl MeasuredCurve {
    /// From signals and light, both relative to full; signal 0 has no light if it is not among them.
    ///
    /// Errors: [`Error::Inconsistent`], naming `object`, for fewer than two levels, signals that do
    /// not ascend to 1, or light that is not finite.
    pub fn new(object: &str, levels: &[(f64, f64)]) -> Result<Self> {
        let good = levels.windows(2).all(|pair| pair[0].0 < pair[1].0)
            && levels.iter().all(|level| level.0 >= 0.0 && level.1.is_finite())
            && levels.last().is_some_and(|level| level.0 == 1.0 && level.1 > 0.0);
        if !good {
            let problem = "a measured curve needs ascending levels up to full output";
            return Err(Error::inconsistent(object, problem));
        }
        let starts_dark = levels[0].0 > 0.0;
        let dark = starts_dark.then_some((0.0, 0.0));
        let full = levels[levels.len() - 1].1;
        let (mut signals, mut heights) = (Vec::new(), Vec::new());
        let mut highest = 0.0f64;
        for (signal, light) in dark.into_iter().chain(levels.iter().copied()) {
            highest = highest.max((light / full).clamp(0.0, 1.0).powf(1.0 / POWER));
            signals.push(signal);
            heights.push(highest);
        }
        if signals.len() < 2 {
            let problem = "a measured curve needs two levels or more";
            return Err(Error::inconsistent(object, problem));
        }
        let slopes = slopes(&signals, &heights);
        Ok(Self { signals, heights, slopes })
    }

    /// Signals and light at the levels.
    pub fn levels(&self) -> impl Iterator<Item = (f64, f64)> {
        self.signals.iter().zip(&self.heights).map(|(&x, &h)| (x, h.powf(POWER)))
    }

    /// Light from signal, 0 to 1 (in place of eq. 5).
    pub fn light(&self, signal: f64) -> f64 {
        let signal = signal.clamp(0.0, 1.0);
        let after = self.signals.partition_point(|&x| x < signal);
        self.height(after.clamp(1, self.signals.len() - 1), signal).clamp(0.0, 1.0).powf(POWER)
    }

    /// Signal from light (in place of eq. 8), clipped to 0 to 1; no light is signal 0.
    pub fn signal(&self, light: f64) -> f64 {
        let wanted = light.clamp(0.0, 1.0).powf(1.0 / POWER);
        if wanted <= self.heights[0] {
            return 0.0;
        }
        let after = self.heights.partition_point(|&h| h < wanted);
        let after = after.clamp(1, self.heights.len() - 1);
        let (mut low, mut high) = (self.signals[after - 1], self.signals[after]);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            let is_below = self.height(after, middle) < wanted;
            (low, high) = if is_below { (middle, high) } else { (low, middle) };
        }
        high
    }

    /// Hermite's cubic between the levels before and at `after`.
    fn height(&self, after: usize, signal: f64) -> f64 {
        let (x0, x1) = (self.signals[after - 1], self.signals[after]);
        let (h0, h1) = (self.heights[after - 1], self.heights[after]);
        let (m0, m1) = (self.slopes[after - 1], self.slopes[after]);
        let width = x1 - x0;
        let t = (signal - x0) / width;
        let u = 1.0 - t;
        let ends = h0 * (1.0 + 2.0 * t) * u * u + h1 * t * t * (3.0 - 2.0 * t);
        ends + width * t * u * (m0 * u - m1 * t)
    }
}

/// Slopes that keep the cubics monotone: none where the levels turn or rest, and the harmonic mean
/// of both sides' elsewhere.
fn slopes(x: &[f64], h: &[f64]) -> Vec<f64> {
    let steps: Vec<f64> = (1..x.len()).map(|i| (h[i] - h[i - 1]) / (x[i] - x[i - 1])).collect();
    let last = steps.len() - 1;
    let slope = |i: usize| match i {
        0 => steps[0],
        i if i > last => steps[last],
        i if steps[i - 1] <= 0.0 || steps[i] <= 0.0 => 0.0,
        i => 2.0 / (steps[i - 1].recip() + steps[i].recip()),
    };
    (0..x.len()).map(slope).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(levels: usize, light: impl Fn(f64) -> f64) -> MeasuredCurve {
        let signal = |i: usize| i as f64 / (levels - 1) as f64;
        let levels: Vec<(f64, f64)> = (0..levels).map(|i| (signal(i), light(signal(i)))).collect();
        MeasuredCurve::new("t", &levels).unwrap()
    }

    fn s_curve(x: f64) -> f64 {
        x * x / (x * x + 3.0 * (1.0 - x).powi(2))
    }

    #[test]
    fn smooth_curves_come_back_from_few_levels() {
        // Errors of a cubic through 17 levels; an S-curve bends most.
        for (light, bound) in [(s_curve as fn(f64) -> f64, 3e-3), (|x| x.powf(1.8), 5e-4)] {
            let curve = curve(17, light);
            for k in 0..=1000 {
                let x = f64::from(k) / 1000.0;
                assert!((curve.light(x) - light(x)).abs() < bound, "{x}");
            }
        }
    }

    #[test]
    fn signals_come_back_from_light() {
        let curve = curve(9, s_curve);
        for digit in 0..=255 {
            let signal = f64::from(digit) / 255.0;
            assert!((curve.signal(curve.light(signal)) - signal).abs() < 1e-6, "{digit}");
        }
        assert_eq!((curve.signal(0.0), curve.signal(-1.0), curve.light(0.0)), (0.0, 0.0, 0.0));
        assert!((curve.signal(2.0) - 1.0).abs() < 1e-8);
    }

    #[test]
    fn levels_that_fall_are_held_and_bad_ones_refused() {
        let held =
            MeasuredCurve::new("t", &[(0.0, 0.0), (0.5, 0.4), (0.6, 0.39), (1.0, 1.0)]).unwrap();
        let mut last = -1.0;
        for k in 0..=100 {
            let light = held.light(f64::from(k) / 100.0);
            // A flat piece is flat to rounding.
            assert!(light >= last - 1e-15, "{k}");
            last = light;
        }
        for bad in [
            &[][..],
            &[(1.0, f64::NAN)],
            &[(0.0, 0.0), (0.5, 1.0)],
            &[(0.5, 0.1), (0.5, 0.2), (1.0, 1.0)],
        ] {
            assert!(MeasuredCurve::new("t", bad).is_err(), "{bad:?}");
        }
    }
}
