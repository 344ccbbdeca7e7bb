//! Files as instruments, spreadsheets and people write them, each with its right value.

use std::path::Path;

use super::*;
use crate::input::mutation;

fn table(bytes: impl Into<Vec<u8>>) -> Result<Table> {
    Table::from_bytes(Path::new("t.csv"), bytes.into())
}

fn curve(bytes: impl Into<Vec<u8>>) -> Result<WavelengthCurve> {
    table(bytes)?.curve(&TableChoice::default())
}

/// Wavelengths and values of a good file.
fn pairs(bytes: impl Into<Vec<u8>>) -> Vec<(f64, f64)> {
    let curve = curve(bytes).unwrap();
    curve.lambda_nm.into_iter().zip(curve.values).collect()
}

fn message(bytes: impl Into<Vec<u8>>) -> String {
    curve(bytes).unwrap_err().to_string()
}

const THREE: [(f64, f64); 3] = [(380.0, 0.85), (580.0, 0.9), (780.0, 0.00041168)];

#[test]
fn separators_and_decimal_marks_are_found() {
    for text in [
        "380,0.85\n580,0.9\n780,4.1168E-04\n",
        "380;0.85\n580;0.9\n780;4.1168E-04\n",
        "380;0,85\n580;0,9\n780;4,1168E-04\n",
        "380\t0,85\n580\t0,9\n780\t4,1168E-04\n",
        "380 0.85\n580 0.9\n780 4.1168E-04",
        "  380    0,850\r\n  580    0,900\r\n  780    4,1168E-04\r\n\r\n",
        "380 \t 0.85\n580\t0.9\n780  4.1168e-4\n",
        "\"380\",\"0,85\"\n\"580\",\"0,9\"\n\"780\",\"4,1168E-04\"\n",
        "\"380\";\"0,85\"\n\"580\";\"0,9\"\n\"780\";\"4,1168E-04\"\n",
        "380,0;0,85;\n580,0;0,9;\n780,0;4,1168E-04;\n",
        "sep=;\nnm;R\n380;0,85\n580;0,9\n780;4,1168E-04\n",
        "380 nm, 85 %\n580 nm, 90 %\n780 nm, 0.041168 %\n",
        "380, 0.85, first\n580, 0.9\n780, 4.1168E-04, last\n",
        "# of 2024, a comment\n380,0.85 # so\n\n% another\n580,0.9\n780,4.1168E-04\n",
        "780;4,1168E-04\n580;0,9\n380;0,85\n",
    ] {
        let found = pairs(text);
        let close = found.iter().zip(THREE).all(|(a, b)| a.0 == b.0 && (a.1 - b.1).abs() < 1e-15);
        assert!(close && found.len() == 3, "{text}: {found:?}");
    }
}

#[test]
fn decimal_commas_between_commas_are_refused() {
    let hint =
        ": decimal commas? then write semicolons between the columns, or points in the numbers";
    assert_eq!(
        message("380,0,850\n385,0,860\n"),
        format!("t.csv:1: a column too many (\"380,0,850\"){hint}")
    );
    assert_eq!(
        message("nm,R\n380,0,850\n385,0,860\n"),
        format!("t.csv:2: a column too many (\"380,0,850\"){hint}")
    );
    assert_eq!(
        message("380,0,850\n385,0,860\n390,1\n"),
        format!("t.csv:3: has 2 columns, the rows above have 3 (\"390,1\"){hint}")
    );
    assert_eq!(
        message("380,4,1168E-04\n385,4,2E-04\n"),
        format!("t.csv:1: a column too many (\"380,4,1168E-04\"){hint}")
    );
    assert!(message("380, 0,850\n385, 0,860\n").contains("a column too many"));
    assert!(message("380,0,0,850\n385,0,0,860\n").contains("a column too many"));
    // A header that names as many columns makes it clear.
    assert_eq!(pairs("nm,a,b\n380,0,1\n385,1,0\n"), [(380.0, 0.0), (385.0, 1.0)]);
    assert_eq!(
        message("380;1.234,5\n385;1.235,5\n"),
        "t.csv:1: \"380;1.234,5\" has points and commas in one number, expected one decimal mark"
    );
}

