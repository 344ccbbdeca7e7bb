#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| lampyris_fuzz::read_after(b"lt_rdf_version: 2.0\n", data));
