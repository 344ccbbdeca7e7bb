//! Surfaces that light is measured on: where a place lies on them in coordinates of equal area, and
//! their frame there.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use crate::error::Result;
use crate::geometry::Mesh;
use crate::geometry::mesh::Shading;

/// A surface in the ray set's own coordinates. Lengths in mm, directions unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// The side of a cylinder about `center`, without its ends.
    Cylinder {
        /// Middle of the axis.
        center: DVec3,
        /// Direction of the axis.
        axis: DVec3,
        /// Distance of the side from the axis.
        radius_mm: f64,
        /// From end to end.
        length_mm: f64,
    },
    /// A sphere.
    Sphere {
        /// Its middle.
        center: DVec3,
        /// Distance of the surface from it.
        radius_mm: f64,
    },
    /// A disc that shines to the side of its normal.
    Disc {
        /// Its middle.
        center: DVec3,
        /// Toward the side that shines.
        normal: DVec3,
        /// Distance of the rim from the middle.
        radius_mm: f64,
    },
    /// A rectangle that shines to the side of its normal.
    Rectangle {
        /// Its middle.
        center: DVec3,
        /// Toward the side that shines.
        normal: DVec3,
        /// Along its width, perpendicular to the normal.
        across: DVec3,
        /// Side along `across`.
        width_mm: f64,
        /// The other side.
        height_mm: f64,
    },
}

/// A place on a surface: coordinates of equal area in 0 to 1, and the frame there.
#[derive(Debug, Clone, Copy)]
pub struct SurfacePlace {
    /// u, v.
    pub coordinates: [f64; 2],
    /// Outward.
    pub normal: DVec3,
    /// From which azimuths of directions are counted.
    pub tangent: DVec3,
}

/// Triangles around a cylinder or sphere.
const SEGMENTS: usize = 256;

impl Shape {
    /// mm².
    pub fn area_mm2(&self) -> f64 {
        match *self {
            Self::Cylinder { radius_mm, length_mm, .. } => TAU * radius_mm * length_mm,
            Self::Sphere { radius_mm, .. } => 4.0 * PI * radius_mm * radius_mm,
            Self::Disc { radius_mm, .. } => PI * radius_mm * radius_mm,
            Self::Rectangle { width_mm, height_mm, .. } => width_mm * height_mm,
        }
    }

    /// Whether u runs around: its ends 0 and 1 are one place.
    pub fn is_round(&self) -> bool {
        !matches!(self, Self::Rectangle { .. })
    }

    /// The place nearest to a point.
    pub fn place_of(&self, point: DVec3) -> SurfacePlace {
        match *self {
            Self::Cylinder { center, axis, length_mm, .. } => {
                let from = point - center;
                let v = from.dot(axis) / length_mm + 0.5;
                let radial = from.reject_from_normalized(axis);
                let u = azimuth(axis, radial);
                self.place(u, v)
            }
            Self::Sphere { center, .. } => {
                let from = (point - center).try_normalize().unwrap_or(DVec3::Z);
                self.place(azimuth(DVec3::Z, from), 0.5 * (1.0 - from.z))
            }
            Self::Disc { center, normal, radius_mm } => {
                let from = (point - center).reject_from_normalized(normal);
                self.place(azimuth(normal, from), from.length_squared() / (radius_mm * radius_mm))
            }
            Self::Rectangle { center, normal, across, width_mm, height_mm } => {
                let from = point - center;
                let up = normal.cross(across);
                self.place(from.dot(across) / width_mm + 0.5, from.dot(up) / height_mm + 0.5)
            }
        }
    }

