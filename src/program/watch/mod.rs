//! Runs a script again whenever it, a module or an input changes, and shows its pictures in a
//! browser.

mod server;

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use crate::error::{Error, Result};
use crate::program::screen::{Screen, Status};
use crate::program::script::{self, Kept, Reads, ScriptFault, Settings};
use crate::program::stamp::Stamp;

/// Between two looks at the files: no person notices, and no machine minds.
const LOOK_EVERY: Duration = Duration::from_millis(20);

/// Runs `script` until Ctrl-C; its page is served at `port` of this machine only, 0 for any that is
/// free. `say` is told where the page is, and what went wrong in each run.
///
/// Errors: a port that cannot be had; Ctrl-C. Faults of the script are shown, and end nothing.
pub fn watch(script: &Path, settings: Settings, port: u16, say: impl Fn(&str)) -> Result<()> {
    let screen = Arc::new(Screen::default());
    let address = server::serve(Arc::clone(&screen), port)?;
    say(&format!("http://{address}/ shows {}; Ctrl-C ends", script.display()));
    let interrupted = Arc::clone(&settings.interrupted);
    let (kept, shown) = (Some(Arc::new(Kept::default())), Some(Arc::clone(&screen)));
    let settings = Settings { kept, screen: shown, ..settings };
    while !interrupted.load(Ordering::Relaxed) {
        let files = Files { of_script: Stamp::of(script).ok(), script, read: Reads::default() };
        screen.begin_run();
        match run(&files, settings.clone()) {
            Ok(()) => screen.end_run(Status::Done),
            Err(fault) if fault.interrupted => {}
            Err(fault) => {
                say(&fault.message);
                screen.end_run(Status::Failed(fault.message));
            }
        }
        while !interrupted.load(Ordering::Relaxed) && !files.have_changed() {
            std::thread::sleep(LOOK_EVERY);
        }
    }
    Err(Error::Interrupted)
}

/// What a run reads, as it was when it was read.
struct Files<'a> {
    script: &'a Path,
    of_script: Option<Stamp>,
    read: Reads,
}

impl Files<'_> {
    /// A file that is gone will come back: editors put new files in the place of old ones.
    fn have_changed(&self) -> bool {
        let is_new = Stamp::of(self.script).is_ok_and(|now| Some(now) != self.of_script);
        is_new || self.read.have_changed()
    }
}

/// One run, which ends early if a file that it has read changes.
fn run(files: &Files, settings: Settings) -> std::result::Result<(), ScriptFault> {
    let (stop, is_over) = (Arc::new(AtomicBool::new(false)), AtomicBool::new(false));
    let interrupted = Arc::clone(&settings.interrupted);
    let settings =
        Settings { interrupted: Arc::clone(&stop), reads: files.read.clone(), ..settings };
    std::thread::scope(|scope| {
        let guard = scope.spawn(|| {
            while !is_over.load(Ordering::Relaxed) {
                if interrupted.load(Ordering::Relaxed) || files.have_changed() {
                    return stop.store(true, Ordering::Relaxed);
                }
                std::thread::park_timeout(LOOK_EVERY);
            }
        });
        let done = script::run(files.script, settings);
        is_over.store(true, Ordering::Relaxed);
        guard.thread().unpark();
        done
    })
}
