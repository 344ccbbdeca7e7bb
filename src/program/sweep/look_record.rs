//! A look as a manifest has it.

use serde_json::{Value, json};

use crate::display::{
    Curve, Display, DisplayParameters, Exposure, Gamut, Glare, Look, MeasuredCurve, PhotoCamera,
    Toe, Tone,
};
use crate::spectrum::Spectrum;

/// All that [`look_from_record`] needs.
pub fn look_record(look: &Look) -> Value {
    let Look { display, exposure, tone, gamut, glare, camera } = look;
    json!({
        "display": display_record(display),
        "exposure": exposure_record(exposure),
        "tone": format!("{tone:?}").to_lowercase(),
        "gamut": match gamut { Gamut::Clip => "clip", Gamut::Desaturate => "desaturate" },
        "glare": glare.map(|Glare { age, pigment, strength }| {
            json!({ "age": age, "pigment": pigment, "strength": strength })
        }),
        "camera": camera.as_ref().map(camera_record),
    })
}

/// The look of [`look_record`]; `None` for one whose tone curve is a function, or if a field is
/// missing or wrong.
pub(super) fn look_from_record(record: &Value) -> Option<Look> {
    Some(Look {
        display: display_from_record(record.get("display")?)?,
        exposure: exposure_from_record(record.get("exposure")?)?,
        tone: match record.get("tone")?.as_str()? {
            "linear" => Tone::Linear,
            "reinhard" => Tone::Reinhard,
            "photographic" => Tone::Photographic,
            _ => return None,
        },
        gamut: match record.get("gamut")?.as_str()? {
            "clip" => Gamut::Clip,
            "desaturate" => Gamut::Desaturate,
            _ => return None,
        },
        glare: match record.get("glare")? {
            Value::Null => None,
            glare => Some(Glare {
                age: number(glare, "age")?,
                pigment: number(glare, "pigment")?,
                strength: number(glare, "strength")?,
            }),
        },
        camera: match record.get("camera")? {
            Value::Null => None,
            camera => Some(camera_from_record(camera)?),
        },
    })
}

/// The display of a look's record.
pub(super) fn display_of(look: &Value) -> Option<Display> {
    display_from_record(look.get("display")?)
}

fn number(value: &Value, key: &str) -> Option<f64> {
    value.get(key)?.as_f64()
}

fn exposure_record(exposure: &Exposure) -> Value {
    match exposure {
        Exposure::Auto => json!("auto"),
        Exposure::Factor(factor) => json!({ "factor": factor }),
        Exposure::Stops(stops) => json!({ "ev": stops }),
        Exposure::Adapted(luminance) => json!({ "adaptation": luminance }),
    }
}

fn exposure_from_record(record: &Value) -> Option<Exposure> {
    if record.as_str() == Some("auto") {
        return Some(Exposure::Auto);
    }
    type ExposureKind = (&'static str, fn(f64) -> Exposure);
    let kinds: [ExposureKind; 3] =
        [("factor", Exposure::Factor), ("ev", Exposure::Stops), ("adaptation", Exposure::Adapted)];
    kinds.into_iter().find_map(|(key, kind)| number(record, key).map(kind))
}

fn camera_record(camera: &PhotoCamera) -> Value {
    let PhotoCamera { name, sensitivities, exposure, full_well, white_xy } = camera;
    let pairs = |s: &Spectrum| -> Vec<[f64; 2]> {
        s.wavelengths_nm().iter().zip(s.values()).map(|(&nm, &value)| [nm, value]).collect()
    };
    json!({
        "name": name,
        "sensitivities": sensitivities.each_ref().map(pairs),
        "exposure": exposure_record(exposure),
        "full_well": full_well,
        "white": white_xy,
    })
}

fn camera_from_record(record: &Value) -> Option<PhotoCamera> {
    let pair = |value: &Value| Some((value.get(0)?.as_f64()?, value.get(1)?.as_f64()?));
    let channel = |at: usize| {
        let pairs = record.get("sensitivities")?.get(at)?.as_array()?;
        let pairs: Option<Vec<(f64, f64)>> = pairs.iter().map(pair).collect();
        Spectrum::from_pairs("camera", pairs?).ok()
    };
    let white = pair(record.get("white")?)?;
    Some(PhotoCamera {
        exposure: exposure_from_record(record.get("exposure")?)?,
        full_well: number(record, "full_well")?,
        white_xy: [white.0, white.1],
        ..PhotoCamera::new(record.get("name")?.as_str()?, [channel(0)?, channel(1)?, channel(2)?])
    })
}

/// All that [`display_from_record`] needs.
fn display_record(display: &Display) -> Value {
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
    let levels = |curve: &MeasuredCurve| curve.levels().collect::<Vec<_>>();
    let mut record = json!({
        "name": display.name(),
        "curves": display.curves().iter().map(curve).collect::<Vec<_>>(),
        "matrix": rows,
        "black": <[f64; 3]>::from(display.black()),
        "bits": display.bits(),
    });
    if let Some(measured) = display.measured_curves() {
        record["levels"] = json!(measured.each_ref().map(levels));
    }
    record
}

/// The display of [`display_record`]; `None` if a field is missing or wrong.
fn display_from_record(record: &Value) -> Option<Display> {
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
    let display = Display::new(parameters).ok()?;
    let Some(measured) = record.get("levels") else { return Some(display) };
    Some(display.with_measured_curves(triple(measured.as_array()?.iter().map(levels_curve))?))
}

fn levels_curve(levels: &Value) -> Option<MeasuredCurve> {
    let level = |level: &Value| Some((level.get(0)?.as_f64()?, level.get(1)?.as_f64()?));
    let levels: Option<Vec<(f64, f64)>> = levels.as_array()?.iter().map(level).collect();
    MeasuredCurve::new("display", &levels?).ok()
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
    fn looks_read_back_through_text() {
        let pq = Display::rec2020_pq(600.0).unwrap();
        let displays = [Display::srgb(), Display::eizo_t766(), Display::p3(), pq];
        let exposures = [Exposure::Auto, Exposure::Stops(0.1), Exposure::Adapted(3.0)];
        for look in [Look::paper(), Look::seen(), Look::camera()] {
            for display in displays.clone() {
                for exposure in exposures {
                    let look = Look { display: display.clone(), exposure, ..look.clone() };
                    let text = look_record(&look).to_string();
                    let parsed: Value = serde_json::from_str(&text).unwrap();
                    let read = look_from_record(&parsed).unwrap();
                    assert_eq!(read.display.matrix(), look.display.matrix());
                    assert_eq!(read.display.code_points(), look.display.code_points());
                    assert_eq!(read.display.is_srgb(), look.display.is_srgb());
                    assert_eq!((read.camera.clone(), read.glare), (look.camera, look.glare));
                    assert_eq!(look_record(&read), parsed);
                }
            }
        }
        assert!(look_from_record(&Value::Null).is_none());
    }

    #[test]
    fn functions_have_no_record() {
        let tone = Tone::Curve(std::sync::Arc::new(Ok));
        assert!(look_from_record(&look_record(&Look { tone, ..Look::paper() })).is_none());
    }
}
