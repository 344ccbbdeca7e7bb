//! Runs a study: each draw that is not in its table yet, until all are.

use std::path::{Path, PathBuf};

use serde_json::{Map, Value, json};

use super::design::{Design, Draws, MOST_DRAWS, MOST_PARAMETERS};
use super::distribution::Distribution;
use super::page;
use super::sensitivity::{Sensitivity, sensitivity};
use super::table::{DrawTable, Writer};
use crate::error::{Error, Result};
use crate::output;
use crate::program::run_crate::RunCrate;
use crate::program::sweep::{Digest, FileDigest, Shard, Source};

/// A parameter and how it varies.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Letters, digits and `_`, a column's name.
    pub name: String,
    /// Its values.
    pub distribution: Distribution,
}

/// What is drawn, from what, and how often.
#[derive(Debug, Clone, PartialEq)]
pub struct Study {
    /// In the order of their names.
    pub parameters: Vec<Parameter>,
    /// How draws are spread.
    pub design: Design,
    /// At most this many draws.
    pub samples: usize,
    /// Another seed gives other draws of the same kind.
    pub seed: u64,
    /// The draws that are this run's; `None` for all.
    pub shard: Option<Shard>,
}

/// What a study did.
#[derive(Debug, Clone, PartialEq)]
pub struct StudyOutcome {
    /// All of it that is there, by draw.
    pub table: DrawTable,
    /// Draws that this run made.
    pub made: usize,
    /// Where the draws of another study lie now that stood in the folder.
    pub moved: Option<PathBuf>,
}

/// Name of a whole study's table.
pub const DRAWS: &str = "draws.csv";
/// Name of a study's record, beside its table.
pub const RECORD: &str = "study.json";

impl Study {
    /// Errors: [`Error::OutOfRange`] for too many or no draws or parameters, for a name that is no
    /// column's, and for a distribution without spread.
    pub fn check(&self) -> Result<()> {
        let refuse = |what: &str, value: usize, most: usize| {
            Err(Error::out_of_range("study", what, value, format!("1 to {most}")))
        };
        if !(1..=MOST_DRAWS).contains(&self.samples) {
            return refuse("\"samples\"", self.samples, MOST_DRAWS);
        }
        if !(1..=MOST_PARAMETERS).contains(&self.parameters.len()) {
            return refuse("number of parameters", self.parameters.len(), MOST_PARAMETERS);
        }
        for Parameter { name, distribution } in &self.parameters {
            check_column("parameter", name)?;
            distribution.check(name)?;
        }
        Ok(())
    }

    /// The draws of this design.
    pub fn draws(&self) -> Draws {
        Draws::new(self.design, &self.distributions(), self.samples, self.seed)
    }

    /// Values of the parameters in draw `index` (from 0).
    pub fn values(&self, draws: &Draws, index: usize) -> Vec<(String, f64)> {
        let value = |(at, parameter): (usize, &Parameter)| {
            (parameter.name.clone(), parameter.distribution.quantile(draws.share(index, at)))
        };
        self.parameters.iter().enumerate().map(value).collect()
    }

    /// What the variance of `values`, one a row of `table`, comes from.
    ///
    /// Errors: as [`sensitivity`].
    pub fn sensitivity(&self, table: &DrawTable, values: &[f64]) -> Result<Sensitivity> {
        let draws = self.draws();
        let shares: Vec<Vec<f64>> = table
            .rows
            .iter()
            .map(|(index, _)| (0..self.parameters.len()).map(|p| draws.share(*index, p)).collect())
            .collect();
        sensitivity(&self.distributions(), &shares, values)
    }

    fn distributions(&self) -> Vec<Distribution> {
        self.parameters.iter().map(|p| p.distribution.clone()).collect()
    }

