//! IES LM-63: keywords, then numbers in free form.

use super::solid::{AngleType, Solid, Symmetry};
use super::{PhotometricFault, PhotometricFormat, PhotometricParts};

const MM_PER_FOOT: f64 = 304.8;
const MM_PER_METER: f64 = 1000.0;

/// Whether the text has the mark of the format, or, as files of 1986 do, only the line "TILT=".
pub(super) fn is_lm63(text: &str) -> bool {
    let mut lines = text.lines().map(str::trim_start).take(500);
    text.starts_with("IESNA") || text.starts_with("IES:") || lines.any(|l| l.starts_with("TILT="))
}

/// Numbers with the lines that they stand in, taken one by one.
struct NumberReader<'a> {
    cells: Box<dyn Iterator<Item = (u64, &'a str)> + 'a>,
    line: u64,
    /// Bytes left, an upper bound of what a count may ask for.
    bytes: usize,
}

impl<'a> NumberReader<'a> {
    fn after(text: &'a str, lines: usize) -> Self {
        let rows = (1..).zip(text.lines()).skip(lines);
        let cells = rows.flat_map(|(line, row)| {
            let cells = row.split([' ', '\t', ',']).filter(|cell| !cell.is_empty());
            cells.map(move |cell| (line, cell))
        });
        Self { cells: Box::new(cells), line: lines as u64, bytes: text.len() }
    }

    fn next(&mut self, what: &str) -> Result<f64, PhotometricFault> {
        let Some((line, cell)) = self.cells.next() else {
            return Err((self.line, format!("the file ends before {what}")));
        };
        self.line = line;
        let number = cell.parse::<f64>().ok().filter(|number| number.is_finite());
        number.ok_or_else(|| (line, format!("{what} is \"{cell}\", expected a number")))
    }

    fn count(&mut self, what: &str) -> Result<usize, PhotometricFault> {
        let number = self.next(what)?;
        if number >= 1.0 && number.fract() == 0.0 && number <= self.bytes as f64 {
            return Ok(number as usize);
        }
        Err((self.line, format!("{what} is {number}, allowed: whole numbers from 1 on")))
    }

    fn list(&mut self, count: usize, what: &str) -> Result<Vec<f64>, PhotometricFault> {
        (0..count).map(|_| self.next(what)).collect()
    }
}

pub(super) fn read(text: &str) -> Result<PhotometricParts, PhotometricFault> {
    let tilt = text.lines().position(|line| line.trim_start().starts_with("TILT="));
    let tilt = tilt.ok_or((0, "no line \"TILT=\"".to_owned()))?;
    let mut numbers = NumberReader::after(text, tilt + 1);
    let warnings = pass_tilts(text, tilt, &mut numbers)?;
    let lamps = numbers.next("the number of lamps")?;
    let lumens = numbers.next("the lumens of a lamp")?;
    let multiplier = numbers.next("the multiplier")?;
    let tilts = numbers.count("the number of vertical angles")?;
    let planes = numbers.count("the number of horizontal angles")?;
    let angles =
        angle_type(numbers.next("the photometric type")?).map_err(|what| (numbers.line, what))?;
    let unit = mm_per_unit(numbers.next("the unit")?).map_err(|what| (numbers.line, what))?;
    let size = numbers.list(3, "a size of the opening")?;
    let factors = numbers.list(2, "a factor")?;
    numbers.next("the input watts")?;
    if planes.checked_mul(tilts).is_none_or(|values| values > numbers.bytes) {
        return Err((numbers.line, format!("{planes} × {tilts} angles do not fit the file")));
    }
    let tilts_deg = numbers.list(tilts, "a vertical angle")?;
    let planes_deg = numbers.list(planes, "a horizontal angle")?;
    let line_of_angles = numbers.line;
    let factor = multiplier * factors[0] * factors[1];
    let mut values = numbers.list(planes * tilts, "an intensity")?;
    values.iter_mut().for_each(|value| *value *= factor);
    let symmetry = symmetry(angles, &planes_deg).map_err(|what| (line_of_angles, what))?;
    let solid = Solid::new(angles, symmetry, planes_deg, tilts_deg, values);
    Ok(PhotometricParts {
        format: PhotometricFormat::Lm63,
        solid: solid.map_err(|what| (line_of_angles, what))?,
        lamp_flux_lm: (lumens > 0.0).then_some(lamps * lumens),
        opening_mm: size.iter().take(2).fold(0.0, |most: f64, side| most.max(side.abs() * unit)),
        description: description(text, tilt),
        warnings,
    })
}

/// Passes over the tilts that are part of the file; warns where there are any.
fn pass_tilts(
    text: &str,
    line: usize,
    numbers: &mut NumberReader,
) -> Result<Vec<String>, PhotometricFault> {
    let stated = text.lines().nth(line).and_then(|line| line.split_once('='));
    let value = stated.map_or("", |(_, value)| value.trim());
    if value.eq_ignore_ascii_case("INCLUDE") {
        numbers.next("the lamp's geometry")?;
        let pairs = numbers.count("the number of tilts")?;
        numbers.list(2 * pairs, "a tilt")?;
    }
    let is_none = value.eq_ignore_ascii_case("NONE");
    let warning = || format!("TILT={value} is not applied: intensities as measured");
    Ok((!is_none).then(warning).into_iter().collect())
}

fn angle_type(code: f64) -> Result<AngleType, String> {
    match code {
        1.0 => Ok(AngleType::C),
        2.0 => Ok(AngleType::B),
        3.0 => Ok(AngleType::A),
        other => Err(format!("photometric type {other}, allowed: 1 (C), 2 (B) and 3 (A)")),
    }
}

fn mm_per_unit(code: f64) -> Result<f64, String> {
    match code {
        1.0 => Ok(MM_PER_FOOT),
        2.0 => Ok(MM_PER_METER),
        other => Err(format!("unit {other}, allowed: 1 (feet) and 2 (meters)")),
    }
}

/// What the range of horizontal angles says.
fn symmetry(angles: AngleType, planes_deg: &[f64]) -> Result<Symmetry, String> {
    let (first, last) = (planes_deg[0], planes_deg[planes_deg.len() - 1]);
    match angles {
        AngleType::A | AngleType::B if first == 0.0 => Ok(Symmetry::Mirrored),
        AngleType::A | AngleType::B => Ok(Symmetry::None),
        AngleType::C if planes_deg.len() == 1 => Ok(Symmetry::Rotation),
        AngleType::C => match (first, last) {
            (0.0, 90.0) => Ok(Symmetry::Quadrants),
            (0.0, 180.0) => Ok(Symmetry::Mirrored),
            (0.0, last) if last > 180.0 => Ok(Symmetry::None),
            _ => Err(format!(
                "horizontal angles of {first} to {last}, allowed for type C: 0, 0 to 90, 0 to 180, \
                 0 to 360"
            )),
        },
    }
}

/// Keywords in brackets and their texts.
fn description(text: &str, tilt: usize) -> Vec<(String, String)> {
    let lines = text.lines().take(tilt).map(str::trim);
    let pairs = lines.filter_map(|line| line.strip_prefix('[')?.split_once(']'));
    let named = pairs.map(|(key, value)| (key.to_lowercase(), value.trim().to_owned()));
    named.filter(|(_, value)| !value.is_empty()).collect()
}
