//! Moments of the light from a part of the sphere, and what they send through a lobe.
//!
//! With d the direction of a node's center and A a lobe's axis, ω·A = x + t with x = d·A and
//! t = (ω − d)·A, so that ∫ L (ω·A)ⁿ dω is to third order
//!
//!   xⁿ (∫L + n/x ∫L t + n (n−1)/(2 x²) ∫L t² + n (n−1) (n−2)/(6 x³) ∫L t³),
//!
//! and what is left out is about the fourth derivative's largest value times ∫L t⁴, over 24.

use glam::DVec3;

use super::dome::{CHANNELS, Dome, Luminances};
use super::patch::{DirectionSpread, Patch};
use super::table::CellTable;

/// Index pairs of a symmetric matrix's six entries.
const PAIRS: [(usize, usize); 6] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];

/// Index triples of a symmetric tensor's ten entries, and how often each occurs.
const TRIPLES: [([usize; 3], f64); 10] = [
    ([0, 0, 0], 1.0),
    ([1, 1, 1], 1.0),
    ([2, 2, 2], 1.0),
    ([0, 0, 1], 3.0),
    ([0, 0, 2], 3.0),
    ([1, 1, 0], 3.0),
    ([1, 1, 2], 3.0),
    ([2, 2, 0], 3.0),
    ([2, 2, 1], 3.0),
    ([0, 1, 2], 6.0),
];

/// ∫ L, and ∫ L of the first three powers of ω − d over a node, for one spectrum.
#[derive(Debug, Clone, Copy, Default)]
struct RadianceMoments {
    light: f64,
    first: DVec3,
    second: [f64; 6],
    third: [f64; 10],
}

impl RadianceMoments {
    /// Light from about d + `offset`, with the covariance that the axes' outer products sum to.
    fn add(&mut self, light: f64, offset: DVec3, axes: &[DVec3]) {
        let spread = |a: usize, b: usize| axes.iter().map(|axis| axis[a] * axis[b]).sum::<f64>();
        self.light += light;
        self.first += offset * light;
        for (sum, (a, b)) in self.second.iter_mut().zip(PAIRS) {
            *sum += light * (offset[a] * offset[b] + spread(a, b));
        }
        for (sum, ([a, b, c], _)) in self.third.iter_mut().zip(TRIPLES) {
            let mixed =
                offset[a] * spread(b, c) + offset[b] * spread(a, c) + offset[c] * spread(a, b);
            *sum += light * (offset[a] * offset[b] * offset[c] + mixed);
        }
    }

    /// Adds another node's, whose center is this one's plus `s`.
    fn add_shifted(&mut self, other: &RadianceMoments, s: DVec3) {
        let RadianceMoments { light, first, .. } = *other;
        let second = |a: usize, b: usize| other.second[pair(a, b)];
        for ((sum, third), ([a, b, c], _)) in self.third.iter_mut().zip(other.third).zip(TRIPLES) {
            let once = s[a] * second(b, c) + s[b] * second(a, c) + s[c] * second(a, b);
            let twice = s[a] * s[b] * first[c] + s[a] * s[c] * first[b] + s[b] * s[c] * first[a];
            *sum += third + once + twice + light * s[a] * s[b] * s[c];
        }
        for ((sum, second), (a, b)) in self.second.iter_mut().zip(other.second).zip(PAIRS) {
            *sum += second + first[a] * s[b] + first[b] * s[a] + light * s[a] * s[b];
        }
        self.first += first + s * light;
        self.light += light;
    }

    /// ∫ L t for t = (ω − d)·`axis`, and of its powers.
    fn along(&self, axis: DVec3) -> Powers {
        let square = |(value, (a, b)): (f64, (usize, usize))| {
            let count = if a == b { 1.0 } else { 2.0 };
            count * value * axis[a] * axis[b]
        };
        let cube = |(value, ([a, b, c], count)): (f64, ([usize; 3], f64))| {
            count * value * axis[a] * axis[b] * axis[c]
        };
        Powers {
            first: self.first.dot(axis),
            second: self.second.into_iter().zip(PAIRS).map(square).sum(),
            third: self.third.into_iter().zip(TRIPLES).map(cube).sum(),
        }
    }
}

/// Where [`PAIRS`] has two indices.
fn pair(a: usize, b: usize) -> usize {
    let (low, high) = (a.min(b), a.max(b));
    if low == 0 { high } else { low + high + 1 }
}

/// See [`RadianceMoments::along`].
#[derive(Debug, Clone, Copy)]
struct Powers {
    first: f64,
    second: f64,
    third: f64,
}

