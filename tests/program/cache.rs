//! What a run leaves for the next.

use std::process::Stdio;

use crate::bench::Bench;

const SCRIPT: &str = r#"
local lampyris = require "lampyris"
local plate = lampyris.mesh.surface { nu = 2, nv = 2,
    point = function(u, v) return 40 * u - 20, 40 * v - 20, -30 end }
local material = lampyris.material { reflectance = 0.8, k_d = 0.5, k_s = 0.4, n_s = 50 }
local bulb = lampyris.bulb("P21W", { samples = 60000 })
local scene = lampyris.scene { objects = { { mesh = plate, material = material } }, lights = { bulb } }
scene:render(lampyris.view { width = 16, height = 12 }):save("a.exr")
"#;

fn kept(bench: &Bench, folder: &str) -> usize {
    std::fs::read_dir(bench.path(folder)).map_or(0, Iterator::count)
}

#[test]
fn pictures_are_the_same_with_and_without_a_cache() {
    let bench = Bench::new();
    bench.write("script.lua", SCRIPT);
    let render = |arguments: &[&str]| {
        bench.succeed(&[&["run", "script.lua", "--out", "out"], arguments].concat());
        std::fs::read(bench.path("out/a.exr")).expect("a picture")
    };
    let alone = render(&["--cache", "off"]);
    for _ in 0..2 {
        assert!(render(&["--cache", "kept"]) == alone);
        assert_eq!(kept(&bench, "kept"), 2, "samples and tree");
    }
    assert!(render(&["--cache", "small", "--cache-size", "1K"]) == alone);
    assert_eq!(kept(&bench, "small"), 0);
}

#[test]
fn processes_share_a_cache() {
    let bench = Bench::new();
    bench.write("script.lua", SCRIPT);
    let start = |index: usize| {
        let out = format!("out{index}");
        let mut command = bench.command(&["run", "script.lua", "--threads", "1", "--out", &out]);
        command.env("LAMPYRIS_CACHE", "kept").stdout(Stdio::null()).spawn().expect("a process")
    };
    let running: Vec<_> = (0..6).map(start).collect();
    let ended = running.into_iter().map(|mut process| process.wait().expect("an end"));
    assert!(ended.map(|status| status.success()).collect::<Vec<_>>().iter().all(|good| *good));
    let picture = |index| std::fs::read(bench.path(&format!("out{index}/a.exr"))).unwrap();
    assert!((1..6).all(|index| picture(index) == picture(0)));
    assert_eq!(kept(&bench, "kept"), 2);
}

#[test]
fn a_cache_that_cannot_be_is_refused_where_it_was_asked_for() {
    let bench = Bench::new();
    bench.write("script.lua", SCRIPT);
    bench.write("file", "text");
    let message = bench.fail(&["run", "script.lua", "--cache", "file"]);
    assert!(message.starts_with("file: "), "{message}");
    // The user's own may be anything.
    let mut command = bench.command(&["run", "script.lua"]);
    command.env_remove("LAMPYRIS_CACHE").env("XDG_CACHE_HOME", bench.path("file"));
    assert!(command.output().expect("the program starts").status.success());
}

#[test]
fn scripts_do_not_reach_it() {
    let bench = Bench::new();
    bench.write("script.lua", "require('lampyris').write('../kept/a.cache', 'text')");
    let message = bench.fail(&["run", "script.lua", "--cache", "kept"]);
    assert!(message.contains("kept/a.cache"), "{message}");
    assert_eq!(kept(&bench, "kept"), 0);
}
