//! The two f32 tests that decide where a ray has to be looked at closely: eight boxes, eight
//! triangles. Both may say yes too often and never no to what the f64 test accepts, so that hits do
//! not depend on the kernel.

use super::super::DVec3;
use super::bounds::Frame;
use super::probe::{Crossing, Probe};
use super::walk::TreeRay;
use super::wide::{CORNERS, LANES, Lanes, Packet, WideNode};

/// A distance as [`TriangleKernel::may_meet`] compares it. It covers the rounding of this value (2), of f32
/// distances (4) and of a mean of the corners' distances, in units of 2⁻²⁴.
#[inline(always)]
pub(super) fn to_end_mm(t_mm: f64) -> f32 {
    t_mm as f32 * (1.0 + 8.0 / (1 << 24) as f32)
}

/// What a packet is tested against: triangles that `probe` meets up to `end_mm`, but not `leaving`.
pub(super) struct Aim<'a> {
    pub probe: &'a Probe,
    pub leaving: u32,
    pub end_mm: f32,
}

pub(super) trait TriangleKernel {
    /// A ray made ready for both tests.
    type Ray;

    fn aim(probe: &Probe, direction: &DVec3, frame: &Frame) -> Self::Ray;

    /// Which boxes the ray enters before `end`, and where (≥ 0).
    fn enter(node: &WideNode, ray: &Self::Ray, end: f32) -> (u32, Lanes);

    /// Keeps the compiler from turning the branch in which it stands into a choice of values, and
    /// from merging it with one of another tag.
    #[inline(always)]
    fn branch<const TAG: usize>() {}

    /// Asks the memory for the node or packet that starts there.
    #[inline(always)]
    fn prefetch(_start: *const u8) {}

    /// Which triangles the ray may meet.
    fn may_meet(packet: &Packet, ray: &Self::Ray, aim: &Aim) -> u32;

    /// Where the probe meets the triangle in a lane: the same bits in every kernel.
    #[inline(always)]
    fn cross(packet: &Packet, lane: usize, probe: &Probe) -> Option<Crossing> {
        probe.cross_lane(packet, lane)
    }
}

/// Plain arrays, which compilers turn into whatever vectors the target has.
pub(super) struct Portable;

impl TriangleKernel for Portable {
    type Ray = TreeRay;

    #[inline(always)]
    fn aim(probe: &Probe, direction: &DVec3, frame: &Frame) -> TreeRay {
        TreeRay::new(probe, direction, frame)
    }

    #[inline(always)]
    fn enter(node: &WideNode, ray: &TreeRay, end: f32) -> (u32, Lanes) {
        let mut near = [0.0f32; LANES];
        let mut far = [end; LANES];
        for axis in 0..3 {
            let near_plane = &node.planes[2 * axis + ray.sign(axis)];
            let far_plane = &node.planes[2 * axis + 1 - ray.sign(axis)];
            for lane in 0..LANES {
                let a = near_plane[lane] * ray.inverse[axis] - ray.origin_inverse[axis];
                let b = far_plane[lane] * ray.inverse[axis] - ray.origin_inverse[axis];
                near[lane] = if a > near[lane] { a } else { near[lane] };
                far[lane] = if b < far[lane] { b } else { far[lane] };
            }
        }
        let mut is_entered = [false; LANES];
        for lane in 0..LANES {
            is_entered[lane] = near[lane] <= far[lane];
        }
        (to_bits(&is_entered), near)
    }

    #[inline(always)]
    fn may_meet(packet: &Packet, _ray: &TreeRay, aim: &Aim) -> u32 {
        let probe = aim.probe;
        let [kx, ky, kz] = probe.axes;
        let (xs, ys, zs) = (&packet.positions[kx], &packet.positions[ky], &packet.positions[kz]);
        let (ox, oy, oz) = (probe.origin[kx], probe.origin[ky], probe.origin[kz]);
        let [sx, sy, sz] = probe.shear;
        let [mut px, mut py, mut pz] = [[0.0; CORNERS]; 3];
        for i in 0..CORNERS {
            let depth = zs[i] - oz;
            px[i] = xs[i] - ox - sx * depth;
            py[i] = ys[i] - oy - sy * depth;
            pz[i] = sz * depth;
        }
        let end_mm = f64::from(aim.end_mm);
        let mut is_met = [false; LANES];
        for (lane, is_met) in is_met.iter_mut().enumerate() {
            let a = usize::from(packet.corners[0][lane]) % CORNERS;
            let b = usize::from(packet.corners[1][lane]) % CORNERS;
            let c = usize::from(packet.corners[2][lane]) % CORNERS;
            let wa = px[c] * py[b] - py[c] * px[b];
            let wb = px[a] * py[c] - py[a] * px[c];
            let wc = px[b] * py[a] - py[b] * px[a];
            let least = wa.min(wb).min(wc);
            let most = wa.max(wb).max(wc);
            let near = pz[a].min(pz[b]).min(pz[c]);
            let far = pz[a].max(pz[b]).max(pz[c]);
            let is_other = packet.triangles[lane] != aim.leaving;
            *is_met = !((least < 0.0) & (most > 0.0)) & (far > 0.0) & (near <= end_mm) & is_other;
        }
        to_bits(&is_met) & u32::from(packet.present)
    }
}

/// Lane i in bit i. A product gathers the lowest bits of the bytes in its highest byte.
#[inline(always)]
fn to_bits(lanes: &[bool; LANES]) -> u32 {
    let bytes = u64::from_le_bytes(lanes.map(u8::from));
    (bytes.wrapping_mul(0x0102_0408_1020_4080) >> 56) as u32
}
