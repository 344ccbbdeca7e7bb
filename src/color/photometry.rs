//! What the numbers of an image mean: relative light, or luminance in cd/m².

/// Which of model.md's two photometries a scene uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Photometry {
    /// Eq. 2 and 9 as they stand: Σ Φ_i c_i (k_d g_d + k_s g_s).
    Relative,
    /// Σ Φ_i c_i / (π r²) (k_d/π g_d + k_s (n_s + 2)/(2π) g_s), r in metres.
    Absolute,
}
