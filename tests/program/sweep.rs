//! Sweeps that are stopped, resumed, shared out and checked.

use std::collections::BTreeMap;
use std::fs;
use std::process::{Child, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use lampyris::output::{read_exr, read_png};
use lampyris::program::sweep::{Digest, Manifest, verify};

use crate::bench::{Bench, text};

/// Eight views of a lit mirror, some ten milliseconds each.
const SCRIPT: &str = r#"
local lampyris = require "lampyris"
local mirror = lampyris.mesh.surface {
  nu = 30, nv = 30,
  point = function(u, v)
    local x, y = 80 * u - 40, 80 * v - 40
    return x, y, (x * x + y * y) / 80
  end,
}
local scene = lampyris.scene {
  objects = { {
    mesh = mirror,
    material = lampyris.material {
      reflectance = lampyris.spectrum.load("aluminium.csv"), k_rg = 0.9, k_s = 0.9, n_s = 40,
    },
  } },
  lights = { lampyris.cylinder {
    center = { 0, 0, 20 }, radius = 0.5, length = 5, flux = 100, samples = 500, seed = 3,
    spectrum = lampyris.spectrum.blackbody(2856),
  } },
}
local views = {}
for k = 1, 8 do
  views[k] = lampyris.view { azimuth = 3 * k, distance = 800, fov = 7, width = 64, height = 48 }
end
local done = lampyris.sweep {
  scene = scene, views = views, output = "s",
  png = { display = lampyris.display.eizo_t766 },
  quality = { samples = 9, light_error = 0 },
  regions = { center = { x = 30, y = 20, width = 4, height = 4 } },
}
print(done.rendered, done.kept)
"#;

fn bench() -> Bench {
    let bench = Bench::new();
    bench.write("sweep.lua", SCRIPT);
    bench.write("aluminium.csv", "380,0.9\n780,0.85\n");
    bench
}

const RUN: [&str; 4] = ["run", "sweep.lua", "--quiet", "--threads=1"];

/// Runs the sweep to its end, and returns how many views it rendered and kept.
fn finish(bench: &Bench) -> (usize, usize) {
    let output = bench.succeed(&RUN);
    let mut counts = output.split_whitespace().map(|n| n.parse().expect("a number"));
    (counts.next().expect("rendered"), counts.next().expect("kept"))
}

fn unbroken() -> BTreeMap<String, Vec<u8>> {
    let bench = bench();
    assert_eq!(finish(&bench), (8, 0));
    bench.files("out/s")
}

fn assert_same(files: &BTreeMap<String, Vec<u8>>, expected: &BTreeMap<String, Vec<u8>>) {
    let names = |files: &BTreeMap<String, Vec<u8>>| files.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(files), names(expected));
    for (name, bytes) in files {
        assert!(*bytes == expected[name], "{name} differs");
    }
}

/// Every file is whole, and the manifest says nothing that is not so.
fn assert_whole(bench: &Bench) -> usize {
    let folder = bench.path("out/s");
    for name in bench.files("out/s").keys() {
        let path = folder.join(name);
        match path.extension().and_then(|e| e.to_str()) {
            Some("exr") => drop(read_exr(&path).expect("a whole image")),
            Some("png") => drop(read_png(&path).expect("a whole image")),
            Some("json") if name.starts_with("ro-crate") => {}
            Some("json") => drop(Manifest::read(&path).expect("a whole manifest")),
            Some("log") => assert!(name == "manifest.log", "{name}"),
            _ => assert!(name.ends_with(".html") || name.ends_with(".partial"), "{name}"),
        }
    }
    let manifest = folder.join("manifest.json");
    if !manifest.exists() {
        return 0;
    }
    let views = Manifest::read(&manifest).expect("a manifest").views;
    assert!(views.iter().all(|view| view.is_whole(&folder)));
    views.len()
}

