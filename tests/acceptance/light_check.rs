//! `scene:check_light_error` finds the light sums' errors where there are any.

use lampyris::geometry::DVec3;
use lampyris::material::Material;
use lampyris::render::{Quality, check_light_error};
use lampyris::scene::Prepared;
use lampyris::shading::{LightCheck, TraceLimits};
use lampyris::view::View;

use crate::stage::*;

const HITS: usize = 200;

fn check(prepared: &Prepared, light_error: f64) -> Option<LightCheck> {
    let quality = exact(4);
    let limits = TraceLimits { light_error, ..quality.limits };
    let view = View { fov_deg: 12.0, ..pixel_view(10.0, 400.0) };
    check_light_error(prepared, &view, &Quality { limits, ..quality }, HITS).expect("a good check")
}

#[test]
fn errors_are_found_and_within_their_estimates() {
    let prepared = busy_scene().prepare().expect("a good scene");
    let (coarse, fine) = (check(&prepared, 0.3), check(&prepared, 0.001));
    let (coarse, fine) = (coarse.expect("light"), fine.expect("light"));
    // One light, and an opaque mirror: at most a sum a hit.
    assert!((1..=HITS).contains(&coarse.sums), "{coarse:?}");
    assert!(coarse.median <= coarse.percentile_95 && coarse.percentile_95 <= coarse.largest);
    assert!(0.0 < coarse.largest && coarse.largest <= 0.3, "{coarse:?}");
    assert!(0.0 < coarse.largest_of_estimate && coarse.largest_of_estimate <= 1.0, "{coarse:?}");
    assert!(fine.largest <= 0.001 && fine.largest < coarse.largest, "{fine:?}, {coarse:?}");
}

#[test]
fn exact_sums_have_no_error() {
    let prepared = busy_scene().prepare().expect("a good scene");
    let check = check(&prepared, 0.0).expect("light");
    assert_eq!((check.median, check.largest, check.largest_of_estimate), (0.0, 0.0, 0.0));
}

#[test]
fn without_light_there_is_nothing_to_check() {
    let away = point_light(DVec3::Z * 10.0, DVec3::Z, 1.0);
    let matt = Material { lobes: diffuse(1.0, 1.0), ..material() };
    let prepared = scene(vec![(square(0.0, 5.0), matt)], vec![away]).prepare();
    assert!(check(&prepared.expect("a good scene"), 0.01).is_none());
}
