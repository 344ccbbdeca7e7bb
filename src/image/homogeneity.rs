//! How even a lit surface is, and how well a picture tells it.

use super::{Region, SpectralImage};
use crate::error::{Error, Result};

/// Figures of evenness over the cells of a region, or the standard errors of these figures.
///
/// Unit: that of luminance for the first three; the others are ratios.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Evenness {
    /// Mean luminance.
    pub mean: f64,
    /// Luminance of the darkest cell.
    pub min: f64,
    /// Luminance of the brightest cell.
    pub max: f64,
    /// RMS contrast: standard deviation of the cells over their mean.
    pub contrast: f64,
    /// Darkest over brightest cell.
    pub uniformity: f64,
    /// Largest difference of two cells side by side, over the mean.
    pub gradient: f64,
}

/// What noise of the picture does to [`Evenness`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseShare {
    /// Standard error of each figure; of the contrast with what the noise adds to it.
    pub error: Evenness,
    /// RMS contrast that this noise alone makes on an even surface.
    pub noise: f64,
}

/// How even a region is: [`homogeneity`].
#[derive(Debug, Clone, PartialEq)]
pub struct Homogeneity {
    /// Columns and rows of cells.
    pub cells: [usize; 2],
    /// The figures.
    pub evenness: Evenness,
    /// From the number of the light's rays; `None` without pictures of its halves.
    pub rays: Option<NoiseShare>,
    /// From the number of camera rays; `None` where the picture does not hold its errors.
    pub samples: Option<NoiseShare>,
}

/// Evenness of `region`, parted into `cells` columns and rows (pixels where that is `None`).
///
/// `halves` are pictures of the same view, each with a half of the light's rays (two for each
/// split, either with the whole flux or with half of it): half the difference of two halves has the
/// variance of the whole. Errors of pixels are those of a picture with adaptive samples.
/// Errors: a region outside of the image or without light; more cells than pixels; an odd number of
/// halves, or halves of another size.
pub fn homogeneity(
    image: &SpectralImage,
    region: Region,
    cells: Option<[usize; 2]>,
    halves: &[&SpectralImage],
) -> Result<Homogeneity> {
    region.check(image.width, image.height)?;
    let lattice = Lattice::new(region, cells)?;
    let luminances = luminances(image);
    let values = lattice.means(image.width, &luminances);
    let figures = Figures::of(&values, lattice.cells)?;
    Ok(Homogeneity {
        cells: lattice.cells,
        evenness: figures.evenness,
        rays: ray_noise(image, &lattice, &figures, &values, halves)?,
        samples: sample_variances(image, &lattice, &luminances)
            .map(|variances| figures.independent(&variances)),
    })
}

fn luminances(image: &SpectralImage) -> Vec<f64> {
    image.to_xyz().pixels.iter().map(|xyz| xyz.y).collect()
}

/// The cells of a region: as equal as whole pixels allow.
struct Lattice {
    region: Region,
    cells: [usize; 2],
}

impl Lattice {
    fn new(region: Region, cells: Option<[usize; 2]>) -> Result<Self> {
        let pixels = [region.width, region.height];
        let cells = cells.unwrap_or(pixels);
        if (0..2).any(|axis| !(1..=pixels[axis]).contains(&cells[axis])) {
            let found = format!("{{{}, {}}}", cells[0], cells[1]);
            let allowed = format!("{{1, 1}} to the region's {{{}, {}}}", pixels[0], pixels[1]);
            return Err(Error::out_of_range("homogeneity", "grid", found, allowed));
        }
        Ok(Self { region, cells })
    }

    /// The pixels of a cell, by its number.
    fn cell(&self, cell: usize) -> Region {
        let [columns, rows] = self.cells;
        let span = |at: usize, of: usize, length: usize| (at * length / of, (at + 1) * length / of);
        let (left, right) = span(cell % columns, columns, self.region.width);
        let (top, bottom) = span(cell / columns, rows, self.region.height);
        Region {
            x: self.region.x + left,
            y: self.region.y + top,
            width: right - left,
            height: bottom - top,
        }
    }

    /// Σ over the pixels of each cell, divided by their number to this power.
    fn sums(&self, width: usize, values: &[f64], power: i32) -> Vec<f64> {
        let sum = |cell| {
            let cell = self.cell(cell);
            let sum: f64 = cell.pixels().map(|(x, y)| values[y * width + x]).sum();
            sum / ((cell.width * cell.height) as f64).powi(power)
        };
        (0..self.cells[0] * self.cells[1]).map(sum).collect()
    }

