//! Eight f32 side by side: the children of a node.

use std::ops::{Add, Mul, Neg, Sub};

use crate::light::sum::lanes::{exp_neg, inverse_sqrt, larger, neg_ln_1m, smaller};

#[derive(Debug, Clone, Copy)]
#[repr(C, align(32))]
pub(super) struct Eight(pub [f32; 8]);

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
        Eight(std::array::from_fn(|i| f(self.0[i])))
    }

    #[inline(always)]
    pub fn zip(self, other: Eight, f: impl Fn(f32, f32) -> f32) -> Eight {
        Eight(std::array::from_fn(|i| f(self.0[i], other.0[i])))
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

    #[inline(always)]
    pub fn sqrt(self) -> Eight {
        self * self.inverse_sqrt()
    }

    #[inline(always)]
    pub fn recip(self) -> Eight {
        self.map(|v| 1.0 / v)
    }

    /// cosⁿ from sin².
    #[inline(always)]
    pub fn cosine_power(sine2: Eight, exponent: f32) -> Eight {
        sine2.map(|s| exp_neg(0.5 * exponent * neg_ln_1m(s)))
    }

    /// `then` where `self` < `bound`, else `otherwise`.
    #[inline(always)]
    pub fn below(self, bound: Eight, then: Eight, otherwise: Eight) -> Eight {
        Eight(std::array::from_fn(
            |i| {
                if self.0[i] < bound.0[i] { then.0[i] } else { otherwise.0[i] }
            },
        ))
    }

    #[inline(always)]
    pub fn smallest(self) -> f32 {
        let four: [f32; 4] = std::array::from_fn(|i| smaller(self.0[i], self.0[i + 4]));
        smaller(smaller(four[0], four[2]), smaller(four[1], four[3]))
    }
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
