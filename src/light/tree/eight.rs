//! Eight f32 side by side: the children of a node.

use std::ops::{Add, Mul, Neg, Sub};

use crate::light::sum::lanes::{exp_neg, inverse_sqrt, larger, neg_ln, neg_ln_1m, smaller};

#[derive(Debug, Clone, Copy)]
#[repr(C, align(32))]
pub(super) struct Eight(pub [f32; 8]);

/// Exponents from which a lobe counts near its axis only: e^(−25 n/24) is below
/// [`super::lobe::NEGLIGIBLE`].
const STEEP: f32 = 40.0;

/// A vector a lane.
pub(super) type Vectors = [Eight; 3];

impl Eight {
    pub const ZERO: Eight = Eight([0.0; 8]);

    #[inline(always)]
    pub fn splat(value: f32) -> Eight {
        Eight([value; 8])
    }

    #[inline(always)]
    pub fn map(self, f: impl Fn(f32) -> f32) -> Eight {
        let mut out = self.0;
        for lane in &mut out {
            *lane = f(*lane);
        }
        Eight(out)
    }

    #[inline(always)]
    pub fn zip(self, other: Eight, f: impl Fn(f32, f32) -> f32) -> Eight {
        lanes(|i| f(self.0[i], other.0[i]))
    }

    #[inline(always)]
    pub fn larger(self, other: Eight) -> Eight {
        self.zip(other, larger)
    }

    #[inline(always)]
    pub fn smaller(self, other: Eight) -> Eight {
        self.zip(other, smaller)
    }

    #[inline(always)]
    pub fn at_least(self, low: f32) -> Eight {
        self.larger(Eight::splat(low))
    }

    #[inline(always)]
    pub fn at_most(self, high: f32) -> Eight {
        self.smaller(Eight::splat(high))
    }

    #[inline(always)]
    pub fn abs(self) -> Eight {
        self.map(f32::abs)
    }

    #[inline(always)]
    pub fn inverse_sqrt(self) -> Eight {
        self.at_least(f32::MIN_POSITIVE).map(inverse_sqrt)
    }

    /// To 0.2 %, for error estimates.
    #[inline(always)]
    pub fn rough_sqrt(self) -> Eight {
        self.at_least(f32::MIN_POSITIVE).map(|x| {
            let y = f32::from_bits(0x5f37_59dfu32.wrapping_sub(x.to_bits() >> 1));
            x * y * (1.5 - 0.5 * x * y * y)
        })
    }

    #[inline(always)]
    pub fn recip(self) -> Eight {
        self.map(|v| 1.0 / v)
    }

    /// cosⁿ of an angle given by both: small sines keep their digits in sin², small cosines in
    /// the cosine.
    #[inline(always)]
    pub fn cosine_power((cos, sine2): (Eight, Eight), exponent: f32) -> Eight {
        if exponent < STEEP {
            return cos.map(|c| exp_neg(exponent * neg_ln(larger(c, f32::MIN_POSITIVE))));
        }
        sine2.map(|s| exp_neg(0.5 * exponent * neg_ln_1m(s)))
    }

    /// At least cosⁿ. For steep lobes the series of −ln(1 − s²) cut after its fourth term, which is
    /// cheaper and tight wherever they shine; wide ones also count near their horizon, where the
    /// cut series would end at e^(−25 n/24).
    #[inline(always)]
    pub fn cosine_power_bound(sine2: Eight, exponent: f32) -> Eight {
        /// Four roundings of a sine² near 1.
        const SLACK: f32 = 2.4e-7;
        if exponent < STEEP {
            return sine2.map(|s| exp_neg(0.5 * exponent * neg_ln_1m(smaller(s, 1.0) - SLACK)));
        }
        sine2.map(|s| exp_neg(0.5 * exponent * s * (1.0 + s * (0.5 + s * (1.0 / 3.0 + s * 0.25)))))
    }

    /// `then` where `self` < `bound`, else `otherwise`.
    #[inline(always)]
    pub fn below(self, bound: Eight, then: Eight, otherwise: Eight) -> Eight {
        lanes(|i| if self.0[i] < bound.0[i] { then.0[i] } else { otherwise.0[i] })
    }

    #[inline(always)]
    pub fn smallest(self) -> f32 {
        self.0.iter().fold(f32::INFINITY, |low, v| smaller(*v, low))
    }
}

/// Written out: a loop here is unrolled anew in every kernel, which takes minutes to compile.
#[inline(always)]
fn lanes(f: impl Fn(usize) -> f32) -> Eight {
    Eight([f(0), f(1), f(2), f(3), f(4), f(5), f(6), f(7)])
}

