//! `lampyris diff`: what was changed is named, and nothing else.

use std::fs;

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

#[test]
fn folders_without_records_are_named() {
    let bench = Bench::new();
    fs::create_dir_all(bench.path("empty")).unwrap();
    let message = text(&bench.run(&["diff", "empty", "empty"]).stderr);
    assert!(message.contains("empty: holds no manifest.json and no study.json"), "{message}");
}
