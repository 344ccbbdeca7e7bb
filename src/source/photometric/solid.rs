//! Intensity by direction, on a grid of two angles.

use glam::DVec3;

/// Which two angles give a direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AngleType {
    /// Turned about a vertical axis, then lifted: how lamps of vehicles are measured.
    A,
    /// Lifted about a horizontal axis, then turned: floodlights.
    B,
    /// Half planes about the lamp's axis, and the angle to it: luminaires.
    C,
}

impl std::fmt::Display for AngleType {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::A => "A",
            Self::B => "B",
            Self::C => "C",
        })
    }
}

/// How planes beyond those of the file follow from them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Symmetry {
    /// They do not: every plane is there, or the intensity beyond is 0.
    None,
    /// All planes are the one.
    Rotation,
    /// Planes at opposite angles are alike: those of 0° to 180° (or 0° to 90° of type A) are there.
    Mirrored,
    /// Type C: planes mirrored at 90° are alike, those of −90° to 90° are there.
    MirroredAtSide,
    /// Type C: both mirrors; planes of 0° to 90° are there.
    Quadrants,
}

/// Luminous intensity by direction, linear between the angles of its grid.
#[derive(Debug, Clone, PartialEq)]
pub struct Solid {
    angles: AngleType,
    symmetry: Symmetry,
    /// Angles of the planes (type C) or turns (A, B), degrees, ascending; no less than one.
    planes_deg: Vec<f64>,
    /// Within a plane, degrees, ascending; no less than two.
    tilts_deg: Vec<f64>,
    /// cd, plane by plane.
    values_cd: Vec<f64>,
    flux_lm: f64,
}

/// Parts that one cell's sides are cut into for integrating.
const PARTS: usize = 4;

impl Solid {
    /// Errors: angles that do not ascend or leave their range, a value that is negative or not
    /// finite.
    pub(super) fn new(
        angles: AngleType,
        symmetry: Symmetry,
        planes_deg: Vec<f64>,
        tilts_deg: Vec<f64>,
        values_cd: Vec<f64>,
    ) -> Result<Self, String> {
        let (planes, tilts) = match angles {
            AngleType::A => ((-180.0, 180.0), (-90.0, 90.0)),
            AngleType::B => ((-180.0, 180.0), (-90.0, 90.0)),
            AngleType::C => ((-90.0, 360.0), (0.0, 180.0)),
        };
        check_angles("horizontal", &planes_deg, planes, 1)?;
        check_angles("vertical", &tilts_deg, tilts, 2)?;
        if let Some(bad) = values_cd.iter().find(|v| !(v.is_finite() && **v >= 0.0)) {
            return Err(format!("an intensity is {bad}, allowed: finite and not negative"));
        }
        let mut solid = Self { angles, symmetry, planes_deg, tilts_deg, values_cd, flux_lm: 0.0 };
        solid.flux_lm = solid.sampler().total();
        Ok(solid)
    }

    /// Which angles the grid has.
    pub fn angle_type(&self) -> AngleType {
        self.angles
    }

    /// Numbers of planes and of angles in each.
    pub fn size(&self) -> [usize; 2] {
        [self.planes_deg.len(), self.tilts_deg.len()]
    }

    /// Luminous flux, lm: the integral over all directions.
    pub fn flux_lm(&self) -> f64 {
        self.flux_lm
    }

    /// Largest intensity, cd.
    pub fn peak_cd(&self) -> f64 {
        self.values_cd.iter().copied().fold(0.0, f64::max)
    }

    /// Intensity toward a unit vector, cd.
    pub fn intensity_cd(&self, direction: DVec3) -> f64 {
        let [plane, tilt] = angles_of(self.angles, direction);
        let Some((i, s)) = self.place_of_plane(plane) else { return 0.0 };
        let Some((j, t)) = place(&self.tilts_deg, tilt) else { return 0.0 };
        let at = |i: usize, j: usize| self.value(i.min(self.planes_deg.len() - 1), j);
        let low = at(i, j) * (1.0 - s) + at(i + 1, j) * s;
        let high = at(i, j + 1) * (1.0 - s) + at(i + 1, j + 1) * s;
        low * (1.0 - t) + high * t
    }

    fn value(&self, plane: usize, tilt: usize) -> f64 {
        self.values_cd[plane * self.tilts_deg.len() + tilt.min(self.tilts_deg.len() - 1)]
    }

