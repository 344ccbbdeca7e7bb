//! The command line.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use clap::{Args, Parser, Subcommand, ValueEnum};

use lampyris::Error;
use lampyris::display::{Display, Exposure, Look};
use lampyris::input;
use lampyris::output;
use lampyris::program::cache::Cache;
use lampyris::program::develop::develop_files;
use lampyris::program::progress::Verbosity;
use lampyris::program::script::{self, ScriptFault, Settings};
use lampyris::program::sweep::{self, Shard};
use lampyris::program::{archive, diff, info, memory, study, watch};

/// Predicts what a lit lamp looks like and how bright it is, wavelength by wavelength.
///
/// Exit status: 0 done; 1 a script or its input failed; 2 wrong command line; 130 interrupted.
#[derive(Debug, Parser)]
#[command(version, max_term_width = 100)]
struct CommandLine {
    #[command(subcommand)]
    command: Command,
}

// One at a time, never in a list: a box would cost more than the room.
#[allow(clippy::large_enum_variant)]
#[derive(Debug, Subcommand)]
enum Command {
    /// Run a Lua script
    ///
    /// Scripts read files from their own folder, the working directory and the folders of --read,
    /// and write below --out.
    Run {
        script: PathBuf,
        #[command(flatten)]
        options: RunOptions,
        /// Render a part of each sweep, such as 3/40; `lampyris merge` joins the parts
        #[arg(long, value_name = "NUMBER/COUNT")]
        shard: Option<Shard>,
        /// Say which views and draws sweeps and studies would make, and why; make none of them
        #[arg(long)]
        dry_run: bool,
        /// Arguments for the script, after --
        #[arg(last = true)]
        arguments: Vec<String>,
    },
    /// Run a Lua script again whenever it or what it reads changes, and show its pictures
    ///
    /// A page in a browser on this machine shows each picture coarse first, then finer, and what the
    /// script prints. What has not changed is kept from run to run.
    Watch {
        script: PathBuf,
        #[command(flatten)]
        options: RunOptions,
        /// Where the page is served, on this machine only [default: any that is free]
        #[arg(long, value_name = "PORT", default_value_t = 0, hide_default_value = true)]
        port: u16,
        /// Arguments for the script, after --
        #[arg(last = true)]
        arguments: Vec<String>,
    },
    /// Say what EXR files, ray files, OBJ meshes and spectrum tables hold
    Info {
        #[arg(required = true, value_name = "FILE")]
        files: Vec<PathBuf>,
    },
    /// Make PNG pictures of EXR files, without rendering again
    Develop {
        #[arg(required = true, value_name = "FILE.exr")]
        files: Vec<PathBuf>,
        /// Display that the pictures are for [default: the look's, sRGB]
        #[arg(long, value_name = "NAME", value_parser = display_from_name)]
        display: Option<Display>,
        /// How light is shown: paper, seen or camera
        #[arg(long, value_name = "NAME", value_parser = look_from_name, default_value = "paper")]
        look: Look,
        /// "auto", or stops: 1 is twice as bright as the light's own unit [default: the look's]
        #[arg(long, value_name = "auto|EV", value_parser = exposure_from_text, allow_hyphen_values = true)]
        exposure: Option<Exposure>,
        /// Bits of a channel [default: the display's, 8 or 16]
        #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=16))]
        bits: Option<u32>,
        /// Folder for the pictures [default: beside each file]
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
    },
    /// Type Lua line by line, with the same interface as scripts
    Repl {
        #[command(flatten)]
        options: RunOptions,
    },
    /// Say which options and results the records of the interface have, such as view
    Options {
        #[arg(value_name = "NAME", default_value = "")]
        name: String,
    },
    /// Write a commented script to start from: NAME.lua
    New { name: String },
    /// Check the files of a sweep or study against their record, also before a merge
    Verify {
        /// Folder, or a manifest
        #[arg(value_name = "DIR")]
        manifest: PathBuf,
        /// Check this script and what it read, too
        #[arg(long, value_name = "SCRIPT")]
        script: Option<PathBuf>,
    },
    /// Join the shards of a sweep or a study
    Merge {
        /// Folders with the shards' manifests or tables
        #[arg(required = true, value_name = "DIR")]
        folders: Vec<PathBuf>,
        /// Where the whole goes [default: the first DIR]
        #[arg(long, value_name = "DIR")]
        into: Option<PathBuf>,
    },
    /// Put a sweep or study, its script and all that it read into one file
    Pack {
        /// Folder of the sweep or study
        folder: PathBuf,
        /// Where its script lies [default: near the working directory or the folder]
        #[arg(long, value_name = "SCRIPT")]
        script: Option<PathBuf>,
        /// The archive [default: the folder's name with .tar, in the working directory]
        #[arg(long, value_name = "FILE")]
        into: Option<PathBuf>,
    },
    /// Make the experiment of an archive again, and say whether it is the same
    ///
    /// It is unpacked and made in --out, which must be new or empty, and reads nothing else.
    /// Exit status: 0 if it is the same, 1 if it is not or the archive is none.
    Replay {
        archive: PathBuf,
        #[command(flatten)]
        options: RunOptions,
        /// Largest relative difference of numbers on record that counts as the same [default: 0]
        #[arg(long, value_name = "SHARE", value_parser = tolerance_from_text)]
        tolerance: Option<f64>,
    },
    /// Name every difference of two folders of sweeps or studies
    ///
    /// Exit status: 0 if there is none, 1 if there are some or the folders do not read.
    Diff { a: PathBuf, b: PathBuf },
}

