//! Which points of the parameters' space a study draws.

use super::distribution::Distribution;
use crate::source::sequence::random;

/// How draws are spread.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Design {
    /// Sobol's sequence, scrambled by Owen's method: even in every few parameters at once.
    #[default]
    Sobol,
    /// Even in each parameter by itself (McKay et al. 1979).
    LatinHypercube,
    /// All combinations of a few values of each parameter.
    Grid,
}

/// Most draws of a study: what the sequence of [`Design::Sobol`] has.
pub const MOST_DRAWS: usize = 1 << 16;
/// Most parameters of a study, likewise.
pub const MOST_PARAMETERS: usize = sobol_burley::NUM_DIMENSIONS as usize;

/// The draws of a study, each from its index alone.
#[derive(Debug, Clone)]
pub struct Draws {
    design: Design,
    seed: u64,
    /// Values of each parameter, for a grid.
    levels: Vec<usize>,
    permutations: Vec<Vec<u32>>,
    count: usize,
}

impl Draws {
    /// At most `samples` draws (1 to [`MOST_DRAWS`]); a grid has as many as fit evenly.
    pub fn new(design: Design, parameters: &[Distribution], samples: usize, seed: u64) -> Self {
        let mut draws = Self { design, seed, levels: vec![], permutations: vec![], count: samples };
        match design {
            Design::Sobol => {}
            Design::LatinHypercube => {
                draws.permutations = (0..parameters.len())
                    .map(|parameter| permutation(samples, seed, parameter as u64))
                    .collect();
            }
            Design::Grid => {
                draws.levels = levels(parameters, samples);
                draws.count = draws.levels.iter().product();
            }
        }
        draws
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Where draw `index` (from 0) lies along a parameter: the share of its values below, above 0
    /// and below 1.
    pub fn share(&self, index: usize, parameter: usize) -> f64 {
        match self.design {
            Design::Sobol => {
                // Every bit of the seed counts; the sequence takes 32.
                let seed = (random(self.seed, 0, 0) * 2f64.powi(32)) as u32;
                let value = sobol_burley::sample(index as u32, parameter as u32, seed);
                f64::from(value) + 2f64.powi(-25) // half of f32's last digit: never 0
            }
            Design::LatinHypercube => {
                let cell = f64::from(self.permutations[parameter][index]);
                let place = random(self.seed, index as u64, 2 * parameter as u64 + 1);
                (cell + place.max(1e-12)) / self.count as f64
            }
            Design::Grid => {
                let before: usize = self.levels[..parameter].iter().product();
                let levels = self.levels[parameter];
                ((index / before % levels) as f64 + 0.5) / levels as f64
            }
        }
    }
}

/// Lists in full; of the others the same number of values each, as many as `samples` allow.
fn levels(parameters: &[Distribution], samples: usize) -> Vec<usize> {
    let of_lists: usize = parameters.iter().map(|p| list_len(p).unwrap_or(1)).product();
    let free = parameters.iter().filter(|p| list_len(p).is_none()).count() as u32;
    let fits = |n: usize| n.checked_pow(free).is_some_and(|all| all * of_lists <= samples);
    let each = if free == 0 { 1 } else { (1..).take_while(|&n| fits(n)).last().unwrap_or(1) };
    parameters.iter().map(|p| list_len(p).unwrap_or(each)).collect()
}

fn list_len(parameter: &Distribution) -> Option<usize> {
    match parameter {
        Distribution::List(values) => Some(values.len()),
        _ => None,
    }
}

/// Fisher and Yates's shuffle.
fn permutation(count: usize, seed: u64, parameter: u64) -> Vec<u32> {
    let mut order: Vec<u32> = (0..count as u32).collect();
    for last in (1..count).rev() {
        let other = (random(seed, last as u64, 2 * parameter) * (last + 1) as f64) as usize;
        order.swap(last, other);
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: Distribution = Distribution::Uniform { low: 0.0, high: 1.0 };

    fn cells(draws: &Draws, parameter: usize, cells: usize) -> Vec<usize> {
        let mut counts = vec![0; cells];
        for index in 0..draws.count() {
            let share = draws.share(index, parameter);
            assert!(share > 0.0 && share < 1.0);
            counts[(share * cells as f64) as usize] += 1;
        }
        counts
    }

    #[test]
    fn each_parameter_is_even() {
        for design in [Design::Sobol, Design::LatinHypercube] {
            let draws = Draws::new(design, &[UNIT, UNIT, UNIT], 256, 7);
            for parameter in 0..3 {
                assert_eq!(cells(&draws, parameter, 256), [1; 256], "{design:?}");
            }
        }
    }

    #[test]
    fn seeds_differ_and_repeat() {
        for design in [Design::Sobol, Design::LatinHypercube] {
            let share = |seed| Draws::new(design, &[UNIT], 16, seed).share(5, 0);
            assert_eq!(share(1), share(1));
            assert_ne!(share(1), share(2));
            assert_ne!(share(1), share(1 + (1 << 40)), "all bits of the seed count");
        }
    }

    #[test]
    fn a_grid_is_full_and_within_its_number() {
        let list = Distribution::List(vec![1.0, 2.0, 3.0]);
        let draws = Draws::new(Design::Grid, &[UNIT, list, UNIT], 100, 1);
        assert_eq!(draws.count(), 5 * 3 * 5);
        assert_eq!(cells(&draws, 1, 3), [25; 3]);
        let mut points: Vec<_> =
            (0..75).map(|i| [0, 1, 2].map(|p| (draws.share(i, p) * 1e3) as u32)).collect();
        points.sort_unstable();
        points.dedup();
        assert_eq!(points.len(), 75);
    }
}
