#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| lampyris_fuzz::read_after(b"0 0 0 0 0 1 1\n", data));