/// Waits until the sweep has `count` views.
fn wait_for_views(bench: &Bench, child: &mut Child, count: usize) {
    let start = Instant::now();
    let manifest = bench.path("out/s/manifest.json");
    loop {
        if Manifest::read(&manifest).is_ok_and(|manifest| manifest.views.len() >= count) {
            return;
        }
        assert!(child.try_wait().expect("a status").is_none(), "ended before it was stopped");
        assert!(start.elapsed() < Duration::from_secs(60), "no views after a minute");
        sleep(Duration::from_millis(1));
    }
}

/// What max_depth cuts off is in the record of each view, and told once for all of them.
#[test]
fn rays_that_are_cut_are_counted_and_told_once() {
    let bench = bench();
    bench.write("sweep.lua", &SCRIPT.replace("light_error = 0", "light_error = 0, max_depth = 0"));
    let output = bench.run(&["run", "sweep.lua", "--threads=1"]);
    let told = text(&output.stderr);
    assert_eq!(told.matches("ended at max_depth").count(), 1, "{told}");
    let views = Manifest::read(&bench.path("out/s/manifest.json")).expect("a manifest").views;
    let cut = |stats: &serde_json::Value| stats["rays_cut"].as_u64().is_some_and(|rays| rays > 0);
    assert!(views.len() == 8 && views.iter().all(|view| cut(&view.details["stats"])), "{views:?}");
}

#[test]
fn killed_sweeps_go_on_to_the_same_bytes() {
    let expected = unbroken();
    let bench = bench();
    let mut rendered_before = 0;
    for (count, delay_ms) in [(1, 0), (3, 3), (5, 7)] {
        let mut child = bench.command(&RUN).stdout(Stdio::null()).spawn().expect("a start");
        wait_for_views(&bench, &mut child, count);
        sleep(Duration::from_millis(delay_ms));
        child.kill().expect("SIGKILL");
        child.wait().expect("an end");
        let views = assert_whole(&bench);
        assert!(views >= count.max(rendered_before), "{views} views are left of {count}");
        rendered_before = views;
    }
    let (rendered, kept) = finish(&bench);
    assert_eq!((rendered + kept, kept), (8, rendered_before));
    assert_same(&bench.files("out/s"), &expected);
    assert_eq!(finish(&bench), (0, 8), "nothing is left to do");
    assert_same(&bench.files("out/s"), &expected);
}

#[cfg(unix)]
#[test]
fn interrupted_sweeps_end_with_status_130() {
    let bench = bench();
    let mut child =
        bench.command(&RUN).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("a start");
    wait_for_views(&bench, &mut child, 1);
    let id = child.id().to_string();
    let signal = std::process::Command::new("kill").args(["-INT", &id]).status();
    assert!(signal.expect("kill runs").success());
    let output = child.wait_with_output().expect("an end");
    assert_eq!(output.status.code(), Some(130), "{}", text(&output.stderr));
    assert!(text(&output.stderr).ends_with("interrupted\n"), "{}", text(&output.stderr));
    assert!(assert_whole(&bench) >= 1);
    let names = bench.files("out/s");
    assert!(!names.keys().any(|name| name.ends_with(".partial")), "{:?}", names.keys());
}

/// A limit on the size of files stands for a disk that is full: writes fail midway.
#[cfg(unix)]
#[test]
fn a_full_disk_leaves_whole_files_only() {
    let expected = unbroken();
    let bench = bench();
    // 40 blocks of 512 bytes: PNG files fit, EXR files do not. Ignored, the signal becomes an error.
    let script = "trap '' XFSZ; ulimit -f 40; exec \"$0\" \"$@\"";
    let output = std::process::Command::new("sh")
        .args(["-c", script, env!("CARGO_BIN_EXE_lampyris")])
        .args(RUN)
        .current_dir(bench.path(""))
        .output()
        .expect("a shell");
    assert_eq!(output.status.code(), Some(1));
    let message = text(&output.stderr);
    assert!(message.contains("view_0001.exr: File too large"), "{message}");
    assert_eq!(assert_whole(&bench), 0);
    assert!(bench.files("out/s").is_empty(), "{:?}", bench.files("out/s").keys());
    assert_eq!(finish(&bench), (8, 0));
    assert_same(&bench.files("out/s"), &expected);
}

