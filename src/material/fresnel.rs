//! How much a smooth interface mirrors: Fresnel's law.

use crate::spectrum::Spectrum;

/// What decides how much a surface mirrors, and how much goes on through it.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Fresnel {
    /// k_rg and k_tg alone, at every angle.
    #[default]
    Off,
    /// R(θ) of the material's `ior` and of what is on the other side.
    Dielectric,
    /// R(θ) of a metal with the complex index n + ik.
    Metal {
        /// 0 to 100.
        n: Spectrum,
        /// 0 to 100.
        k: Spectrum,
    },
}

impl Fresnel {
    /// Whether it shares light out by the angle.
    pub fn is_on(&self) -> bool {
        !matches!(self, Self::Off)
    }
}

/// Share of unpolarised light that an interface between clear media mirrors.
///
/// `cos` is that of the angle of incidence, 0 to 1, in the medium of index `before`. 0 to 1; 1 at
/// total internal reflection. Source: Fresnel's equations, as model.md, "Interfaces".
pub fn dielectric_reflectance(cos: f64, before: f64, after: f64) -> f64 {
    let sin2_after = (before / after).powi(2) * (1.0 - cos * cos);
    if sin2_after >= 1.0 {
        return 1.0;
    }
    let cos_after = (1.0 - sin2_after).sqrt();
    let s = (before * cos - after * cos_after) / (before * cos + after * cos_after);
    let p = (after * cos - before * cos_after) / (after * cos + before * cos_after);
    0.5 * (s * s + p * p)
}

/// Share of unpolarised light that a metal of index `n` + i `k` mirrors into a clear medium of
/// index `before`, at an angle of incidence of cosine `cos`, 0 to 1.
///
/// Source: Fresnel's equations for a complex index, in real numbers (Born & Wolf, section 14.2).
pub fn metal_reflectance(cos: f64, before: f64, [n, k]: [f64; 2]) -> f64 {
    let (n, k) = (n / before, k / before);
    let (cos2, sin2) = (cos * cos, 1.0 - cos * cos);
    let difference = n * n - k * k - sin2;
    let sum = (difference * difference + 4.0 * n * n * k * k).sqrt();
    // a + ib is the root of (n + ik)² − sin²θ.
    let a = (0.5 * (sum + difference)).max(0.0).sqrt();
    let s = (sum + cos2 - 2.0 * a * cos) / (sum + cos2 + 2.0 * a * cos);
    let (even, odd) = (cos2 * sum + sin2 * sin2, 2.0 * a * cos * sin2);
    let p = s * (even - odd) / (even + odd).max(f64::MIN_POSITIVE);
    0.5 * (s + p)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Hecht, "Optics": glass of 1.5 mirrors 4 % at normal incidence, no p light at Brewster's
    /// angle, and all light at grazing incidence.
    #[test]
    fn glass_at_normal_brewster_and_grazing_incidence() {
        assert!((dielectric_reflectance(1.0, 1.0, 1.5) - 0.04).abs() < 1e-15);
        let brewster = 1.5f64.atan();
        let s = ((1.0 - 2.25) / (1.0 + 2.25f64)).powi(2);
        let value = dielectric_reflectance(brewster.cos(), 1.0, 1.5);
        assert!((value - 0.5 * s).abs() < 1e-14, "{value}");
        assert_eq!(dielectric_reflectance(0.0, 1.0, 1.5), 1.0);
        assert_eq!(dielectric_reflectance(0.5, 1.5, 1.0), 1.0, "60° is past the critical angle");
    }

    /// Light that comes from the other side along the same path is mirrored as much.
    #[test]
    fn both_ways_mirror_the_same() {
        for degrees in [0.0f64, 10.0, 40.0, 80.0, 89.0] {
            let sin = degrees.to_radians().sin();
            let inside = (1.0 - (sin / 1.49).powi(2)).sqrt();
            let (into, out) = (
                dielectric_reflectance(degrees.to_radians().cos(), 1.0, 1.49),
                dielectric_reflectance(inside, 1.49, 1.0),
            );
            assert!((into - out).abs() < 1e-13, "{degrees}: {into} {out}");
        }
    }

    #[test]
    fn a_metal_without_absorption_is_a_dielectric() {
        for degrees in [0.0f64, 30.0, 56.0, 85.0, 90.0] {
            let cos = degrees.to_radians().cos();
            let (metal, clear) =
                (metal_reflectance(cos, 1.33, [2.0, 0.0]), dielectric_reflectance(cos, 1.33, 2.0));
            assert!((metal - clear).abs() < 1e-12, "{degrees}: {metal} {clear}");
        }
    }

    /// Complex arithmetic, written out: r_s = (c − w)/(c + w), r_p = (N²c − w)/(N²c + w) with
    /// w = √(N² − sin²θ).
    #[test]
    fn aluminium_follows_the_complex_formula() {
        type Complex = [f64; 2];
        let multiply =
            |a: Complex, b: Complex| [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]];
        let norm2 = |a: Complex| a[0] * a[0] + a[1] * a[1];
        let index = [0.96, 6.69];
        for degrees in [0.0f64, 20.0, 60.0, 85.0, 89.9] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let squared = multiply(index, index);
            let inside = [squared[0] - sin * sin, squared[1]];
            let modulus = norm2(inside).sqrt();
            let w = [((modulus + inside[0]) / 2.0).sqrt(), ((modulus - inside[0]) / 2.0).sqrt()];
            let share =
                |c: Complex| norm2([c[0] - w[0], c[1] - w[1]]) / norm2([c[0] + w[0], c[1] + w[1]]);
            let expected = 0.5 * (share([cos, 0.0]) + share([squared[0] * cos, squared[1] * cos]));
            let value = metal_reflectance(cos, 1.0, index);
            assert!((value - expected).abs() < 1e-12, "{degrees}: {value} {expected}");
        }
    }
}
