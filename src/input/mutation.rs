//! Files broken by chance, for the tests of readers.

/// Copies of the seeds, each cut, changed, shortened or lengthened in a few places.
///
/// `LAMPYRIS_MUTATIONS` sets their number; there are `few` unless it does. Letters from `letters` are
/// put in.
pub fn broken<'a>(
    seeds: &'a [Vec<u8>],
    few: usize,
    letters: &'a [u8],
) -> impl Iterator<Item = Vec<u8>> + 'a {
    let count = std::env::var("LAMPYRIS_MUTATIONS").ok().and_then(|n| n.parse().ok());
    let mut state = 1u64;
    let mut random = move |below: usize| {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    (0..count.unwrap_or(few)).map(move |round| {
        let mut bytes = seeds[round % seeds.len()].clone();
        for _ in 0..=random(4) {
            let at = random(bytes.len());
            match random(5) {
                0 => bytes[at] = random(256) as u8,
                1 => bytes[at] = letters[random(letters.len())],
                2 => bytes.insert(at, letters[random(letters.len())]),
                3 if random(4) == 0 => bytes.truncate(at.max(1)),
                _ => drop(bytes.drain(at..(at + 1 + random(8)).min(bytes.len()))),
            }
            if bytes.is_empty() {
                bytes.push(b'1');
            }
        }
        bytes
    })
}
