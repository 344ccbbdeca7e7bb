//! Checks an experiment against its manifest.

use std::path::Path;

use super::folder::{MANIFEST, manifest_names};
use super::manifest::{Entry, FileDigest, Manifest, Source};
use super::shard::Shard;
use crate::error::{Error, Place, Result};

/// What [`verify`] found.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Report {
    /// Files that are what the manifest says.
    pub good: usize,
    /// A line each, for people.
    pub problems: Vec<String>,
    /// What is no fault, but good to know.
    pub notes: Vec<String>,
}

/// Compares outputs, and where `script` is given the script and its inputs, with a manifest or with
/// all manifests of a folder: also of shards that are not merged yet.
///
/// Inputs are looked for as the script does: in its folder, then in the working directory.
/// Errors: a manifest that does not read.
pub fn verify(target: &Path, script: Option<&Path>) -> Result<Report> {
    let mut report = Report::default();
    if !target.is_dir() {
        report.check_manifest(target, script)?;
        return Ok(report);
    }
    let names = manifest_names(target)?;
    let shards: Vec<Shard> = names.iter().filter_map(|n| Shard::of_manifest_name(n)).collect();
    match (names.last().map(String::as_str), shards.first()) {
        (None, _) => {
            let problem = "holds no manifest of a sweep and no study";
            return Err(Error::bad_file(target, Place::File, problem));
        }
        (Some(MANIFEST), _) | (_, None) => report.check_manifest(&target.join(MANIFEST), script)?,
        (_, Some(first)) => {
            for name in &names {
                report.check_manifest(&target.join(name), script)?;
            }
            report.check_shards(*first, &shards);
        }
    }
    Ok(report)
}

impl Report {
    /// What `merge` would miss.
    fn check_shards(&mut self, first: Shard, shards: &[Shard]) {
        let all = (1..=first.count).map(|number| Shard { number, ..first });
        let missing: Vec<String> =
            all.filter(|shard| !shards.contains(shard)).map(|shard| shard.to_string()).collect();
        if missing.is_empty() {
            self.notes.push(format!("all {} shards are there: merge joins them", first.count));
        } else {
            self.problems.push(format!("missing shards: {}", missing.join(", ")));
        }
    }

    fn check_manifest(&mut self, manifest: &Path, script: Option<&Path>) -> Result<()> {
        let content = Manifest::read(manifest)?;
        let folder = manifest.parent().unwrap_or(Path::new(""));
        let report = self;
        if !content.is_complete {
            let name = manifest.display();
            report.problems.push(format!("{name}: not finished: run it again to go on"));
        }
        let outputs = content.views.iter().flat_map(Entry::files).chain(&content.pages);
        for file in outputs {
            report.check(file, &folder.join(&file.path));
        }
        if let Some(script) = script {
            report.check_source(&content.source, script);
        }
        Ok(())
    }

    /// Whether script and inputs are what the record says, and the program too.
    pub(in crate::program) fn check_source(&mut self, source: &Source, script: &Path) {
        if let Some(file) = &source.script {
            self.check(file, script);
        }
        let folder = script.parent().unwrap_or(Path::new(""));
        for file in &source.inputs {
            let beside = folder.join(&file.path);
            let path = if beside.exists() { beside } else { file.path.clone().into() };
            self.check(file, &path);
        }
        let program = super::program();
        let differences = super::build_differences(&source.made_by());
        if source.program != program {
            self.problems.extend(differences);
        } else if !differences.is_empty() {
            let note = format!(
                "made by another build of {program}: this one would render all views again"
            );
            self.notes.push(note);
            self.notes.extend(differences);
        }
    }

    fn check(&mut self, expected: &FileDigest, path: &Path) {
        match super::Digest::of_file(path) {
            Ok(digest) if digest == expected.digest => self.good += 1,
            Ok(_) => self.problems.push(format!("{}: content has changed", path.display())),
            Err(error) => self.problems.push(error.to_string()),
        }
    }
}
