//! Joins the shards of a study, and checks a study that is there.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use super::run::{DRAWS, RECORD, Study, claim, shard_of_table, write_pages};
use super::table::DrawTable;
use crate::error::{Error, Place, Result};
use crate::output;
use crate::program::sweep::{Digest, FileDigest, Merged, Report, Shard, Source, fault};

/// Whether a folder holds a study, or shards of one.
pub fn is_study(folder: &Path) -> bool {
    folder.join(RECORD).exists()
}

/// A study's record: its text, and what that says.
fn record(folder: &Path) -> Result<(String, Value)> {
    let path = folder.join(RECORD);
    let text = fs::read_to_string(&path).map_err(|e| Error::io(&path, e))?;
    let not_one = |problem: String| Error::bad_file(&path, Place::File, problem);
    let value = serde_json::from_str(&text).map_err(|e| not_one(format!("not JSON: {e}")))?;
    Ok((text, value))
}

fn study_of(folder: &Path, record: &Value) -> Result<Study> {
    let problem = "is no record of a study";
    let none = || Error::bad_file(&folder.join(RECORD), Place::File, problem);
    let study = Study::from_record(record).ok_or_else(none)?;
    study.check()?;
    Ok(study)
}

/// What a record says that the draws were made from.
fn source_of(record: &Value) -> Source {
    let list = |key: &str| record.get(key).and_then(Value::as_array).into_iter().flatten();
    let mut read = list("read").filter_map(FileDigest::from_json);
    Source {
        program: record.get("program").and_then(Value::as_str).unwrap_or_default().to_owned(),
        executable: record.get("executable").and_then(Value::as_str).and_then(Digest::parse),
        build: record.get("build").cloned().unwrap_or_default(),
        arguments: list("arguments").filter_map(Value::as_str).map(str::to_owned).collect(),
        script: read.next(),
        inputs: read.collect(),
        seeds: Value::Null,
    }
}

/// Makes the whole study in `into` from the tables of its shards in `folders`: the bytes of one run.
///
/// Errors: shards that are missing, unfinished or of different studies, and what differs; a table
/// that does not read; [`Error::Io`].
pub fn merge(folders: &[PathBuf], into: &Path) -> Result<Merged> {
    let (text, value) = record(&folders[0])?;
    for folder in &folders[1..] {
        check_same(&folders[0], &value, folder)?;
    }
    let study = study_of(&folders[0], &value)?;
    let tables = tables(folders)?;
    if tables.is_empty() && folders.iter().all(|folder| folder == into) {
        let table = DrawTable::read(&into.join(DRAWS))?;
        check_complete(&study, &table)?;
        return Ok(Merged { moved: None, shards: 0, views: table.rows.len() });
    }
    let table = joined(&tables)?;
    check_complete(&study, &table)?;
    output::make_folder(into)?;
    let moved = claim(into, &text)?;
    output::write_text(&into.join(DRAWS), &table.to_csv())?;
    write_pages(into, &study, &source_of(&value), &table)?;
    for (_, path, _) in tables.iter().filter(|(_, path, _)| path.parent() == Some(into)) {
        fs::remove_file(path).map_err(|e| Error::io(path, e))?;
    }
    let moved = moved.map(|aside| format!("draws of another study are now in {}", aside.display()));
    Ok(Merged { moved, shards: tables.len(), views: table.rows.len() })
}

/// Says whether a study's table is whole and of its own design, and with `script` whether that and
/// its inputs are as they were.
///
/// Errors: a record or table that does not read.
pub fn verify(folder: &Path, script: Option<&Path>) -> Result<Report> {
    let (_, value) = record(folder)?;
    let study = study_of(folder, &value)?;
    let mut report = Report::default();
    let mut tables = tables(&[folder.to_owned()])?;
    if tables.is_empty() {
        let path = folder.join(DRAWS);
        tables.push((Shard { number: 1, count: 1 }, path.clone(), DrawTable::read(&path)?));
    }
    let table = joined(&tables).unwrap_or_default();
    match check_complete(&study, &table) {
        Ok(()) => report.good += 1,
        Err(problem) => report.problems.push(problem.to_string()),
    }
    if let Some(script) = script {
        report.check_source(&source_of(&value), script);
    }
    Ok(report)
}

/// Errors: another record, and which of its entries differ.
fn check_same(first: &Path, model: &Value, folder: &Path) -> Result<()> {
    let (_, other) = record(folder)?;
    let keys = model.as_object().into_iter().flatten().map(|(key, _)| key.as_str());
    let differ: Vec<&str> = keys.filter(|key| model.get(key) != other.get(key)).collect();
    if differ.is_empty() {
        return Ok(());
    }
    let (first, folder, differ) = (first.display(), folder.display(), differ.join(", "));
    Err(fault(format!("{first} and {folder} are of different studies: they differ in {differ}")))
}

/// The shards' tables, each once, with their files.
fn tables(folders: &[PathBuf]) -> Result<Vec<(Shard, PathBuf, DrawTable)>> {
    let mut tables = BTreeMap::new();
    for folder in folders {
        let io = |e| Error::io(folder, e);
        for entry in fs::read_dir(folder).map_err(io)? {
            let path = entry.map_err(io)?.path();
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            if let Some(shard) = shard_of_table(&name) {
                tables.entry(shard).or_insert((path.clone(), DrawTable::read(&path)?));
            }
        }
    }
    Ok(tables.into_iter().map(|(shard, (path, table))| (shard, path, table)).collect())
}

/// All draws, by their index. Errors: no shards, or of two ways to share out; other columns.
fn joined(tables: &[(Shard, PathBuf, DrawTable)]) -> Result<DrawTable> {
    let Some((first, _, model)) = tables.iter().find(|(_, _, table)| !table.rows.is_empty()) else {
        return Err(fault("no shards: expected folders with files such as draws.03-of-40.csv"));
    };
    let mut rows = BTreeMap::new();
    for (shard, _, table) in tables.iter().filter(|(_, _, table)| !table.rows.is_empty()) {
        if shard.count != first.count || table.columns != model.columns {
            return Err(fault(format!("shards {first} and {shard} are not of one study")));
        }
        rows.extend(table.rows.iter().cloned());
    }
    Ok(DrawTable { columns: model.columns.clone(), rows: rows.into_iter().collect() })
}

/// Errors: draws that are missing, or were made from other parameters than the design has.
fn check_complete(study: &Study, table: &DrawTable) -> Result<()> {
    let draws = study.draws();
    let made: BTreeSet<usize> = table.rows.iter().map(|(index, _)| *index).collect();
    let missing: Vec<usize> = (0..draws.count()).filter(|index| !made.contains(index)).collect();
    if let Some(first) = missing.first() {
        let (missing, all) = (missing.len(), draws.count());
        return Err(fault(format!(
            "{missing} of {all} draws are missing, the first is draw {first}"
        )));
    }
    for (index, values) in &table.rows {
        let drawn = study.values(&draws, *index);
        let is_same = |(value, (_, drawn)): (&f64, &(String, f64))| value == drawn;
        if *index >= draws.count() || !values.iter().zip(&drawn).all(is_same) {
            return Err(fault(format!("draw {index} is none of this study's")));
        }
    }
    Ok(())
}
