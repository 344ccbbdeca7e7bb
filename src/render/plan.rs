//! Which pixels of a picture need more samples, so that its error comes within a target.
//!
//! A pixel's samples are doubled, again and again: every power of two of them is as evenly spread
//! as can be. How far the mean is off is told by how its quarters differ.

use super::film::{Film, PixelStats};

/// Camera rays of every pixel in the first round: the fewest that differ, and more for closer
/// targets, since smaller things matter to them that few samples would miss.
fn first_samples(target: f64) -> u32 {
    ((0.08 / target) as u32).saturating_add(1).min(16).next_power_of_two().max(2)
}

/// A pixel's error falls as this power of its samples, where edges cross it (measured); halved.
const DECAY: f64 = 1.5;

/// Share of the wanted squared error that a plan aims at, since estimates scatter.
const AIM: f64 = 0.9;

/// Share of the samples to come by a plan that are taken in the end (measured: 0.17 to 0.48 after 2
/// and 4 samples a pixel, 0.36 to 0.63 after 8 and 16). Few samples overrate errors, and a pixel is
/// only doubled if it wants twice as many.
fn share_taken(first_samples: u32) -> f64 {
    if first_samples < 8 { 0.3 } else { 0.45 }
}

/// What a pixel needs at least, as a share of what its neighbors do: of the mean of their variances,
/// and of any one's samples. It may have a highlight that none of its samples has met, and the more
/// likely the more its neighbors need.
const SHARE_OF_NEIGHBORS: f64 = 0.25;

/// Sums of a pixel's luminances over the quarters of its samples, or halves if there are two.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Quarters {
    /// Samples that there will be: a power of two from 2 on, or 0 where no error is asked.
    planned: u32,
    sums: [f64; 4],
}

impl Quarters {
    /// Twice as many samples to come.
    fn double(&mut self) {
        let [a, b, c, d] = self.sums;
        self.sums = [a + b, c + d, 0.0, 0.0];
        self.planned *= 2;
    }

    /// Adds sample number `at`.
    pub fn add(&mut self, at: u32, luminance: f64) {
        if let Some(quarter) = (u64::from(at) * 4).checked_div(u64::from(self.planned)) {
            self.sums[quarter as usize % 4] += luminance;
        }
    }

    pub fn is_full(&self, count: u32) -> bool {
        count >= self.planned
    }

    /// Means of the four quarters, or of two halves.
    fn means(&self) -> impl Iterator<Item = f64> + Clone {
        let parts = self.planned.min(4) as usize;
        let of_part = f64::from(self.planned) / parts as f64;
        self.sums.into_iter().step_by(4 / parts.max(1)).map(move |sum| sum / of_part)
    }

    /// Square of the error of their `mean`.
    ///
    /// Parts are spread as evenly as all, only coarser, and all of them together are evener than
    /// four independent ones: this errs to the safe side by 1.4 where edges cross the pixel.
    fn squared_error(&self, mean: f64) -> f64 {
        let parts = f64::from(self.planned.min(4));
        self.means().map(|part| (part - mean).powi(2)).sum::<f64>() / (parts * (parts - 1.0))
    }

    /// What errors are relative to: the mean without its brightest part, or `lit`.
    ///
    /// A rare highlight that one sample has met by chance would otherwise excuse itself.
    fn scale(&self, lit: f64) -> f64 {
        let (sum, most) =
            self.means().fold((0.0, 0.0f64), |(sum, most), mean| (sum + mean, most.max(mean)));
        ((sum - most) / f64::from(self.planned.min(4) - 1)).max(lit)
    }
}

impl PixelStats {
    fn steps_a_sample(&self) -> f64 {
        self.steps as f64 / f64::from(self.count.max(1))
    }

    /// Estimated squared error of the luminance, relative to it or to `lit`.
    fn squared_error(&self, lit: f64) -> f64 {
        let scale = self.quarters.scale(lit);
        if scale > 0.0 { self.quarters.squared_error(self.mean) / scale.powi(2) } else { 0.0 }
    }
}

/// What a plan leads to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Outlook {
    /// Rays and light sums of the whole picture when it is done, as far as can be told.
    pub steps: f64,
    /// Whether any pixel has more to come.
    pub goes_on: bool,
}

impl Film {
    /// Every pixel's first samples; no more than `most`, but for two. Few pixels have more of them:
    /// their estimates scatter less by number.
    pub fn plan_first(&mut self, target: f64, most: u32) {
        const ALL: usize = 4096;
        let of_few = (ALL / self.pixels.len().max(1)).clamp(1, 16) as u32;
        let mut planned = first_samples(target).max(of_few.next_power_of_two());
        while planned > most.max(2) {
            planned /= 2;
        }
        self.pixels.iter_mut().for_each(|pixel| pixel.quarters.planned = planned);
    }

