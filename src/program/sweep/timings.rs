//! Seconds a view took: the one thing about a sweep that differs from run to run.
//!
//! Kept as a script that the page reads if it is there, so that the page itself does not change.

use std::collections::BTreeMap;
use std::path::Path;

use super::folder::{file_names, remove};
use super::shard::Shard;
use crate::error::Result;
use crate::output;

/// What the page's script calls the table.
const BEFORE: &str = "const lampyrisTimings = ";
const AFTER: &str = ";\n";
const WHOLE: &str = "timings.js";

pub(super) fn name(shard: Option<Shard>) -> String {
    match shard {
        None => WHOLE.to_owned(),
        Some(shard) => shard.manifest_name().replace("manifest.", "timings.").replace("json", "js"),
    }
}

/// Earlier seconds, as far as they are known; they are a courtesy, so that no fault is reported.
pub(super) fn read(folder: &Path, shard: Option<Shard>) -> BTreeMap<String, f64> {
    let text = std::fs::read_to_string(folder.join(name(shard))).unwrap_or_default();
    let table = text.strip_prefix(BEFORE).and_then(|text| text.strip_suffix(AFTER));
    let value: serde_json::Value =
        table.and_then(|table| serde_json::from_str(table).ok()).unwrap_or_default();
    let rows = value.as_object().into_iter().flatten();
    rows.filter_map(|(view, seconds)| Some((view.clone(), seconds.as_f64()?))).collect()
}

pub(super) fn write(
    folder: &Path,
    shard: Option<Shard>,
    seconds: &BTreeMap<String, f64>,
) -> Result<()> {
    let rounded = |s: f64| (s * 1000.0).round() / 1000.0;
    let rows: serde_json::Map<_, _> =
        seconds.iter().map(|(view, &s)| (view.clone(), rounded(s).into())).collect();
    let table = serde_json::Value::from(rows);
    output::write_text(&folder.join(name(shard)), &format!("{BEFORE}{table:#}{AFTER}"))
}

pub(super) fn remove_of_shards(folder: &Path) -> Result<()> {
    let names = file_names(folder)?;
    let of_shard = |name: &&String| {
        let manifest = name.strip_prefix("timings.").and_then(|n| n.strip_suffix(".js"));
        manifest.is_some_and(|n| Shard::of_manifest_name(&format!("manifest.{n}.json")).is_some())
    };
    names.iter().filter(of_shard).try_for_each(|name| remove(&folder.join(name)))
}
