//! Many views as one experiment: a folder that can be stopped, resumed, shared out and checked.
//!
//! [`Plan::run`]: `Folder::open → (kept, or render and add) for each view → finish`, which develops
//! the pictures of all views from their EXR files: a changed look renders nothing. Every file is written whole
//! or not at all, and a view counts only once the manifest names its outputs with their digests;
//! so a sweep that is killed at any moment goes on where it was, to the same bytes.
//!
//! A shard renders every n-th view into the same folder and writes a manifest of its own;
//! [`merge`] joins them. Seconds and other things that differ from run to run are kept apart, in
//! `timings.js`.

mod again;
mod contact_sheet;
mod digest;
mod fingerprint;
mod folder;
mod look_record;
mod luminance;
mod manifest;
mod merge;
mod page;
mod pictures;
mod plan;
mod program;
mod record;
mod shard;
mod timings;
mod verify;

pub use digest::{Digest, Hasher};
pub use fingerprint::of_scene;
pub use folder::MANIFEST;
pub use manifest::{Entry, FileDigest, Manifest, Source};
pub(in crate::program) use merge::fault;
pub use merge::{Merged, merge};
pub use pictures::{Pictures, Share};
pub use plan::{Plan, Shot, SweepOutcome, check_name};
pub use program::{LOCK_FILE, build, build_differences, executable, program};
pub use record::RegionReading;
pub use shard::Shard;
pub use verify::{Report, verify};
