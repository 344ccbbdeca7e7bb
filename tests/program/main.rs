//! The built program, as people and machines run it.

mod archive;
mod attacks;
mod bench;
mod cache;
mod diff;
mod inputs;
mod language;
mod manual;
mod mistakes;
mod pictures;
mod sandbox;
mod study;
mod sweep;
mod uncertainty;
mod watch;