/// weight (ω·axis)^exponent on the side of `horizon` where ω·horizon > 0; with a view V, it is the
/// half vector of ω and V in place of ω.
#[derive(Debug, Clone, Copy)]
pub(super) struct FarLobe {
    pub axis: DVec3,
    pub exponent: f64,
    pub weight: f64,
    /// None for a lobe about the normal, which ends at its own horizon.
    pub horizon: Option<DVec3>,
    pub half: Option<DVec3>,
}

impl FarLobe {
    /// In a direction above the horizon.
    pub fn toward(&self, direction: DVec3) -> f64 {
        let half = |view: DVec3| (direction + view).normalize_or_zero();
        let versine = 0.5 * (self.half.map_or(direction, half) - self.axis).length_squared();
        if versine < 1.0 { self.weight * (self.exponent * (-versine).ln_1p()).exp() } else { 0.0 }
    }

    /// Exponent of a lobe about its axis that is as sharp as this one in its sharpest direction.
    pub fn sharpness(&self) -> f64 {
        let cos_view = self.half.map_or(0.5, |view| view.dot(self.axis).max(1e-3));
        self.exponent / (2.0 * cos_view).powi(2)
    }
}

/// What a node sends through lobes.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct NodeSum {
    pub values: Luminances,
    /// Estimate of how wrong the sum of `values` is.
    pub error: f64,
    /// Bound on the sum.
    pub most: f64,
}

/// A part of the sphere.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node {
    pub patch: Patch,
    pub center: DVec3,
    /// Largest distance of its directions from the center's.
    pub radius: f64,
    moments: [RadianceMoments; CHANNELS],
}

impl Node {
    fn empty(patch: Patch) -> Node {
        let moments = [RadianceMoments::default(); CHANNELS];
        Node { patch, center: patch.center(), radius: patch.radius(), moments }
    }

    /// From four looks into a patch no larger than a cell.
    pub fn from_dome(dome: &Dome, patch: Patch) -> Node {
        let mut node = Node::empty(patch);
        for part in patch.parts([2, 2]) {
            node.add(dome.luminances(part.place(), part.center()), &part.spread());
        }
        node
    }

    /// From the mean luminances of its cells.
    pub fn from_table(table: &CellTable, patch: Patch) -> Node {
        let mut node = Node::empty(patch);
        table.for_each(&patch, |luminances, spread| node.add(luminances, &spread));
        node
    }

    fn add(&mut self, luminances: Luminances, spread: &DirectionSpread) {
        for (moments, luminance) in self.moments.iter_mut().zip(luminances) {
            if luminance > 0.0 {
                let light = luminance * spread.solid_angle;
                moments.add(light, spread.mean - self.center, &spread.axes);
            }
        }
    }

    pub fn from_halves(patch: Patch, halves: [&Node; 2]) -> Node {
        let mut node = Node::empty(patch);
        for half in halves {
            let shift = half.center - node.center;
            for (moments, other) in node.moments.iter_mut().zip(&half.moments) {
                moments.add_shifted(other, shift);
            }
        }
        node
    }

    /// ∫ L over it, all spectra together.
    pub fn light(&self) -> f64 {
        self.moments.iter().map(|moments| moments.light).sum()
    }

    /// Where its light comes from on average.
    pub fn mean_direction(&self) -> DVec3 {
        let first: DVec3 = self.moments.iter().map(|moments| moments.first).sum();
        (self.center + first / self.light().max(f64::MIN_POSITIVE)).normalize()
    }

    pub fn sum(&self, lobes: &[FarLobe]) -> NodeSum {
        let mut total = NodeSum::default();
        let light = self.light();
        if light == 0.0 {
            return total;
        }
        for lobe in lobes {
            let share = self.share_above(lobe.horizon);
            if share > 0.0 {
                let sum = self.sum_lobe(lobe, light);
                for (total, value) in total.values.iter_mut().zip(sum.values) {
                    *total += value * share;
                }
                let cut = if share < 1.0 { 0.5 * sum.most } else { 0.0 };
                total.error += (sum.error + cut).min(sum.most);
                total.most += sum.most;
            }
        }
        total
    }

    /// How much of the node is above a lobe's horizon, 0 to 1.
    fn share_above(&self, horizon: Option<DVec3>) -> f64 {
        let height = horizon.map_or(1.0, |horizon| self.center.dot(horizon));
        let reach = horizon.map_or(1.0, |_| reach(height, self.radius));
        (0.5 + 0.5 * height / reach).clamp(0.0, 1.0)
    }

