//! The two f32 tests that decide where a ray has to be looked at closely: eight boxes, eight
//! triangles. Both may say yes too often and never no to what the f64 test accepts, so that hits do
//! not depend on the kernel.

use super::walk::TreeRay;
use super::wide::{LANES, Lanes, Packet, WideNode};

/// Tolerance of the weights of a triangle in units of its longest edge.
///
/// In units of 2⁻²⁴, with origins up to 1.5 and corners up to 1: a corner relative to the origin is
/// off by 5, its cross product with the direction by 25 a component, the product of that with an
/// edge by 60.
pub(super) const WEIGHT_SLACK: f32 = 64.0 / (1 << 24) as f32;
/// The same for the sum of two weights against the determinant (twice 60, and 15 edges ≤ 2 for the
/// determinant), and in units of the edge's square for the distance: its numerator is off by 51, the
/// determinant times a distance up to 4 by 80.
pub(super) const SUM_SLACK: f32 = 256.0 / (1 << 24) as f32;

pub(super) trait Kernel {
    /// Which boxes the ray enters before `end`, and where (≥ 0).
    fn enter(node: &WideNode, ray: &TreeRay, end: f32) -> (u32, Lanes);

    /// Which triangles the ray may meet before `end`.
    fn may_meet(packet: &Packet, ray: &TreeRay, end: f32) -> u32;
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
    fn may_meet(packet: &Packet, ray: &TreeRay, end: f32) -> u32 {
        let [dx, dy, dz] = ray.direction;
        let [e1, e2] = &packet.edges;
        let slack = packet.edge_length * WEIGHT_SLACK;
        let sum_slack = packet.edge_length * SUM_SLACK;
        let t_slack = packet.edge_length * sum_slack;
        let mut is_met = [false; LANES];
        for lane in 0..LANES {
            let x = packet.corner[0][lane] - ray.origin[0];
            let y = packet.corner[1][lane] - ray.origin[1];
            let z = packet.corner[2][lane] - ray.origin[2];
            let (e1x, e1y, e1z) = (e1[0][lane], e1[1][lane], e1[2][lane]);
            let (e2x, e2y, e2z) = (e2[0][lane], e2[1][lane], e2[2][lane]);
            let nx = e1y * e2z - e1z * e2y;
            let ny = e1z * e2x - e1x * e2z;
            let nz = e1x * e2y - e1y * e2x;
            let (tx, ty, tz) = (y * dz - z * dy, z * dx - x * dz, x * dy - y * dx);
            let det = nx * dx + ny * dy + nz * dz;
            let sign = 1.0f32.copysign(det);
            let u = sign * (tx * e2x + ty * e2y + tz * e2z);
            let v = -sign * (tx * e1x + ty * e1y + tz * e1z);
            let t = sign * (nx * x + ny * y + nz * z);
            let det = det.abs();
            is_met[lane] = (u >= -slack)
                & (v >= -slack)
                & (u + v <= det + sum_slack)
                & (t >= -t_slack)
                & (t <= end * det + t_slack);
        }
        to_bits(&is_met)
    }
}

/// Lane i in bit i. A product gathers the lowest bits of the bytes in its highest byte.
#[inline(always)]
fn to_bits(lanes: &[bool; LANES]) -> u32 {
    let bytes = u64::from_le_bytes(lanes.map(u8::from));
    (bytes.wrapping_mul(0x0102_0408_1020_4080) >> 56) as u32
}
