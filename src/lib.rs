//! Lampyris predicts what a lit lamp looks like and how bright it is, wavelength by wavelength.
//!
//! `Scene (plain data) → Scene::prepare → Prepared (BVH, light trees, spectra at the bands) →
//! render → SpectralImage → display → PNG`, and EXR straight from `SpectralImage`. With the feature
//! `program` (a default) a Lua script makes the scene: `script.lua → program::script::run → Scene`.
//!
//! The equations are those of Lee, Lee & Ha, "Rendering Method of Light Environment Based on
//! Modeling of Physical Characteristic" (J. IEEK 43-SP-6, 2006), cited here as "eq. n".
//!
//! # Modules, in reading order
//!
//! Each knows only those before it.
//!
//! | storey | module | holds |
//! |---|---|---|
//! | ground | [`error`], [`input`] | the one public error type; files to be read |
//! | | [`simd`], [`statistics`], [`columns`], [`fit`] | instruction sets; percentiles; tables of numbers in files; least squares |
//! | | [`spectrum`], [`color`] | the wavelength grid, resampling, CIE tables; tristimulus values, CIELAB, color differences |
//! | scene | [`geometry`] | rays, hits, meshes and their normals, mesh files, the BVH |
//! | | [`material`] | what a surface does with light, and lobes fitted to measured curves |
//! | | [`light`] | what a hit asks of light: ray sets, the exact sum, the tree |
//! | | [`source`] | where light comes from: ray files, filaments, bulbs, emitters |
//! | | [`environment`] | what surrounds the scene: pictures, skies, the sun |
//! | | [`view`], [`scene`] | pixel to ray; the plain scene, and its preparation |
//! | picture | [`shading`] | what a ray brings back: local and global terms |
//! | | [`image`], [`render`] | spectra of pixels; samples, tiles, errors (no physics) |
//! | | [`display`], [`output`] | what a person sees on a monitor; EXR, PNG and other files |
//! | program | `program` | Lua scripts, sweeps, figures, photometric files, the command line |
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
//! no kernel's result depends on fused multiply-add or on the number of lanes. sin, exp and pow are
//! the C library's, and the same from machine to machine as far as they are.
//!
//! # Four walks
//!
//! *A view's azimuth.* A script gives `azimuth` in degrees, and its option row checks the range.
//! [`view::View`] keeps it as it was given. [`view::View::camera`] turns it into the eye's place and
//! three axes. [`view::Camera::ray`] makes the ray of an image position from them. Nothing after
//! that knows angles.
//!
//! *A ray's radiance.* [`mod@render`] takes a camera ray for each sample of a pixel, and
//! [`shading::Tracer`] follows it. At each hit the light trees answer one sum for all bands
//! ([`light::LightTree`]), which material and light spectra turn into radiance. Mirrored and
//! transmitted rays go on with what is left of the throughput. A ray that hits nothing adds the
//! background. The pixel keeps the mean over its samples, in f32.
//!
//! *A ray file's record.* [`source::rayfile`] tells the format by its first bytes. The format's
//! layout says where position, direction, flux and wavelength stand in the record. Each value is
//! checked to be finite and is brought to mm and lm. The record becomes a [`light::RaySample`] of a
//! [`light::RaySet`], and its wavelength a share of the set's spectrum. The light tree sorts the
//! samples by place, and a hit asks the tree.
//!
//! *A PNG's pixel.* [`image::SpectralImage::to_xyz`] sums the pixel's bands with the color-matching
//! functions (eq. 4). [`display`] adds glare, if asked, scales by the exposure, and bends luminance
//! by the tone curve. Colors that the display cannot show are clipped or desaturated, and counted.
//! The display model turns XYZ into digits (eq. 7 and 8). [`output`] writes them with the display's
//! profile, whole or not at all.

#![warn(missing_docs)]

pub mod color;
pub mod columns;
pub mod display;
pub mod environment;
pub mod error;
pub mod fit;
pub mod geometry;
pub mod image;
pub mod input;
pub mod light;
pub mod material;
pub mod output;
#[cfg(feature = "program")]
pub mod program;
pub mod render;
pub mod scene;
pub mod shading;
pub mod simd;
pub mod source;
pub mod spectrum;
pub mod statistics;
pub mod view;

pub use error::{Error, Result};