    /// Between which planes of the file an angle lies, by the symmetry.
    fn place_of_plane(&self, plane_deg: f64) -> Option<(usize, f64)> {
        let folded = match (self.symmetry, self.angles) {
            (Symmetry::Rotation, _) => return Some((0, 0.0)),
            (Symmetry::Mirrored, AngleType::A | AngleType::B) => plane_deg.abs(),
            (Symmetry::None, AngleType::A | AngleType::B) => plane_deg,
            (Symmetry::None, AngleType::C) => plane_deg.rem_euclid(360.0),
            (Symmetry::Mirrored, AngleType::C) => half_turn(plane_deg),
            (Symmetry::MirroredAtSide, _) => 90.0 - half_turn(plane_deg - 90.0),
            (Symmetry::Quadrants, _) => {
                let half = half_turn(plane_deg);
                half.min(180.0 - half)
            }
        };
        place(&self.planes_deg, folded)
    }

    /// For drawing directions.
    pub(super) fn sampler(&self) -> DirectionSampler<'_> {
        DirectionSampler::new(self)
    }

    /// Planes and tilts at the edges of the cells over all directions, degrees.
    fn edges(&self) -> [Vec<f64>; 2] {
        let all: Vec<f64> = match (self.angles, self.symmetry) {
            (_, Symmetry::Rotation) => vec![0.0, 360.0],
            (AngleType::A | AngleType::B, Symmetry::None) => self.planes_deg.clone(),
            (AngleType::A | AngleType::B, _) => {
                self.planes_deg.iter().flat_map(|p| [-p, *p]).collect()
            }
            (AngleType::C, _) => {
                let folded = self.planes_deg.iter();
                folded
                    .flat_map(|&p| [p, -p, 180.0 - p, 180.0 + p])
                    .map(|p| p.rem_euclid(360.0))
                    .chain([0.0, 360.0])
                    .collect()
            }
        };
        let mut planes = all;
        planes.sort_by(f64::total_cmp);
        planes.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
        [planes, self.tilts_deg.clone()]
    }
}

/// 0° to 180°: an angle or its opposite.
fn half_turn(deg: f64) -> f64 {
    let turned = deg.rem_euclid(360.0);
    turned.min(360.0 - turned)
}

fn check_angles(
    what: &str,
    deg: &[f64],
    (low, high): (f64, f64),
    least: usize,
) -> Result<(), String> {
    if deg.len() < least {
        return Err(format!("has {} {what} angles, needs {least} or more", deg.len()));
    }
    if let Some(pair) = deg.windows(2).find(|pair| pair[0] >= pair[1]) {
        return Err(format!("{what} angle {} follows {}, must ascend", pair[1], pair[0]));
    }
    // NaN is out of range too.
    match deg.iter().find(|a| !(low..=high).contains(*a)) {
        Some(bad) => Err(format!("a {what} angle is {bad}, allowed: {low} to {high} degrees")),
        None => Ok(()),
    }
}

/// The angle below, and how far to the next one, 0 to 1; `None` outside.
fn place(angles: &[f64], angle: f64) -> Option<(usize, f64)> {
    // Angles that were turned into a direction and back.
    const ROUNDING_DEG: f64 = 1e-9;
    let (first, last) = (*angles.first()?, *angles.last()?);
    if !(first - ROUNDING_DEG..=last + ROUNDING_DEG).contains(&angle) {
        return None;
    }
    let below = angles.partition_point(|&a| a <= angle).saturating_sub(1);
    match angles.get(below + 1) {
        Some(next) => {
            Some((below, ((angle - angles[below]) / (next - angles[below])).clamp(0.0, 1.0)))
        }
        None => Some((below, 0.0)),
    }
}

/// Plane and tilt of a unit vector, degrees.
///
/// Horizontal angles of types A and B turn clockwise, of type C counter-clockwise (LM-63-2002). So who
/// looks out of the lamp has positive angles of type A to the right (−X) and up, and C planes turn from
/// the right (C = 0°) over up (+Y, 90°), as CIE's do. Of type B, whose planes share the axis ±X,
/// horizontal angles are down and vertical ones to the right: as Radiance's `ies2rad` has both, turned
/// about Y.
pub(super) fn angles_of(angles: AngleType, DVec3 { x, y, z }: DVec3) -> [f64; 2] {
    let asin = |v: f64| v.clamp(-1.0, 1.0).asin().to_degrees();
    match angles {
        AngleType::A => [(-x).atan2(z).to_degrees(), asin(y)],
        AngleType::B => [(-y).atan2(z).to_degrees(), asin(-x)],
        AngleType::C => [y.atan2(-x).to_degrees(), z.clamp(-1.0, 1.0).acos().to_degrees()],
    }
}

