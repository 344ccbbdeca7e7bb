//! EULUMDAT: one value a line, in a fixed order.

use super::solid::{AngleType, Solid, Symmetry};
use super::{PhotometricFault, PhotometricFormat, PhotometricParts};

/// Lines (from 1) of the header that are used.
mod line {
    pub const COMPANY: usize = 1;
    pub const SYMMETRY: usize = 3;
    pub const PLANES: usize = 4;
    pub const TILTS: usize = 6;
    pub const NAME: usize = 9;
    pub const OPENING_LENGTH: usize = 16;
    pub const OPENING_WIDTH: usize = 17;
    pub const FACTOR: usize = 24;
    pub const SETS: usize = 26;
}

/// Lines of a set of lamps, the third of which is their flux.
const LINES_PER_SET: usize = 6;
const LINE_OF_FLUX: usize = 3;
/// Direct ratios, which say nothing about the light itself.
const DIRECT_RATIOS: usize = 10;
/// The most of either angle that a file has.
const MOST_ANGLES: usize = 10_000;

/// Whether the third to seventh lines are numbers that can stand there, and the first is none.
pub(super) fn is_eulumdat(text: &str) -> bool {
    let lines: Vec<&str> = text.lines().take(7).map(str::trim).collect();
    let number = |at: usize| lines.get(at - 1).and_then(|line| number(line));
    let whole = |at: usize, low: f64, high: f64| {
        number(at).is_some_and(|n| n.fract() == 0.0 && (low..=high).contains(&n))
    };
    lines.first().is_some_and(|line| number_of_cells(line) == 0 || number(1).is_none())
        && whole(2, 0.0, 3.0)
        && whole(3, 0.0, 4.0)
        && whole(4, 1.0, MOST_ANGLES as f64)
        && number(5).is_some()
        && whole(6, 1.0, MOST_ANGLES as f64)
        && number(7).is_some()
}

fn number_of_cells(line: &str) -> usize {
    line.split_whitespace().filter(|cell| number(cell).is_some()).count()
}

/// With a point or a comma.
fn number(text: &str) -> Option<f64> {
    text.trim().replace(',', ".").parse::<f64>().ok().filter(|number| number.is_finite())
}

struct EulumdatLines<'a>(Vec<&'a str>);

impl EulumdatLines<'_> {
    fn number(&self, at: usize, what: &str) -> Result<f64, PhotometricFault> {
        let Some(text) = self.0.get(at - 1) else {
            return Err((self.0.len() as u64, format!("the file ends before {what}")));
        };
        number(text).ok_or_else(|| (at as u64, format!("{what} is \"{text}\", expected a number")))
    }

    fn count(&self, at: usize, what: &str, most: usize) -> Result<usize, PhotometricFault> {
        let number = self.number(at, what)?;
        if number.fract() == 0.0 && (1.0..=most as f64).contains(&number) {
            return Ok(number as usize);
        }
        Err((at as u64, format!("{what} is {number}, allowed: whole numbers, 1 to {most}")))
    }

    fn list(&self, from: usize, count: usize, what: &str) -> Result<Vec<f64>, PhotometricFault> {
        (from..from + count).map(|at| self.number(at, what)).collect()
    }
}

pub(super) fn read(text: &str) -> Result<PhotometricParts, PhotometricFault> {
    if !is_eulumdat(text) {
        return Err((0, "neither an IES LM-63 nor a EULUMDAT file".to_owned()));
    }
    let lines = EulumdatLines(text.lines().map(str::trim).collect());
    let code = lines.number(line::SYMMETRY, "the symmetry")?;
    let planes = lines.count(line::PLANES, "the number of C planes", MOST_ANGLES)?;
    let tilts = lines.count(line::TILTS, "the number of γ angles", MOST_ANGLES)?;
    let sets = lines.count(line::SETS, "the number of sets of lamps", 100)?;
    let flux_lm = lines.number(line::SETS + LINE_OF_FLUX, "the flux of the lamps")?;
    let factor = lines.number(line::FACTOR, "the conversion factor")?;
    let first_plane = line::SETS + LINES_PER_SET * sets + DIRECT_RATIOS + 1;
    let planes_deg = lines.list(first_plane, planes, "a C plane")?;
    let tilts_deg = lines.list(first_plane + planes, tilts, "an angle γ")?;
    let (symmetry, mut stored) =
        stored_planes(code as u32, planes_deg).map_err(|what| (line::SYMMETRY as u64, what))?;
    let first_value = first_plane + planes + tilts;
    let per_klm = flux_lm / 1000.0 * if factor == 0.0 { 1.0 } else { factor };
    let mut values = lines.list(first_value, stored.len() * tilts, "an intensity")?;
    values.iter_mut().for_each(|value| *value *= per_klm);
    if symmetry == Symmetry::None {
        close_turn(&mut stored, &mut values, tilts);
    }
    let solid = Solid::new(AngleType::C, symmetry, stored, tilts_deg, values);
    let opening = [line::OPENING_LENGTH, line::OPENING_WIDTH];
    let opening_mm = opening.iter().filter_map(|&at| number(lines.0.get(at - 1)?));
    let warnings = (sets > 1).then(|| format!("the first of {sets} sets of lamps counts"));
    Ok(PhotometricParts {
        format: PhotometricFormat::Eulumdat,
        solid: solid.map_err(|what| (first_plane as u64, what))?,
        lamp_flux_lm: (flux_lm > 0.0).then_some(flux_lm),
        opening_mm: opening_mm.fold(0.0, f64::max),
        description: [("company", line::COMPANY), ("luminaire", line::NAME)]
            .into_iter()
            .filter_map(|(name, at)| Some((name.to_owned(), (*lines.0.get(at - 1)?).to_owned())))
            .filter(|(_, text)| !text.is_empty())
            .collect(),
        warnings: warnings.into_iter().collect(),
    })
}

/// The first plane again at its angle plus 360°, unless what is missing of the turn was not measured.
fn close_turn(planes_deg: &mut Vec<f64>, values: &mut Vec<f64>, tilts: usize) {
    const WIDEST_GAP_DEG: f64 = 90.0;
    let (first, last) = (planes_deg[0], planes_deg[planes_deg.len() - 1]);
    let gap_deg = first + 360.0 - last;
    if first == 0.0 && gap_deg > 0.0 && gap_deg <= WIDEST_GAP_DEG {
        planes_deg.push(360.0);
        values.extend_from_within(..tilts);
    }
}

/// The planes whose values are there, in their order, ascending.
fn stored_planes(code: u32, planes_deg: Vec<f64>) -> Result<(Symmetry, Vec<f64>), String> {
    let count = planes_deg.len();
    let first = |count: usize| planes_deg[..count.min(planes_deg.len())].to_vec();
    match code {
        0 => Ok((Symmetry::None, planes_deg)),
        1 => Ok((Symmetry::Rotation, first(1))),
        2 => Ok((Symmetry::Mirrored, first(count / 2 + 1))),
        // From C 270° over 0° to 90°.
        3 => {
            let turned = |plane: f64| if plane >= 270.0 { plane - 360.0 } else { plane };
            let from = 3 * count / 4;
            let stored = (0..=count / 2).map(|k| turned(planes_deg[(from + k) % count]));
            Ok((Symmetry::MirroredAtSide, stored.collect()))
        }
        4 => Ok((Symmetry::Quadrants, first(count / 4 + 1))),
        other => Err(format!("symmetry {other}, allowed: 0 to 4")),
    }
}
