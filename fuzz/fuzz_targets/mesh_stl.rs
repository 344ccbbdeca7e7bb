#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    lampyris_fuzz::read_stl(data);
    lampyris_fuzz::read_mesh(b"solid a\nfacet\n", data);
});
