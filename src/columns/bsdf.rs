//! Measured scatter: Zemax `.bsdf` and ASTM E1392, as angles from the lobe's direction and values.
//!
//! Zemax gives scatter by azimuth and radial angle about the specular direction, a block for each
//! rotation of the sample and angle of incidence. E1392 names its columns in a line "VARS".

use std::fmt::Write;

use super::cells::{DecimalMark, Separator, Style};
use super::{Found, Line, Table, TableFormat, TextProblem, block, spdx};
use crate::error::{Error, Place, Result as FileResult};

const TAB: Style = Style::new(Separator::Tab, DecimalMark::Point);
const BLANK: Style = Style::new(Separator::Blank, DecimalMark::Point);

/// Columns of the tables that both formats become.
const NAMES: [&str; 3] = ["incidence_deg", "angle_deg", "value"];

/// Which side of a sample was measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ScatterKind {
    /// BRDF.
    Reflected,
    /// BTDF.
    Transmitted,
}

/// In-plane scatter at one angle of incidence.
#[derive(Debug, Clone, PartialEq)]
pub struct Scatter {
    /// From the sample's normal.
    pub incidence_deg: f64,
    /// Angle from the lobe's direction in degrees, ascending, and value.
    pub points: Vec<(f64, f64)>,
}

/// Whether the text has the keywords of Zemax' format.
pub(super) fn is_zemax(text: &str) -> bool {
    let head: Vec<&str> = text.lines().take(100).map(str::trim_start).collect();
    ["ScatterRadial", "ScatterAzimuth"]
        .iter()
        .all(|key| head.iter().any(|line| line.starts_with(key)))
}

/// Whether a line names the angles that ASTM E1392 has.
pub(super) fn is_astm(text: &str) -> bool {
    text.lines().take(500).any(|line| variables(line).is_some())
}

/// The names after "VARS", if angles are among them.
fn variables(line: &str) -> Option<Vec<String>> {
    let names = line.trim().strip_prefix("VARS")?.trim_start_matches(['=', ' ', '\t', ':']);
    let names: Vec<String> = names.split(',').map(|name| name.trim().to_lowercase()).collect();
    names.iter().any(|name| name.starts_with("theta")).then_some(names)
}

/// The lines of a Zemax file, one after the other.
struct Zemax<'a> {
    text: &'a str,
    lines: std::vec::IntoIter<Line>,
    last: Line,
}

impl<'a> Zemax<'a> {
    fn next(&mut self) -> Result<&'a str, TextProblem> {
        let Some(line) = self.lines.next() else {
            return Err(self.last.problem("the file ends too early".to_owned()));
        };
        self.last = line;
        Ok(line.text(self.text))
    }

    /// "key value", whatever its case.
    fn value(&mut self, key: &str) -> Result<&'a str, TextProblem> {
        let line = self.next()?;
        let (found, value) = line.split_once([' ', '\t', ',']).unwrap_or((line, ""));
        if found.eq_ignore_ascii_case(key) {
            return Ok(value.trim_matches([' ', '\t', ',']));
        }
        Err(self.last.problem(format!("\"{found}\", expected \"{key}\"")))
    }

    fn numbers(&mut self) -> Result<Vec<f64>, TextProblem> {
        let line = self.next()?;
        let cells = line.split([' ', '\t', ',']).filter(|cell| !cell.is_empty());
        let numbers: Option<Vec<f64>> = cells.map(|cell| BLANK.number(cell)).collect();
        let numbers = numbers.filter(|n| n.iter().all(|n| n.is_finite()));
        numbers.ok_or_else(|| self.last.problem(format!("\"{line}\", expected numbers")))
    }

    /// A key with a count, and that many numbers in the next line.
    fn list(&mut self, key: &str) -> Result<Vec<f64>, TextProblem> {
        let count = self.value(key)?.to_owned();
        let numbers = self.numbers()?;
        if count.parse() == Ok(numbers.len()) {
            return Ok(numbers);
        }
        Err(self.last.problem(format!("{} numbers, {key} says {count}", numbers.len())))
    }
}

