//! What each format says comes out.

use lampyris::light::RaySample;
use lampyris::source::rayfile::{FluxUnit, Format, LightOptions, RayFile, SpectrumSource, Warning};
use lampyris::spectrum::{Spectrum, WavelengthGrid, cie};

use crate::seeds::{self, LightTools, Row, THREE, Tm25, Zemax, read};

fn stored(row: &Row) -> RaySample {
    RaySample {
        position: [row[0], row[1], row[2]],
        direction: [row[3], row[4], row[5]],
        flux: row[6],
    }
}

/// Lumens of W at a wavelength.
fn lumens(row: &Row) -> f64 {
    683.0 * cie::v_lambda(f64::from(row[7])) * f64::from(row[6])
}

fn assert_same_geometry(file: &RayFile) {
    assert_eq!(file.samples.len(), THREE.len());
    for (sample, row) in file.samples.iter().zip(&THREE) {
        assert_eq!(sample.position, stored(row).position, "{}", file.format);
        assert_eq!(sample.direction, stored(row).direction, "{}", file.format);
    }
}

#[test]
fn three_rays_are_the_same_in_every_encoding_with_wavelengths() {
    let with_wavelengths: Vec<Vec<u8>> = vec![
        Tm25 {
            spectral_id: 2,
            flags: [1, 1, 1, 1, 0, 0, 0, 0],
            rows: THREE.iter().map(|r| r.to_vec()).collect(),
            ..Tm25::default()
        }
        .bytes(),
        Zemax::spectral().bytes(),
        LightTools::spectral().bytes(),
        seeds::lighttools_ascii().into_bytes(),
        seeds::zemax_text().into_bytes(),
    ];
    let expected_lm: f64 = THREE.iter().map(lumens).sum();
    for bytes in with_wavelengths {
        let file = read(&bytes).unwrap();
        assert_same_geometry(&file);
        assert_eq!(file.flux_unit, FluxUnit::Watt);
        // µm in f32 are good to 3e-5 nm, f32 flux to 6e-8.
        assert!((file.flux_lm.unwrap() / expected_lm - 1.0).abs() < 1e-6, "{}", file.format);
        for (sample, row) in file.samples.iter().zip(&THREE) {
            assert!((f64::from(sample.flux) / lumens(row) - 1.0).abs() < 1e-6);
        }
        let SpectrumSource::PerRay { min_nm, max_nm } = file.spectrum_source else { panic!() };
        assert!((min_nm - 450.0).abs() < 1e-4 && (max_nm - 620.0).abs() < 1e-4);
        let spectrum = file.spectrum.unwrap();
        let watts: f64 = THREE.iter().map(|r| f64::from(r[6])).sum();
        for row in THREE {
            let share = spectrum.at(f64::from(row[7])) * 5.0;
            assert!((share - f64::from(row[6]) / watts).abs() < 1e-5);
        }
    }
}

#[test]
fn three_rays_are_the_same_in_every_encoding_without_wavelengths() {
    let files = [
        (Tm25::default().bytes(), Format::Tm25),
        (Zemax::flux_only(1).bytes(), Format::ZemaxBinary),
        (LightTools::flux_only(1).bytes(), Format::LightToolsBinary),
        (LightTools { major: 3, ..LightTools::flux_only(1) }.bytes(), Format::LightToolsBinary),
        (seeds::asap(u32::to_le_bytes), Format::Asap),
        (seeds::asap(u32::to_be_bytes), Format::Asap),
        (seeds::seven_columns().into_bytes(), Format::Columns),
        (seeds::csv().into_bytes(), Format::Csv),
    ];
    for (bytes, format) in files {
        let file = read(&bytes).unwrap();
        assert_eq!(file.format, format);
        assert_same_geometry(&file);
        assert!(file.samples.iter().zip(&THREE).all(|(s, row)| s.flux == row[6]));
        assert_eq!(file.flux_lm, Some(file.flux_sum));
        assert_eq!(file.spectrum, None);
        let stated = file.flux_unit == FluxUnit::Lumen;
        assert_eq!(file.warnings.contains(&Warning::UnstatedUnit), !stated, "{format}");
    }
}

