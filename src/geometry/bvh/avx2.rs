//! The kernel for x86-64 with AVX2 and FMA.

use std::arch::asm;
use std::arch::x86_64::*;

use super::super::{DVec3, Hit, Ray, TriangleId};
use super::Bvh;
use super::bounds::Frame;
use super::kernel::{Aim, TriangleKernel};
use super::probe::{self, CANCELLATION, Crossing, Probe};
use super::query::{FirstHit, Segment};
use super::shaft::{Role, Shaft, Sides, Slabs};
use super::walk::LEAST_DIRECTION;
use super::wide::{CORNERS, LANES, Lanes, Packet, WideNode};

/// A ray in the tree's frame, each value in all lanes.
#[derive(Clone, Copy)]
pub(super) struct WideRay {
    inverse: [__m256; 3],
    origin_inverse: [__m256; 3],
    /// Where the plane lies through which the ray enters, in bytes from the start of a node; the
    /// other plane of the axis is found by flipping `PLANE_BYTES`.
    entry: [usize; 3],
    /// [`Probe::shear`].
    shear: [__m256; 3],
}

/// Bytes of one plane of a node.
const PLANE_BYTES: usize = size_of::<Lanes>();

/// Used only in functions compiled for AVX2 and FMA, into which all of it is inlined.
pub(super) struct Avx2;

impl TriangleKernel for Avx2 {
    type Ray = WideRay;

    #[inline(always)]
    fn aim(probe: &Probe, direction: &DVec3, frame: &Frame) -> WideRay {
        // SAFETY: as in `enter`.
        unsafe {
            let origin = _mm256_sub_pd(triple(&probe.origin), triple(frame.center.as_ref()));
            let origin = _mm256_cvtpd_ps(_mm256_mul_pd(origin, _mm256_set1_pd(frame.per_mm)));
            let direction = _mm256_cvtpd_ps(triple(direction.as_ref()));
            let minus = _mm_set1_ps(-0.0);
            let least = _mm_set1_ps(LEAST_DIRECTION);
            let is_less = _mm_cmplt_ps(_mm_andnot_ps(minus, direction), least);
            let guarded = _mm_or_ps(_mm_and_ps(minus, direction), least);
            let inverse = _mm_div_ps(_mm_set1_ps(1.0), _mm_blendv_ps(direction, guarded, is_less));
            let product = _mm_mul_ps(origin, inverse);
            let signs = _mm_movemask_ps(inverse) as usize;
            WideRay {
                inverse: [
                    spread::<0x00>(inverse),
                    spread::<0x55>(inverse),
                    spread::<0xaa>(inverse),
                ],
                origin_inverse: [
                    spread::<0x00>(product),
                    spread::<0x55>(product),
                    spread::<0xaa>(product),
                ],
                entry: [
                    (signs & 1) * PLANE_BYTES,
                    (signs >> 1 & 1) * PLANE_BYTES + 2 * PLANE_BYTES,
                    (signs >> 2 & 1) * PLANE_BYTES + 4 * PLANE_BYTES,
                ],
                shear: probe.shear.map(|s| _mm256_set1_ps(s as f32)),
            }
        }
    }

