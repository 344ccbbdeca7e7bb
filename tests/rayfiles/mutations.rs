//! Broken files of every kind: no panic, and no more memory than the file justifies.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use crate::random::Random;
use crate::seeds;

/// The system's allocator, which notes the largest request of a thread.
struct Watched;

thread_local! {
    static LARGEST: Cell<usize> = const { Cell::new(0) };
}

fn note(size: usize) {
    // Threads that end have no counter any more.
    let _ = LARGEST.try_with(|largest| largest.set(largest.get().max(size)));
}

// SAFETY: every call goes to the system's allocator unchanged; the note allocates nothing.
unsafe impl GlobalAlloc for Watched {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        note(layout.size());
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        note(layout.size());
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        note(size);
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Watched = Watched;

/// Words that readers stumble over.
const WORDS: [u32; 12] = [
    0,
    1,
    2,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_ffff,
    0x7fc0_0001,
    0x7f80_0000,
    0x0000_1000,
    0x3f80_0000,
    0x4b00_0000,
    0x0100_c07f,
];

const SNIPPETS: [&[u8]; 12] = [
    b"\n",
    b"\r\n",
    b",",
    b" ",
    b"-",
    b"e99",
    b"nan",
    b"#",
    b"1e-46",
    b"lt_endofdata",
    b"\0",
    b"\xef\xbb\xbf",
];

/// Where to change: mostly in the fields of headers and near the end, where the rays are.
fn place(bytes: &[u8], random: &mut Random) -> usize {
    match random.below(4) {
        0 => random.below(bytes.len()),
        1 => random.below(bytes.len().min(300)),
        2 => random.below(bytes.len().min(96)) & !3,
        _ => bytes.len().saturating_sub(1 + random.below(300)),
    }
}

fn mutate(bytes: &mut Vec<u8>, random: &mut Random) {
    for _ in 0..1 + random.below(4) {
        let at = place(bytes, random);
        match random.below(7) {
            0 if at < bytes.len() => bytes[at] ^= 1 << random.below(8),
            1 if at < bytes.len() => bytes[at] = random.bits() as u8,
            2 if at + 4 <= bytes.len() => {
                bytes[at..at + 4].copy_from_slice(&WORDS[random.below(WORDS.len())].to_le_bytes());
            }
            3 => bytes.truncate(at),
            4 => {
                let end = (at + random.below(64)).min(bytes.len());
                bytes.drain(at.min(end)..end);
            }
            5 => {
                let snippet = SNIPPETS[random.below(SNIPPETS.len())];
                let at = at.min(bytes.len());
                bytes.splice(at..at, snippet.iter().copied());
            }
            _ => {
                let end = (at + random.below(64)).min(bytes.len());
                let copy = bytes[at.min(end)..end].to_vec();
                bytes.splice(at.min(end)..at.min(end), copy);
            }
        }
    }
}

/// `LAMPYRIS_MUTATIONS` sets the number; a million were run before release.
#[test]
fn mutated_files_neither_panic_nor_ask_for_memory() {
    let count = std::env::var("LAMPYRIS_MUTATIONS").ok().and_then(|n| n.parse().ok());
    let count: u64 = count.unwrap_or(20_000);
    let seeds = seeds::all();
    let mut accepted = 0;
    // One thread, so that its counter sees every request.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build().unwrap();
    pool.install(|| {
        for case in 0..count {
            let mut random = Random(case);
            let mut bytes = seeds[random.below(seeds.len())].clone();
            mutate(&mut bytes, &mut random);
            LARGEST.set(0);
            accepted += u64::from(seeds::read(&bytes).is_ok());
            // Buffers of fixed size, and at most 170 times a file of tiny spectral tables.
            let bound = 64 * bytes.len() + (1 << 20);
            assert!(LARGEST.get() <= bound, "case {case}: {} bytes", LARGEST.get());
        }
    });
    // Mutations that never get past the headers would test nothing.
    assert!(accepted > count / 20, "{accepted} of {count}");
    println!("{accepted} of {count} mutated files were read, the others refused");
}
