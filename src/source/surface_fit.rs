//! The surface on which start points lie, by least squares.
//!
//! Ray files start their rays on a point, a sphere or a cylinder around the lamp, or on a plane: if
//! one is found that is not the emitter, [`super::StartSurface`] brings the rays back.

use crate::fit::solve_linear;
use crate::geometry::DVec3;

/// A surface through start points. Lengths in mm, directions unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FittedSurface {
    /// All starts in one place.
    Point {
        /// Their mean.
        at: DVec3,
    },
    /// A sphere, or part of one.
    Sphere {
        /// Its middle.
        center: DVec3,
        /// Distance of the starts from it.
        radius_mm: f64,
    },
    /// A cylinder's side.
    Cylinder {
        /// On the axis, in the middle of the starts.
        through: DVec3,
        /// Direction of the axis.
        axis: DVec3,
        /// Distance of the starts from the axis.
        radius_mm: f64,
        /// Extent of the starts along the axis.
        length_mm: f64,
    },
    /// A part of a plane.
    Plane {
        /// Mean of the starts.
        through: DVec3,
        /// Across the plane.
        normal: DVec3,
        /// Largest distance of a start from `through`.
        radius_mm: f64,
    },
}

/// A fitted surface and how well it explains the points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceFit {
    /// What was found.
    pub surface: FittedSurface,
    /// Root mean square distance of the points that it explains, mm.
    pub rms_mm: f64,
    /// Share of the points that it explains, 0 to 1.
    pub share: f64,
}

impl std::fmt::Display for FittedSurface {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // Adding 0 turns −0 into 0.
        let rounded = |x: f64| (x * 1e4).round() / 1e4 + 0.0;
        let triple =
            |v: DVec3| format!("({:.4}, {:.4}, {:.4})", rounded(v.x), rounded(v.y), rounded(v.z));
        match self {
            Self::Point { at } => write!(f, "point {}", triple(*at)),
            Self::Sphere { center, radius_mm } => {
                write!(f, "sphere about {}, radius {radius_mm:.4} mm", triple(*center))
            }
            Self::Cylinder { through, axis, radius_mm, length_mm } => write!(
                f,
                "cylinder along {} about {}, radius {radius_mm:.4} mm, length {length_mm:.4} mm",
                triple(*axis),
                triple(*through)
            ),
            Self::Plane { through, normal, radius_mm } => write!(
                f,
                "plane with normal {}, within {radius_mm:.4} mm of {}",
                triple(*normal),
                triple(*through)
            ),
        }
    }
}

impl FittedSurface {
    fn distance_mm(&self, p: DVec3) -> f64 {
        match *self {
            Self::Point { at } => p.distance(at),
            Self::Sphere { center, radius_mm } => (p.distance(center) - radius_mm).abs(),
            Self::Cylinder { through, axis, radius_mm, .. } => {
                ((p - through).reject_from_normalized(axis).length() - radius_mm).abs()
            }
            Self::Plane { through, normal, .. } => (p - through).dot(normal).abs(),
        }
    }
}

/// A surface counts as found if its rms distance is below this share of the points' extent: f32
/// start points and the digits of text files keep below 1e-5, coils and chips are far above.
const FOUND: f64 = 1e-3;

/// Start points on a sphere cover less than a large one would need to be told from a plane.
const LARGEST_RADIUS: f64 = 10.0;

/// Start points of text files are rounded to seven digits; no rounding makes a stray.
const ROUNDING: f64 = 1e-6;

/// Points farther than this many median distances are left out of the second fit.
const OUTLIER: f64 = 6.0;

type FitKind = fn(&[DVec3]) -> Option<FittedSurface>;

/// The simplest surface that the points lie on: a point, a plane, a sphere or a cylinder, up to a
/// few stray points. `None` for fewer than 10 points or a shape that is none of these.
pub fn fit_surface(points: &[DVec3]) -> Option<SurfaceFit> {
    if points.len() < 10 {
        return None;
    }
    let extent = extent_mm(points);
    let fits: [FitKind; 4] = [fit_point, fit_plane, fit_sphere, fit_cylinder];
    fits.into_iter().find_map(|fit| robust_fit(points, fit, extent))
}

fn extent_mm(points: &[DVec3]) -> f64 {
    let low = points.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = points.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    low.distance(high)
}

