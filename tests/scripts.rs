//! Every shipped script runs, small enough for a test.

use std::path::{Path, PathBuf};

use lampyris::program::script::{self, Settings};

/// A folder for one test's output, removed at its end.
struct Output(PathBuf);

impl Output {
    fn new(name: &str) -> Self {
        let folder = format!("lampyris_scripts_{}_{name}", std::process::id());
        Self(std::env::temp_dir().join(folder))
    }

    fn has(&self, file: &str) -> bool {
        self.0.join(file).exists()
    }
}

impl Drop for Output {
    fn drop(&mut self) {
        // What was never written cannot be removed, and a temporary folder may stay.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Runs `scripts/NAME.lua` with arguments; panics with its message if it fails.
fn run(name: &str, arguments: &[&str]) -> Output {
    let output = Output::new(name);
    let settings = Settings {
        out: output.0.clone(),
        arguments: arguments.iter().map(|&a| a.to_owned()).collect(),
        ..Settings::default()
    };
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scripts/{name}.lua"));
    if let Err(fault) = script::run(&path, settings) {
        panic!("{name}: {fault}");
    }
    output
}

/// Figures come as PNG and SVG under their own names.
fn assert_draws(name: &str) {
    let output = run(name, &["tiny"]);
    for ending in ["png", "svg"] {
        assert!(output.has(&format!("{name}.{ending}")), "{name}.{ending} is missing");
    }
}

/// A lamp of Table 5 and one of its views.
const MODELS: [(&str, &str); 4] =
    [("model1", "15"), ("model2", "00"), ("model3", "turn"), ("model4", "tail")];

/// Scripts that draw a figure of their own name.
const FIGURES: [&str; 15] = [
    "fig1",
    "fig3",
    "fig5",
    "fig6",
    "fig7",
    "fig8",
    "fig9",
    "fig10",
    "fig11",
    "fig8_samples",
    "glare",
    "interfaces",
    "start_points",
    "target_error",
    "tradeoff",
];

/// Scripts that print tables.
const TABLES: [&str; 10] = [
    "daylight",
    "table2",
    "table3",
    "table4",
    "table5",
    "stability",
    "study",
    "bench",
    "truth",
    "time_to_error",
];

/// What the others require, and the page of them all.
const SHARED: [&str; 10] = [
    "all",
    "closed_form",
    "crt",
    "lamp",
    "model",
    "paper",
    "prediction",
    "revolve",
    "sheet",
    "test_lamp",
];

/// Lamps of today, with the arguments that make them small.
const LAMPS: [(&str, &[&str]); 3] = [
    ("collimator", &["32", "24", "1"]),
    ("light_guide", &["32", "1"]),
    ("opal", &["32", "1", "500"]),
];

#[test]
fn every_script_has_its_test() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts");
    let entries = std::fs::read_dir(folder).expect("a folder of scripts");
    let paths = entries.map(|entry| entry.expect("an entry").path());
    let mut scripts: Vec<String> = paths
        .filter(|path| path.extension().is_some_and(|ending| ending == "lua"))
        .map(|path| path.file_stem().expect("a name").to_string_lossy().into_owned())
        .collect();
    scripts.sort();
    let models = MODELS.iter().map(|(name, _)| name);
    let mut run: Vec<&str> =
        models.chain(&FIGURES).chain(&TABLES).chain(&SHARED).copied().collect();
    run.extend(LAMPS.map(|(name, _)| name));
    run.sort_unstable();
    assert_eq!(scripts, run);
}

#[test]
fn models_render() {
    for (name, view) in MODELS {
        let output = run(name, &["32", "6", "100"]);
        assert!(output.has(&format!("{name}_{view}.exr")), "{name}");
        for look in ["srgb", "t766", "seen", "camera"] {
            assert!(output.has(&format!("{name}_{view}_{look}.png")), "{name}: {look}");
        }
    }
}

#[test]
fn lamps_of_today_render() {
    for (name, arguments) in LAMPS {
        let output = run(name, arguments);
        assert!(output.has(&format!("{name}_00.png")) && output.has(&format!("{name}_15.exr")));
    }
}

#[test]
fn figures_are_drawn() {
    FIGURES.into_iter().for_each(assert_draws);
}

#[test]
fn tables_are_printed() {
    for name in TABLES {
        run(name, &["tiny"]);
    }
}

/// The script fails by itself where an extreme is off; its table tells that it looked at all.
#[test]
fn the_extremes_hold() {
    let output = run("stability", &["tiny"]);
    let table = std::fs::read_to_string(output.0.join("stability.csv")).expect("a table");
    let rows: Vec<&str> = table.lines().skip(1).collect();
    assert!(rows.len() >= 23, "{table}");
    for row in rows {
        let cells: Vec<f64> = row.rsplitn(4, ',').filter_map(|cell| cell.parse().ok()).collect();
        let [allowed, worst, cases] = cells[..] else { panic!("{row}") };
        assert!(cases >= 1.0 && worst <= allowed && allowed <= 0.01, "{row}");
    }
}

/// The page holds every figure itself, and refers to nothing outside.
#[test]
fn all_of_it_becomes_one_page() {
    let output = run("all", &["tiny"]);
    let page = std::fs::read_to_string(output.0.join("index.html")).expect("a page");
    assert!(page.matches("<svg").count() >= 13);
    assert!(page.trim_end().ends_with("</html>"));
    for outside in ["src=\"http", "src=\"fig", "href=\"http", "@import", "url("] {
        assert!(!page.contains(outside), "{outside}");
    }
}

#[test]
fn the_trade_is_a_table() {
    let output = run("tradeoff", &["tiny"]);
    let table = std::fs::read_to_string(output.0.join("tradeoff.csv")).expect("a table");
    assert!(table.starts_with("knob,setting,"), "{table}");
    assert!(table.lines().count() > 10);
}
