//! The two f32 tests that decide where a ray has to be looked at closely: eight boxes, eight
//! triangles. Both may say yes too often and never no to what the f64 test accepts, so that hits do
//! not depend on the kernel.

use super::probe::Probe;
use super::walk::TreeRay;
use super::wide::{CORNERS, LANES, Lanes, Packet, WideNode};

/// The corners of a packet as a probe sees them: coordinate, then place.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Sheared(pub [[f64; CORNERS]; 3]);

impl Sheared {
    pub const NONE: Sheared = Sheared([[0.0; CORNERS]; 3]);

    #[inline(always)]
    pub fn corner(&self, place: u8) -> [f64; 3] {
        let place = usize::from(place);
        [self.0[0][place], self.0[1][place], self.0[2][place]]
    }
}

pub(super) trait Kernel {
    /// Which boxes the ray enters before `end`, and where (≥ 0).
    fn enter(node: &WideNode, ray: &TreeRay, end: f32) -> (u32, Lanes);

    /// Keeps the compiler from turning the branch in which it stands into a choice of values.
    #[inline(always)]
    fn branch() {}

    /// Asks the memory for what will be read soon.
    #[inline(always)]
    fn prefetch<T>(_place: &T) {}

    /// Shears the corners, with the same bits in every kernel, and says which triangles the probe
    /// may meet up to `end_mm`.
    fn may_meet(packet: &Packet, probe: &Probe, end_mm: f64, sheared: &mut Sheared) -> u32;
}

/// Plain arrays, which compilers turn into whatever vectors the target has.
pub(super) struct Portable;

impl Kernel for Portable {
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
    fn may_meet(packet: &Packet, probe: &Probe, end_mm: f64, sheared: &mut Sheared) -> u32 {
        let [kx, ky, kz] = probe.axes;
        let (xs, ys, zs) = (&packet.positions[kx], &packet.positions[ky], &packet.positions[kz]);
        let (ox, oy, oz) = (probe.origin[kx], probe.origin[ky], probe.origin[kz]);
        let [sx, sy, sz] = probe.shear;
        let [px, py, pz] = &mut sheared.0;
        for i in 0..CORNERS {
            let depth = zs[i] - oz;
            px[i] = xs[i] - ox - sx * depth;
            py[i] = ys[i] - oy - sy * depth;
            pz[i] = sz * depth;
        }
        // A distance is a mean of those of the corners, but for its rounding.
        let end_mm = end_mm * (1.0 + 64.0 * f64::EPSILON);
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
            *is_met = !((least < 0.0) & (most > 0.0)) & (far > 0.0) & (near <= end_mm);
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
