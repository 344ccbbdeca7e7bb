//! Start points moved back to the emitter.
//!
//! Makers ship rays that start on an auxiliary sphere or cylinder around the lamp. Eq. 9 takes the
//! start point as the place of the source, so that such rays must first go back along themselves.

use std::sync::Arc;

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::geometry::DVec3;
use crate::light::RaySet;

/// Where rays are made to start, in the set's own coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StartSurface {
    core: Core,
    radius_mm: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Core {
    Axis { through: DVec3, direction: DVec3 },
    Point(DVec3),
}

/// Below this sine of the angle between ray and axis (2e-6°) the nearest point is undefined in f32
/// directions; such a ray stays where it is.
const SMALLEST_SINE: f64 = 3e-8;

impl StartSurface {
    /// Where a ray comes nearest to an axis.
    ///
    /// Errors: an axis without direction, or one that is not finite.
    pub fn axis(through: DVec3, direction: DVec3) -> Result<Self> {
        let unit = direction.try_normalize().filter(|d| d.is_finite() && through.is_finite());
        let direction = unit.ok_or_else(|| {
            Error::out_of_range("start", "axis", direction, "a finite direction other than zero")
        })?;
        Ok(Self { core: Core::Axis { through, direction }, radius_mm: 0.0 })
    }

    /// Where a ray comes nearest to a point.
    ///
    /// Errors: a point that is not finite.
    pub fn point(point: DVec3) -> Result<Self> {
        if !point.is_finite() {
            return Err(Error::out_of_range("start", "point", point, "finite mm"));
        }
        Ok(Self { core: Core::Point(point), radius_mm: 0.0 })
    }

    /// Where a ray leaves the cylinder about the axis, or the sphere about the point; a ray that
    /// passes outside starts where it comes nearest.
    ///
    /// Errors: a radius that is negative or not finite.
    pub fn with_radius(self, radius_mm: f64) -> Result<Self> {
        if !(radius_mm.is_finite() && radius_mm >= 0.0) {
            let allowed = "finite mm, 0 or more";
            return Err(Error::out_of_range("start", "radius", radius_mm, allowed));
        }
        Ok(Self { radius_mm, ..self })
    }

    /// Distance (mm) between a ray's line and the axis or point. `direction` is unit.
    pub fn distance_mm(&self, origin: DVec3, direction: DVec3) -> f64 {
        let from_core = origin - self.anchor();
        let (from_core, across) = (self.across(from_core), self.across(direction));
        let along = from_core.dot(across) / across.length_squared();
        if along.is_finite() { (from_core - along * across).length() } else { from_core.length() }
    }

    /// The ray's new start. `direction` is unit.
    pub fn start_of(&self, origin: DVec3, direction: DVec3) -> DVec3 {
        let from_core = self.across(origin - self.anchor());
        let across = self.across(direction);
        let sine = across.length();
        if sine < SMALLEST_SINE {
            return origin;
        }
        let to_nearest = -from_core.dot(across) / (sine * sine);
        let distance = (from_core + to_nearest * across).length();
        let half_chord = (self.radius_mm * self.radius_mm - distance * distance).max(0.0).sqrt();
        origin + (to_nearest + half_chord / sine) * direction
    }

    fn anchor(&self) -> DVec3 {
        match self.core {
            Core::Axis { through, .. } => through,
            Core::Point(point) => point,
        }
    }

    /// The part of a vector that changes the distance from the axis or point.
    fn across(&self, v: DVec3) -> DVec3 {
        match self.core {
            Core::Axis { direction, .. } => v - v.dot(direction) * direction,
            Core::Point(_) => v,
        }
    }
}

impl RaySet {
    /// Each ray moved along itself to `surface`; directions and flux stay.
    ///
    /// Errors: a start point that f32 cannot hold.
    pub fn starting_at(mut self, surface: &StartSurface) -> Result<Self> {
        let samples = Arc::make_mut(&mut self.samples);
        samples.par_iter_mut().for_each(|sample| {
            let start = surface.start_of(sample.origin(), sample.unit_direction());
            sample.position = start.to_array().map(|x| x as f32);
        });
        let flawed = samples.iter().position(|s| s.position.iter().any(|x| !x.is_finite()));
        match flawed {
            None => Ok(self),
            Some(index) => {
                let problem = format!("ray {} comes nearest beyond 3e38 mm", index + 1);
                Err(Error::inconsistent("start", problem))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit(x: f64, y: f64, z: f64) -> DVec3 {
        DVec3::new(x, y, z).normalize()
    }

    #[test]
    fn nearest_to_axis_and_point_by_hand() {
        let axis = StartSurface::axis(DVec3::ZERO, 2.0 * DVec3::Z).unwrap();
        let start = axis.start_of(DVec3::new(5.0, 1.0, 7.0), unit(-1.0, 0.0, -1.0));
        assert!(start.distance(DVec3::new(0.0, 1.0, 2.0)) < 1e-14);
        let point = StartSurface::point(DVec3::new(0.0, 0.0, 2.0)).unwrap();
        let start = point.start_of(DVec3::new(5.0, 1.0, 7.0), unit(-1.0, 0.0, -1.0));
        assert!(start.distance(DVec3::new(0.0, 1.0, 2.0)) < 1e-14);
        assert!(
            (point.distance_mm(DVec3::new(5.0, 1.0, 7.0), unit(-1.0, 0.0, -1.0)) - 1.0).abs()
                < 1e-14
        );
    }

    #[test]
    fn a_radius_puts_the_start_where_the_ray_leaves() {
        let cylinder = StartSurface::axis(DVec3::ZERO, DVec3::Z).unwrap().with_radius(2.0).unwrap();
        let start = cylinder.start_of(DVec3::new(-9.0, 0.0, 0.0), unit(1.0, 0.0, 1.0));
        assert!(start.distance(DVec3::new(2.0, 0.0, 11.0)) < 1e-13);
        let outside = cylinder.start_of(DVec3::new(-9.0, 3.0, 0.0), DVec3::X);
        assert_eq!(outside, DVec3::new(0.0, 3.0, 0.0));
    }

    #[test]
    fn a_ray_along_the_axis_stays() {
        let axis = StartSurface::axis(DVec3::ZERO, DVec3::Z).unwrap();
        let origin = DVec3::new(1.0, 0.0, 5.0);
        assert_eq!(axis.start_of(origin, DVec3::Z), origin);
        assert_eq!(axis.distance_mm(origin, DVec3::Z), 1.0);
    }

    #[test]
    fn bad_surfaces_are_refused() {
        assert!(StartSurface::axis(DVec3::ZERO, DVec3::ZERO).is_err());
        assert!(StartSurface::axis(DVec3::NAN, DVec3::Z).is_err());
        assert!(StartSurface::point(DVec3::INFINITY).is_err());
        assert!(StartSurface::point(DVec3::ZERO).unwrap().with_radius(-1.0).is_err());
    }
}
