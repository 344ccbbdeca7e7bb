//! What a node's samples send through half-vector lobes, to second order in their places.
//!
//! With d the way from the hit to a sample and ρ its length, H is the direction of d + ρV, which a
//! step δ of the place moves by Tδ + ½ V(|δ|² − (L·δ)²)/ρ, T = I + V Lᵀ. With D = |L + V|, β the
//! angle between N and H, a = N − cos β H, v = Tᵀa/(D cos β) and u = TᵀH/D,
//!
//!   ∇ ln cos β = v,   ∇∇ ln cos β : C = uCu − vCv − 2 vCu − tr(TCTᵀ)/D² + (a·V/(D cos β)) (tr C − LCL)
//!
//! over ρ and ρ². What that leaves out is estimated as for a lobe about N in the place of which
//! the samples lie as H sees them: at most 1/D as far apart, plus what bends H's way.

use super::eight::{Eight, Vectors, dot, dot_one, scaled, turned, vectors};
use super::lobe::{Angle, Bounds, Falling, HORIZON, INWARD, LobeSums};
use super::node::Cloud;
use crate::light::sum::power::Power;

/// The second derivative of H's way is at most this times the square of the first; it acts on the
/// remainders like a falloff of 1.5 times as many powers.
const BENDING: f32 = 2.6;

/// A node as its half vectors with V see the normal.
pub(super) struct HalfCloud {
    /// As far apart as H may turn.
    cloud: Cloud,
    /// Between H and N; `across` is Tᵀa.
    angle: Angle,
    inverse_sum: Eight,
    /// Whether D changes little over the node, else below 0.
    steadiness: Eight,
    /// vCv, vCL, and all of ∇∇ ln cos β : C.
    slope2: Eight,
    mixed: Eight,
    curvature: Eight,
}

impl HalfCloud {
    #[inline(always)]
    pub fn new(cloud: &Cloud, view: [f32; 3], normal: [f32; 3]) -> HalfCloud {
        let direction = &cloud.direction;
        let sum = vectors(|axis| direction[axis] + view[axis]);
        let inverse_sum = dot(&sum, &sum).inverse_sqrt();
        let half = scaled(&sum, inverse_sum);
        let angle = Angle::new(&half, normal);
        let pulled = |w: &Vectors| {
            let along = dot_one(w, view);
            vectors(|axis| w[axis] + direction[axis] * along)
        };
        let inverse_cos = inverse_sum * angle.cos.at_least(HORIZON).recip();
        let across = pulled(&angle.across);
        let (v, u) = (scaled(&across, inverse_cos), scaled(&pulled(&half), inverse_sum));
        let v_spread = turned(&cloud.covariance, &v);
        let slope2 = dot(&v, &v_spread).at_least(0.0);
        let radial = cloud.radial();
        let turned_trace = cloud.trace + radial + dot_one(&cloud.along, view) * 2.0;
        let bend = dot_one(&angle.across, view) * inverse_cos * (cloud.trace - radial);
        let curvature = dot(&u, &turned(&cloud.covariance, &u))
            - slope2
            - dot(&u, &v_spread) * 2.0
            - turned_trace * inverse_sum * inverse_sum
            + bend;
        let length = dot(&sum, &half);
        let turning = (length - cloud.chord).at_least(HORIZON).recip();
        HalfCloud {
            cloud: cloud.nearer_by(turning),
            angle: Angle { across, ..angle },
            inverse_sum,
            steadiness: length - cloud.chord * 2.0,
            slope2,
            mixed: dot(&v, &cloud.along),
            curvature,
        }
    }

    #[inline(always)]
    pub fn add_lobe(
        &self,
        sums: &mut LobeSums,
        cloud: &Cloud,
        (lobe, k): (Power, f32),
        straddles: impl Fn(Eight, Eight) -> Eight,
    ) {
        let n = lobe.exponent;
        // Powers of 1/ρ are powers of up to 2 over D ρ.
        let pure = 2.0 * k + 1.5;
        let falling = Falling { mixed: pure + 1.5 * BENDING, pure };
        let Some(bounds) = Bounds::new(&self.cloud, &self.angle, n, falling) else {
            sums.add_negligible(lobe.weight);
            return;
        };
        let Bounds { largest, at_mean, smooth } = bounds;
        let smooth = Eight::ZERO.below(self.steadiness, smooth, largest);
        let (swing2, second) = self.first_orders(cloud, n, k);
        let value = (at_mean * (second + 1.0)).at_least(0.0).smaller(largest);
        sums.value = sums.value + value * lobe.weight;
        sums.error = sums.error + straddles(largest, smooth) * lobe.weight;
        sums.largest = sums.largest + largest * lobe.weight;
        sums.at_mean = sums.at_mean + at_mean * lobe.weight;
        let tan = self.angle.farther_tan2(self.cloud.chord * INWARD).rough_sqrt();
        sums.slope = sums.slope + at_mean * (tan * self.inverse_sum * n + k) * lobe.weight;
        sums.swing = sums.swing + at_mean * swing2.rough_sqrt() * lobe.weight;
    }

    /// Mean of (∇G·(s − c̄))² over G², and ½ ∇∇G : C over G, for G = cosⁿβ r^−k.
    #[inline(always)]
    fn first_orders(&self, cloud: &Cloud, n: f32, k: f32) -> (Eight, Eight) {
        let radial = cloud.radial();
        let first = self.slope2 * (n * n) - self.mixed * (2.0 * n * k) + radial * (k * k);
        let falloff = radial * (2.0 * k) - cloud.trace * k;
        let second = first + self.curvature * n + falloff;
        let inverse = cloud.inverse_distance * cloud.inverse_distance;
        (first.at_least(0.0) * inverse, second * inverse * 0.5)
    }
}