#[derive(Debug, Args)]
struct RunOptions {
    /// Folder under which everything is written
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// Let scripts read from this folder, too; may be given again
    #[arg(long, value_name = "DIR")]
    read: Vec<PathBuf>,
    /// Threads to render with [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
    /// Most memory to use, such as 500M [default: three quarters of the machine's]
    #[arg(long, value_name = "SIZE", value_parser = bytes_from_text)]
    max_memory: Option<usize>,
    /// Folder that keeps rays and light trees from run to run, or "off" [default: LAMPYRIS_CACHE of the
    /// environment, or "lampyris" in the user's cache folder]
    #[arg(long, value_name = "DIR")]
    cache: Option<PathBuf>,
    /// Most that this folder may hold
    #[arg(long, value_name = "SIZE", value_parser = bytes_from_text, default_value = "2G")]
    cache_size: usize,
    /// No progress on standard error
    #[arg(long)]
    quiet: bool,
    /// What standard error is for: a person's terminal, or a machine that reads JSON lines
    #[arg(long, value_name = "FORMAT", default_value = "text")]
    log: Log,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Log {
    Text,
    Json,
}

/// A script or its input failed.
const FAILED: u8 = 1;
/// Ctrl-C, as shells report it.
const INTERRUPTED: u8 = 130;

fn main() -> ExitCode {
    std::panic::set_hook(Box::new(report_bug));
    match CommandLine::parse().command {
        Command::Run { script, options, shard, dry_run, arguments } => options.start(|settings| {
            let read = with_data_of_project(settings.read, &script);
            let settings = Settings { shard, is_dry_run: dry_run, arguments, read, ..settings };
            end_when_stuck(settings.clone());
            confine_reading(&script, &settings)?;
            script::run(&script, settings)
        }),
        Command::Watch { script, options, port, arguments } => options.start(|settings| {
            let read = with_data_of_project(settings.read, &script);
            let settings = Settings { arguments, read, ..settings };
            end_when_stuck(settings.clone());
            confine_reading(&script, &settings)?;
            let say = |line: &str| {
                say(line); // the page goes on without a terminal
            };
            watch::watch(&script, settings, port, say).map_err(ScriptFault::from)
        }),
        Command::Repl { options } => options.start(script::repl),
        Command::Develop { files, display, mut look, exposure, bits, out } => {
            look.display = display.unwrap_or(look.display);
            look.exposure = exposure.unwrap_or(look.exposure);
            let display = look.display.clone();
            match bits.map_or(Ok(display.clone()), |bits| display.with_bits(bits)) {
                Ok(display) => develop(&files, &Look { display, ..look }, out.as_deref()),
                Err(error) => exit_code(Err(error)),
            }
        }
        Command::Info { files } => print_each(&files, |file| info::describe(file)),
        Command::Options { name } => match script::describe_options(&name) {
            Ok(text) => say(text.trim_end()),
            Err(error) => exit_code(Err(error)),
        },
        Command::New { name } => match script::write_starter(&name) {
            Ok(path) => {
                say(&format!("{}: run it with: lampyris run {}", path.display(), path.display()))
            }
            Err(error) => exit_code(Err(error)),
        },
        Command::Verify { manifest, script } => verify(&manifest, script.as_deref()),
        Command::Diff { a, b } => diff(&a, &b),
        Command::Pack { folder, script, into } => pack(&folder, script.as_deref(), into),
        Command::Replay { archive, options, tolerance } => {
            let mut code = ExitCode::SUCCESS;
            let ran = options.start(|settings| {
                let (replayed, is_same) = replay(&archive, settings, tolerance)?;
                code = if is_same {
                    say(&replayed)
                } else {
                    say(&replayed);
                    ExitCode::from(FAILED)
                };
                Ok(())
            });
            if ran == ExitCode::SUCCESS { code } else { ran }
        }
        Command::Merge { folders, into } => {
            let into = into.as_ref().unwrap_or(&folders[0]); // clap asks for one at least
            let is_study = folders.iter().any(|folder| study::is_study(folder));
            let (merged, unit) = match is_study {
                true => (study::merge(&folders, into), "draws"),
                false => (sweep::merge(&folders, into), "views"),
            };
            match merged {
                Ok(sweep::Merged { moved, shards, views }) => {
                    moved.into_iter().for_each(|moved| eprintln!("warning: merge: {moved}"));
                    say(&format!("{}: {shards} shards, {views} {unit}", into.display()))
                }
                Err(error) => exit_code(Err(error)),
            }
        }
    }
}

/// What a panic says, if it is text.
fn said<'a>(panic: &'a std::panic::PanicHookInfo<'_>) -> Option<&'a str> {
    let payload = panic.payload();
    let text = payload.downcast_ref::<&str>().copied();
    text.or_else(|| payload.downcast_ref::<String>().map(String::as_str))
}

/// One line in place of Rust's. Unwinding ends the program then, with exit status 101, and removes
/// what was being written.
fn report_bug(panic: &std::panic::PanicHookInfo<'_>) {
    use std::io::Write;
    let problem = said(panic).unwrap_or("no message").replace('\n', " ");
    let place = panic.location().map_or_else(String::new, |place| format!(" ({place})"));
    let line = format!("lampyris: a bug, please report it with what led here: {problem}{place}\n");
    let _ = std::io::stderr().write_all(line.as_bytes()); // there is nobody else to tell
}

/// What the command says on standard output.
///
/// Nobody may be listening any more, which is no fault; a full disk is one.
fn say(text: &str) -> ExitCode {
    use std::io::{ErrorKind, Write};
    let mut out = std::io::stdout().lock();
    match writeln!(out, "{text}").and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            eprintln!("standard output: {error}");
            ExitCode::from(FAILED)
        }
        _ => ExitCode::SUCCESS,
    }
}

