//! The exact sum over a few hundred neighboring samples, in f32 lanes.
//!
//! Everything is relative to the block's center, and taken in a frame about the lobes' axis, so
//! that the sine of the angle from the axis keeps its digits where a lobe of exponent 10⁶ needs
//! them. The passes run over whole arrays, so that the compiler vectorizes each of them.

use std::ops::Range;

use glam::DVec3;

use super::Side;
use super::lanes::{LARGEST_EXPONENT, exp_neg, inverse_sqrt, larger, neg_ln, neg_ln_1m, smaller};
use super::power::{LobeSet, Power};
use crate::simd::widest;

/// Samples whose partial sums are kept apart; the order of summation depends on nothing else.
pub(crate) const LANES: usize = 16;

/// Most samples in a block, padding included.
pub(crate) const BLOCK_CAPACITY: usize = 320;

/// Sixteen samples: positions relative to their block's center, directions times flux.
///
/// A lane without a sample has flux 0.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(crate) struct SampleGroup {
    pub offset: [[f32; LANES]; 3],
    pub flux: [[f32; LANES]; 3],
}

impl SampleGroup {
    pub const EMPTY: SampleGroup =
        SampleGroup { offset: [[0.0; LANES]; 3], flux: [[0.0; LANES]; 3] };

    /// Directions times flux of the samples.
    pub fn fluxes(&self) -> impl Iterator<Item = DVec3> + '_ {
        let lane = |i: usize| DVec3::from([0, 1, 2].map(|axis| f64::from(self.flux[axis][i])));
        (0..LANES).map(lane).filter(|flux| *flux != DVec3::ZERO)
    }
}

/// Neighboring samples, at most [`BLOCK_CAPACITY`].
#[derive(Debug, Clone)]
pub(crate) struct Block {
    pub center: DVec3,
    /// Radius of a sphere about `center` that holds the samples.
    pub radius: f64,
    /// Into the tree's groups.
    pub groups: Range<u32>,
    /// Into the tree's order of samples.
    pub samples: Range<u32>,
}

/// Whether a block contributes, and what of the lobes reaches it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Reach {
    Nothing,
    DiffuseOnly,
    AllLobes,
    /// f32 would not keep model.md's accuracy: sum the block in f64.
    NeedsF64,
}

impl Block {
    /// `query` in the block's coordinates.
    ///
    /// f32 rounds a sample's place by about 2⁻²⁴ of the block's radius, which turns its direction
    /// by that over the distance; a lobe n changes by n θ times the turn, with n θ²/2 < 70 where
    /// it counts. √n · radius/distance ≤ 100 keeps this under 2e-4. A direction taken from a
    /// cosine alone loses n · 2e-7, so diffuse exponents over 1000 are left to f64, too.
    pub fn reach(&self, query: &BlockQuery) -> Reach {
        let (side, lobes) = (&query.side, query.lobes);
        let to_center = self.center - query.point;
        if to_center.dot(side.normal) <= -self.radius {
            return Reach::Nothing;
        }
        let distance = to_center.length();
        let nearest = distance - self.radius;
        let in_range = nearest > 1e-12 && distance < 1e12;
        let largest = lobes.largest_exponent.max(query.exponent);
        if !in_range || largest.sqrt() * self.radius > 100.0 * nearest || lobes.diffuse_needs_f64()
        {
            return Reach::NeedsF64;
        }
        let chord =
            (side.axis - to_center / distance).length() - cone_chord(self.radius / distance);
        let versine = 0.5 * chord.max(0.0).powi(2);
        // β of a half-vector lobe is at least half the angle from the axis.
        let halved = if side.is_half { 0.5 } else { 1.0 };
        let exponent = halved * lobes.smallest_specular * -(-(halved * versine).min(1.0)).ln_1p();
        match (exponent < f64::from(LARGEST_EXPONENT), lobes.diffuse.weight > 0.0) {
            (true, _) => Reach::AllLobes,
            (false, true) => Reach::DiffuseOnly,
            (false, false) => Reach::Nothing,
        }
    }
}

