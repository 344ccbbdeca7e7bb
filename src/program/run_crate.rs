//! A folder's record for other programs: a Process Run Crate 0.5, which is an RO-Crate 1.1.
//!
//! It says once more, in JSON-LD, what `manifest.json` and `study.json` say. Nothing in it tells of
//! when or where: the same experiment makes the same bytes.

use std::fmt::Write;
use std::path::Path;

use serde_json::{Map, Value, json};

use super::sweep::{FileDigest, Source};
use crate::error::Result;
use crate::output;

/// Name of the record.
pub const RUN_CRATE: &str = "ro-crate-metadata.json";

/// What is said of a folder.
pub struct RunCrate<'a> {
    /// What the folder is, in a word or two.
    pub kind: &'a str,
    /// What it was made from.
    pub source: &'a Source,
    /// What the run made, by name.
    pub results: Vec<String>,
    /// Other files of the folder.
    pub others: Vec<String>,
}

/// Until the program has a home on the web; RFC 2606 keeps such names free.
const PROGRAM: &str = "https://lampyris.invalid/";
const PROFILE: &str = "https://w3id.org/ro/wfrun/process/0.5";

impl RunCrate<'_> {
    /// Writes the record into `folder`, whole or not at all. Errors: [`crate::Error::Io`].
    pub fn write(&self, folder: &Path) -> Result<()> {
        let context = "https://w3id.org/ro/crate/1.1/context";
        let record = json!({ "@context": context, "@graph": self.graph() });
        output::write_text(&folder.join(RUN_CRATE), &format!("{record:#}\n"))
    }

    fn graph(&self) -> Vec<Value> {
        let script = self.source.script.as_ref().map_or("a prompt", |script| script.path.as_str());
        let name = format!("{} of {script}", self.kind);
        let files: Vec<&String> = self.results.iter().chain(&self.others).collect();
        let inputs: Vec<&FileDigest> =
            self.source.script.iter().chain(&self.source.inputs).collect();
        let mut graph = vec![
            json!({
                "@id": RUN_CRATE, "@type": "CreativeWork",
                "conformsTo": { "@id": "https://w3id.org/ro/crate/1.1" }, "about": { "@id": "./" },
            }),
            with_list(
                json!({
                    "@id": "./", "@type": "Dataset", "name": name,
                    "description": format!("Made by {} from {script}.", self.source.program),
                    "conformsTo": { "@id": PROFILE },
                    "datePublished": date(), "license": { "@id": "#license" },
                    "author": { "@id": "#operator" }, "publisher": { "@id": "#operator" },
                    "mentions": { "@id": "#run" },
                }),
                "hasPart",
                files.iter().map(|file| uri(file)),
            ),
            json!({
                "@id": PROFILE, "@type": "CreativeWork", "name": "Process Run Crate", "version": "0.5",
            }),
            json!({
                "@id": "#license", "@type": "CreativeWork", "name": "No license is stated",
                "description": "Ask whoever ran the script.",
            }),
            json!({
                "@id": "#operator", "@type": "Organization", "name": "Whoever ran the script",
                "url": "#operator",
            }),
            self.program(),
            self.run(&name, inputs.len()),
        ];
        graph.extend((1..).zip(inputs).map(|(number, file)| input(number, file)));
        graph.extend(files.into_iter().map(|file| part(file)));
        graph
    }

    fn program(&self) -> Value {
        let (name, version) = self.source.program.split_once(' ').unwrap_or_default();
        let mut program = json!({
            "@id": format!("{PROGRAM}{version}"), "@type": "SoftwareApplication",
            "name": name, "softwareVersion": version, "url": PROGRAM,
        });
        if let Some(executable) = &self.source.executable {
            program["identifier"] = json!(format!("sha256:{executable}"));
        }
        program
    }

    fn run(&self, name: &str, inputs: usize) -> Value {
        let version = self.source.program.split_once(' ').unwrap_or_default().1;
        let arguments = self.source.arguments.join(" ");
        let run = json!({
            "@id": "#run", "@type": "CreateAction", "name": name,
            "description": format!(
                "lampyris run, with the script's arguments \"{arguments}\". Dates are not recorded, so that \
                 equal runs are equal files: 1970-01-01 or what SOURCE_DATE_EPOCH says stands for them."
            ),
            "instrument": { "@id": format!("{PROGRAM}{version}") },
            "agent": { "@id": "#operator" }, "endTime": date(),
        });
        let run = with_list(run, "object", (1..=inputs).map(input_id));
        with_list(run, "result", self.results.iter().map(|file| uri(file)))
    }
}

