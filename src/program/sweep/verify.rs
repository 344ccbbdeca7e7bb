//! Checks an experiment against its manifest.

use std::path::Path;

use super::manifest::{Entry, FileDigest, Manifest};
use crate::error::Result;

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

/// Compares outputs, and where `script` is given the script and its inputs, with `manifest`.
///
/// Inputs are looked for as the script does: in its folder, then in the working directory.
/// Errors: a manifest that does not read.
pub fn verify(manifest: &Path, script: Option<&Path>) -> Result<Report> {
    let content = Manifest::read(manifest)?;
    let folder = manifest.parent().unwrap_or(Path::new(""));
    let mut report = Report::default();
    if !content.is_complete {
        report.problems.push("the sweep is not finished: run it again to go on".to_owned());
    }
    let outputs = content.views.iter().flat_map(Entry::files).chain(&content.pages);
    for file in outputs {
        report.check(file, &folder.join(&file.path));
    }
    if let Some(script) = script {
        report.check_source(&content, script);
    }
    Ok(report)
}

impl Report {
    fn check_source(&mut self, manifest: &Manifest, script: &Path) {
        if let Some(file) = &manifest.source.script {
            self.check(file, script);
        }
        let folder = script.parent().unwrap_or(Path::new(""));
        for file in &manifest.source.inputs {
            let beside = folder.join(&file.path);
            let path = if beside.exists() { beside } else { file.path.clone().into() };
            self.check(file, &path);
        }
        let program = super::program();
        let differences = super::build_differences(&manifest.source.made_by());
        if manifest.source.program != program {
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
