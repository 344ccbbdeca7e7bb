//! Luminous intensity toward the eye, from an image.

use crate::color::Photometry;
use crate::color::Xyz;
use crate::error::{Error, Result};
use crate::image::{Region, SpectralImage};
use crate::view::{Camera, View};

/// Intensity of all that `image` shows, toward the eye of `view`: Y in cd, X and Z likewise.
///
/// What a photometer at the eye that faces the target reads, times the square of their distance:
/// I = r² Σ L Ω cos θ, over the pixels' luminance L, solid angle Ω, and angle θ to the view's
/// axis, with r from the eye to the target in m. For a lamp that is small against r this is its
/// luminance times its projected area.
/// Errors: an image of relative photometry, which has no unit.
pub fn intensity(image: &SpectralImage, view: &View) -> Result<Xyz> {
    Ok(Xyz::from_bands(image.grid, &intensity_bands(image, view)?))
}

/// The same at each band: W·sr⁻¹·nm⁻¹. Errors: as [`intensity`].
pub fn intensity_bands(image: &SpectralImage, view: &View) -> Result<Vec<f64>> {
    if image.photometry != Photometry::Absolute {
        let problem = "needs a scene with photometry = \"absolute\": relative values have no unit";
        return Err(Error::inconsistent("intensity", problem));
    }
    let camera = view.camera();
    let mut bands = vec![0.0; image.grid.bands()];
    for y in 0..image.height {
        for x in 0..image.width {
            let facing_sr = facing_sr(&camera, [x as f64 + 0.5, y as f64 + 0.5]);
            for (sum, value) in bands.iter_mut().zip(image.pixel(x, y)) {
                *sum += f64::from(*value) * facing_sr;
            }
        }
    }
    let r_m = view.distance_mm * 1e-3;
    bands.iter_mut().for_each(|value| *value *= r_m * r_m);
    Ok(bands)
}

/// Ω cos θ of the pixel with this center.
pub fn facing_sr(camera: &Camera, [x, y]: [f64; 2]) -> f64 {
    camera.pixel_solid_angle_sr(x, y) * camera.cos_to_axis(x, y)
}

/// Whether there is light at the image's border, so that more of it may lie outside.
pub fn is_cut_off(image: &SpectralImage) -> bool {
    let (width, height) = (image.width, image.height);
    let strips = [
        Region { x: 0, y: 0, width, height: 1 },
        Region { x: 0, y: height.saturating_sub(1), width, height: 1 },
        Region { x: 0, y: 0, width: 1, height },
        Region { x: width.saturating_sub(1), y: 0, width: 1, height },
    ];
    strips.into_iter().any(|strip| image.mean_xyz(strip).is_ok_and(|xyz| xyz.y > 0.0))
}
