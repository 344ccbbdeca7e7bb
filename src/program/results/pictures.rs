//! What is read from pictures, and what made a folder of them.

use super::super::fields::{Fields, field};
use super::super::sweep::{RegionReading, SweepOutcome};
use super::super::uncertainty::{Budget, Contribution};
use crate::color::signal;
use crate::display::Developed;
use crate::image::difference::ImageDifference;
use crate::image::homogeneity::{Homogeneity, NoiseShare};

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
