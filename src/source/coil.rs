//! The shape of a coiled wire: points on its surface, and what it hides of itself.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use crate::error::{Error, Result};
use crate::geometry::Mesh;

/// A round wire wound to a helix about +Z, its middle at the origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coil {
    /// Radius of the wire's cross-section, mm.
    pub wire_radius_mm: f64,
    /// How often the wire goes around, 0.01 to 1e6.
    pub turns: f64,
    /// From a turn to the next, mm.
    pub pitch_mm: f64,
    /// From the coil's axis to the middle of the wire, mm.
    pub coil_radius_mm: f64,
}

/// A place on the wire's surface; the wire's two cut ends are not part of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WirePoint {
    /// mm.
    pub position: DVec3,
    /// Unit, outward.
    pub normal: DVec3,
}

impl Coil {
    /// Errors: [`Error::OutOfRange`] and [`Error::Inconsistent`], as of `object`.
    ///
    /// Lengths from 1e-9 to 1e9 mm keep every intermediate square inside f32, in which samples
    /// are stored.
    pub fn check(&self, object: &str) -> Result<()> {
        let lengths = [
            ("wire radius", self.wire_radius_mm),
            ("pitch", self.pitch_mm),
            ("coil radius", self.coil_radius_mm),
            ("length (turns · pitch)", self.length_mm()),
        ];
        for (what, length_mm) in lengths {
            if !(1e-9..=1e9).contains(&length_mm) {
                return Err(Error::out_of_range(object, what, length_mm, "1e-9 to 1e9 mm"));
            }
        }
        if !(0.01..=1e6).contains(&self.turns) {
            return Err(Error::out_of_range(object, "turns", self.turns, "0.01 to 1e6"));
        }
        let wire_mm = 2.0 * self.wire_radius_mm;
        if self.coil_radius_mm <= self.wire_radius_mm {
            let problem = format!(
                "coil radius {} mm leaves no hole in a coil of {wire_mm} mm wire, allowed: above \
                 the wire radius",
                self.coil_radius_mm
            );
            return Err(Error::inconsistent(object, problem));
        }
        if self.turns > 1.0 && self.pitch_mm < wire_mm {
            let problem = format!(
                "turns overlap, pitch is {} mm, allowed: from {wire_mm} mm, the wire's diameter",
                self.pitch_mm
            );
            return Err(Error::inconsistent(object, problem));
        }
        Ok(())
    }

    /// Along the axis, between the middles of the wire's ends.
    pub fn length_mm(&self) -> f64 {
        self.turns * self.pitch_mm
    }

    /// Length of the wire, unwound.
    pub fn wire_length_mm(&self) -> f64 {
        TAU * self.turns * self.coil_radius_mm.hypot(self.rise_mm())
    }

    /// Area of the wire without its ends, mm². A bent tube has the area of the straight one.
    pub fn surface_mm2(&self) -> f64 {
        TAU * self.wire_radius_mm * self.wire_length_mm()
    }

    /// The wire as triangles, without its ends; its polygons around have the circle's length.
    ///
    /// Errors: more than 2³² positions.
    pub(super) fn mesh(&self) -> Result<Mesh> {
        const AROUND: usize = 16;
        const PER_TURN: f64 = 32.0;
        let along = (self.turns * PER_TURN).ceil().max(1.0) as usize;
        let half = std::f64::consts::PI / AROUND as f64;
        let grown = self.wire_radius_mm * (half / half.sin() - 1.0);
        let place = |i: usize, j: usize| {
            let at = self.surface_point(j as f64 / along as f64, i as f64 / AROUND as f64);
            at.position + at.normal * grown
        };
        let grid = (0..=along).flat_map(|j| (0..=AROUND).map(move |i| (i, j)));
        let points: Vec<Option<DVec3>> = grid.map(|(i, j)| Some(place(AROUND - i, j))).collect();
        Ok(Mesh::from_grid("filament", AROUND, along, &points)?.into_flat())
    }

    /// Along the axis for a radian of turning.
    fn rise_mm(&self) -> f64 {
        self.pitch_mm / TAU
    }