    fn means(&self, width: usize, values: &[f64]) -> Vec<f64> {
        self.sums(width, values, 1)
    }
}

/// Variance of each cell's luminance from its camera rays; `None` where the picture does not hold
/// the errors of its pixels.
fn sample_variances(
    image: &SpectralImage,
    lattice: &Lattice,
    luminances: &[f64],
) -> Option<Vec<f64>> {
    let mean = luminances.iter().sum::<f64>() / luminances.len() as f64;
    let pairs = image.error.as_ref()?.iter().zip(luminances);
    let variances: Vec<f64> =
        pairs.map(|(error, y)| (f64::from(*error) * y.max(mean)).powi(2)).collect();
    let variances = lattice.sums(image.width, &variances, 2);
    variances.iter().all(|variance| variance.is_finite()).then_some(variances)
}

fn ray_noise(
    image: &SpectralImage,
    lattice: &Lattice,
    figures: &Figures,
    values: &[f64],
    halves: &[&SpectralImage],
) -> Result<Option<NoiseShare>> {
    if halves.len() % 2 == 1 {
        let problem = "an odd number of halves: expected two of each split";
        return Err(Error::inconsistent("homogeneity", problem));
    }
    let differs = |half: &&&SpectralImage| [half.width, half.height] != [image.width, image.height];
    if let Some(half) = halves.iter().find(differs) {
        let problem = format!(
            "a half has {} × {} pixels, the image {} × {}",
            half.width, half.height, image.width, image.height
        );
        return Err(Error::inconsistent("homogeneity", problem));
    }
    let fields: Vec<Vec<f64>> = halves
        .chunks_exact(2)
        .map(|pair| {
            let [a, b] = [pair[0], pair[1]].map(|i| lattice.means(i.width, &luminances(i)));
            half_difference(values, &a, &b)
        })
        .collect();
    Ok((!fields.is_empty()).then(|| figures.drawn(&fields)))
}

/// One draw of the whole set's noise: halves of half the flux add up to the picture, halves of the
/// whole flux to twice the picture.
fn half_difference(whole: &[f64], a: &[f64], b: &[f64]) -> Vec<f64> {
    let sum = |values: &[f64]| values.iter().sum::<f64>();
    let scale = if sum(a) + sum(b) > 1.5 * sum(whole) { 0.5 } else { 1.0 };
    a.iter().zip(b).map(|(a, b)| scale * (a - b)).collect()
}

/// The figures, and how each follows the cells: its derivative by each cell's luminance.
struct Figures {
    evenness: Evenness,
    slopes: [Vec<f64>; 6],
}

impl Figures {
    /// Errors: no light.
    fn of(values: &[f64], cells: [usize; 2]) -> Result<Self> {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        if mean.is_nan() || mean <= 0.0 {
            return Err(Error::inconsistent("homogeneity", "the region has no light"));
        }
        let square = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / n;
        let contrast = square.sqrt() / mean;
        let extreme = |is_more: fn(f64, f64) -> bool| {
            let better =
                |best: usize, at: usize| if is_more(values[at], values[best]) { at } else { best };
            (0..values.len()).fold(0, better)
        };
        let (darkest, brightest) = (extreme(|a, b| a < b), extreme(|a, b| a > b));
        let (low, high) = steepest(values, cells);
        let evenness = Evenness {
            mean,
            min: values[darkest],
            max: values[brightest],
            contrast,
            uniformity: values[darkest] / values[brightest],
            gradient: (values[high] - values[low]) / mean,
        };
        let slopes = |of: &dyn Fn(usize) -> f64| (0..values.len()).map(of).collect::<Vec<_>>();
        let is = |cell: usize, at: usize| f64::from(u8::from(cell == at));
        let Evenness { max, uniformity, gradient, .. } = evenness;
        let of_contrast = |at: usize| match contrast {
            0.0 => 0.0,
            _ => ((values[at] - mean) / (contrast * mean) - contrast) / (n * mean),
        };
        Ok(Self {
            evenness,
            slopes: [
                slopes(&|_| 1.0 / n),
                slopes(&|at| is(darkest, at)),
                slopes(&|at| is(brightest, at)),
                slopes(&of_contrast),
                slopes(&|at| (is(darkest, at) - uniformity * is(brightest, at)) / max),
                slopes(&|at| (is(high, at) - is(low, at) - gradient / n) / mean),
            ],
        })
    }