/// Fits, drops what lies far out, and fits again.
fn robust_fit(points: &[DVec3], fit: FitKind, extent_mm: f64) -> Option<SurfaceFit> {
    let first = fit(points)?;
    let mut distances: Vec<f64> = points.iter().map(|&p| first.distance_mm(p)).collect();
    distances.sort_by(f64::total_cmp);
    let reach = OUTLIER * distances[distances.len() / 2] + ROUNDING * extent_mm;
    let near = |p: &DVec3| first.distance_mm(*p) <= reach;
    let kept: Vec<DVec3> = points.iter().copied().filter(near).collect();
    let surface = fit(&kept)?;
    let squares: f64 = kept.iter().map(|&p| surface.distance_mm(p).powi(2)).sum();
    let rms_mm = (squares / kept.len() as f64).sqrt();
    let is_found = match surface {
        // A point has no extent to measure by but that of its distance from the origin.
        FittedSurface::Point { at } => rms_mm <= 1e-6 * at.length().max(1.0),
        FittedSurface::Sphere { radius_mm, .. } | FittedSurface::Cylinder { radius_mm, .. } => {
            rms_mm <= FOUND * extent_mm && radius_mm < LARGEST_RADIUS * extent_mm
        }
        FittedSurface::Plane { .. } => rms_mm <= FOUND * extent_mm,
    };
    let share = kept.len() as f64 / points.len() as f64;
    is_found.then_some(SurfaceFit { surface, rms_mm, share })
}

fn mean(points: &[DVec3]) -> DVec3 {
    points.iter().sum::<DVec3>() / points.len() as f64
}

fn fit_point(points: &[DVec3]) -> Option<FittedSurface> {
    Some(FittedSurface::Point { at: mean(points) })
}

/// Through the mean, normal to the direction in which the points vary least.
fn fit_plane(points: &[DVec3]) -> Option<FittedSurface> {
    let through = mean(points);
    let spread = |normal: &DVec3| points.iter().map(|&p| (p - through).dot(*normal).powi(2)).sum();
    let normal = best_direction(spread)?;
    let radius_mm = points.iter().map(|&p| p.distance(through)).fold(0.0, f64::max);
    Some(FittedSurface::Plane { through, normal, radius_mm })
}

/// |p|² = 2 c·p + (r² − |c|²) is linear in the center and the last term.
fn fit_sphere(points: &[DVec3]) -> Option<FittedSurface> {
    let origin = mean(points);
    let scale = extent_mm(points);
    let rows = points.iter().map(|&p| {
        let p = (p - origin) / scale;
        ([2.0 * p.x, 2.0 * p.y, 2.0 * p.z, 1.0], p.length_squared())
    });
    let [x, y, z, rest] = solve_linear(rows)?;
    let center = DVec3::new(x, y, z);
    let radius = (rest + center.length_squared()).sqrt();
    let (center, radius_mm) = (origin + scale * center, scale * radius);
    (center.is_finite() && radius.is_finite())
        .then_some(FittedSurface::Sphere { center, radius_mm })
}

/// The axis whose circle, across it, fits best.
fn fit_cylinder(points: &[DVec3]) -> Option<FittedSurface> {
    // The search runs a circle fit per direction, for which some thousand points are enough.
    let stride = points.len().div_ceil(2000);
    let few: Vec<DVec3> = points.iter().copied().step_by(stride).collect();
    let axis = best_direction(|axis| circle_residual(&few, *axis))?;
    let (through, radius_mm) = circle_across(points, axis)?;
    let along = |p: &DVec3| (*p - through).dot(axis);
    let low = points.iter().map(along).fold(f64::INFINITY, f64::min);
    let high = points.iter().map(along).fold(f64::NEG_INFINITY, f64::max);
    let (through, length_mm) = (through + 0.5 * (low + high) * axis, high - low);
    Some(FittedSurface::Cylinder { through, axis, radius_mm, length_mm })
}

fn circle_residual(points: &[DVec3], axis: DVec3) -> f64 {
    let Some((through, radius_mm)) = circle_across(points, axis) else { return f64::INFINITY };
    let cylinder = FittedSurface::Cylinder { through, axis, radius_mm, length_mm: 0.0 };
    points.iter().map(|&p| cylinder.distance_mm(p).powi(2)).sum()
}

/// Center (on the plane through the mean) and radius of the circle that the points make, seen along
/// `axis`.
fn circle_across(points: &[DVec3], axis: DVec3) -> Option<(DVec3, f64)> {
    let origin = mean(points);
    let scale = extent_mm(points);
    let (e1, e2) = axis.any_orthonormal_pair();
    let rows = points.iter().map(|&p| {
        let p = (p - origin) / scale;
        let (x, y) = (p.dot(e1), p.dot(e2));
        ([2.0 * x, 2.0 * y, 1.0], x * x + y * y)
    });
    let [x, y, rest] = solve_linear(rows)?;
    let radius = (rest + x * x + y * y).sqrt();
    let center = origin + scale * (x * e1 + y * e2);
    (center.is_finite() && radius.is_finite()).then_some((center, scale * radius))
}

