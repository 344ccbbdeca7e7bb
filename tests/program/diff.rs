//! `lampyris diff`: what was changed is named, and nothing else.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use crate::bench::{Bench, text};

/// A sweep of two views and a study; `KEY` are places that tests change.
const SCRIPT: &str = r#"
local lampyris = require "lampyris"
local plate = lampyris.mesh.new {
  positions = { { -50, -50, 0 }, { 50, -50, 0 }, { 50, 50, 0 }, { -50, 50, 0 } },
  triangles = { { 1, 2, 3 }, { 1, 3, 4 } },
}
local scene = lampyris.scene {
  objects = { { mesh = plate, material = lampyris.material { reflectance = REFLECTANCE, k_d = 1 } } },
  lights = { lampyris.cylinder { center = { 0, 0, 30 }, radius = 1, length = 5, flux = 100,
    samples = 50, seed = SEED, spectrum = lampyris.spectrum.load "lamp.csv" } },
}
local function view(azimuth)
  return lampyris.view { azimuth = azimuth, distance = 500, fov = 10, width = 8, height = 6 }
end
lampyris.sweep { scene = scene, output = "s", views = { view(0), view(AZIMUTH) },
  quality = { samples = SAMPLES } }
"#;

const PLACES: [(&str, &str); 4] =
    [("REFLECTANCE", "0.5"), ("SEED", "1"), ("AZIMUTH", "20"), ("SAMPLES", "1")];

fn sweep(bench: &Bench, out: &str, change: Option<(&str, &str)>, spectrum: &str) {
    let fill = |script: String, (key, value): &(&str, &str)| {
        let value = change.filter(|(changed, _)| changed == key).map_or(*value, |(_, to)| to);
        script.replace(key, value)
    };
    bench.write("sweep.lua", &PLACES.iter().fold(SCRIPT.to_owned(), fill));
    bench.write("lamp.csv", spectrum);
    bench.succeed(&["run", "sweep.lua", "--quiet", "--out", out]);
}

fn diff(bench: &Bench, a: &str, b: &str) -> Vec<String> {
    let done = bench.run(&["diff", a, b]);
    let lines: Vec<String> = text(&done.stdout).lines().map(str::to_owned).collect();
    assert_eq!(done.status.code(), Some(i32::from(!lines.is_empty())), "{}", text(&done.stderr));
    lines
}

#[test]
fn changes_are_named_and_nothing_else() {
    const FLAT: &str = "380,1\n780,1\n";
    let bench = Bench::new();
    sweep(&bench, "a", None, FLAT);
    sweep(&bench, "same", None, FLAT);
    assert!(diff(&bench, "a/s", "same/s").is_empty());
    for (change, spectrum, expected) in [
        (
            Some(("REFLECTANCE", "0.6")),
            FLAT,
            &["view view_0001: luminance differs by 2.000e-1"][..],
        ),
        (Some(("SEED", "2")), FLAT, &["seeds[cylinder].seed: 1 → 2", "view view_0001: luminance"]),
        (Some(("AZIMUTH", "30")), FLAT, &["views[view_0002].details.view.azimuth: 20.0 → 30.0"]),
        (Some(("SAMPLES", "4")), FLAT, &["views[view_0001].details.quality.samples: 1 → 4"]),
        (None, "380,1\n780,2\n", &["inputs[lamp.csv].sha256: ", "spectra by"]),
    ] {
        sweep(&bench, "b", change, spectrum);
        let lines = diff(&bench, "a/s", "b/s");
        for part in expected {
            assert!(lines.iter().any(|line| line.contains(part)), "{part}: {lines:#?}");
        }
        // A changed azimuth changes the second view alone.
        let first = lines.iter().any(|line| line.starts_with("view view_0001"));
        assert_eq!(first, !matches!(change, Some(("AZIMUTH", _))), "{lines:#?}");
        let of_input = lines.iter().any(|line| line.contains("lamp.csv"));
        assert_eq!(of_input, change.is_none(), "{lines:#?}");
        fs::remove_dir_all(bench.path("b")).unwrap();
    }
}

/// Paths of a record's leaves as `diff` names them, each with where it is.
fn leaves(path: &str, place: &str, value: &Value, found: &mut Vec<(String, String)>) {
    match value {
        Value::Object(fields) => {
            for (key, value) in fields {
                let below = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                leaves(&below, &format!("{place}/{key}"), value, found);
            }
        }
        Value::Array(entries) => {
            for (at, entry) in entries.iter().enumerate() {
                let named = ["name", "path", "object"];
                let name = named.iter().find_map(|key| entry.get(key)?.as_str());
                let name = name.map_or_else(|| (at + 1).to_string(), str::to_owned);
                leaves(&format!("{path}[{name}]"), &format!("{place}/{at}"), entry, found);
            }
        }
        _ => found.push((path.to_owned(), place.to_owned())),
    }
}