#[test]
fn what_no_longer_matches_is_rendered_again() {
    let expected = unbroken();
    let bench = bench();
    finish(&bench);
    // A file that was changed, and one that was lost.
    fs::write(bench.path("out/s/view_0003.png"), "not what it was").expect("a written file");
    fs::remove_file(bench.path("out/s/view_0007.exr")).expect("a removed file");
    assert_eq!(finish(&bench), (1, 7), "a picture is developed, not rendered");
    assert_same(&bench.files("out/s"), &expected);
    // One view less: its files go.
    bench.write("sweep.lua", &SCRIPT.replace("k = 1, 8", "k = 1, 7"));
    assert_eq!(finish(&bench), (0, 7));
    assert!(!bench.files("out/s").contains_key("view_0008.exr"));
    bench.write("aluminium.csv", "380,0.9\n780,0.84\n");
    assert_eq!(finish(&bench), (7, 0), "the input has changed");
    bench.write("aluminium.csv", "380,0.9\n780,0.85\n");
    bench.write("sweep.lua", SCRIPT);
    assert_eq!(finish(&bench), (8, 0));
    assert_same(&bench.files("out/s"), &expected);
}

/// An executable with a byte more runs the same, but is another build.
#[cfg(unix)]
#[test]
fn another_build_renders_again() {
    let bench = bench();
    finish(&bench);
    let other = bench.path("other");
    fs::copy(env!("CARGO_BIN_EXE_lampyris"), &other).expect("a copy");
    let mut file = fs::File::options().append(true).open(&other).expect("an open file");
    std::io::Write::write_all(&mut file, b"\0").expect("a byte more");
    drop(file);
    let run = |arguments: &[&str]| {
        let mut command = std::process::Command::new(&other);
        let output = command.args(arguments).current_dir(bench.path("")).output();
        let output = output.expect("a start");
        (output.status.success(), text(&output.stdout), text(&output.stderr))
    };
    let verified = run(&["verify", "out/s/manifest.json", "--script", "sweep.lua"]);
    assert!(verified.0, "{}", verified.2);
    let note =
        "note: made by another build of lampyris 0.1.0: this one would render all views again\n";
    assert!(
        verified.2.starts_with(note) && verified.2.contains("of the same sources"),
        "{}",
        verified.2
    );
    let counts = || run(&RUN).1;
    assert_eq!((counts(), counts()), ("8\t0\n".to_owned(), "0\t8\n".to_owned()));
    run(&["run", "sweep.lua", "--quiet", "--shard=1/2", "--out=shards"]);
    bench.succeed(&["run", "sweep.lua", "--quiet", "--shard=2/2", "--out=shards"]);
    let message = bench.fail(&["merge", "shards/s"]);
    assert!(message.ends_with("differ in build of the program\n"), "{message}");
}

#[test]
fn shards_merge_to_the_bytes_of_one_run() {
    let expected = unbroken();
    let bench = bench();
    for shard in ["2/5", "5/5", "1/5", "4/5"] {
        bench.succeed(&["run", "sweep.lua", "--quiet", "--shard", shard]);
    }
    assert_eq!(bench.fail(&["merge", "out/s"]), "merge: missing or unfinished shards: 3/5\n");
    bench.succeed(&["run", "sweep.lua", "--quiet", "--shard=3/5", "--out=elsewhere"]);
    let merged = bench.succeed(&["merge", "out/s", "elsewhere/s", "--into", "whole"]);
    assert_eq!(merged, "whole: 5 shards, 8 views\n");
    assert_same(&bench.files("whole"), &expected);
    bench.succeed(&["merge", "out/s", "elsewhere/s"]);
    assert_same(&bench.files("out/s"), &expected);
}

