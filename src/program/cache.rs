//! Rays and light trees in files, from one run to the next.
//!
//! A file is named by the digest of all that its content comes from, the program included, and ends
//! with the digest of its content: whatever is there under the right name and whole is what would be
//! made. So nobody needs to agree on anything: processes may read, write and remove files at once.

use std::fs::{self, File};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

use crate::error::Result;
use crate::input;
use crate::light::{LightTree, RaySet, read_samples, write_samples};
use crate::output;
use crate::program::sweep::{Digest, Hasher, executable};
use crate::source::Filament;

/// What fewer samples need is made in about the time that reading takes.
const FEWEST_SAMPLES: usize = 50_000;

const EXTENSION: &str = "cache";

/// A folder of files that hold what takes long to make; by default none.
#[derive(Debug, Clone, Default)]
pub struct Cache(Option<Arc<CacheFolder>>);

#[derive(Debug)]
struct CacheFolder {
    path: PathBuf,
    most_bytes: u64,
}

impl Cache {
    /// In a folder, which is made when it is needed. It holds no more than `most_bytes`: what was not
    /// used for the longest time goes first.
    pub fn new(path: PathBuf, most_bytes: u64) -> Self {
        Self(Some(Arc::new(CacheFolder { path, most_bytes })))
    }

    /// Where the user's programs keep such files: `lampyris` in `$XDG_CACHE_HOME`, or in `.cache` of the
    /// home folder.
    pub fn default_folder() -> Option<PathBuf> {
        let named = std::env::var_os("XDG_CACHE_HOME").map(PathBuf::from);
        let home = || Some(std::env::home_dir()?.join(".cache"));
        let caches = named.filter(|path| path.is_absolute()).or_else(home)?;
        caches.is_absolute().then(|| caches.join("lampyris"))
    }

    /// Where files go, if they are kept.
    pub fn folder(&self) -> Option<&Path> {
        self.0.as_ref().map(|folder| &*folder.path)
    }

    /// [`Filament::rayset`]; its samples are read if they were drawn before.
    ///
    /// Errors: as [`Filament::rayset`].
    pub fn rayset(&self, filament: &Filament) -> Result<RaySet> {
        let Filament { coil, samples, seed, .. } = filament;
        let Some(folder) = self.for_samples(*samples) else { return filament.rayset() };
        let key = key("rays", |hasher| hasher.text(&format!("{coil:?} {samples} {seed}")));
        let read = |file: &mut File| read_samples(*samples, file);
        let drawn = match key.as_ref().and_then(|key| folder.find(key, read)) {
            Some(drawn) => drawn,
            None => {
                let drawn = filament.draw()?;
                folder.keep(key.as_ref(), |out| write_samples(&drawn, out));
                drawn
            }
        };
        filament.rayset_of(drawn)
    }

    /// [`LightTree::build`], read if it was built before; `None` for what is not kept.
    pub fn light_tree(&self, rays: &RaySet) -> Option<LightTree> {
        let folder = self.for_samples(rays.samples.len())?;
        if let Some(tree) = LightTree::shared(rays) {
            return Some(tree);
        }
        let key = key("tree", |hasher| {
            hasher.samples(&rays.samples);
            hasher.floats([rays.exponent].into_iter());
        });
        let read = |file: &mut File| LightTree::read(rays, file);
        let found = key.as_ref().and_then(|key| folder.find(key, read));
        found.or_else(|| {
            let tree = LightTree::build(rays);
            folder.keep(key.as_ref(), |out| tree.write(out));
            Some(tree)
        })
    }

    fn for_samples(&self, count: usize) -> Option<&CacheFolder> {
        self.0.as_deref().filter(|_| count >= FEWEST_SAMPLES)
    }
}

/// `None` where the program cannot tell which it is.
fn key(kind: &str, add: impl FnOnce(&mut Hasher)) -> Option<Digest> {
    let mut hasher = Hasher::new();
    hasher.text(kind);
    hasher.text(executable()?.as_str());
    add_arithmetic(&mut hasher);
    add(&mut hasher);
    Some(hasher.finish())
}

/// What the C library's functions give here: machines that share a folder may differ in last digits.
fn add_arithmetic(hasher: &mut Hasher) {
    let at = |i: i32| 0.1 + 0.37 * f64::from(i);
    let values = |x: f64| [x.sin(), x.cos(), (0.1 * x).exp(), x.ln(), x.powf(0.7), x.atan2(3.0)];
    (0..200).for_each(|i| hasher.floats(values(at(i)).into_iter()));
}

