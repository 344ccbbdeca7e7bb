//! Standard uncertainties of what a picture shows, from those of its inputs.
//!
//! The law of propagation and its words are the GUM's (JCGM 100:2008): flux and spectra act
//! linearly on the picture's bands, so their derivatives are known from the picture itself. Other
//! inputs are tried at three values (Gauss-Hermite), which is exact up to the fifth power of an
//! input and needs no derivative.

use crate::color::Xyz;
use crate::error::{Error, Result};
use crate::spectrum::{WavelengthGrid, cie};

/// Luminance, chromaticity x and y, intensity; what is unknown is 0 with an uncertainty of 0.
pub type Quantities = [f64; 4];

/// Light that the quantities are made of, at the bands of a grid.
#[derive(Debug, Clone, PartialEq)]
pub struct Seen {
    /// Mean spectral radiance of a region: luminance and chromaticity.
    pub region: Vec<f64>,
    /// Spectral radiant intensity of the picture; empty where it has none.
    pub frame: Vec<f64>,
}

impl Seen {
    /// Its luminance, chromaticity and intensity.
    pub fn quantities(&self, grid: WavelengthGrid) -> Quantities {
        let color = Xyz::from_bands(grid, &self.region);
        let [x, y] = color.chromaticity().unwrap_or_default();
        [color.y, x, y, cie::luminous(grid, &self.frame)]
    }

    /// Change of the quantities for a small change of the light.
    fn change(&self, grid: WavelengthGrid, by: &Self) -> Quantities {
        let color = Xyz::from_bands(grid, &self.region);
        let Xyz { x, y, z } = Xyz::from_bands(grid, &by.region);
        let sum = color.x + color.y + color.z;
        let [small_x, small_y] = color.chromaticity().unwrap_or_default();
        let share = |part: f64, whole: f64| match sum {
            0.0 => 0.0,
            _ => (part - whole * (x + y + z)) / sum,
        };
        [y, share(x, small_x), share(y, small_y), cie::luminous(grid, &by.frame)]
    }

    /// Band by band.
    fn map(&self, f: impl Fn(&[f64]) -> Vec<f64>) -> Self {
        Self { region: f(&self.region), frame: f(&self.frame) }
    }
}

/// What one input adds to the uncertainties.
#[derive(Debug, Clone, PartialEq)]
pub struct Contribution {
    /// The input.
    pub name: String,
    /// Standard uncertainties of the quantities from this input alone.
    pub u: Quantities,
    /// The same with signs; `None` for a spectrum, which is many inputs.
    pub signed: Option<Quantities>,
}

/// A relative uncertainty u(λ) of a spectrum, and how errors of its wavelengths go together.
#[derive(Debug, Clone, PartialEq)]
pub struct SpectralInput {
    /// u(λ)/s(λ) at the bands, ≥ 0.
    pub relative: Vec<f64>,
    /// r(Δλ) = exp(−|Δλ|/this), nm; 0 is independent bands.
    pub correlation_nm: f64,
}

/// An input of a picture, by what is known of its effect.
#[derive(Debug, Clone, PartialEq)]
pub enum InputEffect {
    /// Light in proportion to the input, and its relative standard uncertainty.
    Flux {
        /// What of the picture is its light.
        light: Seen,
        /// u(Φ)/Φ, ≥ 0.
        relative: f64,
    },
    /// The spectrum of a light whose flux is known by itself.
    LightSpectrum {
        /// What of the picture is its light.
        light: Seen,
        /// Its spectrum at the bands, relative.
        spectrum: Vec<f64>,
        /// What is known of it.
        input: SpectralInput,
    },
    /// Another spectrum: light at a band follows the same band only.
    Spectrum {
        /// Derivative of the light by the logarithm of the spectrum, at each band.
        slope: Seen,
        /// What is known of it.
        input: SpectralInput,
    },
    /// Anything else: the light at the input's value less and plus √3 standard uncertainties.
    Tried {
        /// At both.
        light: [Seen; 2],
    },
}

