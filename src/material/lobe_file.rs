//! Measured lobes from files: two columns of a table, Zemax `.bsdf`, ASTM E1392.

use std::path::Path;

use crate::columns::{Table, units};
use crate::error::Result;

/// A lobe as a file has it.
#[derive(Debug, Clone, PartialEq)]
pub struct LobeFile {
    /// Angle in degrees, ascending, and BRDF or BTDF.
    pub points: Vec<(f64, f64)>,
    /// What was chosen, converted or turned, a sentence each.
    pub notes: Vec<String>,
}

/// Reads a lobe: the first column and `column` (1-based) of a table; of a file of scatter the plane
/// of incidence, at the incidence nearest to `incidence_deg`, or at the first one.
///
/// Logarithms, which a header names, are raised to the power of ten. Angles that descend are turned.
/// Errors: [`crate::Error::Io`], and [`crate::Error::BadFile`] with the line.
pub fn read_lobe(path: &Path, column: usize, incidence_deg: Option<f64>) -> Result<LobeFile> {
    let table = Table::read(path)?;
    if table.is_scatter() {
        let scatter = table.scatter(incidence_deg)?;
        let notes = vec![format!("scatter at {}° of incidence", scatter.incidence_deg)];
        return Ok(LobeFile { points: scatter.points, notes });
    }
    table.check_commas()?;
    let mut points: Vec<(f64, f64)> = table
        .rows()
        .map(|row| Ok((row.number(0)?, row.number(column - 1)?)))
        .collect::<Result<_>>()?;
    let mut notes = Vec::new();
    if table.names.get(column - 1).is_some_and(|name| units::is_logarithm(name)) {
        points.iter_mut().for_each(|point| point.1 = 10f64.powf(point.1));
        notes.push(format!("column {column} holds logarithms: 10 to their power"));
    }
    if points.windows(2).all(|pair| pair[0].0 > pair[1].0) {
        points.reverse();
    }
    Ok(LobeFile { points, notes })
}