#[test]
fn every_column_of_tm25_has_its_place() {
    // 64 combinations of the flags after position and direction; each column holds its own value.
    for combination in 0..64u32 {
        let flag = |i: u32| (combination >> i & 1) as i32;
        let flags = [1, 1, flag(0), flag(1), flag(2), flag(3), flag(4), flag(5)];
        if flags[2] + flags[4] == 0 {
            continue;
        }
        let row = |r: &Row| {
            let mut row = r[..6].to_vec();
            let columns = [
                (flags[2], vec![r[6]]),
                (flags[3], vec![r[7]]),
                (flags[4], vec![100.0 * r[6]]),
                (flags[5], vec![9.0; 6]),
                (flags[6], vec![-7.0; 2]),
                (flags[7], vec![f32::from_bits(2)]),
            ];
            row.extend(columns.into_iter().filter(|(flag, _)| *flag == 1).flat_map(|(_, c)| c));
            row.extend([-1.0, f32::NAN]);
            row
        };
        let tm25 = Tm25 {
            flags,
            rows: THREE.iter().map(row).collect(),
            tables: vec![vec![[450.0, 1.0]], vec![[600.0, 1.0]]],
            additional: 2,
            text_bytes: 64,
            ..Tm25::default()
        };
        let factor = if flags[4] == 1 { 100.0 } else { 1.0 };
        for spectral_id in 0..5 {
            let needs = match spectral_id {
                2 => flags[2] == 1 && flags[3] == 1,
                4 => flags[7] == 1,
                _ => true,
            };
            let bytes = Tm25 { spectral_id, wavelength: 550.0, ..tm25.clone() }.bytes();
            if !needs {
                assert!(read(&bytes).is_err(), "{flags:?} {spectral_id}");
                continue;
            }
            let file = read(&bytes).unwrap();
            assert_same_geometry(&file);
            let sum: f64 = THREE.iter().map(|r| f64::from(r[6] * factor)).sum();
            assert!((file.flux_sum / sum - 1.0).abs() < 1e-7, "{flags:?} {spectral_id}");
        }
    }
}

#[test]
fn one_wavelength_one_table_and_a_table_a_ray() {
    let radiant = [1, 1, 1, 0, 0, 0, 0, 0];
    let file = read(
        &Tm25 { spectral_id: 1, wavelength: 550.0, flags: radiant, ..Tm25::default() }.bytes(),
    )
    .unwrap();
    let efficacy = 683.0 * cie::v_lambda(550.0);
    assert!((file.flux_lm.unwrap() / (efficacy * file.flux_sum) - 1.0).abs() < 1e-12);
    assert_eq!(file.spectrum_source, SpectrumSource::Line { nm: 550.0 });

    let table = vec![[545.0, 0.0], [550.0, 2.0], [555.0, 0.0]];
    let file = read(
        &Tm25 { spectral_id: 3, flags: radiant, tables: vec![table], ..Tm25::default() }.bytes(),
    )
    .unwrap();
    // A narrow triangle: V changes by 1 % across it and almost linearly.
    assert!((file.flux_lm.unwrap() / (efficacy * file.flux_sum) - 1.0).abs() < 2e-3);
    assert_eq!(file.spectrum_source, SpectrumSource::Table);

    // Two rays blue, one red, indices as floats and as integers.
    for index in [|i: u32| i as f32, f32::from_bits as fn(u32) -> f32] {
        let indices = [1, 2, 1].map(index);
        let rows = THREE.iter().zip(indices).map(|(r, i)| [&r[..7], &[i]].concat()).collect();
        let file = read(
            &Tm25 {
                spectral_id: 4,
                flags: [1, 1, 1, 0, 0, 0, 0, 1],
                tables: vec![vec![[450.0, 3.0]], vec![[620.0, 1.0]]],
                rows,
                ..Tm25::default()
            }
            .bytes(),
        )
        .unwrap();
        assert_eq!(file.spectrum_source, SpectrumSource::Mixture { tables: 2 });
        let (blue, red) = (0.003 + 0.0015, 0.0045);
        let spectrum = file.spectrum.unwrap();
        assert!((spectrum.at(450.0) / spectrum.at(620.0) - blue / red).abs() < 1e-6);
        let expected = 683.0 * (cie::v_lambda(450.0) * blue + cie::v_lambda(620.0) * red);
        assert!((file.flux_lm.unwrap() / expected - 1.0).abs() < 1e-6);
    }
}

#[test]
fn lengths_of_every_unit() {
    for (length_unit, mm) in [(0, 1000.0), (1, 25.4), (2, 10.0), (3, 304.8), (4, 1.0)] {
        let file = read(&Zemax { length_unit, ..Zemax::flux_only(0) }.bytes()).unwrap();
        assert_eq!(file.samples[1].position[0], (0.75 * mm) as f32);
        assert_eq!(file.flux_unit, FluxUnit::Watt);
        let text = seeds::zemax_text().replace("3\t4", &format!("3\t{length_unit}"));
        assert_eq!(read(text.as_bytes()).unwrap().samples, {
            let spectral = Zemax { length_unit, ..Zemax::spectral() };
            read(&spectral.bytes()).unwrap().samples
        });
    }
    let units = [(1, 1.0), (2, 10.0), (3, 1e3), (4, 25.4), (5, 304.8), (6, 1e-3), (7, 1e-6)];
    for (length_unit, mm) in units {
        let file = read(&LightTools { length_unit, ..LightTools::spectral() }.bytes()).unwrap();
        assert_eq!(file.samples[1].position[0], (0.75 * mm) as f32);
    }
    let file = read(&LightTools { length_unit: 0, ..LightTools::spectral() }.bytes()).unwrap();
    assert_eq!(file.warnings, [Warning::UnstatedLengthUnit]);
}

