//! What was tried from outside, each as it was found.

use std::process::Stdio;

use crate::bench::{Bench, text};

/// Before a script's own lines.
const BEFORE: &str = r#"
local L = require "lampyris"
local scene = L.scene { objects = {} }
local view = L.view { width = 2, height = 2 }
"#;

fn message_of(bench: &Bench, script: &str, more: &[&str]) -> String {
    bench.write("script.lua", &format!("{BEFORE}{script}\n"));
    bench.fail(&[&["run", "script.lua"], more].concat())
}

#[test]
fn finalizers_are_never_run() {
    let bench = Bench::new();
    bench.write(
        "script.lua",
        "local L = require 'lampyris'
         local meta = { __gc = function() print(tostring(L.spectrum.constant(1))) end }
         G = setmetatable({}, meta)
         assert(meta.__gc and getmetatable(G) == meta)
         for _ = 1, 10 do setmetatable({}, meta) end
         collectgarbage()
         assert(not pcall(setmetatable, L, { __gc = print }))",
    );
    let output = bench.run(&["run", "script.lua"]);
    assert_eq!((output.status.code(), text(&output.stdout)), (Some(0), String::new()));
    let warning = "warning: setmetatable: finalizers (__gc) are never run; <close> is (12 times)\n";
    assert_eq!(text(&output.stderr), warning);
}

#[test]
fn tables_in_themselves_end_in_a_message() {
    let bench = Bench::new();
    for key in ["exposure", "tone", "glare", "display", "look"] {
        let script = format!(
            "local t = {{}} t.{key} = t
             L.sweep {{ scene = scene, views = {{ view }}, output = 's', png = {{ {key} = t }} }}"
        );
        assert!(message_of(&bench, &script, &[]).starts_with("script.lua:6: sweep: png"), "{key}");
    }
    let deep = "local t = {} for _ = 1, 1e6 do t = { t } end image = scene:render(view)
                image:save('x.png', { glare = t })";
    assert!(message_of(&bench, deep, &[]).contains("unknown key"));
}

#[test]
fn what_does_not_fit_is_told_before_it_is_made() {
    let bench = Bench::new();
    let large = "scene:render(L.view { width = 16384, height = 16384 })";
    let message = message_of(&bench, large, &["--max-memory", "500M"]);
    let start =
        "script.lua:5: scene:render: a picture of 16384 × 16384 pixels: needs 191.1 GB, but ";
    let end = " of --max-memory 0.5 GB are in use: fewer pixels, or a larger wavelength_step, would fit\n";
    assert!(message.starts_with(start) && message.ends_with(end), "{message}");
    let surface = "L.mesh.surface { nu = 1e5, nv = 1e5, point = function() return 0, 0, 0 end }";
    assert!(
        message_of(&bench, surface, &["--max-memory", "1G"]).contains("mesh.surface: needs 1280")
    );
    let endless = "load(function() return string.rep('x', 1e6) end)";
    assert!(message_of(&bench, endless, &["--max-memory", "100M"]).contains("memory"));
    bench.write("script.lua", &format!("{BEFORE}assert(not pcall(function() {large} end))"));
    bench.succeed(&["run", "script.lua", "--max-memory", "500M"]);
}

#[test]
fn loops_that_drop_pictures_stay_flat() {
    let bench = Bench::new();
    let script = "local peak
        for _ = 1, 24 do
            local image = scene:render(L.view { width = 320, height = 240 }, { samples = 1 })
            peak = image.stats.peak_memory_mb
        end
        assert(peak < 300, peak)"; // 25 MB a picture, and its film
    bench.write("script.lua", &format!("{BEFORE}{script}"));
    bench.succeed(&["run", "script.lua", "--quiet"]);
}

const SAVE_RAYS: &str =
    "local lamp = L.cylinder { radius = 1, length = 1, flux = 1, samples = 2000,
    spectrum = L.spectrum.constant(1) }
    for _ = 1, 20 do lamp:save('lamp.csv') end";

#[cfg(unix)]
#[test]
fn ray_files_follow_no_link_and_share_no_name() {
    let bench = Bench::new();
    bench.write("secret", "untouched");
    bench.write("out/other", "");
    let link = bench.path("out/lamp.csv.part");
    std::os::unix::fs::symlink(bench.path("secret"), link).expect("a link");
    bench.write("script.lua", &format!("{BEFORE}{SAVE_RAYS}"));
    let start = || {
        let mut command = bench.command(&["run", "script.lua", "--threads=1"]);
        command.stderr(Stdio::piped()).spawn().expect("a start")
    };
    let savers: Vec<_> = (0..4).map(|_| start()).collect();
    for saver in savers {
        let output = saver.wait_with_output().expect("an end");
        assert!(output.status.success(), "{}", text(&output.stderr));
    }
    assert_eq!(std::fs::read_to_string(bench.path("secret")).expect("a file"), "untouched");
    let info = bench.succeed(&["info", "out/lamp.csv"]);
    assert!(info.starts_with("out/lamp.csv: ray file (CSV), 2000 rays\n"), "{info}");
    assert_eq!(bench.files("out").len(), 3);
}

