//! The reference scenes, run as scripts, against spectra computed by brute force in f64.

use std::path::Path;

use lampyris::output::read_exr;

use crate::stage::{run_script, scratch};

/// The 64-bit reference and ours differ by f32 light samples and f32 images.
const RELATIVE: f64 = 1e-4;
/// Of the image's maximum: what is darker is rounding.
const OF_MAXIMUM: f64 = 1e-9;
/// The rest are rays that pass an edge.
const PIXELS_THAT_AGREE: f64 = 0.995;

#[test]
fn goldens_agree_with_the_reference() {
    for (case, azimuths) in
        [("reflector", &[0, 6][..]), ("lens", &[0, 60, 85]), ("absolute", &[6, 45])]
    {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/goldens").join(case);
        let out = scratch("goldens").join(case);
        run_script(&folder.join("case.lua"), &out, &[]);
        for azimuth in azimuths {
            let image = out.join(format!("{case}_{azimuth}.exr"));
            compare(&image, &folder.join(format!("expected_az{azimuth}.csv")));
        }
    }
}

fn compare(image: &Path, expected: &Path) {
    let rendered = read_exr(image).expect("a readable EXR");
    let text = std::fs::read_to_string(expected).expect("a readable table");
    let rows: Vec<Vec<f64>> = text
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|cell| cell.parse().expect("a number")).collect())
        .collect();
    assert_eq!(rows.len(), rendered.width * rendered.height);
    let maximum = rows.iter().flat_map(|row| &row[2..]).copied().fold(0.0, f64::max);
    let agrees = |row: &&Vec<f64>| {
        let pixel = rendered.pixel(row[0] as usize, row[1] as usize);
        pixel.iter().zip(&row[2..]).all(|(&value, &expected)| {
            let tolerance = (RELATIVE * expected.abs()).max(OF_MAXIMUM * maximum);
            (f64::from(value) - expected).abs() <= tolerance
        })
    };
    let share = rows.iter().filter(agrees).count() as f64 / rows.len() as f64;
    assert!(share >= PIXELS_THAT_AGREE, "{}: {share} of the pixels agree", image.display());
}
