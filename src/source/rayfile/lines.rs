//! Rays as lines of decimal numbers, parsed in parallel.

use std::sync::Arc;

use rayon::prelude::*;

use super::input::Input;
use super::record::{Flaw, Layout, check_stray};
use super::spectral::Tally;
use super::{FluxUnit, Rays};
use crate::columns::DecimalMark;
use crate::error::{Error, Place, Result};
use crate::light::RaySample;

/// Bytes that one task parses. Sums run within a piece, then over pieces in order.
const PIECE_BYTES: usize = 1 << 18;

/// Bytes read at once.
const BATCH_BYTES: usize = 1 << 22;

/// No line of a ray file comes near this; without a bound, a file without line ends would be read
/// whole to be refused.
const LONGEST_LINE: usize = 1 << 16;

/// Rays a segment: 58 MB, which the allocator maps and returns to the system one by one.
const SEGMENT_RAYS: usize = 1 << 21;

/// The most columns that a text format has.
pub(super) const MAX_COLUMNS: usize = 16;

/// The fewest that a ray has, in a set without start points.
const FEWEST_COLUMNS: usize = 4;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum RowSeparator {
    /// Runs of blanks and tabs.
    Blank,
    Byte(u8),
}

impl RowSeparator {
    /// The separator that a row uses.
    pub fn of(line: &[u8]) -> Self {
        let words = || line.split(u8::is_ascii_whitespace).filter(|cell| !cell.is_empty());
        // Commas within the words of such a row are decimal marks.
        let is_row_of_words =
            words().count() >= FEWEST_COLUMNS && !words().any(|w| w.ends_with(b","));
        match [b';', b','].into_iter().find(|b| line.contains(b)) {
            Some(b',') if is_row_of_words => Self::Blank,
            Some(byte) => Self::Byte(byte),
            None => Self::Blank,
        }
    }

    pub fn split(self, line: &[u8]) -> impl Iterator<Item = &[u8]> {
        line.split(move |&b| match self {
            Self::Blank => b.is_ascii_whitespace(),
            Self::Byte(byte) => b == byte,
        })
        .filter(move |cell| self != Self::Blank || !cell.is_empty())
        .map(<[u8]>::trim_ascii)
    }
}

/// How the rows of a text file read.
pub(super) struct RowFormat<'a> {
    pub layout: &'a Layout,
    pub unit: FluxUnit,
    pub separator: RowSeparator,
    pub decimal: DecimalMark,
    /// The line that ends the rows, where the format has one.
    pub end: Option<&'static str>,
}

/// A text file, line by line for its header and in bulk for its rows.
pub(super) struct Lines<'i, 'a> {
    input: &'i mut Input<'a>,
    buffer: Vec<u8>,
    at: usize,
    /// 1-based, of the line at `at`.
    number: u64,
}

impl<'i, 'a> Lines<'i, 'a> {
    pub fn new(input: &'i mut Input<'a>) -> Self {
        Self { input, buffer: Vec::new(), at: 0, number: 1 }
    }

    /// The next line without its end, or `None` after the last one.
    pub fn peek(&mut self) -> Result<Option<&[u8]>> {
        while !self.buffer[self.at..].contains(&b'\n') && self.input.bytes_left() > 0 {
            self.refill()?;
        }
        let rest = &self.buffer[self.at..];
        let line = rest.split(|&b| b == b'\n').next().unwrap_or_default();
        let line = if self.number == 1 { without_bom(line) } else { line };
        Ok((!rest.is_empty()).then_some(line.trim_ascii()))
    }

    /// Steps over the line that `peek` shows.
    pub fn advance(&mut self) {
        let rest = &self.buffer[self.at..];
        self.at += rest.iter().position(|&b| b == b'\n').map_or(rest.len(), |end| end + 1);
        self.number += 1;
    }

    /// Steps over blank lines and `#` comments, and shows what follows.
    pub fn peek_content(&mut self) -> Result<Option<&[u8]>> {
        while self.peek()?.is_some_and(is_skipped) {
            self.advance();
        }
        self.peek()
    }

    pub fn bad(&self, problem: impl Into<String>) -> Error {
        self.input.bad_at(Place::Line(self.number), problem)
    }