impl CacheFolder {
    fn file(&self, key: &Digest) -> PathBuf {
        self.path.join(key.as_str()).with_extension(EXTENSION)
    }

    /// What is kept; `None` if there is nothing, or nothing whole.
    fn find<T>(&self, key: &Digest, read: impl FnOnce(&mut File) -> io::Result<T>) -> Option<T> {
        let mut file = input::open_anywhere(&self.file(key)).ok()?;
        if !is_whole(&mut file).ok()? {
            return None;
        }
        let _ = file.set_modified(SystemTime::now()); // else it only looks older than it is
        read(&mut file).ok()
    }

    /// Keeps what `write` gives. Where that fails, it is made again another time: no fault of the run.
    fn keep(&self, key: Option<&Digest>, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) {
        let Some(key) = key else { return };
        let kept = output::write_unsynced(&self.file(key), |file| {
            let mut out = Sealed { file, hasher: Hasher::new(), left: self.most_bytes };
            write(&mut out)?;
            let digest = out.hasher.finish();
            file.write_all(&digest.to_bytes())
        });
        if kept.is_ok() {
            let _ = self.remove_oldest(); // another run will
        }
    }

    fn remove_oldest(&self) -> io::Result<()> {
        let mut files = Vec::new();
        for entry in fs::read_dir(&self.path)?.flatten() {
            let path = entry.path();
            let data = entry.metadata()?;
            if path.extension().is_some_and(|extension| extension == EXTENSION) && data.is_file() {
                files.push((data.modified()?, data.len(), path));
            }
        }
        files.sort();
        let mut bytes: u64 = files.iter().map(|(_, bytes, _)| bytes).sum();
        for (_, size, path) in files {
            if bytes <= self.most_bytes {
                break;
            }
            let _ = fs::remove_file(path); // somebody else may have removed it
            bytes -= size;
        }
        Ok(())
    }
}

const DIGEST_BYTES: u64 = 32;

/// Whether a file ends with the digest of what is before it; it is then read from its start.
fn is_whole(file: &mut File) -> io::Result<bool> {
    let length = file.metadata()?.len();
    let Some(content) = length.checked_sub(DIGEST_BYTES) else { return Ok(false) };
    let mut hasher = Hasher::new();
    let mut buffer = vec![0; 1 << 18];
    let mut left = file.take(content);
    loop {
        match left.read(&mut buffer)? {
            0 => break,
            count => hasher.bytes(&buffer[..count]),
        }
    }
    let mut end = Vec::new();
    file.read_to_end(&mut end)?;
    file.seek(SeekFrom::Start(0))?;
    Ok(end == hasher.finish().to_bytes())
}

/// Digests what goes into a file, of which there is an end.
struct Sealed<'a> {
    file: &'a mut File,
    hasher: Hasher,
    left: u64,
}

