//! Tables that are built into the program.

/// Rows of a CSV table of the program's own, without its comments and header: the first cell as it
/// stands, and every cell as a number, NaN where it is none.
pub(crate) fn built_in_rows(csv: &'static str) -> impl Iterator<Item = (&'static str, Vec<f64>)> {
    csv.lines().filter(|line| !line.starts_with('#')).skip(1).map(|line| {
        let cells = || line.split(',').map(str::trim);
        let numbers = cells().map(|cell| cell.parse().unwrap_or(f64::NAN)).collect();
        (cells().next().unwrap_or_default(), numbers)
    })
}