impl RunOptions {
    fn start(self, run: impl FnOnce(Settings) -> Result<(), ScriptFault>) -> ExitCode {
        if let Err(message) = use_threads(self.threads) {
            eprintln!("lampyris: {message}");
            return ExitCode::from(FAILED);
        }
        let cache = match self.cache() {
            Ok(cache) => cache,
            Err(error) => return exit_code(Err(error)),
        };
        let written = [self.out.as_path()].into_iter().chain(cache.folder());
        if let Err(error) = output::confine(written) {
            return exit_code(Err(error));
        }
        let verbosity = match (self.log, self.quiet) {
            (Log::Json, _) => Verbosity::Json,
            (Log::Text, true) => Verbosity::Quiet,
            (Log::Text, false) => Verbosity::Bar,
        };
        let settings = Settings {
            out: self.out,
            verbosity,
            interrupted: interrupted_by_ctrl_c(),
            read: self.read,
            max_memory: Some(self.max_memory.unwrap_or_else(memory::default_limit)),
            cache,
            ..Settings::default()
        };
        match run(settings) {
            Ok(()) => ExitCode::SUCCESS,
            Err(fault) => {
                eprintln!("{}", fault.report(verbosity));
                ExitCode::from(if fault.interrupted { INTERRUPTED } else { FAILED })
            }
        }
    }

