//! Progress on standard error, for people or machines, and Ctrl-C.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use serde_json::json;

use crate::render::Watch;

/// Who reads standard error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Verbosity {
    /// Nobody.
    #[default]
    Quiet,
    /// A person: a bar, if it is a terminal.
    Bar,
    /// A machine: one JSON object a line.
    Json,
}

/// Pixels done, the time that remains, and the memory in use.
pub struct Progress {
    verbosity: Verbosity,
    bar: ProgressBar,
    interrupted: Arc<AtomicBool>,
    start: Instant,
    /// Milliseconds after `start` of the last look at the memory, or of the last JSON line.
    last_report_ms: AtomicU64,
}

const REPORT_EVERY: Duration = Duration::from_secs(1);

impl Progress {
    /// For `pixels` in all; [`Progress::more_pixels`] adds to them.
    pub fn new(verbosity: Verbosity, interrupted: Arc<AtomicBool>, pixels: usize) -> Self {
        let target = match verbosity {
            Verbosity::Bar => ProgressDrawTarget::stderr(),
            Verbosity::Quiet | Verbosity::Json => ProgressDrawTarget::hidden(),
        };
        let bar = ProgressBar::with_draw_target(Some(pixels as u64), target);
        bar.set_style(style(if pixels > 0 { OF_ALL } else { OF_UNKNOWN }));
        bar.set_message("render");
        let (start, last_report_ms) = (Instant::now(), AtomicU64::new(0));
        Self { verbosity, bar, interrupted, start, last_report_ms }
    }

    /// Adds to the pixels in all.
    pub fn more_pixels(&self, count: usize) {
        self.bar.inc_length(count as u64);
    }

    /// Pixels that are there already: they are not waited for, and tell nothing of the time left.
    pub fn pixels_kept(&self, count: usize) {
        self.bar.dec_length(count as u64);
    }

    /// What came before the first pixel tells nothing of the time that pixels take.
    pub fn starts_rendering(&self) {
        if self.bar.position() == 0 {
            self.bar.reset_elapsed();
        }
    }

    /// Says which view is rendered now; `of` where the number of views is known.
    pub fn begin_view(&self, index: usize, of: Option<usize>) {
        let of_all = of.map_or_else(String::new, |of| format!(" of {of}"));
        self.bar.set_message(format!("view {index}{of_all}"));
        self.log(json!({ "event": "view", "view": index, "of": of }));
    }

    /// Says which draw of a study is made now.
    pub fn begin_draw(&self, index: usize, of: usize) {
        self.bar.set_message(format!("draw {index} of {of}"));
        self.log(json!({ "event": "draw", "draw": index, "of": of }));
    }

    /// One line of JSON, if machines read.
    fn log(&self, event: serde_json::Value) {
        if self.verbosity == Verbosity::Json {
            eprintln!("{event}");
        }
    }

    fn report(&self) {
        let memory = memory_bytes();
        if let Some(bytes) = memory {
            self.bar.set_prefix(format!(" · {:.1} GB", bytes as f64 / 1e9));
        }
        let (done, all) = (self.bar.position(), self.bar.length());
        self.log(json!({
            "event": "pixels",
            "done": done,
            "of": all,
            "seconds": self.start.elapsed().as_secs_f64(),
            "remaining_seconds": remaining(self.bar.elapsed(), done, all).map(|left| left.as_secs_f64()),
            "memory_bytes": memory,
        }));
    }

    /// Whether it is time for the next report; of many threads that ask, one is told so.
    fn is_due(&self) -> bool {
        let now = self.start.elapsed().as_millis() as u64;
        let last = self.last_report_ms.load(Ordering::Relaxed);
        let due = now >= last + REPORT_EVERY.as_millis() as u64;
        due && self
            .last_report_ms
            .compare_exchange(last, now, Ordering::Relaxed, Ordering::Relaxed)
            .is_ok()
    }
}

/// Of a job whose pixels are known.
const OF_ALL: &str =
    "{msg} {wide_bar} {percent:>3} % of {human_len} pixels · {elapsed} · {left}{prefix}";
/// Of one that says what comes only when it comes.
const OF_UNKNOWN: &str = "{msg} · {human_pos} pixels · {elapsed}{prefix}";

fn style(template: &str) -> ProgressStyle {
    let style = ProgressStyle::with_template(template);
    let style = style.unwrap_or_else(|_| ProgressStyle::default_bar());
    style.with_key("left", |state: &ProgressState, out: &mut dyn fmt::Write| {
        let left = remaining(state.elapsed(), state.pos(), state.len());
        // A string takes all that is written.
        let _ = match left {
            Some(left) => write!(out, "{} left", HumanDuration(left)),
            None => write!(out, "time left unknown"),
        };
    })
}

/// As long for each pixel that is left as for those that are done.
fn remaining(elapsed: Duration, done: u64, all: Option<u64>) -> Option<Duration> {
    let all = all.filter(|&all| done > 0 && all >= done)?;
    Some(elapsed.mul_f64((all - done) as f64 / done as f64))
}

impl Watch for Progress {
    fn pixels_done(&self, count: usize) {
        self.bar.inc(count as u64);
        if self.verbosity != Verbosity::Quiet && self.is_due() {
            self.report();
        }
    }

    fn expects(&self, seconds: f64) {
        self.bar.set_message(format!(
            "about {} more",
            HumanDuration(Duration::from_secs_f64(seconds.max(0.0)))
        ));
        self.log(json!({ "event": "expected", "remaining_seconds": seconds }));
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

/// Resident memory of the process, where the system tells (Linux).
fn memory_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib * 1024)
}
