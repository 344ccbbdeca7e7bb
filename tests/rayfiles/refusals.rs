//! What is broken is refused with its place.

use crate::seeds::{self, LightTools, THREE, Tm25, Zemax, message, read};

#[test]
fn flawed_records_are_named() {
    let rows = |column: usize, value: f32| {
        let mut rows: Vec<Vec<f32>> = THREE.iter().map(|r| r[..7].to_vec()).collect();
        rows[1][column] = value;
        Tm25 { rows, ..Tm25::default() }.bytes()
    };
    assert_eq!(
        message(&rows(0, f32::NAN)),
        "rays: record 2: start point has a coordinate NaN, allowed: finite mm"
    );
    assert_eq!(
        message(&rows(5, 0.0)),
        "rays: record 2: direction is (0, 0.6, 0), allowed: unit length within 1 %"
    );
    assert_eq!(
        message(&rows(6, -1.0)),
        "rays: record 2: flux is -1, allowed: finite and not negative"
    );
    assert_eq!(
        message(&rows(6, f32::INFINITY)),
        "rays: record 2: flux is inf, allowed: finite and not negative"
    );
    let text = seeds::seven_columns().replace("0.0045", "nan");
    assert_eq!(message(text.as_bytes()), "rays:3: flux is NaN, allowed: finite and not negative");
    let mut zemax = Zemax::spectral();
    zemax.rows[2][7] = 0.0;
    assert_eq!(
        message(&zemax.bytes()),
        "rays: record 3: wavelength is 0 nm, allowed: finite and above 0"
    );
}

/// The first flaw counts, also far into a file and in other chunks.
#[test]
fn the_first_of_many_flaws_is_named() {
    let mut rows = vec![vec![0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0]; 200_000];
    // More than the one in a thousand that may be left out.
    for record in [123_456].into_iter().chain(190_000..190_300) {
        rows[record - 1][6] = -1.0;
    }
    let text: String = rows.iter().map(|r| format!("{},0,0,0,0,1,{}\n", r[0], r[6])).collect();
    let bytes = Tm25 { rows, ..Tm25::default() }.bytes();
    assert!(message(&bytes).starts_with("rays: record 123456: flux is -1"));
    let csv = format!("x,y,z,dx,dy,dz,flux\n{text}");
    assert!(message(csv.as_bytes()).starts_with("rays:123457: flux is -1"));
}

#[test]
fn counts_that_disagree_with_the_size() {
    let mut bytes = Tm25::default().bytes();
    bytes[20] = 4;
    assert_eq!(
        message(&bytes),
        "rays: 4 rays of 28 bytes do not fit the 84 bytes after the header"
    );
    bytes[20..28].fill(255);
    assert!(message(&bytes).contains("18446744073709551615 rays"));
    let mut bytes = Zemax::flux_only(0).bytes();
    bytes.push(0);
    assert!(message(&bytes).contains("do not fit the 85 bytes"));
    let text = seeds::zemax_text().replacen('3', "5", 1);
    assert_eq!(message(text.as_bytes()), "rays: the first line promises 5 rays, the file holds 3");
}

/// Every file of every format, cut at every byte, is refused; text without an end mark only where
/// a line is cut.
#[test]
fn truncated_files_are_refused() {
    for bytes in seeds::all() {
        let is_free_text = bytes.starts_with(b"X_Pos") || bytes.starts_with(b"# three");
        let first = if is_free_text { 0 } else { bytes.len().saturating_sub(600) };
        for end in first..bytes.len() {
            let cut = read(&bytes[..end]);
            // A number without its last digits is a number, and a missing row is not missed.
            let last_line = bytes[..end].rsplit(|&b| b == b'\n').next().unwrap_or_default();
            let cells = last_line.split(|b| b", ".contains(b)).filter(|c| !c.is_empty()).count();
            let may_pass = is_free_text && (cells == 0 || cells == 7);
            // Zemax text ends without a mark: its last number may lose digits.
            let may_lose_digits = bytes.starts_with(b"3\t4") && end + 5 > bytes.len();
            assert!(cut.is_err() || may_pass || may_lose_digits, "{end} of {} bytes", bytes.len());
        }
    }
}

#[test]
fn headers_out_of_range() {
    let mut bytes = Zemax::flux_only(0).bytes();
    bytes[136] = 5;
    assert_eq!(message(&bytes), "rays: length unit 5, allowed: 0 to 4");
    let bytes = LightTools { major: 4, ..LightTools::spectral() }.bytes();
    assert_eq!(message(&bytes), "rays: LightTools version 4, allowed: 2 and 3");
    let bytes = Tm25 { spectral_id: 5, ..Tm25::default() }.bytes();
    assert_eq!(message(&bytes), "rays: spectral identifier 5, allowed: 0 to 4");
    let bytes = Tm25 { flags: [1, 1, 0, 0, 0, 0, 0, 0], ..Tm25::default() }.bytes();
    assert_eq!(message(&bytes), "rays: the rays have no flux, neither radiant nor luminous");
    let tables = vec![vec![[500.0, 1.0], [400.0, 1.0]]];
    let bytes = Tm25 { spectral_id: 3, tables, ..Tm25::default() }.bytes();
    assert!(message(&bytes).contains("spectral table 1: wavelength 400 nm follows 500 nm"));
    let ascii = seeds::lighttools_ascii().replace("millimeters", "cubits");
    assert_eq!(
        message(ascii.as_bytes()),
        "rays:7: \"lt_length_units\" is \"cubits\", which is not known"
    );
    let ascii = seeds::lighttools_ascii().replace("lt_endofdata", "");
    assert_eq!(message(ascii.as_bytes()), "rays:14: the file ends without \"lt_endofdata\"");
}

#[test]
fn sets_without_rays_or_light() {
    assert_eq!(
        message(&Tm25 { rows: Vec::new(), ..Tm25::default() }.bytes()),
        "rays: the file holds no rays"
    );
    let mut dark = Tm25::default();
    dark.rows.iter_mut().for_each(|row| row[6] = 0.0);
    assert_eq!(message(&dark.bytes()), "rays: no ray carries flux");
    let mut infrared = Zemax::spectral();
    infrared.rows.iter_mut().for_each(|row| row[7] = 0.9);
    assert_eq!(message(&infrared.bytes()), "rays: the rays make no light between 380 and 780 nm");
}

#[test]
fn other_files_are_no_ray_files() {
    let other: [&[u8]; 5] = [b"", b"\n\n", b"v 0 0 0\nf 1 2 3\n", b"1 2 3 4 5 6\n", &[0; 5000]];
    for bytes in other {
        assert!(message(bytes).starts_with("rays: not a ray file of a known format"));
    }
}

#[test]
fn rows_that_are_no_rows() {
    let csv = |row: &str| format!("x,y,z,dx,dy,dz,flux\n0,0,0,0,0,1,1\n\n{row}\n");
    assert_eq!(message(csv("1,2,3").as_bytes()), "rays:4: a row of 3 numbers, expected 7");
    assert_eq!(
        message(csv("0,0,0,0,,1,1").as_bytes()),
        "rays:4: column 5 is \"\", expected a number"
    );
    assert_eq!(
        message(csv("0,0,1e39,0,0,1,1").as_bytes()),
        "rays:4: start point has a coordinate inf, allowed: finite mm"
    );
    let long = vec![b'1'; 200_000];
    let bytes = [b"x,y,z,dx,dy,dz,flux\n", &long[..]].concat();
    assert!(read(&bytes).is_err());
}
