//! What a node's samples send through the lobes, to second order in their places, and what that
//! leaves out.
//!
//! Along a great circle that comes within A of the axis, cosⁿ is Aⁿ cosⁿt. With y = tan²t its
//! derivatives by t, over cosⁿ, are
//!
//!   −n √y,   n (n−1) y − n,   −√y (n (n−1) (n−2) y − n (3n−2)),
//!   n (n−1) (n−2) (n−3) y² − n (n−1) (6n−8) y + n (3n−2),
//!
//! and y is at most tan² of the angle from the axis, which it is on the circle through the axis.

use super::eight::{Eight, Vectors, dot, dot_one, vectors};
use super::half::HalfCloud;
use super::node::{Cloud, NodeQuery};
use crate::light::sum::power::Power;

/// A Taylor remainder weighs the derivative at t of the way to a sample with 4 (1 − t)³, 1/5 on
/// average. For a derivative that grows as e^(at), this is less than its value at 0.4 up to a = 10.
pub(super) const INWARD: f32 = 0.4;

/// e^8: where a lobe grows more between the mean place and the sample nearest to the axis, only its
/// largest value bounds what a few samples there send.
const STEEPEST: f32 = 2981.0;

/// A lobe below e^−40 is not worth an expansion; its bound then is this fraction of its weight.
const NEGLIGIBLE_EXPONENT: f32 = 40.0;
pub(super) const NEGLIGIBLE: f32 = 4.3e-18;

/// Nearer to a lobe's horizon (its cosine) its largest value bounds it: f32 holds no tangent there.
pub(super) const HORIZON: f32 = 1e-3;

/// Rounding of cos² from directions in f32.
const COSINE2_ROUNDING: f32 = 1e-6;

/// Sums over lobes.
pub(super) struct LobeSums {
    /// With the second order.
    pub value: Eight,
    /// Error of `value`.
    pub error: Eight,
    /// The most that they are anywhere in the cone of the samples.
    pub largest: Eight,
    /// Without any order above 0.
    pub at_mean: Eight,
    /// |∇G| times the distance.
    pub slope: Eight,
    /// Root mean square of ∇G·(s − c̄).
    pub swing: Eight,
}

impl LobeSums {
    const ZERO: LobeSums = LobeSums {
        value: Eight::ZERO,
        error: Eight::ZERO,
        largest: Eight::ZERO,
        at_mean: Eight::ZERO,
        slope: Eight::ZERO,
        swing: Eight::ZERO,
    };

    #[inline(always)]
    pub fn add_negligible(&mut self, weight: f32) {
        let most = Eight::splat(weight * NEGLIGIBLE);
        self.error = self.error + most;
        self.largest = self.largest + most;
    }
}

/// Of the diffuse lobe, and of specular ones about the query's axis.
#[inline(always)]
pub(super) fn sum_lobes(cloud: &Cloud, query: &NodeQuery) -> LobeSums {
    let mut sums = LobeSums::ZERO;
    let straddles = straddling(cloud, query);
    // One body for all, since it is long.
    for i in 0..=query.specular.len() {
        let (axis, lobe) = match i {
            0 => (query.normal, query.diffuse),
            _ => (query.axis, query.specular[i - 1]),
        };
        if lobe.weight > 0.0 {
            add_lobe(&mut sums, cloud, (axis, lobe, query.falloff()), straddles);
        }
    }
    sums
}

/// Of the diffuse lobe, and of half-vector ones.
#[inline(always)]
pub(super) fn sum_half_lobes(cloud: &Cloud, query: &NodeQuery) -> LobeSums {
    let mut sums = LobeSums::ZERO;
    let straddles = straddling(cloud, query);
    if query.diffuse.weight > 0.0 {
        add_lobe(&mut sums, cloud, (query.normal, query.diffuse, query.falloff()), straddles);
    }
    let Some(view) = query.half else { return sums };
    let half = HalfCloud::new(cloud, view, query.normal);
    for lobe in query.specular {
        half.add_lobe(&mut sums, cloud, (*lobe, query.falloff()), straddles);
    }
    sums
}

/// Chooses for nodes that the hit's horizon cuts, and for the others.
#[inline(always)]
fn straddling(cloud: &Cloud, query: &NodeQuery) -> impl Fn(Eight, Eight) -> Eight + Copy {
    let horizon = cloud.cos_normal(query).abs();
    let chord = cloud.chord;
    move |then, otherwise| horizon.below(chord, then, otherwise)
}

