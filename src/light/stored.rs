//! Samples and numbers as bytes, for who keeps them from one process to the next.

use std::io::{self, Read, Write};
use std::sync::Arc;

use super::RaySample;

/// Floats of a sample.
const FLOATS: usize = 7;

impl RaySample {
    fn floats(&self) -> [f32; FLOATS] {
        let ([x, y, z], [a, b, c]) = (self.position, self.direction);
        [x, y, z, a, b, c, self.flux]
    }

    fn floats_mut(&mut self) -> impl Iterator<Item = &mut f32> {
        self.position.iter_mut().chain(&mut self.direction).chain([&mut self.flux])
    }
}

/// 28 bytes a sample: position, direction, flux.
pub fn write_samples(samples: &[RaySample], out: &mut dyn Write) -> io::Result<()> {
    write_floats(out, samples.iter().flat_map(RaySample::floats))
}

/// What [`write_samples`] wrote of `count` samples, bit for bit.
///
/// Errors: bytes that end too early.
pub fn read_samples(count: usize, from: &mut dyn Read) -> io::Result<Arc<[RaySample]>> {
    let empty = RaySample { position: [0.0; 3], direction: [0.0; 3], flux: 0.0 };
    let mut samples: Arc<[RaySample]> = std::iter::repeat_n(empty, count).collect();
    let places = Arc::make_mut(&mut samples).iter_mut().flat_map(RaySample::floats_mut);
    read_floats(from, FLOATS * count, places)?;
    Ok(samples)
}

/// Words that go through memory at a time.
const CHUNK: usize = 16384;

pub(super) fn write_floats(
    out: &mut dyn Write,
    values: impl Iterator<Item = f32>,
) -> io::Result<()> {
    write_words(out, values.map(f32::to_le_bytes))
}

/// `count` values.
pub(super) fn read_floats<'a>(
    from: &mut dyn Read,
    count: usize,
    values: impl Iterator<Item = &'a mut f32>,
) -> io::Result<()> {
    read_words(from, count, values, f32::from_le_bytes)
}

pub(super) fn write_words(
    out: &mut dyn Write,
    words: impl Iterator<Item = [u8; 4]>,
) -> io::Result<()> {
    let mut chunk = Vec::with_capacity(4 * CHUNK);
    for word in words {
        chunk.extend(word);
        if chunk.len() == 4 * CHUNK {
            out.write_all(&chunk)?;
            chunk.clear();
        }
    }
    out.write_all(&chunk)
}

pub(super) fn read_words<'a, T: 'a>(
    from: &mut dyn Read,
    mut count: usize,
    mut values: impl Iterator<Item = &'a mut T>,
    value: fn([u8; 4]) -> T,
) -> io::Result<()> {
    let mut chunk = vec![[0; 4]; CHUNK.min(count)];
    while count > 0 {
        chunk.truncate(count);
        from.read_exact(chunk.as_flattened_mut())?;
        chunk.iter().zip(values.by_ref()).for_each(|(word, place)| *place = value(*word));
        count -= chunk.len();
    }
    Ok(())
}
