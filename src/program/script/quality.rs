//! The options of a picture's quality, for all that renders.

use mlua::Value;

use super::host::Host;
use super::kinds::{Choice, Count, Custom, Kind, Number, Or, nested};
use super::options::{self, Options, Range};
use super::record::{Record, options};
use super::spectrum::STEP;
use crate::error::Error;
use crate::render::{Asked, Quality, RenderStats, Samples};
use crate::shading::{Layers, TraceLimits};
use crate::spectrum::WavelengthGrid;

const MAX_SAMPLES_A_PIXEL: u64 = 1_000_000;

options! {
    struct QualityOptions {
        /// of a pixel; 1 is its center
        samples: Samples = SAMPLES.or(Quality::default().samples),
        /// instead of all others: relative rms error of luminance over lit pixels
        target_error: Option<f64> = Number(Range::between(0.0, 1.0, "")).optional(""),
        /// bound on the relative error of the sum over light samples; 0 is the exact sum
        light_error: f64 = light_error(),
        /// parts that the picture keeps: for each light, or direct, mirrored and transmitted light
        layers: Option<Layers> = Choice(&[("lights", Layers::Lights), ("paths", Layers::Paths)])
            .optional("none"),
        ..trace: TraceOptions,
    }
}

options! {
    /// How far rays are followed.
    struct TraceOptions {
        max_depth: u32 = DEPTH.or(Quality::default().limits.max_depth),
        min_throughput: f64 =
            Number(Range::RATIO).or(Quality::default().limits.min_throughput),
        /// directions into which a ray splits where ior depends on the wavelength; 1 does not split
        dispersion: u32 = Count::new(1, 81).or(1),
        wavelength_step: WavelengthGrid = STEP.or(Quality::default().grid),
    }
}

options! {
    struct AdaptiveSamples {
        min: u32 = Count::new(2, MAX_SAMPLES_A_PIXEL).or(4),
        /// not below min
        max: Option<u32> = Count::new(2, MAX_SAMPLES_A_PIXEL).optional("256, or min if that is more"),
        /// relative standard error of a pixel's luminance
        error: f64 = Number(Range::above_zero("")).or(0.01),
    }
}

/// A count, or `"auto"`: as deep as `min_throughput` lets a ray go.
const DEPTH: Custom<u32> = Custom {
    lua_type: "integer|\"auto\"",
    allowed: "0 to 10000",
    read: |object, what, value| {
        if value.is_string() {
            let auto = [("auto", TraceLimits::ANY_DEPTH)];
            return options::choice(object, what, &options::text(object, what, value)?, &auto);
        }
        let most = TraceLimits::ANY_DEPTH.into();
        options::count(object, what, value, 0, most).map(|depth| depth as u32)
    },
    shown: u32::to_string,
};

/// Largest error of the sum over light samples.
pub(super) fn light_error() -> Or<Number> {
    Number(Range::RATIO).or(Quality::default().limits.light_error)
}

/// The options of a quality, in an option.
pub(super) const QUALITY: Custom<Asked> = Custom {
    lua_type: "QualityOptions",
    allowed: "",
    read: |object, what, value| asked(&nested(object, what), value.clone()),
    shown: |_| String::new(),
};

/// `target_error`, or the settings that it would choose.
///
/// Errors: both; keys and ranges.
pub(super) fn asked(object: &str, value: Value) -> mlua::Result<Asked> {
    let options = Options::new(object, value, &QualityOptions::keys())?;
    let given = QualityOptions::from_options(&options)?;
    let Some(target) = given.target_error else {
        let quality = given.trace.quality(given.light_error);
        let layers = given.layers.unwrap_or_default();
        return Ok(Asked::Quality(Quality { samples: given.samples, layers, ..quality }));
    };
    for key in QualityOptions::keys() {
        if key != "target_error" && options.has(key)? {
            let problem = format!("\"target_error\" chooses \"{key}\": give one of the two");
            return Err(Error::inconsistent(object, problem).into());
        }
    }
    Ok(Asked::TargetError(target))
}

pub(super) fn warn_of_target(host: &Host, stats: &RenderStats) {
    if let Some(report) = stats.target.filter(|report| !report.is_reached()) {
        host.warn(report.to_string());
    }
    stats.counts.warnings().into_iter().for_each(|warning| host.warn(warning));
}

impl TraceOptions {
    /// With the samples of the default.
    pub(super) fn quality(&self, light_error: f64) -> Quality {
        let Self { max_depth, min_throughput, dispersion, wavelength_step: grid } = *self;
        let limits = TraceLimits { max_depth, min_throughput, light_error, dispersion };
        Quality { limits, grid, ..Quality::default() }
    }
}

const SAMPLES: Custom<Samples> = Custom {
    lua_type: "integer|AdaptiveSamples",
    allowed: "1 to 1000000",
    read: samples,
    shown: |samples| match samples {
        Samples::Fixed(count) => count.to_string(),
        Samples::Adaptive { .. } | Samples::Lit { .. } => String::new(),
    },
};

/// A count, or `{min =, max =, error =}`.
fn samples(object: &str, what: &str, value: &Value) -> mlua::Result<Samples> {
    if !value.is_table() {
        let count = options::count(object, what, value, 1, MAX_SAMPLES_A_PIXEL)?;
        return Ok(Samples::Fixed(count as u32));
    }
    let object = nested(object, what);
    let AdaptiveSamples { min, max, error } = AdaptiveSamples::read(&object, value.clone())?;
    let max = f64::from(max.unwrap_or(256.max(min)));
    let max = options::whole(&object, "\"max\"", max, min.into(), MAX_SAMPLES_A_PIXEL)? as u32;
    Ok(Samples::Adaptive { min, max, error })
}
