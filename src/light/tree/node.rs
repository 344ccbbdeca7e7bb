//! What a node sends to a hit, and how wrong that may be.
//!
//! With R the distance from the hit P to the node's center s₀, ω the direction from s₀ to P, and
//! τ = (s − s₀)·Q, a sample's emission is exactly c = max(0, ω·Q − τ/R) R/r. So a table by ω, of
//! Σ Φ max(0, ω·Q) with first and second moments of the places s, gives the node's sum as
//!
//!   (E − T/R) · [ G(c̄) + ½ ∇∇G : C ],  G(s) = (k_d (L·N)^n_d + Σ k_s (L·M)^n_s) (R/r)^k,
//!
//! where T = Σ Φ H τ, c̄ and C are the emission-weighted mean place and covariance, and k is 1, or
//! 3 with the inverse square. Left out, and so estimated:
//! - the third order of G: bounded by its largest third derivative over the cone in which the hit
//!   sees the node, times the largest |s − c̄| times the trace of C;
//! - the correlation of τ with ∇G·(s − c̄), and the samples that τ turns toward or away;
//! - interpolation: E is convex on the octahedron's faces, so it lies between the blended tangents
//!   and the interpolated values. Their mean is used, and half of their difference is the bound.

use super::eight::{Eight, Vectors, dot, dot_one, scaled, turned};
use super::levels::Octet;
use super::octahedron::{Grid, Triangle};
use super::table::{CHANNELS, EMISSION, GRADIENT, MEAN, PARALLAX, PARALLAX2, SPREAD};
use crate::light::sum::power::Power;

/// One side of a hit, relative to the tree's center.
#[derive(Debug, Clone, Copy)]
pub(super) struct NodeQuery<'a> {
    pub point: [f32; 3],
    pub normal: [f32; 3],
    pub axis: [f32; 3],
    pub diffuse: Power,
    pub specular: &'a [Power],
    pub inverse_square: bool,
}

impl NodeQuery<'_> {
    /// k of (R/r)^k.
    fn falloff(&self) -> f32 {
        if self.inverse_square { 3.0 } else { 1.0 }
    }
}

/// Eight nodes' answers.
#[derive(Debug, Clone, Copy)]
pub(super) struct NodeSums {
    pub value: Eight,
    pub error: Eight,
    /// Emission-weighted mean places, relative to the tree's center.
    pub place: Vectors,
}

/// Radius over distance from which a node is too near for its table.
const NEAREST: f32 = 0.4;

/// A lobe below e^−40 is not worth an expansion; its bound then is this fraction of its weight.
const NEGLIGIBLE_EXPONENT: f32 = 40.0;
const NEGLIGIBLE: f32 = 4.3e-18;

pub(super) fn eval_octet(
    octet: &Octet,
    (grid, table): (Grid, &[f32]),
    query: &NodeQuery,
) -> NodeSums {
    #[cfg(target_arch = "x86_64")]
    {
        use crate::light::sum::isa::{Isa, detected};
        #[target_feature(enable = "avx2")]
        fn with_avx2(octet: &Octet, table: (Grid, &[f32]), query: &NodeQuery) -> NodeSums {
            kernel(octet, table, query)
        }
        if detected() != Isa::Plain {
            // SAFETY: the processor has said that it has AVX2.
            return unsafe { with_avx2(octet, (grid, table), query) };
        }
    }
    kernel(octet, (grid, table), query)
}

#[inline(always)]
fn kernel(octet: &Octet, (grid, table): (Grid, &[f32]), query: &NodeQuery) -> NodeSums {
    let to_center: Vectors = std::array::from_fn(|axis| octet.center[axis] + -query.point[axis]);
    let inverse_distance = dot(&to_center, &to_center).inverse_sqrt();
    let outward = scaled(&to_center, -inverse_distance);
    let emission = Emission::look_up(&outward, grid, table);
    let cloud = Cloud::new(&to_center, octet.radius, &emission);
    let lobes = sum_lobes(&cloud, query);

    let falloff = falloff(&cloud, inverse_distance, query.inverse_square);
    let parallax = emission.parallax * inverse_distance;
    let value = ((emission.middle - parallax) * lobes.value * falloff).at_least(0.0);
    let error = falloff * total_error(&emission, &cloud, &lobes, (inverse_distance, grid));

    let far_error = error + value * 1e-6;
    let limit = Eight::splat(NEAREST);
    let near_error = near_bound(octet, inverse_distance, query);
    // All samples on the other side, or none at all.
    let horizon = cloud.cos_normal(query) + cloud.chord;
    let seen = |v: Eight| Eight::ZERO.below(horizon, v, Eight::ZERO);
    let near = |far: Eight, near: Eight| cloud.cone.below(limit, seen(far), near);
    let present = |v: Eight| Eight::ZERO.below(octet.flux, v, Eight::ZERO);
    NodeSums {
        value: present(near(value, Eight::ZERO)),
        error: present(near(far_error, near_error)),
        place: std::array::from_fn(|axis| octet.center[axis] + emission.mean[axis]),
    }
}

