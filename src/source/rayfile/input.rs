//! A ray file as bytes of known number, read front to back.

use std::io::{Cursor, Read};
use std::path::{Path, PathBuf};

use crate::error::{Error, Place, Result};

/// How much of a file decides its format.
const HEAD_BYTES: usize = 4096;

/// Bytes with their count, so that no header can ask for more memory than the file justifies.
pub(super) struct Input<'a> {
    path: PathBuf,
    head: Cursor<Vec<u8>>,
    rest: &'a mut dyn Read,
    bytes: u64,
    bytes_left: u64,
}

impl<'a> Input<'a> {
    /// Errors: [`Error::Io`].
    pub fn new(path: &Path, reader: &'a mut dyn Read, bytes: u64) -> Result<Self> {
        let mut input = Self {
            path: path.to_owned(),
            head: Cursor::default(),
            rest: reader,
            bytes,
            bytes_left: bytes,
        };
        let mut head = vec![0; HEAD_BYTES.min(usize::try_from(bytes).unwrap_or(HEAD_BYTES))];
        let found = input.fill(&mut head)?;
        head.truncate(found);
        input.bytes_left = bytes;
        input.head = Cursor::new(head);
        Ok(input)
    }

    pub fn head(&self) -> &[u8] {
        self.head.get_ref()
    }

    pub fn bytes_left(&self) -> u64 {
        self.bytes_left
    }

    /// As many bytes as there are, at most `buffer.len()`.
    pub fn fill(&mut self, buffer: &mut [u8]) -> Result<usize> {
        let wanted = buffer.len().min(usize::try_from(self.bytes_left).unwrap_or(usize::MAX));
        let mut found = 0;
        while found < wanted {
            let target = &mut buffer[found..wanted];
            let step = match self.head.read(target) {
                Ok(0) => self.rest.read(target),
                step => step,
            };
            match step {
                Ok(0) => break,
                Ok(bytes) => found += bytes,
                Err(e) if e.kind() == std::io::ErrorKind::Interrupted => {}
                Err(e) => return Err(Error::io(&self.path, e)),
            }
        }
        self.bytes_left -= found as u64;
        Ok(found)
    }

    /// Errors: the file ends before `buffer` is full; `what` names the part that is cut.
    pub fn read_exact(&mut self, buffer: &mut [u8], what: &str) -> Result<()> {
        let found = self.fill(buffer)?;
        if found == buffer.len() {
            return Ok(());
        }
        Err(self.bad(format!(
            "the file ends after {} bytes, {} bytes short of {what}",
            self.bytes - self.bytes_left,
            buffer.len() - found
        )))
    }

    /// The next `bytes` bytes; allocates only what the file's size justifies.
    pub fn take(&mut self, bytes: u64, what: &str) -> Result<Vec<u8>> {
        if bytes > self.bytes_left {
            return Err(self.bad(format!(
                "{what} takes {bytes} bytes, the file has {} left",
                self.bytes_left
            )));
        }
        let mut buffer = vec![0; bytes as usize];
        self.read_exact(&mut buffer, what)?;
        Ok(buffer)
    }

    pub fn bad(&self, problem: impl Into<String>) -> Error {
        self.bad_at(Place::File, problem)
    }

    pub fn bad_at(&self, place: Place, problem: impl Into<String>) -> Error {
        Error::bad_file(&self.path, place, problem)
    }
}

/// Little-endian fields of a header at byte offsets that the caller has checked.
pub(super) struct Header(pub Vec<u8>);

impl Header {
    fn word(&self, offset: usize) -> [u8; 4] {
        let mut word = [0; 4];
        word.copy_from_slice(&self.0[offset..offset + 4]);
        word
    }

    pub fn u32(&self, offset: usize) -> u32 {
        u32::from_le_bytes(self.word(offset))
    }

    pub fn i32(&self, offset: usize) -> i32 {
        i32::from_le_bytes(self.word(offset))
    }

    pub fn f32(&self, offset: usize) -> f32 {
        f32::from_le_bytes(self.word(offset))
    }

    pub fn u64(&self, offset: usize) -> u64 {
        u64::from(self.u32(offset)) | u64::from(self.u32(offset + 4)) << 32
    }

    /// Printable ASCII up to the first NUL.
    pub fn text(&self, offset: usize, bytes: usize) -> String {
        let text = self.0[offset..offset + bytes].split(|&b| b == 0).next().unwrap_or_default();
        String::from_utf8_lossy(text).trim().to_owned()
    }
}