/// References under a key: one alone is no list.
fn with_list(mut entity: Value, key: &str, ids: impl Iterator<Item = String>) -> Value {
    let mut references: Vec<Value> = ids.map(|id| json!({ "@id": id })).collect();
    match references.len() {
        0 => {}
        1 => entity[key] = references.remove(0),
        _ => entity[key] = references.into(),
    }
    entity
}

fn input_id(number: usize) -> String {
    format!("#input-{number}")
}

/// Something read that is not in the folder.
fn input(number: usize, file: &FileDigest) -> Value {
    json!({
        "@id": input_id(number), "@type": "CreativeWork", "name": file.path,
        "identifier": format!("sha256:{}", file.digest),
    })
}

fn part(name: &str) -> Value {
    let ending = Path::new(name).extension().and_then(|ending| ending.to_str());
    let format = match ending {
        Some("exr") => "image/x-exr",
        Some("png") => "image/png",
        Some("html") => "text/html",
        Some("json") => "application/json",
        Some("js") => "text/javascript",
        _ => "text/csv",
    };
    let part = [("@id", uri(name)), ("@type", "File".to_owned()), ("name", name.to_owned())];
    let part = part.into_iter().chain([("encodingFormat", format.to_owned())]);
    part.map(|(key, value)| (key.to_owned(), json!(value))).collect::<Map<_, _>>().into()
}

/// A file's name as a relative URI (RFC 3986).
fn uri(name: &str) -> String {
    let mut uri = String::new();
    for byte in name.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' => {
                uri.push(byte.into())
            }
            _ => drop(write!(uri, "%{byte:02X}")), // writing to a string cannot fail
        }
    }
    uri
}

/// The day of `SOURCE_DATE_EPOCH` (reproducible-builds.org), or the first of 1970.
fn date() -> String {
    let epoch = std::env::var("SOURCE_DATE_EPOCH").ok().and_then(|text| text.parse::<u64>().ok());
    day(epoch.unwrap_or(0) / 86_400)
}

/// Date of a day after 1970-01-01 (Fliegel & Van Flandern 1968, from the Julian day).
fn day(days: u64) -> String {
    let l = days as i64 + 2_440_588 + 68_569;
    let n = 4 * l / 146_097;
    let l = l - (146_097 * n + 3) / 4;
    let i = 4000 * (l + 1) / 1_461_001;
    let l = l - 1461 * i / 4 + 31;
    let j = 80 * l / 2447;
    let day = l - 2447 * j / 80;
    let l = j / 11;
    format!("{:04}-{:02}-{day:02}", 100 * (n - 49) + i + l, j + 2 - 12 * l)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_are_those_of_the_calendar() {
        for (days, date) in [
            (0, "1970-01-01"),
            (58, "1970-02-28"),
            (11_016, "2000-02-29"),
            (20_786, "2026-11-29"),
            (47_541, "2100-03-01"),
        ] {
            assert_eq!(day(days), date);
        }
    }

    #[test]
    fn names_become_uris() {
        assert_eq!(uri("view_0001+a.exr"), "view_0001%2Ba.exr");
        assert_eq!(uri("전.png"), "%EC%A0%84.png");
    }
}