#[test]
fn shards_of_different_inputs_do_not_merge() {
    let bench = bench();
    bench.succeed(&["run", "sweep.lua", "--quiet", "--shard=1/2"]);
    bench.write("aluminium.csv", "380,0.8\n780,0.8\n");
    bench.succeed(&["run", "sweep.lua", "--quiet", "--shard=2/2"]);
    let message = bench.fail(&["merge", "out/s"]);
    assert_eq!(message, "merge: shards 1/2 and 2/2 differ in inputs\n");
    assert!(bench.fail(&["merge", "."]).starts_with("merge: no shards"));
}

#[test]
fn verify_finds_every_change() {
    let bench = bench();
    finish(&bench);
    let arguments = ["verify", "out/s/manifest.json", "--script", "sweep.lua"];
    // 8 views of three files, contact sheet, page and crate, script and one input.
    assert_eq!(bench.succeed(&arguments), "out/s/manifest.json: 29 files are as they were\n");
    bench.write("aluminium.csv", "380,0.8\n780,0.8\n");
    fs::remove_file(bench.path("out/s/view_0002_luminance.png")).expect("a removed file");
    fs::write(bench.path("out/s/index.html"), "").expect("a written file");
    let message = bench.fail(&arguments);
    assert!(message.contains("aluminium.csv: content has changed"), "{message}");
    assert!(message.contains("view_0002_luminance.png: No such file"), "{message}");
    assert!(message.contains("index.html: content has changed"), "{message}");
    assert_eq!(message.lines().count(), 3);
}

/// In any file but the one that tells seconds. `LAMPYRIS_MUTATIONS` sets the number.
#[test]
fn verify_finds_every_flipped_bit() {
    let bench = bench();
    finish(&bench);
    let manifest = bench.path("out/s/manifest.json");
    let found = || verify(&manifest, None).map_or(1, |report| report.problems.len());
    assert_eq!(found(), 0);
    let files: Vec<(String, Vec<u8>)> = bench.files("out/s").into_iter().collect();
    let count = std::env::var("LAMPYRIS_MUTATIONS").ok().and_then(|n| n.parse().ok());
    let mut state = 1u64;
    for flip in 0..count.unwrap_or(150) {
        let mut random = |below: usize| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 33) as usize % below
        };
        let (name, good) = &files[random(files.len())];
        let mut bytes = good.clone();
        let at = random(bytes.len());
        bytes[at] ^= 1 << random(8);
        let path = bench.path(&format!("out/s/{name}"));
        fs::write(&path, bytes).expect("a written file");
        assert_ne!(found(), 0, "{flip}: byte {at} of {name}");
        fs::write(&path, good).expect("a written file");
    }
    assert_eq!(found(), 0);
}

/// A manifest that names other files is refused, so that they are neither deleted nor shown.
#[test]
fn manifests_that_name_other_files_delete_nothing() {
    let bench = bench();
    finish(&bench);
    bench.write("out/s/mine.png", "mine");
    let manifest = fs::read_to_string(bench.path("out/s/manifest.json")).expect("a manifest");
    for name in ["mine.png", "../../sweep.lua"] {
        bench.write("out/s/manifest.json", &manifest.replace("view_0003_luminance.png", name));
        let message = bench.fail(&RUN);
        assert!(message.contains("manifest.json: "), "{name}: {message}");
        assert!(bench.path("out/s/mine.png").exists() && bench.path("sweep.lua").exists());
    }
    // With a digest that fits, it is still no file of that view's.
    let mut value: serde_json::Value = serde_json::from_str(&manifest).expect("JSON");
    value["views"][2]["pictures"][0]["path"] = "mine.png".into();
    value.as_object_mut().expect("an object").remove("sha256");
    let digest = Digest::of_bytes(value.to_string().as_bytes());
    value["sha256"] = digest.as_str().into();
    bench.write("out/s/manifest.json", &format!("{value:#}\n"));
    bench.succeed(&RUN);
    assert_eq!(fs::read(bench.path("out/s/mine.png")).expect("a file"), b"mine");
}