/// The combined standard uncertainties and the budget behind them.
#[derive(Debug, Clone, PartialEq)]
pub struct Budget {
    /// Estimates.
    pub values: Quantities,
    /// Combined standard uncertainties.
    pub u: Quantities,
    /// By input, the largest share of the luminance's variance first.
    pub contributions: Vec<Contribution>,
}

impl Contribution {
    /// What `input` adds to the quantities of `seen`.
    pub fn of(name: &str, seen: &Seen, grid: WavelengthGrid, input: &InputEffect) -> Self {
        let name = name.to_owned();
        match input {
            InputEffect::Flux { light, relative } => {
                let signed = seen.change(grid, light).map(|change| change * relative);
                Self { name, u: signed.map(f64::abs), signed: Some(signed) }
            }
            InputEffect::LightSpectrum { light, spectrum, input } => {
                let u = input.spread(
                    |band| seen.change(grid, &normalized(light, spectrum, grid, band)),
                    grid,
                );
                Self { name, u, signed: None }
            }
            InputEffect::Spectrum { slope, input } => {
                let only = |band: usize| slope.map(|bands| kept(bands, band));
                let u = input.spread(|band| seen.change(grid, &only(band)), grid);
                Self { name, u, signed: None }
            }
            InputEffect::Tried { light } => {
                let [low, high] = light.each_ref().map(|light| light.quantities(grid));
                let middle = seen.quantities(grid);
                let of = |f: fn(f64, f64, f64) -> f64| {
                    std::array::from_fn(|at| f(low[at], middle[at], high[at]))
                };
                Self {
                    name,
                    u: of(three_points),
                    signed: Some(of(|a, _, b| (b - a) / 12f64.sqrt())),
                }
            }
        }
    }
}

/// Standard deviation of a function of a normal input, from three values √3 of its deviations apart.
fn three_points(low: f64, middle: f64, high: f64) -> f64 {
    let points = [(low, 1.0 / 6.0), (middle, 2.0 / 3.0), (high, 1.0 / 6.0)];
    let mean: f64 = points.iter().map(|(value, weight)| value * weight).sum();
    points.iter().map(|(value, weight)| (value - mean).powi(2) * weight).sum::<f64>().sqrt()
}

/// Zero but for one band; empty stays empty.
fn kept(bands: &[f64], band: usize) -> Vec<f64> {
    let keep = |(at, value): (usize, &f64)| if at == band { *value } else { 0.0 };
    bands.iter().enumerate().map(keep).collect()
}

/// Derivative of a light of given flux by the logarithm of its spectrum at one band: more there is
/// less everywhere (eq. 12).
fn normalized(light: &Seen, spectrum: &[f64], grid: WavelengthGrid, band: usize) -> Seen {
    let share = cie::luminous(grid, &kept(spectrum, band)) / cie::luminous(grid, spectrum);
    light.map(|bands| {
        let more = kept(bands, band);
        more.iter().zip(bands).map(|(more, all)| more - share * all).collect()
    })
}

impl SpectralInput {
    /// √(Σ Σ r(λ, λ') c(λ) c(λ')) with the change c of each quantity by one band's uncertainty.
    fn spread(&self, change: impl Fn(usize) -> Quantities, grid: WavelengthGrid) -> Quantities {
        let changes: Vec<Quantities> = self
            .relative
            .iter()
            .enumerate()
            .map(|(band, u)| change(band).map(|change| change * u))
            .collect();
        let mut variance = Quantities::default();
        for (i, a) in changes.iter().enumerate() {
            for (j, b) in changes.iter().enumerate() {
                let r = self.correlation(i.abs_diff(j) as f64 * grid.step_nm());
                (0..4).for_each(|at| variance[at] += r * a[at] * b[at]);
            }
        }
        variance.map(|variance| variance.max(0.0).sqrt())
    }

    fn correlation(&self, apart_nm: f64) -> f64 {
        if apart_nm == 0.0 { 1.0 } else { (-apart_nm / self.correlation_nm).exp() }
    }
}