#[test]
fn a_mark_without_a_header_loses_no_row() {
    let text = "\u{feff}380,0.1\n780,0.9\n";
    let expected = [(380.0, 0.1), (780.0, 0.9)];
    assert_eq!(pairs(text), expected);
    let utf16 = |of: fn(u16) -> [u8; 2], text: &str| -> Vec<u8> {
        text.encode_utf16().flat_map(of).collect()
    };
    for text in [text, "380\t0.1\r\n780\t0.9\r\n", "380;0,1\n780;0,9\n"] {
        assert_eq!(pairs(utf16(u16::to_le_bytes, text)), expected);
        assert_eq!(pairs(utf16(u16::to_be_bytes, text)), expected);
    }
    let korean =
        [&b"\xc6\xc4\xc0\xe5;\xb9\xdd\xbb\xe7\xc0\xb2\n"[..], b"380;0,1\n780;0,9\n"].concat();
    let found = table(korean).unwrap();
    assert_eq!(
        (found.reading.encoding, found.names),
        (Encoding::Cp949, vec!["파장".to_owned(), "반사율".to_owned()])
    );
    let latin = [&b"Wellenl\xe4nge;R\n"[..], b"380;0,1\n780;0,9\n"].concat();
    assert_eq!(pairs(latin), expected);
}

#[test]
fn headers_and_ends_of_instruments_are_left_aside() {
    let ocean = "SpectraSuite Data File\n++++++++++++++++++++++++++++++++++++\nDate: Tue Mar 03 12:00:00 \
        2020\nUser: me\nIntegration Time (usec): 100000 (USB4F04123)\nSpectra Averaged: 10\nBoxcar \
        Smoothing: 5\nNumber of Pixels in File: 3\n>>>>>Begin Spectral Data<<<<<\n380.00\t0.10\n\
        580.12\t0.50\n780.00\t0.90\n>>>>>End Spectral Data<<<<<\n";
    assert_eq!(pairs(ocean), [(380.0, 0.1), (580.12, 0.5), (780.0, 0.9)]);
    let reading = table(ocean).unwrap().reading;
    assert_eq!(reading.instrument, Some("Ocean Optics SpectraSuite"));
    assert_eq!(
        reading.notes,
        [
            "9 lines above the rows",
            "1 lines below, from \">>>>>End Spectral Data<<<<<\" in line 13"
        ]
    );
    let german = ocean.replace("0.10", "0,10").replace("0.50", "0,50").replace("0.90", "0,90");
    let german =
        german.replace("380.00", "380,00").replace("580.12", "580,12").replace("780.00", "780,00");
    assert_eq!(pairs(german), pairs(ocean));

    let avantes = "Integration time [ms]:  6,700\nAveraging Nr. [scans]: 100\nSmoothing Nr. [pixels]: 2\n\
        Data measured with spectrometer [name]: 0909060U1\nWave   ;Sample   ;Dark     ;Reference;\
        Transmittance\n[nm]   ;[counts] ;[counts] ;[counts] ;[%]\n\n 380,173;   758,890;   761,660;   \
        762,360;    10,000\n 580,000;   758,890;   761,660;   762,360;    50,000\n";
    let found = table(avantes).unwrap();
    assert_eq!(found.names[0], "Wave [nm]");
    assert_eq!(found.names[4], "Transmittance [%]");
    let fifth = found.curve(&TableChoice { column: Some(5), row: None }).unwrap();
    assert_eq!((fifth.lambda_nm, fifth.values), (vec![380.173, 580.0], vec![0.1, 0.5]));

    let cs2000 = "CS-2000,,\nDate,2024/11/25\nLv,123.4\nx,0.3127,y,0.3290\nT,6504\nWavelength[nm],\
        Spectral radiance[W/(sr m2 nm)]\n380,1.234E-05\n381,1.3E-05\n382,1.4e-05\n";
    assert_eq!(pairs(cs2000), [(380.0, 1.234e-5), (381.0, 1.3e-5), (382.0, 1.4e-5)]);
    assert_eq!(table(cs2000).unwrap().reading.instrument, Some("Konica Minolta CS-2000"));
}

