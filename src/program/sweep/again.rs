//! Why a view is rendered, and what that leaves of an earlier sweep.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use serde_json::{Map, Value};

use super::manifest::Entry;

/// What a view's image depends on, as manifests tell it, and what is said if that has changed.
const CAUSES: [(&str, &str); 3] = [
    ("scene", "the scene has changed"),
    ("view", "the view has changed"),
    ("quality", "the quality has changed"),
];

/// Why a view that an earlier run made is rendered again; `asked` is what it is made from now.
pub(super) fn cause(entry: &Entry, folder: &Path, asked: &Map<String, Value>) -> &'static str {
    let differs = |key: &&str| entry.details.get(*key) != asked.get(*key);
    let changed = CAUSES.iter().find(|(key, _)| differs(key));
    match changed {
        Some((_, cause)) => cause,
        None if !entry.is_whole(folder) => "its image is missing or not as it was written",
        None => "the program or the script's name has changed",
    }
}

/// One sentence for each cause, of `(view, cause)`.
pub(super) fn sentences(again: &[(String, &'static str)]) -> Vec<String> {
    let mut by_cause: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    again.iter().for_each(|(view, cause)| by_cause.entry(cause).or_default().push(view));
    let sentence = |(cause, views): (&str, Vec<&str>)| {
        format!("sweep: rendered again, since {cause}: {}", some_of(&views))
    };
    by_cause.into_iter().map(sentence).collect()
}

/// The first few names, and how many more.
pub(super) fn some_of(names: &[&str]) -> String {
    const SHOWN: usize = 5;
    let mut text = names[..names.len().min(SHOWN)].join(", ");
    if names.len() > SHOWN {
        let _ = write!(text, " and {} more", names.len() - SHOWN); // writing to a string cannot fail
    }
    text
}