    /// Makes the draws that `folder` does not hold yet; `run` turns parameters into results.
    ///
    /// Draws of another study (other parameters, script or program) are moved aside, not mixed in.
    /// A run that is stopped goes on where it was, to the same bytes. `begin` is told how many draws
    /// of this run are made, and of how many.
    /// Errors: as [`Study::check`] and of `run`; a result of a parameter's name, or not finite.
    pub fn run<E: From<Error>>(
        &self,
        folder: &Path,
        source: &Source,
        mut begin: impl FnMut(usize, usize),
        mut run: impl FnMut(&[(String, f64)]) -> std::result::Result<Vec<(String, f64)>, E>,
    ) -> std::result::Result<StudyOutcome, E> {
        self.check()?;
        let moved = claim(folder, &self.record_text(source))?;
        let draws = self.draws();
        let mut writer = Writer::open(&folder.join(self.table_name()))?;
        let mut is_made = vec![false; draws.count()];
        writer.table().rows.iter().filter(|(i, _)| *i < draws.count()).for_each(|(index, _)| {
            is_made[*index] = true;
        });
        let missing: Vec<usize> = self.own_draws().filter(|&index| !is_made[index]).collect();
        for (made, &index) in missing.iter().enumerate() {
            begin(made, missing.len());
            let mut cells = self.values(&draws, index);
            let results = run(&cells)?;
            for (name, _) in &results {
                self.check_result(name)?;
            }
            cells.extend(results);
            writer.add(index, cells)?;
        }
        let table = writer.into_table();
        if table.rows.len() == draws.count() {
            write_pages(folder, self, source, &table)?;
        }
        Ok(StudyOutcome { table, made: missing.len(), moved })
    }

    /// Indices of the draws that are this run's to make.
    pub fn own_draws(&self) -> impl Iterator<Item = usize> {
        let shard = self.shard;
        (0..self.draws().count()).filter(move |i| shard.is_none_or(|shard| shard.has(i + 1)))
    }

    /// The draws of this run that `folder` holds already. Errors: as [`Self::run`].
    pub fn made(&self, folder: &Path, source: &Source) -> Result<DrawTable> {
        let known = std::fs::read_to_string(folder.join(RECORD)).ok();
        match known.as_deref() == Some(self.record_text(source).as_str()) {
            true => DrawTable::read(&folder.join(self.table_name())),
            false => Ok(DrawTable::default()),
        }
    }

    fn check_result(&self, name: &str) -> Result<()> {
        check_column("result", name)?;
        if self.parameters.iter().any(|parameter| parameter.name == name) {
            let problem = format!("\"{name}\" is the name of a parameter and of a result");
            return Err(Error::inconsistent("study", problem));
        }
        Ok(())
    }

    /// Name of the file with this run's draws.
    fn table_name(&self) -> String {
        match self.shard {
            None => DRAWS.to_owned(),
            Some(shard) => {
                shard.manifest_name().replace("manifest.", "draws.").replace("json", "csv")
            }
        }
    }

    /// What the draws depend on.
    fn record_text(&self, source: &Source) -> String {
        let file = |file: &FileDigest| json!({ "path": file.path, "sha256": file.digest.as_str() });
        let parameters: Map<String, Value> =
            self.parameters.iter().map(|p| (p.name.clone(), p.distribution.record())).collect();
        let record = json!({
            "format": FORMAT,
            "parameters": parameters,
            "design": format!("{:?}", self.design),
            "samples": self.samples,
            "seed": self.seed,
            "program": source.program,
            "executable": source.executable.as_ref().map(Digest::as_str),
            "build": source.build,
            "arguments": source.arguments,
            "read": source.script.iter().chain(&source.inputs).map(file).collect::<Vec<_>>(),
        });
        format!("{record:#}\n")
    }

