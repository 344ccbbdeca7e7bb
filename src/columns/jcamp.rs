//! JCAMP-DX: labelled lines, and one table of ordinates at even steps or of pairs.
//!
//! Ordinates may be packed: differences (DIF), repetitions (DUP) and letters for a sign and first
//! digit (SQZ), after McDonald & Wilks, Appl. Spectrosc. 42 (1988) 151.

use std::fmt::Write;

use super::cells::{DecimalMark, Separator, Style};
use super::{Found, TableFormat, TextProblem, spdx};

/// What the labels before the data state.
#[derive(Debug)]
struct JcampLabels {
    x_factor: f64,
    y_factor: f64,
    first_x: Option<f64>,
    last_x: Option<f64>,
    points: Option<usize>,
    x_units: String,
    y_units: String,
}

/// A file of some kilobytes may repeat one value without end; no spectrometer has more points.
const MOST_POINTS: usize = 4_000_000;

pub(super) fn read(text: &str) -> Result<Found, TextProblem> {
    let mut header = JcampLabels {
        x_factor: 1.0,
        y_factor: 1.0,
        first_x: None,
        last_x: None,
        points: None,
        x_units: String::new(),
        y_units: String::new(),
    };
    let mut lines = (1..).zip(text.lines());
    let points = loop {
        let Some((number, line)) = lines.next() else {
            return Err(problem(0, "no \"##XYDATA\" and no \"##XYPOINTS\" in the JCAMP-DX file"));
        };
        let Some((label, value)) = label(line) else { continue };
        match label.as_str() {
            "XYDATA" | "XYPOINTS" | "PEAKTABLE" => {
                let rows = lines.map(|(n, line)| (n, content(line)));
                let rows = rows.take_while(|(_, line)| !line.starts_with("##"));
                break match label.as_str() {
                    "XYDATA" if value.contains("++") => ordinates(&header, rows)?,
                    _ => pairs(&header, rows)?,
                };
            }
            _ => header.state(&label, value, number)?,
        }
    };
    Ok(header.found(&points))
}

fn problem(line: u32, what: impl Into<String>) -> TextProblem {
    TextProblem { line: u64::from(line), what: what.into() }
}

/// A line without its comment.
fn content(line: &str) -> &str {
    line.split("$$").next().unwrap_or_default().trim()
}

/// A label in capitals without blanks and marks, and its value.
fn label(line: &str) -> Option<(String, &str)> {
    let (label, value) = content(line).strip_prefix("##")?.split_once('=')?;
    let kept = label.chars().filter(|c| c.is_alphanumeric());
    Some((kept.collect::<String>().to_uppercase(), value.trim()))
}

impl JcampLabels {
    fn state(&mut self, label: &str, value: &str, line: u32) -> Result<(), TextProblem> {
        let number = || {
            let style = Style::new(Separator::Tab, DecimalMark::Point);
            let commas = Style::new(Separator::Tab, DecimalMark::Comma);
            let number = style.number(value).or_else(|| commas.number(value));
            number
                .filter(|n| n.is_finite())
                .ok_or_else(|| problem(line, format!("{label} is \"{value}\", expected a number")))
        };
        match label {
            "XFACTOR" => self.x_factor = number()?,
            "YFACTOR" => self.y_factor = number()?,
            "FIRSTX" => self.first_x = Some(number()?),
            "LASTX" => self.last_x = Some(number()?),
            "NPOINTS" => self.points = Some(number()?.max(0.0) as usize),
            "XUNITS" => self.x_units = value.to_owned(),
            "YUNITS" => self.y_units = value.to_owned(),
            _ => {}
        }
        Ok(())
    }

    fn found(&self, points: &[(f64, f64, u32)]) -> Found {
        let mut text = String::new();
        for (x, y, _) in points {
            let _ = writeln!(text, "{x}\t{y}"); // into a string: cannot fail
        }
        let numbers: Vec<u32> = points.iter().map(|point| point.2).collect();
        let notes = [("x", &self.x_units), ("y", &self.y_units)];
        let notes = notes.iter().filter(|(_, unit)| !unit.is_empty());
        Found {
            format: TableFormat::Jcamp,
            style: Style::new(Separator::Tab, DecimalMark::Point),
            names: vec![format!("wavelength ({})", self.x_units), self.y_units.clone()],
            keywords: Vec::new(),
            rows: spdx::anew_rows(&text, &numbers),
            notes: notes.map(|(axis, unit)| format!("{axis} in {unit}")).collect(),
            text: Some(text),
        }
    }
}

