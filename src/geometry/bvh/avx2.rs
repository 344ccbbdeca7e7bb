//! The kernel for x86-64 with AVX2 and FMA.

use std::arch::x86_64::*;

use super::super::{Hit, Ray, TriangleId};
use super::Bvh;
use super::kernel::{Kernel, Sheared};
use super::probe::Probe;
use super::query::Segment;
use super::walk::TreeRay;
use super::wide::{Lanes, Packet, WideNode};

/// May be used only in functions compiled for AVX2 and FMA, into which it is inlined.
pub(super) struct Avx2;

/// # Safety
/// The processor has AVX2 and FMA; so have the functions below.
impl Kernel for Avx2 {
    #[inline(always)]
    fn enter(node: &WideNode, ray: &TreeRay, end: f32) -> (u32, Lanes) {
        let mut near_lanes = [0.0; 8];
        // SAFETY: Bvh::walk chooses this kernel only where the processor has AVX2 and FMA.
        let lanes = unsafe {
            let mut near = _mm256_setzero_ps();
            let mut far = _mm256_set1_ps(end);
            for axis in 0..3 {
                let inverse = _mm256_set1_ps(ray.inverse[axis]);
                let origin = _mm256_set1_ps(ray.origin_inverse[axis]);
                let near_plane = load(&node.planes[2 * axis + ray.sign(axis)]);
                let far_plane = load(&node.planes[2 * axis + 1 - ray.sign(axis)]);
                near = _mm256_max_ps(_mm256_fmsub_ps(near_plane, inverse, origin), near);
                far = _mm256_min_ps(_mm256_fmsub_ps(far_plane, inverse, origin), far);
            }
            _mm256_storeu_ps(near_lanes.as_mut_ptr(), near);
            _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(near, far))
        };
        (lanes as u32, near_lanes)
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
            let (ax, bx, cx) = gather3(x, &places);
            let (ay, by, cy) = gather3(y, &places);
            let (az, bz, cz) = gather3(z, &places);
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
            !_mm256_movemask_ps(is_out) as u32 & packet.present
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

/// Sheared corners in f32: eight places, then four.
type Places = (__m256, __m256);

#[inline(always)]
unsafe fn shear(packet: &Packet, probe: &Probe, sheared: &mut Sheared) -> [Places; 3] {
    let [kx, ky, kz] = probe.axes;
    let (xs, ys, zs) = (&packet.positions[kx], &packet.positions[ky], &packet.positions[kz]);
    // SAFETY: the caller has AVX; four f64 from 0, 4 and 8 are inside of arrays of twelve.
    unsafe {
        let ox = _mm256_set1_pd(probe.origin[kx]);
        let oy = _mm256_set1_pd(probe.origin[ky]);
        let oz = _mm256_set1_pd(probe.origin[kz]);
        let sx = _mm256_set1_pd(probe.shear[0]);
        let sy = _mm256_set1_pd(probe.shear[1]);
        let sz = _mm256_set1_pd(probe.shear[2]);
        let [px, py, pz] = &mut sheared.0;
        let mut parts = [[_mm_setzero_ps(); 3]; 3];
        for part in 0..3 {
            let i = 4 * part;
            let depth = _mm256_sub_pd(_mm256_loadu_pd(zs.as_ptr().add(i)), oz);
            let x = _mm256_sub_pd(_mm256_loadu_pd(xs.as_ptr().add(i)), ox);
            let y = _mm256_sub_pd(_mm256_loadu_pd(ys.as_ptr().add(i)), oy);
            let x = _mm256_sub_pd(x, _mm256_mul_pd(sx, depth));
            let y = _mm256_sub_pd(y, _mm256_mul_pd(sy, depth));
            let z = _mm256_mul_pd(sz, depth);
            _mm256_storeu_pd(px.as_mut_ptr().add(i), x);
            _mm256_storeu_pd(py.as_mut_ptr().add(i), y);
            _mm256_storeu_pd(pz.as_mut_ptr().add(i), z);
            parts[part] = [_mm256_cvtpd_ps(x), _mm256_cvtpd_ps(y), _mm256_cvtpd_ps(z)];
        }
        let [p, q, r] = parts;
        [
            (_mm256_set_m128(q[0], p[0]), _mm256_castps128_ps256(r[0])),
            (_mm256_set_m128(q[1], p[1]), _mm256_castps128_ps256(r[1])),
            (_mm256_set_m128(q[2], p[2]), _mm256_castps128_ps256(r[2])),
        ]
    }
}

#[inline(always)]
unsafe fn widen(places: &[u8; 8]) -> __m256i {
    // SAFETY: reads eight bytes; the caller has AVX2.
    unsafe { _mm256_cvtepu8_epi32(_mm_loadl_epi64(places.as_ptr().cast())) }
}

/// The values at the places of the first, second and third corners.
#[inline(always)]
unsafe fn gather3(values: Places, places: &[__m256i; 3]) -> (__m256, __m256, __m256) {
    // SAFETY: the caller has AVX2.
    unsafe { (gather(values, places[0]), gather(values, places[1]), gather(values, places[2])) }
}

#[inline(always)]
unsafe fn gather((low, high): Places, places: __m256i) -> __m256 {
    // SAFETY: the caller has AVX2.
    unsafe {
        // The bit that says 8 or more, where the blend looks for it.
        let is_high = _mm256_castsi256_ps(_mm256_slli_epi32::<28>(places));
        let low = _mm256_permutevar8x32_ps(low, places);
        let high = _mm256_permutevar8x32_ps(high, places);
        _mm256_blendv_ps(low, high, is_high)
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
