//! Looks into a picture without taking it: the error of its light sums, and the rays of one place.

use super::Quality;
use super::pattern::Pattern;
use crate::error::Result;
use crate::scene::Prepared;
use crate::shading::{LightCheck, PathSegment, Tracer};
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