    /// The study that a record tells of; `None` if it is none.
    pub(super) fn from_record(record: &Value) -> Option<Self> {
        if record.get("format")?.as_str() != Some(FORMAT) {
            return None;
        }
        let parameter = |(name, spread): (&String, &Value)| {
            Some(Parameter { name: name.clone(), distribution: Distribution::from_record(spread)? })
        };
        let parameters = record.get("parameters")?.as_object()?.iter().map(parameter);
        let name = record.get("design")?.as_str()?;
        let designs = [Design::Sobol, Design::LatinHypercube, Design::Grid];
        Some(Self {
            parameters: parameters.collect::<Option<_>>()?,
            design: designs.into_iter().find(|design| format!("{design:?}") == name)?,
            samples: usize::try_from(record.get("samples")?.as_u64()?).ok()?,
            seed: record.get("seed")?.as_u64()?,
            shard: None,
        })
    }
}

/// What people and other programs read of a whole study.
pub(super) fn write_pages(
    folder: &Path,
    study: &Study,
    source: &Source,
    table: &DrawTable,
) -> Result<()> {
    page::write(folder, study, table)?;
    let results = [DRAWS, "index.html"].map(str::to_owned).to_vec();
    let others = vec![RECORD.to_owned()];
    RunCrate { kind: "Study", source, results, others }.write(folder)
}

/// The only format so far.
const FORMAT: &str = "lampyris study 1";

/// The part of a study whose draws a file of this name holds.
pub(super) fn shard_of_table(name: &str) -> Option<Shard> {
    let name = name.strip_prefix("draws.")?.strip_suffix(".csv")?;
    Shard::of_manifest_name(&format!("manifest.{name}.json"))
}

/// Sets a folder up for the study of this record; tells where another's draws went.
pub(super) fn claim(folder: &Path, text: &str) -> Result<Option<PathBuf>> {
    let path = folder.join(RECORD);
    let known = std::fs::read_to_string(&path).ok();
    if known.as_deref() == Some(text) {
        return Ok(None);
    }
    let moved = known.map(|known| set_aside(folder, &known)).transpose()?;
    output::write_text(&path, text)?;
    Ok(moved)
}

/// Moves a study's record and tables into a folder of its own, named by its content.
fn set_aside(folder: &Path, record: &str) -> Result<PathBuf> {
    let name = Digest::of_bytes(record.as_bytes());
    let aside = folder.join(format!("earlier-{}", &name.as_str()[..12]));
    let io = |e| Error::io(&aside, e);
    std::fs::create_dir_all(&aside).map_err(io)?;
    for entry in std::fs::read_dir(folder).map_err(io)? {
        let path = entry.map_err(io)?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if name == RECORD || (name.starts_with("draws.") && name.ends_with(".csv")) {
            std::fs::rename(&path, aside.join(&name)).map_err(io)?;
        }
    }
    Ok(aside)
}

/// Names become columns of a table.
fn check_column(what: &str, name: &str) -> Result<()> {
    let plain = name.chars().all(|c| c.is_alphanumeric() || c == '_' || c == '.');
    if plain && !name.is_empty() && name != "draw" {
        return Ok(());
    }
    let allowed = "letters, digits, \"_\" and \".\", not \"draw\"";
    Err(Error::out_of_range("study", &format!("name of a {what}"), format!("\"{name}\""), allowed))
}

impl Distribution {
    /// As the script gives it.
    fn record(&self) -> Value {
        match self {
            Self::Normal { mean, sd } => json!({ "normal": [mean, sd] }),
            Self::Uniform { low, high } => json!({ "uniform": [low, high] }),
            Self::List(values) => json!({ "list": values }),
        }
    }