    /// The place with coordinates u, v, which are brought into 0 to 1.
    pub fn place(&self, u: f64, v: f64) -> SurfacePlace {
        let u = if self.is_round() { u.rem_euclid(1.0) } else { u.clamp(0.0, 1.0) };
        let v = v.clamp(0.0, 1.0);
        let (normal, tangent) = match *self {
            Self::Cylinder { axis, .. } => (around(axis, u), axis),
            Self::Sphere { .. } => {
                let z = 1.0 - 2.0 * v;
                let normal = around(DVec3::Z, u) * (1.0 - z * z).max(0.0).sqrt() + DVec3::Z * z;
                (normal, around(DVec3::Z, u + 0.25))
            }
            Self::Disc { normal, .. } => (normal, normal.any_orthonormal_vector()),
            Self::Rectangle { normal, across, .. } => (normal, across),
        };
        SurfacePlace { coordinates: [u, v], normal, tangent }
    }

    /// The point of a place, mm.
    pub fn point(&self, place: &SurfacePlace) -> DVec3 {
        let [u, v] = place.coordinates;
        match *self {
            Self::Cylinder { center, axis, radius_mm, length_mm } => {
                center + place.normal * radius_mm + axis * ((v - 0.5) * length_mm)
            }
            Self::Sphere { center, radius_mm } => center + place.normal * radius_mm,
            Self::Disc { center, normal, radius_mm } => {
                center + around(normal, u) * (v.sqrt() * radius_mm)
            }
            Self::Rectangle { center, normal, across, width_mm, height_mm } => {
                center
                    + across * ((u - 0.5) * width_mm)
                    + normal.cross(across) * ((v - 0.5) * height_mm)
            }
        }
    }

    /// Where a ray's line leaves the surface outward; where it passes by, the nearest place.
    pub fn exit_of(&self, origin: DVec3, direction: DVec3) -> DVec3 {
        match *self {
            Self::Cylinder { center, axis, radius_mm, .. } => {
                let across = |v: DVec3| v.reject_from_normalized(axis);
                leave_round(
                    origin,
                    direction,
                    [across(origin - center), across(direction)],
                    radius_mm,
                )
            }
            Self::Sphere { center, radius_mm } => {
                leave_round(origin, direction, [origin - center, direction], radius_mm)
            }
            Self::Disc { center, normal, .. } | Self::Rectangle { center, normal, .. } => {
                let cos = direction.dot(normal);
                let along = (center - origin).dot(normal) / cos;
                if cos.abs() > 1e-9 { origin + direction * along } else { origin }
            }
        }
    }

    /// Triangles that rays meet. Polygons around have the circle's length, so that their mean
    /// width is the circle's.
    pub fn mesh(&self) -> Result<Mesh> {
        let (nu, nv) = match self {
            Self::Cylinder { .. } => (SEGMENTS, 1),
            Self::Sphere { .. } => (SEGMENTS, SEGMENTS / 2),
            Self::Disc { .. } => (SEGMENTS, 1),
            Self::Rectangle { .. } => (1, 1),
        };
        let grown = self.scaled_to_polygons(nu);
        let points: Vec<Option<DVec3>> = (0..=nv)
            .flat_map(|j| (0..=nu).map(move |i| (i, j)))
            .map(|(i, j)| Some(grown.grid_point(i as f64 / nu as f64, j as f64 / nv as f64)))
            .collect();
        Ok(Mesh::from_grid("emitter", nu, nv, &points)?.into_flat())
    }

    /// The same triangles with the surface's own normals at their corners.
    ///
    /// Errors: as [`Shape::mesh`].
    pub fn smooth_mesh(&self) -> Result<Mesh> {
        let mesh = self.mesh()?;
        let normals = mesh.positions.iter().map(|p| self.place_of(*p).normal).collect();
        Ok(Mesh { shading: Shading::PerPosition(normals), ..mesh })
    }

    /// A grid's point; u and v run so that the front is outward.
    fn grid_point(&self, u: f64, v: f64) -> DVec3 {
        match self {
            // Seen from outside, u runs right and v up.
            Self::Cylinder { .. } | Self::Rectangle { .. } => self.point(&self.place(u, v)),
            Self::Sphere { .. } => {
                let polar = PI * (1.0 - v);
                self.point(&self.place(u, 0.5 * (1.0 - polar.cos())))
            }
            Self::Disc { .. } => self.point(&self.place(u, 1.0 - v)),
        }
    }