pub(super) fn read_zemax(text: &str) -> Result<Found, TextProblem> {
    let lines = block::content_lines(text);
    let last = lines.first().copied().unwrap_or_else(|| Line::of(text, "", 0));
    let mut file = Zemax { text, lines: lines.into_iter(), last };
    file.value("Source")?;
    let symmetry = file.value("Symmetry")?.to_owned();
    file.value("SpectralContent")?;
    let kind = file.value("ScatterType")?.to_owned();
    let rotations = file.list("SampleRotation")?;
    let incidences = file.list("AngleOfIncidence")?;
    let azimuths = file.list("ScatterAzimuth")?;
    let radii = file.list("ScatterRadial")?;
    let content = file.next()?.to_owned();
    file.value("DataBegin")?;
    let mut rows = String::new();
    let mut numbers = Vec::new();
    // Further rotations stand behind the first one.
    for &incidence in &incidences {
        file.value("TIS")?;
        for &azimuth in &azimuths {
            let values = file.numbers()?;
            if values.len() != radii.len() {
                let (has, radial) = (values.len(), radii.len());
                return Err(file.last.problem(format!("{has} values, ScatterRadial has {radial}")));
            }
            for (&radial, value) in radii.iter().zip(values) {
                if let Some(angle) = in_plane(azimuth, radial) {
                    let _ = writeln!(rows, "{incidence}\t{angle}\t{value}"); // cannot fail
                    numbers.push(file.last.number);
                }
            }
        }
    }
    let mut notes = vec![
        format!("{kind}, {symmetry}, {content}"),
        format!("in-plane lobe about the specular direction, at incidences {incidences:?}°"),
    ];
    if rotations.len() > 1 {
        notes.push(format!("the first of {} rotations of the sample", rotations.len()));
    }
    let keywords = vec![("ScatterType".to_owned(), kind)];
    Ok(found(TableFormat::Bsdf, rows, &numbers, keywords, notes))
}

/// The angle in the plane of incidence: azimuth 0° is toward the normal, which counts as below 0.
fn in_plane(azimuth_deg: f64, radial_deg: f64) -> Option<f64> {
    match azimuth_deg.rem_euclid(360.0) {
        0.0 => Some(-radial_deg),
        180.0 if radial_deg != 0.0 => Some(radial_deg),
        _ => None,
    }
}

fn found(
    format: TableFormat,
    text: String,
    numbers: &[u32],
    keywords: Vec<(String, String)>,
    notes: Vec<String>,
) -> Found {
    let names = NAMES.map(str::to_owned).to_vec();
    let rows = spdx::anew_rows(&text, numbers);
    Found { format, style: TAB, names, keywords, rows, notes, text: Some(text) }
}

/// Where E1392's columns are.
struct BsdfColumns {
    theta_i: usize,
    phi_i: Option<usize>,
    theta_s: usize,
    phi_s: Option<usize>,
    value: usize,
}

impl BsdfColumns {
    fn of(names: &[String]) -> Option<Self> {
        let at = |wanted: &[&str]| names.iter().position(|name| wanted.contains(&name.as_str()));
        let theta_i = at(&["theta_i", "thetai", "theta_in"])?;
        let theta_s = at(&["theta_s", "thetas", "theta_r", "theta_o", "theta_t"])?;
        let is_angle = |name: &String| name.starts_with("theta") || name.starts_with("phi");
        // Of several channels the middle one: green of R, G, B.
        let channels: Vec<usize> = (0..names.len()).filter(|&i| !is_angle(&names[i])).collect();
        Some(Self {
            theta_i,
            phi_i: at(&["phi_i", "phii", "phi_in"]),
            theta_s,
            phi_s: at(&["phi_s", "phis", "phi_r", "phi_o", "phi_t"]),
            value: *channels.get(channels.len() / 2)?,
        })
    }
}

pub(super) fn read_astm(text: &str) -> Result<Found, TextProblem> {
    let lines = block::content_lines(text);
    let head = lines.iter().position(|line| variables(line.text(text)).is_some());
    let at = head.unwrap_or_default();
    let names = variables(lines[at].text(text)).unwrap_or_default();
    let Some(columns) = BsdfColumns::of(&names) else {
        let what = "VARS names no theta_i, no theta_s or no value".to_owned();
        return Err(lines[at].problem(what));
    };
    let style = Style::new(Separator::Comma, DecimalMark::Point);
    let mut rows = Vec::new();
    for line in &lines[at + 1..] {
        let content = line.text(text);
        let style = if content.contains(',') { style } else { BLANK };
        let numbers: Option<Vec<f64>> = style.cells(content).map(|c| style.number(c)).collect();
        let numbers = numbers.filter(|n| n.len() == names.len() && n.iter().all(|n| n.is_finite()));
        let numbers = numbers.ok_or_else(|| {
            line.problem(format!("\"{content}\", expected {} numbers", names.len()))
        })?;
        rows.push((numbers, line.number));
    }
    Ok(astm_found(&columns, &names, rows))
}

