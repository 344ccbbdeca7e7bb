//! The fields of every record that scripts and manifests read.

use std::sync::Arc;

use super::fields::{Cell, Fields, field};
use super::intensity::PointCheck;
use super::sweep::{RegionReading, SweepOutcome};
use super::uncertainty::{Budget, Contribution};
use crate::color::signal;
use crate::display::{ChannelFit, Curve, Developed, PatchError, Verification};
use crate::geometry::import::MeshFile;
use crate::geometry::{Closure, DVec3, Mesh};
use crate::image::difference::ImageDifference;
use crate::image::homogeneity::{Homogeneity, NoiseShare};
use crate::material::{FittedLobe, LobeFit};
use crate::render::{Asked, Quality, RenderStats, Samples, TargetReport};
use crate::scene::BuildSeconds;
use crate::shading::Layers;
use crate::shading::{LightCheck, PathSegment, RayKind};
use crate::source::surface_fit::{FittedSurface, SurfaceFit};
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

/// How far an image is from a reference.
pub const DIFFERENCE: Fields<ImageDifference> = Fields {
    class: "ImageDifference",
    fields: &[
        field("lit_pixels", "integer", "which all but spectral_rms are about", |d| {
            d.lit_pixels.into()
        }),
        field("relative_rms", "number", "of luminance", |d| d.relative_rms.into()),
        field("worst", "number", "relative, of a pixel's luminance", |d| d.worst.into()),
        field("mean_delta_e_2000", "number", "", |d| d.mean_delta_e_2000.into()),
        field("percentile_95_delta_e_2000", "number", "", |d| d.percentile_95_delta_e_2000.into()),
        field("spectral_rms", "number", "relative to the rms of the reference", |d| {
            d.spectral_rms.into()
        }),
    ],
};

/// What a picture shows, with standard uncertainties.
pub const BUDGET: Fields<Budget> = Fields {
    class: "UncertaintyBudget",
    fields: &[
        field("Y", "number", "luminance of the region", |b| b.values[0].into()),
        field("x", "number", "", |b| b.values[1].into()),
        field("y", "number", "", |b| b.values[2].into()),
        field("I", "number", "intensity of the image, cd; 0 where it has none", |b| {
            b.values[3].into()
        }),
        field("u_Y", "number", "combined standard uncertainty", |b| b.u[0].into()),
        field("u_x", "number", "", |b| b.u[1].into()),
        field("u_y", "number", "", |b| b.u[2].into()),
        field("u_I", "number", "", |b| b.u[3].into()),
        field("budget", "UncertaintyContribution[]", "by input, the largest u_Y first", |b| {
            CONTRIBUTION.list(&b.contributions)
        }),
    ],
};

/// What one input adds to the uncertainties.
pub const CONTRIBUTION: Fields<Contribution> = Fields {
    class: "UncertaintyContribution",
    fields: &[
        field("input", "string", "", |c| c.name.as_str().into()),
        field("u_Y", "number", "from this input alone", |c| c.u[0].into()),
        field("u_x", "number", "", |c| c.u[1].into()),
        field("u_y", "number", "", |c| c.u[2].into()),
        field("u_I", "number", "", |c| c.u[3].into()),
    ],
};

/// How even a region is.
pub const HOMOGENEITY: Fields<Homogeneity> = Fields {
    class: "Homogeneity",
    fields: &[
        field("mean", "number", "luminance", |h| h.evenness.mean.into()),
        field("min", "number", "luminance of the darkest cell", |h| h.evenness.min.into()),
        field("max", "number", "luminance of the brightest cell", |h| h.evenness.max.into()),
        field("contrast", "number", "RMS: standard deviation of the cells over their mean", |h| {
            h.evenness.contrast.into()
        }),
        field("uniformity", "number", "darkest over brightest cell", |h| {
            h.evenness.uniformity.into()
        }),
        field(
            "gradient",
            "number",
            "largest step between cells side by side, over the mean",
            |h| h.evenness.gradient.into(),
        ),
        field("cells", "integer[]", "columns and rows", |h| h.cells.into()),
        field(
            "rays",
            "NoiseShare?",
            "noise from the number of light rays; nil without halves",
            |h| h.rays.map(|share| NOISE_SHARE.record(&share)).into(),
        ),
        field(
            "samples",
            "NoiseShare?",
            "noise from the number of camera rays; nil unless samples are adaptive",
            |h| h.samples.map(|share| NOISE_SHARE.record(&share)).into(),
        ),
    ],
};