impl Write for Sealed<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let left = self.left.checked_sub(bytes.len() as u64);
        self.left = left.ok_or_else(|| io::Error::other("more than the cache may hold"))?;
        self.file.write_all(bytes)?;
        self.hasher.bytes(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::DVec3;
    use crate::output::scratch::ScratchFolder;
    use crate::source::Coil;

    const FILAMENT: Filament = Filament {
        coil: Coil { wire_radius_mm: 0.06, turns: 12.0, pitch_mm: 0.17, coil_radius_mm: 0.4 },
        center: DVec3::ZERO,
        axis: DVec3::X,
        flux_lm: 400.0,
        samples: FEWEST_SAMPLES,
        seed: 1,
    };

    fn files(folder: &ScratchFolder) -> Vec<PathBuf> {
        let entries = fs::read_dir(folder.path("")).unwrap().map(|entry| entry.unwrap().path());
        let mut files: Vec<PathBuf> = entries.collect();
        files.sort();
        files
    }

    fn with_seed(seed: u64) -> Filament {
        Filament { seed, ..FILAMENT }
    }

    #[test]
    fn what_is_kept_is_what_would_be_made() {
        let folder = ScratchFolder::new();
        let cache = Cache::new(folder.path(""), 1 << 30);
        let made = FILAMENT.rayset().unwrap();
        for _ in 0..2 {
            let rays = cache.rayset(&FILAMENT).unwrap();
            assert_eq!(rays.samples, made.samples);
            let tree = cache.light_tree(&rays).unwrap();
            let bytes = |tree: &LightTree| {
                let mut bytes = Vec::new();
                tree.write(&mut bytes).unwrap();
                bytes
            };
            assert!(bytes(&tree) == bytes(&LightTree::build(&made)));
            assert_eq!(files(&folder).len(), 2);
        }
        // Moved and brighter, it has the same samples.
        let moved = Filament { center: DVec3::ONE, flux_lm: 3.0, ..FILAMENT };
        let rays = cache.rayset(&moved).unwrap();
        assert_eq!((rays.flux_lm, rays.world_from_local.translation), (3.0, DVec3::ONE));
        cache.light_tree(&rays).unwrap();
        assert_eq!(files(&folder).len(), 2);
        cache.rayset(&with_seed(2)).unwrap();
        assert_eq!(files(&folder).len(), 3);
    }

    /// Else nothing would show that files are read at all.
    #[test]
    fn what_a_file_of_the_right_name_holds_is_taken() {
        let folder = ScratchFolder::new();
        let cache = Cache::new(folder.path(""), 1 << 30);
        let drawn = cache.rayset(&FILAMENT).unwrap();
        let first = files(&folder);
        let other = cache.rayset(&with_seed(2)).unwrap();
        assert!(drawn.samples != other.samples);
        let second = files(&folder).into_iter().find(|file| !first.contains(file)).unwrap();
        fs::copy(second, &first[0]).unwrap();
        assert_eq!(cache.rayset(&FILAMENT).unwrap().samples, other.samples);

        let before = files(&folder);
        drop(cache.light_tree(&other).unwrap());
        let tree = files(&folder).into_iter().find(|file| !before.contains(file)).unwrap();
        let empty: Vec<u8> = 0u64.to_le_bytes().into(); // a tree of no samples
        let seal = Digest::of_bytes(&empty).to_bytes();
        fs::write(tree, [empty, seal].concat()).unwrap();
        assert!(cache.light_tree(&other).unwrap().is_empty());
    }

    #[test]
    fn small_sets_and_no_folder_keep_nothing() {
        let folder = ScratchFolder::new();
        let small = Filament { samples: FEWEST_SAMPLES - 1, ..FILAMENT };
        let rays = Cache::new(folder.path(""), 1 << 30).rayset(&small).unwrap();
        assert!(Cache::new(folder.path(""), 1 << 30).light_tree(&rays).is_none());
        assert!(files(&folder).is_empty());
        assert!(Cache::default().rayset(&small).is_ok());
        assert!(Cache::default().light_tree(&rays).is_none());
    }

    #[test]
    fn damaged_files_are_made_again() {
        let folder = ScratchFolder::new();
        let cache = Cache::new(folder.path(""), 1 << 30);
        let made = cache.rayset(&FILAMENT).unwrap();
        let [file] = &files(&folder)[..] else { panic!("a file") };
        let whole = fs::read(file).unwrap();
        let mut damaged = whole.clone();
        damaged[1000] ^= 1;
        for content in [&damaged[..], &whole[..whole.len() - 1], &whole[..5], &[]] {
            fs::write(file, content).unwrap();
            assert_eq!(cache.rayset(&FILAMENT).unwrap().samples, made.samples);
            assert!(fs::read(file).unwrap() == whole);
        }
    }

    #[test]
    fn the_folder_holds_no_more_than_it_may() {
        const FILE_BYTES: u64 = 28 * FEWEST_SAMPLES as u64 + DIGEST_BYTES;
        let folder = ScratchFolder::new();
        let cache = Cache::new(folder.path(""), 2 * FILE_BYTES);
        let long_ago = |file: &Path, hours: u64| {
            let time = SystemTime::now() - std::time::Duration::from_secs(3600 * hours);
            File::options().write(true).open(file).unwrap().set_modified(time).unwrap();
        };
        cache.rayset(&with_seed(1)).unwrap();
        let first = files(&folder);
        cache.rayset(&with_seed(2)).unwrap();
        files(&folder).iter().for_each(|file| long_ago(file, 1));
        long_ago(&first[0], 2);
        cache.rayset(&with_seed(1)).unwrap(); // used again, it is the younger one
        cache.rayset(&with_seed(3)).unwrap();
        assert_eq!(files(&folder).len(), 2);
        assert!(files(&folder).contains(&first[0]));

        let tight = Cache::new(folder.path("tight"), FILE_BYTES - DIGEST_BYTES - 1);
        tight.rayset(&FILAMENT).unwrap();
        assert_eq!(fs::read_dir(folder.path("tight")).unwrap().count(), 0);
    }

    #[test]
    fn a_folder_that_is_none_changes_nothing() {
        let folder = ScratchFolder::new();
        fs::write(folder.path("file"), "text").unwrap();
        let cache = Cache::new(folder.path("file"), 1 << 30);
        assert_eq!(cache.rayset(&FILAMENT).unwrap().samples, FILAMENT.rayset().unwrap().samples);
    }
}