fn astm_found(columns: &BsdfColumns, names: &[String], rows: Vec<(Vec<f64>, u32)>) -> Found {
    let angles = rows.iter().flat_map(|(n, _)| [n[columns.theta_i], n[columns.theta_s]]);
    let largest = angles.fold(0.0, |most: f64, angle| most.max(angle.abs()));
    let is_radians = largest <= std::f64::consts::FRAC_PI_2 + 1e-3;
    let deg = |angle: f64| if is_radians { angle.to_degrees() } else { angle };
    let mut text = String::new();
    let mut numbers = Vec::new();
    for (row, number) in &rows {
        let phi = |at: Option<usize>| at.map_or(0.0, |at| deg(row[at]));
        let turned = (phi(columns.phi_s) - phi(columns.phi_i)).rem_euclid(360.0);
        let (incidence, scatter) = (deg(row[columns.theta_i]), deg(row[columns.theta_s]));
        let Some(side) = side(turned) else { continue };
        let _ =
            writeln!(text, "{incidence}\t{}\t{}", side * scatter - incidence, row[columns.value]);
        numbers.push(*number);
    }
    let unit = if is_radians { "radians" } else { "degrees" };
    let notes = vec![
        format!("angles in {unit}, in-plane rows {} of {}", numbers.len(), rows.len()),
        format!("values of \"{}\"", names[columns.value]),
    ];
    found(TableFormat::Astm, text, &numbers, Vec::new(), notes)
}

/// Whether scatter is on the side of the specular direction (half a turn from the light, 1), on the
/// light's (−1), or out of the plane of incidence.
fn side(turned_deg: f64) -> Option<f64> {
    const TOLERANCE_DEG: f64 = 0.5;
    if (turned_deg - 180.0).abs() <= TOLERANCE_DEG {
        Some(1.0)
    } else if turned_deg.min(360.0 - turned_deg) <= TOLERANCE_DEG {
        Some(-1.0)
    } else {
        None
    }
}

impl Table {
    /// Whether the rows are scatter by incidence and angle, as [`Self::scatter`] takes them.
    pub fn is_scatter(&self) -> bool {
        matches!(self.reading.format, TableFormat::Bsdf | TableFormat::Astm)
    }

    /// BRDF or BTDF, where the file says so.
    pub fn scatter_kind(&self) -> Option<ScatterKind> {
        match self.keyword("ScatterType")? {
            kind if kind.eq_ignore_ascii_case("BTDF") => Some(ScatterKind::Transmitted),
            _ => Some(ScatterKind::Reflected),
        }
    }

    /// Scatter at the measured incidence that is nearest to `incidence_deg`, or at the first one.
    ///
    /// Errors: [`Error::BadFile`] for a file without rows in the plane of incidence.
    pub fn scatter(&self, incidence_deg: Option<f64>) -> FileResult<Scatter> {
        let rows: Vec<[f64; 3]> = self
            .rows()
            .map(|row| Ok([row.number(0)?, row.number(1)?, row.number(2)?]))
            .collect::<FileResult<_>>()?;
        let Some(first) = rows.first() else {
            let problem = "no rows in the plane of incidence";
            return Err(Error::bad_file(self.path(), Place::File, problem));
        };
        let wanted = incidence_deg.unwrap_or(first[0]);
        let distance = |row: &[f64; 3]| (row[0] - wanted).abs();
        let nearest = rows.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let incidence_deg = nearest.unwrap_or(first)[0];
        let of_incidence = rows.iter().filter(|row| row[0] == incidence_deg);
        let mut points: Vec<(f64, f64)> = of_incidence.map(|row| (row[1], row[2])).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points.dedup_by(|a, b| a.0 == b.0);
        Ok(Scatter { incidence_deg, points })
    }
}
