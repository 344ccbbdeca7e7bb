//! Mesh files that are broken in every way, and dense tables: no panic, and no more memory than the
//! file justifies.

#[path = "../common/random.rs"]
mod random;

use std::alloc::{GlobalAlloc, Layout, System};
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use lampyris::columns::{Table, TableChoice};
use lampyris::geometry::import::{self, MeshFile, MeshReading, Selection};
use random::Random;

/// The system's allocator, which notes how much is held, and the most that was.
struct Watched;

static HELD: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(0);

fn grow(size: usize) {
    MOST.fetch_max(HELD.fetch_add(size, Relaxed) + size, Relaxed);
}

// SAFETY: every call goes to the system's allocator unchanged; counting allocates nothing.
unsafe impl GlobalAlloc for Watched {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        grow(layout.size());
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        HELD.fetch_sub(layout.size(), Relaxed);
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Watched = Watched;

const OBJ: &str = "# lens\nmtllib a.mtl\no lens\ng front outer\nusemtl clear red\ns 1\n\
    v 0 0 0\nv 10 0 0 0.5 0.5 0.5\nv 10 8 0\nv 4 3 0.25\nv 0 8 0\nvt 0 0\nvn 0 0 1\n\
    f 1/1/1 2/1/1 3/1/1 \\\n 4/1/1 5/1/1\ns off\nf -5//-1 -4//-1 -3//-1\nf 1 2 3 4\nf 1 4 5\n";

const ASCII_STL: &str = "solid lens\nfacet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1e1 0 0\n\
    vertex 0 1.5 0\n endloop\nendfacet\nendsolid lens\n";

const ASCII_PLY: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
    property float z\nproperty float nx\nproperty float ny\nproperty float nz\nelement face 2\n\
    property list uchar int vertex_indices\nend_header\n0 0 0 0 0 1\n1 0 0 0 0 1\n1 1 0 0 0 1\n\
    0 1 0 0 0 1\n4 0 1 2 3\n3 0 1 2\n";

fn binary_ply() -> Vec<u8> {
    let mut bytes = ASCII_PLY.split_inclusive("end_header\n").next().unwrap_or_default().to_owned();
    bytes = bytes.replace("ascii", "binary_little_endian");
    let mut bytes = bytes.into_bytes();
    for k in 0..4 {
        let corner = [f32::from(k as u8 % 2), f32::from(k as u8 / 2), 0.0, 0.0, 0.0, 1.0];
        bytes.extend(corner.into_iter().flat_map(f32::to_le_bytes));
    }
    bytes.push(4);
    bytes.extend([0i32, 1, 3, 2].into_iter().flat_map(i32::to_le_bytes));
    bytes.push(3);
    bytes.extend([0i32, 1, 2].into_iter().flat_map(i32::to_le_bytes));
    bytes
}

fn binary_stl() -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend(3u32.to_le_bytes());
    for k in 0..3 {
        let numbers = (0..12).map(|n| ((n * 7 + k * 5) % 11) as f32);
        bytes.extend(numbers.flat_map(f32::to_le_bytes));
        bytes.extend([0; 2]);
    }
    bytes
}

fn glb() -> Vec<u8> {
    let json = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"name":"a","mesh":0,"children":[1]},{"mesh":0,"scale":[-1,1,1]}],"materials":[{"name":"red"}],"meshes":[{"primitives":[{"attributes":{"POSITION":0,"NORMAL":0},"indices":1,"material":0}]}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,1]},{"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}],"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":6}],"buffers":[{"byteLength":42}]}"#;
    let mut json = json.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut data: Vec<u8> =
        [0f32, 0., 0., 1., 0., 0., 0., 1., 0.].into_iter().flat_map(f32::to_le_bytes).collect();
    data.extend([0u16, 1, 2].into_iter().flat_map(u16::to_le_bytes));
    data.resize(data.len().next_multiple_of(4), 0);
    let word = |n: usize| (n as u32).to_le_bytes();
    let parts = [
        b"glTF".as_slice(),
        &word(2),
        &word(28 + json.len() + data.len()),
        &word(json.len()),
        b"JSON",
        &json,
        &word(data.len()),
        b"BIN\0",
        &data,
    ];
    parts.concat()
}

fn seeds() -> Vec<Vec<u8>> {
    vec![
        OBJ.into(),
        OBJ.replace('\n', "\r\n").into(),
        ASCII_STL.into(),
        ASCII_PLY.into(),
        binary_ply(),
        binary_stl(),
        glb(),
    ]
}

const WORDS: [&[u8]; 24] = [
    b"\n",
    b"\r\n",
    b" ",
    b"-",
    b"/",
    b"//",
    b"\\\n",
    b"e99",
    b"nan",
    b"#",
    b"0",
    b"-1",
    b"99999999999",
    b"f 1 2 3\n",
    b"v 1 2\n",
    b"g a\n",
    b"s 2\n",
    b"\0",
    b"\xff\xff\xff\xff",
    b"\xff\xfe",
    b"\xef\xbb\xbf",
    b"4294967295",
    b"\"",
    b"}",
];

fn mutate(bytes: &mut Vec<u8>, random: &mut Random) {
    for _ in 0..1 + random.below(4) {
        let at = random.below(bytes.len() + 1);
        let end = (at + random.below(64)).min(bytes.len());
        match random.below(6) {
            0 if at < bytes.len() => bytes[at] ^= 1 << random.below(8),
            1 if at < bytes.len() => bytes[at] = random.bits() as u8,
            2 => bytes.truncate(at),
            3 => drop(bytes.drain(at..end)),
            4 => {
                let word = WORDS[random.below(WORDS.len())];
                bytes.splice(at..at, word.iter().copied());
            }
            _ => {
                let copy = bytes[at..end].to_vec();
                bytes.splice(at..at, copy);
            }
        }
    }
}