/// 2 sin(α/2) of the cone's half angle α = asin(sine), for sine < 1.
fn cone_chord(sine: f64) -> f64 {
    let versine = sine * sine / (1.0 + (1.0 - sine * sine).max(0.0).sqrt());
    (2.0 * versine).sqrt()
}

/// A hit's side as a block's kernel sees it.
struct LocalSide {
    /// Block center − P.
    base: [f32; 3],
    /// Rows t, b, m: m is the lobes' axis, t lies in the plane of m and the normal.
    frame: [[f32; 3]; 3],
    /// `base` in that frame, rounded after the turn.
    framed_base: [f32; 3],
    /// The normal's components along t and m.
    normal: [f32; 2],
    inverse_square: bool,
    /// Exponent of the samples' own lobes.
    exponent: f32,
    is_half: bool,
}

impl LocalSide {
    fn new(center: DVec3, query: &BlockQuery) -> LocalSide {
        let (base, side) = (center - query.point, &query.side);
        let m = side.axis;
        let across = side.normal - m * m.dot(side.normal);
        // Where both are the same but for rounding, so is what lies across: it has no direction.
        let t = across.try_normalize().filter(|_| across.length() > 1e-8);
        let t = t.unwrap_or_else(|| m.any_orthonormal_vector());
        let b = m.cross(t);
        let frame = [t, b, m];
        LocalSide {
            base: base.as_vec3().into(),
            frame: frame.map(|row| row.as_vec3().into()),
            framed_base: frame.map(|row| row.dot(base) as f32),
            normal: [side.normal.dot(t) as f32, side.normal.dot(m) as f32],
            inverse_square: query.inverse_square,
            exponent: query.exponent as f32,
            is_half: side.is_half,
        }
    }
}

/// Work arrays of a block, and each sample's contribution afterwards.
pub(crate) struct Scratch {
    cos_normal: [f32; BLOCK_CAPACITY],
    cos_axis: [f32; BLOCK_CAPACITY],
    /// Squared sine of the angle from the axis. For half-vector lobes both are the half vector's from
    /// the normal.
    sine2: [f32; BLOCK_CAPACITY],
    emitted: [f32; BLOCK_CAPACITY],
    scattered: [f32; BLOCK_CAPACITY],
    power: [f32; BLOCK_CAPACITY],
}

impl Scratch {
    pub fn new() -> Scratch {
        let zeros = [0.0; BLOCK_CAPACITY];
        Scratch {
            cos_normal: zeros,
            cos_axis: zeros,
            sine2: zeros,
            emitted: zeros,
            scattered: zeros,
            power: zeros,
        }
    }

    /// Contributions of the last block evaluated.
    pub fn contributions(&self, count: usize) -> impl Iterator<Item = f32> + '_ {
        self.emitted.iter().zip(&self.scattered).take(count).map(|(e, s)| e * s)
    }
}

/// What a block is asked, beside its samples.
pub(crate) struct BlockQuery<'a> {
    pub point: DVec3,
    pub side: Side,
    pub lobes: &'a LobeSet,
    pub inverse_square: bool,
    /// Exponent of the samples' own lobes; 1 for Lambert's.
    pub exponent: f64,
}

/// Σ over the block's samples with L·normal > 0, without `LobeSet::unit`.
pub(crate) fn sum_block(
    groups: &[SampleGroup],
    center: DVec3,
    query: &BlockQuery,
    reach: Reach,
    scratch: &mut Scratch,
) -> f64 {
    let side = LocalSide::new(center, query);
    let specular: &[Power] = match reach {
        Reach::AllLobes => &query.lobes.specular,
        _ => &[],
    };
    let (side, lobes) = (&side, (query.lobes.diffuse, specular));
    widest!(kernel(
        groups: &[SampleGroup],
        side: &LocalSide,
        lobes: (Power, &[Power]),
        scratch: &mut Scratch
    ) -> f64)
}

