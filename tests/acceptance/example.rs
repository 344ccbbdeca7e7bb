//! The example is a program that works.

use std::path::Path;

use lampyris::output::{read_exr, read_png};

use crate::stage::scratch;

#[path = "../../examples/lamp.rs"]
#[allow(dead_code)] // its main
mod lamp;

#[test]
fn the_example_draws_a_lit_lamp() {
    let folder = scratch("example");
    std::fs::create_dir_all(&folder).expect("a folder");
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/goldens/reflector");
    lamp::draw(&data, &folder).expect("the example works");
    let image = read_exr(&folder.join("lamp.exr")).expect("a readable EXR");
    let brightest = image.to_xyz().luminance_percentile(100.0).expect("pixels");
    assert!(brightest > 1000.0, "{brightest} cd/m²");
    assert_eq!(read_png(&folder.join("lamp.png")).expect("a readable PNG").1, 8);
}
