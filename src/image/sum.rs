//! Light is linear: weighted sums of images.

use std::fmt::Write;

use super::{Metadata, SpectralImage};
use crate::error::{Error, Result};

/// Σ weight · image: the picture of lamps dimmed to these shares of their light.
///
/// Bands are added in f64 and rounded once. View and metadata stay as far as all images share
/// them; standard errors and counts of samples go. Weights may be negative, for differences.
/// Errors: [`Error::Inconsistent`] for no image, or images that differ in size, wavelengths or
/// photometry; [`Error::OutOfRange`] for a weight that is not finite.
pub fn weighted_sum(terms: &[(f64, &SpectralImage)]) -> Result<SpectralImage> {
    let Some((_, first)) = terms.first() else {
        return Err(Error::inconsistent("image sum", "has no images"));
    };
    for (weight, image) in terms {
        check(*weight, image, first)?;
    }
    let mut sum = SpectralImage::new(first.width, first.height, first.grid, first.photometry);
    for (at, value) in sum.bands.iter_mut().enumerate() {
        let parts = terms.iter().map(|(weight, image)| weight * f64::from(image.bands[at]));
        *value = parts.sum::<f64>() as f32;
    }
    sum.view = first.view.filter(|view| terms.iter().all(|(_, i)| i.view == Some(*view)));
    sum.metadata = shared_metadata(terms);
    Ok(sum)
}

fn check(weight: f64, image: &SpectralImage, first: &SpectralImage) -> Result<()> {
    if !weight.is_finite() {
        return Err(Error::out_of_range("image sum", "weight", weight, "finite numbers"));
    }
    let shape = |i: &SpectralImage| {
        format!("{} × {} pixels of {} bands, {:?}", i.width, i.height, i.grid.bands(), i.photometry)
    };
    let (found, expected) = (shape(image), shape(first));
    if found == expected {
        return Ok(());
    }
    let problem = format!("images differ: {expected} and {found}").to_lowercase();
    Err(Error::inconsistent("image sum", problem))
}

/// Entries that all images have, and the weights.
fn shared_metadata(terms: &[(f64, &SpectralImage)]) -> Metadata {
    let (_, first) = terms[0]; // never empty
    let is_shared = |key: &String, value: &String| {
        key != WEIGHTS && terms.iter().all(|(_, image)| image.metadata.get(key) == Some(value))
    };
    let shared = first.metadata.iter().filter(|(key, value)| is_shared(key, value));
    let mut metadata: Metadata = shared.map(|(k, v)| (k.clone(), v.clone())).collect();
    let mut weights = String::new();
    for (at, (weight, image)) in terms.iter().enumerate() {
        let plus = if at == 0 { "" } else { " + " };
        let inner = image.metadata.get(WEIGHTS);
        let inner = inner.map_or_else(String::new, |sum| format!(" ({sum})"));
        let _ = write!(weights, "{plus}{weight}{inner}"); // writing to a string cannot fail
    }
    metadata.insert(WEIGHTS.to_owned(), weights);
    metadata
}

const WEIGHTS: &str = "sum_of_weights";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Photometry;
    use crate::spectrum::WavelengthGrid;

    fn image(value: f32) -> SpectralImage {
        let mut image = SpectralImage::new(3, 2, WavelengthGrid::Step20, Photometry::Absolute);
        image.bands.fill(value);
        image.metadata.insert("script".to_owned(), "lamp.lua".to_owned());
        image.metadata.insert("quality".to_owned(), value.to_string());
        image
    }

    #[test]
    fn sums_are_weighted_and_keep_what_is_shared() {
        let (a, b) = (image(1.5), image(2.0));
        let sum = weighted_sum(&[(0.25, &a), (-1.0, &b)]).unwrap();
        assert!(sum.bands.iter().all(|&value| value == -1.625));
        assert_eq!(sum.metadata["script"], "lamp.lua");
        assert_eq!(sum.metadata.get("quality"), None);
        assert_eq!(sum.metadata["sum_of_weights"], "0.25 + -1");
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let message =
            |terms: &[(f64, &SpectralImage)]| weighted_sum(terms).unwrap_err().to_string();
        let (a, mut b) = (image(1.0), image(1.0));
        b.photometry = Photometry::Relative;
        assert_eq!(message(&[]), "image sum: has no images");
        assert_eq!(
            message(&[(1.0, &a), (1.0, &b)]),
            "image sum: images differ: 3 × 2 pixels of 21 bands, absolute and \
             3 × 2 pixels of 21 bands, relative"
        );
        assert_eq!(message(&[(f64::NAN, &a)]), "image sum: weight is NaN, allowed: finite numbers");
    }
}