/// A folder becomes a link to another while files are saved in it.
#[cfg(target_os = "linux")]
#[test]
fn no_swap_of_folders_leads_writes_outside() {
    let bench = Bench::new();
    for folder in ["secret", "out/d"] {
        std::fs::create_dir_all(bench.path(folder)).expect("a folder");
    }
    // On a busy machine one turn of the processor may hold 500 tries: go on until some are saved.
    let script = "local tries, saved, start = 0, 0, os.clock()
        while tries < 500 or saved < 10 do
            tries = tries + 1
            if pcall(L.write, 'd/t.txt', 'x') then saved = saved + 1 end
            assert(os.clock() < start + 20, saved)
        end";
    bench.write("script.lua", &format!("{BEFORE}{script}"));
    let mut child = bench.command(&["run", "script.lua"]).spawn().expect("a start");
    let (folder, aside) = (bench.path("out/d"), bench.path("out/aside"));
    while child.try_wait().expect("a status").is_none() {
        // The script may make the folder anew at any moment, so that any of these may fail.
        let _ = std::fs::rename(&folder, &aside);
        let _ = std::os::unix::fs::symlink(bench.path("secret"), &folder);
        let _ = std::fs::remove_file(&folder);
        let _ = std::fs::remove_dir_all(&folder);
        let _ = std::fs::rename(&aside, &folder);
    }
    assert!(child.wait().expect("an end").success());
    assert_eq!(bench.files("secret").len(), 0);
}

/// A folder becomes a link to another while files in it are read. Each reading has a name of its
/// own: of a known name a changed file is noticed.
#[cfg(target_os = "linux")]
#[test]
fn no_swap_of_folders_leads_reads_outside() {
    let bench = Bench::new();
    bench.write("secret/t.csv", "380,1\n780,1\n");
    bench.write("in/d/t.csv", "380,2\n780,2\n");
    let script = "local read = 0
        for at = 1, 6000 do
            local name = string.rep('./', at % 1500) .. 'd/t.csv'
            local text, value
            if at % 2 == 0 then
                text, value = pcall(L.read, name)
                value = value:sub(5, 5) == '1' and 1
            else
                text, value = pcall(L.spectrum.load, name)
                value = text and value:at(500)
            end
            assert(value ~= 1, 'outside')
            if text then read = read + 1 end
        end
        assert(read > 0)";
    bench.write("in/script.lua", &format!("{BEFORE}{script}"));
    let mut command = bench.command(&["run", "script.lua"]);
    let mut child = command.current_dir(bench.path("in")).spawn().expect("a start");
    let (folder, aside) = (bench.path("in/d"), bench.path("in/aside"));
    while child.try_wait().expect("a status").is_none() {
        std::fs::rename(&folder, &aside).expect("a folder");
        std::os::unix::fs::symlink(bench.path("secret"), &folder).expect("a link");
        std::fs::remove_file(&folder).expect("a link");
        std::fs::rename(&aside, &folder).expect("a folder");
    }
    assert!(child.wait().expect("an end").success());
}