    #[inline(always)]
    fn enter(node: &WideNode, ray: &WideRay, end: f32) -> (u32, Lanes) {
        let mut near_lanes = [0.0; 8];
        // SAFETY: only `closest`, `occluded` and `hits` below use this kernel; `Bvh` calls them only where
        // the processor has their features.
        let lanes = unsafe {
            let entry = |axis: usize| plane(node, ray.entry[axis], ray, axis);
            let exit = |axis: usize| plane(node, ray.entry[axis] ^ PLANE_BYTES, ray, axis);
            // Pairs, which shorten the chain that each step of a ray waits for.
            let near = _mm256_max_ps(
                _mm256_max_ps(entry(0), entry(1)),
                _mm256_max_ps(entry(2), _mm256_setzero_ps()),
            );
            let far = _mm256_min_ps(
                _mm256_min_ps(exit(0), exit(1)),
                _mm256_min_ps(exit(2), _mm256_set1_ps(end)),
            );
            _mm256_storeu_ps(near_lanes.as_mut_ptr(), near);
            _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(near, far))
        };
        (lanes as u32, near_lanes)
    }

    #[inline(always)]
    fn branch<const TAG: usize>() {
        // SAFETY: a comment for the assembler.
        unsafe { asm!("# {0}", const TAG, options(nomem, nostack, preserves_flags)) }
    }

    #[inline(always)]
    fn prefetch(start: *const u8) {
        for line in 0..size_of::<Packet>() / 64 {
            // SAFETY: prefetching any address is sound.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(64 * line).cast()) }
        }
    }

    #[inline(always)]
    fn may_meet(packet: &Packet, ray: &WideRay, aim: &Aim) -> u32 {
        // SAFETY: as above.
        unsafe {
            let [x, y, z] = shear(packet, aim.probe, ray);
            let minus = _mm256_set1_ps(-0.0);
            let width = _mm256_add_ps(_mm256_andnot_ps(minus, x), _mm256_andnot_ps(minus, y));
            let places =
                [widen(&packet.corners[0]), widen(&packet.corners[1]), widen(&packet.corners[2])];
            let (ax, bx, cx) = gather(x, &places);
            let (ay, by, cy) = gather(y, &places);
            let (az, bz, cz) = gather(z, &places);
            let (wide_a, wide_b, wide_c) = gather(width, &places);
            let near = _mm256_min_ps(_mm256_min_ps(az, bz), cz);
            let far = _mm256_max_ps(_mm256_max_ps(az, bz), cz);
            let end = _mm256_set1_ps(aim.end_mm);
            let is_beyond = _mm256_or_ps(
                _mm256_cmp_ps::<_CMP_LT_OQ>(far, _mm256_setzero_ps()),
                _mm256_cmp_ps::<_CMP_GT_OQ>(near, end),
            );
            let (wa, wb, wc) = (edge(cx, cy, bx, by), edge(ax, ay, cx, cy), edge(bx, by, ax, ay));
            let least = _mm256_min_ps(_mm256_min_ps(wa, wb), wc);
            let most = _mm256_max_ps(_mm256_max_ps(wa, wb), wc);
            let width = _mm256_add_ps(_mm256_add_ps(wide_a, wide_b), wide_c);
            let depth = _mm256_max_ps(far, _mm256_xor_ps(near, minus));
            let reach = _mm256_mul_ps(_mm256_add_ps(width, depth), _mm256_set1_ps(EDGE_SLACK));
            let slack = _mm256_fmadd_ps(width, reach, _mm256_set1_ps(LEAST_EDGE));
            let is_beside = _mm256_and_ps(
                _mm256_cmp_ps::<_CMP_LT_OQ>(least, _mm256_xor_ps(slack, minus)),
                _mm256_cmp_ps::<_CMP_GT_OQ>(most, slack),
            );
            let triangles = _mm256_loadu_si256(packet.triangles.as_ptr().cast());
            let is_left = _mm256_cmpeq_epi32(triangles, _mm256_set1_epi32(aim.leaving as i32));
            let is_left = _mm256_castsi256_ps(is_left);
            let is_out = _mm256_or_ps(_mm256_or_ps(is_beyond, is_left), is_beside);
            !_mm256_movemask_ps(is_out) as u32 & u32::from(packet.present)
        }
    }

    #[inline(always)]
    fn cross(packet: &Packet, lane: usize, probe: &Probe) -> Option<Crossing> {
        // SAFETY: as above.
        unsafe { cross(packet, lane, probe) }
    }
}

/// [`Probe::cross_lane`] with the corners in lanes: each operation is one of that.
///
/// Not part of the loops that call it, whose registers are all in use.
#[inline(never)]
#[target_feature(enable = "avx2,fma")]
fn cross(packet: &Packet, lane: usize, probe: &Probe) -> Option<Crossing> {
    let [kx, ky, kz] = probe.axes;
    // SAFETY: this function is compiled for AVX2.
    unsafe {
        let z = corners(packet, lane, kz);
        let depth = _mm256_sub_pd(z, _mm256_set1_pd(probe.origin[kz]));
        let x = _mm256_sub_pd(corners(packet, lane, kx), _mm256_set1_pd(probe.origin[kx]));
        let y = _mm256_sub_pd(corners(packet, lane, ky), _mm256_set1_pd(probe.origin[ky]));
        let x = _mm256_sub_pd(x, _mm256_mul_pd(_mm256_set1_pd(probe.shear[0]), depth));
        let y = _mm256_sub_pd(y, _mm256_mul_pd(_mm256_set1_pd(probe.shear[1]), depth));
        let z = _mm256_mul_pd(_mm256_set1_pd(probe.shear[2]), depth);
        // Lanes: edge(c, b), edge(a, c), edge(b, a).
        let (px, py) = (turn::<CAB>(x), turn::<CAB>(y));
        let (qx, qy) = (turn::<BCA>(x), turn::<BCA>(y));
        let (left, right) = (_mm256_mul_pd(px, qy), _mm256_mul_pd(py, qx));
        let edges = _mm256_sub_pd(left, right);
        let minus = _mm256_set1_pd(-0.0);
        let sum = _mm256_add_pd(_mm256_andnot_pd(minus, left), _mm256_andnot_pd(minus, right));
        let least = _mm256_mul_pd(_mm256_set1_pd(CANCELLATION), sum);
        let is_cancelled = _mm256_cmp_pd::<_CMP_LE_OQ>(_mm256_andnot_pd(minus, edges), least);
        if _mm256_movemask_pd(is_cancelled) & 7 != 0 {
            return cross_cancelled(packet, lane, probe);
        }
        let zero = _mm256_setzero_pd();
        let negative = _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LT_OQ>(edges, zero)) & 7;
        let positive = _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_GT_OQ>(edges, zero)) & 7;
        if negative != 0 && positive != 0 {
            return None;
        }
        let [wa, wb, wc] = first_three(edges);
        let [ta, tb, tc] = first_three(_mm256_mul_pd(edges, z));
        probe::crossing([wa, wb, wc], ta + tb + tc)
    }
}

