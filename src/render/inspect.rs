//! Looks into a picture without taking it: the error of its light sums, the rays of one place, and
//! the mean of a region.

use rayon::prelude::*;

use super::Quality;
use super::pattern::Pattern;
use crate::error::Result;
use crate::image::Region;
use crate::scene::Prepared;
use crate::shading::{LightCheck, PathSegment, TraceState, Tracer};
use crate::spectrum::Bands;
use crate::view::View;

/// Compares the light sums of `hits` hits of a view, drawn evenly, with the exact ones.
///
/// Same inputs, same hits. `None` if no light arrives at any of them. Errors: as [`super::render`].
pub fn check_light_error(
    prepared: &Prepared,
    view: &View,
    quality: &Quality,
    hits: usize,
) -> Result<Option<LightCheck>> {
    /// Camera rays tried for each hit, before the view is taken for empty.
    const TRIES: usize = 100;
    let tables = prepared.tables(quality.grid)?;
    let tracer = Tracer { prepared, tables, limits: quality.limits };
    let camera = view.camera();
    let pattern = Pattern::of_pixel(0, 0);
    let rays = (0..(hits * TRIES) as u32).map(|i| {
        let [x, y] = pattern.place(i);
        camera.ray(x * view.width as f64, y * view.height as f64)
    });
    Ok(tracer.check_light(rays, hits))
}

/// The rays that are followed for image position (x, y), in pixels from the top left corner.
///
/// Errors: as [`super::render`].
pub fn trace_paths(
    prepared: &Prepared,
    view: &View,
    quality: &Quality,
    [x, y]: [f64; 2],
) -> Result<Vec<PathSegment>> {
    let tables = prepared.tables(quality.grid)?;
    let tracer = Tracer { prepared, tables, limits: quality.limits };
    Ok(tracer.paths(view.camera().ray(x, y)))
}

/// Mean spectrum over a region of a view that is not taken: from so many rays, spread evenly.
///
/// `weight` is a factor for each image position. Two scenes see the same rays, so that their
/// difference is known better than either. Same inputs, same bits.
/// Errors: a region outside of the view; as [`super::render`].
pub fn mean_spectrum(
    prepared: &Prepared,
    view: &View,
    quality: &Quality,
    (region, rays): (Region, u32),
    weight: impl Fn([f64; 2]) -> f64 + Sync,
) -> Result<Vec<f64>> {
    region.check(view.width, view.height)?;
    let tables = prepared.tables(quality.grid)?;
    let tracer = Tracer { prepared, tables, limits: quality.limits };
    let camera = view.camera();
    let pattern = Pattern::of_pixel(0, 0);
    let spectrum = |ray: u32| {
        let [x, y] = pattern.place(ray);
        let x = region.x as f64 + x * region.width as f64;
        let y = region.y as f64 + y * region.height as f64;
        let mut sum = Bands::zero(tables.bands);
        tracer.trace(camera.ray(x, y), &mut TraceState::default(), &mut sum);
        let weight = weight([x, y]);
        sum.as_slice().iter().map(|value| value * weight).collect::<Vec<f64>>()
    };
    // Collected first: the sum's order, and so its bits, are then the same for any threads.
    let spectra: Vec<Vec<f64>> = (0..rays).into_par_iter().map(spectrum).collect();
    let band = |band: usize| spectra.iter().map(|s| s[band]).sum::<f64>() / f64::from(rays);
    Ok((0..tables.bands).map(band).collect())
}
