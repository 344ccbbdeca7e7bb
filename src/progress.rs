//! A progress bar on standard error, and Ctrl-C.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::render::Watch;

/// Shows pixels done and the time that remains; silent where standard error is no terminal.
pub struct Progress {
    bar: ProgressBar,
    interrupted: Arc<AtomicBool>,
}

/// Whether a person wants to see progress.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verbosity {
    Quiet,
    Bar,
}

impl Progress {
    pub fn new(verbosity: Verbosity, interrupted: Arc<AtomicBool>, pixels: usize) -> Self {
        let target = match verbosity {
            Verbosity::Quiet => ProgressDrawTarget::hidden(),
            Verbosity::Bar => ProgressDrawTarget::stderr(),
        };
        let template = "render {wide_bar} {percent:>3} % · {elapsed} · {eta} left";
        let style =
            ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
        let bar = ProgressBar::with_draw_target(Some(pixels as u64), target).with_style(style);
        Self { bar, interrupted }
    }
}

impl Watch for Progress {
    fn pixels_done(&self, count: usize) {
        self.bar.inc(count as u64);
    }

    fn is_cancelled(&self) -> bool {
        self.interrupted.load(Ordering::Relaxed)
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
