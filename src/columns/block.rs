//! Where in a text the rows of numbers are: told by what the lines are like.

use super::cells::{DecimalMark, Separator, Style};
use super::{Line, TextProblem};

/// The rows of a text without a format of its own, and what stands around them.
#[derive(Debug)]
pub(super) struct NumberBlock {
    pub style: Style,
    pub rows: Vec<Line>,
    /// Lines of words above the rows, nearest first: two at most, and the comment above them.
    pub header: Vec<Line>,
    /// Lines above the rows that are no rows, header included, and below.
    pub above: usize,
    pub below: usize,
    /// The first line below.
    pub end: Option<Line>,
}

/// What a line is like under a style.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum LineShape {
    /// Two numbers at least, and no less than half of the cells.
    Row {
        starts_with_number: bool,
    },
    /// One number, in front: a row whose other cells are missing or words.
    Broken,
    Words,
}

/// Lines that decide a style: a header is shorter, and all lines of a long table are alike.
const DECIDING_LINES: usize = 2000;

/// The rows of `text`, or none.
pub(super) fn find(text: &str) -> Result<Option<NumberBlock>, TextProblem> {
    let lines = content_lines(text);
    let Some(style) = style_of(text, &lines[..lines.len().min(DECIDING_LINES)])
        .or_else(|| style_of(text, &lines))
    else {
        return match lines.iter().find(|line| has_both_marks(line.text(text))) {
            Some(line) => Err(line.problem(format!(
                "\"{}\" has points and commas in one number, expected one decimal mark",
                line.text(text)
            ))),
            None => Ok(None),
        };
    };
    let shapes: Vec<LineShape> = lines.iter().map(|line| shape(style, line.text(text))).collect();
    let Some((first, last)) = longest_run(&shapes) else { return Ok(None) };
    check_around(text, style, &lines, &shapes, (first, last))?;
    if style.separator == Separator::Comma {
        check_width(text, style, &lines[first..last])?;
    }
    let mut header: Vec<Line> = lines[..first].iter().rev().take(2).copied().collect();
    header.extend(comment_above(text, &lines[first]));
    let (above, below) = (first, lines.len() - last);
    let end = lines.get(last).copied();
    let mut rows = lines;
    rows.truncate(last);
    rows.drain(..first);
    Ok(Some(NumberBlock { style, rows, header, above, below, end }))
}

/// A line without its comment.
fn without_comment(line: &str) -> &str {
    line.split('#').next().unwrap_or_default().trim()
}

/// Whether the whole line is a comment. No number starts with one of these.
fn is_comment(line: &str) -> bool {
    ["#", "%", "!", "//"].iter().any(|mark| line.starts_with(mark))
}

/// All lines but blank ones and comments.
pub(super) fn content_lines(text: &str) -> Vec<Line> {
    let content = |line: &str| !is_comment(line.trim()) && !without_comment(line).is_empty();
    let count = text.split('\n').filter(|line| content(line)).count();
    let mut lines = Vec::with_capacity(count);
    for (number, line) in (1..).zip(text.split('\n')) {
        if content(line) {
            lines.push(Line::of(text, without_comment(line), number));
        }
    }
    lines
}

/// The comment right above a line, which may hold names and units.
fn comment_above(text: &str, line: &Line) -> Option<Line> {
    let before = text[..line.start as usize].trim_end();
    let comment = before.rsplit('\n').next().map(str::trim).filter(|line| is_comment(line))?;
    Some(Line::of(text, comment.trim_start_matches(['#', '%', '!', '/']).trim(), 0))
}

/// The style under which most of the lines are rows.
fn style_of(text: &str, lines: &[Line]) -> Option<Style> {
    let mut best = (0.0, None);
    for style in Style::ALL {
        let score: f64 = lines.iter().map(|line| share_of_numbers(style, line.text(text))).sum();
        if score > best.0 {
            best = (score, Some(style));
        }
    }
    best.1
}

struct NumberCount {
    numbers: usize,
    filled: usize,
    starts_with_number: bool,
}

fn count(style: Style, line: &str) -> NumberCount {
    let mut count = NumberCount { numbers: 0, filled: 0, starts_with_number: false };
    for (at, cell) in style.cells(line).enumerate() {
        let is_number = style.number(cell).is_some();
        count.starts_with_number |= at == 0 && is_number;
        count.numbers += usize::from(is_number);
        count.filled += usize::from(!cell.is_empty());
    }
    count
}

fn is_row(count: &NumberCount) -> bool {
    count.numbers >= 2 && 2 * count.numbers >= count.filled
}

