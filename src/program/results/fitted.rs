//! What was fitted to measurements, and held against them.

use super::super::fields::{Fields, field};
use super::super::intensity::PointCheck;
use crate::display::{ChannelFit, Curve, PatchError, Verification};
use crate::material::{FittedLobe, LobeFit};

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