#[test]
fn a_changed_look_renders_nothing() {
    let bench = bench();
    finish(&bench);
    let first = bench.files("out/s");
    for (old, new) in [
        ("eizo_t766 }", "eizo_t766, exposure = 3 }"),
        ("eizo_t766 }", "p3, look = \"seen\" }"),
        ("eizo_t766 }", "eizo_t766, tone = function(l) return l / (1 + l) end }"),
        ("png =", "exposure = \"each\", false_color = \"each\", png ="),
        ("x = 30, y = 20", "x = 29, y = 21"),
        ("k_rg = 0.9", "name = \"mirror\", k_rg = 0.9"),
    ] {
        bench.write("sweep.lua", &SCRIPT.replace(old, new));
        assert_eq!(finish(&bench), (0, 8), "{new}");
        let files = bench.files("out/s");
        assert!(files["view_0001.exr"] == first["view_0001.exr"], "{new}");
        let same_picture = files["view_0008.png"] == first["view_0008.png"];
        assert_eq!(same_picture, new.starts_with("x =") || new.starts_with("name"), "{new}");
    }
    bench.write("sweep.lua", SCRIPT);
    assert_eq!(finish(&bench), (0, 8));
    assert_same(&bench.files("out/s"), &first);
}

/// The same of many views, all at once: nothing that the picture does not depend on is looked at.
#[test]
fn a_hundred_views_are_developed_again() {
    const VIEWS: usize = 100;
    let script = [
        ("k = 1, 8", "k = 1, 100"),
        ("3 * k", "0.3 * k"),
        ("64, height = 48", "16, height = 12"),
        ("x = 30, y = 20", "x = 7, y = 4"),
    ];
    let change = [
        ("eizo_t766 }", "eizo_t766, exposure = 3, look = \"seen\" }"),
        ("x = 7, y = 4", "x = 6, y = 5"),
        ("k_rg = 0.9", "name = \"mirror\", k_rg = 0.9"),
    ];
    let replaced = |text: String, (old, new): &(&str, &str)| {
        assert!(text.contains(old), "{old}");
        text.replace(old, new)
    };
    let bench = bench();
    let script = script.iter().fold(SCRIPT.to_owned(), replaced);
    bench.write("sweep.lua", &script);
    assert_eq!(finish(&bench), (VIEWS, 0));
    let first = bench.files("out/s");
    bench.write("sweep.lua", &change.iter().fold(script, replaced));
    assert_eq!(finish(&bench), (0, VIEWS));
    let files = bench.files("out/s");
    for view in 1..=VIEWS {
        let [exr, png] = ["exr", "png"].map(|ending| format!("view_{view:04}.{ending}"));
        assert!(files[&exr] == first[&exr] && files[&png] != first[&png], "view {view}");
    }
}

#[test]
fn views_share_one_exposure_and_one_range() {
    let bench = bench();
    finish(&bench);
    let manifest = Manifest::read(&bench.path("out/s/manifest.json")).expect("a manifest");
    let details = |key: &str| -> Vec<serde_json::Value> {
        manifest.views.iter().map(|view| view.details[key].clone()).collect()
    };
    let factors = details("exposure");
    assert!(factors.iter().all(|factor| *factor == factors[0]), "{factors:?}");
    let automatic = details("automatic_exposure");
    let brightest = automatic.iter().filter_map(|v| v.as_f64()).fold(f64::INFINITY, f64::min);
    assert_eq!(factors[0].as_f64(), Some(brightest));
    assert!(automatic.iter().any(|factor| *factor != automatic[0]), "views differ");
    let ranges = details("false_color");
    assert!(ranges.iter().all(|range| *range == ranges[0]), "{ranges:?}");
}

