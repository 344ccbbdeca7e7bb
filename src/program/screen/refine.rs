//! A picture that comes coarse first, then finer.

use super::Screen;
use crate::error::Result;
use crate::image::SpectralImage;
use crate::program::progress::Progress;
use crate::render::{Asked, Quality, RenderStats, Samples, Untold};
use crate::scene::Prepared;
use crate::shading::{Layers, TraceLimits};
use crate::view::View;

/// Pixels of the first picture: it is to be there before its maker has looked up.
const FIRST_PIXELS: usize = 5_000;

/// How much finer the next picture is along a side.
const FINER: usize = 4;

/// Bound on the relative error of the light sums of coarse pictures.
const COARSE_LIGHT_ERROR: f64 = 0.05;

/// Takes the picture that is asked for; where there is a screen, coarse ones are shown on the way.
///
/// Returns the picture's number on the screen, too.
/// Errors: as [`Asked::render`].
pub fn render(
    screen: Option<&Screen>,
    asked: &Asked,
    prepared: &Prepared,
    view: &View,
    progress: &Progress,
) -> Result<(SpectralImage, RenderStats, Option<usize>)> {
    let number = screen.map(Screen::next_render);
    let show = |image: &SpectralImage, shrink| {
        if let (Some(screen), Some(number)) = (screen, number) {
            screen.show(number, image, [view.width, view.height], shrink);
        }
    };
    if screen.is_some() {
        let mut shrink = first_shrink(view);
        while shrink > 1 {
            let view = smaller(view, shrink);
            let (image, _) = coarse(asked).render(prepared, &view, &Untold(progress))?;
            show(&image, shrink);
            shrink /= FINER;
        }
    }
    let (image, stats) = asked.render(prepared, view, progress)?;
    show(&image, 1);
    Ok((image, stats, number))
}

/// A power of two.
fn first_shrink(view: &View) -> usize {
    let sides = |shrink: &usize| view.pixels() / shrink.pow(2) > FIRST_PIXELS;
    let larger = (0..16).map(|power| 1usize << power).take_while(sides).count();
    1 << larger
}

fn smaller(view: &View, shrink: usize) -> View {
    let (width, height) = (view.width.div_ceil(shrink), view.height.div_ceil(shrink));
    View { width, height, ..*view }
}

/// One ray a pixel, at the bands that are asked for: others may miss a narrow spectrum.
fn coarse(asked: &Asked) -> Asked {
    let quality = match asked {
        Asked::Quality(quality) => *quality,
        Asked::TargetError(_) => Quality::default(),
    };
    let light_error = quality.limits.light_error.max(COARSE_LIGHT_ERROR);
    let limits = TraceLimits { light_error, ..quality.limits };
    let (samples, layers) = (Samples::Fixed(1), Layers::None);
    Asked::Quality(Quality { samples, limits, layers, ..quality })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_pictures_have_few_pixels() {
        for (width, height) in [(1, 1), (70, 70), (71, 71), (640, 480), (16384, 16384)] {
            let view = View { width, height, ..View::default() };
            let shrink = first_shrink(&view);
            assert!(view.pixels() / shrink.pow(2) <= FIRST_PIXELS, "{width} × {height}: {shrink}");
            assert!(shrink == 1 || view.pixels() * 4 / shrink.pow(2) > FIRST_PIXELS);
        }
    }
}
