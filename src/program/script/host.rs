//! What a running script knows of its surroundings: folders, output, warnings, Ctrl-C.

use std::collections::BTreeSet;
use std::io::Write;
use std::path::{Component, Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock};

use mlua::Lua;

use super::kept::Kept;
use crate::display::{Gamut, GamutReport, Look};
use crate::error::{Error, Result};
use crate::output;
use crate::program::cache::Cache;
use crate::program::memory;
use crate::program::progress::{Progress, Verbosity};
use crate::program::screen::Screen;
use crate::program::stage::InUse;
use crate::program::stamp::Stamp;
use crate::program::sweep::{self, Shard};

/// What the command line says.
#[derive(Debug, Clone, Default)]
pub struct Settings {
    /// Everything written goes under this folder.
    pub out: PathBuf,
    /// What standard error is told.
    pub verbosity: Verbosity,
    /// The script's own arguments.
    pub arguments: Vec<String>,
    /// Set by Ctrl-C.
    pub interrupted: Arc<AtomicBool>,
    /// Folders to read from, besides the script's and the working directory.
    pub read: Vec<PathBuf>,
    /// Bytes that the program may use, Lua's among them.
    pub max_memory: Option<usize>,
    /// Tell what sweeps and studies would make, and make nothing of it.
    pub is_dry_run: bool,
    /// The part of each sweep to render.
    pub shard: Option<Shard>,
    /// What is kept from one run to the next.
    pub kept: Option<Arc<Kept>>,
    /// Where pictures and text are shown while they come.
    pub screen: Option<Arc<Screen>>,
    /// All files that are read, for who waits until they change.
    pub reads: Reads,
    /// Prepared scenes that others may take parts from.
    pub in_use: InUse,
    /// What earlier processes made.
    pub cache: Cache,
}

/// The files that a run has read so far.
#[derive(Debug, Clone, Default)]
pub struct Reads(Arc<Mutex<Vec<ScriptInput>>>);

impl Reads {
    fn add(&self, input: &ScriptInput) {
        locked(&self.0).push(input.clone());
    }

    /// Whether one of them is there, but not as it was read.
    pub fn have_changed(&self) -> bool {
        let is_new =
            |input: &ScriptInput| Stamp::of(&input.path).is_ok_and(|now| now != input.stamp);
        locked(&self.0).iter().any(is_new)
    }
}

/// The surroundings of one script.
#[derive(Debug, Clone)]
pub struct Host {
    /// The script's file, as it was named.
    pub script: PathBuf,
    /// What the command line says.
    pub settings: Settings,
    warnings: Arc<Mutex<Vec<(String, u32)>>>,
    clipped: Arc<Mutex<Clipped>>,
    script_input: Arc<OnceLock<ScriptInput>>,
    inputs: Arc<Mutex<Vec<ScriptInput>>>,
    /// Bytes of big things made since garbage was last collected.
    uncollected: Arc<AtomicUsize>,
    seeds: Arc<Mutex<Vec<(String, u64)>>>,
    /// Folders that sweeps and studies have.
    claimed: Arc<Mutex<BTreeSet<PathBuf>>>,
}

/// A file that the script read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ScriptInput {
    /// As the script names it.
    pub name: String,
    /// Where it was found.
    pub path: PathBuf,
    /// When it was read.
    pub stamp: Stamp,
}

/// What a host was told.
#[derive(Debug, Clone, Default)]
pub(super) struct Told {
    warnings: Vec<(String, u32)>,
    inputs: Vec<ScriptInput>,
    seeds: Vec<(String, u64)>,
}

impl Told {
    /// Whether the files are as they were read.
    pub fn still_holds(&self) -> bool {
        self.inputs.iter().all(|input| input.check().is_ok())
    }
}

impl ScriptInput {
    /// Whether the file is still the one that was read.
    ///
    /// Errors: the file has changed since it was read.
    pub fn check(&self) -> Result<()> {
        if Stamp::of(&self.path)? == self.stamp {
            return Ok(());
        }
        let problem = format!("{} has changed since it was read: run the script again", self.name);
        Err(Error::inconsistent("input", problem))
    }
}

impl Host {
    /// State of a script that has not read anything yet.
    pub fn new(script: &Path, settings: Settings) -> Self {
        Self {
            script: script.to_owned(),
            settings,
            script_input: Arc::default(),
            uncollected: Arc::default(),
            warnings: Arc::default(),
            clipped: Arc::default(),
            inputs: Arc::default(),
            seeds: Arc::default(),
            claimed: Arc::default(),
        }
    }

