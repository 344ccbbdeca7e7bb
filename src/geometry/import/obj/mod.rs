//! Wavefront OBJ: one pass over the bytes, in pieces that are read side by side.

mod piece;
mod scanner;

use rayon::prelude::*;

use super::parts::PolygonRun;
use super::polygons::{NONE, Polygons};
use super::{Contents, MeshFault, MeshResult};
use crate::error::Place;
use crate::geometry::normals::Smoothing;
use piece::{Counts, NOWHERE, Piece, PieceFault, Statement};
pub(super) use scanner::{Scanner, line_of};

/// Large enough that a piece costs nothing besides its bytes, small enough to share them out evenly.
const PIECE_BYTES: usize = 1 << 18;

/// Enough for many threads, few enough to stay small.
const PIECES_AT_ONCE: usize = 32;

pub(super) fn parse(bytes: Vec<u8>) -> MeshResult<Contents> {
    parse_pieces(&bytes, PIECE_BYTES)
}

pub(super) fn parse_pieces(bytes: &[u8], piece_bytes: usize) -> MeshResult<Contents> {
    let starts = starts(bytes, piece_bytes);
    let part = |at: usize| &bytes[starts[at]..starts.get(at + 1).copied().unwrap_or(bytes.len())];
    let located = |at: usize, fault: PieceFault| MeshFault {
        place: Place::Line(line_of(bytes, starts[at] + fault.at)),
        problem: fault.problem,
    };
    let mut whole = ObjContents::default();
    // A few at a time: what they held is used again for the next.
    for first in (0..starts.len()).step_by(PIECES_AT_ONCE) {
        let all = first..starts.len().min(first + PIECES_AT_ONCE);
        let pieces: Vec<_> = all.into_par_iter().map(|at| Piece::parse(part(at), None)).collect();
        for (at, piece) in (first..).zip(pieces) {
            whole.add(piece.map_err(|fault| located(at, fault))?)?;
        }
    }
    if let Some(at) = whole.wrong_piece() {
        // Once more, to find the line.
        let fault = Piece::parse(part(at), Some((whole.before[at], whole.counts))).err();
        return Err(fault.map_or_else(|| MeshFault::file("bad index"), |f| located(at, f)));
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
struct ObjContents {
    polygons: Polygons,
    counts: Counts,
    /// Counts before each piece, and where its corners begin.
    before: Vec<Counts>,
    first_corners: Vec<usize>,
    run: Option<PolygonRun>,
    free_forms: usize,
}

impl ObjContents {
    /// Errors: more vertices than can be counted.
    fn add(&mut self, mut piece: Piece) -> MeshResult<()> {
        let polygons = &mut self.polygons;
        let (first_corner, first_polygon) = (polygons.corners.len(), polygons.ends.len() as u32);
        self.before.push(self.counts);
        self.first_corners.push(first_corner);
        piece.settle(self.counts);
        self.counts = self.counts.after(&piece);
        let most = self.counts.positions.max(self.counts.normals);
        if most.max(first_corner + piece.corners.len()) >= NOWHERE as usize {
            return Err(MeshFault::file("has more vertices or corners than can be counted"));
        }
        polygons.positions.append(&mut piece.positions);
        polygons.normals.append(&mut piece.normals);
        polygons.corners.append(&mut piece.corners);
        if !piece.corner_normals.is_empty() {
            polygons.corner_normals.resize(first_corner, NONE);
            polygons.corner_normals.append(&mut piece.corner_normals);
        }
        polygons.ends.extend(piece.ends.iter().map(|end| first_corner as u32 + end));
        self.free_forms += piece.free_forms;
        for (polygon, statement) in piece.statements {
            self.note(first_polygon + polygon, statement);
        }
        Ok(())
    }

    /// The piece that holds the first corner whose position is not there.
    fn wrong_piece(&self) -> Option<usize> {
        let count = self.counts.positions;
        let wrong = self.polygons.corners.iter().position(|&place| place as usize >= count)?;
        Some(self.first_corners.partition_point(|&first| first <= wrong) - 1)
    }

    /// Corners lose normals that are not there; how many do.
    fn drop_missing_normals(&mut self) -> usize {
        let polygons = &mut self.polygons;
        if polygons.corner_normals.is_empty() {
            return 0;
        }
        polygons.corner_normals.resize(polygons.corners.len(), NONE);
        let mut missing = 0;
        for place in &mut polygons.corner_normals {
            if *place as usize >= self.counts.normals && *place != NONE {
                missing += 1;
                *place = NONE;
            }
        }
        missing
    }

    fn note(&mut self, first: u32, statement: Statement) {
        let parts = &mut self.polygons.parts;
        let mut run = PolygonRun { first, ..self.run.unwrap_or(PolygonRun::START) };
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
        let missing_normals = self.drop_missing_normals();
        let polygons = &mut self.polygons;
        if polygons.parts.runs.first().is_none_or(|run| run.first > 0) {
            polygons.parts.runs.insert(0, PolygonRun::START);
        }
        polygons.finish();
        let mut warnings = Vec::new();
        if missing_normals > 0 {
            warnings.push(format!(
                "{} corners name a normal that is not there: their faces' normals are made",
                missing_normals
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
