//! Every shipped script runs, small enough for a test.

use std::path::{Path, PathBuf};

use lampyris::script::{self, Settings};

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

#[test]
fn models_render() {
    for (name, view) in [("model1", "15"), ("model2", "00"), ("model3", "turn"), ("model4", "tail")]
    {
        let output = run(name, &["32", "6", "100"]);
        assert!(output.has(&format!("{name}_{view}.exr")), "{name}");
        assert!(output.has(&format!("{name}_{view}_srgb.png")), "{name}");
    }
}

#[test]
fn figures_are_drawn() {
    for name in [
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
        "start_points",
        "tradeoff",
    ] {
        assert_draws(name);
    }
}

#[test]
fn tables_are_printed() {
    for name in ["table2", "table3", "table4", "table5", "stability", "bench"] {
        run(name, &["tiny"]);
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
