//! The reference scenes, run as scripts, against spectra computed by brute force in f64.

use std::path::Path;

use lampyris::color::Photometry;
use lampyris::display::{Exposure, Look};
use lampyris::image::{SpectralImage, weighted_sum};
use lampyris::output::{Digits, develop_png, read_exr, read_png};
use lampyris::spectrum::WavelengthGrid;

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
    if share < PIXELS_THAT_AGREE {
        let pictures = write_pictures(image, &rendered, &rows);
        panic!("{}: {share} of the pixels agree; see {pictures}", image.display());
    }
}

/// Writes what was expected, what came, and their difference, exposed alike; says where.
fn write_pictures(path: &Path, rendered: &SpectralImage, rows: &[Vec<f64>]) -> String {
    let mut expected = rendered.clone();
    let bands = rendered.grid.bands();
    for row in rows {
        let start = (row[1] as usize * rendered.width + row[0] as usize) * bands;
        let places = &mut expected.bands[start..start + bands];
        places.iter_mut().zip(&row[2..]).for_each(|(place, &value)| *place = value as f32);
    }
    let mut difference = weighted_sum(&[(1.0, rendered), (-1.0, &expected)]).expect("of one size");
    difference.bands.iter_mut().for_each(|value| *value = value.abs());
    let look = Look::paper();
    let factor = look.factor(&look.latent(&expected).expect("finite")).expect("pixels");
    let look = Look { exposure: Exposure::Factor(factor), ..look };
    let stem = path.with_extension("");
    for (name, image) in
        [("expected", &expected), ("actual", rendered), ("difference", &difference)]
    {
        let picture = format!("{}_{name}.png", stem.display());
        develop_png(Path::new(&picture), image, &look).expect("a written picture");
    }
    format!("{}_{{expected,actual,difference}}.png", stem.display())
}

#[test]
fn a_golden_that_fails_leaves_pictures() {
    let out = scratch("goldens_that_fail");
    let image = SpectralImage::new(2, 1, WavelengthGrid::Step20, Photometry::Relative);
    let rows: Vec<Vec<f64>> =
        [0.0, 1.0].iter().map(|&x| [vec![x, 0.0], vec![1.0; 21]].concat()).collect();
    std::fs::create_dir_all(&out).expect("a folder");
    let place = write_pictures(&out.join("case.exr"), &image, &rows);
    assert!(place.ends_with("case_{expected,actual,difference}.png"), "{place}");
    let digits = |name: &str| {
        let raster = read_png(&out.join(format!("case_{name}.png"))).expect("a picture").0;
        raster.samples
    };
    assert_eq!(digits("expected"), digits("difference"), "all of it is missing");
    assert_eq!(digits("actual"), Digits::Eight(vec![0; 6].into()));
}