    /// Estimated rms error of luminance over lit pixels, relative to each.
    pub fn lit_error(&self) -> f64 {
        let lit = self.lit_luminance();
        let all_lit = self.pixels.iter().filter(|pixel| pixel.mean > 0.0 && pixel.mean >= lit);
        let squares: f64 = all_lit.clone().map(|pixel| pixel.squared_error(lit)).sum();
        (squares / all_lit.count().max(1) as f64).sqrt()
    }

    /// Doubles the samples of the pixels where that helps most, none beyond `most`, if their error
    /// is not yet within `target`.
    ///
    /// With errors e² ~ n^−[`DECAY`] the picture's is least for a given number of samples if each
    /// pixel has them in proportion to (e² n^DECAY)^(1/(1 + DECAY)).
    pub fn plan(&mut self, target: f64, most: u32) -> Outlook {
        if self.lit_error() <= target {
            return Outlook { steps: self.steps(), goes_on: false };
        }
        let errors = self.squared_errors();
        let wanted = self.wanted_samples(&errors, self.allowed(target, &errors, most));
        let is_open: Vec<bool> = self.pixels.iter().map(|pixel| 2 * pixel.count <= most).collect();
        let mut chosen: Vec<usize> =
            (0..errors.len()).filter(|&at| is_open[at] && self.needs_twice(at, &wanted)).collect();
        if chosen.is_empty() {
            chosen = self.most_useful(&errors, &is_open, target);
        }
        let to_come = self.pixels.iter().zip(&wanted).map(|(pixel, &wanted)| {
            pixel.steps_a_sample() * (wanted.min(f64::from(most)) - f64::from(pixel.count)).max(0.0)
        });
        let to_come = share_taken(first_samples(target)) * to_come.sum::<f64>();
        let outlook = Outlook { steps: self.steps() + to_come, goes_on: !chosen.is_empty() };
        chosen.into_iter().for_each(|at| self.pixels[at].quarters.double());
        outlook
    }

    /// Rays and light sums of all samples that were taken.
    pub fn steps(&self) -> f64 {
        self.pixels.iter().map(|pixel| pixel.steps as f64).sum()
    }

    /// Those of the samples that are planned and not taken.
    pub fn steps_to_come(&self) -> f64 {
        let open = |pixel: &PixelStats| pixel.quarters.planned.saturating_sub(pixel.count);
        self.pixels.iter().map(|pixel| pixel.steps_a_sample() * f64::from(open(pixel))).sum()
    }

    /// Sum of squared errors that pixels may leave together, were `most` no limit.
    fn allowed(&self, target: f64, errors: &[f64], most: u32) -> f64 {
        let lit = self.lit_luminance();
        let is_lit = |pixel: &&PixelStats| pixel.mean > 0.0 && pixel.mean >= lit;
        let count = self.pixels.iter().filter(is_lit).count();
        let all = AIM * target * target * count as f64;
        let pixels = self.pixels.iter().zip(errors);
        let closed: f64 =
            pixels.filter(|(pixel, _)| 2 * pixel.count > most).map(|(_, error)| error).sum();
        (all - closed).max(0.1 * all)
    }

    /// Estimated relative squared error of each pixel, also by what its neighbors' are.
    fn squared_errors(&self) -> Vec<f64> {
        let lit = self.lit_luminance();
        let own: Vec<f64> = self.pixels.iter().map(|pixel| pixel.squared_error(lit)).collect();
        let variance = |at: usize| own[at] * f64::from(self.pixels[at].count);
        let of_pixel = |at: usize| {
            let (sum, count) = self
                .around(at)
                .filter(|&other| other != at)
                .fold((0.0, 0.0), |(sum, count), other| (sum + variance(other), count + 1.0));
            let near = SHARE_OF_NEIGHBORS * sum / f64::max(count, 1.0);
            own[at].max(near / f64::from(self.pixels[at].count))
        };
        (0..own.len()).map(of_pixel).collect()
    }

    /// Samples of each pixel that leave the squared errors `allowed` together.
    fn wanted_samples(&self, errors: &[f64], allowed: f64) -> Vec<f64> {
        let pixels = self.pixels.iter().zip(errors);
        let shares: Vec<f64> = pixels
            .map(|(pixel, error)| {
                (error * f64::from(pixel.count).powf(DECAY)).powf((1.0 + DECAY).recip())
            })
            .collect();
        let scale = (shares.iter().sum::<f64>() / allowed).powf(DECAY.recip());
        shares.into_iter().map(|share| scale * share).collect()
    }

    fn needs_twice(&self, at: usize, wanted: &[f64]) -> bool {
        let near = self.around(at).map(|other| SHARE_OF_NEIGHBORS * wanted[other]);
        near.fold(wanted[at], f64::max) >= 2.0 * f64::from(self.pixels[at].count)
    }