    /// Noise that is independent from cell to cell.
    fn independent(&self, variances: &[f64]) -> NoiseShare {
        let of = |slopes: &Vec<f64>| {
            let terms = slopes.iter().zip(variances).map(|(slope, v)| slope * slope * v);
            terms.sum::<f64>().sqrt()
        };
        let mean_square = variances.iter().sum::<f64>() / variances.len() as f64;
        self.share(self.slopes.each_ref().map(of), mean_square)
    }

    /// Noise of which these are draws.
    fn drawn(&self, fields: &[Vec<f64>]) -> NoiseShare {
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let draws = fields.len() as f64;
        let of = |slopes: &Vec<f64>| {
            let squares = fields.iter().map(|field| product(slopes, field).powi(2));
            (squares.sum::<f64>() / draws).sqrt()
        };
        // Noise that all cells share makes no contrast.
        let spread = |field: &Vec<f64>| {
            let n = field.len() as f64;
            product(field, field) / n - (field.iter().sum::<f64>() / n).powi(2)
        };
        let mean_square = fields.iter().map(spread).sum::<f64>() / draws;
        self.share(self.slopes.each_ref().map(of), mean_square)
    }

    /// Squares of contrasts add up, so that noise adds to every contrast.
    fn share(&self, errors: [f64; 6], mean_square: f64) -> NoiseShare {
        let [mean, min, max, contrast, uniformity, gradient] = errors;
        let noise = mean_square.max(0.0).sqrt() / self.evenness.mean;
        let true_square = (self.evenness.contrast.powi(2) - noise * noise).max(0.0);
        let added = self.evenness.contrast - true_square.sqrt();
        let contrast = contrast.hypot(added);
        NoiseShare { error: Evenness { mean, min, max, contrast, uniformity, gradient }, noise }
    }
}