fn share_of_numbers(style: Style, line: &str) -> f64 {
    let count = count(style, line);
    if is_row(&count) { count.numbers as f64 / count.filled as f64 } else { 0.0 }
}

fn shape(style: Style, line: &str) -> LineShape {
    let count = count(style, line);
    match (is_row(&count), count.starts_with_number) {
        (true, starts_with_number) => LineShape::Row { starts_with_number },
        (false, true) => LineShape::Broken,
        (false, false) => LineShape::Words,
    }
}

/// From and to the lines of the longest run of rows that start alike; the first of equal ones.
fn longest_run(shapes: &[LineShape]) -> Option<(usize, usize)> {
    let (mut best, mut from) = ((0, 0), 0);
    for at in 0..shapes.len() {
        if at == 0 || shapes[at] != shapes[at - 1] {
            from = at;
        }
        if matches!(shapes[at], LineShape::Row { .. }) && at + 1 - from > best.1 - best.0 {
            best = (from, at + 1);
        }
    }
    (best.1 > 0).then_some(best)
}

/// Refuses rows that a line which is none cuts off from the others, and broken rows.
fn check_around(
    text: &str,
    style: Style,
    lines: &[Line],
    shapes: &[LineShape],
    (first, last): (usize, usize),
) -> Result<(), TextProblem> {
    let width = |at: usize| style.cells(lines[at].text(text)).count();
    let is_alike = |at: usize| shapes[at] == shapes[first] && width(at) == width(first);
    let is_broken = |at: usize| {
        shapes[at] == LineShape::Broken
            && shapes[first] == LineShape::Row { starts_with_number: true }
    };
    // A number alone above the rows is a count, as many formats have it.
    if let Some(at) = (0..first).find(|&at| is_alike(at)) {
        let cut = (at..first).find(|&at| !is_alike(at)).unwrap_or(first);
        return Err(not_a_row(text, style, &lines[cut], width(first)));
    }
    let broken_above = first.checked_sub(1).filter(|&at| is_broken(at) && width(at) > 1);
    let mut below = last..lines.len();
    let is_row_again = (last..lines.len()).any(is_alike);
    let bad = broken_above
        .or_else(|| below.find(|&at| is_broken(at)))
        .or((is_row_again && last < lines.len()).then_some(last));
    bad.map_or(Ok(()), |at| Err(not_a_row(text, style, &lines[at], width(first))))
}

fn not_a_row(text: &str, style: Style, line: &Line, width: usize) -> TextProblem {
    let content = line.text(text);
    let bad = style.cells(content).enumerate().find(|(_, cell)| style.number(cell).is_none());
    let found = style.cells(content).count();
    line.problem(match bad {
        _ if found != width => {
            format!("has {found} columns, the other rows have {width} (\"{content}\")")
        }
        Some((column, cell)) => {
            format!("column {} is \"{cell}\", expected a number", column + 1)
        }
        None => format!("\"{content}\" is no row like the others"),
    })
}

/// Refuses rows of commas that have more cells than others: their commas are decimal marks too.
fn check_width(text: &str, style: Style, rows: &[Line]) -> Result<(), TextProblem> {
    let width = |line: &Line| {
        let cells = style.cells(line.text(text)).enumerate();
        cells.filter(|(_, cell)| style.number(cell).is_some()).last().map_or(0, |(at, _)| at + 1)
    };
    if rows.iter().any(|line| line.text(text).contains('.')) {
        return Ok(());
    }
    let usual = rows.first().map_or(0, width);
    match rows.iter().find(|line| width(line) != usual) {
        None => Ok(()),
        Some(line) => Err(line.problem(format!(
            "has {} columns, the rows above have {usual} (\"{}\"){DECIMAL_COMMA}",
            width(line),
            line.text(text)
        ))),
    }
}

/// A hint, for rows of commas in which no number has a point.
pub(super) const DECIMAL_COMMA: &str =
    ": decimal commas? then write semicolons between the columns, or points in the numbers";

fn has_both_marks(line: &str) -> bool {
    let words =
        line.split([';', '\t', ' ']).filter(|word| word.starts_with(|c: char| c.is_ascii_digit()));
    words.into_iter().any(|word| {
        word.bytes().all(|b| b.is_ascii_digit() || b == b'.' || b == b',')
            && word.contains('.')
            && word.contains(',')
    })
}

/// Whether commas between the cells of the rows may be decimal marks as well.
pub(super) fn may_be_decimal_commas(text: &str, style: Style, rows: &[Line]) -> bool {
    style == Style::new(Separator::Comma, DecimalMark::Point)
        && !rows.iter().any(|line| line.text(text).contains('.'))
}