type Points = Vec<(f64, f64, u32)>;

/// (X++(Y..Y)): each line an abscissa, for checking, and ordinates.
fn ordinates<'a>(
    header: &JcampLabels,
    rows: impl Iterator<Item = (u32, &'a str)>,
) -> Result<Points, TextProblem> {
    let mut values: Vec<(f64, u32)> = Vec::new();
    let mut is_check = false;
    for (line, content) in rows.filter(|(_, content)| !content.is_empty()) {
        let mut unpacked = Unpacked::default();
        unpacked.take(content).map_err(|what| problem(line, what))?;
        let [_, ordinates @ ..] = unpacked.values.as_slice() else { continue };
        let fresh = match (ordinates.first(), values.last()) {
            (Some(first), Some((last, _))) if is_check => {
                if first != last {
                    let what = format!("starts with {first}, the line before ends with {last}");
                    return Err(problem(line, what));
                }
                &ordinates[1..]
            }
            _ => ordinates,
        };
        values.extend(fresh.iter().map(|&value| (value, line)));
        if values.len() > MOST_POINTS {
            return Err(problem(line, format!("more than {MOST_POINTS} points")));
        }
        // A line that ends in differences gives its last ordinate again in the next one.
        is_check = unpacked.difference.is_some();
    }
    evenly_spaced(header, &values)
}

fn evenly_spaced(header: &JcampLabels, values: &[(f64, u32)]) -> Result<Points, TextProblem> {
    let (Some(first), Some(last)) = (header.first_x, header.last_x) else {
        return Err(problem(0, "no \"##FIRSTX\" or no \"##LASTX\" in the JCAMP-DX file"));
    };
    if let Some(stated) = header.points.filter(|&points| points != values.len()) {
        let what = format!("##NPOINTS is {stated}, the data hold {} points", values.len());
        return Err(problem(0, what));
    }
    let step = (last - first) / (values.len().max(2) - 1) as f64;
    let point = |(at, &(value, line)): (usize, &(f64, u32))| {
        (first + step * at as f64, value * header.y_factor, line)
    };
    Ok(values.iter().enumerate().map(point).collect())
}

/// A line's numbers.
#[derive(Default)]
struct Unpacked {
    values: Vec<f64>,
    /// The last difference, if the last number was one.
    difference: Option<f64>,
}

/// What a number's first character makes of it.
enum Form {
    Absolute,
    Difference,
    Repeated,
}

impl Unpacked {
    fn take(&mut self, line: &str) -> Result<(), String> {
        let mut rest = line;
        loop {
            rest = rest.trim_start_matches([' ', '\t', ',', ';']);
            let Some(first) = rest.chars().next() else { return Ok(()) };
            let (form, lead) = form_of(first)
                .ok_or_else(|| format!("'{first}' is no form of a number that JCAMP-DX has"))?;
            let body = &rest[usize::from(lead.is_some())..];
            let length = number_length(body);
            let text = format!("{}{}", lead.unwrap_or_default(), &body[..length]);
            let number: f64 = text.parse().map_err(|_| format!("\"{text}\" is no number"))?;
            self.add(form, number)?;
            rest = &body[length..];
        }
    }

    fn add(&mut self, form: Form, number: f64) -> Result<(), String> {
        let last = self.values.last().copied();
        match form {
            Form::Absolute => {
                self.difference = None;
                self.values.push(number);
            }
            Form::Difference => {
                self.difference = Some(number);
                self.values.push(last.ok_or("a difference to nothing")? + number);
            }
            Form::Repeated => {
                let last = last.ok_or("a repetition of nothing")?;
                let count = (number as usize).saturating_sub(1);
                if count > MOST_POINTS {
                    return Err(format!("{count} repetitions, allowed: up to {MOST_POINTS}"));
                }
                let step = self.difference.unwrap_or(0.0);
                self.values.extend((1..=count).map(|n| last + step * n as f64));
            }
        }
        Ok(())
    }
}

