//! `pack` and `replay`, as two people on two machines use them.

use std::fs;

use crate::bench::{Bench, text};

const SCRIPT: &str = r#"
local lampyris = require "lampyris"
local parts = require "parts.sheet"
local scene = lampyris.scene {
  objects = { { mesh = lampyris.mesh.load "../meshes/sheet.obj", material = parts.material(tonumber(arg[1])) } },
  lights = { lampyris.cylinder { center = { 0, 0, 30 }, axis = { 0, 1, 0 }, radius = 1, length = 4,
    samples = 50, flux = 100, spectrum = lampyris.spectrum.blackbody(2856) } },
}
local view = lampyris.view { distance = 200, fov = 8, width = 16, height = 12 }
lampyris.sweep { scene = scene, views = { view }, quality = { samples = 1 }, output = "deep/sheet" }
lampyris.study { parameters = { x = { uniform = { 0, 1 } } }, samples = 4, output = "draws",
  run = function(p) return { y = p.x ^ 2 } end }
"#;

const MODULE: &str = r#"
local lampyris = require "lampyris"
return { material = function(k_d) return lampyris.material { reflectance = 0.5, k_d = k_d } end }
"#;

/// A bench on which the sweep was made and packed.
fn packed() -> Bench {
    let bench = Bench::new();
    bench.write("work/lamp/script.lua", SCRIPT);
    bench.write("work/lamp/parts/sheet.lua", MODULE);
    bench.write("work/meshes/sheet.obj", "v -9 -9 0\nv 9 -9 0\nv 9 9 0\nv -9 9 0\nf 1 2 3 4\n");
    let script = "work/lamp/script.lua";
    bench.succeed(&["run", script, "--read", "work", "--quiet", "--", "0.7"]);
    let said = bench.succeed(&["pack", "out/deep/sheet", "--script", script]);
    assert_eq!(said, "sheet.tar: 6 files\n");
    bench
}

#[test]
fn a_packed_sweep_is_made_again_elsewhere_to_the_byte() {
    let bench = packed();
    let archive = fs::read(bench.path("sheet.tar")).unwrap();
    let script = ["--script", "work/lamp/script.lua"];
    bench.succeed(&[&["pack", "out/deep/sheet", "--into", "again.tar"], &script[..]].concat());
    assert_eq!(fs::read(bench.path("again.tar")).unwrap(), archive, "the same bytes");

    let elsewhere = Bench::new();
    fs::write(elsewhere.path("sheet.tar"), &archive).unwrap();
    let said = elsewhere.succeed(&["replay", "sheet.tar", "--out", "new", "--quiet"]);
    assert!(said.starts_with("the same to the byte: "), "{said}");
    let again = elsewhere.fail(&["replay", "sheet.tar", "--out", "new"]);
    assert!(again.contains("allowed: a folder that is new or empty"), "{again}");

    bench.succeed(&[&["pack", "out/draws"], &script[..]].concat());
    fs::copy(bench.path("draws.tar"), elsewhere.path("draws.tar")).unwrap();
    let said = elsewhere.succeed(&["replay", "draws.tar", "--out", "study", "--quiet"]);
    assert!(said.starts_with("the same to the byte: 1 files"), "{said}");
}

#[test]
fn what_has_changed_is_not_packed() {
    let bench = packed();
    let pack = ["pack", "out/deep/sheet", "--script", "work/lamp/script.lua"];
    for file in
        ["work/lamp/parts/sheet.lua", "work/lamp/script.lua", "out/deep/sheet/view_0001.exr"]
    {
        let content = fs::read(bench.path(file)).unwrap();
        fs::write(bench.path(file), [&content[..], b" "].concat()).unwrap();
        let message = bench.fail(&pack);
        assert!(
            message.contains(&format!("{file} has changed since the folder was made")),
            "{message}"
        );
        fs::write(bench.path(file), content).unwrap();
    }
    assert!(bench.fail(&["pack", "out/deep/sheet"]).contains("--script says where it lies"));
}

/// Replaces what stands in an archive by text of the same length.
fn tampered(bench: &Bench, from: &str, to: &str) -> String {
    let mut archive = fs::read(bench.path("sheet.tar")).unwrap();
    let at = archive.windows(from.len()).position(|part| part == from.as_bytes()).expect(from);
    archive[at..at + from.len()].copy_from_slice(to.as_bytes());
    fs::write(bench.path("bad.tar"), archive).unwrap();
    let output = bench.run(&["replay", "bad.tar", "--out", &format!("bad{at}"), "--quiet"]);
    assert_eq!(output.status.code(), Some(1));
    text(&output.stdout) + &text(&output.stderr)
}

#[test]
fn tampered_archives_are_found_and_other_programs_named() {
    let bench = packed();
    let said = tampered(&bench, "reflectance = 0.5", "reflectance = 0.6");
    assert!(said.contains("sheet.lua\" has been changed"), "{said}");
    let said = tampered(&bench, "files/up/script.lua", "files/../script.lua");
    assert!(said.contains("no archive of lampyris"), "{said}");
    let listed = fs::read(bench.path("sheet.tar")).unwrap();
    let listed = String::from_utf8_lossy(&listed).into_owned();
    // Other arguments and another program: both are only said, in a list that no digest seals.
    let said = tampered(&bench, "\"0.7\"", "\"0.6\"");
    assert!(said.contains("not the same: ") && said.contains("view_0001.exr: differs"), "{said}");
    assert!(said.contains("largest relative difference of numbers on record: "), "{said}");
    assert!(!said.contains("program:"), "{said}");
    let sources = listed.split("\"sources\": \"").nth(1).unwrap();
    let executable = listed.split("\"executable\": \"").nth(1).unwrap();
    let both = [&executable[..64], &sources[..32]];
    let archive = fs::read(bench.path("sheet.tar")).unwrap();
    let mut other = archive.clone();
    for digest in both {
        let at = archive.windows(digest.len()).position(|part| part == digest.as_bytes()).unwrap();
        other[at] = if other[at] == b'0' { b'1' } else { b'0' };
    }
    fs::write(bench.path("sheet.tar"), other).unwrap();
    let said = bench.succeed(&["replay", "sheet.tar", "--out", "other", "--quiet"]);
    assert!(
        said.contains("program: sources: made from ") && !said.contains("Cargo.lock"),
        "{said}"
    );
}
