//! IES TM-27 `.spdx`: XML in which `SpectralData` elements hold a wavelength and a value each.

use std::fmt::Write;

use super::cells::{DecimalMark, Separator, Style};
use super::{Found, Line, TableFormat, TextProblem};

const TAB: Style = Style::new(Separator::Tab, DecimalMark::Point);

/// The rows are written anew, in the numbers of the lines that they stood in.
pub(super) fn read(text: &str) -> Result<Found, TextProblem> {
    let (mut anew, mut lines) = (String::new(), Vec::new());
    let mut quantity = None;
    let mut comment = false;
    let mut rest = text;
    while let Some(open) = rest.find('<') {
        let after = &rest[open + 1..];
        comment |= after.starts_with("!--");
        let end = if comment { after.find("-->") } else { after.find('>') };
        let Some(end) = end else { break };
        let (tag, content) = (&after[..end], &after[end..]);
        let content = content.trim_start_matches(['-', '>']).split('<').next().unwrap_or_default();
        if !comment {
            match local_name(tag) {
                "SpectralQuantity" => quantity = Some(content.trim().to_owned()),
                "SpectralData" => {
                    let number = line_of(text, tag);
                    let (nm, value) =
                        entry(tag, content).ok_or_else(|| bad(number, tag, content))?;
                    let _ = writeln!(anew, "{nm}\t{value}"); // into a string: cannot fail
                    lines.push(number);
                }
                _ => {}
            }
        }
        comment = false;
        rest = &after[end..];
    }
    if lines.is_empty() {
        let what = "XML without \"SpectralData\" elements, as IES TM-27 has them".to_owned();
        return Err(TextProblem { line: 0, what });
    }
    let notes = quantity.map(|quantity| format!("spectral quantity: {quantity}")).into_iter();
    Ok(Found {
        format: TableFormat::Spdx,
        style: TAB,
        names: vec!["wavelength_nm".to_owned(), "value".to_owned()],
        keywords: Vec::new(),
        rows: anew_rows(&anew, &lines),
        notes: notes.collect(),
        text: Some(anew),
    })
}

/// The lines of a text that was written anew, with the numbers that they had.
pub(super) fn anew_rows(text: &str, numbers: &[u32]) -> Vec<Line> {
    text.lines().zip(numbers).map(|(line, &number)| Line::of(text, line, number)).collect()
}

/// A tag's name without namespace and attributes; none of an end tag.
fn local_name(tag: &str) -> &str {
    let name = tag.split(|c: char| c.is_whitespace() || c == '/').next().unwrap_or_default();
    name.rsplit(':').next().unwrap_or(name)
}

fn entry<'a>(tag: &'a str, content: &'a str) -> Option<(f64, f64)> {
    let (_, after) = tag.split_once("wavelength")?;
    let quoted = after.trim_start().strip_prefix('=')?.trim_start();
    let quote = quoted.chars().next().filter(|c| matches!(c, '"' | '\''))?;
    let nm = quoted[1..].split(quote).next()?;
    Some((TAB.number(nm.trim())?, TAB.number(content.trim())?))
}

fn bad(line: u32, tag: &str, content: &str) -> TextProblem {
    let short = |text: &str| -> String { text.trim().chars().take(60).collect() };
    let what = format!(
        "<{}>{}: expected <SpectralData wavelength=\"nm\">value",
        short(tag),
        short(content)
    );
    TextProblem { line: u64::from(line), what }
}

fn line_of(text: &str, part: &str) -> u32 {
    let at = part.as_ptr().addr() - text.as_ptr().addr();
    1 + text.as_bytes()[..at].iter().filter(|&&b| b == b'\n').count() as u32
}