    /// Whether Ctrl-C was pressed.
    pub fn is_interrupted(&self) -> bool {
        self.settings.interrupted.load(Ordering::Relaxed)
    }

    /// Progress of a job of so many pixels.
    pub fn progress(&self, pixels: usize) -> Progress {
        Progress::new(self.settings.verbosity, Arc::clone(&self.settings.interrupted), pixels)
    }

    /// As files name the script: the same from wherever it is run.
    pub fn script_name(&self) -> String {
        self.script.file_name().unwrap_or_default().to_string_lossy().into_owned()
    }

    /// The folder that files are first looked for in.
    pub fn script_folder(&self) -> &Path {
        self.script.parent().unwrap_or(Path::new(""))
    }

    /// Where a file to be read lies: the script's folder first, then the working directory. It is
    /// noted as an input.
    ///
    /// Errors: a place outside of both and of the folders of `--read`, also through a symbolic
    /// link, whether there is a file or not; a named pipe, a device. A file that is not there is
    /// left to its reader to report.
    pub fn input(&self, path: &str) -> Result<PathBuf> {
        let beside_script = self.script_folder().join(path);
        let found = if beside_script.exists() { beside_script } else { PathBuf::from(path) };
        self.check_readable(path, &found)?;
        if found.exists() {
            self.note_input(path, &found)?;
        }
        Ok(found)
    }

    /// Notes a file that the script is about to read.
    ///
    /// Errors: a file that has changed since it was read before; a named pipe, a device.
    pub(super) fn note_input(&self, name: &str, path: &Path) -> Result<()> {
        let stamp = Stamp::of(path)?;
        let mut inputs = locked(&self.inputs);
        match inputs.iter().find(|input| input.name == name && input.path == path) {
            Some(known) => known.check(),
            None => {
                let input = ScriptInput { name: name.to_owned(), path: path.to_owned(), stamp };
                self.settings.reads.add(&input);
                inputs.push(input);
                Ok(())
            }
        }
    }

    /// Calls `make`, and tells what it has noted here meanwhile.
    ///
    /// Errors: those of `make`; a file that it has read, and that has changed since it was read before.
    pub(super) fn listened_to<T>(
        &self,
        make: impl FnOnce() -> mlua::Result<T>,
    ) -> mlua::Result<(T, Told)> {
        let before = self.take_told();
        let made = make();
        let told = self.take_told();
        self.put_back(before);
        self.tell_again(&told)?;
        Ok((made?, told))
    }

    fn take_told(&self) -> Told {
        Told {
            warnings: std::mem::take(&mut locked(&self.warnings)),
            inputs: std::mem::take(&mut locked(&self.inputs)),
            seeds: std::mem::take(&mut locked(&self.seeds)),
        }
    }

    fn put_back(&self, told: Told) {
        *locked(&self.warnings) = told.warnings;
        *locked(&self.inputs) = told.inputs;
        *locked(&self.seeds) = told.seeds;
    }

    /// Notes what was noted when something was made that is now taken as it was.
    ///
    /// Errors: a file that was noted otherwise before.
    pub(super) fn tell_again(&self, told: &Told) -> Result<()> {
        for (text, count) in &told.warnings {
            (0..*count).for_each(|_| self.warn(text.as_str()));
        }
        for (object, seed) in &told.seeds {
            self.note_seed(object, *seed);
        }
        told.inputs.iter().try_for_each(|input| self.note_input(&input.name, &input.path))
    }

    /// Notes the script itself, before it is read, unless it comes from a pipe.
    pub(super) fn note_script(&self) {
        if let Ok(stamp) = Stamp::of(&self.script) {
            let input = ScriptInput { name: self.script_name(), path: self.script.clone(), stamp };
            self.script_input.get_or_init(|| input);
        }
    }

    /// The script as it was read; `None` at a prompt, and from a pipe.
    pub fn script_input(&self) -> Option<&ScriptInput> {
        self.script_input.get()
    }

    /// All files that the script has read so far, in the order of their first reading.
    pub fn inputs(&self) -> Vec<ScriptInput> {
        locked(&self.inputs).clone()
    }

