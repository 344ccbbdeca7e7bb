//! Ray files: every format reads the same rays, refuses what is broken, and survives anything.

mod formats;
mod mutations;
#[path = "../common/random.rs"]
mod random;
mod real_inputs;
mod refusals;
mod round_trip;
mod seeds;
mod start_points;