    /// A folder that was asked for must be there or be made; the user's own may fail, and nothing is
    /// kept then.
    fn cache(&self) -> Result<Cache, Error> {
        let named = std::env::var_os("LAMPYRIS_CACHE").filter(|name| !name.is_empty());
        let asked = self.cache.clone().or(named.map(PathBuf::from));
        let folder = match asked {
            Some(name) if name == Path::new("off") => None,
            Some(folder) => {
                output::make_folder(&folder)?;
                Some(folder)
            }
            None => Cache::default_folder(),
        };
        Ok(folder.map_or_else(Cache::default, |folder| Cache::new(folder, self.cache_size as u64)))
    }
}

fn pack(folder: &Path, script: Option<&Path>, into: Option<PathBuf>) -> ExitCode {
    let name = folder.file_name().unwrap_or("experiment".as_ref()).to_string_lossy();
    let into = into.unwrap_or_else(|| PathBuf::from(format!("{name}.tar")));
    match archive::pack(folder, script, &into) {
        Ok(files) => say(&format!("{}: {files} files", into.display())),
        Err(error) => exit_code(Err(error)),
    }
}

/// The folders of `--read`, and `data` beside a script's folder `scripts`: a project's scripts run from
/// anywhere.
fn with_data_of_project(mut folders: Vec<PathBuf>, script: &Path) -> Vec<PathBuf> {
    let beside_script = script.parent().filter(|folder| *folder != Path::new(""));
    let scripts = beside_script.unwrap_or(Path::new(".")).canonicalize().ok();
    let scripts = scripts.filter(|folder| folder.file_name().is_some_and(|name| name == "scripts"));
    folders.extend(scripts.map(|folder| folder.with_file_name("data")));
    folders
}

/// What to say of a replay, and whether it is the same.
fn replay(
    archive: &Path,
    settings: Settings,
    tolerance: Option<f64>,
) -> Result<(String, bool), ScriptFault> {
    let root = settings.out;
    let experiment = archive::unpack(archive, &root)?;
    input::confine([root.as_path()])?;
    let out = root.join("out");
    let settings = Settings {
        out: out.clone(),
        read: vec![root.join("files")],
        arguments: experiment.arguments.clone(),
        cache: Cache::default(), // made again, all of it
        ..settings
    };
    end_when_stuck(settings.clone());
    script::run(&root.join(&experiment.script), settings)?;
    let replayed = archive::compare(&experiment, &root, &out)?;
    Ok((replayed.in_words(tolerance), replayed.is_same(tolerance)))
}

fn tolerance_from_text(text: &str) -> Result<f64, String> {
    let share = text.parse().ok().filter(|share| (0.0..1.0).contains(share));
    share.ok_or_else(|| "expected a share such as 1e-6, from 0 to below 1".to_owned())
}

/// Whatever becomes of names while a script runs, files are read in these folders only.
fn confine_reading(script: &Path, settings: &Settings) -> lampyris::Result<()> {
    let beside_script = script.parent().unwrap_or(Path::new(""));
    let known = [beside_script, Path::new("."), &settings.out];
    input::confine(known.into_iter().chain(settings.read.iter().map(PathBuf::as_path)))
}

/// How long an interrupted script may take to end: some calls of Lua's library never look up.
const PATIENCE: Duration = Duration::from_secs(3);

/// Ends the program some time after Ctrl-C if the script has not. Files are whole all the same:
/// they are written aside and renamed.
fn end_when_stuck(settings: Settings) {
    std::thread::spawn(move || {
        while !settings.interrupted.load(Ordering::Relaxed) {
            std::thread::sleep(Duration::from_millis(100));
        }
        std::thread::sleep(PATIENCE);
        eprintln!("{}", ScriptFault::interrupted().report(settings.verbosity));
        std::process::exit(i32::from(INTERRUPTED));
    });
}

fn exit_code(done: Result<(), Error>) -> ExitCode {
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(FAILED)
        }
    }
}