/// Axis by axis.
#[inline(always)]
pub(super) fn vectors(f: impl Fn(usize) -> Eight) -> Vectors {
    [f(0), f(1), f(2)]
}

/// Rows to columns, in steps that are one shuffle of a pair: of 32-bit lanes, of pairs of them, of
/// halves.
#[inline(always)]
pub(super) fn transposed(r: &[Eight; 8]) -> [Eight; 8] {
    let [a0, a1, a2, a3] = transposed_halves(r[0], r[1], r[2], r[3]);
    let [b0, b1, b2, b3] = transposed_halves(r[4], r[5], r[6], r[7]);
    [
        low128(a0, b0),
        low128(a1, b1),
        low128(a2, b2),
        low128(a3, b3),
        high128(a0, b0),
        high128(a1, b1),
        high128(a2, b2),
        high128(a3, b3),
    ]
}

#[inline(always)]
fn transposed_halves(a: Eight, b: Eight, c: Eight, d: Eight) -> [Eight; 4] {
    let (e, f, g, h) = (low32(a, b), high32(a, b), low32(c, d), high32(c, d));
    [low64(e, g), high64(e, g), low64(f, h), high64(f, h)]
}

#[inline(always)]
fn low32(Eight(a): Eight, Eight(b): Eight) -> Eight {
    Eight([a[0], b[0], a[1], b[1], a[4], b[4], a[5], b[5]])
}

#[inline(always)]
fn high32(Eight(a): Eight, Eight(b): Eight) -> Eight {
    Eight([a[2], b[2], a[3], b[3], a[6], b[6], a[7], b[7]])
}

#[inline(always)]
fn low64(Eight(a): Eight, Eight(b): Eight) -> Eight {
    Eight([a[0], a[1], b[0], b[1], a[4], a[5], b[4], b[5]])
}

#[inline(always)]
fn high64(Eight(a): Eight, Eight(b): Eight) -> Eight {
    Eight([a[2], a[3], b[2], b[3], a[6], a[7], b[6], b[7]])
}

#[inline(always)]
fn low128(Eight(a): Eight, Eight(b): Eight) -> Eight {
    Eight([a[0], a[1], a[2], a[3], b[0], b[1], b[2], b[3]])
}

#[inline(always)]
fn high128(Eight(a): Eight, Eight(b): Eight) -> Eight {
    Eight([a[4], a[5], a[6], a[7], b[4], b[5], b[6], b[7]])
}

impl Add for Eight {
    type Output = Eight;
    #[inline(always)]
    fn add(self, other: Eight) -> Eight {
        self.zip(other, |a, b| a + b)
    }
}

impl Sub for Eight {
    type Output = Eight;
    #[inline(always)]
    fn sub(self, other: Eight) -> Eight {
        self.zip(other, |a, b| a - b)
    }
}

impl Mul for Eight {
    type Output = Eight;
    #[inline(always)]
    fn mul(self, other: Eight) -> Eight {
        self.zip(other, |a, b| a * b)
    }
}

impl Mul<f32> for Eight {
    type Output = Eight;
    #[inline(always)]
    fn mul(self, other: f32) -> Eight {
        self.map(|a| a * other)
    }
}

impl Add<f32> for Eight {
    type Output = Eight;
    #[inline(always)]
    fn add(self, other: f32) -> Eight {
        self.map(|a| a + other)
    }
}

impl Neg for Eight {
    type Output = Eight;
    #[inline(always)]
    fn neg(self) -> Eight {
        self.map(|a| -a)
    }
}

#[inline(always)]
pub(super) fn dot(a: &Vectors, b: &Vectors) -> Eight {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
pub(super) fn dot_one(a: &Vectors, b: [f32; 3]) -> Eight {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
pub(super) fn scaled(a: &Vectors, by: Eight) -> Vectors {
    [a[0] * by, a[1] * by, a[2] * by]
}

/// A symmetric matrix (xx, yy, zz, xy, xz, yz) times a vector.
#[inline(always)]
pub(super) fn turned(m: &[Eight; 6], v: &Vectors) -> Vectors {
    [
        m[0] * v[0] + m[3] * v[1] + m[4] * v[2],
        m[3] * v[0] + m[1] * v[1] + m[5] * v[2],
        m[4] * v[0] + m[5] * v[1] + m[2] * v[2],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transposition_swaps_rows_and_columns() {
        let rows: [Eight; 8] =
            std::array::from_fn(|r| Eight(std::array::from_fn(|c| (r * 8 + c) as f32)));
        for (c, column) in transposed(&rows).iter().enumerate() {
            for (r, value) in column.0.iter().enumerate() {
                assert_eq!(*value, (r * 8 + c) as f32);
            }
        }
    }
}