/// The unit vector of plane and tilt.
pub(super) fn direction(angles: AngleType, plane_deg: f64, tilt_deg: f64) -> DVec3 {
    let (sin_p, cos_p) = plane_deg.to_radians().sin_cos();
    let (sin_t, cos_t) = tilt_deg.to_radians().sin_cos();
    match angles {
        AngleType::A => DVec3::new(-sin_p * cos_t, sin_t, cos_p * cos_t),
        AngleType::B => DVec3::new(-sin_t, -sin_p * cos_t, cos_p * cos_t),
        AngleType::C => DVec3::new(-sin_t * cos_p, sin_t * sin_p, cos_t),
    }
}

/// Draws directions in proportion to intensity.
pub(super) struct DirectionSampler<'a> {
    solid: &'a Solid,
    planes_deg: Vec<f64>,
    /// Heights of the tilts, in which solid angle is even.
    heights: Vec<f64>,
    /// Σ of the cells' flux, cell by cell, lm.
    sums: Vec<f64>,
}

impl<'a> DirectionSampler<'a> {
    fn new(solid: &'a Solid) -> Self {
        let [planes_deg, tilts_deg] = solid.edges();
        let cut = |edges: &[f64]| -> Vec<f64> {
            let parts = edges.windows(2).flat_map(|pair| {
                (0..PARTS).map(|k| pair[0] + (pair[1] - pair[0]) * k as f64 / PARTS as f64)
            });
            parts.chain(edges.last().copied()).collect()
        };
        let planes_deg = cut(&planes_deg);
        let heights = cut(&tilts_deg).iter().map(|&tilt| height(solid.angles, tilt)).collect();
        let mut sampler = Self { solid, planes_deg, heights, sums: Vec::new() };
        let (mut sums, mut sum) = (Vec::new(), 0.0);
        for plane in 0..sampler.planes_deg.len().saturating_sub(1) {
            for tilt in 0..sampler.heights.len() - 1 {
                let middle = sampler.intensity(plane, tilt, [0.5, 0.5]);
                sum += middle * sampler.solid_angle_sr(plane, tilt);
                sums.push(sum);
            }
        }
        sampler.sums = sums;
        sampler
    }

    /// lm
    fn total(&self) -> f64 {
        self.sums.last().copied().unwrap_or(0.0)
    }

    fn solid_angle_sr(&self, plane: usize, tilt: usize) -> f64 {
        let turn = (self.planes_deg[plane + 1] - self.planes_deg[plane]).to_radians();
        turn * (self.heights[tilt + 1] - self.heights[tilt]).abs()
    }

    /// The direction at a place in a cell, each 0 to 1.
    fn direction(&self, plane: usize, tilt: usize, [u, v]: [f64; 2]) -> DVec3 {
        let between =
            |edges: &[f64], at: usize, t: f64| edges[at] + t * (edges[at + 1] - edges[at]);
        let plane_deg = between(&self.planes_deg, plane, u);
        let height = between(&self.heights, tilt, v);
        direction(self.solid.angles, plane_deg, tilt_deg(self.solid.angles, height))
    }

    fn intensity(&self, plane: usize, tilt: usize, at: [f64; 2]) -> f64 {
        self.solid.intensity_cd(self.direction(plane, tilt, at))
    }

    /// A direction, and the flux of its ray relative to the others': 1 but for what the intensity
    /// changes within a cell.
    pub(super) fn sample(&self, [u, v, w]: [f64; 3]) -> (DVec3, f64) {
        let wanted = u * self.total();
        let cell = self.sums.partition_point(|&sum| sum <= wanted).min(self.sums.len() - 1);
        let tilts = self.heights.len() - 1;
        let (plane, tilt) = (cell / tilts, cell % tilts);
        let direction = self.direction(plane, tilt, [v, w]);
        let middle = self.intensity(plane, tilt, [0.5, 0.5]);
        (direction, self.solid.intensity_cd(direction) / middle.max(f64::MIN_POSITIVE))
    }
}

/// Solid angle is even in sin of a lift and in −cos of an angle to the axis.
fn height(angles: AngleType, tilt_deg: f64) -> f64 {
    match angles {
        AngleType::A | AngleType::B => tilt_deg.to_radians().sin(),
        AngleType::C => -tilt_deg.to_radians().cos(),
    }
}

fn tilt_deg(angles: AngleType, height: f64) -> f64 {
    let asin = height.clamp(-1.0, 1.0).asin().to_degrees();
    match angles {
        AngleType::A | AngleType::B => asin,
        AngleType::C => asin + 90.0,
    }
}