/// The two cells side by side that differ most, the darker one first.
fn steepest(values: &[f64], [columns, rows]: [usize; 2]) -> (usize, usize) {
    let right = (0..values.len()).filter(|at| at % columns + 1 < columns).map(|at| (at, at + 1));
    let below = (0..columns * (rows - 1)).map(|at| (at, at + columns));
    let difference = |&(a, b): &(usize, usize)| (values[a] - values[b]).abs();
    let most = right.chain(below).max_by(|a, b| difference(a).total_cmp(&difference(b)));
    let (a, b) = most.unwrap_or((0, 0));
    if values[a] <= values[b] { (a, b) } else { (b, a) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Photometry;
    use crate::source::sequence::random;
    use crate::spectrum::{WavelengthGrid, cie};

    const SIDE: usize = 64;

    /// An image whose luminances these are.
    fn image(luminance: impl Fn(usize, usize) -> f64) -> SpectralImage {
        let grid = WavelengthGrid::Step20;
        let mut image = SpectralImage::new(SIDE, SIDE, grid, Photometry::Absolute);
        let unit: f64 = (0..grid.bands()).map(|band| cie::cmf(grid, band)[1]).sum();
        let unit = unit * cie::K_LM_PER_W * grid.step_nm();
        for pixel in 0..SIDE * SIDE {
            let value = (luminance(pixel % SIDE, pixel / SIDE) / unit) as f32;
            image.bands[pixel * grid.bands()..(pixel + 1) * grid.bands()].fill(value);
        }
        image
    }

    const WHOLE: Region = Region { x: 0, y: 0, width: SIDE, height: SIDE };

    /// About normal: the sum of 12 even numbers.
    fn noise(seed: u64, pixel: u64) -> f64 {
        (0..12).map(|d| random(seed, pixel, d)).sum::<f64>() - 6.0
    }

    fn wave(x: usize) -> f64 {
        100.0 * (1.0 + 0.3 * (std::f64::consts::TAU * x as f64 / 16.0).sin())
    }

    /// L = 100 (1 + 0.3 sin(2πx/16)): contrast 0.3/√2, extremes 130 and 70, steepest at the zero,
    /// 0.3 sin(2π/16). In cells of half a period the mean of the sine is 2/π, in discrete form
    /// Σ sin(2πk/16)/8.
    #[test]
    fn a_wave_has_its_closed_figures() {
        let found = homogeneity(&image(|x, _| wave(x)), WHOLE, None, &[]).unwrap();
        let Evenness { mean, min, max, contrast, uniformity, gradient } = found.evenness;
        // f32 pixels.
        let near = |found: f64, expected: f64| {
            assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}");
        };
        near(mean, 100.0);
        near(min, 70.0);
        near(max, 130.0);
        near(contrast, 0.3 / 2f64.sqrt());
        near(uniformity, 70.0 / 130.0);
        near(gradient, 0.3 * (std::f64::consts::TAU / 16.0).sin());
        assert_eq!((found.cells, found.rays, found.samples), ([SIDE; 2], None, None));

        let coarse = homogeneity(&image(|x, _| wave(x)), WHOLE, Some([8, 1]), &[]).unwrap();
        let of_half = (0..8).map(|k| wave(k) / 100.0 - 1.0).sum::<f64>() / 8.0;
        near(coarse.evenness.contrast, of_half);
        near(coarse.evenness.gradient, 2.0 * of_half);
    }

    /// Errors that pictures state are the spread of the figures over many pictures: 300 of them
    /// tell a standard deviation within 4 %; four times that, and what is beyond first order.
    #[test]
    fn stated_errors_are_the_spread_over_pictures() {
        const SIGMA: f64 = 4.0;
        let region = Region { x: 3, y: 5, width: 32, height: 32 };
        let truth = homogeneity(&image(|x, _| wave(x)), region, Some([8, 8]), &[]).unwrap();
        let mut squares = [0.0; 3];
        let mut stated = [0.0; 3];
        for seed in 0..300 {
            let mut noisy = image(|x, y| wave(x) + SIGMA * noise(seed, (y * SIDE + x) as u64));
            let mean = 100.0;
            noisy.error = Some(
                noisy.to_xyz().pixels.iter().map(|c| (SIGMA / c.y.max(mean)) as f32).collect(),
            );
            let found = homogeneity(&noisy, region, Some([8, 8]), &[]).unwrap();
            let error = found.samples.unwrap().error;
            let figures = |e: &Evenness| [e.mean, e.contrast, e.min];
            for (at, value) in figures(&found.evenness).into_iter().enumerate() {
                squares[at] += (value - figures(&truth.evenness)[at]).powi(2);
                stated[at] += figures(&error)[at].powi(2);
            }
        }
        for at in 0..2 {
            let ratio = (squares[at] / stated[at]).sqrt();
            assert!((0.84..1.2).contains(&ratio), "figure {at}: {ratio}");
        }
        // The darkest of many noisy cells is darker than the truth by more than its own error.
        assert!((0.5..3.0).contains(&(squares[2] / stated[2]).sqrt()));
    }

    /// On an even surface all contrast is noise; halves tell it, of the whole flux or of half.
    #[test]
    fn halves_tell_the_noise_of_rays() {
        let (a, b) = (
            image(|x, y| 100.0 + 8.0 * noise(1, (y * SIDE + x) as u64)),
            image(|x, y| 100.0 + 8.0 * noise(2, (y * SIDE + x) as u64)),
        );
        let whole = super::super::weighted_sum(&[(0.5, &a), (0.5, &b)]).unwrap();
        let found = homogeneity(&whole, WHOLE, None, &[&a, &b]).unwrap();
        let rays = found.rays.unwrap();
        // 4096 pixels tell a standard deviation within 1.1 %.
        assert!((rays.noise / found.evenness.contrast - 1.0).abs() < 0.05, "{found:?}");
        assert!((rays.noise / (0.08 / 2f64.sqrt()) - 1.0).abs() < 0.05, "{found:?}");
        let expected = 8.0 / 2f64.sqrt() / SIDE as f64;
        assert!(rays.error.mean < 4.0 * expected, "{rays:?}");
        let [c, d] = [&a, &b].map(|half| super::super::weighted_sum(&[(0.5, half)]).unwrap());
        let of_layers = homogeneity(&whole, WHOLE, None, &[&c, &d]).unwrap().rays.unwrap();
        assert!((of_layers.noise / rays.noise - 1.0).abs() < 1e-5);
    }

    #[test]
    fn what_has_no_evenness_is_refused() {
        let message = |image: &SpectralImage, cells, halves: &[&SpectralImage]| {
            homogeneity(image, WHOLE, cells, halves).unwrap_err().to_string()
        };
        let lit = image(|_, _| 1.0);
        assert_eq!(message(&image(|_, _| 0.0), None, &[]), "homogeneity: the region has no light");
        assert_eq!(
            message(&lit, Some([65, 1]), &[]),
            "homogeneity: grid is {65, 1}, allowed: {1, 1} to the region's {64, 64}"
        );
        assert!(message(&lit, None, &[&lit]).contains("odd number of halves"));
        let small = SpectralImage::new(2, 2, lit.grid, lit.photometry);
        assert!(message(&lit, None, &[&lit, &small]).contains("a half has 2 × 2 pixels"));
        let one = homogeneity(&lit, Region::pixel(1, 1), None, &[]).unwrap().evenness;
        assert_eq!((one.contrast, one.gradient, one.uniformity), (0.0, 0.0, 1.0));
    }
}