#[test]
fn finite_in_and_finite_out() {
    let bench = Bench::new();
    let allowed = "allowed: finite numbers up to 1e32";
    let huge_rays =
        format!("x,y,z,dx,dy,dz,flux,wavelength\n{}", "0,0,0,0,0,1,3e38,555\n".repeat(9));
    for script in [
        "L.spectrum.constant(1e308)",
        "L.spectrum.new { { 400, 1 }, { 500, -1e33 } }",
        "local s = L.spectrum.constant(1e29) s = s * s",
        "local s = L.spectrum.constant(1e32) s = s + s",
        "L.spectrum.load 'huge.csv'",
        "L.scene { objects = {}, background = 1e38 }",
        "L.mesh.new { positions = { { 0, 0, 0 }, { 1e200, 0, 0 }, { 0, 1, 0 } }, triangles = { { 1, 2, 3 } } }",
        "triangle:transform { scale = 1e308 }",
        "L.rayset.load 'rays.csv'",
        "L.rayset.new { positions = { { 0, 0, 0 } }, directions = { { 0, 0, 1 } }, flux = 1e40, spectrum = 1 }",
    ] {
        bench.write("huge.csv", "380,1\n780,1e308\n");
        bench.write("rays.csv", &huge_rays);
        let triangle = "local triangle = L.mesh.new { positions = { { 0, 0, 0 }, { 1, 0, 0 },
            { 0, 1, 0 } }, triangles = { { 1, 2, 3 } } }";
        let message = message_of(&bench, &format!("{triangle} {script}"), &[]);
        assert!(message.ends_with(&format!("{allowed}\n")), "{script}: {message}");
    }
    bench.write("ramps.csv", "R,0,0\nR,128,inf\nR,255,20\nG,0,0\nG,255,60\nB,0,0\nB,255,8\n");
    let fit = "L.display.fit { file = 'ramps.csv' }";
    assert!(message_of(&bench, fit, &[]).contains("luminance is inf, allowed: finite"));
    let two = "local points = {}
        for a = 0, 20 do points[a + 1] = { a, math.cos(math.rad(a)) ^ 50 } end
        L.fit_lobe { points = points, lobes = 2 }";
    assert!(message_of(&bench, two, &[]).contains("lobe fit: "));
    let grow = "local mesh = L.mesh.new { positions = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } },
            triangles = { { 1, 2, 3 } } }
        for _ = 1, 12 do mesh = mesh:transform { scale = 1e30 } end";
    let message = message_of(&bench, grow, &[]);
    assert!(message.contains("mesh:transform: position 2 is [inf, "), "{message}");
    let sum = "local image = scene:render(view)
        for _ = 1, 20 do image = L.image.sum { { image, 1e30 }, { image, 1e30 } } end";
    let scene = "scene = L.scene { objects = {}, background = 1 }";
    for save in ["image:save 'v.exr'", "image:save 'v.png'"] {
        let message = message_of(&bench, &format!("{scene} {sum} {save}"), &[]);
        assert!(message.contains("image: pixel x = 0, y = 0 "), "{message}");
    }
    assert!(!bench.path("out/v.exr").exists() && !bench.path("out/v.png").exists());
}

#[test]
fn inputs_that_change_are_noticed() {
    let bench = Bench::new();
    let script = "L.write('t.csv', '380,1\\n780,1\\n')
        local t = L.spectrum.load 't.csv'
        local start = os.clock() while os.clock() < start + 0.05 do end
        L.write('t.csv', '380,2\\n780,2\\n')
        L.sweep { scene = scene, views = { view }, output = 's' }";
    let message = message_of(&bench, script, &["--out", "."]);
    let problem = "input: t.csv has changed since it was read: run the script again\n";
    assert!(message.ends_with(problem), "{message}");
}

/// The buffers of a glTF file are read with it.
#[test]
fn files_beside_an_input_that_change_are_noticed() {
    const TRIANGLE: &str = r#"{ "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }], "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
        "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
            "min": [0, 0, 0], "max": [1, 1, 0] }],
        "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
        "buffers": [{ "uri": "t.bin", "byteLength": 36 }] }"#;
    let bench = Bench::new();
    bench.write("part/t.gltf", TRIANGLE);
    let corners: Vec<u8> =
        [0f32, 0., 0., 1., 0., 0., 0., 1., 0.].iter().flat_map(|v| v.to_le_bytes()).collect();
    std::fs::write(bench.path("part/t.bin"), corners).expect("a written file");
    let script = "local mesh = L.mesh.load('part/t.gltf', { unit = 'mm' })
        assert(mesh.area == 0.5)
        local start = os.clock() while os.clock() < start + 0.05 do end
        L.write('part/t.bin', ('x'):rep(36))
        L.sweep { scene = scene, views = { view }, output = 's' }";
    let message = message_of(&bench, script, &["--out", "."]);
    let problem = "input: part/t.bin has changed since it was read: run the script again\n";
    assert!(message.ends_with(problem), "{message}");
}

#[test]
fn views_do_not_write_each_others_files() {
    let bench = Bench::new();
    let script = "L.sweep { scene = scene, output = 's', views = {
        { view = view, name = 'a' }, { view = view, name = 'a_luminance' } } }";
    let message = message_of(&bench, script, &[]);
    let problem = "sweep: views: \"a_luminance\" and another view both write a_luminance.png\n";
    assert!(message.ends_with(problem), "{message}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_device_is_an_error_and_a_closed_pipe_is_none() {
    let bench = Bench::new();
    bench.write("script.lua", "print 'lost'");
    bench.write("t.csv", "380,1\n780,1\n");
    for arguments in [&["run", "script.lua"][..], &["info", "t.csv"], &["options", "view"]] {
        let full = std::fs::File::options().write(true).open("/dev/full").expect("a device");
        let output = bench.command(arguments).stdout(full).output().expect("a start");
        assert_eq!(output.status.code(), Some(1), "{arguments:?}");
        assert!(text(&output.stderr).contains("standard output: No space left"), "{arguments:?}");
        let (reader, writer) = std::io::pipe().expect("a pipe");
        drop(reader);
        let output = bench.command(arguments).stdout(writer).output().expect("a start");
        assert!(!text(&output.stderr).contains("panic"), "{arguments:?}");
        assert!(matches!(output.status.code(), Some(0 | 1)), "{arguments:?}");
    }
}