#[test]
fn samples_in_rows_are_chosen() {
    let nm: Vec<String> = (36..=74).map(|k| format!("{}nm", 10 * k)).collect();
    let row = |name: &str, from: f64| -> String {
        let values: Vec<String> =
            (0..39).map(|k| format!("{:.2}", from + f64::from(k) / 100.0)).collect();
        format!("{name},SCI,{}\n", values.join(","))
    };
    let head = format!("CM-3600d,,\nData Name,Mode,{}\n", nm.join(","));
    let one = format!("{head}{}", row("red", 0.1));
    let found = pairs(one.clone());
    assert_eq!((found.len(), found[0], found[38]), (39, (360.0, 0.1), (740.0, 0.48)));
    let two = format!("{one}{}", row("blue", 0.2));
    assert_eq!(
        message(two.clone()),
        "t.csv: 2 samples in rows, give \"row\", 1 to 2 or \"red\", \"blue\""
    );
    for row in ["2", "blue"] {
        let choice = TableChoice { column: None, row: Some(row.to_owned()) };
        assert_eq!(table(two.clone()).unwrap().curve(&choice).unwrap().values[0], 0.2);
    }
    let choice = TableChoice { column: None, row: Some("green".to_owned()) };
    let error = table(two).unwrap().curve(&choice).unwrap_err().to_string();
    assert_eq!(error, "t.csv: no row \"green\", give 1 to 2 or \"red\", \"blue\"");
    // Two lines without names, as CS-1000 files are turned.
    let turned = "380 390 400 410 420 430 440 450\n1 2 3 4 5 6 7 8\n";
    assert_eq!(pairs(turned).last(), Some(&(450.0, 8.0)));
    // Samples named by numbers, in columns.
    let columns = "nm;100;150;200;250;300;350;400;450\n380;1;2;3;4;5;6;7;8\n385;1;2;3;4;5;6;7;8\n";
    let rows: String = (0..9).map(|k| format!("{};1;2;3;4;5;6;7;8\n", 390 + 5 * k)).collect();
    assert_eq!(pairs(format!("{columns}{rows}"))[0], (380.0, 1.0));
}

#[test]
fn units_are_converted_by_the_header_or_refused() {
    for text in [
        "wavelength (um),R\n0.38,0.1\n0.78,0.9\n",
        "Wavelength [µm]\tR\n0.38\t0.1\n0.78\t0.9\n",
        "lambda/Å;R\n3800;0,1\n7800;0,9\n",
        "# wavelength (Angstrom), value\n3800,0.1\n7800,0.9\n",
    ] {
        let found = pairs(text);
        assert!((found[0].0 - 380.0).abs() < 1e-9 && (found[1].0 - 780.0).abs() < 1e-9, "{text}");
    }
    let found = pairs("wavenumber (cm-1),T\n12500,0.9\n25000,0.1\n");
    assert!(
        (found[0].0 - 400.0).abs() < 1e-9 && found[0].1 == 0.1 && (found[1].0 - 800.0).abs() < 1e-9
    );
    for (text, unit) in [
        ("0.38,0.1\n0.78,0.9\n", "µm"),
        ("3800 0.1\n7800 0.9\n", "Å"),
        ("12000;0,1\n27000;0,9\n", "cm⁻¹"),
        ("wavelength,R\n0.4,0.1\n0.7,0.9\n", "µm"),
    ] {
        let found = message(text);
        let expected =
            format!("{unit}? then say so in the header (\"wavelength ({unit})\"), or write nm");
        assert!(found.ends_with(&expected), "{found}");
    }
    assert_eq!(
        message("wavelength (nm),R\n0.38,0.1\n0.78,0.9\n"),
        "t.csv:2: wavelengths are 0.38 to 0.78 by a header that says nm: µm?"
    );
    assert!(message("wavelength (um),R\n380,0.1\n780,0.9\n").ends_with("says µm: nm?"));
    assert_eq!(pairs("nm;R [%]\n380;10\n780;90\n"), [(380.0, 0.1), (780.0, 0.9)]);
    // Infrared tables are no mistake.
    assert_eq!(pairs("900,0.1\n1700,0.9\n")[0].0, 900.0);
    assert_eq!(pairs("250,0.1\n2500,0.9\n")[1].0, 2500.0);
}