    /// Middle of the wire after `turning` radians from its lower end.
    fn middle(&self, turning: f64) -> DVec3 {
        let (sin, cos) = turning.sin_cos();
        let z = self.rise_mm() * turning - 0.5 * self.length_mm();
        DVec3::new(self.coil_radius_mm * cos, self.coil_radius_mm * sin, z)
    }

    /// Evenly by area as (u, v) runs over the unit square: u along the wire, v around it.
    pub fn surface_point(&self, u: f64, v: f64) -> WirePoint {
        let (radius, rise) = (self.coil_radius_mm, self.rise_mm());
        let turning = TAU * self.turns * u;
        let (sin, cos) = turning.sin_cos();
        let inward = DVec3::new(-cos, -sin, 0.0);
        let tangent = DVec3::new(-radius * sin, radius * cos, rise) / radius.hypot(rise);
        let curvature = radius / (radius * radius + rise * rise);
        let (s, c) = angle_around_bent_wire(v, curvature * self.wire_radius_mm).sin_cos();
        let normal = inward * c + tangent.cross(inward) * s;
        WirePoint { position: self.middle(turning) + normal * self.wire_radius_mm, normal }
    }

    /// Whether a ray that leaves the wire's surface meets the wire again.
    ///
    /// Steps by the distance to the wire, which no step can overshoot, from 0.1 wire radii on: a
    /// ray less than 0.6° above the surface may count as free though the wire bends into its way
    /// (0.01 % of Lambert's emission; for coils of five wire radii and more).
    pub fn blocks(&self, from: WirePoint, direction: DVec3) -> bool {
        let wire = self.wire_radius_mm;
        let Some(walls) = Walls::along(self, from.position, direction) else { return false };
        let mut t = 0.1 * wire;
        // A ray that runs along the wire's surface for this many steps is as good as blocked.
        for _ in 0..256 {
            if walls.hole.0 < t && t < walls.hole.1 {
                t = walls.hole.1;
            }
            if t >= walls.exit {
                return false;
            }
            let gap = self.distance_to_middle(from.position + direction * t) - wire;
            if gap < 1e-4 * wire {
                return true;
            }
            t += gap;
        }
        true
    }

    /// From a point near the coil's wall to the middle line of the wire, mm.
    fn distance_to_middle(&self, p: DVec3) -> f64 {
        let near = NearPoint {
            radius_mm: p.truncate().length(),
            azimuth: p.y.atan2(p.x),
            z_mm: p.z + 0.5 * self.length_mm(),
        };
        let turn = (near.z_mm / self.rise_mm() - near.azimuth) / TAU;
        let below = turn.floor();
        // The nearer one first: it mostly makes the other needless.
        let (first, second) =
            if turn - below < 0.5 { (below, below + 1.0) } else { (below + 1.0, below) };
        let nearest = self.squared_distance_on_turn(&near, first);
        if nearest < self.least_squared_distance(&near, second) {
            return nearest.sqrt();
        }
        nearest.min(self.squared_distance_on_turn(&near, second)).sqrt()
    }

    /// No more than [`Coil::squared_distance_on_turn`], without its search, mm²; 0 at the wire's ends.
    ///
    /// Its Newton steps end within δ = ±4 of the turn's nearest azimuth, where |sin δ/2| is at least
    /// 0.4546 |δ/2|. So it is at least the minimum over δ of 0.2066 r R δ² + (h − rise δ)².
    fn least_squared_distance(&self, p: &NearPoint, turn: f64) -> f64 {
        let beside = p.azimuth + TAU * turn;
        if !(4.0..TAU * self.turns - 4.0).contains(&beside) {
            return 0.0;
        }
        let rise2 = self.rise_mm().powi(2);
        let across = 0.2066 * p.radius_mm * self.coil_radius_mm;
        let height = p.z_mm - self.rise_mm() * beside;
        let least = height * height * (across / (across + rise2));
        ((p.radius_mm - self.coil_radius_mm).powi(2) + least) * (1.0 - 1e-6)
    }

