//! The surface that measured rays come from, found from the rays alone.

use std::f64::consts::PI;

use super::shape::Shape;
use crate::error::{Error, Result};
use crate::geometry::DVec3;
use crate::light::RaySample;
use crate::source::Starts;
use crate::source::starts::focus;
use crate::source::surface_fit::{FittedSurface, best_direction};

/// Rays that a fit looks at.
const MOST_RAYS: usize = 20_000;

/// Rays that a search for an axis looks at.
const FEW_RAYS: usize = 2000;

/// The shape of least area that the rays can come from: the surface on which they start, if that is
/// the source's, or else the tightest cylinder, sphere, disc or rectangle that their lines meet.
///
/// Errors: rays from one point, or parallel ones that start on no surface.
pub fn fitted_shape(rays: &[RaySample]) -> Result<Shape> {
    let stride = rays.len().div_ceil(MOST_RAYS).max(1);
    let few: Vec<RaySample> = rays.iter().copied().step_by(stride).collect();
    let starts = Starts::of(&few);
    let own = starts.surface.filter(|_| starts.inner_source.is_none()).map(|fit| fit.surface);
    let found = match own {
        Some(FittedSurface::Sphere { center, radius_mm }) => {
            Some(Shape::Sphere { center, radius_mm })
        }
        Some(FittedSurface::Cylinder { through, axis, radius_mm, length_mm }) => {
            Some(Shape::Cylinder { center: through, axis, radius_mm, length_mm })
        }
        Some(FittedSurface::Plane { through, normal, .. }) => {
            let sign = normal.dot(starts.mean_direction).signum();
            Some(flat_shape(&few, through, normal * sign))
        }
        Some(FittedSurface::Point { .. }) => None,
        None => tightest(&few, starts.mean_direction),
    };
    let usable = found.filter(|shape| shape.area_mm2() > 0.0 && shape.area_mm2().is_finite());
    usable.ok_or_else(|| {
        let problem = "the rays come from one point, or from no surface that can be told: \
                       give one, such as { cylinder = { center, axis, radius, length } }";
        Error::inconsistent("rayset: emitter", problem)
    })
}

fn tightest(rays: &[RaySample], mean_direction: DVec3) -> Option<Shape> {
    let middle = focus(rays)?;
    let cylinder = cylinder_about(rays, middle)?;
    let distances = rays.iter().map(|ray| {
        let from = ray.origin() - middle;
        from.reject_from_normalized(ray.unit_direction()).length()
    });
    let sphere = Shape::Sphere { center: middle, radius_mm: reach(distances.collect()) };
    // A sphere and the cylinder around it have the same area.
    let round = if sphere.area_mm2() < 1.05 * cylinder.area_mm2() { sphere } else { cylinder };
    // Light that goes to one side may come from a chip.
    let flat = (mean_direction.length() > 0.3).then(|| {
        let normal = near_axis(mean_direction.normalize());
        flat_shape(rays, middle, normal)
    });
    Some(flat.filter(|flat| flat.area_mm2() < round.area_mm2()).unwrap_or(round))
}

/// A coordinate axis, if it is within 2°: chips are mounted square.
fn near_axis(direction: DVec3) -> DVec3 {
    let axes = DVec3::AXES.into_iter().flat_map(|axis| [axis, -axis]);
    axes.into_iter().find(|axis| axis.dot(direction) > 0.9994).unwrap_or(direction)
}

/// The thinnest cylinder through which the rays' lines go, as long as the starts on it.
fn cylinder_about(rays: &[RaySample], middle: DVec3) -> Option<Shape> {
    let few: Vec<RaySample> =
        rays.iter().copied().step_by(rays.len().div_ceil(FEW_RAYS).max(1)).collect();
    let axis = best_direction(|axis| line_reach(&few, *axis, middle))?;
    let through = centered(rays, axis, middle);
    let radius_mm = line_reach(rays, axis, through);
    let endless = Shape::Cylinder { center: through, axis, radius_mm, length_mm: 1.0 };
    let along = rays
        .iter()
        .map(|ray| (endless.exit_of(ray.origin(), ray.unit_direction()) - through).dot(axis));
    let [low, high] = span(along.collect(), STRAY);
    let center = through + 0.5 * (low + high) * axis;
    Some(Shape::Cylinder { center, axis, radius_mm, length_mm: high - low })
}

/// How far from an axis the lines pass at most.
fn line_reach(rays: &[RaySample], axis: DVec3, through: DVec3) -> f64 {
    let distances = rays.iter().map(|ray| {
        let across = axis.cross(ray.unit_direction());
        match across.try_normalize() {
            Some(across) => (ray.origin() - through).dot(across).abs(),
            None => (ray.origin() - through).reject_from_normalized(axis).length(),
        }
    });
    reach(distances.collect())
}

/// The axis moved to where it is nearest to all lines: steps across it, halved when none helps.
fn centered(rays: &[RaySample], axis: DVec3, start: DVec3) -> DVec3 {
    let (a, b) = axis.any_orthonormal_pair();
    let (mut best, mut through) = (line_reach(rays, axis, start), start);
    let mut step = 0.1 * best;
    while step > 1e-4 * best {
        let around = [a, -a, b, -b].map(|way| through + step * way);
        let tried = around.map(|place| (line_reach(rays, axis, place), place));
        match tried.into_iter().min_by(|x, y| x.0.total_cmp(&y.0)) {
            Some((reach, place)) if reach < best => (best, through) = (reach, place),
            _ => step *= 0.5,
        }
    }
    through
}

