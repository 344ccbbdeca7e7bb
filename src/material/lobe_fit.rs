//! Exponents of cosⁿα lobes from measured BRDFs and BTDFs (Fig. 3).

use crate::error::{Error, Result};
use crate::fit::{Estimate, MeasuredTable, Residual, check_table, minimize};

/// Measured values by the angle from the specular or the straight-through direction, at one
/// incidence.
#[derive(Debug, Clone, PartialEq)]
pub struct LobeTable<'a> {
    /// Angle in degrees, ascending, −90 to 90 without the ends; BRDF or BTDF, ≥ 0.
    pub points: &'a [(f64, f64)],
    /// Weight of each point's squared residual, ≥ 0; `None` weighs all alike.
    pub weights: Option<&'a [f64]>,
    /// Only points whose angle's size lies in here, degrees.
    pub range_deg: [f64; 2],
}

impl<'a> LobeTable<'a> {
    /// All of `points`, weighed alike.
    pub fn new(points: &'a [(f64, f64)]) -> Self {
        Self { points, weights: None, range_deg: [0.0, 90.0] }
    }
}

/// Where a table of angles from anywhere, such as the sample's normal, has its lobe.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Peak {
    /// At 0°: the angles are from the lobe's direction.
    #[default]
    AtZero,
    /// At this angle, degrees.
    At(f64),
    /// Wherever the values above half of the largest one have their center.
    Found,
}

/// The points with angles from the peak.
///
/// Errors: [`Error::Inconsistent`] for no points, whose peak is not found.
pub fn about_peak(points: &[(f64, f64)], peak: Peak) -> Result<Vec<(f64, f64)>> {
    let peak_deg = match peak {
        Peak::AtZero => 0.0,
        Peak::At(angle) => angle,
        Peak::Found => {
            let most = points.iter().map(|point| point.1).fold(0.0, f64::max);
            let high = points.iter().filter(|point| point.1 > 0.5 * most);
            let (sum, weight) = high.fold((0.0, 0.0), |(sum, weight), &(angle, value)| {
                (sum + angle * (value - 0.5 * most), weight + (value - 0.5 * most))
            });
            if !(weight > 0.0 && weight.is_finite()) {
                return Err(Error::inconsistent(OBJECT, "there is no peak to be found"));
            }
            sum / weight
        }
    };
    Ok(points.iter().map(|&(angle, value)| (angle - peak_deg, value)).collect())
}

/// How many lobes are summed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LobeCount {
    /// A single lobe.
    #[default]
    One,
    /// A narrow lobe and a wide one.
    Two,
}

/// In which space residuals are small.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LobeSpace {
    /// That of the values: the peak decides.
    #[default]
    Linear,
    /// That of their logarithms: peak and tail alike. Needs values above 0.
    Log,
}

/// A cosⁿα with standard errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FittedLobe {
    /// Exponent.
    pub n: f64,
    /// Standard error of `n`.
    pub n_error: f64,
    /// A: the value at 0°, in the unit of the table.
    pub amplitude: f64,
    /// Standard error of `amplitude`.
    pub amplitude_error: f64,
}

impl FittedLobe {
    /// The lobe's value at an angle from its axis, −90 to 90 degrees.
    pub fn eval(&self, angle_deg: f64) -> f64 {
        self.amplitude * (self.n * ln_cos(angle_deg)).exp()
    }
}

/// The sum of lobes that fits a table.
#[derive(Debug, Clone, PartialEq)]
pub struct LobeFit {
    /// One or two, narrowest first.
    pub lobes: Vec<FittedLobe>,
    /// Root mean square residual, in the unit of the values, not weighted.
    pub rms: f64,
    /// The same of log₁₀, over the points above 0.
    pub rms_decades: f64,
    /// Points within the range.
    pub points: usize,
}

impl LobeFit {
    /// Sum of the lobes at an angle from their axis, −90 to 90 degrees.
    pub fn eval(&self, angle_deg: f64) -> f64 {
        self.lobes.iter().map(|lobe| lobe.eval(angle_deg)).sum()
    }
}