    fn scaled_to_polygons(&self, segments: usize) -> Self {
        let half = PI / segments as f64;
        match *self {
            Self::Cylinder { center, axis, radius_mm, length_mm } => {
                Self::Cylinder { center, axis, radius_mm: radius_mm * half / half.sin(), length_mm }
            }
            // The polygon's area is the disc's.
            Self::Disc { center, normal, radius_mm } => Self::Disc {
                center,
                normal,
                radius_mm: radius_mm * (half / (half.sin() * half.cos())).sqrt(),
            },
            other => other,
        }
    }
}

/// Unit, across `axis`, at a share of the turn about it.
fn around(axis: DVec3, turns: f64) -> DVec3 {
    let (a, b) = axis.any_orthonormal_pair();
    let (sin, cos) = (TAU * turns).sin_cos();
    a * cos + b * sin
}

/// Share of the turn about `axis`, 0 to 1.
fn azimuth(axis: DVec3, v: DVec3) -> f64 {
    let (a, b) = axis.any_orthonormal_pair();
    (v.dot(b).atan2(v.dot(a)) / TAU).rem_euclid(1.0)
}

/// Where a line leaves a round surface; `from` and `across` count for the distance from its middle.
fn leave_round(
    origin: DVec3,
    direction: DVec3,
    [from, across]: [DVec3; 2],
    radius_mm: f64,
) -> DVec3 {
    let square = across.length_squared();
    if square < 1e-15 {
        return origin;
    }
    let nearest = -from.dot(across) / square;
    let distance2 = (from + across * nearest).length_squared();
    let half_chord = ((radius_mm * radius_mm - distance2).max(0.0) / square).sqrt();
    origin + direction * (nearest + half_chord)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHAPES: [Shape; 4] = [
        Shape::Cylinder {
            center: DVec3::new(1.0, 2.0, 3.0),
            axis: DVec3::new(0.6, 0.0, 0.8),
            radius_mm: 0.65,
            length_mm: 4.1,
        },
        Shape::Sphere { center: DVec3::new(1.0, 2.0, 3.0), radius_mm: 2.0 },
        Shape::Disc { center: DVec3::ONE, normal: DVec3::new(0.6, 0.0, 0.8), radius_mm: 1.5 },
        Shape::Rectangle {
            center: DVec3::ONE,
            normal: DVec3::new(0.6, 0.0, 0.8),
            across: DVec3::Y,
            width_mm: 2.0,
            height_mm: 1.0,
        },
    ];

    #[test]
    fn places_and_points_are_each_others_inverse() {
        for shape in SHAPES {
            for (u, v) in [(0.1, 0.3), (0.7, 0.9), (0.99, 0.02)] {
                let place = shape.place(u, v);
                let back = shape.place_of(shape.point(&place));
                assert!((back.coordinates[0] - u).abs() < 1e-12, "{shape:?} {back:?}");
                assert!((back.coordinates[1] - v).abs() < 1e-12, "{shape:?} {back:?}");
                assert!(back.normal.dot(back.tangent).abs() < 1e-12);
                // From inside along a slanted way, the line leaves there again.
                let toward = (place.normal + 0.4 * place.tangent).normalize();
                let point = shape.point(&place);
                assert!(shape.exit_of(point - 0.3 * toward, toward).distance(point) < 1e-12);
            }
        }
    }

    #[test]
    fn meshes_face_outward_and_have_the_shapes_area() {
        for shape in SHAPES {
            let mesh = shape.mesh().unwrap();
            for at in 0..mesh.triangles.len() {
                let [a, b, c] = mesh.corners(at);
                let place = shape.place_of((a + b + c) / 3.0);
                let normal = mesh.geometric_normal(at);
                assert!(normal == DVec3::ZERO || normal.dot(place.normal) > 0.99, "{shape:?} {at}");
            }
            // A sphere of 256 × 128 cells loses 2e-4.
            let area = super::super::mesh_area(&mesh);
            assert!((area / shape.area_mm2() - 1.0).abs() < 3e-4, "{shape:?} {area}");
        }
    }
}
