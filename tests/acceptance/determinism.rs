//! Same inputs, same bits.

use lampyris::image::SpectralImage;
use lampyris::render::{Asked, Quality, Samples, Unwatched};
use lampyris::shading::TraceLimits;
use lampyris::view::View;

use crate::stage::*;

fn shoot_with_threads(threads: usize, asked: &Asked) -> SpectralImage {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
    let view = View { width: 48, height: 32, fov_deg: 12.0, ..pixel_view(5.0, 500.0) };
    let prepared = busy_scene().prepare().expect("a good scene");
    pool.install(|| asked.render(&prepared, &view, &Unwatched)).expect("a good render").0
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let adaptive = Quality {
        samples: Samples::Adaptive { min: 2, max: 16, error: 0.02 },
        limits: TraceLimits { max_depth: 4, ..TraceLimits::default() },
        ..exact(4)
    };
    let qualities = [exact(4), adaptive].map(Asked::Quality);
    for asked in qualities.into_iter().chain([Asked::TargetError(0.05)]) {
        let one = shoot_with_threads(1, &asked);
        assert!(one.bands.iter().any(|&v| v > 0.0));
        for threads in [2, 3, 7] {
            assert!(shoot_with_threads(threads, &asked) == one, "{threads} threads");
        }
    }
}