    fn sum_lobe(&self, lobe: &FarLobe, light: f64) -> NodeSum {
        if let Some(view) = lobe.half {
            return self.sum_half(lobe, view, light);
        }
        let FarLobe { axis, exponent: n, weight, .. } = *lobe;
        let versine = 0.5 * (self.center - axis).length_squared();
        let angle = LobeAngle::new(versine, self.radius);
        if angle.x + angle.reach <= 0.0 {
            return NodeSum::default();
        }
        let highest = power(angle.nearest, n);
        let most = weight * light * highest;
        let powers = self.moments.map(|moments| moments.along(axis));
        let each = |f: &dyn Fn(&RadianceMoments, &Powers) -> f64| {
            let capped = |at: usize| {
                let moments = &self.moments[at];
                weight * f(moments, &powers[at]).clamp(0.0, moments.light * highest)
            };
            std::array::from_fn(capped)
        };
        let second = powers.iter().map(|powers| powers.second).sum::<f64>();
        if angle.x <= angle.reach {
            let shift = powers.iter().map(|powers| powers.first).sum::<f64>() / light;
            let error = weight * light * angle.bend(angle.x + shift, highest, n);
            let values = each(&|moments, powers| moments.over_horizon(powers, &angle, n));
            return NodeSum { values, error: error.min(most), most };
        }
        let peak = power(versine, n);
        let error = weight * second * angle.fourth_order(second / light, n);
        let values = each(&|moments, powers| peak * moments.relative(powers, angle.x, n));
        NodeSum { values, error: error.min(most), most }
    }
}

impl Node {
    /// cosⁿβ of the half vector is ((N·ω + N·V)/|ω + V|)ⁿ. With a = N·t/(N·d + N·V),
    /// b = V·t/(1 + d·V), t = ω − d and s = a − b/2, it is to third order
    ///
    ///   e^(n (s − a²/2 + b²/4 + a³/3 − b³/6))
    ///
    /// of what it is at d. What is left out is estimated as for a Gaussian of H that turns by 1/D of
    /// what ω does at most, D = |ω + V|.
    fn sum_half(&self, lobe: &FarLobe, view: DVec3, light: f64) -> NodeSum {
        let FarLobe { axis: normal, exponent: n, weight, .. } = *lobe;
        let sum = self.center + view;
        let (height, width) = (sum.dot(normal), sum.length());
        let turning = (width - self.radius).max(f64::MIN_POSITIVE).recip();
        let sine = (sum / width.max(f64::MIN_POSITIVE)).cross(normal).length();
        let nearest = (sine - self.radius * turning).clamp(0.0, 1.0);
        let highest =
            if height <= -self.radius { 0.0 } else { (1.0 - nearest * nearest).powf(0.5 * n) };
        let most = weight * light * highest;
        let peak = if height > 0.0 { lobe.toward(self.center) / weight } else { 0.0 };
        if 2.0 * self.radius > width.min(height) || most == 0.0 {
            let values = self.moments.map(|moments| weight * peak * moments.light);
            return NodeSum { values, error: most, most };
        }
        let (a, b) = (normal / height, view / (0.5 * width * width));
        let relative = |moments: &RadianceMoments| {
            weight * (peak * moments.half(a, b, n)).clamp(0.0, highest * moments.light)
        };
        let values = self.moments.each_ref().map(relative);
        let square: f64 = self.moments.iter().map(RadianceMoments::square).sum::<f64>() / light;
        let bent = half_fourth_order(n, sine / (height / width)) * turning.powi(4);
        let error = most * bent / 24.0 * square * (2.0 * square).min(self.radius * self.radius);
        NodeSum { values, error: error.min(most), most }
    }
}

/// Largest fourth derivative of cosⁿβ, over it, by an angle that turns H as much, for the tangent
/// of β; H's way may bend, as the light tree's does.
fn half_fourth_order(n: f64, tan: f64) -> f64 {
    let x = n.sqrt() * tan;
    let first = n.sqrt() * x;
    let second = n * (1.0 + x * x);
    let third = n.powf(1.5) * (3.0 * x + x.powi(3));
    let fourth = n * n * (3.0 + 6.0 * x * x + x.powi(4));
    fourth + 15.6 * third + 53.0 * second + 45.0 * first
}

/// Where a node's directions lie about a lobe's axis.
struct LobeAngle {
    /// Cosine of the angle from the center.
    x: f64,
    /// Largest |t|.
    reach: f64,
    /// Least 1 − ω·A.
    nearest: f64,
}

