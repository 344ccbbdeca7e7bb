//! The program on top of the renderer: Lua scripts, sweeps, figures, photometric files and rules.
//!
//! The feature `program` (a default) adds it; the renderer knows nothing of it.

pub mod archive;
pub mod cache;
pub mod develop;
pub mod diff;
pub mod fields;
pub mod figure;
pub mod info;
pub mod intensity;
pub mod memory;
pub mod progress;
pub mod results;
pub mod run_crate;
pub mod screen;
pub mod script;
pub mod stage;
pub mod stamp;
pub mod study;
pub mod sweep;
pub mod uncertainty;
pub mod watch;