#[test]
fn descending_is_turned_and_doubles_are_refused() {
    let found = curve("780,0.9\n580,0.5\n380,0.1\n").unwrap();
    assert_eq!((found.lambda_nm, found.values), (vec![380.0, 580.0, 780.0], vec![0.1, 0.5, 0.9]));
    assert_eq!(found.notes, ["wavelengths descend: turned"]);
    assert_eq!(
        message("380,0.1\n385,0.2\n385,0.3\n"),
        "t.csv:3: wavelength 385 nm is twice there, see line 2"
    );
    assert_eq!(
        message("390,0.1\n385,0.2\n385,0.3\n"),
        "t.csv:3: wavelength 385 nm is twice there, see line 2"
    );
    assert_eq!(
        message("380,0.1\n390,0.2\n385,0.3\n395,0.4\n"),
        "t.csv:3: wavelength 385 nm beside 390 nm, neither ascending nor descending"
    );
}

#[test]
fn what_is_no_row_is_refused_with_its_line() {
    for (text, expected) in [
        ("these are\nonly words\n", "t.csv: no rows, expected wavelength in nm and value"),
        ("", "t.csv: no rows, expected wavelength in nm and value"),
        ("380,0.1\n580,\n780,0.9\n", "t.csv:2: column 2 is \"\", expected a number"),
        ("380,0.1\n580,--\n780,0.9\n", "t.csv:2: column 2 is \"--\", expected a number"),
        ("380,0.1\n580,0.5\n780,n/a\n", "t.csv:3: column 2 is \"n/a\", expected a number"),
        ("380,0.1\n580,#N/A\n780,0.9\n", "t.csv:2: column 2 is \"\", expected a number"),
        (
            "380,0.1\nhere is a word\n780,0.9\n785,0.9\n",
            "t.csv:2: has 1 columns, the other rows have 2 (\"here is a word\")",
        ),
        (
            "380,NaN\n780,0.9\n",
            "t.csv:1: value at 380 nm is NaN, allowed: finite numbers up to 1e32",
        ),
        ("0,1\n780,0.9\n", "t.csv:1: wavelength is 0, allowed: finite and above 0 nm"),
        ("a\u{0}b\n", "t.csv:1: a control character: the file is no text"),
        ("\u{1f}\u{8b}", "t.csv:1: a control character: the file is no text"),
    ] {
        assert_eq!(message(text), expected, "{text}");
    }
    let error =
        table("nm,value\n380,0.1\n").unwrap().curve(&TableChoice { column: Some(3), row: None });
    assert_eq!(error.unwrap_err().to_string(), "t.csv:2: no column 3, the row has 2 (\"380,0.1\")");
    assert_eq!(message(vec![0x1f, 0x8b, 8]), "t.csv: is compressed (gzip): unpack it first");
    assert_eq!(
        message("version https://git-lfs.github.com/spec/v1\noid sha256:1\nsize 1\n"),
        "t.csv: is a pointer of Git LFS, not the file: run \"git lfs pull\" first"
    );
}

