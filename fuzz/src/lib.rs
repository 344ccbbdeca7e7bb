//! Readers of files under fuzzing: `cargo +nightly fuzz run tm25`.
//!
//! Formats are told apart by content, so that each target puts its format's mark in front.

use std::path::Path;

use lampyris::columns::{TableChoice, Table};
use lampyris::display;
use lampyris::geometry::import::{self, MeshReading};
use lampyris::output;
use lampyris::source::{photometric, rayfile};

pub fn read(bytes: &[u8]) {
    // A refusal is as good as a file; a panic is what is looked for.
    let _ = rayfile::read_from(Path::new("fuzz"), &mut &bytes[..], bytes.len() as u64);
}

pub fn read_after(mark: &[u8], data: &[u8]) {
    read(&[mark, data].concat());
}

/// The fields of a TM-25 header end at 288, the tables begin at 36288: the descriptions between
/// them would only hide the rest from the fuzzer.
pub fn read_tm25(data: &[u8]) {
    const FIELDS: usize = 288;
    const HEADER: usize = 36_288;
    let (fields, rest) = data.split_at(data.len().min(FIELDS - 4));
    let mut bytes = [b"TM25", fields].concat();
    bytes.resize(HEADER, 0);
    bytes.extend(rest);
    read(&bytes);
}

/// A mesh that begins with `mark`.
pub fn read_mesh(mark: &[u8], data: &[u8]) {
    let _ = import::from_bytes(Path::new("fuzz"), [mark, data].concat(), &MeshReading::default());
}

/// A binary STL file whose header fits its length.
pub fn read_stl(data: &[u8]) {
    let records = data.len() / 50;
    let bytes = [&[0; 80], (records as u32).to_le_bytes().as_slice(), &data[..50 * records]].concat();
    read_mesh(&bytes, &[]);
}

/// Tables of every kind, and what is taken from them.
pub fn read_columns(data: &[u8]) {
    if let Ok(table) = Table::from_bytes(Path::new("fuzz"), data.to_vec()) {
        let _ = (table.curve(&TableChoice::default()), table.scatter(None), table.reading.lines());
    }
}

/// A photometric file, and a few rays of it.
pub fn read_photometric(bytes: &[u8]) {
    if let Ok(file) = photometric::from_bytes(Path::new("fuzz"), bytes.to_vec()) {
        let _ = file.rays(photometric::FarField { radius_mm: 1.0, samples: 4, seed: 1 });
    }
}

/// A profile has its mark at byte 36.
pub fn read_profile(data: &[u8]) {
    let mut bytes = data.to_vec();
    bytes.resize(bytes.len().max(128), 0);
    bytes[36..40].copy_from_slice(b"acsp");
    let _ = display::display_from_profile(Path::new("fuzz"), &bytes, None);
}

/// What stands before the numbers of an EULUMDAT file.
pub const LDT_START: &[u8] = b"maker\n1\n0\n";

/// How pictures begin.
const PICTURES: [&[u8]; 6] = [
    b"\x89PNG\r\n\x1a\n",
    &[0xff, 0xd8, 0xff],
    b"II*\0",
    b"MM\0*",
    b"#?RADIANCE\n",
    &[0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0],
];

/// A picture of the kind that the first byte names. Its readers take files.
pub fn read_picture(data: &[u8]) {
    let [kind, data @ ..] = data else { return };
    let name = format!("lampyris-fuzz-{}", std::process::id());
    let path = std::env::temp_dir().join(name);
    if std::fs::write(&path, [PICTURES[usize::from(*kind) % PICTURES.len()], data].concat()).is_err() {
        return;
    }
    let _ = (output::declared_size(&path), output::read_color_picture(&path), output::read_exr(&path));
}
