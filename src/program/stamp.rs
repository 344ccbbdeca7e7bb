//! Tells whether a file is still the one that was read.

use std::path::Path;

use crate::error::{Error, Place, Result};

/// What the system says of a file; it changes with the content, and nobody can set it back.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stamp {
    length: u64,
    /// Device, file, and when it was changed: seconds and nanoseconds.
    identity: [i64; 4],
}

impl Stamp {
    /// Errors: [`Error::Io`]; [`Error::BadFile`] for what would be waited for, such as a named pipe.
    pub fn of(path: &Path) -> Result<Self> {
        let data = path.metadata().map_err(|e| Error::io(path, e))?;
        if !data.is_file() {
            return Err(Error::bad_file(path, Place::File, "is no regular file"));
        }
        Ok(Self { length: data.len(), identity: identity(&data) })
    }
}

#[cfg(unix)]
fn identity(data: &std::fs::Metadata) -> [i64; 4] {
    use std::os::unix::fs::MetadataExt;
    [data.dev() as i64, data.ino() as i64, data.ctime(), data.ctime_nsec()]
}

#[cfg(not(unix))]
fn identity(data: &std::fs::Metadata) -> [i64; 4] {
    let epoch = std::time::SystemTime::UNIX_EPOCH;
    let modified = data.modified().ok().and_then(|at| at.duration_since(epoch).ok());
    let modified = modified.unwrap_or_default();
    [0, 0, modified.as_secs() as i64, i64::from(modified.subsec_nanos())]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::scratch::ScratchFolder;

    #[test]
    fn an_edit_of_the_same_length_changes_the_stamp() {
        let scratch = ScratchFolder::new();
        let path = scratch.path("a.obj");
        std::fs::write(&path, "one").unwrap();
        let before = Stamp::of(&path).unwrap();
        assert_eq!(Stamp::of(&path).unwrap(), before);
        // Longer than the clock of a file system ticks.
        std::thread::sleep(std::time::Duration::from_millis(20));
        std::fs::write(&path, "two").unwrap();
        assert_ne!(Stamp::of(&path).unwrap(), before);
    }
}