impl LobeAngle {
    /// For a node whose center has 1 − x = `versine`.
    fn new(versine: f64, radius: f64) -> LobeAngle {
        let x = 1.0 - versine;
        let reach = reach(x, radius);
        let sine = (versine * (2.0 - versine)).max(0.0).sqrt();
        let inward = if x < 0.0 { reach } else { sine * radius };
        LobeAngle { x, reach, nearest: (versine - inward).max(0.0) }
    }

    /// Half of how far the bounds of the mean of max(0, ·)ⁿ are apart, a convex function: its value
    /// at the mean, and the chord from the lowest to the highest.
    fn bend(&self, mean: f64, highest: f64, n: f64) -> f64 {
        let [low, high] = self.range();
        let chord = highest * ((mean - low) / (high - low)).clamp(0.0, 1.0);
        0.5 * (chord - mean.max(0.0).powf(n)).max(0.0)
    }

    /// Least and largest ω·A.
    fn range(&self) -> [f64; 2] {
        [self.x - self.reach, 1.0 - self.nearest]
    }

    /// Largest fourth derivative of xⁿ over 24, times what t² is where light is: about three times
    /// its mean, as in a bell curve, and at most its largest.
    fn fourth_order(&self, mean_square: f64, n: f64) -> f64 {
        let lowest = (1.0 - self.x + self.reach).min(1.0);
        let steepest = if n >= 4.0 { self.nearest } else { lowest };
        let factors = (n * (n - 1.0) * (n - 2.0) * (n - 3.0)).abs() / 24.0;
        let square = (3.0 * mean_square).min(self.reach * self.reach);
        factors * power(steepest, n - 4.0) * square
    }
}

/// How far ω·a may be from d·a = `cosine`, for unit ω within `radius` of d.
fn reach(cosine: f64, radius: f64) -> f64 {
    (1.0 - cosine * cosine).max(0.0).sqrt() * radius + 0.5 * radius * radius
}

/// (1 − versine)ⁿ, with the digits of a small versine.
fn power(versine: f64, n: f64) -> f64 {
    if versine >= 1.0 { 0.0 } else { (n * (-versine).ln_1p()).exp() }
}

impl RadianceMoments {
    /// ∫ L |ω − d|².
    fn square(&self) -> f64 {
        self.second[0] + self.second[3] + self.second[5]
    }

    /// ∫ L of the series of [`Node::sum_half`].
    fn half(&self, a: DVec3, b: DVec3, n: f64) -> f64 {
        let s = a - 0.5 * b;
        let [of_s, of_a, of_b] = [s, a, b].map(|axis| self.along(axis));
        // ∫ L (s·t) (a·t)², from cubes.
        let mixed = |a: DVec3| {
            let cubes = self.along(s + a).third + self.along(s - a).third;
            (cubes - 2.0 * of_s.third) / 6.0
        };
        let first = of_s.first - 0.5 * of_a.second + 0.25 * of_b.second;
        let first = first + of_a.third / 3.0 - of_b.third / 6.0;
        let second = 0.5 * of_s.second - 0.5 * mixed(a) + 0.25 * mixed(b);
        self.light + n * (first + n * (second + n * of_s.third / 6.0))
    }

    /// ∫ L (ω·A)ⁿ over xⁿ: to third order, and the fourth as for an even spread.
    fn relative(&self, powers: &Powers, x: f64, n: f64) -> f64 {
        let first = n / x;
        let second = first * (n - 1.0) / (2.0 * x);
        let third = second * (n - 2.0) / (3.0 * x);
        let fourth = third * (n - 3.0) / (4.0 * x);
        // Of an even spread ∫ t⁴ is 9/5 (∫ t²)².
        let even = 1.8 * powers.second * powers.second / self.light.max(f64::MIN_POSITIVE);
        let higher = third * powers.third + fourth * even;
        self.light + first * powers.first + second * powers.second + higher
    }

    /// ∫ L max(0, ·)ⁿ over light that is spread evenly about its mean, as wide as it is.
    fn over_horizon(&self, powers: &Powers, angle: &LobeAngle, n: f64) -> f64 {
        if self.light == 0.0 {
            return 0.0;
        }
        let shift = powers.first / self.light;
        let variance = powers.second / self.light - shift * shift;
        let mean = angle.x + shift;
        let [low, high] = angle.range();
        let half = (3.0 * variance).max(0.0).sqrt().min(high - mean).min(mean - low).max(1e-12);
        let up_to = |end: f64| end.max(0.0).powf(n + 1.0);
        self.light * (up_to(mean + half) - up_to(mean - half)) / (2.0 * half * (n + 1.0))
    }
}