/// Orders of lanes for [`turn`].
const CAB: i32 = 0b11_01_00_10;
const BCA: i32 = 0b11_00_10_01;

/// The corners of a triangle on one axis.
#[inline(always)]
unsafe fn corners(packet: &Packet, lane: usize, axis: usize) -> __m256d {
    let positions = &packet.positions[axis];
    let [a, b, c] = &packet.corners;
    let at = |places: &[u8; LANES]| positions[usize::from(places[lane]) % CORNERS];
    // SAFETY: the caller has AVX.
    unsafe { _mm256_setr_pd(at(a), at(b), at(c), 0.0) }
}

#[inline(always)]
unsafe fn turn<const ORDER: i32>(values: __m256d) -> __m256d {
    // SAFETY: the caller has AVX2.
    unsafe { _mm256_permute4x64_pd::<ORDER>(values) }
}

#[inline(always)]
unsafe fn first_three(values: __m256d) -> [f64; 3] {
    // SAFETY: the caller has AVX.
    unsafe {
        let low = _mm256_castpd256_pd128(values);
        let high = _mm256_extractf128_pd::<1>(values);
        [_mm_cvtsd_f64(low), _mm_cvtsd_f64(_mm_unpackhi_pd(low, low)), _mm_cvtsd_f64(high)]
    }
}

/// A cancelling edge function is for the plain test.
#[cold]
#[inline(never)]
fn cross_cancelled(packet: &Packet, lane: usize, probe: &Probe) -> Option<Crossing> {
    probe.cross_lane(packet, lane)
}

/// A triangle is left out only if f32 is sure of the signs of two edge functions.
///
/// In units of 2⁻²⁴, a sheared coordinate x − s z is off by 1 of |x|, 1 of z and 4 of s (in |s z|,
/// and |s| ≤ 1), and 1 of the result: with Z the largest |z| and a corner's width n = |x| + |y|
/// (of sheared coordinates), by at most 2 n + 6 Z. The edge function of p and q is then off by
/// 6 Z (n_p + n_q) + 4 n_p n_q, its own rounding adds 2 n_p n_q. With S the sum of the three
/// widths this is under 6 Z S + 1.5 S². The slack is 16 S (Z + S): it covers products of errors
/// too, up to 2 (2 S + 6 Z)² 2⁻²⁴, since where S is under 64 Z 2⁻²⁴ no edge function reaches it.
const EDGE_SLACK: f32 = 16.0 / (1 << 24) as f32;
/// Keeps products that underflow from being sure.
const LEAST_EDGE: f32 = 1e-36;

/// Sheared corners, from differences taken in f64.
#[inline(always)]
unsafe fn shear(packet: &Packet, probe: &Probe, ray: &WideRay) -> [__m256; 3] {
    let [kx, ky, kz] = probe.axes;
    // SAFETY: the caller has AVX.
    unsafe {
        let x = relative(&packet.positions[kx], probe.origin[kx]);
        let y = relative(&packet.positions[ky], probe.origin[ky]);
        let z = relative(&packet.positions[kz], probe.origin[kz]);
        let [sx, sy, sz] = ray.shear;
        [_mm256_fnmadd_ps(sx, z, x), _mm256_fnmadd_ps(sy, z, y), _mm256_mul_ps(sz, z)]
    }
}

