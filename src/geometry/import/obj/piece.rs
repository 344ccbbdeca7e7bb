//! A part of the text, read without knowing what stands before it.

use super::super::polygons::NONE;
use super::scanner::Scanner;
use super::smoothing;
use crate::geometry::DVec3;
use crate::geometry::normals::Smoothing;

/// What a piece says about the polygons after it.
pub(super) enum Statement<'a> {
    /// Names of a `g`, with single blanks.
    Group(std::borrow::Cow<'a, [u8]>),
    Object(&'a [u8]),
    Material(&'a [u8]),
    Smoothing(Smoothing),
}

/// What is wrong, and at which byte of the piece.
pub(super) struct PieceFault {
    pub at: usize,
    pub problem: String,
}

/// Positions and normals so far.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Counts {
    pub positions: usize,
    pub normals: usize,
}

impl Counts {
    pub fn after(self, piece: &Piece) -> Self {
        Self {
            positions: self.positions + piece.positions.len(),
            normals: self.normals + piece.normals.len(),
        }
    }
}

/// What is to be true of indices: how many vertices stand before the piece, and how many there are.
type KnownCounts = Option<(Counts, Counts)>;

#[derive(Default)]
pub(super) struct Piece<'a> {
    pub positions: Vec<DVec3>,
    pub normals: Vec<DVec3>,
    /// Places of positions from 0, or, of those in `relative`, from the piece's first (as i32).
    pub corners: Vec<u32>,
    /// Likewise for normals; shorter than `corners` where the last ones have none.
    pub corner_normals: Vec<u32>,
    /// Where polygons end in `corners`.
    pub ends: Vec<u32>,
    pub statements: Vec<(u32, Statement<'a>)>,
    /// Corners whose index was negative.
    relative: Vec<u32>,
    relative_normals: Vec<u32>,
    pub free_forms: usize,
    known: KnownCounts,
}

impl<'a> Piece<'a> {
    /// Errors: a statement that is none. Indices are checked only if it is `known` what they may be.
    pub fn parse(bytes: &'a [u8], known: KnownCounts) -> Result<Self, PieceFault> {
        let mut piece = Self { known, ..Self::default() };
        let mut scanner = Scanner::new(bytes);
        while !scanner.is_at_end() {
            let at = scanner.at();
            let is_done = piece.statement(&mut scanner);
            is_done.map_err(|problem| PieceFault { at, problem })?;
            scanner.skip_line();
        }
        Ok(piece)
    }

    fn statement(&mut self, scanner: &mut Scanner<'a>) -> Result<(), String> {
        match scanner.word() {
            b"v" => self.position(scanner),
            b"f" | b"fo" => self.face(scanner),
            b"vn" => scanner.vector("normal").map(|normal| self.normals.push(normal)),
            b"g" => {
                let names = names(scanner);
                self.state(Statement::Group(names))
            }
            b"o" => {
                let name = scanner.rest_of_line();
                self.state(Statement::Object(name))
            }
            b"usemtl" => {
                let name = scanner.rest_of_line();
                self.state(Statement::Material(name))
            }
            b"s" => {
                let value = if scanner.is_at_word() { scanner.word() } else { b"off" };
                self.state(Statement::Smoothing(smoothing(value)))
            }
            b"curv" | b"curv2" | b"surf" => {
                self.free_forms += 1;
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn state(&mut self, statement: Statement<'a>) -> Result<(), String> {
        self.statements.push((self.ends.len() as u32, statement));
        Ok(())
    }

    /// x y z, and w if it is the only number more: colors are of no use here.
    fn position(&mut self, scanner: &mut Scanner) -> Result<(), String> {
        let mut position = scanner.vector("position")?;
        if scanner.is_at_word()
            && let (1, word) = scanner.count_words()
            && let Some(w) = Scanner::new(word).number().filter(|&w| w != 1.0)
        {
            position /= w;
            if !position.is_finite() {
                return Err(format!("position is not finite after its division by w = {w}"));
            }
        }
        self.positions.push(position);
        Ok(())
    }

    fn face(&mut self, scanner: &mut Scanner) -> Result<(), String> {
        let first = self.corners.len();
        while scanner.is_at_word() {
            self.corner(scanner)?;
        }
        let corners = self.corners.len() - first;
        if corners < 3 {
            return Err(format!("face has {corners} corners, expected 3 or more"));
        }
        self.ends.push(self.corners.len() as u32);
        Ok(())
    }

    /// `position/texture/normal`, the last two of which may be missing.
    fn corner(&mut self, scanner: &mut Scanner) -> Result<(), String> {
        let start = scanner.at();
        let position = scanner.index();
        let mut normal = None;
        let mut is_whole = position.is_some();
        if scanner.peek() == b'/' {
            scanner.bump();
            scanner.index();
            if scanner.peek() == b'/' {
                scanner.bump();
                if scanner.peek() > b' ' && scanner.peek() != b'\\' {
                    normal = scanner.index();
                    is_whole &= normal.is_some();
                }
            }
        }
        let is_whole = is_whole && (scanner.peek() <= b' ' || scanner.peek() == b'\\');
        match position {
            Some(position) if is_whole => self.push_corner(position, normal),
            _ => Err(not_an_index(start, scanner)),
        }
    }

    fn push_corner(&mut self, position: i64, normal: Option<i64>) -> Result<(), String> {
        let known = self.known.map(|(before, all)| (before.positions, all.positions));
        check_index(position, self.positions.len(), known)?;
        let corner = self.corners.len() as u32;
        if position < 0 {
            self.relative.push(corner);
        }
        self.corners.push(place(position, self.positions.len()));
        if let Some(normal) = normal {
            self.corner_normals.resize(corner as usize, NONE);
            if normal < 0 {
                self.relative_normals.push(corner);
            }
            self.corner_normals.push(place(normal, self.normals.len()));
        }
        Ok(())
    }

    /// Turns all places into those of the whole file, whether there or not.
    pub fn settle(&mut self, before: Counts) {
        settle(&mut self.corners, &self.relative, before.positions);
        if !self.corner_normals.is_empty() {
            self.corner_normals.resize(self.corners.len(), NONE);
            settle(&mut self.corner_normals, &self.relative_normals, before.normals);
        }
    }
}

/// A place that is never there.
pub(super) const NOWHERE: u32 = NONE - 1;

/// From 0; for a negative index how far after `count` of the piece, as i32.
fn place(index: i64, count: usize) -> u32 {
    if index < 0 {
        let place = count as i64 + index;
        i32::try_from(place).unwrap_or(i32::MIN) as u32
    } else {
        u32::try_from(index - 1).unwrap_or(NOWHERE).min(NOWHERE)
    }
}

fn settle(places: &mut [u32], relative: &[u32], before: usize) {
    for &corner in relative {
        let place = &mut places[corner as usize];
        let settled = before as i64 + i64::from(*place as i32);
        *place = u32::try_from(settled).unwrap_or(NOWHERE);
    }
}

/// 1 to the number of all positions, or, counted back from here, −1 to minus those above.
fn check_index(index: i64, count: usize, known: Option<(usize, usize)>) -> Result<(), String> {
    let Some((before, all)) = known else {
        return Ok(());
    };
    let above = before + count;
    let is_there = if index < 0 {
        index.unsigned_abs() <= above as u64
    } else {
        index > 0 && index as u64 <= all as u64
    };
    if is_there {
        return Ok(());
    }
    let place = if above == all { " above this line" } else { "" };
    Err(format!("position index is {index}, allowed: 1 to {all}{place}, or −{above} to −1"))
}

/// Names in which each run of blanks is one, over continued lines too.
fn names<'a>(scanner: &mut Scanner<'a>) -> std::borrow::Cow<'a, [u8]> {
    let line = scanner.rest_of_line();
    let has_runs = line.windows(2).any(|pair| pair.iter().all(u8::is_ascii_whitespace));
    if !has_runs && !line.ends_with(b" \\") && !line.contains(&b'\t') {
        return line.into();
    }
    let mut line = line.to_vec();
    while line.ends_with(b" \\") && !scanner.is_at_end_of_text() {
        line.pop();
        scanner.skip_line();
        line.extend(scanner.rest_of_line());
    }
    let words: Vec<&[u8]> = line.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty()).collect();
    words.join(&b' ').into()
}

fn not_an_index(start: usize, scanner: &mut Scanner) -> String {
    let word = scanner.word_from(start);
    let field = word.split(|&byte| byte == b'/').find(|field| {
        !field.is_empty()
            && std::str::from_utf8(field).ok().and_then(|f| f.parse::<i64>().ok()).is_none()
    });
    let kind = match field {
        Some(field) if word.starts_with(field) => "position",
        Some(_) => "normal",
        None => "position",
    };
    let field = String::from_utf8_lossy(field.unwrap_or_default());
    format!("{kind} index is \"{field}\", expected a number")
}
