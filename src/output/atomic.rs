//! Files that are there whole or not at all.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, OnceLock};
use std::time::Duration;

use crate::error::{Error, Result};
use crate::input;

/// Writes a file beside `path`, brings it to the disk and renames it to `path`.
///
/// Whatever stops it (an error of `write`, a full disk, a killed process), `path` keeps what it
/// held before. Folders on the way to it are made.
/// Errors: [`Error::Io`].
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut File) -> io::Result<()>,
) -> Result<()> {
    replace(path, write, true).map_err(|e| Error::io(path, e))
}

/// [`write_atomically`], but it does not wait for the disk: for what can be made again, and shows
/// whether it is whole.
pub fn write_unsynced(path: &Path, write: impl FnOnce(&mut File) -> io::Result<()>) -> Result<()> {
    replace(path, write, false).map_err(|e| Error::io(path, e))
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
            if let Some(value) = row.as_ref().iter().find(|value| !value.is_finite()) {
                return Err(io::Error::other(format!("a value of the table is {value}")));
            }
            let cells: Vec<String> = row.as_ref().iter().map(f64::to_string).collect();
            writeln!(out, "{}", cells.join(","))?;
        }
        out.flush()
    })
}

/// The only places that this process writes to, once it has been confined.
static CONFINED: OnceLock<Vec<PathBuf>> = OnceLock::new();

/// Lets [`write_atomically`] write below `roots` only, for as long as the process lives.
///
/// Checked with the folder in hand that is written to: whatever becomes of the names on the way to
/// it in the meantime, nothing is written elsewhere (on Linux; other systems check names).
/// Errors: [`Error::Io`] if there is no such place.
pub fn confine<'a>(roots: impl IntoIterator<Item = &'a Path>) -> Result<()> {
    let real = |root: &Path| input::real_path(root).map_err(|e| Error::io(root, e));
    let real = roots.into_iter().map(real).collect::<Result<_>>()?;
    CONFINED.get_or_init(|| real);
    Ok(())
}

/// Makes a folder and all above it. Errors: [`Error::Io`], also where [`confine`] forbids it.
pub fn make_folder(folder: &Path) -> Result<()> {
    OpenFolder::of(folder).map(drop).map_err(|e| Error::io(folder, e))
}

/// A new file that is added to while it is there, such as a log.
///
/// Errors: [`Error::Io`], also if there is one of this name.
pub fn create(path: &Path) -> Result<File> {
    let create = || {
        let (place, name) = OpenFolder::of_file(path)?;
        File::options().append(true).create_new(true).open(place.path.join(name))
    };
    create().map_err(|e| Error::io(path, e))
}

/// Writes through a handle of the folder, so that a name that changes its meaning changes nothing.
fn replace(
    path: &Path,
    write: impl FnOnce(&mut File) -> io::Result<()>,
    is_synced: bool,
) -> io::Result<()> {
    let (place, name) = OpenFolder::of_file(path)?;
    if is_new_to_us(path.parent().unwrap_or(path)) {
        remove_abandoned(&place.path);
    }
    let partial = Partial(place.path.join(partial_name(name)));
    let mut file = File::options().read(true).write(true).create_new(true).open(&partial.0)?;
    let _ = file.try_lock(); // where there are no locks, nothing is taken for abandoned
    write(&mut file)?;
    if is_synced {
        file.sync_all()?;
    }
    drop(file);
    fs::rename(&partial.0, place.path.join(name))?;
    // The rename itself survives a crash only if the folder is synced.
    place.handle.filter(|_| is_synced).map_or(Ok(()), |handle| handle.sync_all())
}

/// A folder that is open, and where it may be written to.
struct OpenFolder {
    handle: Option<File>,
    /// Names the very folder that is open, whatever its own name leads to now.
    path: PathBuf,
}

impl OpenFolder {
    /// The folder of a file, and the file's name in it.
    fn of_file(path: &Path) -> io::Result<(Self, &OsStr)> {
        let name = path.file_name().ok_or_else(|| io::Error::other("not the name of a file"))?;
        Ok((Self::of(path.parent().unwrap_or(Path::new("")))?, name))
    }

