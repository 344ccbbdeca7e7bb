//! Where secondary rays start, so that they neither meet the surface they leave nor miss the next.

use super::super::{DVec3, Hit};
use super::Bvh;

/// How far off the surface a ray starts, in units of ε (|P| + scene diameter), ε = 2⁻⁵³.
///
/// What may move the hit point P, or the plane of a neighbor as the next ray sees it, along the
/// normal: interpolating the corners √3 (|P| + 8 D), adding the offset √3 |P|, taking the
/// neighbor's corners relative to the start and shearing them 5 √3 D, its three weights 6 D; each
/// times ε. The sum stays under 31 (|P| + D) ε; the constant is twice that.
pub(super) const LIFT: f64 = 64.0;

/// How far inside of its triangle a ray starts, in lifts.
///
/// Next to a shared edge the lifted point may lie beyond the plane of a neighbor that rises from
/// that edge: with an angle φ between both it needs an inset of lift / tan(φ/2), so that 64 serves
/// wedges down to 2°.
const INSET: f64 = 64.0;

/// The starting points of the rays that leave a hit, one a side.
///
/// Unit: mm. They lie about 10⁻¹⁴ of the scene off the surface (and off its edges 64 times that),
/// the least that provably clears the rounding of the hit and of the next test.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Departure {
    /// Where the ray met the triangle, interpolated from its corners.
    pub point: DVec3,
    /// Unit, counter-clockwise winding = front.
    pub n_geom: DVec3,
    start: DVec3,
    lift_mm: f64,
}

impl Departure {
    /// The origin of a ray that leaves in `direction`: on the side of N_g to which it points.
    pub fn toward(&self, direction: DVec3) -> DVec3 {
        let side = if direction.dot(self.n_geom) < 0.0 { -1.0 } else { 1.0 };
        self.start + self.n_geom * (side * self.lift_mm)
    }
}

impl Bvh {
    /// Surfaces that are this near, mm, cannot be told apart: a ray that leaves one of them starts
    /// beyond the other. Four lifts, of which a ray's start takes one and rounding half of one.
    pub fn place_mm(&self) -> f64 {
        let Some((low, high)) = self.bounds() else { return 0.0 };
        let farthest = low.abs().max(high.abs()).max_element();
        4.0 * LIFT * (0.5 * f64::EPSILON) * (farthest + 2.0 * self.radius_mm())
    }

    /// The hit point, interpolated from the corners: off the triangle's plane by less than
    /// 2⁻⁵³ √3 (|P| + 8 edges), whatever the distance of the ray's origin.
    pub fn hit_point(&self, hit: &Hit) -> DVec3 {
        interpolate(self.corners(hit.triangle), hit.u, hit.v)
    }

    /// Starting points for rays that leave `hit`; trace them with `leaving = Some(hit.triangle)`.
    pub fn departure(&self, hit: &Hit) -> Departure {
        let corners = self.corners(hit.triangle);
        let [a, b, c] = corners;
        let point = interpolate(corners, hit.u, hit.v);
        let normal = (b - a).cross(c - a);
        let twice_area = normal.length();
        let scale_mm = point.abs().max_element() + 2.0 * self.radius_mm();
        let lift_mm = LIFT * (0.5 * f64::EPSILON) * scale_mm;
        // Weight of a corner = distance to the opposite edge / height over it.
        let inset = INSET * lift_mm / twice_area;
        let least = [(c - b), (a - c), (b - a)].map(|e| (e.length() * inset).min(0.25));
        let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
        let start = if (0..3).all(|i| weights[i] >= least[i]) {
            point
        } else {
            let inside: [f64; 3] = std::array::from_fn(|i| weights[i].max(least[i]));
            let sum: f64 = inside.iter().sum();
            interpolate(corners, inside[1] / sum, inside[2] / sum)
        };
        Departure { point, n_geom: normal / twice_area, start, lift_mm }
    }
}

fn interpolate([a, b, c]: [DVec3; 3], u: f64, v: f64) -> DVec3 {
    a + ((b - a) * u + (c - a) * v)
}