#[inline(always)]
fn kernel(
    groups: &[SampleGroup],
    side: &LocalSide,
    (diffuse, specular): (Power, &[Power]),
    scratch: &mut Scratch,
) -> f64 {
    let count = (groups.len() * LANES).min(BLOCK_CAPACITY);
    for (i, group) in groups.iter().enumerate().take(BLOCK_CAPACITY / LANES) {
        place_group(group, side, i * LANES, scratch);
        if side.exponent != 1.0 {
            narrow_group(group, side, i * LANES, scratch);
        }
        if side.is_half {
            halve_group(group, side, i * LANES, scratch);
        }
    }
    let Scratch { cos_normal, cos_axis, sine2, emitted, scattered, power } = scratch;
    diffuse_power(diffuse, &cos_normal[..count], &mut scattered[..count]);
    for lobe in specular {
        match lobe.integer {
            Some(n) => {
                power[..count].copy_from_slice(&cos_axis[..count]);
                add_integer_power(n, lobe.weight, &mut power[..count], &mut scattered[..count]);
            }
            None => add_power(*lobe, &sine2[..count], &mut scattered[..count]),
        }
    }
    fold(&emitted[..count], &scattered[..count])
}

/// Angles from normal and axis, and Φ c (over r² if asked).
#[inline(always)]
fn place_group(group: &SampleGroup, side: &LocalSide, start: usize, scratch: &mut Scratch) {
    let ([t, b, m], [u0, v0, w0]) = (side.frame, side.framed_base);
    let lanes = start..start + LANES;
    let cos_normal = &mut scratch.cos_normal[lanes.clone()];
    let cos_axis = &mut scratch.cos_axis[lanes.clone()];
    let sine2 = &mut scratch.sine2[lanes.clone()];
    let emitted = &mut scratch.emitted[lanes];
    for i in 0..LANES {
        let (x, y, z) = (group.offset[0][i], group.offset[1][i], group.offset[2][i]);
        let u = u0 + (t[0] * x + t[1] * y + t[2] * z);
        let v = v0 + (b[0] * x + b[1] * y + b[2] * z);
        let w = w0 + (m[0] * x + m[1] * y + m[2] * z);
        let across = u * u + v * v;
        let inverse = inverse_sqrt(larger(across + w * w, f32::MIN_POSITIVE));
        let toward = (side.base[0] + x) * group.flux[0][i]
            + (side.base[1] + y) * group.flux[1][i]
            + (side.base[2] + z) * group.flux[2][i];
        let cosine = (side.normal[0] * u + side.normal[1] * w) * inverse;
        let falloff = if side.inverse_square { inverse * inverse } else { 1.0 };
        let emission = larger(-toward * inverse, 0.0) * falloff;
        cos_normal[i] = smaller(larger(cosine, 0.0), 1.0);
        cos_axis[i] = smaller(larger(w * inverse, 0.0), 1.0);
        sine2[i] = if w > 0.0 { smaller(across * inverse * inverse, 1.0) } else { 1.0 };
        emitted[i] = if cosine > 0.0 { emission } else { 0.0 };
    }
}

/// The angle of the half vector from the normal in place of that from the axis: L + V lies across N
/// as L − M does, which has its digits where the lobe is.
#[inline(always)]
fn halve_group(group: &SampleGroup, side: &LocalSide, start: usize, scratch: &mut Scratch) {
    let ([t, b, m], [u0, v0, w0]) = (side.frame, side.framed_base);
    let lanes = start..start + LANES;
    let cos_axis = &mut scratch.cos_axis[lanes.clone()];
    let sine2 = &mut scratch.sine2[lanes];
    for i in 0..LANES {
        let (x, y, z) = (group.offset[0][i], group.offset[1][i], group.offset[2][i]);
        let u = u0 + (t[0] * x + t[1] * y + t[2] * z);
        let v = v0 + (b[0] * x + b[1] * y + b[2] * z);
        let w = w0 + (m[0] * x + m[1] * y + m[2] * z);
        let square = u * u + v * v;
        let inverse = inverse_sqrt(larger(square + w * w, f32::MIN_POSITIVE));
        let (u, v, w) = (u * inverse, v * inverse, w * inverse);
        let off_m = if w > 0.0 { -(square * inverse * inverse) / (1.0 + w) } else { w - 1.0 };
        let along = side.normal[1] * u - side.normal[0] * off_m;
        let height = side.normal[0] * u + side.normal[1] * w + side.normal[1];
        let across = along * along + v * v;
        let inverse = inverse_sqrt(larger(across + height * height, f32::MIN_POSITIVE));
        cos_axis[i] = smaller(larger(height * inverse, 0.0), 1.0);
        sine2[i] = smaller(across * inverse * inverse, 1.0);
    }
}

