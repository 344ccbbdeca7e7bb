//! Ray files built byte by byte from the published layouts.

use std::path::Path;

use lampyris::Result;
use lampyris::source::rayfile::{self, RayFile};

/// x y z (mm), direction, W, nm.
pub type Row = [f32; 8];

pub const THREE: [Row; 3] = [
    [-0.625, -0.375, 0.125, -0.8, 0.0, 0.6, 0.003, 550.0],
    [0.75, 0.875, 0.125, 0.0, 0.6, 0.8, 0.0045, 450.0],
    [0.1875, -0.6875, 0.125, 0.28, -0.96, 0.0, 0.0015, 620.0],
];

pub fn read(bytes: &[u8]) -> Result<RayFile> {
    rayfile::read_from(Path::new("rays"), &mut &bytes[..], bytes.len() as u64)
}

pub fn message(bytes: &[u8]) -> String {
    read(bytes).map(|_| ()).expect_err("refused").to_string()
}

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

fn put(bytes: &mut [u8], at: usize, field: &[u8]) {
    bytes[at..at + field.len()].copy_from_slice(field);
}

/// A TM-25 file; columns are what the rows hold.
#[derive(Clone)]
pub struct Tm25 {
    pub luminous: f32,
    pub radiant: f32,
    pub spectral_id: i32,
    pub wavelength: f32,
    pub flags: [i32; 8],
    pub tables: Vec<Vec<[f32; 2]>>,
    pub additional: usize,
    pub text_bytes: usize,
    pub rows: Vec<Vec<f32>>,
}

impl Default for Tm25 {
    /// Luminous flux alone, no spectrum, the header's flux unknown.
    fn default() -> Self {
        Self {
            luminous: f32::NAN,
            radiant: f32::NAN,
            spectral_id: 0,
            wavelength: f32::NAN,
            flags: [1, 1, 0, 0, 1, 0, 0, 0],
            tables: Vec::new(),
            additional: 0,
            text_bytes: 0,
            rows: THREE.iter().map(|r| r[..7].to_vec()).collect(),
        }
    }
}

impl Tm25 {
    pub fn bytes(&self) -> Vec<u8> {
        let mut bytes = vec![0; 36_288];
        put(&mut bytes, 0, b"TM25");
        put(&mut bytes, 4, &2013i32.to_le_bytes());
        put(&mut bytes, 12, &self.luminous.to_le_bytes());
        put(&mut bytes, 16, &self.radiant.to_le_bytes());
        put(&mut bytes, 20, &(self.rows.len() as u64).to_le_bytes());
        put(&mut bytes, 60, &self.spectral_id.to_le_bytes());
        put(&mut bytes, 64, &self.wavelength.to_le_bytes());
        put(&mut bytes, 76, &(self.tables.len() as i32).to_le_bytes());
        put(&mut bytes, 80, &(self.additional as i32).to_le_bytes());
        put(&mut bytes, 84, &(self.text_bytes as i32).to_le_bytes());
        for (i, flag) in self.flags.iter().enumerate() {
            put(&mut bytes, 256 + 4 * i, &flag.to_le_bytes());
        }
        for table in &self.tables {
            bytes.extend((table.len() as i32).to_le_bytes());
            bytes.extend(floats(table.as_flattened()));
        }
        bytes.resize(36_288 + (bytes.len() - 36_288).next_multiple_of(32), 0);
        bytes.resize(bytes.len() + 512 * self.additional + self.text_bytes, 0);
        bytes.extend(self.rows.iter().flat_map(|row| floats(row)));
        bytes
    }
}

/// A Zemax binary source.
#[derive(Clone)]
pub struct Zemax {
    pub length_unit: u32,
    pub ray_format: i32,
    pub flux_type: i32,
    pub flux: f32,
    pub rows: Vec<Vec<f32>>,
}

impl Zemax {
    pub fn flux_only(flux_type: i32) -> Self {
        let rows = THREE.iter().map(|r| r[..7].to_vec()).collect();
        Self { length_unit: 4, ray_format: 0, flux_type, flux: 0.0, rows }
    }

    /// Wavelengths in µm.
    pub fn spectral() -> Self {
        let row = |r: &Row| [&r[..7], &[r[7] / 1000.0]].concat();
        Self { ray_format: 2, rows: THREE.iter().map(row).collect(), ..Self::flux_only(0) }
    }

    pub fn bytes(&self) -> Vec<u8> {
        let mut bytes = vec![0; 208];
        put(&mut bytes, 0, &1010i32.to_le_bytes());
        put(&mut bytes, 4, &(self.rows.len() as u32).to_le_bytes());
        put(&mut bytes, 8, b"three rays");
        put(&mut bytes, 108, &self.flux.to_le_bytes());
        put(&mut bytes, 112, &self.flux.to_le_bytes());
        put(&mut bytes, 136, &self.length_unit.to_le_bytes());
        put(&mut bytes, 192, &self.ray_format.to_le_bytes());
        put(&mut bytes, 196, &self.flux_type.to_le_bytes());
        bytes.extend(self.rows.iter().flat_map(|row| floats(row)));
        bytes
    }
}

/// A LightTools binary file.
#[derive(Clone)]
pub struct LightTools {
    pub major: u32,
    pub data_type: u32,
    pub far_field: u32,
    pub color: u32,
    pub length_unit: u32,
    pub flux: f32,
    pub rows: Vec<Vec<f32>>,
}