#[test]
fn the_same_script_gives_the_same_bytes_from_everywhere() {
    let bench = Bench::new();
    let script = "scene:render(view):save 'v.exr' scene:render(view):save 'v.png'";
    bench.write("a/b/script.lua", &format!("{BEFORE}{script}"));
    let whole = bench.path("a/b/script.lua").display().to_string();
    let pictures = |folder: &str, script: &str| {
        std::fs::create_dir_all(bench.path(folder)).expect("a folder");
        let mut command = bench.command(&["run", script, "--quiet"]);
        let output = command.current_dir(bench.path(folder)).output().expect("a start");
        assert!(output.status.success(), "{}", text(&output.stderr));
        bench.files(&format!("{folder}/out"))
    };
    let first = pictures("a/b", "script.lua");
    assert_eq!(first, pictures("a", "b/script.lua"));
    assert_eq!(first, pictures("c", &whole));
}

#[cfg(unix)]
#[test]
fn named_pipes_are_not_waited_for() {
    let bench = Bench::new();
    let made = std::process::Command::new("mkfifo").arg(bench.path("pipe.csv")).status();
    assert!(made.expect("mkfifo").success());
    assert_eq!(bench.fail(&["info", "pipe.csv"]), "pipe.csv: is no regular file\n");
    let message = message_of(&bench, "L.spectrum.load 'pipe.csv'", &[]);
    assert_eq!(message, "script.lua:5: pipe.csv: is no regular file\n");
}

#[test]
fn nobody_learns_what_is_outside() {
    let bench = Bench::new();
    bench.write("outside/there.csv", "380,1\n780,1\n");
    bench.write("inside/script.lua", "");
    let message = |path: &str| {
        bench.write("inside/script.lua", &format!("require('lampyris').read '{path}'"));
        let mut command = bench.command(&["run", "script.lua"]);
        let output = command.current_dir(bench.path("inside")).output().expect("a start");
        text(&output.stderr).replace(path, "PATH")
    };
    assert_eq!(message("../outside/there.csv"), message("../outside/nowhere.csv"));
    assert_eq!(message("/etc/hostname"), message("/etc/no-such-file"));
    assert!(message("../outside/no/folder.csv").contains("allowed: files in the script's folder"));
    assert!(message("nowhere.csv").contains("No such file"));
}

#[test]
fn printing_is_as_lua_prints() {
    let bench = Bench::new();
    bench.write("script.lua", "print(1, 2.0, nil, 'x') io.write('a', 1, 2.5):write 'b\\n' print()");
    assert_eq!(bench.succeed(&["run", "script.lua"]), "1\t2.0\tnil\tx\na12.5b\n\n");
    assert!(bench.fail_script("io.write({})").contains("string expected, got table"));
}

#[test]
fn merging_again_is_no_fault() {
    let bench = Bench::new();
    let script = "L.sweep { scene = scene, views = { view, view }, output = 's' }";
    bench.write("script.lua", &format!("{BEFORE}{script}"));
    for shard in ["1/2", "2/2"] {
        bench.succeed(&["run", "script.lua", "--shard", shard, "--quiet"]);
    }
    assert_eq!(bench.succeed(&["merge", "out/s"]), "out/s: 2 shards, 2 views\n");
    let merged = bench.files("out/s");
    assert_eq!(bench.succeed(&["merge", "out/s"]), "out/s: 0 shards, 2 views\n");
    assert_eq!(bench.files("out/s"), merged);
}

/// Every call returns or raises an error that `pcall` catches.
#[test]
fn random_calls_break_nothing() {
    let bench = Bench::new();
    bench.write("random.lua", include_str!("random.lua"));
    let options = bench.succeed(&["options"]);
    let rows = options.lines().filter_map(|line| line.strip_prefix("  "));
    let keys: Vec<&str> = rows.filter_map(|row| row.split([' ', '?']).next()).collect();
    for seed in ["1", "2", "3"] {
        let arguments = ["run", "random.lua", "--quiet", "--max-memory", "1G", "--"];
        let output = bench.run(&[&arguments[..], &[seed, &keys.join(" "), "1500"]].concat());
        let message = text(&output.stderr);
        assert!(output.status.success() && !message.contains("a bug"), "{seed}: {message}");
    }
}