/// Φ cᵐ (over r² if asked) in place of Φ c. The lobe is taken from the chord between the sample's
/// direction and the way to the hit, which keeps its digits where a cosine is near 1.
#[inline(always)]
fn narrow_group(group: &SampleGroup, side: &LocalSide, start: usize, scratch: &mut Scratch) {
    let emitted = &mut scratch.emitted[start..start + LANES];
    #[allow(clippy::needless_range_loop)] // lanes of many arrays
    for i in 0..LANES {
        let l: [f32; 3] = [0, 1, 2].map(|axis| side.base[axis] + group.offset[axis][i]);
        let q: [f32; 3] = [0, 1, 2].map(|axis| group.flux[axis][i]);
        let square =
            |v: [f32; 3]| larger(v[0] * v[0] + v[1] * v[1] + v[2] * v[2], f32::MIN_POSITIVE);
        let flux2 = square(q);
        let (inverse, inverse_flux) = (inverse_sqrt(square(l)), inverse_sqrt(flux2));
        let versine =
            0.5 * square([0, 1, 2].map(|axis| l[axis] * inverse + q[axis] * inverse_flux));
        let cos_power = exp_neg(side.exponent * neg_ln_1m(smaller(versine, 1.0 - f32::EPSILON)));
        let falloff = if side.inverse_square { inverse * inverse } else { 1.0 };
        let emission = flux2 * inverse_flux * cos_power * falloff;
        emitted[i] = if emitted[i] > 0.0 { emission } else { 0.0 };
    }
}

#[inline(always)]
fn diffuse_power(lobe: Power, cosine: &[f32], scattered: &mut [f32]) {
    if lobe.weight == 0.0 {
        scattered.fill(0.0);
    } else if let Some(n) = lobe.integer {
        scattered.copy_from_slice(cosine);
        integer_power(n, scattered, |value, power| *value = lobe.weight * power);
    } else {
        for (value, cos) in scattered.iter_mut().zip(cosine) {
            *value = lobe.weight * exp_neg(lobe.exponent * neg_ln(*cos));
        }
    }
}

#[inline(always)]
fn add_integer_power(n: u32, weight: f32, cosine: &mut [f32], scattered: &mut [f32]) {
    integer_power(n, cosine, |value, power| *value = power);
    for (value, power) in scattered.iter_mut().zip(cosine) {
        *value += weight * *power;
    }
}

/// weight · cosⁿ = weight · exp(n/2 · ln(1 − sin²)).
#[inline(always)]
fn add_power(lobe: Power, sine2: &[f32], scattered: &mut [f32]) {
    let half = 0.5 * lobe.exponent;
    for (value, sine2) in scattered.iter_mut().zip(sine2) {
        *value += lobe.weight * exp_neg(half * neg_ln_1m(*sine2));
    }
}

/// cosⁿ of every value by squarings, most significant bit first.
#[inline(always)]
fn integer_power(n: u32, values: &mut [f32], store: impl Fn(&mut f32, f32)) {
    for lanes in values.chunks_exact_mut(LANES) {
        let base: [f32; LANES] = std::array::from_fn(|i| lanes[i]);
        let mut power = base;
        for bit in (0..n.ilog2()).rev() {
            power = std::array::from_fn(|i| power[i] * power[i]);
            if n >> bit & 1 == 1 {
                power = std::array::from_fn(|i| power[i] * base[i]);
            }
        }
        for i in 0..LANES {
            store(&mut lanes[i], power[i]);
        }
    }
}

#[inline(always)]
fn fold(emitted: &[f32], scattered: &[f32]) -> f64 {
    let mut lanes = [0.0f32; LANES];
    for (e, s) in emitted.chunks_exact(LANES).zip(scattered.chunks_exact(LANES)) {
        for i in 0..LANES {
            lanes[i] += e[i] * s[i];
        }
    }
    lanes.iter().map(|lane| f64::from(*lane)).sum()
}
