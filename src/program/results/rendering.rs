//! What was asked of a render, and what it did and cost.

use super::super::fields::{Cell, Fields, field};
use crate::render::{Asked, Quality, RenderStats, Samples, TargetReport};
use crate::scene::BuildSeconds;
use crate::shading::{Layers, LightCheck, PathSegment, RayKind};
use crate::view::View;

/// Where a picture is taken from: the options' names.
pub const VIEW: Fields<View> = Fields {
    class: "View",
    fields: &[
        field("azimuth", "number", "", |view| view.azimuth_deg.into()),
        field("elevation", "number", "", |view| view.elevation_deg.into()),
        field("distance", "number", "", |view| view.distance_mm.into()),
        field("target", "vector", "", |view| view.target.into()),
        field("fov", "number", "", |view| view.fov_deg.into()),
        field("width", "integer", "", |view| view.width.into()),
        field("height", "integer", "", |view| view.height.into()),
    ],
};

/// What was asked of a picture: the options' names.
pub const ASKED: Fields<Asked> = Fields {
    class: "Quality",
    fields: &[
        field("samples", "integer|AdaptiveSamples", "", |asked| of_quality(asked, samples)),
        field("max_depth", "integer", "", |asked| of_quality(asked, |q| q.limits.max_depth)),
        field("min_throughput", "number", "", |asked| {
            of_quality(asked, |q| q.limits.min_throughput)
        }),
        field("light_error", "number", "", |asked| of_quality(asked, |q| q.limits.light_error)),
        field("dispersion", "integer", "", |asked| of_quality(asked, |q| q.limits.dispersion)),
        field("wavelength_step", "number", "", |asked| of_quality(asked, |q| q.grid.step_nm())),
        field("layers", "\"lights\"|\"paths\"", "", |asked| of_quality(asked, layers)),
        field("target_error", "number", "", |asked| match asked {
            Asked::TargetError(target) => (*target).into(),
            Asked::Quality(_) => Cell::Nothing,
        }),
    ],
};

fn of_quality<T: Into<Cell>>(asked: &Asked, value: impl Fn(&Quality) -> T) -> Cell {
    match asked {
        Asked::Quality(quality) => value(quality).into(),
        Asked::TargetError(_) => Cell::Nothing,
    }
}

fn layers(quality: &Quality) -> Cell {
    match quality.layers {
        Layers::None => Cell::Nothing,
        Layers::Lights => "lights".into(),
        Layers::Paths => "paths".into(),
    }
}

fn samples(quality: &Quality) -> Cell {
    match quality.samples {
        Samples::Fixed(count) => count.into(),
        Samples::Adaptive { min, max, error } => {
            Cell::Record(vec![("min", min.into()), ("max", max.into()), ("error", error.into())])
        }
        Samples::Lit { max, error } => {
            Cell::Record(vec![("max", max.into()), ("lit_error", error.into())])
        }
    }
}

/// What a render did, as it is in every run.
pub const STATS: Fields<RenderStats> = Fields {
    class: "Stats",
    fields: &[
        field("camera_rays", "integer", "", |stats| stats.counts.camera_rays.into()),
        field("mirror_rays", "integer", "", |stats| stats.counts.mirror_rays.into()),
        field("transmitted_rays", "integer", "", |stats| stats.counts.transmitted_rays.into()),
        field("shadow_rays", "integer", "", |stats| stats.counts.shadow_rays.into()),
        field(
            "rays_cut",
            "integer",
            "that ended at max_depth with more than 1 % of their light",
            |stats| stats.counts.rays_cut.into(),
        ),
        field(
            "light_sums",
            "integer",
            "one for each side of a hit and light that shine",
            |stats| stats.counts.light_sums.into(),
        ),
        field("nodes_per_sum", "number", "of light trees", |stats| {
            per_sum(stats, stats.counts.light_nodes)
        }),
        field("samples_per_sum", "number", "of lights", |stats| {
            per_sum(stats, stats.counts.light_samples)
        }),
        field("light_error", "number", "of mean luminance by the light sums, relative", |stats| {
            stats.mean_light_error.into()
        }),
        field("largest_light_error", "number", "of a pixel, relative", |stats| {
            stats.largest_light_error.into()
        }),
        field(
            "interreflection_error",
            "number?",
            "of the light that bounces, from the number of its samples",
            |stats| stats.interreflection_error.into(),
        ),
        field("target", "TargetReport", "what target_error chose; nil without", |stats| {
            stats.target.map(|report| TARGET.record(&report)).into()
        }),
    ],
};