/// Combines contributions: u² = Σ uᵢ² + 2 Σ r(i, j) uᵢ uⱼ, uᵢ with its sign in the second sum.
///
/// Errors: a correlation of a name that is no input, or is a spectrum; correlations that contradict
/// each other.
pub fn combine(
    values: Quantities,
    mut contributions: Vec<Contribution>,
    correlations: &[(String, String, f64)],
) -> Result<Budget> {
    let mut variance = Quantities::default();
    for contribution in &contributions {
        (0..4).for_each(|at| variance[at] += contribution.u[at].powi(2));
    }
    let sum = variance;
    for (a, b, r) in correlations {
        let [a, b] = [signed(&contributions, a)?, signed(&contributions, b)?];
        (0..4).for_each(|at| variance[at] += 2.0 * r * a[at] * b[at]);
    }
    // Rounding may leave a little less than nothing.
    if (0..4).any(|at| variance[at] < -1e-9 * sum[at]) {
        return Err(Error::inconsistent("uncertainty", "the correlations contradict each other"));
    }
    let first = |contribution: &Contribution| contribution.u[0];
    contributions.sort_by(|a, b| first(b).total_cmp(&first(a)));
    Ok(Budget { values, u: variance.map(|v| v.max(0.0).sqrt()), contributions })
}

