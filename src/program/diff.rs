//! What differs between two folders of sweeps or studies, by name.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::error::{Error, Place, Result};
use crate::image::difference::ImageDifference;
use crate::output;
use crate::program::study;

/// Records that a folder may have, and the list in each whose entries have names.
const RECORDS: [(&str, &str); 2] = [("manifest.json", "views"), ("study.json", "")];

/// One line for each difference; none for folders that hold the same experiment.
///
/// Digests of pictures are not named by themselves: an image that differs is named with luminance,
/// ΔE00 and spectrum.
/// Errors: a folder without a record, records of two kinds, and files that do not read.
pub fn between(a: &Path, b: &Path) -> Result<Vec<String>> {
    let (name, list) = record_of(a)?;
    if record_of(b)?.0 != name {
        let problem =
            format!("{} is a sweep and {} a study, or the other way", a.display(), b.display());
        return Err(Error::inconsistent("diff", problem));
    }
    let [left, right] = [read(&a.join(name))?, read(&b.join(name))?];
    let mut lines = field_differences(&named(&left, list), &named(&right, list));
    match list {
        "" => lines.extend(table_differences(a, b)?),
        list => lines.extend(image_differences(a, b, &names(&left, list), &names(&right, list))?),
    }
    Ok(lines)
}

fn record_of(folder: &Path) -> Result<(&'static str, &'static str)> {
    let found = RECORDS.into_iter().find(|(name, _)| folder.join(name).exists());
    let none = || Error::bad_file(folder, Place::File, "holds no manifest.json and no study.json");
    found.ok_or_else(none)
}

fn read(path: &Path) -> Result<Value> {
    let text = fs::read_to_string(path).map_err(|e| Error::io(path, e))?;
    serde_json::from_str(&text).map_err(|e| Error::bad_file(path, Place::File, e.to_string()))
}

fn names(record: &Value, list: &str) -> BTreeSet<String> {
    let entries = record.get(list).and_then(Value::as_array).into_iter().flatten();
    entries.filter_map(|entry| entry.get("name")?.as_str().map(str::to_owned)).collect()
}

/// Every leaf of a record by its path; entries of lists by their name, path or object where they
/// have one, so that a view more shifts no others.
fn named(record: &Value, list: &str) -> BTreeMap<String, String> {
    let mut leaves = BTreeMap::new();
    collect("", record, &mut leaves);
    // The pictures themselves are compared, and what follows from others says nothing new.
    let follows = |path: &str| {
        path.starts_with("pages")
            || path == "sha256"
            || (!list.is_empty() && path.starts_with(list) && is_derived(path))
    };
    leaves.retain(|path, _| !follows(path));
    leaves
}

fn is_derived(path: &str) -> bool {
    let ends = [".key", ".picture_key", ".index", ".details.measured"];
    let holds = [".outputs[", ".pictures["];
    ends.iter().any(|end| path.ends_with(end)) || holds.iter().any(|part| path.contains(part))
}

fn collect(path: &str, value: &Value, leaves: &mut BTreeMap<String, String>) {
    let below = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
    match value {
        Value::Object(fields) => {
            fields.iter().for_each(|(key, value)| collect(&below(key), value, leaves));
        }
        Value::Array(entries) => {
            for (at, entry) in entries.iter().enumerate() {
                let name =
                    ["name", "path", "object"].into_iter().find_map(|key| entry.get(key)?.as_str());
                let name = name.map_or_else(|| (at + 1).to_string(), str::to_owned);
                collect(&format!("{path}[{name}]"), entry, leaves);
            }
        }
        leaf => {
            leaves.insert(path.to_owned(), leaf.to_string());
        }
    }
}

fn field_differences(a: &BTreeMap<String, String>, b: &BTreeMap<String, String>) -> Vec<String> {
    let paths: BTreeSet<&String> = a.keys().chain(b.keys()).collect();
    let line = |path: &String| match (a.get(path), b.get(path)) {
        (Some(left), Some(right)) if left == right => None,
        (Some(left), Some(right)) => Some(format!("{path}: {left} → {right}")),
        (Some(left), None) => Some(format!("{path}: only in the first, {left}")),
        (None, Some(right)) => Some(format!("{path}: only in the second, {right}")),
        (None, None) => None,
    };
    paths.into_iter().filter_map(line).collect()
}

fn image_differences(
    a: &Path,
    b: &Path,
    left: &BTreeSet<String>,
    right: &BTreeSet<String>,
) -> Result<Vec<String>> {
    let mut lines = Vec::new();
    for name in left.intersection(right) {
        let paths = [a, b].map(|folder| folder.join(format!("{name}.exr")));
        let bytes = |path: &Path| fs::read(path).map_err(|e| Error::io(path, e));
        if bytes(&paths[0])? == bytes(&paths[1])? {
            continue;
        }
        let images = [output::read_exr(&paths[0])?, output::read_exr(&paths[1])?];
        lines.push(match ImageDifference::between(&images[1], &images[0]) {
            Err(error) => format!("view {name}: {error}"),
            Ok(found) if found.worst == 0.0 && found.spectral_rms == 0.0 => {
                format!("view {name}: the same light, other metadata")
            }
            Ok(found) => format!(
                "view {name}: luminance differs by {:.3e} rms and {:.3e} at worst, ΔE00 by {:.3} in the \
                 mean and {:.3} in 95 % of pixels, spectra by {:.3e} rms",
                found.relative_rms,
                found.worst,
                found.mean_delta_e_2000,
                found.percentile_95_delta_e_2000,
                found.spectral_rms
            ),
        });
    }
    Ok(lines)
}

fn table_differences(a: &Path, b: &Path) -> Result<Vec<String>> {
    let [left, right] = [
        study::DrawTable::read(&a.join("draws.csv"))?,
        study::DrawTable::read(&b.join("draws.csv"))?,
    ];
    let mut lines = Vec::new();
    if left.columns != right.columns {
        lines.push(format!("columns: {} → {}", left.columns.join(", "), right.columns.join(", ")));
        return Ok(lines);
    }
    let right_rows: BTreeMap<usize, &Vec<f64>> = right.rows.iter().map(|(i, v)| (*i, v)).collect();
    let left_rows: BTreeMap<usize, &Vec<f64>> = left.rows.iter().map(|(i, v)| (*i, v)).collect();
    for index in left_rows.keys().chain(right_rows.keys()).collect::<BTreeSet<_>>() {
        match (left_rows.get(index), right_rows.get(index)) {
            (Some(one), Some(other)) => {
                let cells = left.columns.iter().zip(one.iter().zip(other.iter()));
                let differ = cells.filter(|(_, (x, y))| x.to_bits() != y.to_bits());
                lines.extend(
                    differ.map(|(name, (x, y))| format!("draw {index}: {name}: {x} → {y}")),
                );
            }
            (Some(_), None) => lines.push(format!("draw {index}: only in the first")),
            _ => lines.push(format!("draw {index}: only in the second")),
        }
    }
    Ok(lines)
}