/// The form, and the sign and digit that a letter stands for.
fn form_of(first: char) -> Option<(Form, Option<String>)> {
    let lead = |sign: &str, zero: u8| Some(format!("{sign}{}", first as u8 - zero));
    Some(match first {
        '0'..='9' | '.' | '+' | '-' => (Form::Absolute, None),
        '@'..='I' => (Form::Absolute, lead("", b'@')),
        'a'..='i' => (Form::Absolute, lead("-", b'a' - 1)),
        '%' => (Form::Difference, Some("0".to_owned())),
        'J'..='R' => (Form::Difference, lead("", b'J' - 1)),
        'j'..='r' => (Form::Difference, lead("-", b'j' - 1)),
        'S'..='Z' => (Form::Repeated, lead("", b'S' - 1)),
        's' => (Form::Repeated, Some("9".to_owned())),
        _ => return None,
    })
}

/// Bytes of digits, a point, and an exponent with a sign; a sign else starts the next number.
fn number_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let mut at = usize::from(matches!(bytes, [b'+' | b'-', ..]));
    loop {
        at = match bytes[at..] {
            [b'0'..=b'9' | b'.', ..] => at + 1,
            [b'E' | b'e', b'+' | b'-', b'0'..=b'9', ..] if at > 0 => at + 2,
            _ => return at,
        };
    }
}

/// (XY..XY): pairs, parted by blanks, commas or semicolons.
fn pairs<'a>(
    header: &JcampLabels,
    rows: impl Iterator<Item = (u32, &'a str)>,
) -> Result<Points, TextProblem> {
    let mut points = Vec::new();
    for (line, content) in rows.filter(|(_, content)| !content.is_empty()) {
        let cells: Vec<&str> =
            content.split([' ', '\t', ',', ';']).filter(|c| !c.is_empty()).collect();
        let numbers: Option<Vec<f64>> = cells.iter().map(|cell| cell.parse().ok()).collect();
        let numbers = numbers.filter(|numbers| numbers.len().is_multiple_of(2));
        let Some(numbers) = numbers else {
            return Err(problem(line, format!("\"{content}\", expected pairs of numbers")));
        };
        let scaled = |pair: &[f64]| (pair[0] * header.x_factor, pair[1] * header.y_factor, line);
        points.extend(numbers.chunks_exact(2).map(scaled));
    }
    Ok(points)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unpacked(line: &str) -> Vec<f64> {
        let mut unpacked = Unpacked::default();
        unpacked.take(line).unwrap();
        unpacked.values
    }

    /// The examples of McDonald & Wilks: one row in the forms AFFN, PAC, SQZ, DIF and DIF with DUP.
    #[test]
    fn all_forms_of_a_line_are_one() {
        let expected =
            [599.0, 0.0, 0.0, 0.0, 0.0, 2.0, 4.0, 4.0, 4.0, 7.0, 5.0, 4.0, 4.0, 5.0, 5.0];
        for line in [
            "599 0 0 0 0 2 4 4 4 7 5 4 4 5 5",
            "599+0+0+0+0+2+4+4+4+7+5+4+4+5+5",
            "599@@@@BDDDGEDDEE",
            "599@%%%KK%%Lkj%J%",
            "599@VKT%TLkj%J%",
        ] {
            assert_eq!(unpacked(line), expected, "{line}");
        }
        assert_eq!(unpacked("400 -1.5E-2+3"), [400.0, -0.015, 3.0]);
        assert_eq!(unpacked("400b5 a"), [400.0, -25.0, -1.0]);
    }

    #[test]
    fn differences_are_checked_from_line_to_line() {
        let file = |second: &str| {
            format!(
                "##TITLE=t\n##XUNITS=NANOMETERS\n##YFACTOR=0.5\n##FIRSTX=400\n##LASTX=405\n\
                 ##NPOINTS=6\n##XYDATA=(X++(Y..Y))\n400A0JJ\n{second}\n##END=\n"
            )
        };
        let found = read(&file("402A2JJJ")).unwrap();
        assert_eq!(found.text.unwrap(), "400\t5\n401\t5.5\n402\t6\n403\t6.5\n404\t7\n405\t7.5\n");
        assert_eq!(found.rows[3].number, 9);
        let problem = read(&file("402A3JJJ")).err().unwrap();
        assert_eq!(problem.what, "starts with 13, the line before ends with 12");
        let problem = read(&file("402A2J")).err().unwrap();
        assert_eq!(problem.what, "##NPOINTS is 6, the data hold 4 points");
    }

    #[test]
    fn pairs_are_scaled() {
        let text = "##TITLE=t\n##XFACTOR=1000\n##XYPOINTS=(XY..XY)\n0.4,1 0.5,2\n0.6 3\n##END=\n";
        assert_eq!(read(text).unwrap().text.unwrap(), "400\t1\n500\t2\n600\t3\n");
    }
}