/// The disc or rectangle in a plane that the rays' lines meet.
fn flat_shape(rays: &[RaySample], through: DVec3, normal: DVec3) -> Shape {
    let plane = Shape::Disc { center: through, normal, radius_mm: 1.0 };
    let points: Vec<DVec3> =
        rays.iter().map(|ray| plane.exit_of(ray.origin(), ray.unit_direction())).collect();
    let (a, b) = normal.any_orthonormal_pair();
    const TURNS: u32 = 90;
    let rectangles = (0..TURNS).map(|turn| {
        let (sin, cos) = (0.5 * PI * f64::from(turn) / f64::from(TURNS)).sin_cos();
        let across = a * cos + b * sin;
        let up = normal.cross(across);
        // A plane that is off by a little shifts grazing rays by much: no stray counts.
        let along =
            |way: DVec3| span(points.iter().map(|p| (*p - through).dot(way)).collect(), 0.0);
        let ([x0, x1], [y0, y1]) = (along(across), along(up));
        let center = through + across * (0.5 * (x0 + x1)) + up * (0.5 * (y0 + y1));
        Shape::Rectangle { center, normal, across, width_mm: x1 - x0, height_mm: y1 - y0 }
    });
    let area = |shape: &Shape| shape.area_mm2();
    let rectangle = rectangles.min_by(|x, y| area(x).total_cmp(&area(y)));
    let center = points.iter().sum::<DVec3>() / points.len() as f64;
    let distances = points.iter().flat_map(|p| [p.distance(center), -p.distance(center)]);
    let [_, radius_mm] = span(distances.collect(), 0.0);
    let disc = Shape::Disc { center, normal, radius_mm };
    match rectangle {
        Some(rectangle) if area(&rectangle) < area(&disc) => rectangle,
        _ => disc,
    }
}

/// Values that reach this share of all others' span beyond them are strays, not the surface's rim.
const STRAY: f64 = 0.05;

/// The largest of some distances, but for strays.
fn reach(distances: Vec<f64>) -> f64 {
    let negated: Vec<f64> = distances.iter().map(|value| -value).collect();
    let [_, high] = span([distances, negated].concat(), STRAY);
    high
}

/// Lowest and highest value; the last thousandth at either end counts only if it reaches less than
/// `stray` of the others' span beyond them.
fn span(mut values: Vec<f64>, stray: f64) -> [f64; 2] {
    if values.is_empty() {
        return [0.0; 2];
    }
    values.sort_by(f64::total_cmp);
    let last = values.len() - 1;
    let (low, high) = (values[last / 1000], values[last - last / 1000]);
    let slack = stray * (high - low);
    let [lowest, highest] = [values[0], values[last]];
    let is_rim = |beyond: f64| beyond < slack;
    [
        if is_rim(low - lowest) { lowest } else { low },
        if is_rim(highest - high) { highest } else { high },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::lambert;
    use crate::source::sequence::random;

    /// Lambert rays from a shape, started on a sphere of 15 mm around.
    fn rays(shape: Shape, count: u64) -> Vec<RaySample> {
        let ray = |i: u64| {
            let at = |k: u64| random(5, i, k);
            let place = shape.place(at(0), at(1));
            let direction = lambert::direction(place.normal, at(2), at(3));
            let auxiliary = Shape::Sphere { center: DVec3::ZERO, radius_mm: 15.0 };
            super::super::sample(auxiliary.exit_of(shape.point(&place), direction), direction)
        };
        (0..count).map(ray).collect()
    }

    #[test]
    fn shapes_are_found_behind_an_auxiliary_sphere() {
        let shapes = [
            Shape::Cylinder {
                center: DVec3::new(0.5, -0.3, 0.2),
                axis: DVec3::new(0.0, 0.6, 0.8),
                radius_mm: 0.65,
                length_mm: 4.1,
            },
            Shape::Sphere { center: DVec3::new(0.5, -0.3, 0.2), radius_mm: 2.0 },
            Shape::Disc { center: DVec3::new(0.1, 0.2, 0.3), normal: DVec3::Z, radius_mm: 1.5 },
            Shape::Rectangle {
                center: DVec3::new(0.1, 0.2, 0.3),
                normal: DVec3::Z,
                across: DVec3::X,
                width_mm: 2.0,
                height_mm: 1.0,
            },
        ];
        for shape in shapes {
            let found = fitted_shape(&rays(shape, 20_000)).unwrap();
            assert_eq!(std::mem::discriminant(&found), std::mem::discriminant(&shape), "{found:?}");
            let area = found.area_mm2() / shape.area_mm2();
            // Centers from 20,000 lines are off by some thousandths of the size.
            assert!((area - 1.0).abs() < 0.03, "{found:?} for {shape:?}");
        }
    }

    #[test]
    fn one_point_is_no_surface() {
        let rays: Vec<RaySample> = (0..1000)
            .map(|i| {
                let direction = lambert::direction(DVec3::Z, random(2, i, 0), random(2, i, 1));
                super::super::sample(DVec3::ONE, direction)
            })
            .collect();
        assert!(fitted_shape(&rays).is_err());
    }
}
