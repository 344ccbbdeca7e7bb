//! ASAP `.dis`: five header records of seven words, then seven words a ray, in either byte order.

use super::binary::{ByteOrder, RayBlock};
use super::input::Input;
use super::record::Layout;
use super::{FluxUnit, Format, Parsed, Warning};
use crate::error::Result;

const HEADER_BYTES: u64 = 5 * 7 * 4;

/// The first word says how many words a record has: 247 + 256 · 4 · words.
const SEVEN_WORDS: i32 = 247 + 256 * 4 * 7;

const TITLE: std::ops::Range<usize> = 28..52;
/// "XYZABCF" and the length unit.
const LABEL: std::ops::Range<usize> = 68..84;
/// Minus the number of rays.
const RAYS: std::ops::Range<usize> = 108..112;

/// The order in which the first word makes sense.
pub(super) fn byte_order(head: &[u8]) -> Option<ByteOrder> {
    let word = *head.first_chunk::<4>()?;
    if i32::from_le_bytes(word) == SEVEN_WORDS {
        Some(ByteOrder::Little)
    } else if i32::from_be_bytes(word) == SEVEN_WORDS {
        Some(ByteOrder::Big)
    } else {
        None
    }
}

pub(super) fn read(input: &mut Input) -> Result<Parsed> {
    let order = byte_order(input.head()).unwrap_or(ByteOrder::Little);
    let header = input.take(HEADER_BYTES, "the header")?;
    let text = |range| String::from_utf8_lossy(&header[range]).replace('\0', " ").trim().to_owned();
    let mut word = [0; 4];
    word.copy_from_slice(&header[RAYS]);
    let count = match order {
        ByteOrder::Little => i32::from_le_bytes(word),
        ByteOrder::Big => i32::from_be_bytes(word),
    };
    if count > 0 {
        return Err(input.bad(format!("{count} where minus the number of rays should be")));
    }
    let label = text(LABEL);
    let mm_per_unit = length_unit(&label);
    let layout = Layout { mm_per_unit: mm_per_unit.unwrap_or(1.0), ..Layout::seven_columns() };
    let unit = FluxUnit::Unstated;
    let rays = u64::from(count.unsigned_abs());
    let rays = RayBlock { layout: &layout, unit, rays, order }.read(input, 0)?;
    let mut parsed = Parsed::new(Format::Asap, rays, unit);
    if mm_per_unit.is_none() {
        parsed.warnings.push(Warning::UnstatedLengthUnit);
    }
    parsed.describe("title", text(TITLE));
    Ok(parsed)
}

/// The last word of the label.
fn length_unit(label: &str) -> Option<f64> {
    match label.split_whitespace().last()?.to_ascii_uppercase().as_str() {
        "MM" => Some(1.0),
        "CM" => Some(10.0),
        "M" => Some(1000.0),
        "IN" | "INCHES" => Some(25.4),
        "FT" | "FEET" => Some(304.8),
        "UM" | "MICRONS" => Some(1e-3),
        "NM" => Some(1e-6),
        _ => None,
    }
}
