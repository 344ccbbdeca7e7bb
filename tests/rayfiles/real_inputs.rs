//! Ray files as programs and people really write them.

use lampyris::source::rayfile::{FluxUnit, Format, SpectrumSource, Warning};
use lampyris::spectrum::cie;

use crate::seeds::{self, Row, THREE, Zemax, message, read};

fn lumens(rows: &[Row]) -> f64 {
    let of = |row: &Row| 683.0 * cie::v_lambda(f64::from(row[7])) * f64::from(row[6]);
    rows.iter().map(of).sum()
}

#[test]
fn speos_files_are_told_by_their_size_and_rays() {
    let watts: f32 = THREE.iter().map(|row| row[6]).sum();
    let file = read(&seeds::speos(watts, 2.0, &THREE)).unwrap();
    assert_eq!(
        (file.format, file.flux_unit, file.flux_lm),
        (Format::Speos, FluxUnit::Watt, Some(2.0))
    );
    assert_eq!(file.samples[1].position, [0.75, 0.875, 0.125]);
    let SpectrumSource::PerRay { min_nm, max_nm } = file.spectrum_source else { panic!() };
    assert_eq!((min_nm, max_nm), (450.0, 620.0));
    // Without luminous flux the wavelengths give it.
    let file = read(&seeds::speos(watts, 0.0, &THREE)).unwrap();
    assert!((file.flux_lm.unwrap() / lumens(&THREE) - 1.0).abs() < 1e-6);
    let whole = seeds::speos(watts, 2.0, &THREE);
    assert!(message(&whole[..whole.len() - 1]).contains("not a ray file of a known format"));
}

#[test]
fn named_columns_come_in_any_order_and_with_wavelengths() {
    let text = seeds::named("x,y,z,dx,dy,dz,flux_w,wavelength_nm", ",", ".", &THREE);
    let german =
        seeds::named("X [mm];Y [mm];Z [mm];VX;VY;VZ;Power [W];Lambda [nm]", ";", ",", &THREE);
    let tabs =
        seeds::named("PosX\tPosY\tPosZ\tl\tm\tn\tradiant flux\twavelength", "\t", ".", &THREE);
    let utf16: Vec<u8> =
        format!("\u{feff}{german}").encode_utf16().flat_map(u16::to_le_bytes).collect();
    for bytes in [text.into_bytes(), german.into_bytes(), tabs.into_bytes(), utf16] {
        let file = read(&bytes).unwrap();
        assert_eq!((file.format, file.flux_unit), (Format::Csv, FluxUnit::Watt));
        assert_eq!(file.samples[2].position, [0.1875, -0.6875, 0.125]);
        assert!((file.flux_lm.unwrap() / lumens(&THREE) - 1.0).abs() < 1e-6);
    }
    let turned = "flux,x,y,z,dx,dy,dz\n2,1,2,3,0,0,1\n";
    let file = read(turned.as_bytes()).unwrap();
    assert_eq!((file.flux_lm, file.samples[0].position), (Some(2.0), [1.0, 2.0, 3.0]));
    let micrometers = "x,y,z,dx,dy,dz,flux,wavelength [um]\n0,0,0,0,0,1,1,0.555\n";
    let SpectrumSource::PerRay { min_nm, .. } =
        read(micrometers.as_bytes()).unwrap().spectrum_source
    else {
        panic!()
    };
    assert!((min_nm - 555.0).abs() < 1e-4);
    let meters = "x_m,y_m,z_m,dx,dy,dz,flux\n0.001,0,0,0,0,1,1\n";
    assert_eq!(read(meters.as_bytes()).unwrap().samples[0].position, [1.0, 0.0, 0.0]);
}

#[test]
fn eight_columns_without_names_are_told_by_their_wavelengths() {
    for (nm, other) in [(1.0, "620"), (1e-3, "0.62")] {
        let rows = THREE.map(|mut row| {
            row[7] *= nm;
            row
        });
        let file = read(seeds::named("rays of a lamp", " ", ".", &rows).as_bytes()).unwrap();
        assert_eq!((file.format, file.samples.len()), (Format::Columns, 3), "{other}");
        let SpectrumSource::PerRay { max_nm, .. } = file.spectrum_source else { panic!() };
        assert!((max_nm - 620.0).abs() < 1e-3);
    }
    let german = seeds::named("", "\t", ",", &THREE);
    assert_eq!(read(german.as_bytes()).unwrap().samples.len(), 3);
    assert_eq!(
        message(b"0 0 0 0 0 1 500 600\n"),
        "rays:1: 500 and 600 may both be a wavelength, or neither: name the columns in a first line \
         (x,y,z,dx,dy,dz,flux,wavelength)"
    );
}

/// One ray in a thousand may be none: a row of zeros, or a flux below 0.
#[test]
fn stray_rays_are_left_out_and_counted() {
    let good = [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 550.0];
    for stray in [[0.0; 8], [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, -1e-6, 550.0]] {
        let mut rows = vec![good; 2000];
        rows[1234] = stray;
        let mut flux_only = Zemax::flux_only(1);
        flux_only.rows = rows.iter().map(|row| row[..7].to_vec()).collect();
        let mut spectral = Zemax::spectral();
        // µm there.
        let in_um = |row: &Row| [&row[..7], &[row[7] / 1000.0]].concat();
        spectral.rows = rows.iter().map(in_um).collect();
        let files = [
            flux_only.bytes(),
            spectral.bytes(),
            seeds::speos(1999.0, 0.0, &rows),
            seeds::named("x,y,z,dx,dy,dz,flux,wavelength", ",", ".", &rows).into_bytes(),
        ];
        for bytes in files {
            let file = read(&bytes).unwrap();
            assert_eq!(file.samples.len(), 1999, "{}", file.format);
            assert!((file.flux_sum - 1999.0).abs() < 1e-9, "{}", file.format);
            let dropped = file.warnings.iter().find_map(|warning| match warning {
                Warning::RaysDropped { rays, .. } => Some(*rays),
                _ => None,
            });
            assert_eq!(dropped, Some(1), "{}", file.format);
        }
        // Three are too many, and the first is named.
        rows[3] = stray;
        rows[4] = stray;
        let named = seeds::named("x,y,z,dx,dy,dz,flux,wavelength", ",", ".", &rows);
        assert!(message(named.as_bytes()).starts_with("rays:5: "), "{}", message(named.as_bytes()));
        let speos = message(&seeds::speos(1.0, 0.0, &rows));
        assert!(speos.starts_with("rays: record 4: "), "{speos}");
    }
    // What is no number at all is refused, be it one in a million.
    let mut rows = vec![good; 2000];
    rows[7][0] = f32::NAN;
    assert!(message(&seeds::speos(1.0, 0.0, &rows)).starts_with("rays: record 8: start point"));
}

#[test]
fn packed_files_get_a_hint() {
    for (bytes, hint) in [
        (&b"\x1f\x8b\x08\x00"[..], "rays: is compressed (gzip): unpack it first"),
        (
            b"PK\x03\x04",
            "rays: is a ZIP archive (or an office document): unpack or export it first",
        ),
        (
            b"version https://git-lfs.github.com/spec/v1\noid sha256:1\n",
            "rays: is a pointer of Git LFS, not the file: run \"git lfs pull\" first",
        ),
    ] {
        assert_eq!(message(bytes), hint);
    }
}