/// Fits A cosⁿα, or the sum of two, by least squares.
///
/// Errors: [`Error::Inconsistent`] for fewer points than parameters and one (3 or 5), with the row of one that is unsorted, negative, not
/// finite, saturated (three in a row at the maximum) or, in log space, 0; for weights that do not
/// match; for a table without a lobe.
pub fn fit_lobe(table: &LobeTable, count: LobeCount, space: LobeSpace) -> Result<LobeFit> {
    let rows = check(table, count, space)?;
    let lobes = match count {
        LobeCount::One => fit_lobes::<1, 2>(&rows, space)?,
        LobeCount::Two => fit_lobes::<2, 4>(&rows, space)?,
    };
    let (rms, rms_decades) = rms(&rows, &lobes);
    Ok(LobeFit { lobes, rms, rms_decades, points: rows.len() })
}

/// Root mean square residuals, of the values and of log₁₀ of those above 0.
fn rms(rows: &[LobeRow], lobes: &[FittedLobe]) -> (f64, f64) {
    let root_mean =
        |squares: Vec<f64>| (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt();
    let model = |row: &LobeRow| -> f64 {
        lobes.iter().map(|lobe| lobe.amplitude * (lobe.n * row.ln_cos).exp()).sum()
    };
    let linear = rows.iter().map(|row| (row.value - model(row)).powi(2));
    let lit = rows.iter().filter(|row| row.value > 0.0);
    let decades = lit.map(|row| (row.value / model(row).max(f64::MIN_POSITIVE)).log10().powi(2));
    (root_mean(linear.collect()), root_mean(decades.collect()))
}

const OBJECT: &str = "lobe fit";

/// A point within the range.
struct LobeRow {
    /// Among the table's points.
    point: usize,
    ln_cos: f64,
    value: f64,
    /// Root of the weight.
    root_weight: f64,
}

/// ln cos α; cos α itself has no digits left near 0°.
fn ln_cos(angle_deg: f64) -> f64 {
    let half_sin = (0.5 * angle_deg.to_radians()).sin();
    (-2.0 * half_sin * half_sin).ln_1p()
}

fn check(table: &LobeTable, count: LobeCount, space: LobeSpace) -> Result<Vec<LobeRow>> {
    let refuse = |problem: String| Err(Error::inconsistent(OBJECT, problem));
    let columns = ["angle", "value"];
    let checks = MeasuredTable { object: OBJECT, columns, min_rows: 0, max_plateau: 2 };
    check_table(&checks, table.points)?;
    for (row, &(angle, value)) in (1..).zip(table.points) {
        if angle.abs() >= 90.0 {
            return refuse(format!("row {row}: angle is {angle}, allowed: −90 to 90 degrees"));
        }
        if space == LobeSpace::Log && value == 0.0 {
            return refuse(format!("row {row}: value is 0, which has no logarithm"));
        }
    }
    let weights = check_weights(table)?;
    let [from, to] = table.range_deg;
    let inside = table.points.iter().zip(weights).enumerate();
    let inside = inside.filter(|(_, ((angle, _), _))| (from..=to).contains(&angle.abs()));
    let rows: Vec<LobeRow> = inside
        .map(|(point, (&(angle, value), weight))| LobeRow {
            point,
            ln_cos: ln_cos(angle),
            value,
            root_weight: weight.sqrt(),
        })
        .collect();
    let needs = match count {
        LobeCount::One => 3,
        LobeCount::Two => 5,
    };
    let weighty = rows.iter().filter(|row| row.root_weight > 0.0).count();
    if weighty < needs {
        return refuse(format!("has {weighty} points in range, needs at least {needs}"));
    }
    check_peak(table, &rows)?;
    if rows.iter().all(|row| row.value == 0.0) {
        return refuse("all values in range are 0".to_owned());
    }
    Ok(rows)
}

/// Refuses a table whose lobe is elsewhere than at 0°: its angles are from the normal, most likely.
fn check_peak(table: &LobeTable, rows: &[LobeRow]) -> Result<()> {
    const FARTHEST_DEG: f64 = 10.0;
    let weighty = rows.iter().filter(|row| row.root_weight > 0.0);
    let Some(top) = weighty.clone().max_by(|a, b| a.value.total_cmp(&b.value)) else {
        return Ok(());
    };
    let middle = weighty.max_by(|a, b| a.ln_cos.total_cmp(&b.ln_cos)).unwrap_or(top);
    let top_deg = table.points[top.point].0;
    if middle.value >= 0.5 * top.value && top_deg.abs() <= FARTHEST_DEG {
        return Ok(());
    }
    let problem = format!(
        "the largest value is at {top_deg}°, not near 0°: angles from the normal? give peak = \
         {top_deg}, or peak = \"auto\""
    );
    Err(Error::inconsistent(OBJECT, problem))
}

fn check_weights(table: &LobeTable) -> Result<Vec<f64>> {
    let refuse = |problem: String| Err(Error::inconsistent(OBJECT, problem));
    let Some(weights) = table.weights else {
        return Ok(vec![1.0; table.points.len()]);
    };
    if weights.len() != table.points.len() {
        let (has, points) = (weights.len(), table.points.len());
        return refuse(format!("has {has} weights for {points} points"));
    }
    match weights.iter().position(|w| !(w.is_finite() && *w >= 0.0)) {
        None => Ok(weights.to_vec()),
        Some(at) => refuse(format!(
            "row {}: weight is {}, allowed: finite, at least 0",
            at + 1,
            weights[at]
        )),
    }
}

/// Exponents that are nearer than this are of one lobe.
const SAME_LOBE: f64 = 1.001;

/// The fit of LOBES lobes by PARAMETERS = 2 LOBES logarithms: of each amplitude, then exponent.
/// Logarithms keep both above 0 and of one size.
fn fit_lobes<const LOBES: usize, const PARAMETERS: usize>(
    rows: &[LobeRow],
    space: LobeSpace,
) -> Result<Vec<FittedLobe>> {
    let start = start::<LOBES, PARAMETERS>(rows, space)?;
    let fit = minimize(OBJECT, start, rows.len(), |p, at| residual(p, &rows[at], space))?;
    let mut lobes: Vec<FittedLobe> = (0..LOBES).map(|lobe| fitted_lobe(&fit, lobe)).collect();
    lobes.sort_by(|a, b| b.n.total_cmp(&a.n));
    if lobes.iter().any(|lobe| !(lobe.n.is_finite() && lobe.amplitude.is_finite())) {
        return Err(Error::inconsistent(OBJECT, "the fit does not converge"));
    }
    if let [a, b] = lobes[..]
        && a.n < SAME_LOBE * b.n
    {
        let problem = format!("both lobes have n = {:.3}: one describes the points", a.n);
        return Err(Error::inconsistent(OBJECT, problem));
    }
    if let Some(lobe) = lobes.iter().find(|lobe| lobe.n_error > lobe.n) {
        let FittedLobe { n, n_error, .. } = lobe;
        let problem =
            format!("n = {n:.3} ± {n_error:.3}: the points do not determine the exponent");
        return Err(Error::inconsistent(OBJECT, problem));
    }
    Ok(lobes)
}

fn fitted_lobe<const P: usize>(fit: &Estimate<P>, lobe: usize) -> FittedLobe {
    let of = |at: usize| (fit.parameters[at].exp(), fit.standard_errors[at]);
    let ((amplitude, amplitude_share), (n, n_share)) = (of(2 * lobe), of(2 * lobe + 1));
    FittedLobe { n, n_error: n * n_share, amplitude, amplitude_error: amplitude * amplitude_share }
}

fn residual<const P: usize>(parameters: &[f64; P], row: &LobeRow, space: LobeSpace) -> Residual<P> {
    let mut gradient = [0.0; P];
    let mut model = 0.0;
    for lobe in 0..P / 2 {
        let n = parameters[2 * lobe + 1].exp();
        let value = (parameters[2 * lobe] + n * row.ln_cos).exp();
        gradient[2 * lobe] = value;
        gradient[2 * lobe + 1] = value * n * row.ln_cos;
        model += value;
    }
    let (value, scale) = match space {
        LobeSpace::Linear => (model - row.value, 1.0),
        // A lobe that underflows is as far off as f64 reaches.
        LobeSpace::Log => {
            let model = model.max(f64::MIN_POSITIVE);
            ((model / row.value).ln(), 1.0 / model)
        }
    };
    Residual {
        value: value * row.root_weight,
        gradient: gradient.map(|g| g * scale * row.root_weight),
    }
}

/// Exponents that starts are taken from: four a decade from 0.1 to 10⁷.
fn start_exponents() -> impl Iterator<Item = f64> {
    (-4..=28).map(|i| 10f64.powf(f64::from(i) / 4.0))
}

/// The best of all starting exponents, each with the amplitudes that fit best at it.
fn start<const LOBES: usize, const P: usize>(
    rows: &[LobeRow],
    space: LobeSpace,
) -> Result<[f64; P]> {
    let mut best = (f64::INFINITY, [0.0; P]);
    let mut consider = |exponents: &[f64]| {
        let Some(amplitudes) = amplitudes(rows, exponents, space) else { return };
        let mut parameters = [0.0; P];
        for (lobe, (amplitude, n)) in amplitudes.iter().zip(exponents).enumerate() {
            parameters[2 * lobe] = amplitude.ln();
            parameters[2 * lobe + 1] = n.ln();
        }
        let squares = rows.iter().map(|row| residual(&parameters, row, space).value.powi(2)).sum();
        if squares < best.0 {
            best = (squares, parameters);
        }
    };
    for n in start_exponents() {
        match LOBES {
            1 => consider(&[n]),
            _ => start_exponents().filter(|&wide| wide < n).for_each(|wide| consider(&[n, wide])),
        }
    }
    if best.0.is_finite() {
        Ok(best.1)
    } else {
        Err(Error::inconsistent(OBJECT, "no lobe comes near the points"))
    }
}

/// Amplitudes by linear least squares at given exponents, `None` unless all are above 0.
///
/// In log space residuals are taken relative to the value, which is the same where they are small.
fn amplitudes(rows: &[LobeRow], exponents: &[f64], space: LobeSpace) -> Option<Vec<f64>> {
    let weighed = |row: &LobeRow| match space {
        LobeSpace::Linear => row.root_weight,
        LobeSpace::Log => row.root_weight / row.value,
    };
    let lobe = |row: &LobeRow, at: usize| (exponents[at] * row.ln_cos).exp() * weighed(row);
    let sum = |term: &dyn Fn(&LobeRow) -> f64| rows.iter().map(term).sum::<f64>();
    let product = |a: usize, b: usize| sum(&|row| lobe(row, a) * lobe(row, b));
    let with_value = |a: usize| sum(&|row| lobe(row, a) * row.value * weighed(row));
    let found: Vec<f64> = if exponents.len() == 1 {
        vec![with_value(0) / product(0, 0)]
    } else {
        let (aa, ab, bb) = (product(0, 0), product(0, 1), product(1, 1));
        let (av, bv) = (with_value(0), with_value(1));
        let determinant = aa * bb - ab * ab;
        vec![(av * bb - bv * ab) / determinant, (bv * aa - av * ab) / determinant]
    };
    found.iter().all(|a| *a > 0.0 && a.is_finite()).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cos ⁿα at even steps over 0 to `to_deg`, times or plus noise.
    fn lobe(n: f64, amplitude: f64, to_deg: f64, count: usize) -> Vec<(f64, f64)> {
        let angle = |i: usize| to_deg * i as f64 / (count - 1) as f64;
        (0..count).map(|i| (angle(i), amplitude * angle(i).to_radians().cos().powf(n))).collect()
    }

    /// Standard normal numbers: Box and Muller over a linear congruential generator.
    struct Noise(u64);

    impl Noise {
        fn uniform(&mut self) -> f64 {
            self.0 = self
                .0
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            ((self.0 >> 11) as f64 + 0.5) / (1u64 << 53) as f64
        }

        fn normal(&mut self) -> f64 {
            let radius = (-2.0 * self.uniform().ln()).sqrt();
            radius * (2.0 * std::f64::consts::PI * self.uniform()).cos()
        }
    }

    fn fit(points: &[(f64, f64)], count: LobeCount, space: LobeSpace) -> LobeFit {
        fit_lobe(&LobeTable::new(points), count, space).unwrap()
    }

    #[test]
    fn clean_lobes_are_found_over_the_whole_range_of_exponents() {
        for n in [1.0, 10.0, 1500.0, 1e5, 1e6] {
            // To where the lobe has fallen to e⁻⁴.
            let to_deg = (-4.0f64 / n).exp().acos().to_degrees().min(89.0);
            let points = lobe(n, 0.3, to_deg, 40);
            for space in [LobeSpace::Linear, LobeSpace::Log] {
                let found = fit(&points, LobeCount::One, space);
                // cos α itself was rounded to 1e-16 when the points were made: n times that.
                let tolerance = 1e-9 + 1e-15 * n * n;
                assert!((found.lobes[0].n / n - 1.0).abs() < tolerance, "{n}: {found:?}");
                assert!((found.lobes[0].amplitude / 0.3 - 1.0).abs() < 1e-8, "{n}: {found:?}");
            }
        }
    }

    /// The paper's aluminium has n = 1500. Of 400 noisy tables about 68 % must have n within its
    /// standard error; 62 to 75 % is ± 3 of that count's own standard deviations.
    #[test]
    fn standard_error_of_n_covers_the_truth() {
        let clean = lobe(1500.0, 2.0, 2.0, 60);
        for space in [LobeSpace::Linear, LobeSpace::Log] {
            let covers = |seed: u64| {
                let mut noise = Noise(seed);
                let noisy: Vec<(f64, f64)> = clean
                    .iter()
                    .map(|&(angle, value)| match space {
                        LobeSpace::Linear => (angle, value + 0.05 * 2.0 * noise.normal()),
                        LobeSpace::Log => (angle, value * (0.05 * noise.normal()).exp()),
                    })
                    .collect();
                let lobe = fit(&noisy, LobeCount::One, space).lobes[0];
                (lobe.n - 1500.0).abs() < lobe.n_error
            };
            let covered = (0..400).filter(|&seed| covers(seed)).count();
            assert!((248..=300).contains(&covered), "{space:?}: {covered} of 400");
        }
    }

    #[test]
    fn two_lobes_are_told_apart() {
        let narrow = lobe(900.0, 5.0, 30.0, 200);
        let wide = lobe(12.0, 0.2, 30.0, 200);
        let points: Vec<(f64, f64)> =
            narrow.iter().zip(&wide).map(|(a, b)| (a.0, a.1 + b.1)).collect();
        for space in [LobeSpace::Linear, LobeSpace::Log] {
            let found = fit(&points, LobeCount::Two, space);
            let [first, second] = found.lobes[..] else { panic!("{found:?}") };
            assert!((first.n - 900.0).abs() < 1e-4 && (second.n - 12.0).abs() < 1e-4, "{found:?}");
            assert!((first.amplitude - 5.0).abs() < 1e-6, "{found:?}");
            assert!(found.rms < 1e-8 && found.rms_decades < 1e-8, "{found:?}");
            assert!((found.eval(-3.0) - first.eval(3.0) - second.eval(3.0)).abs() < 1e-12);
        }
        assert!(fit(&points, LobeCount::One, LobeSpace::Log).rms_decades > 0.1);
    }

    /// SciPy 1.17.1, with a = np.radians([0, .5, 1, 1.5, 2, 3]) and v = [9.8, 9.5, 7.7, 6.2, 4.1,
    /// 1.1]: `curve_fit(lambda a, A, n: A*np.cos(a)**n, a, v, p0=[10, 1500], xtol=1e-14,
    /// ftol=1e-14, gtol=1e-14)`, and the same on np.log(v) of A*np.cos(a)**n; σ from
    /// `np.sqrt(np.diag(pcov))`.
    #[test]
    fn agrees_with_scipy() {
        let points = [(0.0, 9.8), (0.5, 9.5), (1.0, 7.7), (1.5, 6.2), (2.0, 4.1), (3.0, 1.1)];
        for (space, [amplitude, n, amplitude_error, n_error]) in [
            (LobeSpace::Linear, [9.89538769, 1469.76384, 0.142656634, 64.4350516]),
            (LobeSpace::Log, [10.1650036, 1594.32642, 0.287203592, 44.7279444]),
        ] {
            let lobe = fit(&points, LobeCount::One, space).lobes[0];
            assert!((lobe.n / n - 1.0).abs() < 1e-6, "{lobe:?}");
            assert!((lobe.amplitude / amplitude - 1.0).abs() < 1e-6, "{lobe:?}");
            assert!((lobe.n_error / n_error - 1.0).abs() < 1e-4, "{lobe:?}");
            assert!((lobe.amplitude_error / amplitude_error - 1.0).abs() < 1e-4, "{lobe:?}");
        }
    }

    #[test]
    fn one_lobe_is_not_two() {
        for space in [LobeSpace::Linear, LobeSpace::Log] {
            let points = lobe(50.0, 1.0, 20.0, 21);
            let found = fit_lobe(&LobeTable::new(&points), LobeCount::Two, space);
            let message = found.unwrap_err().to_string();
            assert!(message.starts_with("lobe fit: "), "{message}");
        }
    }

    #[test]
    fn range_and_weights_choose_the_points() {
        let mut points = lobe(100.0, 1.0, 20.0, 41);
        points[20].1 = 5.0;
        let weights: Vec<f64> = (0..41).map(|i| if i == 20 { 0.0 } else { 2.0 }).collect();
        let weighed = LobeTable { weights: Some(&weights), ..LobeTable::new(&points) };
        let ranged = LobeTable { range_deg: [0.0, 9.0], ..LobeTable::new(&points) };
        for (table, count) in [(weighed, 41), (ranged, 19)] {
            let found = fit_lobe(&table, LobeCount::One, LobeSpace::Linear).unwrap();
            assert!((found.lobes[0].n - 100.0).abs() < 1e-6, "{found:?}");
            assert_eq!(found.points, count);
        }
    }

    #[test]
    fn lobes_in_absolute_angles_are_found_or_refused() {
        let absolute: Vec<(f64, f64)> = (0..=60)
            .map(|i| 15.0 + f64::from(i))
            .map(|a: f64| (a, 3.0 * (a - 45.0).to_radians().cos().powi(200)))
            .collect();
        let refused = fit_lobe(&LobeTable::new(&absolute), LobeCount::One, LobeSpace::Log);
        assert_eq!(
            refused.unwrap_err().to_string(),
            "lobe fit: the largest value is at 45°, not near 0°: angles from the normal? give peak = \
             45, or peak = \"auto\""
        );
        for peak in [Peak::At(45.0), Peak::Found] {
            let points = about_peak(&absolute, peak).unwrap();
            let found = fit(&points, LobeCount::One, LobeSpace::Log);
            assert!((found.lobes[0].n - 200.0).abs() < 1e-3, "{peak:?}: {found:?}");
        }
        let noise = [(0.0, 1.0), (1.0, 0.98), (2.0, 1.03), (3.0, 0.99), (4.0, 1.04)];
        let refused = fit_lobe(&LobeTable::new(&noise), LobeCount::One, LobeSpace::Linear);
        let message = refused.unwrap_err().to_string();
        assert!(message.ends_with("the points do not determine the exponent"), "{message}");
    }

    #[test]
    fn bad_tables_are_refused_with_the_row() {
        let message = |points: &[(f64, f64)]| {
            fit_lobe(&LobeTable::new(points), LobeCount::One, LobeSpace::Log)
                .unwrap_err()
                .to_string()
        };
        let good = [(0.0, 3.0), (1.0, 2.0), (2.0, 1.0), (3.0, 0.5)];
        let with = |row: usize, point: (f64, f64)| {
            let mut bad = good;
            bad[row] = point;
            message(&bad)
        };
        assert_eq!(message(&good[..2]), "lobe fit: has 2 points in range, needs at least 3");
        assert_eq!(with(2, (0.5, 1.0)), "lobe fit: row 3: angle 0.5 follows 1, must ascend");
        assert_eq!(
            with(1, (1.0, -2.0)),
            "lobe fit: row 2: value is -2, allowed: finite, at least 0"
        );
        assert_eq!(
            with(1, (1.0, f64::NAN)),
            "lobe fit: row 2: value is NaN, allowed: finite, at least 0"
        );
        assert_eq!(with(3, (3.0, 0.0)), "lobe fit: row 4: value is 0, which has no logarithm");
        assert_eq!(
            with(3, (95.0, 0.5)),
            "lobe fit: row 4: angle is 95, allowed: −90 to 90 degrees"
        );
        assert_eq!(
            message(&[(0.0, 3.0), (1.0, 3.0), (2.0, 3.0), (3.0, 0.5)]),
            "lobe fit: rows 1 to 3: value stays at its maximum 3, the instrument is saturated"
        );
        let weights = [1.0, -1.0, 1.0, 1.0];
        let table = LobeTable { weights: Some(&weights), ..LobeTable::new(&good) };
        assert_eq!(
            fit_lobe(&table, LobeCount::One, LobeSpace::Log).unwrap_err().to_string(),
            "lobe fit: row 2: weight is -1, allowed: finite, at least 0"
        );
        let dark = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)];
        assert!(fit_lobe(&LobeTable::new(&dark), LobeCount::One, LobeSpace::Linear).is_err());
    }
}