    /// To the point of the helix that Newton's method finds from beside the point on one turn, mm².
    fn squared_distance_on_turn(&self, p: &NearPoint, turn: f64) -> f64 {
        let (radius, rise) = (self.coil_radius_mm, self.rise_mm());
        let across = p.radius_mm * radius;
        let beside = p.azimuth + TAU * turn;
        let mut delta = 0.0f64;
        for _ in 0..4 {
            let (sin, cos) = delta.sin_cos();
            // first and second derivative of half the squared distance
            let slope = across * sin - rise * (p.z_mm - rise * (beside + delta));
            let bend = (across * cos + rise * rise).max(0.1 * (across + rise * rise));
            let step = slope / bend;
            delta -= step.clamp(-1.0, 1.0);
            // Newton squares the error, and the distance squares it once more.
            if step.abs() < 1e-4 {
                break;
            }
        }
        let turning = (beside + delta).clamp(0.0, TAU * self.turns);
        // The chord's half angle, free of the cancellation of 1 − cos.
        let half_sin = (0.5 * (turning - beside)).sin();
        (p.radius_mm - radius).powi(2)
            + 4.0 * across * half_sin * half_sin
            + (p.z_mm - rise * turning).powi(2)
    }
}

/// A point in cylinder coordinates, z from the wire's lower end.
struct NearPoint {
    radius_mm: f64,
    azimuth: f64,
    z_mm: f64,
}

/// Solves ψ − e sin ψ = 2π v for ψ (Kepler's equation): so grows the area of a bent tube with the
/// angle ψ from its inner side, where the surface is shorter; e < 1 is curvature × radius.
fn angle_around_bent_wire(v: f64, e: f64) -> f64 {
    let mean = TAU * v;
    let (mut low, mut high) = (mean - e, mean + e);
    let mut angle = mean + e * mean.sin();
    for _ in 0..60 {
        let residual = angle - e * angle.sin() - mean;
        if residual.abs() < 1e-14 * TAU {
            break;
        }
        if residual > 0.0 {
            high = angle
        } else {
            low = angle
        }
        let newton = angle - residual / (1.0 - e * angle.cos()).max(1e-12);
        angle = if (low..=high).contains(&newton) { newton } else { 0.5 * (low + high) };
    }
    angle
}

/// Where a ray is between the two cylinders and two planes that enclose the wire.
struct Walls {
    /// Distances between which the ray is in the empty middle; an empty interval if never.
    hole: (f64, f64),
    /// Distance from which on it is outside.
    exit: f64,
}

impl Walls {
    /// `None` if the ray, which starts on the wire, is outside from the start.
    fn along(coil: &Coil, origin: DVec3, direction: DVec3) -> Option<Self> {
        let (wire, radius) = (coil.wire_radius_mm, coil.coil_radius_mm);
        let half = 0.5 * coil.length_mm() + wire;
        let to_plane = if direction.z == 0.0 {
            f64::INFINITY
        } else {
            (half.copysign(direction.z) - origin.z) / direction.z
        };
        let (p, d) = (origin.truncate(), direction.truncate());
        let (_, to_cylinder) = crossings(p, d, radius + wire).unwrap_or_default();
        let exit = to_plane.min(to_cylinder);
        let hole = crossings(p, d, radius - wire).unwrap_or((0.0, 0.0));
        (exit > 0.0).then_some(Self { hole, exit })
    }
}

