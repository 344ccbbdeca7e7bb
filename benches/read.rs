//! Files read from memory: MB/s for 10⁶ rays and 10⁵ rows of a spectrum. `cargo bench --bench read`.
//!
//! The disk's own rate is that of reading the same bytes from a file, right after they were written.

use std::io::Write;
use std::path::Path;
use std::time::Instant;

use lampyris::columns::{Table, TableChoice};
use lampyris::source::rayfile;

const RAYS: usize = 1_000_000;
const ROWS: usize = 100_000;
const REPEATS: usize = 5;

fn main() {
    println!("| file | MB | MB/s read | MB/s of the disk's cache |\n|---|---|---|---|");
    let rays = |bytes: &[u8]| {
        let file = rayfile::read_from(Path::new("rays"), &mut &bytes[..], bytes.len() as u64);
        assert_eq!(file.expect("rays").samples.len(), RAYS);
    };
    report("10⁶ rays, Zemax binary", &zemax(), rays);
    report("10⁶ rays, Speos", &speos(), rays);
    report("10⁶ rays, CSV", csv().as_bytes(), rays);
    report("10⁶ rays, CSV with wavelengths and decimal commas", german().as_bytes(), rays);
    let spectrum = |bytes: &[u8]| {
        let table = Table::from_bytes(Path::new("spectrum"), bytes.to_vec()).expect("a table");
        assert_eq!(table.curve(&TableChoice::default()).expect("a spectrum").values.len(), ROWS);
    };
    report("10⁵ rows of a spectrum, commas", table(",", ".").as_bytes(), spectrum);
    report(
        "10⁵ rows of a spectrum, semicolons and decimal commas",
        table(";", ",").as_bytes(),
        spectrum,
    );
}

/// The best of some runs.
fn report(name: &str, bytes: &[u8], read: impl Fn(&[u8])) {
    let megabytes = bytes.len() as f64 / 1e6;
    let seconds = best(|| read(bytes));
    let mut path = std::env::temp_dir();
    path.push("lampyris_read_bench");
    std::fs::File::create(&path).and_then(|mut file| file.write_all(bytes)).expect("a file");
    let disk = best(|| assert_eq!(std::fs::read(&path).expect("a file").len(), bytes.len()));
    let _ = std::fs::remove_file(&path);
    println!("| {name} | {megabytes:.0} | {:.0} | {:.0} |", megabytes / seconds, megabytes / disk);
}

fn best(run: impl Fn()) -> f64 {
    let times = (0..REPEATS).map(|_| {
        let start = Instant::now();
        run();
        start.elapsed().as_secs_f64()
    });
    times.fold(f64::INFINITY, f64::min)
}

/// Directions that turn around the axis.
fn ray(index: usize) -> [f32; 6] {
    let (sin, cos) = (index as f64 * 0.1).sin_cos();
    [cos as f32, sin as f32, 0.5, (0.6 * cos) as f32, (0.6 * sin) as f32, 0.8]
}

fn floats(values: &[f32]) -> impl Iterator<Item = u8> {
    values.iter().flat_map(|v| v.to_le_bytes())
}

fn zemax() -> Vec<u8> {
    let mut bytes = vec![0; 208];
    bytes[..4].copy_from_slice(&1010i32.to_le_bytes());
    bytes[4..8].copy_from_slice(&(RAYS as u32).to_le_bytes());
    bytes[136..140].copy_from_slice(&4u32.to_le_bytes());
    bytes[196..200].copy_from_slice(&1i32.to_le_bytes());
    (0..RAYS).for_each(|i| bytes.extend(floats(&ray(i)).chain(floats(&[1.0]))));
    bytes
}

fn speos() -> Vec<u8> {
    let mut bytes: Vec<u8> = floats(&[1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 100.0]).collect();
    (0..RAYS).for_each(|i| bytes.extend(floats(&ray(i)).chain(floats(&[550.0, 1e-6]))));
    bytes
}

fn csv() -> String {
    let row = |i: usize| {
        let [x, y, z, dx, dy, dz] = ray(i);
        format!("{x},{y},{z},{dx},{dy},{dz},1\n")
    };
    format!("x,y,z,dx,dy,dz,flux\n{}", (0..RAYS).map(row).collect::<String>())
}

fn german() -> String {
    let row = |i: usize| {
        let [x, y, z, dx, dy, dz] = ray(i);
        format!("{x};{y};{z};{dx};{dy};{dz};1;555,5\n").replace('.', ",")
    };
    let rows: String = (0..RAYS).map(row).collect();
    format!("x;y;z;dx;dy;dz;flux;wavelength\n{rows}")
}

fn table(separator: &str, mark: &str) -> String {
    let row = |i: usize| {
        let cells = [380.0 + i as f64 * 0.004, 0.5 + 0.4 * (i as f64 * 1e-3).sin()];
        cells.map(|cell| format!("{cell:.6}").replace('.', mark)).join(separator) + "\n"
    };
    (0..ROWS).map(row).collect()
}