    fn from_record(record: &Value) -> Option<Self> {
        let numbers = |key: &str| -> Option<Vec<f64>> {
            record.get(key)?.as_array()?.iter().map(Value::as_f64).collect()
        };
        let pair = |key: &str| <[f64; 2]>::try_from(numbers(key)?).ok();
        let normal = pair("normal").map(|[mean, sd]| Self::Normal { mean, sd });
        let uniform = pair("uniform").map(|[low, high]| Self::Uniform { low, high });
        normal.or(uniform).or(numbers("list").map(Self::List))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::scratch::ScratchFolder;

    fn study(samples: usize) -> Study {
        let parameter =
            |name: &str, distribution| Parameter { name: name.to_owned(), distribution };
        Study {
            parameters: vec![
                parameter("flux", Distribution::Uniform { low: 391.0, high: 529.0 }),
                parameter("shift", Distribution::Normal { mean: 0.0, sd: 0.15 }),
            ],
            design: Design::Sobol,
            samples,
            seed: 3,
            shard: None,
        }
    }

    fn results(cells: &[(String, f64)]) -> Result<Vec<(String, f64)>> {
        Ok(vec![("i0".to_owned(), cells[0].1 * (1.0 - cells[1].1.powi(2)))])
    }

    fn files(folder: &Path) -> Vec<(String, Vec<u8>)> {
        let mut files: Vec<_> = std::fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .filter(|path| path.is_file())
            .map(|path| {
                (
                    path.file_name().unwrap().to_string_lossy().into_owned(),
                    std::fs::read(&path).unwrap(),
                )
            })
            .collect();
        files.sort();
        files
    }

    /// Ten times stopped by an error of its run, it ends with the bytes of an unbroken one.
    #[test]
    fn stopped_studies_go_on_to_the_same_bytes() {
        let (whole, broken) = (ScratchFolder::new(), ScratchFolder::new());
        let source = Source::default();
        study(32).run(&whole.path(""), &source, |_, _| {}, results).unwrap();
        for stop in 0..10 {
            let mut left = 3;
            let stopped = study(32).run(
                &broken.path(""),
                &source,
                |_, _| {},
                |cells| {
                    left -= 1;
                    if left < 0 { Err(Error::Interrupted) } else { results(cells) }
                },
            );
            assert!(stopped.is_err(), "{stop}");
        }
        let last = study(32).run(&broken.path(""), &source, |_, _| {}, results).unwrap();
        assert_eq!(last.made, 2);
        assert_eq!(files(&broken.path("")), files(&whole.path("")));
    }

    #[test]
    fn draws_of_another_study_are_moved_aside() {
        let scratch = ScratchFolder::new();
        let folder = scratch.path("");
        let source = Source::default();
        study(8).run(&folder, &source, |_, _| {}, results).unwrap();
        let other = study(16).run(&folder, &source, |_, _| {}, results).unwrap();
        assert_eq!(other.made, 16);
        assert!(other.moved.unwrap().join("draws.csv").exists());
        assert_eq!(study(16).run(&folder, &source, |_, _| {}, results).unwrap().made, 0);
    }

    #[test]
    fn shards_make_the_draws_of_the_whole() {
        let scratch = ScratchFolder::new();
        let whole = study(10).run(&scratch.path("whole"), &Source::default(), |_, _| {}, results);
        let mut rows = Vec::new();
        for number in 1..=3 {
            let shard = Study { shard: Some(Shard { number, count: 3 }), ..study(10) };
            let part = shard.run(&scratch.path("parts"), &Source::default(), |_, _| {}, results);
            rows.extend(part.unwrap().table.rows);
        }
        rows.sort_by_key(|(index, _)| *index);
        assert_eq!(rows, whole.unwrap().table.rows);
    }

    #[test]
    fn bad_names_are_refused() {
        let mut bad = study(4);
        bad.parameters[0].name = "a,b".to_owned();
        assert_eq!(
            bad.check().unwrap_err().to_string(),
            "study: name of a parameter is \"a,b\", allowed: letters, digits, \"_\" and \".\", not \"draw\""
        );
        let scratch = ScratchFolder::new();
        let same = study(4).run(
            &scratch.path(""),
            &Source::default(),
            |_, _| {},
            |_| Ok::<_, Error>(vec![("flux".to_owned(), 1.0)]),
        );
        let message = "study: \"flux\" is the name of a parameter and of a result";
        assert_eq!(same.unwrap_err().to_string(), message);
        assert!(study(0).check().is_err());
        assert!(study(MOST_DRAWS + 1).check().is_err());
    }
}
