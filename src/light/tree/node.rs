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
//! - the third order of G: its derivative at c̄ times the norm of the third central moment;
//! - the fourth: the largest derivative over the cone in which the hit sees the node, times the
//!   covariance times the square of what the node's box reaches that way;
//! - the correlation of τ with ∇G·(s − c̄), and the samples that τ turns toward or away;
//! - interpolation: E is convex on the octahedron's faces, so it lies between the blended tangents
//!   and the interpolated values. Their mean is used; how far it may be off was measured while
//!   building.

use super::eight::{Eight, Vectors, dot, dot_one, scaled, transposed, turned, vectors};
use super::levels::Octet;
use super::lobe::{INWARD, LobeSums, sum_half_lobes, sum_lobes};
use super::moments::{
    CHANNELS, Channels, EMISSION, GRADIENT, MEAN, PAIRS, PARALLAX, PARALLAX2, SKEWNESS, SPREAD,
};
use super::octahedron::OctahedronGrid;
use crate::light::sum::power::Power;
use crate::simd::eight_wide;

/// One side of a hit, relative to the tree's center.
#[derive(Debug, Clone, Copy)]
pub(super) struct NodeQuery<'a> {
    pub point: [f32; 3],
    pub normal: [f32; 3],
    pub axis: [f32; 3],
    pub diffuse: Power,
    pub specular: &'a [Power],
    /// V, if the specular lobes are half-vector lobes.
    pub half: Option<[f32; 3]>,
    pub inverse_square: bool,
}