/// All files get their turn, whatever is wrong with some.
fn print_each(files: &[PathBuf], describe: impl Fn(&PathBuf) -> Result<String, Error>) -> ExitCode {
    let mut code = ExitCode::SUCCESS;
    for file in files {
        match describe(file) {
            Ok(text) if say(&text) == ExitCode::SUCCESS => {}
            Ok(_) => code = ExitCode::from(FAILED),
            Err(error) => code = exit_code(Err(error)),
        }
    }
    code
}

/// All files get their turn; the pictures are named as they are done.
fn develop(files: &[PathBuf], look: &Look, out: Option<&std::path::Path>) -> ExitCode {
    let results = match develop_files(files, look, out) {
        Ok(results) => results,
        Err(error) => return exit_code(Err(error)),
    };
    let mut code = ExitCode::SUCCESS;
    for result in results {
        match result {
            Ok((path, developed)) => {
                let exposure = developed.picture.exposure_factor;
                let said = say(&format!("{}: exposure {exposure}", path.display()));
                code = if said == ExitCode::SUCCESS { code } else { said };
            }
            Err(error) => code = exit_code(Err(error)),
        }
    }
    code
}

fn diff(a: &std::path::Path, b: &std::path::Path) -> ExitCode {
    match diff::between(a, b) {
        Ok(lines) => {
            if !lines.is_empty() {
                say(&lines.join("\n"));
            }
            ExitCode::from(if lines.is_empty() { 0 } else { FAILED })
        }
        Err(error) => exit_code(Err(error)),
    }
}

fn display_from_name(name: &str) -> Result<Display, String> {
    Display::named(name).ok_or_else(|| format!("expected one of {}", Display::NAMES.join(", ")))
}

fn look_from_name(name: &str) -> Result<Look, String> {
    Look::named(name).ok_or_else(|| format!("expected one of {}", Look::NAMES.join(", ")))
}

fn exposure_from_text(text: &str) -> Result<Exposure, String> {
    match text.parse::<f64>() {
        Ok(stops) if stops.abs() <= 100.0 => Ok(Exposure::Stops(stops)),
        _ if text == "auto" => Ok(Exposure::Auto),
        _ => Err("expected \"auto\", or stops from -100 to 100".to_owned()),
    }
}

fn verify(manifest: &std::path::Path, script: Option<&std::path::Path>) -> ExitCode {
    let found = match study::is_study(manifest) {
        true => study::verify(manifest, script),
        false => sweep::verify(manifest, script),
    };
    let report = match found {
        Ok(report) => report,
        Err(error) => return exit_code(Err(error)),
    };
    report.problems.iter().for_each(|problem| eprintln!("{problem}"));
    report.notes.iter().for_each(|note| eprintln!("note: {note}"));
    let said = say(&format!("{}: {} files are as they were", manifest.display(), report.good));
    if report.problems.is_empty() { said } else { ExitCode::from(FAILED) }
}

fn use_threads(threads: Option<u16>) -> Result<(), rayon::ThreadPoolBuildError> {
    let count = threads.map_or(0, usize::from); // 0: all cores
    rayon::ThreadPoolBuilder::new().num_threads(count).build_global()
}

/// `500M` and the like, in powers of 1000.
fn bytes_from_text(text: &str) -> Result<usize, String> {
    let units = [("K", 1_000), ("M", 1_000_000), ("G", 1_000_000_000)];
    let unit = units.iter().find_map(|&(unit, bytes)| Some((text.strip_suffix(unit)?, bytes)));
    let (digits, bytes) = unit.unwrap_or((text, 1));
    let count: Option<usize> = digits.parse().ok().filter(|&count| count > 0);
    let size = count.and_then(|count| count.checked_mul(bytes));
    size.ok_or_else(|| "expected a number of bytes, with K, M or G such as 500M".to_owned())
}

/// A flag that the first Ctrl-C sets; the second ends the program at once.
fn interrupted_by_ctrl_c() -> Arc<AtomicBool> {
    let flag = Arc::new(AtomicBool::new(false));
    let seen = Arc::clone(&flag);
    let installed = ctrlc::set_handler(move || {
        if seen.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(INTERRUPTED));
        }
    });
    if let Err(error) = installed {
        eprintln!("warning: Ctrl-C will not end the script cleanly: {error}");
    }
    flag
}