    fn refill(&mut self) -> Result<()> {
        let kept = self.buffer.len() - self.at;
        if kept > LONGEST_LINE && !self.buffer[self.at..].contains(&b'\n') {
            return Err(self.bad(format!("a line of more than {LONGEST_LINE} bytes")));
        }
        self.buffer.drain(..self.at);
        self.at = 0;
        let left = usize::try_from(self.input.bytes_left()).unwrap_or(usize::MAX);
        let room = if kept == 0 || kept > LONGEST_LINE { BATCH_BYTES } else { BATCH_BYTES - kept };
        self.buffer.resize(kept + room.min(left), 0);
        let found = self.input.fill(&mut self.buffer[kept..])?;
        self.buffer.truncate(kept + found);
        if found == 0 && self.input.bytes_left() > 0 {
            return Err(self.bad("the file became shorter while it was read"));
        }
        Ok(())
    }

    /// Reads rows to the end marker, or to the end of the file.
    ///
    /// Errors: the first line that is not a row, and a missing end marker.
    pub fn read_rows(mut self, table: &RowFormat) -> Result<Rays> {
        let mut segments = Segments::default();
        let mut tally = Tally::default();
        loop {
            let last = self.input.bytes_left() == 0;
            let rest = &self.buffer[self.at..];
            let whole = match (last, rest.iter().rposition(|&b| b == b'\n')) {
                (true, _) => rest.len(),
                (false, Some(end)) => end + 1,
                (false, None) => 0,
            };
            let pieces: Vec<RowPiece> = split_at_lines(&rest[..whole])
                .into_par_iter()
                .map(|text| table.parse(text))
                .collect();
            for piece in pieces {
                segments.append(&piece.samples);
                // Lines from 0; that of a fault is from 1.
                tally.merge(self.number - 1, &piece.tally);
                self.number += piece.lines;
                match piece.stop {
                    None => {}
                    Some(Stop::End) => return self.finished(segments, tally),
                    Some(Stop::Flaw(flaw)) => return Err(self.bad(flaw.to_string())),
                    Some(Stop::Fault(problem)) => return Err(self.bad(problem)),
                }
            }
            self.at += whole;
            if last {
                return match table.end {
                    Some(end) => Err(self.bad(format!("the file ends without \"{end}\""))),
                    None => self.finished(segments, tally),
                };
            }
            self.refill()?;
        }
    }
}

impl Lines<'_, '_> {
    fn finished(self, segments: Segments, tally: Tally) -> Result<Rays> {
        check_stray(self.input, &tally, Place::Line)?;
        Ok(Rays { samples: segments.into_arc(), tally })
    }
}

pub(super) fn without_bom(line: &[u8]) -> &[u8] {
    line.strip_prefix(b"\xef\xbb\xbf").unwrap_or(line)
}

pub(super) fn is_skipped(line: &[u8]) -> bool {
    line.is_empty() || line.starts_with(b"#")
}

/// Cuts text into runs of whole lines of about [`PIECE_BYTES`].
fn split_at_lines(mut text: &[u8]) -> Vec<&[u8]> {
    let mut pieces = Vec::new();
    while text.len() > PIECE_BYTES {
        let end = text[PIECE_BYTES..].iter().position(|&b| b == b'\n');
        let (piece, rest) = text.split_at(end.map_or(text.len(), |end| PIECE_BYTES + end + 1));
        pieces.push(piece);
        text = rest;
    }
    pieces.push(text);
    pieces
}

#[derive(Default)]
struct RowPiece {
    samples: Vec<RaySample>,
    tally: Tally,
    /// Lines before the one that stopped it, or all.
    lines: u64,
    stop: Option<Stop>,
}

enum Stop {
    End,
    Flaw(Flaw),
    Fault(String),
}

