//! The tone curve of one display channel (eq. 5 and 8).

/// Light of a channel, relative to its full output, from its signal x = d/(2ⁿ − 1).
///
/// max(0, gain x + offset)^gamma (eq. 5), and below `toe.end` the line `toe.slope` x, if there is
/// a toe: sRGB's curve is a GOG curve with one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Curve {
    /// k_g, > 0.
    pub gain: f64,
    /// k_o.
    pub offset: f64,
    /// γ, > 0.
    pub gamma: f64,
    pub toe: Option<Toe>,
}

/// What the matrix of eq. 7 leaves of a channel without light is rounding, near 1e-16 of full
/// output, which eq. 8 would lift to the end of the dead zone.
const NO_LIGHT: f64 = 1e-12;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Toe {
    pub slope: f64,
    /// Signal up to which the line holds.
    pub end: f64,
}

impl Curve {
    pub const fn gog(gain: f64, offset: f64, gamma: f64) -> Self {
        Self { gain, offset, gamma, toe: None }
    }

    /// IEC 61966-2-1.
    pub const SRGB: Self = Self {
        gain: 1.0 / 1.055,
        offset: 0.055 / 1.055,
        gamma: 2.4,
        toe: Some(Toe { slope: 1.0 / 12.92, end: 0.04045 }),
    };

    /// Light from signal, 0 to 1 (eq. 5).
    pub fn light(&self, signal: f64) -> f64 {
        match self.toe {
            Some(toe) if signal <= toe.end => toe.slope * signal,
            _ => (self.gain * signal + self.offset).max(0.0).powf(self.gamma),
        }
    }

    /// Signal from light (eq. 8), clipped to 0 to 1; no light is signal 0.
    pub fn signal(&self, light: f64) -> f64 {
        if light <= NO_LIGHT {
            return 0.0;
        }
        let signal = match self.toe {
            Some(toe) if light <= toe.slope * toe.end => light / toe.slope,
            _ => (light.powf(1.0 / self.gamma) - self.offset) / self.gain,
        };
        signal.clamp(0.0, 1.0)
    }

    /// Signal below which the curve is flat at 0: 0 unless the offset is negative.
    pub fn dead_zone(&self) -> f64 {
        (-self.offset / self.gain).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_is_the_standard_curve() {
        for digit in 0..=255 {
            let signal = f64::from(digit) / 255.0;
            let standard = crate::color::srgb_decode(signal);
            assert!((Curve::SRGB.light(signal) - standard).abs() < 1e-15);
            assert!((Curve::SRGB.signal(standard) - signal).abs() < 1e-6);
        }
    }

    #[test]
    fn negative_offset_is_flat_below_the_dead_zone() {
        let curve = Curve::gog(1.0204, -0.0204, 1.9095);
        assert_eq!(curve.light(5.0 / 255.0 * 0.99), 0.0);
        assert!(curve.light(6.0 / 255.0) > 0.0);
        assert_eq!(curve.signal(0.0), 0.0);
        assert!((curve.dead_zone() * 255.0 - 5.098).abs() < 1e-3);
    }

    #[test]
    fn clipped_to_what_the_display_has() {
        let curve = Curve::gog(0.8997, 0.1003, 2.1514);
        assert_eq!(curve.signal(1.5), 1.0);
        // Darker than digit 0 shows.
        assert_eq!(curve.signal(1e-6), 0.0);
        assert_eq!(curve.signal(-1.0), 0.0);
    }
}
