//! Wavefront OBJ: one pass over the bytes, in pieces that are read side by side.

mod piece;
mod scanner;

use rayon::prelude::*;

use super::parts::Run;
use super::polygons::{NONE, Polygons};
use super::{Contents, Fault, Parsed};
use crate::error::Place;
use crate::geometry::normals::Smoothing;
use piece::{Counts, Piece, PieceFault, Statement};
pub(super) use scanner::{Scanner, line_of};

/// Large enough that a piece costs nothing besides its bytes, small enough to share them out evenly.
const PIECE_BYTES: usize = 1 << 18;

pub(super) fn parse(bytes: Vec<u8>) -> Parsed<Contents> {
    parse_pieces(&bytes, PIECE_BYTES)
}

pub(super) fn parse_pieces(bytes: &[u8], piece_bytes: usize) -> Parsed<Contents> {
    let starts = starts(bytes, piece_bytes);
    let part = |at: usize| &bytes[starts[at]..starts.get(at + 1).copied().unwrap_or(bytes.len())];
    let pieces: Vec<_> =
        (0..starts.len()).into_par_iter().map(|at| Piece::parse(part(at), None)).collect();
    let located = |at: usize, fault: PieceFault| Fault {
        place: Place::Line(line_of(bytes, starts[at] + fault.at)),
        problem: fault.problem,
    };
    let mut whole = Whole::default();
    let mut checked = Vec::with_capacity(pieces.len());
    for (at, piece) in pieces.into_iter().enumerate() {
        checked.push(piece.map_err(|fault| located(at, fault))?);
    }
    let totals = checked.iter().fold(Counts::default(), |sum, piece| sum.after(piece));
    if totals.positions > NONE as usize || totals.normals > NONE as usize {
        return Err(Fault::file("has more vertices than can be counted"));
    }
    let sum = |length: fn(&Piece) -> usize| checked.iter().map(length).sum();
    whole.polygons.positions.reserve_exact(totals.positions);
    whole.polygons.normals.reserve_exact(totals.normals);
    whole.polygons.corners.reserve_exact(sum(|piece| piece.corners.len()));
    whole.polygons.ends.reserve_exact(sum(|piece| piece.ends.len()));
    for (at, piece) in checked.into_iter().enumerate() {
        if !whole.add(piece, totals) {
            // Once more, to find the line.
            let fault = Piece::parse(part(at), Some((whole.before, totals))).err();
            return Err(fault.map_or_else(|| Fault::file("bad index"), |f| located(at, f)));
        }
    }
    Ok(whole.finish())
}

/// Where pieces start: after the end of a line that is not continued.
fn starts(bytes: &[u8], piece_bytes: usize) -> Vec<usize> {
    let mut starts = vec![0];
    let mut from = piece_bytes;
    while from < bytes.len() {
        let Some(length) = bytes[from..].iter().position(|&b| b == b'\n') else {
            break;
        };
        let end = from + length;
        if bytes[..end].trim_ascii_end().ends_with(b"\\") {
            from = end + 1;
        } else {
            starts.push(end + 1);
            from = end + 1 + piece_bytes;
        }
    }
    starts
}

/// All pieces so far.
#[derive(Default)]
struct Whole {
    polygons: Polygons,
    before: Counts,
    run: Option<Run>,
    missing_normals: usize,
    free_forms: usize,
}

impl Whole {
    /// Whether all of the piece's places are there.
    fn add(&mut self, mut piece: Piece, totals: Counts) -> bool {
        let after = self.before.after(&piece);
        if !piece.resolve(self.before, totals) {
            return false;
        }
        self.before = after;
        let polygons = &mut self.polygons;
        let (first_corner, first_polygon) = (polygons.corners.len(), polygons.ends.len() as u32);
        polygons.positions.append(&mut piece.positions);
        polygons.normals.append(&mut piece.normals);
        polygons.corners.append(&mut piece.corners);
        if !piece.corner_normals.is_empty() {
            polygons.corner_normals.resize(first_corner, NONE);
            polygons.corner_normals.append(&mut piece.corner_normals);
        }
        polygons.ends.extend(piece.ends.iter().map(|end| first_corner as u32 + end));
        self.missing_normals += piece.missing_normals;
        self.free_forms += piece.free_forms;
        for (polygon, statement) in piece.statements {
            self.note(first_polygon + polygon, statement);
        }
        true
    }

    fn note(&mut self, first: u32, statement: Statement) {
        let parts = &mut self.polygons.parts;
        let mut run = Run { first, ..self.run.unwrap_or(Run::START) };
        match statement {
            Statement::Group(name) => run.group = Some(parts.groups.number(&name)),
            Statement::Object(name) => run.object = Some(parts.objects.number(name)),
            Statement::Material(name) => run.material = Some(parts.materials.number(name)),
            Statement::Smoothing(smoothing) => run.smoothing = smoothing,
        }
        self.run = Some(run);
        parts.push(run);
    }

    fn finish(mut self) -> Contents {
        let polygons = &mut self.polygons;
        if !polygons.corner_normals.is_empty() {
            polygons.corner_normals.resize(polygons.corners.len(), NONE);
        }
        if polygons.parts.runs.first().is_none_or(|run| run.first > 0) {
            polygons.parts.runs.insert(0, Run::START);
        }
        polygons.finish();
        let mut warnings = Vec::new();
        if self.missing_normals > 0 {
            warnings.push(format!(
                "{} corners name a normal that is not there: their faces' normals are made",
                self.missing_normals
            ));
        }
        if self.free_forms > 0 {
            warnings.push(format!(
                "{} free-form curves or surfaces are left out: export them as polygons",
                self.free_forms
            ));
        }
        Contents { format: "OBJ", polygons: self.polygons, warnings }
    }
}

/// `s off`, `s 0`, `s 1` …
fn smoothing(value: &[u8]) -> Smoothing {
    match std::str::from_utf8(value).ok().and_then(|text| text.parse().ok()) {
        Some(0) => Smoothing::Off,
        Some(group) => Smoothing::Group(group),
        None if value.eq_ignore_ascii_case(b"on") => Smoothing::Group(1),
        None => Smoothing::Off,
    }
}
