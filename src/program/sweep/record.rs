//! What a manifest says of a view, under the names that scripts use.

use serde_json::{Value, json};

use crate::color::Xyz;
use crate::display::{Curve, Display, DisplayParameters, Toe};
use crate::error::Result;
use crate::image::{Region, SpectralImage};
use crate::spectrum::WavelengthGrid;

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
