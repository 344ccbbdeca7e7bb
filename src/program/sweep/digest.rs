//! SHA-256 of files and of what a view is made from.

use std::fmt;
use std::io::{self, BufReader, Read, Write};
use std::path::Path;

use sha2::{Digest as _, Sha256};

use crate::error::{Error, Result};
use crate::input;
use crate::light::{RaySample, write_samples};

/// A SHA-256 digest; shown as 64 hexadecimal digits.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Digest(String);

impl Digest {
    /// Errors: [`Error::Io`].
    pub fn of_file(path: &Path) -> Result<Self> {
        let io = |e| Error::io(path, e);
        let mut file = BufReader::with_capacity(1 << 20, input::open_anywhere(path)?);
        let mut hasher = Hasher::new();
        let mut buffer = vec![0; 1 << 20];
        loop {
            match file.read(&mut buffer) {
                Ok(0) => return Ok(hasher.finish()),
                Ok(count) => hasher.bytes(&buffer[..count]),
                Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
                Err(e) => return Err(io(e)),
            }
        }
    }

    /// The digest of these bytes.
    pub fn of_bytes(bytes: &[u8]) -> Self {
        let mut hasher = Hasher::new();
        hasher.bytes(bytes);
        hasher.finish()
    }

    /// From 64 lower-case hexadecimal digits.
    pub fn parse(text: &str) -> Option<Self> {
        let good = text.len() == 64 && text.bytes().all(|b| matches!(b, b'0'..=b'9' | b'a'..=b'f'));
        good.then(|| Self(text.to_owned()))
    }

    /// Its 32 bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let digit = |byte: u8| (byte as char).to_digit(16).unwrap_or_default() as u8;
        self.0.as_bytes().chunks(2).map(|pair| 16 * digit(pair[0]) + digit(pair[1])).collect()
    }

    /// 64 hexadecimal digits.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl fmt::Display for Digest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// Digests a sequence of things, each set apart from the next.
pub struct Hasher(Sha256);

impl Hasher {
    /// Nothing yet.
    pub fn new() -> Self {
        Self(Sha256::new())
    }

    /// Adds bytes, not set apart from what is around them.
    pub fn bytes(&mut self, bytes: &[u8]) {
        self.0.update(bytes);
    }

    /// Text with its length before it, so that "ab" and "c" differ from "a" and "bc".
    pub fn text(&mut self, text: &str) {
        self.bytes(&(text.len() as u64).to_le_bytes());
        self.bytes(text.as_bytes());
    }

    /// Numbers by their bits, with their count before them.
    pub fn floats(&mut self, values: impl ExactSizeIterator<Item = f64>) {
        self.bytes(&(values.len() as u64).to_le_bytes());
        for value in values {
            self.bytes(&value.to_bits().to_le_bytes());
        }
    }

    /// Samples by their bits, with their count before them.
    pub fn samples(&mut self, samples: &[RaySample]) {
        self.bytes(&(samples.len() as u64).to_le_bytes());
        write_samples(samples, self).expect("a digest takes all bytes");
    }

    /// The digest of all that was added.
    pub fn finish(self) -> Digest {
        use std::fmt::Write as _;
        let mut hex = String::with_capacity(64);
        for byte in self.0.finalize() {
            let _ = write!(hex, "{byte:02x}"); // writing to a string cannot fail
        }
        Digest(hex)
    }
}

impl Write for Hasher {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.bytes(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Default for Hasher {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::scratch::ScratchFolder;

    /// FIPS 180-4, the example "abc".
    const ABC: &str = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";

    #[test]
    fn digests_are_those_of_the_standard() {
        assert_eq!(Digest::of_bytes(b"abc").as_str(), ABC);
        let scratch = ScratchFolder::new();
        std::fs::write(scratch.path("abc"), "abc").unwrap();
        assert_eq!(Digest::of_file(&scratch.path("abc")).unwrap().as_str(), ABC);
        assert_eq!(Digest::parse(ABC).unwrap().as_str(), ABC);
        assert_eq!(Digest::parse(&ABC[1..]), None);
        assert_eq!(Digest::parse(&ABC.to_uppercase()), None);
    }

    #[test]
    fn texts_are_set_apart() {
        let digest = |texts: &[&str]| {
            let mut hasher = Hasher::new();
            texts.iter().for_each(|text| hasher.text(text));
            hasher.finish()
        };
        assert_ne!(digest(&["ab", "c"]), digest(&["a", "bc"]));
    }
}
