//! Reading meshes of a million triangles: MB/s of the wall clock and per second of CPU, beside reading
//! the bytes alone.
//!
//! `cargo bench --bench meshes [-- FOLDER]`: files are written into FOLDER (the temporary one) first.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

use lampyris::geometry::import::{self, MeshReading};

/// Cells a side: two triangles each make a million.
const CELLS: usize = 708;

/// A wavy bowl of 142 mm.
fn height(x: f64, y: f64) -> f64 {
    0.01 * (x * x + y * y) + 2.0 * (0.2 * x).sin() * (0.3 * y).cos()
}

fn place(i: usize, j: usize) -> [f64; 3] {
    let [x, y] = [i, j].map(|k| (k as f64 - CELLS as f64 / 2.0) * 0.2);
    [x, y, height(x, y)]
}

fn normal(i: usize, j: usize) -> [f64; 3] {
    let [x, y, _] = place(i, j);
    let slope = |dx: f64, dy: f64| (height(x + dx, y + dy) - height(x - dx, y - dy)) / 2e-3;
    let (a, b) = (slope(1e-3, 0.0), slope(0.0, 1e-3));
    let length = (1.0 + a * a + b * b).sqrt();
    [-a / length, -b / length, 1.0 / length]
}

/// Corners of each cell, from 0: counter-clockwise from above.
fn cells() -> impl Iterator<Item = [usize; 4]> {
    (0..CELLS * CELLS).map(|k| {
        let a = k / CELLS * (CELLS + 1) + k % CELLS;
        [a, a + 1, a + CELLS + 2, a + CELLS + 1]
    })
}

fn vertices() -> impl Iterator<Item = (usize, usize)> {
    (0..=CELLS).flat_map(|j| (0..=CELLS).map(move |i| (i, j)))
}

fn obj(has_normals: bool) -> Vec<u8> {
    let mut text = String::new();
    for (i, j) in vertices() {
        let [x, y, z] = place(i, j);
        let _ = writeln!(text, "v {x:.6} {y:.6} {z:.6}");
    }
    for (i, j) in vertices().filter(|_| has_normals) {
        let [x, y, z] = normal(i, j);
        let _ = writeln!(text, "vn {x:.4} {y:.4} {z:.4}");
    }
    for cell in cells() {
        let [a, b, c, d] = cell.map(|k| k + 1);
        let _ = if has_normals {
            writeln!(text, "f {a}//{a} {b}//{b} {c}//{c}\nf {a}//{a} {c}//{c} {d}//{d}")
        } else {
            writeln!(text, "f {a} {b} {c}\nf {a} {c} {d}")
        };
    }
    text.into_bytes()
}

fn stl() -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend((2 * (CELLS * CELLS) as u32).to_le_bytes());
    let corner =
        |k: usize| place(k % (CELLS + 1), k / (CELLS + 1)).map(|x| (x as f32).to_le_bytes());
    for [a, b, c, d] in cells() {
        for triangle in [[a, b, c], [a, c, d]] {
            bytes.extend([0; 12]);
            bytes.extend(triangle.into_iter().flat_map(corner).flatten());
            bytes.extend([0; 2]);
        }
    }
    bytes
}

fn ply() -> Vec<u8> {
    let header = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\n\
         property float y\nproperty float z\nelement face {}\n\
         property list uchar int vertex_indices\nend_header\n",
        (CELLS + 1) * (CELLS + 1),
        2 * CELLS * CELLS
    );
    let mut bytes = header.into_bytes();
    for (i, j) in vertices() {
        bytes.extend(place(i, j).into_iter().flat_map(|x| (x as f32).to_le_bytes()));
    }
    for [a, b, c, d] in cells() {
        for triangle in [[a, b, c], [a, c, d]] {
            bytes.push(3);
            bytes.extend(triangle.into_iter().flat_map(|k| (k as u32).to_le_bytes()));
        }
    }
    bytes
}

/// User and system time of this process so far, s; `None` where there is no /proc.
fn cpu_seconds() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    let fields: Vec<&str> = stat.rsplit(')').next()?.split_whitespace().collect();
    let ticks: f64 = fields.get(11)?.parse::<f64>().ok()? + fields.get(12)?.parse::<f64>().ok()?;
    Some(ticks / 100.0)
}

/// The best of five, as MB/s of the wall clock and of CPU time.
fn rates(megabytes: f64, mut work: impl FnMut()) -> [f64; 2] {
    let mut best = [0.0f64; 2];
    for _ in 0..5 {
        let (wall, cpu) = (Instant::now(), cpu_seconds());
        work();
        let cpu = cpu.zip(cpu_seconds()).map_or(f64::NAN, |(before, after)| after - before);
        best =
            [best[0].max(megabytes / wall.elapsed().as_secs_f64()), best[1].max(megabytes / cpu)];
    }
    best
}

fn measure(path: &Path, what: &str, bytes: &[u8]) {
    std::fs::write(path, bytes).expect("a folder to write into");
    let megabytes = bytes.len() as f64 / 1e6;
    let [alone, _] = rates(megabytes, || drop(std::fs::read(path)));
    let mut triangles = 0;
    let [wall, cpu] = rates(megabytes, || {
        triangles =
            import::load(path, &MeshReading::default()).expect("a mesh").mesh.triangles.len();
    });
    println!("| {what} | {triangles} | {megabytes:.1} | {alone:.0} | {wall:.0} | {cpu:.0} |");
    let _ = std::fs::remove_file(path);
}

fn main() {
    let folder = std::env::args().skip(1).find(|argument| !argument.starts_with('-'));
    let folder = folder.map_or_else(std::env::temp_dir, PathBuf::from);
    println!("| file | triangles | MB | bytes alone, MB/s | read, MB/s | MB per CPU second |");
    println!("|---|---|---|---|---|---|");
    let files: [(&str, &str, Vec<u8>); 4] = [
        ("bench.obj", "OBJ without normals", obj(false)),
        ("bench.obj", "OBJ with normals", obj(true)),
        ("bench.stl", "binary STL", stl()),
        ("bench.ply", "binary PLY", ply()),
    ];
    for (name, what, bytes) in files {
        measure(&folder.join(name), what, &bytes);
    }
}