impl RowFormat<'_> {
    fn parse(&self, text: &[u8]) -> RowPiece {
        let mut piece = RowPiece::default();
        for line in text.split_inclusive(|&b| b == b'\n').map(<[u8]>::trim_ascii) {
            if !is_skipped(line) {
                match self.parse_line(line, &mut piece.tally) {
                    Ok(sample) => piece.samples.push(sample),
                    Err(Stop::Flaw(flaw)) if flaw.is_stray() => piece.tally.drop(piece.lines, flaw),
                    Err(stop) => {
                        piece.stop = Some(stop);
                        break;
                    }
                }
            }
            piece.lines += 1;
        }
        piece
    }

    fn parse_line(&self, line: &[u8], tally: &mut Tally) -> std::result::Result<RaySample, Stop> {
        if self.end.is_some_and(|end| line.starts_with(end.as_bytes())) {
            return Err(Stop::End);
        }
        let row = self.numbers(line).map_err(Stop::Fault)?;
        let record = self.layout.record(|column| row[column]);
        record.and_then(|record| tally.add(self.layout, self.unit, record)).map_err(Stop::Flaw)
    }

    fn numbers(&self, line: &[u8]) -> std::result::Result<[f32; MAX_COLUMNS], String> {
        let mut row = [0.0; MAX_COLUMNS];
        let mut count = 0;
        for cell in self.separator.split(line) {
            if let Some(place) = row.get_mut(count) {
                *place = number_with(self.decimal, cell).ok_or_else(|| {
                    let cell = String::from_utf8_lossy(&cell[..cell.len().min(40)]).into_owned();
                    format!("column {} is \"{cell}\", expected a number", count + 1)
                })?;
            }
            count += 1;
        }
        if count == self.layout.columns {
            return Ok(row);
        }
        Err(format!("a row of {count} numbers, expected {}", self.layout.columns))
    }
}

/// The decimal mark of a row: commas, where they do not part its cells and no cell has a point.
pub(super) fn decimal_of(separator: RowSeparator, row: &[u8]) -> DecimalMark {
    let is_comma =
        separator != RowSeparator::Byte(b',') && row.contains(&b',') && !row.contains(&b'.');
    if is_comma { DecimalMark::Comma } else { DecimalMark::Point }
}

/// A number's cell.
pub(super) fn number_with(decimal: DecimalMark, cell: &[u8]) -> Option<f32> {
    /// No number is longer.
    const LONGEST: usize = 64;
    if decimal == DecimalMark::Point {
        return number(cell);
    }
    let mut buffer = [0; LONGEST];
    let point = buffer.get_mut(..cell.len())?;
    point.copy_from_slice(cell);
    if let Some(at) = point.iter().position(|&b| b == b',') {
        point[at] = b'.';
    }
    number(point)
}

pub(super) fn number(cell: &[u8]) -> Option<f32> {
    std::str::from_utf8(cell).ok()?.parse().ok()
}

/// Samples in pieces that never move, until their number is known.
#[derive(Default)]
struct Segments(Vec<Vec<RaySample>>);

impl Segments {
    fn append(&mut self, mut samples: &[RaySample]) {
        while !samples.is_empty() {
            if self.0.last().is_none_or(|segment| segment.len() == SEGMENT_RAYS) {
                self.0.push(Vec::new());
            }
            let Some(segment) = self.0.last_mut() else { return };
            let (now, later) = samples.split_at(samples.len().min(SEGMENT_RAYS - segment.len()));
            segment.extend_from_slice(now);
            samples = later;
        }
    }

    /// Frees each segment once it is moved, so that two copies never stand side by side.
    fn into_arc(self) -> Arc<[RaySample]> {
        let count: usize = self.0.iter().map(Vec::len).sum();
        let mut samples = self.0.into_iter().flatten();
        // A counted range makes `collect` allocate once; the samples run out exactly with it.
        let zero = RaySample { position: [0.0; 3], direction: [0.0; 3], flux: 0.0 };
        (0..count).map(|_| samples.next().unwrap_or(zero)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_keep_order_and_number() {
        let sample = |i: usize| RaySample {
            position: [i as f32, 0.0, 0.0],
            direction: [0.0, 0.0, 1.0],
            flux: 1.0,
        };
        let all: Vec<RaySample> = (0..SEGMENT_RAYS + 10).map(sample).collect();
        let mut segments = Segments::default();
        for run in all.chunks(100_003) {
            segments.append(run);
        }
        assert_eq!(*segments.into_arc(), *all);
    }

    #[test]
    fn pieces_are_whole_lines() {
        let text: Vec<u8> = (0..100_000).flat_map(|i| format!("{i}\n").into_bytes()).collect();
        let pieces = split_at_lines(&text);
        assert!(pieces.len() > 1);
        assert!(pieces.iter().all(|piece| piece.ends_with(b"\n")));
        assert_eq!(pieces.concat(), text);
    }
}