/// Standard errors of figures of evenness.
pub const NOISE_SHARE: Fields<NoiseShare> = Fields {
    class: "NoiseShare",
    fields: &[
        field("noise", "number", "RMS contrast that it makes on an even surface", |share| {
            share.noise.into()
        }),
        field("mean", "number", "standard error", |share| share.error.mean.into()),
        field("min", "number", "likewise", |share| share.error.min.into()),
        field("max", "number", "likewise", |share| share.error.max.into()),
        field("contrast", "number", "likewise, with what noise adds", |share| {
            share.error.contrast.into()
        }),
        field("uniformity", "number", "standard error", |share| share.error.uniformity.into()),
        field("gradient", "number", "likewise", |share| share.error.gradient.into()),
    ],
};

/// What was done to a picture's light for its display.
pub const DEVELOPED: Fields<Developed> = Fields {
    class: "PngReport",
    fields: &[
        field("glare_lost", "number", "share of the light scattered out of the frame", |shown| {
            shown.glare.map(|glare| glare.lost_share).into()
        }),
        field(
            "exposure",
            "number",
            "factor from the image's XYZ to the display's cd/m²",
            |shown| shown.picture.exposure_factor.into(),
        ),
        field("outside_gamut", "integer", "pixels that the display cannot show", |shown| {
            shown.picture.gamut.outside().into()
        }),
        field("too_dark", "integer", "pixels darker than its black", |shown| {
            shown.picture.gamut.too_dark.into()
        }),
        field("too_bright", "integer", "pixels brighter than its white", |shown| {
            shown.picture.gamut.too_bright.into()
        }),
        field("too_saturated", "integer", "pixels outside of its primaries", |shown| {
            shown.picture.gamut.too_saturated.into()
        }),
        field("mean_delta_e_2000", "number", "", |shown| {
            shown.picture.gamut.mean_delta_e_2000.into()
        }),
        field("max_delta_e_2000", "number", "", |shown| {
            shown.picture.gamut.max_delta_e_2000.into()
        }),
    ],
};

/// The light of a region that the script names.
pub const READING: Fields<RegionReading> = Fields {
    class: "Reading",
    fields: &[
        field("x", "integer", "pixels from the left", |reading| reading.region.x.into()),
        field("y", "integer", "pixels from the top", |reading| reading.region.y.into()),
        field("width", "integer", "pixels", |reading| reading.region.width.into()),
        field("height", "integer", "pixels", |reading| reading.region.height.into()),
        field("luminance", "number", "", |reading| reading.xyz.y.into()),
        field("chromaticity", "number[]", "", |reading| reading.xyz.chromaticity().into()),
        field("color", "string", "of signal lights", |reading| {
            let color = reading.xyz.chromaticity().and_then(signal::color_of);
            color.map(|color| color.name()).into()
        }),
        field("wavelength_step", "number", "nm", |reading| reading.grid.step_nm().into()),
        field("spectrum", "number[]", "mean of each band", |reading| reading.bands.clone().into()),
    ],
};

/// What a sweep did.
pub const SWEPT: Fields<SweepOutcome> = Fields {
    class: "SweepReport",
    fields: &[
        field("views", "integer", "rendered and kept", |done| (done.rendered + done.kept).into()),
        field("rendered", "integer", "", |done| done.rendered.into()),
        field("kept", "integer", "that were there already", |done| done.kept.into()),
    ],
};

/// How a channel's curve is, and how well it was fitted.
pub const CHANNEL: Fields<(Curve, Option<ChannelFit>)> = Fields {
    class: "DisplayChannel",
    fields: &[
        field("gain", "number", "k_g", |(curve, _)| curve.gain.into()),
        field("offset", "number", "k_o", |(curve, _)| curve.offset.into()),
        field("gamma", "number", "", |(curve, _)| curve.gamma.into()),
        field("gain_error", "number?", "standard error; nil unless the display was fitted", |c| {
            c.1.as_ref().map(|fit| fit.gain_error).into()
        }),
        field("gamma_error", "number?", "", |c| c.1.as_ref().map(|fit| fit.gamma_error).into()),
        field("rms", "number?", "relative to the channel's maximum", |c| {
            c.1.as_ref().map(|fit| fit.rms).into()
        }),
    ],
};