/// Distances at which p + t d crosses the circle of `radius`; unbounded along the axis.
fn crossings(p: DVec2, d: DVec2, radius: f64) -> Option<(f64, f64)> {
    let (a, b, c) = (d.length_squared(), p.dot(d), p.length_squared() - radius * radius);
    if a < 1e-30 {
        return (c < 0.0).then_some((f64::NEG_INFINITY, f64::INFINITY));
    }
    let discriminant = b * b - a * c;
    if discriminant <= 0.0 {
        return None;
    }
    // The form without cancellation between b and the root.
    let q = -(b + discriminant.sqrt().copysign(b));
    let (t0, t1) = (q / a, c / q);
    Some((t0.min(t1), t0.max(t1)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::lambert;
    use crate::source::sequence::EvenSequence;

    const COIL: Coil =
        Coil { wire_radius_mm: 0.06, turns: 12.0, pitch_mm: 0.17, coil_radius_mm: 0.4 };

    /// Distance from a ray to the middle line by brute force, 2000 chords a turn; the wire within
    /// two radii of the start's place `u`, where it is as good as straight, is left out.
    fn blocked_by_brute_force(coil: &Coil, u: f64, p: DVec3, d: DVec3) -> Option<bool> {
        let steps = (coil.turns * 2000.0) as usize;
        let own = 2.0 * coil.wire_radius_mm / coil.wire_length_mm();
        let mut nearest = f64::INFINITY;
        for share in (0..=steps).map(|i| i as f64 / steps as f64) {
            let m = coil.middle(TAU * coil.turns * share) - p;
            let along = m.dot(d);
            if along > 0.0 && (share - u).abs() > own {
                nearest = nearest.min((m - d * along).length());
            }
        }
        // too close to call
        let gap = nearest / coil.wire_radius_mm;
        (!(0.995..1.005).contains(&gap)).then_some(gap < 1.0)
    }

    #[test]
    fn blocking_agrees_with_brute_force() {
        let sequence = EvenSequence::new(3);
        let (mut asked, mut wrong) = (0, 0);
        for index in 0..3000 {
            let [u, v, a, b] = sequence.point(index);
            let from = COIL.surface_point(u, v);
            let direction = lambert::direction(from.normal, a, b);
            let Some(truth) = blocked_by_brute_force(&COIL, u, from.position, direction) else {
                continue;
            };
            asked += 1;
            wrong += usize::from(COIL.blocks(from, direction) != truth);
        }
        // Rays so flat that they differ in whether the first 0.1 wire radii count.
        assert!(asked > 2800 && wrong * 500 < asked, "{wrong} of {asked}");
    }

    #[test]
    fn surface_points_lie_on_the_wire_and_face_outward() {
        for index in 0..1000 {
            let [u, v, ..] = EvenSequence::new(0).point(index);
            let point = COIL.surface_point(u, v);
            assert!((point.normal.length() - 1.0).abs() < 1e-14);
            let middle = COIL.middle(TAU * COIL.turns * u);
            let outward = (point.position - middle) / COIL.wire_radius_mm;
            assert!(outward.distance(point.normal) < 1e-12);
        }
    }

    /// The centroid of a torus' surface cut at ψ is known: the mean of cos ψ by area is −e/2.
    #[test]
    fn points_are_even_by_area() {
        for e in [1e-6, 0.15, 0.999_999] {
            let n = 100_000;
            let mean = (0..n)
                .map(|i| angle_around_bent_wire((i as f64 + 0.5) / n as f64, e).cos())
                .sum::<f64>()
                / n as f64;
            assert!((mean + 0.5 * e).abs() < 1e-6, "{e}: {mean}");
        }
    }

    #[test]
    fn far_turns_block_only_what_runs_into_them() {
        let from = COIL.surface_point(0.5, 0.5);
        // v = 0.5 is the outermost line: nothing stands in the way outward.
        assert!(!COIL.blocks(from, from.normal));
        let inner = COIL.surface_point(0.5, 0.0);
        assert!(inner.position.truncate().length() < COIL.coil_radius_mm);
        // Straight along the axis, through the hole, out of the end.
        let middle = WirePoint { position: DVec3::ZERO, normal: DVec3::Z };
        assert!(!COIL.blocks(middle, DVec3::Z));
    }

    #[test]
    fn sizes_outside_of_the_range_are_refused() {
        let problem = |coil: Coil| coil.check("filament").unwrap_err().to_string();
        assert_eq!(
            problem(Coil { pitch_mm: 0.1, ..COIL }),
            "filament: turns overlap, pitch is 0.1 mm, allowed: from 0.12 mm, the wire's diameter"
        );
        assert_eq!(
            problem(Coil { wire_radius_mm: f64::NAN, ..COIL }),
            "filament: wire radius is NaN, allowed: 1e-9 to 1e9 mm"
        );
        assert_eq!(
            problem(Coil { coil_radius_mm: 0.05, ..COIL }),
            "filament: coil radius 0.05 mm leaves no hole in a coil of 0.12 mm wire, allowed: \
             above the wire radius"
        );
        assert!(COIL.check("filament").is_ok());
        assert!((COIL.surface_mm2() - TAU * 0.06 * COIL.wire_length_mm()).abs() < 1e-12);
        assert!(COIL.wire_length_mm() > 12.0 * TAU * 0.4);
    }
}
