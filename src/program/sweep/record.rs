//! What a manifest says of a view, under the names that scripts use.

use serde_json::{Value, json};

use crate::color::{Xyz, signal};
use crate::display::{Curve, Display, DisplayParameters, Toe};
use crate::error::Result;
use crate::image::{Region, SpectralImage};
use crate::render::{Asked, Quality, RenderStats, Samples, TargetReport};
use crate::shading::{TraceCounts, TraceLimits};
use crate::spectrum::WavelengthGrid;
use crate::view::View;

pub fn view_record(view: &View) -> Value {
    let View { azimuth_deg, elevation_deg, distance_mm, target, fov_deg, width, height } = view;
    json!({
        "azimuth": azimuth_deg,
        "elevation": elevation_deg,
        "distance": distance_mm,
        "target": target.to_array(),
        "fov": fov_deg,
        "width": width,
        "height": height,
    })
}

pub fn asked_record(asked: &Asked) -> Value {
    match asked {
        Asked::Quality(quality) => quality_record(quality),
        Asked::TargetError(target) => json!({ "target_error": target }),
    }
}

fn quality_record(quality: &Quality) -> Value {
    let Quality { samples, limits, grid } = quality;
    let TraceLimits { max_depth, min_throughput, light_error } = limits;
    let samples = match samples {
        Samples::Fixed(count) => json!(count),
        Samples::Adaptive { min, max, error } => json!({ "min": min, "max": max, "error": error }),
        Samples::Lit { max, error } => json!({ "max": max, "lit_error": error }),
    };
    json!({
        "samples": samples,
        "max_depth": max_depth,
        "min_throughput": min_throughput,
        "light_error": light_error,
        "wavelength_step": grid.step_nm(),
    })
}

/// All but the seconds, which differ from run to run.
pub fn stats_record(stats: &RenderStats) -> Value {
    let TraceCounts {
        camera_rays,
        mirror_rays,
        transmitted_rays,
        shadow_rays,
        light_sums,
        light_nodes,
        light_samples,
    } = stats.counts;
    let mut record = json!({
        "camera_rays": camera_rays,
        "mirror_rays": mirror_rays,
        "transmitted_rays": transmitted_rays,
        "shadow_rays": shadow_rays,
        "light_sums": light_sums,
        "light_nodes": light_nodes,
        "light_samples": light_samples,
        "light_error": stats.mean_light_error,
        "largest_light_error": stats.largest_light_error,
    });
    if let Some(report) = &stats.target {
        record["target"] = target_record(report);
    }
    record
}

fn target_record(report: &TargetReport) -> Value {
    json!({
        "error": report.error(),
        "sampling_error": report.sampling_error,
        "light_sum_error": report.light_sum_error,
        "truncation_error": report.truncation_error,
        "samples": report.mean_samples,
        "most_samples": report.most_samples,
        "max_depth": report.limits.max_depth,
        "min_throughput": report.limits.min_throughput,
        "light_error": report.limits.light_error,
        "wavelength_step": report.grid.step_nm(),
    })
}

/// The light of a region that the script names.
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    pub region: Region,
    pub grid: WavelengthGrid,
    /// Mean of each band.
    pub bands: Vec<f64>,
    pub xyz: Xyz,
}

impl Reading {
    /// Errors: a region that leaves the image.
    pub fn of(image: &SpectralImage, region: Region) -> Result<Self> {
        let bands = image.mean_bands(region)?;
        let xyz = Xyz::from_bands(image.grid, &bands);
        Ok(Self { region, grid: image.grid, bands, xyz })
    }

    pub fn record(&self) -> Value {
        let Region { x, y, width, height } = self.region;
        let xy = self.xyz.chromaticity();
        json!({
            "x": x,
            "y": y,
            "width": width,
            "height": height,
            "luminance": self.xyz.y,
            "chromaticity": xy,
            "color": xy.and_then(signal::color_of).map(|color| color.name()),
            "wavelength_step": self.grid.step_nm(),
            "spectrum": self.bands,
        })
    }
}

/// All that [`display_from_record`] needs.
pub fn display_record(display: &Display) -> Value {
    let curve = |curve: &Curve| {
        let Curve { gain, offset, gamma, toe, pq_peak_cd_m2 } = curve;
        let toe = toe.map(|Toe { slope, end }| json!({ "slope": slope, "end": end }));
        let mut record = json!({ "gain": gain, "offset": offset, "gamma": gamma, "toe": toe });
        if let Some(peak) = pq_peak_cd_m2 {
            record["pq_peak"] = json!(peak);
        }
        record
    };
    let rows = display.matrix().transpose().to_cols_array_2d();
    json!({
        "name": display.name(),
        "curves": display.curves().iter().map(curve).collect::<Vec<_>>(),
        "matrix": rows,
        "black": <[f64; 3]>::from(display.black()),
        "bits": display.bits(),
    })
}

/// The display of [`display_record`]; `None` if a field is missing or wrong.
pub(super) fn display_from_record(record: &Value) -> Option<Display> {
    let number = |value: &Value, key: &str| value.get(key)?.as_f64();
    let curve = |value: &Value| {
        let toe = match value.get("toe")? {
            Value::Null => None,
            toe => Some(Toe { slope: number(toe, "slope")?, end: number(toe, "end")? }),
        };
        let (gain, offset) = (number(value, "gain")?, number(value, "offset")?);
        let pq_peak_cd_m2 = number(value, "pq_peak");
        Some(Curve { gain, offset, gamma: number(value, "gamma")?, toe, pq_peak_cd_m2 })
    };
    let rows = record.get("matrix")?.as_array()?;
    let curves = record.get("curves")?.as_array()?;
    let parameters = DisplayParameters {
        name: record.get("name")?.as_str()?.to_owned(),
        curves: triple(curves.iter().map(curve))?,
        matrix: triple(rows.iter().map(numbers))?,
        black: numbers(record.get("black")?)?.into(),
        bits: u32::try_from(record.get("bits")?.as_u64()?).ok()?,
    };
    Display::new(parameters).ok()
}

fn numbers(value: &Value) -> Option<[f64; 3]> {
    triple(value.as_array()?.iter().map(Value::as_f64))
}

fn triple<T>(items: impl Iterator<Item = Option<T>>) -> Option<[T; 3]> {
    items.collect::<Option<Vec<T>>>()?.try_into().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn displays_read_back() {
        for display in [Display::srgb(), Display::eizo_t766()] {
            let read = display_from_record(&display_record(&display)).unwrap();
            assert_eq!(read.is_srgb(), display.is_srgb());
            assert_eq!((read.curves(), read.name()), (display.curves(), display.name()));
            // Through text too, as a manifest has it.
            let text = display_record(&display).to_string();
            let parsed: Value = serde_json::from_str(&text).unwrap();
            assert_eq!(display_from_record(&parsed).unwrap().matrix(), display.matrix());
        }
        assert!(display_from_record(&Value::Null).is_none());
    }
}