#[test]
fn cgats_spectra_are_read() {
    let sp = "SPECT   \n\nDESCRIPTOR \"Argyll Spectral power/reflectance information\"\nORIGINATOR \
        \"Argyll CMS\"\nSPECTRAL_BANDS \"3\"\nSPECTRAL_START_NM \"380.000000\"\nSPECTRAL_END_NM \
        \"400.000000\"\nSPECTRAL_NORM \"100.000000\"\nNUMBER_OF_FIELDS 3\nBEGIN_DATA_FORMAT\nSPEC_380 \
        SPEC_390 SPEC_400\nEND_DATA_FORMAT\n\nNUMBER_OF_SETS 1\nBEGIN_DATA\n10.0 20.0 30.0\nEND_DATA\n";
    // Three bands are too few to be told as wavelengths among other names.
    let wide: Vec<String> = (0..36).map(|k| format!("SPEC_{}", 380 + 10 * k)).collect();
    let values: Vec<String> = (0..36).map(|k| format!("{}", k * 2)).collect();
    let sp = sp
        .replace("SPEC_380 SPEC_390 SPEC_400", &wide.join(" "))
        .replace("10.0 20.0 30.0", &values.join(" "))
        .replace("400.000000", "730.000000")
        .replace("\"3\"", "\"36\"");
    let found = curve(sp.clone()).unwrap();
    assert_eq!((found.lambda_nm[35], found.values[35]), (730.0, 0.7));
    assert_eq!(found.notes, ["divided by the header's SPECTRAL_NORM 100"]);
    assert_eq!(table(sp.clone()).unwrap().reading.instrument, Some("Argyll"));
    let cut = sp.replace("68 70", "68");
    assert_eq!(message(cut), "t.csv:16: has 35 cells, the format names 36 fields");
    let open = sp.replace("END_DATA\n", "");
    assert_eq!(message(open), "t.csv: the CGATS file ends without \"END_DATA\"");
}

#[test]
fn tm27_and_jcamp_are_read() {
    let spdx = "<?xml version=\"1.0\"?>\n<IESTM2714 xmlns=\"x\">\n<!-- <SpectralData wavelength=\"1\">2\
        </SpectralData> -->\n<SpectralDistribution>\n<SpectralQuantity>relative</SpectralQuantity>\n\
        <SpectralData wavelength=\"400.0\">0.034</SpectralData>\n<SpectralData wavelength = '403.1'>0.037\
        </SpectralData></SpectralDistribution></IESTM2714>\n";
    assert_eq!(pairs(spdx), [(400.0, 0.034), (403.1, 0.037)]);
    assert_eq!(table(spdx).unwrap().reading.notes, ["spectral quantity: relative"]);
    let bad = spdx.replace("0.034", "much");
    assert_eq!(
        message(bad),
        "t.csv:6: <SpectralData wavelength=\"400.0\">much: expected <SpectralData wavelength=\"nm\">value"
    );
    assert_eq!(
        message("<html></html>"),
        "t.csv: XML without \"SpectralData\" elements, as IES TM-27 has them"
    );
    let jcamp = "##TITLE= lens\n##JCAMP-DX= 4.24\n##DATA TYPE= UV/VIS SPECTRUM\n##XUNITS= MICROMETERS\n\
        ##YUNITS= TRANSMITTANCE\n##FIRSTX= 0.38\n##LASTX= 0.78\n##DELTAX= 0.1\n##NPOINTS= 5\n##XFACTOR= 1\n\
        ##YFACTOR= 0.01\n##XYDATA= (X++(Y..Y))\n0.38 10 20 30\n0.68 40 50\n##END=\n";
    let found = pairs(jcamp);
    assert_eq!((found.len(), found[0].1, found[4].1), (5, 0.1, 0.5));
    assert!((found[0].0 - 380.0).abs() < 1e-9 && (found[4].0 - 780.0).abs() < 1e-9);
}

