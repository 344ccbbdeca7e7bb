//! Why is it black? A sentence about a picture without light.

use super::pattern::Pattern;
use crate::error::Result;
use crate::geometry::{DVec3, Ray};
use crate::image::SpectralImage;
use crate::scene::{Light, Prepared, Shadows};
use crate::shading::{Darkness, TraceLimits, Tracer};
use crate::spectrum::WavelengthGrid;
use crate::view::View;

/// Camera rays that are followed, spread over the picture.
const RAYS: u32 = 200;

/// Limits that a picture is asked with when its own show nothing.
const WIDE: TraceLimits =
    TraceLimits { max_depth: 16, min_throughput: 1e-5, light_error: 0.1, dispersion: 1 };

/// Why `image`, of this view, holds no light at all; `None` if it does.
///
/// Errors: as [`super::render`].
pub fn why_black(
    image: &SpectralImage,
    prepared: &Prepared,
    view: &View,
    limits: TraceLimits,
) -> Result<Option<String>> {
    if image.bands.iter().any(|&value| value > 0.0) {
        return Ok(None);
    }
    let question = Question { prepared, view, grid: image.grid, limits };
    let reason = match question.of_scene() {
        Some(reason) => reason,
        None => question.of_rays()?,
    };
    Ok(Some(format!("the picture is black: {reason}")))
}

struct Question<'a> {
    prepared: &'a Prepared,
    view: &'a View,
    grid: WavelengthGrid,
    limits: TraceLimits,
}

impl Question<'_> {
    /// What needs no ray.
    fn of_scene(&self) -> Option<String> {
        let scene = &self.prepared.scene;
        if scene.objects.is_empty() {
            return Some("the scene has no objects".to_owned());
        }
        let is_dark = |light: &Light| light.rays.samples.is_empty() || light.rays.flux_lm <= 0.0;
        if scene.ambient.max() <= 0.0 && scene.lights.iter().all(is_dark) {
            let what = if scene.lights.is_empty() { "no lights" } else { "only lights of 0 lm" };
            return Some(format!("the scene has {what}, and no ambient light"));
        }
        self.of_view()
    }

    /// Whether all objects lie behind the eye.
    fn of_view(&self) -> Option<String> {
        let (low, high) = self.prepared.bvh.bounds()?;
        let eye = self.view.camera().ray(0.0, 0.0).origin;
        let [x, y] = [self.view.width, self.view.height].map(|pixels| pixels as f64 / 2.0);
        let forward = self.view.camera().ray(x, y).direction;
        let corner = |k: usize| {
            let pick = |bit: usize, low: f64, high: f64| if k >> bit & 1 == 0 { low } else { high };
            DVec3::new(pick(0, low.x, high.x), pick(1, low.y, high.y), pick(2, low.z, high.z))
        };
        let is_behind = (0..8).all(|k| (corner(k) - eye).dot(forward) < 0.0);
        is_behind.then(|| {
            format!("all objects are behind the eye, which is at {eye:.1} mm and looks along {forward:.2}")
        })
    }

    fn rays(&self) -> impl Iterator<Item = Ray> {
        let (camera, pattern) = (self.view.camera(), Pattern::of_pixel(0, 0));
        let [width, height] = [self.view.width, self.view.height].map(|pixels| pixels as f64);
        (0..RAYS).map(move |i| {
            let [x, y] = pattern.place(i);
            camera.ray(x * width, y * height)
        })
    }

    fn is_lit_with(&self, limits: TraceLimits) -> Result<bool> {
        let tables = self.prepared.tables(self.grid)?;
        Ok(Tracer { prepared: self.prepared, tables, limits }.is_lit_along(self.rays()))
    }

    /// What rays within wider limits bring back, or else what they meet.
    fn of_rays(&self) -> Result<String> {
        let TraceLimits { max_depth, min_throughput, .. } = self.limits;
        let wide = TraceLimits {
            max_depth: max_depth.max(WIDE.max_depth),
            min_throughput: min_throughput.min(WIDE.min_throughput),
            ..WIDE
        };
        if self.is_lit_with(wide)? {
            let deep = TraceLimits { min_throughput, ..wide };
            if self.is_lit_with(self.limits)? {
                return Ok(
                    "the rays of its pixels miss what little is lit: more pixels or samples show \
                           it"
                    .to_owned(),
                );
            }
            return Ok(if self.is_lit_with(deep)? {
                format!("every path to the light is longer than max_depth = {max_depth}")
            } else {
                format!("every path to the light is cut by min_throughput = {min_throughput}")
            });
        }
        let tables = self.prepared.tables(self.grid)?;
        let tracer = Tracer { prepared: self.prepared, tables, limits: self.limits };
        Ok(self.of_hits(&tracer.darkness(self.rays())))
    }

    fn of_hits(&self, found: &Darkness) -> String {
        let hits = found.hits;
        if found.seen == 0 {
            return self.of_misses();
        }
        if found.shut > 0 && found.shut + found.dead >= found.seen {
            return "a material has a transmittance, but k_tg = 0 (the default): it lets nothing through"
                .to_owned();
        }
        if found.dead == hits {
            return "the materials return nothing: k_d = k_s = k_rg = 0 (the defaults) wherever a ray \
                    arrives"
                .to_owned();
        }
        if found.dead + found.without_reflectance >= hits {
            return "the materials return nothing: their reflectance is 0 (the default)".to_owned();
        }
        if found.reached > 0 && self.prepared.scene.shadows == Shadows::On {
            return format!(
                "shadows: at {} of {} hits light would arrive, but opaque surfaces are in its way",
                found.reached, found.asked
            );
        }
        if found.backs == found.seen {
            return format!(
                "all {} rays that meet a surface meet its back: the eye is inside of a mesh, or its \
                 triangles wind the wrong way",
                found.seen
            );
        }
        if found.asked == 0 {
            return "no hit asks the lights: where lobes are (k_d, k_s), the reflectance is 0, or the hit \
                    is on the far side"
                .to_owned();
        }
        if found.faced == 0 {
            return format!(
                "all light samples face away from the {} places that were asked",
                found.asked
            );
        }
        format!(
            "light arrives only from behind the surfaces, or outside of their lobes, at all {} places \
             that were asked",
            found.asked
        )
    }

    fn of_misses(&self) -> String {
        let Some((low, high)) = self.prepared.bvh.bounds() else {
            return "no object has a triangle".to_owned();
        };
        let size_mm = (high - low).length();
        let camera = self.view.camera();
        let [x, y] = [self.view.width, self.view.height].map(|pixels| pixels as f64 / 2.0);
        let (middle, next) = (camera.ray(x, y), camera.ray(x, y + 1.0));
        let way = (low + high) / 2.0 - middle.origin;
        let pixel_mm = way.length() * middle.direction.angle_between(next.direction);
        if size_mm < pixel_mm {
            return format!(
                "no ray meets a surface: the objects are {size_mm:.1} mm across, a pixel \
                 {pixel_mm:.1} mm there"
            );
        }
        format!(
            "no ray meets a surface: the view looks past the objects, which lie between {low:.1} and \
             {high:.1} mm"
        )
    }
}