impl LightTools {
    pub fn spectral() -> Self {
        Self {
            major: 2,
            data_type: 0,
            far_field: 0,
            color: 2,
            length_unit: 1,
            flux: 0.0,
            rows: THREE.iter().map(|r| r.to_vec()).collect(),
        }
    }

    pub fn flux_only(data_type: u32) -> Self {
        let rows = THREE.iter().map(|r| r[..7].to_vec()).collect();
        Self { data_type, color: 0, rows, ..Self::spectral() }
    }

    pub fn bytes(&self) -> Vec<u8> {
        let mut bytes = b"LTRF".to_vec();
        let words =
            [self.major, 0, self.data_type, self.far_field, self.color, self.length_unit, 0, 0, 0];
        bytes.extend(words.iter().flat_map(|word| word.to_le_bytes()));
        bytes.extend(self.flux.to_le_bytes());
        if self.major == 3 {
            bytes.extend(0u32.to_le_bytes());
        }
        bytes.extend(self.rows.iter().flat_map(|row| floats(row)));
        bytes.extend(b"LTRFEND");
        bytes
    }
}

fn row_text(row: &[f32], separator: &str) -> String {
    row.iter().map(|v| v.to_string()).collect::<Vec<_>>().join(separator)
}

pub fn lighttools_ascii() -> String {
    let rows: String = THREE.iter().map(|r| format!("  {}\r\n", row_text(r, "  "))).collect();
    format!(
        "# a comment\r\nlt_rdf_version: 2.0\r\ndataname: three\r\nlt_datatype: radiant_power\r\n\
         lt_far_field_data: no\r\nlt_color_info: wavelength\r\nlt_length_units: millimeters\r\n\
         lt_data_origin: 0 0 0\r\nlt_radiant_flux: 0\r\nlt_startofdata\r\n{rows}lt_endofdata"
    )
}

pub fn zemax_text() -> String {
    let row = |r: &Row| format!("{}\t{}\n", row_text(&r[..7], "\t"), r[7] / 1000.0);
    format!("3\t4\t0\t0\t0\t0\t0\t0\n{}", THREE.iter().map(row).collect::<String>())
}

pub fn seven_columns() -> String {
    let rows: String = THREE.iter().map(|r| row_text(&r[..7], " ") + "\n").collect();
    format!("X_Pos Y_Pos Z_Pos X_Vec Y_Vec Z_Vec Flux\n{rows}")
}

pub fn csv() -> String {
    let rows: String = THREE.iter().map(|r| row_text(&r[..7], ",") + "\n").collect();
    format!("# three rays\nx,y,z,dx,dy,dz,flux\n{rows}")
}

/// An ASAP file in either byte order.
pub fn asap(word: fn(u32) -> [u8; 4]) -> Vec<u8> {
    let mut bytes = vec![0; 140];
    put(&mut bytes, 0, &word(247 + 256 * 4 * 7));
    put(&mut bytes, 28, b"three rays              ");
    put(&mut bytes, 68, b"XYZABCF MM      ");
    put(&mut bytes, 108, &word((-3i32).cast_unsigned()));
    bytes.extend(THREE.iter().flat_map(|r| r[..7].iter().flat_map(|v| word(v.to_bits()))));
    bytes
}

/// One file of every kind.
pub fn all() -> Vec<Vec<u8>> {
    let table = vec![[400.0, 0.0], [550.0, 1.0], [700.0, 0.5]];
    let indexed = |r: &Row| [&r[..7], &[2.0]].concat();
    vec![
        Tm25::default().bytes(),
        Tm25 {
            spectral_id: 4,
            flags: [1, 1, 1, 0, 0, 0, 0, 1],
            tables: vec![vec![[450.0, 1.0]], table.clone()],
            rows: THREE.iter().map(indexed).collect(),
            ..Tm25::default()
        }
        .bytes(),
        Tm25 {
            spectral_id: 3,
            tables: vec![table],
            additional: 1,
            text_bytes: 32,
            rows: THREE.iter().map(indexed).collect(),
            ..Tm25::default()
        }
        .bytes(),
        Zemax::flux_only(1).bytes(),
        Zemax::spectral().bytes(),
        LightTools::spectral().bytes(),
        LightTools { major: 3, ..LightTools::flux_only(1) }.bytes(),
        lighttools_ascii().into_bytes(),
        zemax_text().into_bytes(),
        seven_columns().into_bytes(),
        csv().into_bytes(),
        asap(u32::to_le_bytes),
        asap(u32::to_be_bytes),
    ]
}

/// A Speos file: W, five words, lm, then x y z l m n nm W.
pub fn speos(watts: f32, lumens: f32, rows: &[Row]) -> Vec<u8> {
    let mut bytes = floats(&[watts, 1.0, 0.0, 0.0, 0.0, 2.0, lumens]);
    for [x, y, z, l, m, n, flux, nm] in rows {
        bytes.extend(floats(&[*x, *y, *z, *l, *m, *n, *nm, *flux]));
    }
    bytes
}

/// Rows under names, cells parted by `separator` with `mark` before decimals.
pub fn named(header: &str, separator: &str, mark: &str, rows: &[Row]) -> String {
    let row = |row: &Row| {
        let cells: Vec<String> =
            row.iter().map(|cell| cell.to_string().replace('.', mark)).collect();
        cells.join(separator) + "\r\n"
    };
    format!("{header}\r\n{}", rows.iter().map(row).collect::<String>())
}