    /// Makes what is not there yet, each folder through a handle of the one above it.
    fn of(folder: &Path) -> io::Result<Self> {
        let is_there = |path: &&Path| path.is_dir();
        let existing = folder.ancestors().find(is_there).unwrap_or(Path::new(""));
        let rest = folder.strip_prefix(existing).unwrap_or(Path::new(""));
        let existing = if existing == Path::new("") { Path::new(".") } else { existing };
        let mut place = Self::open(existing)?;
        for name in rest.components() {
            let below = place.path.join(name);
            if !is_confined(&place.real()?.join(name), true) {
                return Err(outside());
            }
            match fs::create_dir(&below) {
                Err(error) if error.kind() != io::ErrorKind::AlreadyExists => return Err(error),
                _ => place = Self::open(&below)?,
            }
        }
        if is_confined(&place.real()?, false) { Ok(place) } else { Err(outside()) }
    }

    fn open(folder: &Path) -> io::Result<Self> {
        let handle = folder_handle(folder)?;
        let path = place_of(handle.as_ref(), folder);
        Ok(Self { handle, path })
    }

    fn real(&self) -> io::Result<PathBuf> {
        // The link of an open folder is read as it is: its text is not to be looked up again.
        let is_open = self.path.starts_with("/proc/self/fd");
        if is_open { fs::read_link(&self.path) } else { self.path.canonicalize() }
    }
}

/// Whether a place is below the only one to write to, or on the way to it.
fn is_confined(real: &Path, or_above: bool) -> bool {
    let is_on_the_way =
        |root: &PathBuf| real.starts_with(root) || (or_above && root.starts_with(real));
    CONFINED.get().is_none_or(|roots| roots.iter().any(is_on_the_way))
}

fn outside() -> io::Error {
    io::Error::new(io::ErrorKind::PermissionDenied, "outside of the output folder")
}

/// A file that vanishes unless it is renamed.
struct Partial(PathBuf);

impl Drop for Partial {
    fn drop(&mut self) {
        // After the rename there is nothing left to remove, and no way to tell of a failure.
        let _ = fs::remove_file(&self.0);
    }
}

fn is_new_to_us(folder: &Path) -> bool {
    static KNOWN: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
    KNOWN.lock().unwrap_or_else(|e| e.into_inner()).insert(folder.to_owned())
}

/// Younger files may be about to be locked.
const ABANDONED_AFTER: Duration = Duration::from_secs(60);

/// Removes what killed processes had begun: partial files that nobody holds any more. What cannot be
/// removed does no harm.
fn remove_abandoned(place: &Path) {
    for entry in fs::read_dir(place).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if name.starts_with('.') && name.ends_with(PARTIAL) && is_abandoned(&entry) {
            let _ = fs::remove_file(entry.path());
        }
    }
}

fn is_abandoned(entry: &fs::DirEntry) -> bool {
    let age = |data: fs::Metadata| data.modified().ok()?.elapsed().ok();
    // Of a link itself, which is no file.
    let age = entry.metadata().ok().filter(fs::Metadata::is_file).and_then(age);
    age.is_some_and(|age| age > ABANDONED_AFTER)
        && File::open(entry.path()).is_ok_and(|file| file.try_lock().is_ok())
}

const PARTIAL: &str = ".partial";

/// Hidden, in the same folder (renames do not cross file systems), unlike any other's.
fn partial_name(name: &OsStr) -> String {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let count = COUNT.fetch_add(1, Ordering::Relaxed);
    let process = std::process::id();
    format!(".{}.{process}.{count}{PARTIAL}", name.to_string_lossy())
}

/// Folders open as files only on Unix.
#[cfg(unix)]
fn folder_handle(folder: &Path) -> io::Result<Option<File>> {
    let handle = File::open(folder)?;
    let is_folder = handle.metadata()?.is_dir();
    is_folder.then_some(Some(handle)).ok_or_else(|| io::ErrorKind::NotADirectory.into())
}

#[cfg(not(unix))]
fn folder_handle(_: &Path) -> io::Result<Option<File>> {
    Ok(None)
}

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
    fn what_killed_processes_left_is_removed() {
        let scratch = ScratchFolder::new();
        let long_ago = std::time::SystemTime::now() - 2 * ABANDONED_AFTER;
        let begun = |name: &str, is_old: bool| {
            let file = File::create(scratch.path(name)).unwrap();
            if is_old {
                file.set_modified(long_ago).unwrap();
            }
            file
        };
        begun(".a.exr.7.0.partial", true);
        begun(".b.exr.7.1.partial", false);
        let held = begun(".c.exr.8.0.partial", true);
        held.lock().unwrap();
        begun("d.partial", true);
        write_text(&scratch.path("t.txt"), "one").unwrap();
        let mut names: Vec<String> = fs::read_dir(scratch.path(""))
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        assert_eq!(names, [".b.exr.7.1.partial", ".c.exr.8.0.partial", "d.partial", "t.txt"]);
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
