//! The built program, as people and machines run it.

mod bench;
mod sandbox;
mod sweep;
