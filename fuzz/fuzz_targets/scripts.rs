//! Random calls of the interface that scripts have: the input is the seed and the number of calls.

#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use lampyris::program::progress::Verbosity;
use lampyris::program::script::{Settings, describe_options, run};

fuzz_target!(|input: (u32, u8)| {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/program/random.lua");
    let options = describe_options("").expect("all options");
    let rows = options.lines().filter_map(|line| line.strip_prefix("  "));
    let keys: Vec<&str> = rows.filter_map(|row| row.split([' ', '?']).next()).collect();
    let settings = Settings {
        out: std::env::temp_dir().join("lampyris-fuzz"),
        verbosity: Verbosity::Quiet,
        arguments: vec![input.0.to_string(), keys.join(" "), input.1.to_string()],
        max_memory: Some(1_000_000_000),
        ..Settings::default()
    };
    let done = run(Path::new(script), settings);
    assert!(done.is_ok(), "{done:?}");
});
