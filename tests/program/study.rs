//! Studies as a user runs them.

use std::fs;

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