fn read(bytes: Vec<u8>, reading: &MeshReading) -> lampyris::Result<MeshFile> {
    import::from_bytes(Path::new("mesh"), bytes, reading)
}

/// One test at a time: the counters are everybody's.
static ALONE: Mutex<()> = Mutex::new(());

/// Memory that a reader may hold besides 16 times the file: tables of fixed size.
const FIXED: usize = 1 << 20;

/// `LAMPYRIS_MUTATIONS` sets the number.
#[test]
fn broken_meshes_neither_panic_nor_ask_for_memory() {
    let _alone = ALONE.lock().unwrap_or_else(|e| e.into_inner());
    let count = std::env::var("LAMPYRIS_MUTATIONS").ok().and_then(|n| n.parse().ok());
    let count: u64 = count.unwrap_or(20_000);
    let seeds = seeds();
    let welded = MeshReading { weld_mm: 0.5, ..MeshReading::default() };
    let selection = Selection { object: Some(b"lens".to_vec()), ..Selection::default() };
    let part = MeshReading { selection, ..MeshReading::default() };
    let readings = [MeshReading::default(), welded, part];
    let mut accepted = 0;
    for case in 0..count {
        let mut random = Random(case);
        let mut bytes = seeds[random.below(seeds.len())].clone();
        mutate(&mut bytes, &mut random);
        let length = bytes.len();
        let before = HELD.load(Relaxed);
        MOST.store(before, Relaxed);
        let file = read(bytes, &readings[random.below(readings.len())]);
        let most = MOST.load(Relaxed) - before;
        assert!(most <= 16 * length + FIXED, "case {case}: {most} bytes for {length}");
        if let Ok(MeshFile { mesh, .. }) = file {
            accepted += 1;
            let count = mesh.positions.len() as u32;
            assert!(
                mesh.triangles.as_flattened().iter().all(|&corner| corner < count),
                "case {case}"
            );
            assert!(mesh.positions.iter().all(|p| p.is_finite()), "case {case}");
        }
    }
    assert!(accepted > count / 20, "{accepted} of {count}");
    println!("{accepted} of {count} mutated meshes were read, the others refused");
}

/// The densest lines of each kind, a megabyte of them: memory stays below 16 times the file.
#[test]
fn dense_files_stay_within_sixteen_times_their_size() {
    let _alone = ALONE.lock().unwrap_or_else(|e| e.into_inner());
    let lines = |start: &str, line: &str| start.to_owned() + &line.repeat((1 << 20) / line.len());
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let distinct =
        (0..100_000).map(|k| format!("v {} {} 0\n", k % 317, k / 317)).collect::<String>();
    for text in [
        lines(triangle, "f 1 2 3\n"),
        lines(triangle, "f 1//1 2//1 3//1\n"),
        lines(triangle, "g a\nf 1 2 3\n"),
        lines(triangle, "s 1\nf 1 2 3\n"),
        lines("f 1 2 3\n", "v 0 0 0\nv 1 0 0\nv 0 1 0\n"),
        lines(triangle, "v 1 2 3\nf -1 1 2\n"),
        distinct.clone() + &lines("", "f 1 2 400\n"),
        distinct + "f 1 2 400 399",
    ] {
        let length = text.len();
        let bytes = text.into_bytes();
        let before = HELD.load(Relaxed) - length;
        MOST.store(before, Relaxed);
        let file = read(bytes, &MeshReading::default());
        let most = MOST.load(Relaxed) - before;
        assert!(file.is_ok() || length < 100);
        assert!(
            most <= 16 * length + FIXED,
            "{most} bytes for {length}: {:.1}",
            most as f64 / length as f64
        );
    }
}

/// A megabyte of short rows: memory stays below 16 times the file.
#[test]
fn dense_tables_stay_within_sixteen_times_their_size() {
    let _alone = ALONE.lock().unwrap_or_else(|e| e.into_inner());
    let rows = |start: &str, row: &dyn Fn(usize) -> String| -> Vec<u8> {
        let rows: String = (0..).map(row).take(100_000).collect();
        format!("{start}{rows}").into_bytes()
    };
    let utf16: Vec<u8> = rows("\u{feff}", &|_| "1 1\n".to_owned())
        .utf8_chunks()
        .flat_map(|chunk| chunk.valid().encode_utf16().flat_map(u16::to_le_bytes))
        .collect();
    let packed = "##FIRSTX=400\n##LASTX=700\n##NPOINTS=99999999\n##XYDATA=(X++(Y..Y))\n400A0s99999999\n##END=\n";
    for bytes in [
        rows("", &|_| "1 1\n".to_owned()),
        rows("", &|at| format!("{:.3} 1\n", 400.0 + at as f64 * 1e-3)),
        rows("nm;%\n", &|at| format!("{:.3};1\n", 400.0 + at as f64 * 1e-3).replace('.', ",")),
        rows("", &|_| "1,1,1,1,1,1,1,1\n".to_owned()),
        utf16,
        packed.as_bytes().to_vec(),
    ] {
        let length = bytes.len();
        let before = HELD.load(Relaxed) - length;
        MOST.store(before, Relaxed);
        let table = Table::from_bytes(Path::new("table"), bytes);
        let _ = table.map(|table| drop(table.curve(&TableChoice::default())));
        let most = MOST.load(Relaxed) - before;
        assert!(most <= 16 * length + FIXED, "{most} bytes for {length}");
    }
}