/// A measured patch, and what the display's model says of it.
pub const PATCH: Fields<PatchError> = Fields {
    class: "PatchError",
    fields: &[
        field("digits", "number[]", "{r, g, b}", |error| error.patch.digits.into()),
        field("measured", "number[]", "{X, Y, Z}, cd/m²", |error| error.patch.measured.into()),
        field("predicted", "number[]", "{X, Y, Z}, cd/m²", |error| error.predicted.into()),
        field("delta_e_ab", "number", "", |error| error.delta_e_ab.into()),
        field("delta_e_2000", "number", "", |error| error.delta_e_2000.into()),
        field("lightness_error", "number", "", |error| error.lightness_error.into()),
    ],
};

/// How well a display's model predicts measured patches.
pub const VERIFICATION: Fields<Verification> = Fields {
    class: "Verification",
    fields: &[
        field("mean", "number", "ΔE*ab", |verification| verification.mean.into()),
        field("max", "number", "ΔE*ab", |verification| verification.max.into()),
        field("mean_2000", "number", "ΔE00", |verification| verification.mean_2000.into()),
        field("max_2000", "number", "ΔE00", |verification| verification.max_2000.into()),
        field("patches", "PatchError[]", "", |v| PATCH.list(&v.patches)),
        field("worst", "PatchError[]", "ten at most, the worst first", |verification| {
            /// As many as a person looks at.
            const WORST: usize = 10;
            PATCH.list(&verification.worst(WORST))
        }),
        field("verdict", "string", "in words", |v| v.verdict.to_string().as_str().into()),
    ],
};

/// A lobe A cosⁿ, fitted.
pub const LOBE: Fields<FittedLobe> = Fields {
    class: "FittedLobe",
    fields: &[
        field("n", "number", "the exponent", |lobe| lobe.n.into()),
        field("n_error", "number", "standard error", |lobe| lobe.n_error.into()),
        field("amplitude", "number", "", |lobe| lobe.amplitude.into()),
        field("amplitude_error", "number", "standard error", |lobe| lobe.amplitude_error.into()),
    ],
};

/// A fitted sum of lobes.
pub const LOBE_FIT: Fields<LobeFit> = Fields {
    class: "LobeFit",
    fields: &[
        field("lobes", "FittedLobe[]", "", |fit| LOBE.list(&fit.lobes)),
        field("rms", "number", "of the deviations", |fit| fit.rms.into()),
        field("rms_decades", "number", "of those of log₁₀", |fit| fit.rms_decades.into()),
        field("points", "integer", "in the range", |fit| fit.points.into()),
    ],
};

/// What a lamp has in one of its regulation's directions.
pub const POINT: Fields<PointCheck> = Fields {
    class: "PointCheck",
    fields: &[
        field("h", "number", "degrees", |check| check.requirement.direction.h_deg.into()),
        field("v", "number", "degrees", |check| check.requirement.direction.v_deg.into()),
        field("min", "number?", "cd", |check| check.requirement.min_cd.into()),
        field("max", "number?", "cd", |check| check.requirement.max_cd.into()),
        field("intensity", "number?", "cd; nil where the grid does not reach", |check| {
            check.intensity_cd.into()
        }),
        field("color", "string?", "of signal lights", |check| {
            check.color.map(|color| color.name()).into()
        }),
        field("pass", "boolean", "", |check| check.passes.into()),
    ],
};

/// A ray where it is in the scene.
pub struct WorldRay {
    /// Where it starts, mm.
    pub position: DVec3,
    /// Unit vector.
    pub direction: DVec3,
    /// Luminous flux, lm.
    pub flux_lm: f64,
}

/// A ray of a set.
pub const RAY: Fields<WorldRay> = Fields {
    class: "Ray",
    fields: &[
        field("position", "vector", "mm", |ray| ray.position.into()),
        field("direction", "vector", "", |ray| ray.direction.into()),
        field("flux", "number", "lm", |ray| ray.flux_lm.into()),
    ],
};

