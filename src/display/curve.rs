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
    /// The straight line near black.
    pub toe: Option<Toe>,
    /// The perceptual quantizer of HDR displays in place of the rest, with the luminance of full
    /// output in cd/m², up to [`PQ_MAX_CD_M2`].
    pub pq_peak_cd_m2: Option<f64>,
}

/// Luminance of PQ's signal 1. Source: SMPTE ST 2084.
pub const PQ_MAX_CD_M2: f64 = 10_000.0;

/// What the matrix of eq. 7 leaves of a channel without light is rounding, near 1e-16 of full
/// output, which eq. 8 would lift to the end of the dead zone.
const NO_LIGHT: f64 = 1e-12;

/// The straight line of a tone curve near black.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Toe {
    /// Light per signal.
    pub slope: f64,
    /// Signal up to which the line holds.
    pub end: f64,
}

impl Curve {
    /// Eq. 5: gain, offset and gamma.
    pub const fn gog(gain: f64, offset: f64, gamma: f64) -> Self {
        Self { gain, offset, gamma, toe: None, pq_peak_cd_m2: None }
    }

    /// ST 2084, for a display whose full output is `peak_cd_m2`: brighter signals are that.
    pub const fn pq(peak_cd_m2: f64) -> Self {
        let pq_peak_cd_m2 = Some(peak_cd_m2);
        Self { gain: 1.0, offset: 0.0, gamma: 1.0, toe: None, pq_peak_cd_m2 }
    }

    /// IEC 61966-2-1.
    pub const SRGB: Self = Self {
        gain: 1.0 / 1.055,
        offset: 0.055 / 1.055,
        gamma: 2.4,
        toe: Some(Toe { slope: 1.0 / 12.92, end: 0.04045 }),
        pq_peak_cd_m2: None,
    };

    /// Light from signal, 0 to 1 (eq. 5).
    pub fn light(&self, signal: f64) -> f64 {
        if let Some(peak) = self.pq_peak_cd_m2 {
            return (pq_luminance(signal) / peak).min(1.0);
        }
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
        if let Some(peak) = self.pq_peak_cd_m2 {
            return pq_signal(light.min(1.0) * peak);
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

/// Constants of ST 2084.
const M: [f64; 2] = [2610.0 / 16384.0, 2523.0 / 32.0];
const C: [f64; 3] = [3424.0 / 4096.0, 2413.0 / 128.0, 2392.0 / 128.0];

/// cd/m² of a PQ signal, 0 to 1.
fn pq_luminance(signal: f64) -> f64 {
    let power = signal.max(0.0).powf(1.0 / M[1]);
    let linear = ((power - C[0]).max(0.0) / (C[1] - C[2] * power)).powf(1.0 / M[0]);
    PQ_MAX_CD_M2 * linear
}

/// Inverse of [`pq_luminance`].
fn pq_signal(luminance_cd_m2: f64) -> f64 {
    let power = (luminance_cd_m2 / PQ_MAX_CD_M2).clamp(0.0, 1.0).powf(M[0]);
    ((C[0] + C[1] * power) / (1.0 + C[2] * power)).powf(M[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ITU-R BT.2408-7, table 4: 100 cd/m² is 0.508, 203 is 0.581, 1000 is 0.752; ST 2084: 10000
    /// is 1.
    #[test]
    fn pq_has_its_published_levels() {
        for (luminance, signal) in [(100.0, 0.508), (203.0, 0.581), (1000.0, 0.752), (1e4, 1.0)] {
            assert!((pq_signal(luminance) - signal).abs() < 6e-4, "{luminance}");
            assert!((pq_luminance(pq_signal(luminance)) / luminance - 1.0).abs() < 1e-9);
        }
        let display = Curve::pq(1000.0);
        assert_eq!((display.light(1.0), display.signal(0.0)), (1.0, 0.0));
        assert!((display.light(display.signal(0.25)) - 0.25).abs() < 1e-9);
        assert_eq!(display.signal(7.0), display.signal(1.0), "clipped at the peak");
    }

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