/// The most that a node can send to a hit in its midst.
#[inline(always)]
fn near_bound(octet: &Octet, inverse_distance: Eight, query: &NodeQuery) -> Eight {
    let weights = query.specular.iter().fold(query.diffuse.weight, |sum, lobe| sum + lobe.weight);
    let bound = octet.flux * weights;
    if !query.inverse_square {
        return bound;
    }
    // Outside, 1/(R − radius)²; inside there is no bound, and any large number descends.
    let nearness = octet.radius * inverse_distance;
    let gap = (nearness * -1.0 + 1.0).at_least(1e-3);
    bound * (inverse_distance * gap.recip()).zip(inverse_distance, |a, _| a * a)
}

/// What the table says about a direction.
struct Emission {
    /// Between the two bounds of E.
    middle: Eight,
    half_width: Eight,
    /// Interpolated E, consistent with the moments.
    total: Eight,
    mean: Vectors,
    covariance: [Eight; 6],
    parallax: Eight,
    parallax2: Eight,
}

impl Emission {
    #[inline(always)]
    fn look_up(outward: &Vectors, grid: Grid, table: &[f32]) -> Emission {
        let l1 = (outward[0].abs() + outward[1].abs() + outward[2].abs()).at_least(1e-30);
        let inverse = l1.recip();
        let on_octahedron = scaled(outward, inverse);
        let channels = interpolate(&on_octahedron, grid, table);
        let total = channels[EMISSION] * l1;
        let gradient = [channels[GRADIENT], channels[GRADIENT + 1], channels[GRADIENT + 2]];
        let tangent = dot(&gradient, outward).smaller(total);
        let normalize = channels[EMISSION].at_least(f32::MIN_POSITIVE).recip();
        let mean: Vectors = std::array::from_fn(|axis| channels[MEAN + axis] * normalize);
        let pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
        let covariance = std::array::from_fn(|i| {
            let (a, b) = pairs[i];
            channels[SPREAD + i] * normalize - mean[a] * mean[b]
        });
        Emission {
            middle: ((total + tangent) * 0.5).at_least(0.0),
            half_width: (total - tangent) * 0.5,
            total,
            mean,
            covariance,
            parallax: channels[PARALLAX],
            parallax2: channels[PARALLAX2],
        }
    }
}

#[inline(always)]
fn interpolate(at: &Vectors, grid: Grid, table: &[f32]) -> [Eight; CHANNELS] {
    let triangles: [Triangle; 8] =
        std::array::from_fn(|i| grid.triangle([at[0].0[i], at[1].0[i], at[2].0[i]]));
    let shared = triangles.iter().all(|triangle| triangle.corners == triangles[0].corners);
    if shared {
        interpolate_shared(&triangles, table)
    } else {
        interpolate_apart(&triangles, table)
    }
}

#[inline(always)]
fn interpolate_shared(triangles: &[Triangle; 8], table: &[f32]) -> [Eight; CHANNELS] {
    let weights: [Eight; 3] =
        std::array::from_fn(|k| Eight(std::array::from_fn(|i| triangles[i].weights[k])));
    let corners = triangles[0].corners.map(|corner| {
        let start = corner * CHANNELS * 8;
        table[start..start + CHANNELS * 8].as_chunks::<8>().0
    });
    std::array::from_fn(|channel| {
        let value = |k: usize| Eight(corners[k][channel]) * weights[k];
        value(0) + value(1) + value(2)
    })
}

