//! The paper's material (Table 4) and the fitting of its lobes to measured curves.

/// The scalar part of eq. 2: a diffuse lobe and any number of specular ones.
#[derive(Debug, Clone, PartialEq)]
pub struct Lobes {
    /// Proportion of the diffuse lobe, 0 to 1.
    pub k_d: f64,
    /// Exponent n of (L·N)ⁿ, 1 to 10⁶.
    pub n_d: f64,
    /// Only lobes with k_s > 0.
    pub specular: Vec<SpecularLobe>,
}

/// k_s (R·V)^n_s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpecularLobe {
    /// 0 to 1.
    pub k_s: f64,
    /// 1 to 10⁶.
    pub n_s: f64,
}