impl NodeQuery<'_> {
    /// k of (R/r)^k.
    pub fn falloff(&self) -> f32 {
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
const NEAREST: f32 = 0.3;

/// Rounding of directions in f32, rad.
const ROUNDING: f32 = 4e-7;

pub(super) fn eval_octet(
    octet: &Octet,
    table: (OctahedronGrid, &[Channels]),
    query: &NodeQuery,
) -> NodeSums {
    if query.half.is_some() {
        return eight_wide!(of_half_lobes(octet: &Octet, table: (OctahedronGrid, &[Channels]), query: &NodeQuery) -> NodeSums);
    }
    eight_wide!(of_lobes(octet: &Octet, table: (OctahedronGrid, &[Channels]), query: &NodeQuery) -> NodeSums)
}

#[inline(always)]
fn of_lobes(octet: &Octet, table: (OctahedronGrid, &[Channels]), query: &NodeQuery) -> NodeSums {
    kernel::<false>(octet, table, query)
}

#[inline(always)]
fn of_half_lobes(
    octet: &Octet,
    table: (OctahedronGrid, &[Channels]),
    query: &NodeQuery,
) -> NodeSums {
    kernel::<true>(octet, table, query)
}

/// `HALF` and not a function as argument: a call of one would not be compiled for the caller's
/// instruction set.
#[inline(always)]
fn kernel<const HALF: bool>(
    octet: &Octet,
    (grid, table): (OctahedronGrid, &[Channels]),
    query: &NodeQuery,
) -> NodeSums {
    let to_center: Vectors = vectors(|axis| octet.center[axis] + -query.point[axis]);
    let inverse_distance = dot(&to_center, &to_center).inverse_sqrt();
    let outward = scaled(&to_center, -inverse_distance);
    let emission = Emission::look_up(&outward, octet, (grid, table));
    let cloud = Cloud::new(&to_center, octet, &emission);
    let lobes = if HALF { sum_half_lobes(&cloud, query) } else { sum_lobes(&cloud, query) };

    let falloff = falloff(&cloud, inverse_distance, query.inverse_square);
    let parallax = emission.parallax * inverse_distance;
    let value = ((emission.middle - parallax) * lobes.value * falloff).at_least(0.0);
    let error = falloff * total_error(&emission, &lobes, (octet, inverse_distance, grid));

    // f32 rounds the hit's and the node's places by their size.
    let size = dot(&octet.center, &octet.center).rough_sqrt();
    let turn = (size * inverse_distance + 1.0) * ROUNDING;
    let far_error = error + value * 2e-6 + emission.total * lobes.slope * falloff * turn;
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
        place: vectors(|axis| octet.center[axis] + emission.mean[axis]),
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
    /// Error of `middle`, see [`super::interpolation::TableError`].
    uncertainty: Eight,
    /// Interpolated E, consistent with the moments.
    total: Eight,
    mean: Vectors,
    covariance: [Eight; 6],
    parallax: Eight,
    parallax2: Eight,
    /// Norm of the third central moment.
    skewness: Eight,
}

impl Emission {
    #[inline(always)]
    fn look_up(
        outward: &Vectors,
        octet: &Octet,
        (grid, table): (OctahedronGrid, &[Channels]),
    ) -> Emission {
        let l1 = (outward[0].abs() + outward[1].abs() + outward[2].abs()).at_least(1e-30);
        let inverse = l1.recip();
        let on_octahedron = scaled(outward, inverse);
        let channels = interpolate(&on_octahedron, grid, table);
        let total = channels[EMISSION] * l1;
        let gradient = [channels[GRADIENT], channels[GRADIENT + 1], channels[GRADIENT + 2]];
        let tangent = dot(&gradient, outward).smaller(total);
        let normalize = channels[EMISSION].at_least(f32::MIN_POSITIVE).recip();
        let mean = vectors(|axis| channels[MEAN + axis] * normalize);
        let mut covariance = [Eight::ZERO; 6];
        for (i, (a, b)) in PAIRS.into_iter().enumerate() {
            covariance[i] = channels[SPREAD + i] * normalize - mean[a] * mean[b];
        }
        Emission {
            middle: ((total + tangent) * 0.5).at_least(0.0),
            uncertainty: ((total - tangent) * 0.5 * octet.error_share).smaller(octet.largest_error),
            total,
            mean,
            covariance,
            parallax: channels[PARALLAX],
            parallax2: channels[PARALLAX2],
            skewness: channels[SKEWNESS] * l1,
        }
    }
}

/// Every lane from its own node's table.
#[inline(always)]
fn interpolate(at: &Vectors, grid: OctahedronGrid, tables: &[Channels]) -> [Eight; CHANNELS] {
    let triangles = grid.triangles(at);
    let nodes = tables.len() / grid.vertices();
    let mut halves = [[Eight::ZERO; 8]; 2];
    for lane in 0..8 {
        let first = if lane < nodes { lane * grid.vertices() } else { 0 };
        for (half, values) in halves.iter_mut().enumerate() {
            values[lane] = Eight::ZERO;
            for corner in 0..3 {
                let row = &tables[first + triangles.corners[corner].0[lane] as usize].0;
                let weight = triangles.weights[corner].0[lane];
                for i in 0..8 {
                    values[lane].0[i] += row[half * 8 + i] * weight;
                }
            }
        }
    }
    let ([a, b, c, d, e, f, g, h], high) = (transposed(&halves[0]), transposed(&halves[1]));
    let [i, j, k, l, m, n, o, p] = high;
    [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p]
}

/// The samples of a node as the hit sees them.
pub(super) struct Cloud {
    /// Unit, from the hit to the mean place.
    pub direction: Vectors,
    pub inverse_distance: Eight,
    /// Largest distance of a sample from the mean place, over the hit's distance.
    pub cone: Eight,
    /// 2 sin(α/2) of the cone that holds the samples, for `cone` up to [`NEAREST`].
    pub chord: Eight,
    /// 1/(1 − 0.4 cone): how much nearer samples are than their mean, see [`INWARD`].
    pub nearness: Eight,
    /// Norm of the third central moment, over Σ w.
    pub skewness: Eight,
    /// From the node's center to the mean place, and half its box.
    mean: Vectors,
    half_size: Vectors,
    pub covariance: [Eight; 6],
    /// C·direction.
    pub along: Vectors,
    pub trace: Eight,
}

impl Cloud {
    #[inline(always)]
    fn new(to_center: &Vectors, octet: &Octet, emission: &Emission) -> Cloud {
        let mean = &emission.mean;
        let to_mean = vectors(|axis| to_center[axis] + mean[axis]);
        let inverse_distance = dot(&to_mean, &to_mean).inverse_sqrt();
        let direction = scaled(&to_mean, inverse_distance);
        let reach = octet.radius + dot(mean, mean).rough_sqrt().smaller(octet.radius);
        let cone = reach * inverse_distance;
        let nearness = (cone * -INWARD + 1.0).at_least(0.5).recip();
        let along = turned(&emission.covariance, &direction);
        let trace = emission.covariance[0] + emission.covariance[1] + emission.covariance[2];
        Cloud {
            direction,
            inverse_distance,
            cone,
            chord: cone * 1.03, // 2 sin(asin(x)/2) < 1.03 x up to x = 0.45
            nearness,
            skewness: emission.skewness * emission.total.at_least(f32::MIN_POSITIVE).recip(),
            mean: *mean,
            half_size: octet.half_size,
            covariance: emission.covariance,
            along,
            trace: trace.at_least(0.0),
        }
    }

    /// The samples as far apart as if they were nearer by `factor`.
    #[inline(always)]
    pub fn nearer_by(&self, factor: Eight) -> Cloud {
        Cloud {
            inverse_distance: self.inverse_distance * factor,
            cone: self.cone * factor,
            chord: self.chord * factor,
            ..*self
        }
    }

    /// Mean of ((s − c̄)·v)².
    #[inline(always)]
    pub fn spread_along(&self, v: &Vectors) -> Eight {
        dot(v, &turned(&self.covariance, v)).at_least(0.0)
    }

    /// The same along the line of sight.
    #[inline(always)]
    pub fn radial(&self) -> Eight {
        dot(&self.direction, &self.along).at_least(0.0).smaller(self.trace)
    }

    /// Largest |(s − c̄)·v|.
    #[inline(always)]
    pub fn reach_along(&self, v: &Vectors) -> Eight {
        let size = &self.half_size;
        let of_box = v[0].abs() * size[0] + v[1].abs() * size[1] + v[2].abs() * size[2];
        of_box + dot(v, &self.mean).abs()
    }

    #[inline(always)]
    pub fn cos_normal(&self, query: &NodeQuery) -> Eight {
        dot_one(&self.direction, query.normal)
    }
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
    lobes: &LobeSums,
    (octet, inverse_distance, grid): (&Octet, Eight, OctahedronGrid),
) -> Eight {
    // Σ Φ τ²/R², and the root mean square of τ/R times the flux.
    let parallax2 = emission.parallax2.at_least(0.0) * inverse_distance * inverse_distance;
    let parallax = (parallax2 * octet.flux).rough_sqrt();
    let correlated = (parallax2 * emission.total).rough_sqrt();
    let spacing = 4.0 / grid.cells as f32; // rad, the longest edges
    let turned = parallax2 * 3.0 + parallax * (0.25 * spacing);
    // Where τ turns toward the hit some part of what the table knows of, or all of it, neither the
    // mean place nor the moments say where that lies. With an eighth of it as "some" the tests found
    // an error of 1.007 times the estimate, with 0.03 none.
    let anywhere = (emission.total * 0.03).below(turned, turned * lobes.largest, Eight::ZERO);
    emission.total * lobes.error
        + emission.uncertainty * (lobes.at_mean + lobes.swing)
        + correlated * lobes.swing * 1.5
        + turned * (lobes.at_mean + lobes.swing)
        + anywhere
}
