//! The kernel for x86-64 with AVX2 and FMA.

use std::arch::x86_64::*;

use super::super::{Hit, Ray, TriangleId};
use super::Bvh;
use super::kernel::{Kernel, SUM_SLACK, WEIGHT_SLACK};
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
    fn may_meet(packet: &Packet, ray: &TreeRay, end: f32) -> u32 {
        // SAFETY: as above.
        unsafe {
            let direction = set(&ray.direction);
            let origin = set(&ray.origin);
            let (e1, e2) = (load3(&packet.edges[0]), load3(&packet.edges[1]));
            let corner = load3(&packet.corner);
            let offset = [
                _mm256_sub_ps(corner[0], origin[0]),
                _mm256_sub_ps(corner[1], origin[1]),
                _mm256_sub_ps(corner[2], origin[2]),
            ];
            let normal = cross(e1, e2);
            let turned = cross(offset, direction);
            let det = dot(normal, direction);
            let minus = _mm256_set1_ps(-0.0);
            let sign = _mm256_and_ps(det, minus);
            let det = _mm256_xor_ps(det, sign);
            let u = _mm256_xor_ps(dot(turned, e2), sign);
            let v = _mm256_xor_ps(dot(turned, e1), _mm256_xor_ps(sign, minus));
            let t = _mm256_xor_ps(dot(normal, offset), sign);
            let edge = packet.edge_length;
            let least = _mm256_set1_ps(-edge * WEIGHT_SLACK);
            let t_slack = edge * edge * SUM_SLACK;
            let sum = _mm256_sub_ps(_mm256_add_ps(u, v), det);
            let beyond = _mm256_fnmadd_ps(_mm256_set1_ps(end), det, t);
            let inside = _mm256_and_ps(
                _mm256_and_ps(
                    _mm256_cmp_ps::<_CMP_GE_OQ>(_mm256_min_ps(u, v), least),
                    _mm256_cmp_ps::<_CMP_LE_OQ>(sum, _mm256_set1_ps(edge * SUM_SLACK)),
                ),
                _mm256_and_ps(
                    _mm256_cmp_ps::<_CMP_GE_OQ>(t, _mm256_set1_ps(-t_slack)),
                    _mm256_cmp_ps::<_CMP_LE_OQ>(beyond, _mm256_set1_ps(t_slack)),
                ),
            );
            _mm256_movemask_ps(inside) as u32
        }
    }
}

#[inline(always)]
unsafe fn load(lanes: &Lanes) -> __m256 {
    // SAFETY: a reference to eight f32; the caller has AVX.
    unsafe { _mm256_loadu_ps(lanes.as_ptr()) }
}

#[inline(always)]
unsafe fn load3(rows: &[Lanes; 3]) -> [__m256; 3] {
    // SAFETY: the caller has AVX.
    unsafe { [load(&rows[0]), load(&rows[1]), load(&rows[2])] }
}

#[inline(always)]
unsafe fn set(v: &[f32; 3]) -> [__m256; 3] {
    // SAFETY: the caller has AVX.
    unsafe { [_mm256_set1_ps(v[0]), _mm256_set1_ps(v[1]), _mm256_set1_ps(v[2])] }
}

#[inline(always)]
unsafe fn cross(a: [__m256; 3], b: [__m256; 3]) -> [__m256; 3] {
    // SAFETY: the caller has AVX2 and FMA.
    unsafe {
        [
            _mm256_fmsub_ps(a[1], b[2], _mm256_mul_ps(a[2], b[1])),
            _mm256_fmsub_ps(a[2], b[0], _mm256_mul_ps(a[0], b[2])),
            _mm256_fmsub_ps(a[0], b[1], _mm256_mul_ps(a[1], b[0])),
        ]
    }
}

#[inline(always)]
unsafe fn dot(a: [__m256; 3], b: [__m256; 3]) -> __m256 {
    // SAFETY: the caller has AVX2 and FMA.
    unsafe { _mm256_fmadd_ps(a[0], b[0], _mm256_fmadd_ps(a[1], b[1], _mm256_mul_ps(a[2], b[2]))) }
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
