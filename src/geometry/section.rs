//! Where a mesh meets a plane.

use super::{DVec3, Mesh};

/// The plane through `point` across `normal`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// Any point of it, mm.
    pub point: DVec3,
    /// Unit.
    pub normal: DVec3,
}

impl Plane {
    fn height(&self, position: DVec3) -> f64 {
        (position - self.point).dot(self.normal)
    }
}

impl Mesh {
    /// One segment for each triangle that the plane cuts; a corner on the plane counts as above.
    pub fn section(&self, plane: &Plane) -> Vec<[DVec3; 2]> {
        self.triangles.iter().filter_map(|corners| self.cut(*corners, plane)).collect()
    }

    fn cut(&self, corners: [u32; 3], plane: &Plane) -> Option<[DVec3; 2]> {
        let positions = corners.map(|corner| self.positions[corner as usize]);
        let heights = positions.map(|position| plane.height(position));
        let mut crossings = [0, 1, 2]
            .into_iter()
            .map(|i| (i, (i + 1) % 3))
            .filter(|&(i, j)| (heights[i] < 0.0) != (heights[j] < 0.0))
            .map(|(i, j)| {
                let share = heights[i] / (heights[i] - heights[j]);
                positions[i] + share * (positions[j] - positions[i])
            });
        Some([crossings.next()?, crossings.next()?])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cone_is_cut_in_a_circle() {
        let sides = 90;
        let rim = (0..sides).map(|i| f64::from(i) * std::f64::consts::TAU / f64::from(sides));
        let mut positions = vec![DVec3::Z];
        positions.extend(rim.map(|angle| DVec3::new(angle.cos(), angle.sin(), -1.0)));
        let triangles = (0..sides as u32).map(|i| [0, 1 + i, 1 + (i + 1) % sides as u32]);
        let cone = Mesh::smooth("cone", positions, triangles.collect()).unwrap();
        let at = |z: f64| cone.section(&Plane { point: DVec3::Z * z, normal: DVec3::Z });
        let circle = at(0.0);
        assert_eq!(circle.len(), 90);
        for end in circle.iter().flatten() {
            // On the cone's edges.
            assert!((end.truncate().length() - 0.5).abs() < 1e-15 && end.z.abs() < 1e-15);
        }
        assert!(at(2.0).is_empty() && at(-2.0).is_empty());
    }
}
