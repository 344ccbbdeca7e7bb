//! Studies as a user runs them.

use std::fs;
use std::process::Stdio;
use std::thread::sleep;
use std::time::Duration;

use crate::bench::{Bench, text};

/// i = flux (1 − shift²), with closed mean and shares.
const SCRIPT: &str = r#"
local lampyris = require "lampyris"
local stop = tonumber(arg[1])
local calls = 0
local study = lampyris.study {
  parameters = { shift = { normal = { 0, 0.15 } }, flux = { uniform = { 391, 529 } }, kind = { 1, 2 } },
  samples = 64,
  output = "s",
  run = function(p)
    calls = calls + 1
    if calls == stop then error("stopped") end
    return { i = p.flux * (1 - p.shift ^ 2), passes = p.flux > 400 }
  end,
}
print(study.draws, study.made, #study.rows)
print(("%.2f %.2f"):format(study.mean.i, study.percentile("i", 50)))
print(("%.3f %.3f %.3f"):format(study.probability(function(row) return row.passes == 1 end)))
local shares, explained = study.sensitivity "i"
print(("%.3f %.3f %.3f %.4f"):format(shares.flux.first, shares.shift.total, shares.kind.total, explained))
"#;

fn run(stop: &str) -> [&str; 5] {
    ["run", "study.lua", "--quiet", "--", stop]
}

#[test]
fn a_study_is_made_once_and_goes_on_after_errors() {
    let bench = Bench::new();
    bench.write("study.lua", SCRIPT);
    let printed = bench.succeed(&run("0"));
    let lines: Vec<&str> = printed.lines().collect();
    assert_eq!(lines[0], "64\t64\t64");
    // The mean: 460 (1 − 0.15²) = 449.65; of flux, the shift's part is 0.3 %.
    let mean: f64 = lines[1].split(' ').next().unwrap().parse().unwrap();
    assert!((mean - 449.65).abs() < 1.0, "{printed}");
    let shares: Vec<f64> = lines[3].split(' ').map(|cell| cell.parse().unwrap()).collect();
    assert!(
        shares[0] > 0.85 && shares[1] < 0.15 && shares[2] < 0.01 && shares[3] > 0.99,
        "{printed}"
    );
    let table = fs::read_to_string(bench.path("out/s/draws.csv")).unwrap();
    assert!(table.starts_with("draw,flux,kind,shift,i,passes\n0,"), "{table}");
    assert!(bench.succeed(&run("0")).starts_with("64\t0\t64"));

    // Another seed of arguments is another study: its draws are moved aside, and it is stopped thrice.
    for _ in 0..3 {
        assert!(text(&bench.run(&run("20")).stderr).contains("stopped"));
    }
    assert!(bench.succeed(&run("20")).starts_with("64\t7\t64"));
    assert_eq!(fs::read_to_string(bench.path("out/s/draws.csv")).unwrap(), table);
    let page = fs::read_to_string(bench.path("out/s/index.html")).unwrap();
    assert!(page.contains("<svg") && page.contains("What the variance comes from"));
}

#[test]
fn mistakes_have_their_messages() {
    let bench = Bench::new();
    for (options, message) in [
        ("parameters = { x = { normal = { 0, 0 } } }", "parameter \"x\": normal is {0, 0}"),
        ("parameters = { x = { normal = { 0 } } }", "has 1 entries, expected two numbers"),
        ("parameters = { x = {} }", "expected one of normal = {mean, sd}, uniform = {low, high}"),
        ("parameters = { x = { unifrom = { 0, 1 } } }", "did you mean \"uniform\"?"),
        ("parameters = {}", "number of parameters is 0, allowed: 1 to 256"),
        ("parameters = { x = { 1, 2 } }, samples = 0", "\"samples\" is 0"),
        ("parameters = { x = { 1, 2 } }, design = \"sobel\"", "did you mean \"sobol\"?"),
        ("parameters = { x = { 1, 2 } }, run = function() end", "its result is nil"),
        ("parameters = { x = { 1, 2 } }, run = function() return { y = 0/0 } end", "\"y\" is"),
    ] {
        let script = format!(
            "local o = {{ output = \"s\", run = function() return {{ y = 1 }} end }}\n\
             for k, v in pairs {{ {options} }} do o[k] = v end\n\
             require(\"lampyris\").study(o)"
        );
        bench.write("wrong.lua", &script);
        let printed = text(&bench.run(&["run", "wrong.lua"]).stderr);
        assert!(
            printed.contains(message) && printed.contains("wrong.lua:3"),
            "{options}: {printed}"
        );
    }
}

/// Draws that take some milliseconds each, of a lamp that is moved.
const SLOW: &str = r#"
local lampyris = require "lampyris"
local mirror = lampyris.mesh.new {
  positions = { { -50, -50, 0 }, { 50, -50, 0 }, { 50, 50, 0 }, { -50, 50, 0 } },
  triangles = { { 1, 2, 3 }, { 1, 3, 4 } },
}
local material = lampyris.material { reflectance = 0.9, k_d = 0.5, k_s = 0.5, n_s = 20 }
local view = lampyris.view { distance = 500, fov = 10, width = 12, height = 9 }
lampyris.study {
  parameters = { shift = { normal = { 0, 0.15 } }, flux = { uniform = { 391, 529 } } },
  samples = 60, output = "s",
  run = function(p)
    local scene = lampyris.scene {
      objects = { { mesh = mirror, material = material } },
      lights = { lampyris.cylinder { center = { 0, 0, 40 + p.shift }, radius = 1, length = 5, flux = p.flux,
        samples = 200, spectrum = lampyris.spectrum.blackbody(2856) } },
      photometry = "absolute", shadows = false,
    }
    return { i0 = scene:render(view, { samples = 1 }):intensity() }
  end,
}
"#;

#[test]
fn ten_kills_leave_the_bytes_of_an_unbroken_study() {
    let (whole, broken) = (Bench::new(), Bench::new());
    [&whole, &broken].iter().for_each(|bench| bench.write("slow.lua", SLOW));
    whole.succeed(&["run", "slow.lua", "--quiet", "--threads", "1"]);
    let table = broken.path("out/s/draws.csv");
    let draws = || fs::read_to_string(&table).unwrap_or_default().lines().count();
    for _ in 0..10 {
        let before = draws();
        let mut child = broken.command(&["run", "slow.lua", "--quiet"]);
        let mut child = child.stdout(Stdio::null()).spawn().expect("a start");
        while draws() < before + 3 && child.try_wait().expect("a status").is_none() {
            sleep(Duration::from_millis(1));
        }
        child.kill().expect("SIGKILL");
        child.wait().expect("an end");
    }
    assert!(draws() > 10);
    broken.succeed(&["run", "slow.lua", "--quiet"]);
    assert_eq!(broken.files("out/s"), whole.files("out/s"));
}

#[test]
fn shards_merge_to_the_bytes_of_one_run() {
    let (whole, parts) = (Bench::new(), Bench::new());
    [&whole, &parts].iter().for_each(|bench| bench.write("slow.lua", SLOW));
    whole.succeed(&["run", "slow.lua", "--quiet"]);
    parts.succeed(&["run", "slow.lua", "--quiet", "--shard", "1/2"]);
    let missing = parts.fail(&["merge", "out/s"]);
    assert!(missing.contains("30 of 60 draws are missing, the first is draw 1"), "{missing}");
    parts.succeed(&["run", "slow.lua", "--quiet", "--shard", "2/2", "--out", "there"]);
    let said = parts.succeed(&["merge", "out/s", "there/s", "--into", "whole"]);
    assert_eq!(said, "whole: 2 shards, 60 draws\n");
    assert_eq!(parts.files("whole"), whole.files("out/s"));
    parts.succeed(&["run", "slow.lua", "--quiet", "--shard", "2/2"]);
    parts.succeed(&["merge", "out/s"]);
    assert_eq!(parts.files("out/s"), whole.files("out/s"));
    assert_eq!(parts.succeed(&["merge", "out/s"]), "out/s: 0 shards, 60 draws\n");

    parts.write("slow.lua", &SLOW.replace("0.15", "0.16"));
    parts.succeed(&["run", "slow.lua", "--quiet", "--shard", "2/2", "--out", "other"]);
    let other = parts.fail(&["merge", "out/s", "other/s", "--into", "mixed"]);
    assert!(other.contains("of different studies: they differ in parameters, read"), "{other}");
}
