//! Lines into cells, and cells into numbers.

use std::borrow::Cow;
use std::fmt;

/// What stands between the cells of a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Separator {
    /// One tab.
    Tab,
    /// One semicolon.
    Semicolon,
    /// One comma.
    Comma,
    /// Blanks and tabs, as many as there are.
    Blank,
}

/// What stands before a number's decimals.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DecimalMark {
    /// 0.85
    Point,
    /// 0,85
    Comma,
}

impl fmt::Display for Separator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Tab => "tabs",
            Self::Semicolon => "semicolons",
            Self::Comma => "commas",
            Self::Blank => "blanks",
        })
    }
}

impl fmt::Display for DecimalMark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Point => "points",
            Self::Comma => "commas",
        })
    }
}

/// How the rows of a file are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Style {
    /// Between cells.
    pub separator: Separator,
    /// Within numbers.
    pub decimal: DecimalMark,
}

impl Style {
    /// All that are met, by preference: the first of those that explain a file best.
    ///
    /// Commas for both can only be told apart where the numbers stand in quotes.
    pub(super) const ALL: [Self; 8] = [
        Self::new(Separator::Tab, DecimalMark::Point),
        Self::new(Separator::Tab, DecimalMark::Comma),
        Self::new(Separator::Semicolon, DecimalMark::Point),
        Self::new(Separator::Semicolon, DecimalMark::Comma),
        Self::new(Separator::Blank, DecimalMark::Point),
        Self::new(Separator::Blank, DecimalMark::Comma),
        Self::new(Separator::Comma, DecimalMark::Point),
        Self::new(Separator::Comma, DecimalMark::Comma),
    ];

    pub(super) const fn new(separator: Separator, decimal: DecimalMark) -> Self {
        Self { separator, decimal }
    }

    /// The cells of a line, without quotes and the blanks around them.
    pub fn cells(self, line: &str) -> LineCells<'_> {
        LineCells { style: self, rest: Some(line.trim()) }
    }

    /// The number in a cell; "95 %" is 0.95 and "380 nm" is 380.
    pub fn number(self, cell: &str) -> Option<f64> {
        let is_plain = |b: u8| b.is_ascii_digit() || matches!(b, b'.' | b'-');
        if self.decimal == DecimalMark::Point && cell.bytes().all(is_plain) {
            return cell.parse().ok();
        }
        if let Some(percent) = cell.strip_suffix('%') {
            return Some(self.bare_number(percent.trim_end())? / 100.0);
        }
        let bare = ["nm", "°", "deg"].into_iter().find_map(|unit| cell.strip_suffix(unit));
        self.bare_number(bare.unwrap_or(cell).trim_end())
    }

    fn bare_number(self, cell: &str) -> Option<f64> {
        let mut cell = Cow::from(cell);
        if cell.contains('\u{2212}') {
            cell = cell.replace('\u{2212}', "-").into();
        }
        if self.decimal == DecimalMark::Comma {
            let decimals = cell.split_once(',').map(|(_, decimals)| decimals);
            if cell.contains('.') || decimals.is_some_and(|d| !d.starts_with(is_digit)) {
                return None;
            }
            cell = cell.replacen(',', ".", 1).into();
        }
        // Fortran's double precision.
        if cell.starts_with(|c: char| is_digit(c) || matches!(c, '+' | '-' | '.'))
            && cell.contains(['d', 'D'])
        {
            cell = cell.replace(['d', 'D'], "e").into();
        }
        cell.parse().ok()
    }
}

fn is_digit(c: char) -> bool {
    c.is_ascii_digit()
}

/// The cells of one line.
pub struct LineCells<'a> {
    style: Style,
    /// `None` after the last cell.
    rest: Option<&'a str>,
}

impl<'a> Iterator for LineCells<'a> {
    type Item = &'a str;

    fn next(&mut self) -> Option<&'a str> {
        let rest = self.rest?.trim_start_matches([' ', '\u{a0}']);
        let (cell, after) = match rest.strip_prefix('"').and_then(quoted) {
            Some((cell, after)) => (cell, after.trim_start_matches([' ', '\u{a0}'])),
            None => {
                let end = rest.find(|c| self.is_end(c)).unwrap_or(rest.len());
                (&rest[..end], &rest[end..])
            }
        };
        self.rest = self.step(after);
        Some(cell.trim())
    }
}

impl<'a> LineCells<'a> {
    fn is_end(&self, c: char) -> bool {
        match self.style.separator {
            Separator::Tab => c == '\t',
            Separator::Semicolon => c == ';',
            Separator::Comma => c == ',',
            Separator::Blank => c.is_whitespace(),
        }
    }

    /// What follows the separator, from behind a cell on.
    fn step(&self, after: &'a str) -> Option<&'a str> {
        match self.style.separator {
            Separator::Blank => Some(after.trim_start()).filter(|rest| !rest.is_empty()),
            _ => {
                let end = after.find(|c| self.is_end(c))?;
                Some(&after[end + 1..])
            }
        }
    }
}

/// A cell up to its closing quote, and what follows.
fn quoted(text: &str) -> Option<(&str, &str)> {
    let mut from = 0;
    loop {
        let end = from + text[from..].find('"')?;
        if !text[end + 1..].starts_with('"') {
            return Some((&text[..end], &text[end + 1..]));
        }
        from = end + 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells(separator: Separator, line: &str) -> Vec<&str> {
        Style::new(separator, DecimalMark::Point).cells(line).collect()
    }

    #[test]
    fn lines_are_cut_at_their_separator() {
        assert_eq!(cells(Separator::Comma, " 1, 2 ,,\"a, b\" ,3"), ["1", "2", "", "a, b", "3"]);
        assert_eq!(cells(Separator::Comma, "1,"), ["1", ""]);
        assert_eq!(cells(Separator::Blank, "  1\t 2  3 "), ["1", "2", "3"]);
        assert_eq!(cells(Separator::Blank, "\"a b\" 2"), ["a b", "2"]);
        assert_eq!(cells(Separator::Tab, "1\t\t 2 3"), ["1", "", "2 3"]);
        assert_eq!(cells(Separator::Semicolon, "\"x\"\"y\";2"), ["x\"\"y", "2"]);
        assert_eq!(cells(Separator::Comma, "\"open"), ["\"open"]);
        assert_eq!(cells(Separator::Comma, ""), [""]);
    }

    #[test]
    fn numbers_as_people_and_programs_write_them() {
        let point = Style::new(Separator::Tab, DecimalMark::Point);
        let comma = Style::new(Separator::Tab, DecimalMark::Comma);
        for (style, cell, value) in [
            (point, "0.85", 0.85),
            (point, "-.5", -0.5),
            (point, "+5.", 5.0),
            (point, "4.1168E-04", 4.1168e-4),
            (point, "1.5D-03", 1.5e-3),
            (point, "\u{2212}2", -2.0),
            (point, "95 %", 0.95),
            (point, "380nm", 380.0),
            (point, "12.5°", 12.5),
            (comma, "0,85", 0.85),
            (comma, "4,1168E-04", 4.1168e-4),
            (comma, "-0,5", -0.5),
            (comma, "380", 380.0),
        ] {
            assert_eq!(style.number(cell), Some(value), "{cell}");
        }
        for (style, cell) in [
            (point, "0,85"),
            (point, ""),
            (point, "-"),
            (point, "1-2"),
            (point, "1.2.3"),
            (point, "d"),
            (comma, "1.234,5"),
            (comma, "1,"),
            (comma, "1,2,3"),
            (comma, "0.85"),
        ] {
            assert_eq!(style.number(cell), None, "{cell}");
        }
    }
}