#[test]
fn functions_give_views_one_by_one_or_yield_them() {
    let listed = unbroken();
    let ways = [
        "function(k) return views[k] end",
        "function() for _, v in ipairs(views) do coroutine.yield(v, scene) end end",
        "coroutine.wrap(function() for _, v in ipairs(views) do coroutine.yield(v) end end)",
        "function(k) return views[k] and { view = views[k], scene = scene } end",
    ];
    for way in ways {
        let bench = bench();
        let script = SCRIPT.replace("views = views", &format!("views = {way}"));
        bench.write("sweep.lua", &script);
        assert_eq!(finish(&bench), (8, 0), "{way}");
        let files = bench.files("out/s");
        for (name, bytes) in &listed {
            let of_script = ["manifest.json", "index.html", "ro-crate-metadata.json"];
            let of_script = of_script.contains(&name.as_str());
            assert!(of_script || files[name] == *bytes, "{way}: {name} differs");
        }
    }
}

#[test]
fn a_folder_in_use_or_of_others_is_refused() {
    let bench = bench();
    bench.write("out/s/manifest.json", "{\"name\": \"somebody's own\"}");
    let message = bench.fail(&RUN);
    assert!(message.contains("not a manifest: expected \"format\""), "{message}");
    fs::remove_file(bench.path("out/s/manifest.json")).expect("a removed file");
    let mut child = bench.command(&RUN).stdout(Stdio::null()).spawn().expect("a start");
    wait_for_views(&bench, &mut child, 1);
    let message = bench.fail(&RUN);
    assert!(message.contains("sweep: another process sweeps into out/s"), "{message}");
    child.kill().expect("SIGKILL");
    child.wait().expect("an end");
}

#[test]
fn the_page_needs_nothing_beside_it() {
    let bench = bench();
    finish(&bench);
    let page = fs::read_to_string(bench.path("out/s/index.html")).expect("a page");
    assert_eq!(page.matches("<section").count(), 8);
    assert_eq!(page.matches("data:image/png;base64,").count(), 16);
    // Spectra and colors of each view's region, and two luminances over the angle.
    assert_eq!(page.matches("colors, among those of UN R48").count(), 8);
    assert_eq!(page.matches("<svg width=").count(), 8 * 2 + 2);
    assert!(!page.contains("http:") && !page.contains("https:"));
    assert_eq!(page.matches(" src='").count(), 16 + 1, "only timings.js lies outside");
    assert!(page.contains("<script src='timings.js'>"));
}

#[test]
fn machines_read_lines_of_json() {
    let bench = bench();
    let output = bench.run(&["run", "sweep.lua", "--log=json"]);
    let events: Vec<serde_json::Value> = text(&output.stderr)
        .lines()
        .map(|line| serde_json::from_str(line).expect("a line of JSON"))
        .collect();
    let views = events.iter().filter(|event| event["event"] == "view");
    assert_eq!(views.filter_map(|event| event["view"].as_u64()).sum::<u64>(), 36);
    bench.write("wrong.lua", "error('x')");
    let output = bench.run(&["run", "wrong.lua", "--log=json"]);
    let event: serde_json::Value =
        serde_json::from_str(&text(&output.stderr)).expect("a line of JSON");
    assert_eq!(event["message"], "wrong.lua:1: x");
}

