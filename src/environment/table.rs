//! Mean luminances of even cells over the sphere.

use std::f64::consts::TAU;

use rayon::prelude::*;

use super::dome::{CHANNELS, Dome, Luminances};
use super::patch::{Band, Cells, DirectionSpread, Patch};

/// A dome's cells, row by row.
#[derive(Debug, Clone)]
pub(super) struct CellTable {
    pub cells: Cells,
    luminances: Vec<[f32; CHANNELS]>,
    /// One a row.
    bands: Vec<Band>,
    /// Sine and cosine of the longitude in the middle of each column.
    columns: Vec<[f64; 2]>,
}

impl CellTable {
    /// From four looks into each cell.
    pub fn new(dome: &Dome) -> CellTable {
        let cells = dome.cells();
        let rows = (0..cells.rows).into_par_iter();
        let of_row =
            |row| (0..cells.columns).map(move |column| mean(dome, cell(cells, column, row)));
        let longitude = |column: usize| TAU * (column as f64 + 0.5) / cells.columns as f64;
        CellTable {
            cells,
            luminances: rows.flat_map_iter(of_row).collect(),
            bands: (0..cells.rows).map(|row| Band::new(&cell(cells, 0, row))).collect(),
            columns: (0..cells.columns).map(|c| longitude(c).sin_cos().into()).collect(),
        }
    }

    /// Calls `f` for every cell in a patch that is cut between cells.
    pub fn for_each(&self, patch: &Patch, mut f: impl FnMut(Luminances, DirectionSpread)) {
        let range = |axis: usize, of: usize| {
            let at = |end: f64| (end * of as f64).round() as usize;
            at(patch.low[axis])..at(patch.high[axis])
        };
        for row in range(1, self.cells.rows) {
            for column in range(0, self.cells.columns) {
                let seen = self.luminances[row * self.cells.columns + column];
                f(seen.map(f64::from), self.bands[row].spread_toward(self.columns[column]));
            }
        }
    }
}

fn cell(cells: Cells, column: usize, row: usize) -> Patch {
    let at = |column: usize, row: usize| {
        [column as f64 / cells.columns as f64, row as f64 / cells.rows as f64]
    };
    Patch { low: at(column, row), high: at(column + 1, row + 1) }
}

fn mean(dome: &Dome, cell: Patch) -> [f32; CHANNELS] {
    let (mut sums, mut solid_angle) = ([0.0; CHANNELS], 0.0);
    for part in cell.parts([2, 2]) {
        let weight = part.spread().solid_angle;
        solid_angle += weight;
        for (sum, seen) in sums.iter_mut().zip(dome.luminances(part.place(), part.center())) {
            *sum += weight * seen;
        }
    }
    sums.map(|sum| (sum / solid_angle) as f32)
}
