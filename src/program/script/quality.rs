//! The options of a picture's quality, for all that renders.

use mlua::Value;

use super::host::Host;
use super::options::{self, Options, Range};
use super::spectrum::grid_from_step;
use crate::error::Error;
use crate::render::{Asked, Quality, RenderStats, Samples};

pub(super) const ASKED_KEYS: [&str; 6] =
    ["light_error", "max_depth", "min_throughput", "samples", "target_error", "wavelength_step"];

const MAX_SAMPLES_A_PIXEL: u64 = 1_000_000;

/// `target_error`, or the settings that it would choose.
///
/// Errors: both; keys and ranges.
pub(super) fn asked(options: Options) -> mlua::Result<Asked> {
    let target = options.number("target_error", Range::between(0.0, 1.0, ""))?;
    let Some(target) = target else {
        return quality(options).map(Asked::Quality);
    };
    for key in ASKED_KEYS {
        if key != "target_error" && options.has(key)? {
            let problem = format!("\"target_error\" chooses \"{key}\": give one of the two");
            return Err(Error::inconsistent(options.object(), problem).into());
        }
    }
    Ok(Asked::TargetError(target))
}

pub(super) fn warn_of_target(host: &Host, stats: &RenderStats) {
    if let Some(report) = stats.target.filter(|report| !report.is_reached()) {
        host.warn(report.to_string());
    }
}

/// Errors: keys and ranges of the quality options.
pub(super) fn quality(options: Options) -> mlua::Result<Quality> {
    let mut quality = Quality::default();
    let limits = &mut quality.limits;
    if let Some(depth) = options.count("max_depth", 0, 1000)? {
        limits.max_depth = depth as u32;
    }
    limits.min_throughput =
        options.number_or("min_throughput", Range::RATIO, limits.min_throughput)?;
    limits.light_error = options.number_or("light_error", Range::RATIO, limits.light_error)?;
    if options.has("wavelength_step")? {
        let value = options.value("wavelength_step")?;
        quality.grid = grid_from_step(options.object(), "\"wavelength_step\"", &value)?;
    }
    quality.samples = samples(&options, quality.samples)?;
    Ok(quality)
}

/// A count, or `{min =, max =, error =}`.
fn samples(options: &Options, default: Samples) -> mlua::Result<Samples> {
    let object = format!("{}: samples", options.object());
    match options.value("samples")? {
        Value::Nil => Ok(default),
        table @ Value::Table(_) => {
            let options = Options::new(&object, table, &["error", "max", "min"])?;
            let min = options.count("min", 2, MAX_SAMPLES_A_PIXEL)?.unwrap_or(4);
            let max = options.count("max", min, MAX_SAMPLES_A_PIXEL)?.unwrap_or(256.max(min));
            let error = options.number_or("error", Range::above_zero(""), 0.01)?;
            Ok(Samples::Adaptive { min: min as u32, max: max as u32, error })
        }
        value => {
            let count =
                options::count(options.object(), "\"samples\"", &value, 1, MAX_SAMPLES_A_PIXEL)?;
            Ok(Samples::Fixed(count as u32))
        }
    }
}