#[inline(always)]
fn add_lobe(
    sums: &mut LobeSums,
    cloud: &Cloud,
    (axis, lobe, k): ([f32; 3], Power, f32),
    straddles: impl Fn(Eight, Eight) -> Eight,
) {
    let n = lobe.exponent;
    let angle = Angle::new(&cloud.direction, axis);
    let Some(bounds) = Bounds::new(cloud, &angle, n, Falling { mixed: k, pure: k }) else {
        sums.add_negligible(lobe.weight);
        return;
    };
    let Bounds { largest, at_mean, smooth } = bounds;
    let error = straddles(largest, smooth);
    let (swing2, second) = first_orders(cloud, &angle, n, k);
    let value = (at_mean * (second + 1.0)).at_least(0.0).smaller(largest);
    sums.value = sums.value + value * lobe.weight;
    sums.error = sums.error + error * lobe.weight;
    sums.largest = sums.largest + largest * lobe.weight;
    sums.at_mean = sums.at_mean + at_mean * lobe.weight;
    let tan = angle.farther_tan2(cloud.chord * INWARD).rough_sqrt();
    sums.slope = sums.slope + at_mean * (tan * n + k) * lobe.weight;
    sums.swing = sums.swing + at_mean * swing2.rough_sqrt() * lobe.weight;
}

/// k of (R/r)^k as the remainders take it: with derivatives of the lobe, and alone.
#[derive(Clone, Copy)]
pub(super) struct Falling {
    pub mixed: f32,
    pub pure: f32,
}

/// cosⁿ at the mean place, the most that it is anywhere, and what second order leaves out.
pub(super) struct Bounds {
    pub largest: Eight,
    pub at_mean: Eight,
    pub smooth: Eight,
}

impl Bounds {
    /// `None` where the lobe is negligible for all.
    #[inline(always)]
    pub fn new(cloud: &Cloud, angle: &Angle, n: f32, k: Falling) -> Option<Bounds> {
        let nearest = angle.nearer(cloud.chord);
        if 0.5 * n * nearest.smallest() > NEGLIGIBLE_EXPONENT {
            return None;
        }
        let largest = Eight::cosine_power_bound(nearest, n);
        let at_mean = Eight::cosine_power((angle.cos, angle.sine2), n);
        let inward = cloud.chord * INWARD;
        let inner = Eight::cosine_power_bound(angle.nearer(inward), n);
        let third = at_mean * third_order(cloud, angle.farther_tan2(Eight::ZERO), n, k);
        let fourth = inner * fourth_order(cloud, angle, n, k);
        let smooth = (third + fourth).smaller(largest);
        let smooth = largest.below(at_mean * STEEPEST, smooth, largest);
        let smooth = (cloud.chord * 1.5).at_least(HORIZON).below(angle.cos, smooth, largest);
        Some(Bounds { largest, at_mean, smooth })
    }
}

/// Between the mean place and a lobe's axis.
pub(super) struct Angle {
    pub cos: Eight,
    /// 1 past 90°.
    pub sine2: Eight,
    pub sine: Eight,
    /// The axis less its part along the direction.
    pub across: Vectors,
}

impl Angle {
    #[inline(always)]
    pub fn new(direction: &Vectors, axis: [f32; 3]) -> Angle {
        let cos = dot_one(direction, axis);
        let across = vectors(|i| -(direction[i] * cos) + axis[i]);
        let one = Eight::splat(1.0);
        let sine2 = Eight::ZERO.below(cos, dot(&across, &across).at_most(1.0), one);
        Angle { cos, sine2, sine: sine2.rough_sqrt(), across }
    }

    /// Sine² of places up to `chord` nearer to the axis: both bounds hold, each has its digits.
    #[inline(always)]
    fn nearer(&self, chord: Eight) -> Eight {
        let sine = (self.sine - chord).at_least(0.0);
        let cos = (self.cos + chord).at_least(0.0);
        (sine * sine).larger(cos * cos * -1.0 + (1.0 - COSINE2_ROUNDING))
    }

    /// Tangent² of places up to `chord` farther from the axis.
    #[inline(always)]
    pub fn farther_tan2(&self, chord: Eight) -> Eight {
        let sine = (self.sine + chord).at_most(1.0);
        let tan = sine * (self.cos - chord).at_least(0.5 * HORIZON).recip();
        tan * tan
    }
}