/// A mesh, and the names of its file's parts that have faces.
#[derive(Debug, Clone)]
pub struct NamedMesh {
    /// In the coordinates of its own, mm.
    pub mesh: Arc<Mesh>,
    /// Groups of the file.
    pub groups: Arc<[String]>,
    /// Objects of the file.
    pub objects: Arc<[String]>,
    /// Materials of the file.
    pub materials: Arc<[String]>,
}

/// A mesh that is from no file.
impl From<Mesh> for NamedMesh {
    fn from(mesh: Mesh) -> Self {
        let none = || Arc::from([]);
        Self { mesh: Arc::new(mesh), groups: none(), objects: none(), materials: none() }
    }
}

impl From<MeshFile> for NamedMesh {
    fn from(file: MeshFile) -> Self {
        Self {
            mesh: Arc::new(file.mesh),
            groups: file.groups.into(),
            objects: file.objects.into(),
            materials: file.materials.into(),
        }
    }
}

/// A mesh, as scripts and `lampyris info` show it.
pub const MESH: Fields<NamedMesh> = Fields {
    class: "Mesh",
    fields: &[
        field("triangle_count", "integer", "", |named| named.mesh.triangles.len().into()),
        field("bounds", "vector[]", "lowest and highest corner, mm", |named| {
            named.mesh.bounds().into()
        }),
        field("area", "number", "mm²", |named| named.mesh.area_mm2().into()),
        field(
            "volume",
            "number",
            "mm³, of a closed mesh; negative if its fronts are inside",
            |named| named.mesh.volume_mm3().into(),
        ),
        field("open_edges", "integer", "0: the mesh is closed", |named| {
            Closure::of(&named.mesh).open_edges.into()
        }),
        field("groups", "string[]", "names of the file's groups that have faces", |named| {
            named.groups.to_vec().into()
        }),
        field("objects", "string[]", "names of its objects that have faces", |named| {
            named.objects.to_vec().into()
        }),
        field("materials", "string[]", "names of its materials that have faces", |named| {
            named.materials.to_vec().into()
        }),
    ],
};

/// What start points lie on, in the set's own coordinates, and whether it is the source's.
pub const START_SURFACE: Fields<(SurfaceFit, bool)> = Fields {
    class: "FittedSurface",
    fields: &[
        field("kind", "\"point\"|\"sphere\"|\"cylinder\"|\"plane\"", "", |(fit, _)| {
            match fit.surface {
                FittedSurface::Point { .. } => "point",
                FittedSurface::Sphere { .. } => "sphere",
                FittedSurface::Cylinder { .. } => "cylinder",
                FittedSurface::Plane { .. } => "plane",
            }
            .into()
        }),
        field("center", "vector", "mm", |(fit, _)| {
            match fit.surface {
                FittedSurface::Point { at } => at,
                FittedSurface::Sphere { center, .. } => center,
                FittedSurface::Cylinder { through, .. } | FittedSurface::Plane { through, .. } => {
                    through
                }
            }
            .into()
        }),
        field("axis", "vector?", "of a cylinder", |(fit, _)| match fit.surface {
            FittedSurface::Cylinder { axis, .. } => axis.into(),
            _ => Cell::Nothing,
        }),
        field("normal", "vector?", "of a plane", |(fit, _)| match fit.surface {
            FittedSurface::Plane { normal, .. } => normal.into(),
            _ => Cell::Nothing,
        }),
        field("radius", "number?", "mm; of a plane: that all starts are within", |(fit, _)| {
            match fit.surface {
                FittedSurface::Point { .. } => Cell::Nothing,
                FittedSurface::Sphere { radius_mm, .. }
                | FittedSurface::Cylinder { radius_mm, .. }
                | FittedSurface::Plane { radius_mm, .. } => radius_mm.into(),
            }
        }),
        field("length", "number?", "mm, of a cylinder", |(fit, _)| match fit.surface {
            FittedSurface::Cylinder { length_mm, .. } => length_mm.into(),
            _ => Cell::Nothing,
        }),
        field("rms", "number", "distance of the starts that it explains, mm", |(fit, _)| {
            fit.rms_mm.into()
        }),
        field("share", "number", "of the starts that it explains, 0 to 1", |(fit, _)| {
            fit.share.into()
        }),
        field("is_source", "boolean", "false where the rays come from inside of it", |c| {
            c.1.into()
        }),
    ],
};
