//! Files that are there whole or not at all.

use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::error::{Error, Result};

/// Writes a file beside `path`, brings it to the disk and renames it to `path`.
///
/// Whatever stops it (an error of `write`, a full disk, a killed process), `path` keeps what it
/// held before. Folders on the way to it are made.
/// Errors: [`Error::Io`].
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut File) -> io::Result<()>,
) -> Result<()> {
    replace(path, write).map_err(|e| Error::io(path, e))
}

/// [`write_atomically`] for text that is at hand.
pub fn write_text(path: &Path, text: &str) -> Result<()> {
    write_atomically(path, |file| file.write_all(text.as_bytes()))
}

/// A CSV file: a header row, then rows of numbers in the shortest form that reads back the same.
///
/// Errors: [`Error::Io`].
pub fn write_csv<Row: AsRef<[f64]>>(
    path: &Path,
    header: &[&str],
    rows: impl IntoIterator<Item = Row>,
) -> Result<()> {
    write_atomically(path, |file| {
        let mut out = BufWriter::new(file);
        writeln!(out, "{}", header.join(","))?;
        for row in rows {
            let cells: Vec<String> = row.as_ref().iter().map(f64::to_string).collect();
            writeln!(out, "{}", cells.join(","))?;
        }
        out.flush()
    })
}

/// The only place that this process writes to, once it has been confined.
static CONFINED: OnceLock<PathBuf> = OnceLock::new();

/// Lets [`write_atomically`] write below `root` only, for as long as the process lives.
///
/// Checked with the folder in hand that is written to: whatever becomes of the names on the way to
/// it in the meantime, nothing is written elsewhere (on Linux; other systems check names).
/// Errors: [`Error::Io`] if there is no such place.
pub fn confine(root: &Path) -> Result<()> {
    let is_there = |path: &&Path| path.exists();
    let existing = root.ancestors().find(is_there).unwrap_or(Path::new("."));
    let rest = root.strip_prefix(existing).unwrap_or(root);
    let existing = if existing == Path::new("") { Path::new(".") } else { existing };
    let real = existing.canonicalize().map_err(|e| Error::io(existing, e))?;
    CONFINED.get_or_init(|| real.join(rest));
    Ok(())
}

/// Writes through a handle of the folder, so that a name that changes its meaning changes nothing.
fn replace(path: &Path, write: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
    let folder = match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    fs::create_dir_all(folder)?;
    let handle = folder_handle(folder)?;
    let place = place_of(handle.as_ref(), folder);
    check_confined(&place)?;
    let name = path.file_name().ok_or_else(|| io::Error::other("not the name of a file"))?;
    let partial = Partial(place.join(partial_name(name)));
    let mut file = File::options().read(true).write(true).create_new(true).open(&partial.0)?;
    write(&mut file)?;
    file.sync_all()?;
    drop(file);
    fs::rename(&partial.0, place.join(name))?;
    // The rename itself survives a crash only if the folder is synced.
    handle.map_or(Ok(()), |handle| handle.sync_all())
}

fn check_confined(place: &Path) -> io::Result<()> {
    let Some(root) = CONFINED.get() else {
        return Ok(());
    };
    // The link of an open folder is read as it is: its text is not to be looked up again.
    let is_open = place.starts_with("/proc/self/fd");
    let real = if is_open { fs::read_link(place)? } else { place.canonicalize()? };
    if real.starts_with(root) {
        return Ok(());
    }
    Err(io::Error::new(io::ErrorKind::PermissionDenied, "outside of the output folder"))
}

/// A file that vanishes unless it is renamed.
struct Partial(PathBuf);

impl Drop for Partial {
    fn drop(&mut self) {
        // After the rename there is nothing left to remove, and no way to tell of a failure.
        let _ = fs::remove_file(&self.0);
    }
}

/// Hidden, in the same folder (renames do not cross file systems), unlike any other's.
fn partial_name(name: &OsStr) -> String {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let count = COUNT.fetch_add(1, Ordering::Relaxed);
    let process = std::process::id();
    format!(".{}.{process}.{count}.partial", name.to_string_lossy())
}

/// Folders open as files only on Unix.
#[cfg(unix)]
fn folder_handle(folder: &Path) -> io::Result<Option<File>> {
    File::open(folder).map(Some)
}

#[cfg(not(unix))]
fn folder_handle(_: &Path) -> io::Result<Option<File>> {
    Ok(None)
}

/// Names the very folder that is open, whatever its own name leads to now.
#[cfg(target_os = "linux")]
fn place_of(handle: Option<&File>, folder: &Path) -> PathBuf {
    use std::os::fd::AsRawFd;
    let open = handle.map(|handle| PathBuf::from(format!("/proc/self/fd/{}", handle.as_raw_fd())));
    // Without /proc there are only names.
    open.filter(|open| open.exists()).unwrap_or_else(|| folder.to_owned())
}

#[cfg(not(target_os = "linux"))]
fn place_of(_: Option<&File>, folder: &Path) -> PathBuf {
    folder.to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::scratch::ScratchFolder;

    #[test]
    fn folders_are_made_and_files_replaced() {
        let scratch = ScratchFolder::new();
        let path = scratch.path("a/b/c.txt");
        write_text(&path, "one").unwrap();
        write_text(&path, "two").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "two");
        assert_eq!(fs::read_dir(path.parent().unwrap()).unwrap().count(), 1);
    }

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let scratch = ScratchFolder::new();
        let path = scratch.path("c.txt");
        write_text(&path, "old").unwrap();
        let error = write_atomically(&path, |file| {
            file.write_all(b"half")?;
            Err(io::Error::other("disk full"))
        });
        assert_eq!(error.unwrap_err().to_string(), format!("{}: disk full", path.display()));
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(fs::read_dir(path.parent().unwrap()).unwrap().count(), 1);
    }

    #[test]
    fn csv_reads_back_bit_for_bit() {
        let scratch = ScratchFolder::new();
        let path = scratch.path("t.csv");
        let row = [0.1 + 0.2, 1e-300, -0.0];
        write_csv(&path, &["a", "b", "c"], [row]).unwrap();
        let text = fs::read_to_string(&path).unwrap();
        let (header, cells) = text.trim_end().split_once('\n').unwrap();
        assert_eq!(header, "a,b,c");
        for (cell, value) in cells.split(',').zip(row) {
            assert_eq!(cell.parse::<f64>().unwrap().to_bits(), value.to_bits());
        }
    }
}
