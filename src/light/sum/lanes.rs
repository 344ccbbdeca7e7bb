//! The elementary functions of the f32 kernels, branch-free so that loops over them vectorize.
//!
//! Only +, −, ×, ÷, comparisons and bit operations, in a fixed order: every CPU gives the same
//! bits, whatever the width of its vectors.

/// A lobe below e^−70 counts as 0, so that f32 never meets a subnormal.
pub(crate) const LARGEST_EXPONENT: f32 = 70.0;

/// e^−y for y ≥ 0; 0 above [`LARGEST_EXPONENT`]. Relative error under 3e-7.
#[inline(always)]
pub(crate) fn exp_neg(y: f32) -> f32 {
    const LN2_HIGH: f32 = 0.693_359_4; // ln 2 to 12 bits, so that k × LN2_HIGH is exact
    const LN2_LOW: f32 = -2.121_944_4e-4;
    const TO_INTEGER: f32 = 12_582_912.0; // 1.5 · 2²³: adding it rounds to an integer
    let clamped = if y < LARGEST_EXPONENT { y } else { LARGEST_EXPONENT };
    let shifted = clamped * std::f32::consts::LOG2_E + TO_INTEGER;
    let k = shifted - TO_INTEGER;
    let r = (k * LN2_HIGH - clamped) + k * LN2_LOW; // −y = r − k ln 2, |r| ≤ ln 2 / 2
    let tail = (1.0 / 120.0 + r * (1.0 / 720.0 + r * (1.0 / 5040.0))) * r + 1.0 / 24.0;
    let series = 1.0 + r * (1.0 + r * (0.5 + r * (1.0 / 6.0 + r * tail)));
    let exponent = 127u32.wrapping_sub(shifted.to_bits().wrapping_sub(TO_INTEGER.to_bits()));
    let value = series * f32::from_bits(exponent << 23);
    if y < LARGEST_EXPONENT { value } else { 0.0 }
}

/// −ln(1 − x) for 0 ≤ x < 1, relative error under 4e-7.
///
/// x is a sine squared (−ln cos² then) or 1 − cos: what keeps its digits where a cosine is near 1.
#[inline(always)]
pub(crate) fn neg_ln_1m(x: f32) -> f32 {
    let w = 1.0 - x;
    let lost = (1.0 - w) - x; // exact where it matters: 1 − x = w + lost
    neg_ln(w) - lost
}

/// −ln w for normal w > 0, relative error under 4e-7.
#[inline(always)]
pub(crate) fn neg_ln(w: f32) -> f32 {
    const SQRT_HALF_BITS: u32 = 0x3f35_04f3;
    // (ln(1 + f) − f + f²/2)/f³, interpolated at Chebyshev nodes of √½ − 1 … √2 − 1: relative
    // error of ln(1 + f) under 1.3e-7. Cheaper than a division.
    const TAIL: [f32; 7] = [
        0.333_334_15,
        -0.250_007_03,
        0.199_842_23,
        -0.166_027_19,
        0.147_039,
        -0.140_308_92,
        0.090_487_845,
    ];
    let bits = w.to_bits().wrapping_add(0x3f80_0000 - SQRT_HALF_BITS);
    let k = (bits >> 23) as i32 - 127;
    let m = f32::from_bits((bits & 0x007f_ffff) + SQRT_HALF_BITS); // √½ ≤ m < √2
    let f = m - 1.0;
    let f2 = f * f;
    let low = (TAIL[0] + f * TAIL[1]) + f2 * (TAIL[2] + f * TAIL[3]);
    let high = (TAIL[4] + f * TAIL[5]) + f2 * TAIL[6];
    let ln_m = f - f2 * (0.5 - f * (low + f2 * f2 * high));
    k as f32 * -std::f32::consts::LN_2 - ln_m
}

/// 1/√x for normal x > 0, relative error under 2e-7.
///
/// Newton's iteration from the bit pattern: an eighth of the time of a root and a division, and,
/// unlike the processors' own approximations, the same bits everywhere.
#[inline(always)]
pub(crate) fn inverse_sqrt(x: f32) -> f32 {
    let half = 0.5 * x;
    let mut y = f32::from_bits(0x5f37_59dfu32.wrapping_sub(x.to_bits() >> 1));
    y = y * (1.5 - half * y * y);
    y = y * (1.5 - half * y * y);
    y * (1.5 - half * y * y)
}

/// `larger(x, 0)` without the NaN rules of `f32::max`, which cost instructions.
#[inline(always)]
pub(crate) fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[inline(always)]
pub(crate) fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponential_keeps_its_digits_over_its_whole_range() {
        for i in 0..700_000 {
            let y = i as f32 * 1e-4;
            let exact = (-f64::from(y)).exp();
            let error = (f64::from(exp_neg(y)) / exact - 1.0).abs();
            assert!(error < 3e-7, "exp(-{y}): relative error {error:e}");
        }
        assert_eq!(exp_neg(LARGEST_EXPONENT), 0.0);
        assert_eq!(exp_neg(f32::INFINITY), 0.0);
        assert_eq!(exp_neg(0.0), 1.0);
    }

    #[test]
    fn logarithm_of_a_cosine_keeps_its_digits_near_one() {
        for i in 1..1_000_000 {
            let x = (i as f32 * 1e-6).powi(3);
            let exact = -(-f64::from(x)).ln_1p();
            let error = (f64::from(neg_ln_1m(x)) / exact - 1.0).abs();
            assert!(error < 4e-7, "-ln(1 - {x:e}): relative error {error:e}");
        }
        assert_eq!(neg_ln_1m(0.0), 0.0);
    }

    #[test]
    fn inverse_root_keeps_its_digits_at_any_scale() {
        for i in 0..600_000 {
            let x = 10f32.powf(i as f32 * 1e-4 - 30.0);
            let error = (f64::from(inverse_sqrt(x)) * f64::from(x).sqrt() - 1.0).abs();
            assert!(error < 2e-7, "1/sqrt({x:e}): relative error {error:e}");
        }
    }
}
