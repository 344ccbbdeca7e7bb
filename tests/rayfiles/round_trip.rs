//! What is written reads back with the same bits.

use std::path::{Path, PathBuf};

use lampyris::light::{RaySample, RaySet};
use lampyris::output::save_rays as save;
use lampyris::source::rayfile::{self, LightOptions, RayFile, SaveFormat, SpectrumSource};
use lampyris::spectrum::Spectrum;
use proptest::prelude::*;

/// A file of its own in the system's folder for such, gone at the end.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        Self(std::env::temp_dir().join(format!("lampyris-{}-{name}", std::process::id())))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

fn written(rays: &RaySet, spectrum: &Spectrum, path: &Path) -> (RayFile, Vec<u8>) {
    save(path, rays, spectrum, SaveFormat::of(path).unwrap()).unwrap();
    (rayfile::read(path).unwrap(), std::fs::read(path).unwrap())
}

fn bits(sample: &RaySample) -> [u32; 7] {
    let mut bits = [0; 7];
    let values = sample.position.iter().chain(&sample.direction).chain([&sample.flux]);
    bits.iter_mut().zip(values).for_each(|(bits, value)| *bits = value.to_bits());
    bits
}

fn sample() -> impl Strategy<Value = RaySample> {
    let coordinate = prop_oneof![
        -1e3f32..1e3,
        Just(0.0),
        Just(-0.0),
        Just(f32::MIN_POSITIVE),
        Just(1e-40),
        Just(-3e38),
        Just(7.240_707e-16),
    ];
    let direction = (-1.0f32..1.0, -1.0f32..1.0, 0.1f32..1.0);
    let flux = prop_oneof![0.0f32..1.0, Just(1e-12), Just(3.3e9)];
    ([coordinate.clone(), coordinate.clone(), coordinate], direction, flux).prop_map(
        |(position, (x, y, z), flux)| {
            let [x, y, z] = [x, y, z].map(f64::from);
            let length = (x * x + y * y + z * z).sqrt();
            RaySample { position, direction: [x, y, z].map(|c| (c / length) as f32), flux }
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn same_bits(samples in prop::collection::vec(sample(), 1..50), case in 0u32..u32::MAX) {
        let flux_lm: f64 = samples.iter().map(|s| f64::from(s.flux)).sum();
        prop_assume!(flux_lm > 0.0);
        let rays = RaySet::new(samples.clone().into(), flux_lm);
        let spectrum = Spectrum::blackbody(2856.0);
        for extension in ["tm25ray", "csv"] {
            let scratch = Scratch::new(&format!("bits{case}.{extension}"));
            let (file, _) = written(&rays, &spectrum, &scratch.0);
            prop_assert!(file.samples.iter().map(bits).eq(samples.iter().map(bits)));
            prop_assert!(file.warnings.is_empty());
            // The header of TM-25 is f32.
            prop_assert!((file.flux_lm.unwrap() / flux_lm - 1.0).abs() < 1e-7);
        }
    }

    /// A set in other units than lm is written in lm, and from then on does not change.
    #[test]
    fn rescaled_sets_settle(samples in prop::collection::vec(sample(), 1..20), case in 0u32..u32::MAX) {
        prop_assume!(samples.iter().any(|s| s.flux > 0.0));
        let rays = RaySet::new(samples.into(), 460.0);
        let spectrum = Spectrum::blackbody(2856.0);
        for extension in ["tm25ray", "csv"] {
            let scratch = Scratch::new(&format!("settle{case}.{extension}"));
            let (file, first) = written(&rays, &spectrum, &scratch.0);
            prop_assert!(file.warnings.is_empty());
            let given = LightOptions { spectrum: Some(spectrum.clone()), flux_lm: None };
            let (again, _) = file.into_light(given).unwrap();
            prop_assert_eq!(again.flux_lm, 460.0);
            prop_assert_eq!(written(&again, &spectrum, &scratch.0).1, first);
        }
    }
}

fn one_ray() -> RaySet {
    let sample = RaySample { position: [1.0, 2.0, 3.0], direction: [0.0, 0.6, 0.8], flux: 460.0 };
    RaySet::new([sample].into(), 460.0)
}

#[test]
fn tm25_takes_the_spectrum_along() {
    let scratch = Scratch::new("spectrum.tm25ray");
    let table = Spectrum::from_pairs("s", [(400.0, 0.5), (550.0, 1.0), (700.0, 0.25)]).unwrap();
    let (file, _) = written(&one_ray(), &table, &scratch.0);
    assert_eq!(file.spectrum_source, SpectrumSource::Table);
    assert_eq!(file.spectrum, Some(table));
    assert_eq!(file.description.len(), 2);
    let (file, _) = written(&one_ray(), &Spectrum::constant(2.0), &scratch.0);
    assert_eq!(file.spectrum.map(|s| (s.at(380.0), s.at(600.0))), Some((2.0, 2.0)));
}

#[test]
fn placed_sets_are_written_where_they_are() {
    let scratch = Scratch::new("placed.csv");
    let quarter = glam::DAffine3::from_scale_rotation_translation(
        glam::DVec3::splat(2.0),
        glam::DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2),
        glam::DVec3::new(10.0, 0.0, 0.0),
    );
    let rays = RaySet { world_from_local: quarter, ..one_ray() };
    let (file, _) = written(&rays, &Spectrum::constant(1.0), &scratch.0);
    let close = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
    assert!(close(file.samples[0].position, [6.0, 2.0, 6.0]));
    assert!(close(file.samples[0].direction, [-0.6, 0.0, 0.8]));
}

#[test]
fn what_cannot_be_written_leaves_nothing_behind() {
    let scratch = Scratch::new("dark.csv");
    let mut dark = one_ray();
    dark.flux_lm = 0.0;
    assert!(save(&scratch.0, &dark, &Spectrum::constant(1.0), SaveFormat::Csv).is_err());
    assert!(!scratch.0.exists());
    std::fs::write(&scratch.0, "a file, not a folder").unwrap();
    assert!(
        save(&scratch.0.join("all.csv"), &one_ray(), &Spectrum::constant(1.0), SaveFormat::Csv)
            .is_err()
    );
    assert!(SaveFormat::of(Path::new("a.dat")).is_err());
    assert_eq!(SaveFormat::of(Path::new("a.TM25RAY")).unwrap(), SaveFormat::Tm25);
}