#[test]
fn far_field_and_tristimulus_rows() {
    let far = LightTools {
        far_field: 1,
        rows: THREE.iter().map(|r| r[3..7].to_vec()).collect(),
        ..LightTools::flux_only(1)
    };
    let file = read(&far.bytes()).unwrap();
    assert!(file.samples.iter().all(|s| s.position == [0.0; 3]));
    assert_eq!(file.samples[2].direction, [0.28, -0.96, 0.0]);

    let row = |r: &Row| [&r[..6], &[5.0, r[6], 7.0]].concat();
    let xyz =
        LightTools { color: 1, rows: THREE.iter().map(row).collect(), ..LightTools::flux_only(1) };
    assert_eq!(read(&xyz.bytes()).unwrap().samples[0].flux, 0.003);
}

#[test]
fn the_header_flux_counts_and_one_warning_shows_both() {
    let sum = f64::from(0.003f32) + f64::from(0.0045f32) + f64::from(0.0015f32);
    let files = [
        Tm25 { luminous: 460.0, ..Tm25::default() }.bytes(),
        Zemax { flux: 460.0, ..Zemax::flux_only(1) }.bytes(),
        LightTools { flux: 460.0, ..LightTools::flux_only(1) }.bytes(),
        format!("# flux_lm = 460\n{}", seeds::csv()).into_bytes(),
    ];
    for bytes in files {
        let file = read(&bytes).unwrap();
        assert_eq!(file.flux_lm, Some(460.0), "{}", file.format);
        assert_eq!(
            file.warnings,
            [Warning::HeaderFlux { header: 460.0, sum, unit: FluxUnit::Lumen }]
        );
        assert_eq!(
            file.warnings[0].to_string(),
            "the header says 460 lm, the rays sum to 0.009 lm: rescaled to the header"
        );
    }
}

/// NaN as vendors write it, one of them with its bytes swapped.
#[test]
fn an_unknown_header_flux_is_the_sum() {
    for bits in [0x7fc0_0001, 0x7f80_0001, 0x0100_c07f, 0x0100_807f, 0] {
        let luminous = f32::from_bits(bits);
        let file = read(&Tm25 { luminous, ..Tm25::default() }.bytes()).unwrap();
        assert_eq!(file.header_flux, None, "{bits:#x}");
        assert!(file.warnings.is_empty());
    }
}

#[test]
fn a_spectrum_must_come_from_somewhere() {
    let file = read(&Zemax { flux: 2.0, ..Zemax::flux_only(0) }.bytes()).unwrap();
    assert_eq!(file.flux_lm, None);
    let error = file.clone().into_light(LightOptions::default()).unwrap_err();
    assert_eq!(error.to_string(), "rays: the file has no spectrum, give \"spectrum\"");

    // 2 W with an even spectrum over 380 to 780 nm.
    let even = Spectrum::constant(1.0);
    let given = LightOptions { spectrum: Some(even.clone()), ..Default::default() };
    let (rays, _) = file.clone().into_light(given).unwrap();
    let expected = 2.0 * even.luminous_flux(WavelengthGrid::Step5) / 400.0;
    // The grid's sum counts the end bands whole: 4e-5 of 1 on one side.
    assert!((rays.flux_lm / expected - 1.0).abs() < 1e-5);

    let given = LightOptions { spectrum: Some(even), flux_lm: Some(460.0) };
    assert_eq!(file.into_light(given).unwrap().0.flux_lm, 460.0);
}

/// Extremes of flux: sums of 1e-12 and 1e12 lm.
#[test]
fn tiny_and_huge_flux() {
    for flux in [1e-12f32, 1e12] {
        let rows = (0..1000).map(|_| vec![0.0, 0.0, 0.0, 0.0, 0.0, 1.0, flux / 1000.0]).collect();
        let file = read(&Tm25 { luminous: flux, rows, ..Tm25::default() }.bytes()).unwrap();
        assert!(file.warnings.is_empty());
        assert!((file.flux_sum / f64::from(flux) - 1.0).abs() < 1e-6);
    }
}

/// More rays than a batch: the same rays and the same sums for one thread and for many.
#[test]
fn threads_do_not_change_a_bit() {
    let rows: Vec<Vec<f32>> = (0..100_000u32)
        .map(|i| vec![i as f32, 0.5, -0.25, 0.0, 0.6, 0.8, 1.0 + (i % 97) as f32 * 1e-3])
        .collect();
    let text: String = rows
        .iter()
        .map(|r| format!("{} {} {} {} {} {} {}\n", r[0], r[1], r[2], r[3], r[4], r[5], r[6]))
        .collect();
    for bytes in [Tm25 { rows, ..Tm25::default() }.bytes(), text.into_bytes()] {
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| read(&bytes).unwrap())
        };
        let (one, many) = (with(1), with(5));
        assert_eq!(one.samples, many.samples);
        assert_eq!(one.samples[99_999].position[0], 99_999.0);
        assert_eq!(one.flux_sum.to_bits(), many.flux_sum.to_bits());
    }
}