    /// Pixels that are the cheapest to double, as many as bring the error within `target`.
    fn most_useful(&self, errors: &[f64], is_open: &[bool], target: f64) -> Vec<usize> {
        let gain = |at: usize| errors[at] / f64::from(self.pixels[at].count);
        let mut order: Vec<usize> = (0..errors.len()).filter(|&at| is_open[at]).collect();
        order.sort_by(|&a, &b| gain(b).total_cmp(&gain(a)));
        let mut excess: f64 = errors.iter().sum::<f64>() - self.allowed(target, errors, u32::MAX);
        let least = order.len().min(1 + order.len() / 50);
        let mut count = 0;
        while count < order.len() && (count < least || excess > 0.0) {
            excess -= errors[order[count]] * (1.0 - 2f64.powf(-DECAY));
            count += 1;
        }
        order.truncate(count);
        order
    }

    /// A pixel and those that touch it.
    fn around(&self, at: usize) -> impl Iterator<Item = usize> + use<> {
        let (width, height) = (self.width, self.pixels.len() / self.width);
        let (x, y) = (at % width, at / width);
        let rows = y.saturating_sub(1)..(y + 2).min(height);
        let columns = x.saturating_sub(1)..(x + 2).min(width);
        rows.flat_map(move |row| columns.clone().map(move |column| row * width + column))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::View;

    fn film(width: usize, height: usize) -> Film {
        Film::new(&View { width, height, ..View::default() }, 1, 0)
    }

    /// Doubles until there are `count`, and adds what `luminance` says of each.
    fn fill(pixel: &mut PixelStats, count: u32, luminance: impl Fn(u32) -> f64) {
        pixel.quarters.planned = 2;
        while pixel.count < count {
            if pixel.count > 0 {
                pixel.quarters.double();
            }
            while !pixel.quarters.is_full(pixel.count) {
                pixel.add(luminance(pixel.count), 0.0);
                pixel.steps += 1;
            }
        }
    }

    #[test]
    fn error_is_that_of_the_mean_of_four_quarters() {
        let mut film = film(1, 1);
        // Quarters of 16 equal samples each, of means 1 to 4: variance 5/3, brightest 4.
        fill(&mut film.pixels[0], 64, |i| f64::from(i / 16 + 1));
        let expected = (5.0 / 3.0 / 4.0f64).sqrt() / 2.0;
        assert!((film.lit_error() / expected - 1.0).abs() < 1e-12, "{}", film.lit_error());
    }

    #[test]
    fn two_samples_tell_the_error_of_their_mean() {
        let mut film = film(1, 1);
        fill(&mut film.pixels[0], 2, |i| f64::from(1 + 2 * i));
        // Half of the difference, relative to the darker one.
        assert!((film.lit_error() - 1.0).abs() < 1e-12, "{}", film.lit_error());
    }

    #[test]
    fn dark_pixels_do_not_count() {
        let mut film = film(2, 1);
        fill(&mut film.pixels[0], 16, |_| 1.0);
        fill(&mut film.pixels[1], 16, |i| 1e-4 * f64::from(i));
        assert_eq!(film.lit_error(), 0.0);
    }

    #[test]
    fn samples_go_where_they_help() {
        let mut film = film(9, 1);
        for (at, pixel) in film.pixels.iter_mut().enumerate() {
            let spread = if at == 0 { 0.5 } else { 0.0 };
            fill(pixel, 64, |i| 1.0 + spread * f64::from(i / 16 % 2));
        }
        let error = film.lit_error();
        assert!(!film.plan(1.01 * error, 100_000).goes_on, "is within the target");
        // Errors fall as n^−¾: a tenth takes 21.5 times as many.
        let outlook = film.plan(0.1 * error, 100_000);
        // From 576 to 1300 and more, of which 0.45 are thought to be taken.
        assert!(outlook.goes_on && outlook.steps > 900.0, "{outlook:?}");
        let open = |pixel: &PixelStats| !pixel.quarters.is_full(pixel.count);
        let doubled: Vec<bool> = film.pixels.iter().map(open).collect();
        assert_eq!(doubled[..2], [true, true], "its neighbor has some, too");
        assert!(doubled[3..].iter().all(|&more| !more));
    }

    #[test]
    fn closer_targets_start_with_more() {
        let first = [0.5, 0.1, 0.05, 0.03, 0.015, 0.01, 0.003, 1e-9].map(first_samples);
        assert_eq!(first, [2, 2, 2, 4, 8, 16, 16, 16]);
    }

    #[test]
    fn no_pixel_exceeds_the_most() {
        let mut film = film(1, 1);
        fill(&mut film.pixels[0], 64, |i| f64::from(i % 7));
        assert!(!film.plan(1e-9, 100).goes_on);
        assert!(film.plan(1e-9, 128).goes_on);
    }
}
