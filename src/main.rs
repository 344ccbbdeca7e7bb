//! The command line.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use clap::{Parser, Subcommand};

use lampyris::progress::Verbosity;
use lampyris::script::{self, Settings};

/// Predicts what a lit lamp looks like and how bright it is, wavelength by wavelength.
#[derive(Debug, Parser)]
#[command(version)]
struct CommandLine {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Run a Lua script
    Run {
        script: PathBuf,
        /// Folder under which everything is written
        #[arg(long, value_name = "DIR", default_value = "out")]
        out: PathBuf,
        /// Threads to render with [default: all cores]
        #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
        threads: Option<u16>,
        /// No progress on standard error
        #[arg(long)]
        quiet: bool,
        /// Arguments for the script, after --
        #[arg(last = true)]
        arguments: Vec<String>,
    },
}

/// The script or its input failed.
const FAILED: u8 = 1;
/// Ctrl-C, as shells report it.
const INTERRUPTED: u8 = 130;

fn main() -> ExitCode {
    match CommandLine::parse().command {
        Command::Run { script, out, threads, quiet, arguments } => {
            if let Err(message) = use_threads(threads) {
                eprintln!("lampyris: {message}");
                return ExitCode::from(FAILED);
            }
            let verbosity = if quiet { Verbosity::Quiet } else { Verbosity::Bar };
            let interrupted = interrupted_by_ctrl_c();
            let settings = Settings { out, verbosity, arguments, interrupted };
            exit_code(script::run(&script, settings))
        }
    }
}

fn exit_code(done: Result<(), script::ScriptFault>) -> ExitCode {
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(fault) => {
            eprintln!("{fault}");
            ExitCode::from(if fault.interrupted { INTERRUPTED } else { FAILED })
        }
    }
}

fn use_threads(threads: Option<u16>) -> Result<(), rayon::ThreadPoolBuildError> {
    let count = threads.map_or(0, usize::from); // 0: all cores
    rayon::ThreadPoolBuilder::new().num_threads(count).build_global()
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