/// Each lane in its own triangle.
#[inline(never)]
fn interpolate_apart(triangles: &[Triangle; 8], table: &[f32]) -> [Eight; CHANNELS] {
    let mut channels = [Eight::ZERO; CHANNELS];
    for (lane, triangle) in triangles.iter().enumerate() {
        let corners = triangle.corners.map(|corner| {
            let start = corner * CHANNELS * 8;
            table[start..start + CHANNELS * 8].as_chunks::<8>().0
        });
        let weights = triangle.weights;
        for (channel, values) in channels.iter_mut().enumerate() {
            let value = |k: usize| corners[k][channel][lane] * weights[k];
            values.0[lane] = value(0) + value(1) + value(2);
        }
    }
    channels
}

/// The samples of a node as the hit sees them.
struct Cloud {
    /// Unit, from the hit to the mean place.
    direction: Vectors,
    inverse_distance: Eight,
    /// Largest distance of a sample from the mean place, over the hit's distance.
    cone: Eight,
    /// 2 sin(α/2) of the cone that holds the samples, for `cone` up to [`NEAREST`].
    chord: Eight,
    /// (1 − cone)^−3: how much nearer the nearest sample can be.
    nearness3: Eight,
    covariance: [Eight; 6],
    /// C·direction.
    along: Vectors,
    trace: Eight,
}

impl Cloud {
    #[inline(always)]
    fn new(to_center: &Vectors, radius: Eight, emission: &Emission) -> Cloud {
        let mean = &emission.mean;
        let to_mean: Vectors = std::array::from_fn(|axis| to_center[axis] + mean[axis]);
        let inverse_distance = dot(&to_mean, &to_mean).inverse_sqrt();
        let direction = scaled(&to_mean, inverse_distance);
        let reach = radius + dot(mean, mean).sqrt().smaller(radius);
        let cone = reach * inverse_distance;
        let gap = (cone * -1.0 + 1.0).at_least(0.5).recip();
        let along = turned(&emission.covariance, &direction);
        let trace = emission.covariance[0] + emission.covariance[1] + emission.covariance[2];
        Cloud {
            direction,
            inverse_distance,
            cone,
            chord: cone * 1.03, // 2 sin(asin(x)/2) < 1.03 x up to x = 0.45
            nearness3: gap * gap * gap,
            covariance: emission.covariance,
            along,
            trace: trace.at_least(0.0),
        }
    }

    #[inline(always)]
    fn cos_normal(&self, query: &NodeQuery) -> Eight {
        dot_one(&self.direction, query.normal)
    }
}

/// Sums over lobes.
struct LobeSums {
    /// With the second order.
    value: Eight,
    /// Of `value`: the third order.
    error: Eight,
    /// Without any order above 0.
    at_mean: Eight,
    /// |∇G| times the distance.
    slope: Eight,
}

#[inline(always)]
fn sum_lobes(cloud: &Cloud, query: &NodeQuery) -> LobeSums {
    let zero = Eight::ZERO;
    let mut sums = LobeSums { value: zero, error: zero, at_mean: zero, slope: zero };
    let horizon = cloud.cos_normal(query).abs();
    let straddles = |then: Eight, otherwise: Eight| horizon.below(cloud.chord, then, otherwise);
    if query.diffuse.weight > 0.0 {
        add_lobe(&mut sums, cloud, (query.normal, query.diffuse, query.falloff()), straddles);
    }
    for lobe in query.specular {
        add_lobe(&mut sums, cloud, (query.axis, *lobe, query.falloff()), straddles);
    }
    sums
}

#[inline(always)]
fn add_lobe(
    sums: &mut LobeSums,
    cloud: &Cloud,
    (axis, lobe, k): ([f32; 3], Power, f32),
    straddles: impl Fn(Eight, Eight) -> Eight,
) {
    let n = lobe.exponent;
    let cos = dot_one(&cloud.direction, axis);
    let across: Vectors = std::array::from_fn(|i| -(cloud.direction[i] * cos) + axis[i]);
    let one = Eight::splat(1.0);
    let sine2 = Eight::ZERO.below(cos, dot(&across, &across).at_most(1.0), one);
    let sine = sine2.sqrt();
    // The samples nearest to the axis; past 90° their cosine is at most cos + chord.
    let near_cos = (cos + cloud.chord).at_least(0.0);
    let near_sine = (sine - cloud.chord).at_least(0.0);
    let beyond = (near_cos * near_cos * -1.0 + 1.0).at_least(0.0);
    let near_sine2 = Eight::ZERO.below(cos, near_sine * near_sine, beyond);
    let edge_exponent = (n - 3.0).max(0.0);
    if 0.5 * edge_exponent * near_sine2.smallest() > NEGLIGIBLE_EXPONENT {
        sums.error = sums.error + Eight::splat(lobe.weight * NEGLIGIBLE);
        return;
    }
    let edge = Eight::cosine_power(near_sine2, edge_exponent);
    let at_mean = Eight::cosine_power(sine2, n);
    let far_sine = (sine + cloud.chord).at_most(1.0);
    let second = second_order(cloud, (&across, cos), n, k);
    let third = third_order(cloud, (near_sine, far_sine), n, k);
    // Where the lobe ends (its horizon) it has no derivatives; the bound is its largest value.
    let smooth = (cloud.chord * 1.5).at_least(0.05).below(cos, third.at_most(1.0), one);
    let relative = straddles(one, smooth);
    let value = (at_mean * (second + 1.0)).at_least(0.0).smaller(edge);
    sums.value = sums.value + value * lobe.weight;
    sums.error = sums.error + edge * relative * lobe.weight;
    sums.at_mean = sums.at_mean + at_mean * lobe.weight;
    sums.slope = sums.slope + at_mean * (far_sine * n + k) * lobe.weight;
}