/// Mean of (∇G·(s − c̄))² over G², and ½ ∇∇G : C over G, for G = cosⁿ r^−k.
#[inline(always)]
fn first_orders(cloud: &Cloud, angle: &Angle, n: f32, k: f32) -> (Eight, Eight) {
    let inverse_cos = angle.cos.at_least(HORIZON).recip();
    let spread_across = cloud.spread_along(&angle.across);
    let mixed = dot(&angle.across, &cloud.along);
    let radial = cloud.radial();
    let tilt = inverse_cos * inverse_cos * spread_across;
    let turning = inverse_cos * mixed * (2.0 * n);
    let flattening = (cloud.trace - radial) * n;
    let falloff = radial * (k * (k + 2.0)) - cloud.trace * k;
    let second = tilt * (n * (n - 1.0)) - turning * (1.0 + k) - flattening + falloff;
    let first = tilt * (n * n) - turning * k + radial * (k * k);
    let inverse = cloud.inverse_distance * cloud.inverse_distance;
    (first.at_least(0.0) * inverse, second * inverse * 0.5)
}

/// Largest first three derivatives of cosⁿ by direction, over cosⁿ; exact ones for y up to `tan2`.
#[inline(always)]
fn lower_derivatives(tan2: Eight, n: f32) -> (Eight, Eight, Eight) {
    let (cubic, linear) = (n * (n - 1.0) * (n - 2.0), n * (3.0 * n - 2.0));
    let turning_point = if cubic > 0.0 { linear / (3.0 * cubic) } else { f32::MAX };
    let tan = tan2.rough_sqrt();
    let within = tan2.at_most(turning_point).rough_sqrt() * (2.0 / 3.0 * linear);
    let at_end = tan * (tan2 * cubic + -linear).abs();
    (tan * n, (tan2 * (n - 1.0) + 1.0) * n, within.larger(at_end))
}

/// Bound of G relative to cosⁿ, for the norm of the third moment.
#[inline(always)]
fn third_order(cloud: &Cloud, tan2: Eight, n: f32, Falling { mixed: k, pure }: Falling) -> Eight {
    let (first, second, third) = lower_derivatives(tan2, n);
    let derivative = third
        + second * (3.0 * k)
        + first * (3.0 * k * (k + 1.0))
        + pure * (pure + 1.0) * (pure + 2.0);
    let inverse = cloud.inverse_distance;
    derivative * cloud.skewness * (inverse * inverse * inverse) * (1.0 / 6.0)
}

/// Σ w of the fourth derivative along every s − c̄, relative to the largest cosⁿ on the way.
///
/// With p the part of s − c̄ toward the axis, and q all of it across the line of sight, over the
/// distance: a y² p⁴ − b y p² q² + c q⁴, where √y |p| is at most what it is at c̄ and what the way
/// inward adds.
#[inline(always)]
fn fourth_order(
    cloud: &Cloud,
    angle: &Angle,
    n: f32,
    Falling { mixed: k, pure }: Falling,
) -> Eight {
    let inward = cloud.chord * INWARD;
    let (first, second, third) = lower_derivatives(angle.farther_tan2(inward), n);
    let falling = third * (4.0 * k)
        + second * (6.0 * k * (k + 1.0))
        + first * (4.0 * k * (k + 1.0) * (k + 2.0))
        + pure * (pure + 1.0) * (pure + 2.0) * (pure + 3.0);
    let inverse = cloud.inverse_distance;
    let spread = (cloud.trace - cloud.radial()) * inverse * inverse;
    let inverse_cos = (angle.cos - inward).at_least(0.5 * HORIZON).recip();
    let reach = (cloud.reach_along(&angle.across) * inverse + inward * cloud.cone) * inverse_cos;
    let width = (cloud.spread_along(&angle.across).rough_sqrt() * inverse
        + inward * spread.rough_sqrt())
        * inverse_cos;
    let (reach2, width2, cone2) = (reach * reach, width * width, cloud.cone * cloud.cone);
    let a = (n * (n - 1.0) * (n - 2.0) * (n - 3.0)).abs();
    let b = (n * (n - 1.0) * (6.0 * n - 8.0)).abs();
    let c = n * (3.0 * n - 2.0);
    let turning = (reach2 * width2 * a + cone2 * spread * c).larger(width2 * cone2 * b);
    let gap = cloud.nearness * cloud.nearness;
    let falling = falling * cloud.trace * (inverse * inverse) * cone2;
    (turning + falling) * (gap * gap) * (1.0 / 24.0)
}