#[test]
fn a_dry_run_and_a_run_say_why_views_are_rendered_again() {
    let bench = bench();
    const DRY: [&str; 4] = ["run", "sweep.lua", "--quiet", "--dry-run"];
    let all = bench.succeed(&DRY);
    assert!(all.starts_with("out/s: 8 views would be rendered, 0 are there\n"), "{all}");
    assert!(all.contains("  view_0003: is not there yet\n"), "{all}");
    assert!(bench.files("out/s").is_empty(), "a dry run writes nothing");
    finish(&bench);
    let before = bench.files("out/s");
    let none = bench.succeed(&DRY);
    assert!(none.starts_with("out/s: 0 views would be rendered, 8 are there\n"), "{none}");
    for (from, to, cause) in [
        ("k_s = 0.9", "k_s = 0.8", "the scene has changed"),
        ("samples = 9", "samples = 4", "the quality has changed"),
        ("fov = ", "fov = 0.5 * ", "the view has changed"),
    ] {
        assert!(SCRIPT.contains(from), "{from}");
        bench.write("sweep.lua", &SCRIPT.replace(from, to));
        let said = bench.succeed(&DRY);
        assert!(said.contains(&format!("  view_0008: {cause}\n")), "{cause}: {said}");
    }
    bench.write("sweep.lua", SCRIPT);
    fs::write(bench.path("out/s/view_0002.exr"), "changed").expect("a written file");
    let said = bench.succeed(&DRY);
    let missing = "view_0002: its image is missing or not as it was written";
    assert!(said.contains("1 views would be") && said.contains(missing), "{said}");
    let run = text(&bench.run(&RUN).stderr);
    let again = "rendered again, since its image is missing or not as it was written: view_0002";
    assert!(run.contains(again), "{run}");
    assert_same(&bench.files("out/s"), &before);
}

#[test]
fn a_shorter_sweep_moves_what_is_left_aside_and_says_so() {
    let bench = bench();
    finish(&bench);
    let picture = fs::read(bench.path("out/s/view_0008.png")).expect("a picture");
    let shorter = SCRIPT.replace("k = 1, 8", "k = 1, 6");
    bench.write("sweep.lua", &shorter);
    let dry = bench.succeed(&["run", "sweep.lua", "--quiet", "--dry-run"]);
    assert!(dry.contains("  view_0008: is not of this sweep, its files would be moved"), "{dry}");
    let said = text(&bench.run(&RUN).stderr);
    let (before, rest) = said.split_once("now in ").expect("a place");
    assert!(before.contains("views of an earlier sweep into this folder"), "{said}");
    let (aside, views) = rest.split_once(": ").expect("views");
    assert_eq!(views.lines().next(), Some("view_0007, view_0008"));
    assert_eq!(fs::read(bench.path(aside).join("view_0008.png")).expect("a picture"), picture);
    assert!(!bench.path("out/s/view_0008.png").exists());
    assert!(bench.succeed(&["verify", "out/s"]).contains("files are as they were"));
}

#[test]
fn one_folder_for_each_sweep_of_a_script() {
    let bench = bench();
    bench.write("sweep.lua", &format!("{SCRIPT}\n{SCRIPT}"));
    let message = text(&bench.run(&RUN).stderr);
    let expected =
        "sweep: \"output\" is \"s\", into which this script has swept or studied already";
    assert!(message.contains(expected), "{message}");
}

#[test]
fn a_folder_is_verified_before_it_is_merged() {
    let bench = bench();
    assert!(bench.fail(&["verify", "."]).contains("holds no manifest of a sweep and no study"));
    bench.succeed(&["run", "sweep.lua", "--quiet", "--shard", "1/2"]);
    assert!(bench.fail(&["verify", "out/s"]).contains("missing shards: 2/2"));
    bench.succeed(&["run", "sweep.lua", "--quiet", "--shard", "2/2"]);
    let whole = bench.run(&["verify", "out/s", "--script", "sweep.lua"]);
    assert!(whole.status.success());
    assert_eq!(text(&whole.stderr), "note: all 2 shards are there: merge joins them\n");
    fs::write(bench.path("out/s/view_0001.exr"), "changed").expect("a written file");
    let message = bench.fail(&["verify", "out/s"]);
    assert!(message.contains("view_0001.exr: content has changed"), "{message}");
}
