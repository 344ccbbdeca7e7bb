//! Where in its pixel a sample lies.

/// Where in the unit square the i-th sample lies: the additive recurrence of the plastic number,
/// evenly spread for every count, begun at the pixel's center.
pub(super) fn sample_place(i: u32) -> [f64; 2] {
    const PLASTIC: f64 = 1.324_717_957_244_746;
    [1.0 / PLASTIC, 1.0 / (PLASTIC * PLASTIC)].map(|step| (0.5 + f64::from(i) * step).fract())
}