#[test]
fn scatter_is_taken_in_the_plane_of_incidence() {
    let zemax = "# Data Generated\nSource  Measured\nSymmetry  PlaneSymmetrical\nSpectralContent  \
        Monochrome\nScatterType  BRDF\nSampleRotation  1\n0\nAngleOfIncidence  2\n15\t45\n\
        ScatterAzimuth 3\n0 90 180\nScatterRadial 3\n0 5 10\n\nMonochrome\nDataBegin\nTIS 0.13\n\
        9 5 1\n9 8 7\n9 6 2\nTIS 0.2\n90 50 10\n90 80 70\n90 60 20\nDataEnd\n";
    let found = table(zemax).unwrap();
    let first = [(-10.0, 1.0), (-5.0, 5.0), (0.0, 9.0), (5.0, 6.0), (10.0, 2.0)];
    assert_eq!(
        found.scatter(None).unwrap(),
        Scatter { incidence_deg: 15.0, points: first.to_vec() }
    );
    assert_eq!(found.scatter(Some(50.0)).unwrap().points[2], (0.0, 90.0));
    assert_eq!(found.scatter_kind(), Some(ScatterKind::Reflected));
    let cut = zemax.replace("9 8 7", "9 8");
    assert_eq!(message(cut), "t.csv:19: 2 values, ScatterRadial has 3");

    let astm = "ASTM E1392-96(2002)\nSAMPLE paint\nNUM_POINTS 4\nVARS theta_i,phi_i,theta_s,phi_s,R,G,B\n\
        45,0,40,180,1,2,3\n45,0,45,180,4,9,6\n45,0,50,180,1,3,3\n45,0,45,90,7,7,7\n";
    let found = table(astm).unwrap().scatter(None).unwrap();
    assert_eq!(found.points, [(-5.0, 2.0), (0.0, 9.0), (5.0, 3.0)]);
    let radians = astm.replace("45,", "0.785398163,").replace(",40,", ",0.698131701,");
    let radians = radians
        .replace(",50,", ",0.872664626,")
        .replace("180", "3.14159265")
        .replace(",90,", ",1.57,");
    let found = table(radians).unwrap().scatter(None).unwrap();
    assert!(found.points.len() == 3 && (found.points[0].0 + 5.0).abs() < 1e-6, "{found:?}");
}

/// Any cut and any changed byte of the files above is read or refused, and never worse.
#[test]
fn mutated_files_neither_panic_nor_hang() {
    let seeds: [&[u8]; 6] = [
        b"nm;R [%]\n380;10,5\n385;20,5\n390;30\n>>>End<<<\n",
        b"BEGIN_DATA_FORMAT\nA SPEC_400\nEND_DATA_FORMAT\nBEGIN_DATA\n1 2\nEND_DATA\n",
        b"##FIRSTX=400\n##LASTX=405\n##NPOINTS=6\n##XYDATA=(X++(Y..Y))\n400A0JJT\n402A2JJJs\n##END=\n",
        b"<SpectralData wavelength=\"400\">1</SpectralData><!-- x --><a>",
        b"Source M\nSymmetry P\nSpectralContent M\nScatterType B\nSampleRotation 1\n0\nAngleOfIncidence 1\n1\nScatterAzimuth 1\n0\nScatterRadial 2\n0 1\nMonochrome\nDataBegin\nTIS 1\n1 2\nDataEnd\n",
        b"VARS theta_i,phi_i,theta_s,phi_s,R\n45,0,40,180,1\n",
    ];
    let seeds = seeds.map(<[u8]>::to_vec);
    for bytes in mutation::broken(&seeds, 30_000, b",;\t \n.-E\"9#<%S") {
        if let Ok(table) = table(bytes) {
            let _ =
                (table.curve(&TableChoice::default()), table.scatter(None), table.reading.lines());
        }
    }
}
