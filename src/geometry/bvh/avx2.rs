//! The kernel for x86-64 with AVX2 and FMA.

use std::arch::asm;
use std::arch::x86_64::*;

use super::super::{Hit, Ray, TriangleId};
use super::Bvh;
use super::kernel::{Kernel, Sheared};
use super::probe::Probe;
use super::query::Segment;
use super::walk::TreeRay;
use super::wide::{Lanes, Packet, WideNode};

/// Used only in functions compiled for AVX2 and FMA, into which all of it is inlined.
pub(super) struct Avx2;

impl Kernel for Avx2 {
    #[inline(always)]
    fn enter(node: &WideNode, ray: &TreeRay, end: f32) -> (u32, Lanes) {
        let mut near_lanes = [0.0; 8];
        // SAFETY: only `closest` and `occluded` below use this kernel; `Bvh` calls them only where
        // the processor has their features.
        let lanes = unsafe {
            let entry = |axis: usize| plane(&node.planes[2 * axis + ray.sign(axis)], ray, axis);
            let exit = |axis: usize| plane(&node.planes[2 * axis + 1 - ray.sign(axis)], ray, axis);
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
    fn branch() {
        // SAFETY: does nothing.
        unsafe { asm!("", options(nomem, nostack, preserves_flags)) }
    }

    #[inline(always)]
    fn prefetch<T>(place: &T) {
        let start: *const i8 = (&raw const *place).cast();
        for line in 0..size_of::<T>().div_ceil(64) {
            // SAFETY: the address is inside of `place`.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(start.add(64 * line)) }
        }
    }

    #[inline(always)]
    fn may_meet(packet: &Packet, probe: &Probe, end_mm: f64, sheared: &mut Sheared) -> u32 {
        // SAFETY: as above.
        unsafe {
            let [x, y, z] = shear(packet, probe, sheared);
            let places =
                [widen(&packet.corners[0]), widen(&packet.corners[1]), widen(&packet.corners[2])];
            let (ax, bx, cx) = gather(x, &places);
            let (ay, by, cy) = gather(y, &places);
            let (az, bz, cz) = gather(z, &places);
            let (wa, wb, wc) = (sign(cx, cy, bx, by), sign(ax, ay, cx, cy), sign(bx, by, ax, ay));
            let is_negative = _mm256_or_ps(_mm256_or_ps(wa.0, wb.0), wc.0);
            let is_positive = _mm256_or_ps(_mm256_or_ps(wa.1, wb.1), wc.1);
            let near = _mm256_min_ps(_mm256_min_ps(az, bz), cz);
            let far = _mm256_max_ps(_mm256_max_ps(az, bz), cz);
            let end = _mm256_set1_ps(end_mm as f32 * (1.0 + Z_SLACK));
            let is_out = _mm256_or_ps(
                _mm256_or_ps(
                    _mm256_cmp_ps::<_CMP_LT_OQ>(far, _mm256_setzero_ps()),
                    _mm256_cmp_ps::<_CMP_GT_OQ>(near, end),
                ),
                _mm256_and_ps(is_negative, is_positive),
            );
            !_mm256_movemask_ps(is_out) as u32 & u32::from(packet.present)
        }
    }
}

/// A triangle is left out only if f32 is sure. In units of 2⁻²⁴ an edge function is off by 4 of the
/// sum of its two products: 2 each for rounding the coordinates, 1 each for the product, the
/// difference included.
const EDGE_SLACK: f32 = 8.0 / (1 << 24) as f32;
/// Keeps products that underflow from being sure.
const LEAST_EDGE: f32 = 1e-36;
/// Rounding a distance and the end of the ray, with a reserve.
const Z_SLACK: f32 = 8.0 / (1 << 24) as f32;

/// Sheared corners: all in f64 for the exact test, returned in f32.
///
/// No product is fused with the difference after it: the f64 values are the bits of the plain
/// kernel.
#[inline(always)]
unsafe fn shear(packet: &Packet, probe: &Probe, sheared: &mut Sheared) -> [__m256; 3] {
    let [kx, ky, kz] = probe.axes;
    let (xs, ys, zs) = (&packet.positions[kx], &packet.positions[ky], &packet.positions[kz]);
    // SAFETY: the caller has AVX; four f64 from 0 and from 4 are inside of arrays of eight.
    unsafe {
        let ox = _mm256_set1_pd(probe.origin[kx]);
        let oy = _mm256_set1_pd(probe.origin[ky]);
        let oz = _mm256_set1_pd(probe.origin[kz]);
        let sx = _mm256_set1_pd(probe.shear[0]);
        let sy = _mm256_set1_pd(probe.shear[1]);
        let sz = _mm256_set1_pd(probe.shear[2]);
        let [px, py, pz] = &mut sheared.0;
        let mut parts = [[_mm_setzero_ps(); 3]; 2];
        for (half, part) in parts.iter_mut().enumerate() {
            let i = 4 * half;
            let depth = _mm256_sub_pd(_mm256_loadu_pd(zs.as_ptr().add(i)), oz);
            let x = _mm256_sub_pd(_mm256_loadu_pd(xs.as_ptr().add(i)), ox);
            let y = _mm256_sub_pd(_mm256_loadu_pd(ys.as_ptr().add(i)), oy);
            let x = _mm256_sub_pd(x, _mm256_mul_pd(sx, depth));
            let y = _mm256_sub_pd(y, _mm256_mul_pd(sy, depth));
            let z = _mm256_mul_pd(sz, depth);
            _mm256_storeu_pd(px.as_mut_ptr().add(i), x);
            _mm256_storeu_pd(py.as_mut_ptr().add(i), y);
            _mm256_storeu_pd(pz.as_mut_ptr().add(i), z);
            *part = [_mm256_cvtpd_ps(x), _mm256_cvtpd_ps(y), _mm256_cvtpd_ps(z)];
        }
        let [p, q] = parts;
        [_mm256_set_m128(q[0], p[0]), _mm256_set_m128(q[1], p[1]), _mm256_set_m128(q[2], p[2])]
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

/// Where the edge function of p and q is surely negative, and where surely positive.
#[inline(always)]
unsafe fn sign(px: __m256, py: __m256, qx: __m256, qy: __m256) -> (__m256, __m256) {
    // SAFETY: the caller has AVX2 and FMA.
    unsafe {
        let minus = _mm256_set1_ps(-0.0);
        let (left, right) = (_mm256_mul_ps(px, qy), _mm256_mul_ps(py, qx));
        let area = _mm256_sub_ps(left, right);
        let sum = _mm256_add_ps(_mm256_andnot_ps(minus, left), _mm256_andnot_ps(minus, right));
        let slack = _mm256_fmadd_ps(sum, _mm256_set1_ps(EDGE_SLACK), _mm256_set1_ps(LEAST_EDGE));
        (
            _mm256_cmp_ps::<_CMP_LT_OQ>(area, _mm256_xor_ps(slack, minus)),
            _mm256_cmp_ps::<_CMP_GT_OQ>(area, slack),
        )
    }
}

/// Where the ray meets eight planes.
#[inline(always)]
unsafe fn plane(positions: &Lanes, ray: &TreeRay, axis: usize) -> __m256 {
    // SAFETY: the caller has AVX2 and FMA.
    unsafe {
        let inverse = _mm256_set1_ps(ray.inverse[axis]);
        _mm256_fmsub_ps(load(positions), inverse, _mm256_set1_ps(ray.origin_inverse[axis]))
    }
}

#[inline(always)]
unsafe fn load(lanes: &Lanes) -> __m256 {
    // SAFETY: a reference to eight f32; the caller has AVX.
    unsafe { _mm256_loadu_ps(lanes.as_ptr()) }
}

/// [`Bvh::closest_with`] compiled for AVX2 and FMA.
#[target_feature(enable = "avx2,fma,bmi1,lzcnt,popcnt")]
pub(super) fn closest(bvh: &Bvh, ray: &Ray, leaving: Option<TriangleId>) -> Option<Hit> {
    bvh.closest_with::<Avx2>(ray, leaving)
}

/// [`Bvh::occluded_with`] compiled for AVX2 and FMA.
#[target_feature(enable = "avx2,fma,bmi1,lzcnt,popcnt")]
pub(super) fn occluded(bvh: &Bvh, segment: &Segment, blocks: &[bool]) -> bool {
    bvh.occluded_with::<Avx2>(segment, blocks)
}
