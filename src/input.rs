//! Files to be read: looked at once they are open, and only inside of known folders.

#[cfg(test)]
pub(crate) mod mutation;

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use crate::error::{Error, Place, Result};

/// The only folders that this process reads from, once it has been confined.
static CONFINED: OnceLock<Vec<PathBuf>> = OnceLock::new();

/// Lets [`open`] open files below `folders` only, for as long as the process lives.
///
/// Checked with the file in hand: whatever becomes of the names on the way to it in the meantime,
/// nothing is read elsewhere (on Linux; other systems check names).
/// Errors: [`Error::Io`] if there is no working directory.
pub fn confine<'a>(folders: impl IntoIterator<Item = &'a Path>) -> Result<()> {
    let real = |folder: &'a Path| real_path(folder).map_err(|e| Error::io(folder, e));
    let folders = folders.into_iter().map(real).collect::<Result<_>>()?;
    CONFINED.get_or_init(|| folders);
    Ok(())
}

/// Opens a file to be read.
///
/// Errors: [`Error::Io`], also for a file that [`confine`] keeps out of reach; [`Error::BadFile`]
/// for folders, named pipes and devices, which are not waited for.
pub fn open(path: &Path) -> Result<File> {
    let file = open_anywhere(path)?;
    check_confined(&file, path).map_err(|e| Error::io(path, e))?;
    Ok(file)
}

/// As [`open`], wherever the file lies: for what no script gets to see.
pub(crate) fn open_anywhere(path: &Path) -> Result<File> {
    let mut options = File::options();
    options.read(true);
    never_wait(&mut options);
    let file = options.open(path).map_err(|e| Error::io(path, e))?;
    match file.metadata() {
        Ok(data) if data.is_file() => Ok(file),
        _ => Err(Error::bad_file(path, Place::File, "is no regular file")),
    }
}

/// All of a file. Errors: as [`open`].
pub fn bytes(path: &Path) -> Result<Vec<u8>> {
    head(path, u64::MAX)
}

/// The first `most` bytes of a file, or all of a shorter one. Errors: as [`open`].
pub fn head(path: &Path, most: u64) -> Result<Vec<u8>> {
    let file = open(path)?;
    let length = file.metadata().map_or(0, |data| data.len());
    let mut bytes = Vec::with_capacity(length.min(most) as usize);
    file.take(most).read_to_end(&mut bytes).map_err(|e| Error::io(path, e))?;
    Ok(bytes)
}

/// A path without links, of a place that need not be there yet.
pub(crate) fn real_path(path: &Path) -> io::Result<PathBuf> {
    let is_there = |path: &&Path| path.exists();
    let existing = path.ancestors().find(is_there).unwrap_or(Path::new(""));
    let rest = path.strip_prefix(existing).unwrap_or(path);
    let existing = if existing == Path::new("") { Path::new(".") } else { existing };
    Ok(existing.canonicalize()?.join(rest))
}

fn check_confined(file: &File, path: &Path) -> io::Result<()> {
    let Some(folders) = CONFINED.get() else {
        return Ok(());
    };
    let real = place_of(file, path)?;
    if folders.iter().any(|folder| real.starts_with(folder)) {
        return Ok(());
    }
    Err(io::Error::new(io::ErrorKind::PermissionDenied, "outside of the folders to read from"))
}

/// Where an open file lies, whatever its name leads to now.
#[cfg(target_os = "linux")]
fn place_of(file: &File, path: &Path) -> io::Result<PathBuf> {
    use std::os::fd::AsRawFd;
    // Without /proc there are only names.
    let open = std::fs::read_link(format!("/proc/self/fd/{}", file.as_raw_fd()));
    open.or_else(|_| path.canonicalize())
}

#[cfg(not(target_os = "linux"))]
fn place_of(_: &File, path: &Path) -> io::Result<PathBuf> {
    path.canonicalize()
}

/// A named pipe opens at once, so that it can be refused.
#[cfg(unix)]
fn never_wait(options: &mut std::fs::OpenOptions) {
    use std::os::unix::fs::OpenOptionsExt;
    options.custom_flags(libc::O_NONBLOCK);
}

#[cfg(not(unix))]
fn never_wait(_: &mut std::fs::OpenOptions) {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::scratch::ScratchFolder;

    #[test]
    fn reads_files_and_nothing_else() {
        let scratch = ScratchFolder::new();
        std::fs::write(scratch.path("t.txt"), "abc").unwrap();
        assert_eq!(bytes(&scratch.path("t.txt")).unwrap(), b"abc");
        assert_eq!(head(&scratch.path("t.txt"), 2).unwrap(), b"ab");
        let message = |name: &str| open(&scratch.path(name)).unwrap_err().to_string();
        assert!(message("").ends_with(": is no regular file"), "{}", message(""));
        assert!(message("none").contains("No such file"), "{}", message("none"));
    }

    #[test]
    fn real_paths_need_not_be_there() {
        let scratch = ScratchFolder::new();
        let real = scratch.path("").canonicalize().unwrap();
        assert_eq!(real_path(&scratch.path("a/b")).unwrap(), real.join("a/b"));
        let here = std::env::current_dir().unwrap().canonicalize().unwrap();
        assert_eq!(real_path(Path::new("no/such")).unwrap(), here.join("no/such"));
    }
}