/// Another value of the same kind.
fn changed(value: &Value) -> Value {
    match value {
        Value::Number(number) => json!(number.as_f64().expect("a number") + 1.0),
        Value::Bool(flag) => json!(!flag),
        Value::String(text) => json!(format!("{text}, changed")),
        _ => json!("changed"),
    }
}

/// Plants a change in leaves of a record that `is_meant`, and returns their paths.
fn plant(file: &Path, most: usize, is_meant: impl Fn(&str) -> bool) -> Vec<String> {
    let mut record: Value = serde_json::from_str(&fs::read_to_string(file).unwrap()).unwrap();
    let mut found = Vec::new();
    leaves("", "", &record, &mut found);
    found.retain(|(path, _)| is_meant(path));
    found.truncate(most);
    for (_, place) in &found {
        let leaf = record.pointer_mut(place).expect("a leaf");
        *leaf = changed(leaf);
    }
    fs::write(file, format!("{record:#}\n")).unwrap();
    found.into_iter().map(|(path, _)| path).collect()
}

/// What names other things, or follows from them.
fn is_plantable(path: &str) -> bool {
    let of_itself = ["name", "path", "object", "key", "picture_key", "index", "measured", "sha256"];
    let last = path.rsplit('.').next().unwrap_or_default();
    let follows = ["pages", ".outputs[", ".pictures["].iter().any(|part| path.contains(part));
    let is_input = path == "inputs[lamp.csv].sha256";
    is_input || !(follows || of_itself.contains(&last))
}

/// 200 changes at once: of a sweep's record, its images, a study's record and its draws.
#[test]
fn two_hundred_planted_changes_are_found_and_nothing_else() {
    const FLAT: &str = "380,1\n780,1\n";
    let bench = Bench::new();
    for out in ["a", "b"] {
        sweep(&bench, out, None, FLAT);
        bench.write("study.lua", STUDY);
        bench.succeed(&["run", "study.lua", "--quiet", "--out", out]);
    }
    let mut planted = plant(&bench.path("b/s/manifest.json"), 110, is_plantable);
    for view in ["view_0001", "view_0002"] {
        let path = bench.path(&format!("b/s/{view}.exr"));
        let mut image = lampyris::output::read_exr(&path).unwrap();
        image.bands[500] += 1e-6;
        lampyris::output::write_exr(&path, &image).unwrap();
        planted.push(format!("view {view}"));
    }
    assert_lines(&diff(&bench, "a/s", "b/s"), &planted);
    let in_sweep = planted.len();

    let mut planted = plant(&bench.path("b/t/study.json"), 12, |path| {
        path != "format" && !path.ends_with(".path")
    });
    let table = bench.path("b/t/draws.csv");
    let mut rows: Vec<Vec<String>> = fs::read_to_string(&table)
        .unwrap()
        .lines()
        .map(|line| line.split(',').map(str::to_owned).collect())
        .collect();
    let columns = rows[0].clone();
    let left = 200 - in_sweep - planted.len();
    for at in 0..left {
        let (row, column) = (1 + at / 3, 1 + at % 3);
        let value: f64 = rows[row][column].parse().unwrap();
        rows[row][column] = format!("{:?}", value + value.abs() * 1e-15 + 1e-300);
        planted.push(format!("draw {}: {}", row - 1, columns[column]));
    }
    let text: Vec<String> = rows.iter().map(|row| row.join(",") + "\n").collect();
    fs::write(&table, text.concat()).unwrap();
    assert_lines(&diff(&bench, "a/t", "b/t"), &planted);
    assert_eq!(in_sweep + planted.len(), 200);
}

/// Each planted change has its line, and no line is of anything else.
fn assert_lines(lines: &[String], planted: &[String]) {
    for change in planted {
        let starts = lines.iter().filter(|line| line.starts_with(&format!("{change}:"))).count();
        assert_eq!(starts, 1, "{change}: {lines:#?}");
    }
    assert_eq!(lines.len(), planted.len(), "{lines:#?}");
}

const STUDY: &str = r#"
require("lampyris").study {
  parameters = { shift = { normal = { 0, 0.15 } }, flux = { uniform = { 391, 529 } } },
  samples = 64, output = "t", run = function(p) return { i = p.flux * (1 - p.shift ^ 2) } end,
}
"#;

#[test]
fn folders_without_records_are_named() {
    let bench = Bench::new();
    fs::create_dir_all(bench.path("empty")).unwrap();
    let message = text(&bench.run(&["diff", "empty", "empty"]).stderr);
    assert!(message.contains("empty: holds no manifest.json and no study.json"), "{message}");
}
