//! The light of the shipped lamps has the color that UN R48 demands of their lenses.

use std::path::Path;

use lampyris::color::signal::SignalColor;
use lampyris::image::Region;
use lampyris::output::read_exr;

use crate::stage::{run_script, scratch};

/// Chromaticity of all the light that a tiny picture of a lamp holds, as R48 judges it.
fn rendered_chromaticity(model: &str, image: &str) -> [f64; 2] {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts").join(model);
    let out = scratch("lens_colors");
    // Width in pixels, coarseness of the meshes, light samples.
    run_script(&script, &out, &["48", "8", "500"]);
    let image = read_exr(&out.join(image)).expect("a readable EXR");
    let all = Region { x: 0, y: 0, width: image.width, height: image.height };
    image.mean_xyz(all).expect("pixels").chromaticity().expect("light")
}

#[test]
fn red_lens_is_red() {
    let color = rendered_chromaticity("model1.lua", "model1_00.exr");
    assert!(SignalColor::Red.contains(color), "{color:?}");
}

#[test]
fn amber_lens_is_amber() {
    let color = rendered_chromaticity("model3.lua", "model3_turn.exr");
    assert!(SignalColor::Amber.contains(color), "{color:?}");
}