/// Eight coordinates as seen from the origin.
#[inline(always)]
unsafe fn relative(positions: &[f64; 8], origin: f64) -> __m256 {
    // SAFETY: the caller has AVX; four f64 from 0 and from 4 are inside of an array of eight.
    unsafe {
        let origin = _mm256_set1_pd(origin);
        let low = _mm256_sub_pd(_mm256_loadu_pd(positions.as_ptr()), origin);
        let high = _mm256_sub_pd(_mm256_loadu_pd(positions.as_ptr().add(4)), origin);
        _mm256_set_m128(_mm256_cvtpd_ps(high), _mm256_cvtpd_ps(low))
    }
}

#[inline(always)]
unsafe fn widen(places: &[u8; 8]) -> __m256i {
    // SAFETY: reads eight bytes; the caller has AVX2.
    unsafe { _mm256_cvtepu8_epi32(_mm_loadl_epi64(places.as_ptr().cast())) }
}

/// The values at the places of the first, second and third corners.
#[inline(always)]
unsafe fn gather(values: __m256, places: &[__m256i; 3]) -> (__m256, __m256, __m256) {
    // SAFETY: the caller has AVX2.
    unsafe {
        (
            _mm256_permutevar8x32_ps(values, places[0]),
            _mm256_permutevar8x32_ps(values, places[1]),
            _mm256_permutevar8x32_ps(values, places[2]),
        )
    }
}

/// Edge functions of p and q.
#[inline(always)]
unsafe fn edge(px: __m256, py: __m256, qx: __m256, qy: __m256) -> __m256 {
    // SAFETY: the caller has AVX2 and FMA.
    unsafe { _mm256_fmsub_ps(px, qy, _mm256_mul_ps(py, qx)) }
}

/// Where the ray meets the eight planes that lie so many bytes into the node.
#[inline(always)]
unsafe fn plane(node: &WideNode, place: usize, ray: &WideRay, axis: usize) -> __m256 {
    // SAFETY: one of the six planes of a node, see `WideRay::entry`; the caller has AVX2 and FMA.
    unsafe {
        let planes = node.planes.as_ptr().cast::<u8>().add(place).cast::<f32>();
        _mm256_fmsub_ps(_mm256_loadu_ps(planes), ray.inverse[axis], ray.origin_inverse[axis])
    }
}

/// Three f64 and a 0.
#[inline(always)]
unsafe fn triple(values: &[f64; 3]) -> __m256d {
    // SAFETY: two and one of three values; the caller has AVX.
    unsafe { _mm256_set_m128d(_mm_load_sd(values.as_ptr().add(2)), _mm_loadu_pd(values.as_ptr())) }
}

/// One of four lanes in eight.
#[inline(always)]
unsafe fn spread<const LANE: i32>(values: __m128) -> __m256 {
    // SAFETY: the caller has AVX2.
    unsafe { _mm256_broadcastss_ps(_mm_shuffle_ps::<LANE>(values, values)) }
}

/// [`Bvh::closest_with`] compiled for AVX2 and FMA.
#[target_feature(enable = "avx2,fma,bmi1,lzcnt,popcnt")]
pub(super) fn closest(
    bvh: &Bvh,
    ray: &Ray,
    leaving: Option<TriangleId>,
    reach_mm: f64,
) -> Option<FirstHit> {
    bvh.closest_with::<Avx2>(ray, leaving, reach_mm)
}

/// [`Bvh::occluded_with`] compiled for AVX2 and FMA.
#[target_feature(enable = "avx2,fma,bmi1,lzcnt,popcnt")]
pub(super) fn occluded(bvh: &Bvh, segment: &Segment, blocks: &[bool]) -> bool {
    bvh.occluded_with::<Avx2>(segment, blocks)
}

/// [`Bvh::hits_with`] compiled for AVX2 and FMA.
#[target_feature(enable = "avx2,fma,bmi1,lzcnt,popcnt")]
pub(super) fn hits(
    bvh: &Bvh,
    ray: &Ray,
    leaving: Option<TriangleId>,
    end_mm: f64,
    shaft: Option<&Shaft>,
) -> Vec<Hit> {
    bvh.hits_with::<Avx2>(ray, leaving, end_mm, shaft)
}

/// [`Bvh::gather`] compiled for AVX2.
#[target_feature(enable = "avx2,fma,bmi1,lzcnt,popcnt")]
pub(super) fn gather_shaft(
    bvh: &Bvh,
    planes: (&Slabs, &Sides),
    leaving: TriangleId,
    role: impl Fn(usize) -> Role,
    shaft: Shaft,
) -> Option<Shaft> {
    bvh.gather(planes, leaving, role, shaft)
}