    /// Notes the seed of a light's samples.
    pub fn note_seed(&self, object: &str, seed: u64) {
        let mut seeds = locked(&self.seeds);
        let noted = (object.to_owned(), seed);
        if !seeds.contains(&noted) {
            seeds.push(noted);
        }
    }

    /// Objects and their seeds, in the order of their making.
    pub fn seeds(&self) -> Vec<(String, u64)> {
        locked(&self.seeds).clone()
    }

    /// Errors: `path`, once its symbolic links are followed, lies in no folder to read from.
    pub(super) fn check_readable(&self, name: &str, path: &Path) -> Result<()> {
        // Where there is nothing, the folder that it would be in decides: nobody learns what is there.
        let is_there = |path: &&Path| path.symlink_metadata().is_ok();
        let existing = path.ancestors().find(is_there).unwrap_or(Path::new("."));
        let real = existing.canonicalize().unwrap_or_default();
        let script_folder = match self.script_folder() {
            folder if folder == Path::new("") => Path::new("."),
            folder => folder,
        };
        let folders = [script_folder, Path::new(".")].into_iter();
        let mut folders = folders.chain(self.settings.read.iter().map(PathBuf::as_path));
        if folders.any(|folder| folder.canonicalize().is_ok_and(|f| real.starts_with(f))) {
            return Ok(());
        }
        let allowed = "files in the script's folder, the working directory and --read DIR";
        Err(Error::out_of_range("input", "path", format!("\"{name}\""), allowed))
    }

    /// Where a file is to be written, its folder made.
    ///
    /// Errors: a path that leaves the output folder, also through a symbolic link; a folder that
    /// cannot be made.
    pub fn output(&self, path: &str) -> Result<PathBuf> {
        let refused = || {
            let out = self.settings.out.display();
            Error::out_of_range("output", "path", format!("\"{path}\""), format!("below {out}/"))
        };
        let relative = Path::new(path);
        let stays =
            relative.components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir));
        if !stays || relative.file_name().is_none() {
            return Err(refused());
        }
        let target = self.settings.out.join(relative);
        let folder = target.parent().unwrap_or(&self.settings.out);
        let io = |e| Error::io(folder, e);
        // The deepest folder that exists decides before anything is made.
        let existing = folder.ancestors().find(|f| f.exists()).unwrap_or(Path::new("."));
        if self.settings.out.exists() {
            let root = self.settings.out.canonicalize().map_err(io)?;
            if existing.starts_with(&self.settings.out)
                && !existing.canonicalize().map_err(io)?.starts_with(&root)
            {
                return Err(refused());
            }
        }
        output::make_folder(folder)?;
        Ok(target)
    }

    /// [`Self::output_folder`] for one sweep or study of the script alone.
    ///
    /// Errors: another one of this script has the same.
    pub fn claim_folder(&self, object: &str, path: &str) -> Result<PathBuf> {
        let folder = self.output_folder(path)?;
        let is_new = locked(&self.claimed).insert(folder.clone());
        // At a prompt a line is typed again.
        if is_new || self.script_input().is_none() {
            return Ok(folder);
        }
        let problem = format!(
            "\"output\" is \"{path}\", into which this script has swept or studied already: each needs a \
             folder of its own"
        );
        Err(Error::inconsistent(object, problem))
    }

    /// A folder of its own below the output folder, made. Errors: as [`Host::output`].
    pub fn output_folder(&self, path: &str) -> Result<PathBuf> {
        let file = self.output(&format!("{path}/{}", sweep::MANIFEST))?;
        Ok(file.parent().unwrap_or(&self.settings.out).to_owned())
    }

    /// Notes something that silently changes the picture; the same text is printed once, counted.
    pub fn warn(&self, text: impl Into<String>) {
        let text = text.into();
        let mut warnings = locked(&self.warnings);
        match warnings.iter_mut().find(|(known, _)| *known == text) {
            Some((_, count)) => *count += 1,
            None => warnings.push((text, 1)),
        }
    }

    /// Notes what displays could not show of pictures that were clipped to them.
    pub fn note_clipped(&self, look: &Look, report: &GamutReport, pictures: usize) {
        if look.gamut == Gamut::Clip && look.camera.is_none() {
            let mut clipped = locked(&self.clipped);
            clipped.report = clipped.report.merge(*report);
            clipped.pictures += pictures;
        }
    }

    /// So that the next warning is printed as if it were the first.
    pub(super) fn forget_warnings(&self) {
        locked(&self.warnings).clear();
        *locked(&self.clipped) = Clipped::default();
    }

    /// A line on standard output; nobody may be listening any more, which is no fault.
    pub fn say(&self, line: &str) {
        let _ = writeln!(std::io::stdout(), "{line}");
    }

    /// Prints each warning once, with how often it came.
    pub fn print_warnings(&self) {
        let clipped = locked(&self.clipped).warning().map(|text| (text, 1));
        for (text, count) in locked(&self.warnings).iter().chain(&clipped) {
            let times = if *count > 1 { format!(" ({count} times)") } else { String::new() };
            match self.settings.verbosity {
                Verbosity::Json => {
                    let event = serde_json::json!({
                        "event": "warning", "text": text, "times": count
                    });
                    eprintln!("{event}");
                }
                Verbosity::Quiet | Verbosity::Bar => eprintln!("warning: {text}{times}"),
            }
            if let Some(screen) = &self.settings.screen {
                screen.print(&format!("warning: {text}{times}\n"));
            }
        }
    }

    /// Prints on standard output, and where else the script is watched.
    ///
    /// Errors: nobody takes it.
    pub(super) fn print(&self, text: &[u8]) -> Result<()> {
        if let Some(screen) = &self.settings.screen {
            screen.print(&String::from_utf8_lossy(text));
        }
        let written = std::io::stdout().write_all(text);
        written.map_err(|e| Error::io(Path::new("standard output"), e))
    }
}

