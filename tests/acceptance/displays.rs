//! Lamps are more saturated than most displays: what of UN R48's colors each can show.

use lampyris::color::Xyz;
use lampyris::color::signal::SignalColor;
use lampyris::display::{Display, Gamut, GamutMap};

/// Whether a place lies in a convex polygon.
fn is_between(corners: &[[f64; 2]], [x, y]: [f64; 2]) -> bool {
    let side = |at: usize| {
        let ([ax, ay], [bx, by]) = (corners[at], corners[(at + 1) % corners.len()]);
        (bx - ax) * (y - ay) - (by - ay) * (x - ax) >= 0.0
    };
    (1..corners.len()).all(|at| side(at) == side(0))
}

/// Share of a color's area in xy that `display` shows without clipping, in percent.
fn share_shown(color: SignalColor, display: &Display) -> f64 {
    // Where the display is far from its black and its white.
    let luminance = 0.05 * display.white().y;
    let map = GamutMap::new(display, Gamut::Clip);
    let corners = color.corners();
    let bounds = |c: usize| {
        let values = corners.iter().map(|corner| corner[c]);
        values.clone().fold(1.0, f64::min)..values.fold(0.0, f64::max)
    };
    let (x_range, y_range) = (bounds(0), bounds(1));
    let (mut inside, mut shown) = (0, 0);
    const STEPS: usize = 400;
    for at in 0..STEPS * STEPS {
        let place = |range: &std::ops::Range<f64>, step: usize| {
            range.start + (range.end - range.start) * (step as f64 + 0.5) / STEPS as f64
        };
        let xy = [place(&x_range, at % STEPS), place(&y_range, at / STEPS)];
        // The regulation's lines are open where the locus of pure colors bounds its corners.
        if is_between(corners, xy) {
            inside += 1;
            let (_, report) = map.map(Xyz::from_xy(xy, luminance));
            shown += usize::from(report.outside() == 0);
        }
    }
    100.0 * f64::from(shown as u32) / f64::from(inside)
}

/// Red and amber of each display in percent, computed beside the project from areas in xy.
#[test]
fn wide_gamuts_show_lawful_lamps() {
    for (name, red, amber) in
        [("eizo_t766", 0.0, 0.0), ("srgb", 0.0, 0.0), ("p3", 24.0, 47.0), ("rec2020", 59.0, 63.0)]
    {
        let display = Display::named(name).expect("a display");
        let shares = [SignalColor::Red, SignalColor::Amber].map(|c| share_shown(c, &display));
        for (share, expected) in shares.into_iter().zip([red, amber]) {
            // Half a percent of rounding and a grid of 400 × 400.
            assert!((share - expected).abs() <= 1.0, "{name}: {shares:?}");
        }
    }
}