/// ½ ∇∇G : C over G for G = cosⁿ r^−k.
#[inline(always)]
fn second_order(cloud: &Cloud, (across, cos): (&Vectors, Eight), n: f32, k: f32) -> Eight {
    let inverse_cos = cos.at_least(0.05).recip();
    let spread_across = dot(across, &turned(&cloud.covariance, across)).at_least(0.0);
    let mixed = dot(across, &cloud.along);
    let radial = dot(&cloud.direction, &cloud.along).at_least(0.0);
    let curvature = inverse_cos * inverse_cos * spread_across * (n * (n - 1.0));
    let turning = inverse_cos * mixed * (2.0 * n * (1.0 + k));
    let flattening = (cloud.trace - radial) * n;
    let falloff = radial * (k * (k + 2.0)) - cloud.trace * k;
    let sum = curvature - turning - flattening + falloff;
    sum * cloud.inverse_distance * cloud.inverse_distance * 0.5
}

/// Bound of the third order over the largest cosⁿ⁻³ in the cone.
///
/// The derivative along a line is n (n−1) (n−2) cos'³ + 3 n (n−1) cos' cos″ + n cos‴ with
/// |cos'| ≤ sin/r; its first two terms make n² sin (n sin² − 3), as those of a Gaussian. Those of
/// r^−k follow by the product rule.
#[inline(always)]
fn third_order(cloud: &Cloud, (near_sine, far_sine): (Eight, Eight), n: f32, k: f32) -> Eight {
    let hermite = |sine: Eight| (sine * sine * n + -3.0).abs();
    let largest = hermite(near_sine).larger(hermite(far_sine));
    let own = far_sine * largest * (n * n) + 7.0 * n;
    let with_falloff = (far_sine * far_sine * (n * n) + n) * (3.0 * k)
        + far_sine * (3.0 * k * (k + 1.0) * n)
        + k * (k + 1.0) * (k + 2.0);
    let size = cloud.trace * cloud.inverse_distance * cloud.inverse_distance * cloud.cone;
    (own + with_falloff) * size * cloud.nearness3 * (1.0 / 6.0)
}

/// (R/r)^k, over R² with the inverse square.
#[inline(always)]
fn falloff(cloud: &Cloud, inverse_distance: Eight, inverse_square: bool) -> Eight {
    let ratio = cloud.inverse_distance * inverse_distance.at_least(f32::MIN_POSITIVE).recip();
    if inverse_square { ratio * cloud.inverse_distance * cloud.inverse_distance } else { ratio }
}

#[inline(always)]
fn total_error(
    emission: &Emission,
    cloud: &Cloud,
    lobes: &LobeSums,
    (inverse_distance, grid): (Eight, Grid),
) -> Eight {
    let width = cloud.trace.sqrt() * cloud.inverse_distance;
    let slope = lobes.slope * width;
    // √(Σ Φ H τ² · Σ w)/R
    let parallax2 = emission.parallax2.at_least(0.0) * inverse_distance * inverse_distance;
    let parallax = (parallax2 * emission.total).sqrt();
    let spacing = 4.0 / grid.cells as f32; // rad, the longest edges
    emission.total * lobes.error
        + emission.half_width * (lobes.at_mean + slope)
        + parallax * slope * 1.5
        + (parallax2 + parallax * (0.5 * spacing)) * lobes.at_mean
}
