//! Directions that a diffuse emitter sends its light in.

use std::f64::consts::TAU;

use glam::DVec3;

/// Distributed like the cosine to `normal`, as (u, v) runs over the unit square.
///
/// Both are unit vectors.
pub(super) fn direction(normal: DVec3, u: f64, v: f64) -> DVec3 {
    let (a, b) = normal.any_orthonormal_pair();
    let (sin, cos) = (TAU * v).sin_cos();
    let across = u.sqrt();
    (a * (across * cos) + b * (across * sin) + normal * (1.0 - u).sqrt()).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mean of cos² over a cosine lobe is 1/2 along its axis and 1/4 across it.
    #[test]
    fn second_moments_are_those_of_a_cosine_lobe() {
        let normal = DVec3::new(2.0, -1.0, 0.5).normalize();
        let across = normal.any_orthonormal_vector();
        let n = 300;
        let (mut along_sum, mut across_sum) = (0.0, 0.0);
        for i in 0..n * n {
            let at = |k: usize| (k as f64 + 0.5) / n as f64;
            let d = direction(normal, at(i / n), at(i % n));
            along_sum += d.dot(normal).powi(2) / (n * n) as f64;
            across_sum += d.dot(across).powi(2) / (n * n) as f64;
        }
        assert!((along_sum - 0.5).abs() < 1e-9, "{along_sum}");
        assert!((across_sum - 0.25).abs() < 1e-9, "{across_sum}");
    }
}