/// What displays could not show of the pictures of a run.
#[derive(Debug, Clone, Copy, Default)]
struct Clipped {
    pictures: usize,
    report: GamutReport,
}

impl Clipped {
    /// Shares of the pixels below which nobody minds: automatic exposure alone leaves 0.5 %
    /// above white.
    const MIND: f64 = 0.01;

    fn warning(&self) -> Option<String> {
        let Self { pictures, report } = self;
        let share = |pixels: usize| pixels as f64 / report.pixels.max(1) as f64;
        let (bright, saturated) = (share(report.too_bright), share(report.too_saturated));
        if bright.max(saturated) < Self::MIND {
            return None;
        }
        Some(format!(
            "{pictures} pictures are clipped where the display cannot follow: {:.1} % of their \
             pixels are more saturated than its primaries, {:.1} % brighter than its white, up to \
             ΔE00 {:.1}; look = \"seen\" keeps shape and hue, display = lampyris.display.p3 or an \
             HDR display shows more, exposure = {{ev = -1}} is darker",
            100.0 * saturated,
            100.0 * bright,
            report.max_delta_e_2000,
        ))
    }
}

/// A thread that panicked leaves these lists as good as they were.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(|e| e.into_inner())
}

/// The host of a state.
pub(super) fn of(lua: &Lua) -> mlua::Result<Host> {
    let host = lua.app_data_ref::<Host>();
    host.map(|host| host.clone()).ok_or_else(|| mlua::Error::runtime("state without a host"))
}

/// Big things weigh little in Lua's eyes, so that its collector is called after so many bytes.
const COLLECT_AFTER: usize = 64_000_000;

/// Makes room for something big that is about to be made.
///
/// Errors: it does not fit into what the program may use; `remedy` tells what would.
pub(super) fn reserve(lua: &Lua, object: &str, bytes: usize, remedy: &str) -> mlua::Result<()> {
    let host = of(lua)?;
    let uncollected = host.uncollected.fetch_add(bytes, Ordering::Relaxed).saturating_add(bytes);
    if uncollected > COLLECT_AFTER {
        host.uncollected.store(bytes, Ordering::Relaxed);
        lua.gc_collect()?;
    }
    let limit = host.settings.max_memory.unwrap_or(usize::MAX);
    let used = memory::resident().unwrap_or(0);
    if bytes <= limit.saturating_sub(used) {
        return Ok(());
    }
    let problem = format!(
        "needs {}, but {} of --max-memory {} are in use: {remedy}",
        memory::in_words(bytes),
        memory::in_words(used),
        memory::in_words(limit),
    );
    Err(Error::inconsistent(object, problem).into())
}

/// [`reserve`] for what is made of a file, which is a few times as large.
pub(super) fn reserve_for_file(lua: &Lua, object: &str, path: &Path) -> mlua::Result<()> {
    let length = path.metadata().map_or(0, |data| data.len() as usize);
    reserve(lua, object, length.saturating_mul(4), "a smaller file")
}