fn per_sum(stats: &RenderStats, count: u64) -> Cell {
    (count as f64 / stats.counts.light_sums.max(1) as f64).into()
}

/// What a render cost, which differs from run to run.
pub struct Cost {
    /// Time of rendering, s.
    pub seconds: f64,
    /// Time of rendering as thought after the first samples, s; `None` without `target_error`.
    pub expected_seconds: Option<f64>,
    /// Time of preparing the scene.
    pub build: BuildSeconds,
    /// Largest memory of the program so far, MB of 10⁶ bytes; `None` where the system does not tell.
    pub peak_memory_mb: Option<f64>,
}

/// What a render cost.
pub const COST: Fields<Cost> = Fields {
    class: "Cost",
    fields: &[
        field("seconds", "number", "of rendering", |cost| cost.seconds.into()),
        field(
            "expected_seconds",
            "number",
            "of rendering, as thought after the first samples; nil without target_error",
            |cost| cost.expected_seconds.into(),
        ),
        field("bvh_seconds", "number", "of building the scene's BVH", |cost| cost.build.bvh.into()),
        field("light_tree_seconds", "number", "of building its light trees", |cost| {
            cost.build.light_trees.into()
        }),
        field("peak_memory_mb", "number", "of the program so far", |cost| {
            cost.peak_memory_mb.into()
        }),
    ],
};

/// What `target_error` chose, and the errors that it estimates.
pub const TARGET: Fields<TargetReport> = Fields {
    class: "TargetReport",
    fields: &[
        field(
            "error",
            "number",
            "estimated, relative rms of luminance over lit pixels",
            |report| report.error().into(),
        ),
        field("reached", "boolean", "whether the error is within the target", |report| {
            report.is_reached().into()
        }),
        field("sampling_error", "number", "its share of camera rays", |report| {
            report.sampling_error.into()
        }),
        field("light_sum_error", "number", "its share of light sums", |report| {
            report.light_sum_error.into()
        }),
        field(
            "truncation_error",
            "number",
            "its share of max_depth and min_throughput",
            |report| report.truncation_error.into(),
        ),
        field("samples", "number", "mean of a pixel", |report| report.mean_samples.into()),
        field("most_samples", "integer", "of a pixel", |report| report.most_samples.into()),
        field("max_depth", "integer", "chosen", |report| report.limits.max_depth.into()),
        field("min_throughput", "number", "chosen", |report| report.limits.min_throughput.into()),
        field("light_error", "number", "chosen", |report| report.limits.light_error.into()),
        field("wavelength_step", "number", "nm", |report| report.grid.step_nm().into()),
    ],
};

/// How far light sums are from exact ones.
pub const LIGHT_CHECK: Fields<LightCheck> = Fields {
    class: "LightCheck",
    fields: &[
        field(
            "sums",
            "integer",
            "compared: one for each side of a hit and light that shine",
            |c| c.sums.into(),
        ),
        field("median", "number", "of the relative errors", |check| check.median.into()),
        field("percentile_95", "number", "", |check| check.percentile_95.into()),
        field("largest", "number", "", |check| check.largest.into()),
        field("largest_of_estimate", "number", "largest ratio of an error to its estimate", |c| {
            c.largest_of_estimate.into()
        }),
        field(
            "speedup",
            "number",
            "time of the exact sums over that of these; some thousand hits make it reliable",
            |check| check.speedup.into(),
        ),
    ],
};

/// A ray of an image position.
pub const PATH: Fields<PathSegment> = Fields {
    class: "PathSegment",
    fields: &[
        field("kind", "\"camera\"|\"mirrored\"|\"transmitted\"", "", |segment| {
            match segment.kind {
                RayKind::Camera => "camera",
                RayKind::Mirrored => "mirrored",
                RayKind::Transmitted => "transmitted",
            }
            .into()
        }),
        field("depth", "integer", "0 for the camera's", |segment| segment.depth.into()),
        field("start", "vector", "mm", |segment| segment.start.into()),
        field("direction", "vector", "", |segment| segment.direction.into()),
        field("throughput", "number", "mean over the bands", |segment| segment.throughput.into()),
        field("finish", "vector", "mm; nil where it hits nothing", |segment| {
            segment.end.map(|end| end.point).into()
        }),
        field("normal", "vector", "of the surface that it hits", |segment| {
            segment.end.map(|end| end.normal).into()
        }),
        field("object", "integer", "of the scene, 1-based", |segment| {
            segment.end.map(|end| end.object + 1).into()
        }),
    ],
};
