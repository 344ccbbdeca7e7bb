//! Lampyris predicts what a lit lamp looks like and how bright it is, wavelength by wavelength.
//!
//! `script.lua → script::run → Scene (plain data) → Scene::prepare → Prepared (BVH, light trees,
//! resampled spectra) → render → SpectralImage → color (XYZ) → display → PNG`, and EXR straight
//! from `SpectralImage`.
//!
//! The equations are those of Lee, Lee & Ha, "Rendering Method of Light Environment Based on
//! Modeling of Physical Characteristic" (J. IEEK 43-SP-6, 2006), cited here as "eq. n".
//!
//! Units and axes: lengths in mm, wavelengths in nm, flux in lm, angles in degrees at the
//! interface and in radians inside. Right-handed; +Z points out of the lamp to the viewer, +X to
//! the viewer's right, +Y up.
//!
//! Numeric policy: geometry (points, directions, normals, distances) is f64, because an f32 normal
//! already shows in a lobe of exponent 1500; the BVH may prefilter in f32 but decides in f64.
//! Spectra are carried and accumulated in f64. Samples of ray sets are stored in f32, as ray files
//! store them, and summed in f32 lanes that are folded into f64. Images are stored in f32.
//!
//! Determinism: same inputs give the same bytes for any number of threads and any SIMD width, so
//! no kernel's result depends on fused multiply-add or on the number of lanes.

pub mod color;
pub mod columns;
pub mod display;
pub mod error;
pub mod fit;
pub mod geometry;
pub mod image;
pub mod light;
pub mod material;
pub mod output;
#[cfg(feature = "program")]
pub mod program;
pub mod render;
pub mod scene;
pub mod shading;
pub mod source;
pub mod spectrum;
pub mod statistics;
pub mod view;

pub use error::{Error, Result};