/// The unit vector, up to its sign, for which `cost` is least: the best of a grid over the half
/// sphere, then smaller and smaller steps around it. The sign makes the largest component positive.
pub(super) fn best_direction(cost: impl Fn(&DVec3) -> f64) -> Option<DVec3> {
    const GRID: u32 = 300;
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    let spiral = (0..GRID).map(|i| {
        let z = (f64::from(i) + 0.5) / f64::from(GRID);
        let (s, c) = (golden * f64::from(i)).sin_cos();
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * c, r * s, z)
    });
    let candidates = DVec3::AXES.into_iter().chain(spiral).map(|d| (cost(&d), d));
    let (mut least, mut best) = candidates.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let mut step = 0.1;
    while step > 1e-10 {
        let (e1, e2) = best.any_orthonormal_pair();
        let around = [e1, -e1, e2, -e2].map(|e| (best + step * e).normalize());
        let next = around.into_iter().map(|d| (cost(&d), d)).min_by(|a, b| a.0.total_cmp(&b.0))?;
        if next.0 < least {
            (least, best) = next;
        } else {
            step *= 0.5;
        }
    }
    let largest = best[best.abs().max_position()];
    least.is_finite().then_some(if largest < 0.0 { -best } else { best })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::sequence::random;

    const N: u64 = 3000;

    fn cube(i: u64) -> [f64; 3] {
        [0, 1, 2].map(|dimension| random(1, i, dimension))
    }

    fn on_sphere(i: u64) -> DVec3 {
        let [u, v, _] = cube(i);
        let (z, phi) = (2.0 * u - 1.0, std::f64::consts::TAU * v);
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * phi.cos(), r * phi.sin(), z)
    }

    fn in_f32(p: DVec3) -> DVec3 {
        p.as_vec3().as_dvec3()
    }

    fn fit(point: impl Fn(u64) -> DVec3) -> Option<SurfaceFit> {
        fit_surface(&(0..N).map(|i| in_f32(point(i))).collect::<Vec<_>>())
    }

    #[test]
    fn a_sphere_of_any_size_with_strays() {
        let center = DVec3::new(1.0, -2.0, 10.0);
        for scale in [1e-3, 1.0, 1e6] {
            let found = fit(|i| match i {
                17 | 900 => scale * DVec3::ONE,
                _ => scale * (center + 10.0 * on_sphere(i)),
            });
            let SurfaceFit {
                surface: FittedSurface::Sphere { center: c, radius_mm }, share, ..
            } = found.unwrap()
            else {
                panic!("{found:?}")
            };
            // f32 start points.
            assert!(
                (c / scale - center).length() < 1e-5 && (radius_mm / scale - 10.0).abs() < 1e-5
            );
            assert!(share < 1.0 && share > 0.99);
        }
    }

    #[test]
    fn half_a_sphere_is_a_sphere() {
        let found = fit(|i| on_sphere(i) * DVec3::new(1.0, 1.0, on_sphere(i).z.signum()));
        assert!(matches!(found.unwrap().surface, FittedSurface::Sphere { .. }));
    }

    #[test]
    fn a_tilted_cylinder() {
        let axis = DVec3::new(1.0, 2.0, -2.0) / 3.0;
        let (e1, e2) = axis.any_orthonormal_pair();
        let found = fit(|i| {
            let [u, v, _] = cube(i);
            let phi = std::f64::consts::TAU * u;
            DVec3::new(4.0, 5.0, 6.0) + 0.65 * (phi.cos() * e1 + phi.sin() * e2) + 4.1 * v * axis
        });
        let Some(SurfaceFit {
            surface: FittedSurface::Cylinder { through, axis: a, radius_mm, length_mm },
            ..
        }) = found
        else {
            panic!("{found:?}")
        };
        assert!(a.cross(axis).length() < 1e-6 && (radius_mm - 0.65).abs() < 1e-6);
        // 3000 random points leave a gap of some thousandths at the ends.
        assert!((through - DVec3::new(4.0, 5.0, 6.0) - 2.05 * axis).length() < 5e-3);
        assert!((length_mm - 4.1).abs() < 1e-2);
    }

    #[test]
    fn a_point_and_a_plane() {
        let point = fit(|_| DVec3::new(0.1, 0.2, 0.3)).unwrap();
        assert!(matches!(point.surface, FittedSurface::Point { .. }));
        let normal = DVec3::new(0.0, 0.6, 0.8);
        let (e1, e2) = normal.any_orthonormal_pair();
        let plane = fit(|i| cube(i)[0] * e1 + cube(i)[1] * e2 + normal).unwrap();
        let FittedSurface::Plane { normal: n, through, .. } = plane.surface else {
            panic!("{plane:?}")
        };
        assert!(n.cross(normal).length() < 1e-6 && (through.dot(n) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn a_cloud_and_a_line_are_no_surface() {
        assert_eq!(fit(|i| DVec3::from(cube(i))), None);
        assert_eq!(fit_surface(&[DVec3::ZERO; 9]), None);
        // A line lies on many surfaces; whichever is named must hold it.
        let line = fit(|i| cube(i)[0] * DVec3::Z);
        assert!(line.is_none_or(|fit| fit.rms_mm < 1e-6));
    }
}