fn signed(contributions: &[Contribution], name: &str) -> Result<Quantities> {
    const OBJECT: &str = "uncertainty: correlation";
    let names = || contributions.iter().map(|c| c.name.as_str()).collect::<Vec<_>>().join(", ");
    let found = contributions.iter().find(|contribution| contribution.name == name);
    let found = found
        .ok_or_else(|| Error::out_of_range(OBJECT, "input", format!("\"{name}\""), names()))?;
    let problem =
        format!("\"{name}\" is a spectrum, which is correlated by its own \"correlation\"");
    found.signed.ok_or_else(|| Error::inconsistent(OBJECT, problem))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::study::{normal_quantile, standard_deviation};
    use crate::source::sequence::random;

    const GRID: WavelengthGrid = WavelengthGrid::Step20;

    fn seen(bands: &[f64]) -> Seen {
        Seen { region: bands.to_vec(), frame: bands.iter().map(|value| 2.0 * value).collect() }
    }

    /// Two lights of different color.
    fn lights() -> [Vec<f64>; 2] {
        let bands = |f: fn(f64) -> f64| (0..GRID.bands()).map(|b| f(b as f64)).collect();
        [bands(|b| 1.0 + 0.1 * b), bands(|b| 3.0 / (1.0 + b))]
    }

    fn sum(a: &[f64], b: &[f64]) -> Vec<f64> {
        a.iter().zip(b).map(|(a, b)| a + b).collect()
    }

    fn normal(draw: u64, dimension: u64) -> f64 {
        normal_quantile(random(5, draw, dimension).max(1e-12))
    }

    /// Standard deviations over 10⁴ draws, which know them within 0.7 %.
    fn drawn(light: impl Fn(u64) -> Vec<f64>) -> Quantities {
        let draws: Vec<Quantities> =
            (0..10_000).map(|draw| seen(&light(draw)).quantities(GRID)).collect();
        std::array::from_fn(|at| {
            standard_deviation(&draws.iter().map(|draw| draw[at]).collect::<Vec<_>>())
        })
    }

    /// Four deviations of the draws' own error, and the second order of 5 % inputs.
    fn assert_near(found: Quantities, expected: Quantities) {
        for at in 0..4 {
            assert!((found[at] / expected[at] - 1.0).abs() < 0.03, "{found:?} {expected:?}");
        }
    }

    #[test]
    fn fluxes_and_their_correlation_are_those_of_draws() {
        let [a, b] = lights();
        let whole = seen(&sum(&a, &b));
        let flux = |name: &str, light: &[f64]| {
            let input = InputEffect::Flux { light: seen(light), relative: 0.05 };
            Contribution::of(name, &whole, GRID, &input)
        };
        for r in [0.0, 0.8] {
            let budget = combine(
                whole.quantities(GRID),
                vec![flux("a", &a), flux("b", &b)],
                &[("a".to_owned(), "b".to_owned(), r)],
            )
            .unwrap();
            let draws = drawn(|draw| {
                let [z, other] = [normal(draw, 0), normal(draw, 1)];
                let second = r * z + (1.0 - r * r).sqrt() * other;
                let scaled = |light: &[f64], z: f64| -> Vec<f64> {
                    light.iter().map(|value| value * (1.0 + 0.05 * z)).collect()
                };
                sum(&scaled(&a, z), &scaled(&b, second))
            });
            assert_near(budget.u, draws);
        }
    }

    /// A chain of bands whose neighbors are correlated by exp(−20/40).
    fn chain(draw: u64) -> Vec<f64> {
        let r = (-20.0f64 / 40.0).exp();
        let mut last = normal(draw, 0);
        (0..GRID.bands() as u64)
            .map(|band| {
                if band > 0 {
                    last = r * last + (1.0 - r * r).sqrt() * normal(draw, band);
                }
                last
            })
            .collect()
    }

    #[test]
    fn spectra_are_those_of_draws() {
        let [a, b] = lights();
        let whole = seen(&sum(&a, &b));
        let input = SpectralInput { relative: vec![0.03; GRID.bands()], correlation_nm: 40.0 };
        let spectrum: Vec<f64> = (0..GRID.bands()).map(|band| 2.0 + band as f64).collect();
        let light = InputEffect::LightSpectrum {
            light: seen(&a),
            spectrum: spectrum.clone(),
            input: input.clone(),
        };
        let found = Contribution::of("a", &whole, GRID, &light);
        let draws = drawn(|draw| {
            let factors: Vec<f64> = chain(draw).iter().map(|z| 1.0 + 0.03 * z).collect();
            let changed: Vec<f64> = spectrum.iter().zip(&factors).map(|(s, f)| s * f).collect();
            let scale = cie::luminous(GRID, &spectrum) / cie::luminous(GRID, &changed);
            let light: Vec<f64> = a.iter().zip(&factors).map(|(a, f)| a * f * scale).collect();
            sum(&light, &b)
        });
        assert_near(found.u, draws);

        // Light that goes as the cube of a reflectance.
        let slope = InputEffect::Spectrum {
            slope: seen(&a.iter().map(|a| 3.0 * a).collect::<Vec<_>>()),
            input,
        };
        let found = Contribution::of("paint", &whole, GRID, &slope);
        let draws = drawn(|draw| {
            let light = a.iter().zip(chain(draw)).map(|(a, z)| a * (1.0 + 0.03 * z).powi(3));
            sum(&light.collect::<Vec<_>>(), &b)
        });
        assert_near(found.u, draws);
    }

    /// y = x² about 1 with u = 0.3: variance 4u² + 2u⁴, to which a derivative alone is blind.
    #[test]
    fn three_values_know_a_parabola() {
        let u = 0.3;
        let at = |k: f64| (1.0 + k * 3f64.sqrt() * u).powi(2);
        let expected = (4.0 * u * u + 2.0 * u.powi(4)).sqrt();
        assert!((three_points(at(-1.0), at(0.0), at(1.0)) / expected - 1.0).abs() < 1e-12);
    }

    #[test]
    fn wrong_correlations_are_named() {
        let part = |name: &str, signed| Contribution { name: name.to_owned(), u: [1.0; 4], signed };
        let parts = || vec![part("a", Some([1.0; 4])), part("b", Some([1.0; 4])), part("s", None)];
        let message = |a: &str, b: &str, r: f64| {
            combine([0.0; 4], parts(), &[(a.to_owned(), b.to_owned(), r)]).unwrap_err().to_string()
        };
        assert!(message("a", "c", 0.5).contains("input is \"c\", allowed: a, b, s"));
        assert!(message("a", "s", 0.5).contains("\"s\" is a spectrum"));
        assert!(message("a", "b", -3.0).contains("contradict"));
    }
}
