//! Scripts that try to break out.

use std::process::Stdio;
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::bench::{Bench, text};

#[test]
fn nothing_that_reaches_the_system_is_there() {
    let bench = Bench::new();
    let gone = [
        "os.execute",
        "os.exit",
        "os.getenv",
        "os.remove",
        "os.rename",
        "os.setlocale",
        "os.tmpname",
        "io.open",
        "io.popen",
        "io.lines",
        "io.read",
        "io.input",
        "io.output",
        "io.tmpfile",
        "io.stdout",
        "io.stderr",
        "io.stdin",
        "debug",
        "dofile",
        "loadfile",
        "package",
        "string.dump",
        "collectgarbage and nil",
        "require('lampyris').os",
    ];
    let checks: String = gone
        .iter()
        .map(|name| {
            format!(
                "do local ok, v = pcall(function() return {name} end)\n\
                     assert(not ok or v == nil, [[{name}]]) end\n"
            )
        })
        .collect();
    bench.write("script.lua", &checks);
    bench.succeed(&["run", "script.lua"]);
}

#[test]
fn binary_chunks_and_c_modules_are_refused() {
    let bench = Bench::new();
    bench.write(
        "script.lua",
        r#"
        local f, message = load("\27Lua\x54\0\x19\x93\r\n\x1a\n", "x", "b")
        assert(f == nil and message:find("binary"), message)
        assert(not pcall(require, "../outside"))
        assert(not pcall(require, "/etc/passwd"))
        assert(not pcall(require, "socket"))
        assert(getmetatable("").__index == string)
        assert(getmetatable(require "lampyris") == false)
        assert(not pcall(setmetatable, require "lampyris", {}))
        "#,
    );
    bench.succeed(&["run", "script.lua"]);
}

const TABLE: &str = "380,1\n780,1\n";

/// A script in one folder that is run in another, beside a folder that neither may read.
fn reading_bench(path: &str) -> Bench {
    let bench = Bench::new();
    bench.write("secret/table.csv", TABLE);
    bench.write("scripts/own.csv", TABLE);
    bench.write("work/here.csv", TABLE);
    let script = format!("require('lampyris').spectrum.load(\"{path}\")");
    bench.write("scripts/script.lua", &script);
    bench
}

fn run_in_work(bench: &Bench, more: &[&str]) -> (bool, String) {
    let mut command = bench.command(&["run", "../scripts/script.lua"]);
    let output = command.args(more).current_dir(bench.path("work")).output().expect("a start");
    (output.status.success(), text(&output.stderr))
}

#[test]
fn reading_stays_in_the_known_folders() {
    for path in ["own.csv", "here.csv", "../scripts/own.csv", "../work/here.csv"] {
        let (success, message) = run_in_work(&reading_bench(path), &[]);
        assert!(success, "{path}: {message}");
    }
    let absolute = reading_bench("").path("secret/table.csv").display().to_string();
    let inside = reading_bench("../secret/table.csv");
    let (success, message) = run_in_work(&inside, &[]);
    assert!(!success);
    assert_eq!(
        message,
        "../scripts/script.lua:1: input: path is \"../secret/table.csv\", allowed: files in the \
         script's folder, the working directory and --read DIR\n"
    );
    let (success, message) = run_in_work(&inside, &["--read", "../secret"]);
    assert!(success, "{message}");
    for path in ["/etc/hostname", &absolute] {
        let (success, _) = run_in_work(&reading_bench(path), &[]);
        assert!(!success, "{path}");
    }
}

#[test]
fn a_projects_scripts_read_its_data_from_anywhere() {
    let bench = reading_bench("../data/table.csv");
    bench.write("data/table.csv", "400,1\n700,1\n");
    let (success, message) = run_in_work(&bench, &[]);
    assert!(success, "{message}");
    let mut command = bench.command(&["run", "script.lua"]);
    let output = command.current_dir(bench.path("scripts")).output().expect("a start");
    assert!(output.status.success(), "{}", text(&output.stderr));
    // Other folders beside other scripts stay closed.
    bench.write("downloads/script.lua", "require('lampyris').spectrum.load '../data/table.csv'");
    let mut command = bench.command(&["run", "../downloads/script.lua"]);
    let output = command.current_dir(bench.path("work")).output().expect("a start");
    assert!(text(&output.stderr).contains("allowed: files in the script's folder"));
}

#[cfg(unix)]
#[test]
fn symbolic_links_lead_nowhere() {
    use std::os::unix::fs::symlink;
    let bench = reading_bench("link.csv");
    symlink(bench.path("secret/table.csv"), bench.path("scripts/link.csv")).expect("a link");
    let (success, message) = run_in_work(&bench, &[]);
    assert!(!success && message.contains("input: path is \"link.csv\""), "{message}");

    let bench = Bench::new();
    bench.write("secret/module.lua", "return 1");
    symlink(bench.path("secret"), bench.path("modules")).expect("a link");
    bench.write("inner/script.lua", "require 'm.module'");
    symlink(bench.path("secret"), bench.path("inner/m")).expect("a link");
    let mut command = bench.command(&["run", "script.lua"]);
    let output = command.current_dir(bench.path("inner")).output().expect("a start");
    assert!(!output.status.success());
    assert!(text(&output.stderr).contains("allowed: files in the script's folder"));
}

const SAVE: &str = "require('lampyris').mesh.new {
  positions = { {0,0,0}, {1,0,0}, {0,1,0} }, triangles = { {1,2,3} },
}:save(PATH)";

#[cfg(unix)]
#[test]
fn writing_stays_below_the_output_folder() {
    use std::os::unix::fs::symlink;
    let bench = Bench::new();
    std::fs::create_dir_all(bench.path("secret")).expect("a folder");
    std::fs::create_dir_all(bench.path("out")).expect("a folder");
    symlink(bench.path("secret"), bench.path("out/link")).expect("a link");
    for path in ["../m.obj", "/tmp/m.obj", "a/../../m.obj", "link/m.obj", "link/deep/m.obj", ""] {
        let message = bench.fail_script(&SAVE.replace("PATH", &format!("\"{path}\"")));
        let expected = format!("output: path is \"{path}\", allowed: below out/");
        assert!(message.contains(&expected), "{path}: {message}");
    }
    assert_eq!(bench.files("secret").len(), 0);
    // A link in the place of the file itself is replaced, not followed.
    symlink(bench.path("secret/m.obj"), bench.path("out/m.obj")).expect("a link");
    bench.write("script.lua", &SAVE.replace("PATH", "\"m.obj\""));
    bench.succeed(&["run", "script.lua"]);
    assert_eq!(bench.files("secret").len(), 0);
    // A sweep's folder is an output like others.
    let sweep = |output: &str| {
        bench.fail_script(&format!(
            "require('lampyris').sweep {{ views = {{}}, output = \"{output}\" }}"
        ))
    };
    for output in ["..", "../s", "/tmp/s", "link"] {
        assert!(sweep(output).contains("allowed: below out/"), "{output}");
    }
}

#[test]
fn memory_is_limited() {
    let bench = Bench::new();
    bench.write("script.lua", "local t = {} for i = 1, 1e9 do t[i] = ('x'):rep(1000) .. i end");
    let message = bench.fail(&["run", "script.lua", "--max-memory", "50M"]);
    assert_eq!(message, "script: out of memory\n");
    bench.write("script.lua", "pcall(string.rep, 'x', 1e9) print(#('x'):rep(1e6))");
    assert_eq!(bench.succeed(&["run", "script.lua", "--max-memory", "50M"]), "1000000\n");
    for wrong in ["0", "-1", "5T", "M", "99999999999G"] {
        let output = bench.run(&["run", "script.lua", "--max-memory", wrong]);
        assert_eq!(output.status.code(), Some(2), "{wrong}");
    }
}

/// Loops that only an interrupt from outside can end.
#[cfg(unix)]
#[test]
fn ctrl_c_ends_endless_loops() {
    let loops = [
        "while true do end",
        "while true do pcall(error) end",
        "while true do pcall(function() while true do end end) end",
        "local f = coroutine.wrap(function() while true do end end) f()",
        "while true do local c = coroutine.create(function() while true do end end) \
         coroutine.resume(c) end",
        "while true do xpcall(function() while true do end end, function() end) end",
        "local t = setmetatable({}, {__index = function(t, k) return t[k + 1] end}) \
         while true do pcall(function() return t[1] end) end",
    ];
    for body in loops {
        let bench = Bench::new();
        bench.write("script.lua", &format!("io.write('started\\n')\n{body}"));
        let mut command = bench.command(&["run", "script.lua"]);
        let command = command.stdout(Stdio::null()).stderr(Stdio::piped());
        let mut child = command.spawn().expect("a start");
        sleep(Duration::from_millis(150));
        assert!(child.try_wait().expect("a status").is_none(), "{body}: has ended by itself");
        let id = child.id().to_string();
        std::process::Command::new("kill").args(["-INT", &id]).status().expect("kill runs");
        let start = Instant::now();
        while child.try_wait().expect("a status").is_none() {
            if start.elapsed() > Duration::from_secs(10) {
                child.kill().expect("SIGKILL");
                panic!("{body}: goes on after Ctrl-C");
            }
            sleep(Duration::from_millis(5));
        }
        let output = child.wait_with_output().expect("an end");
        assert_eq!(output.status.code(), Some(130), "{body}: {}", text(&output.stderr));
    }
}

/// What is stuck inside of a function of Lua's library, or where Lua asks for no hook.
#[cfg(unix)]
#[test]
fn ctrl_c_ends_what_never_looks_up() {
    let bodies = [
        "string.rep('', 1 << 60)",
        "string.find(('a'):rep(60), ('a?'):rep(60) .. ('a'):rep(60))",
        "string.gsub(('a'):rep(60), ('a-'):rep(60) .. 'b', '')",
        "table.move({}, 1, 1 << 60, 2)",
    ];
    let bench = Bench::new();
    let mut children = Vec::new();
    for (at, body) in bodies.iter().enumerate() {
        let name = format!("{at}.lua");
        bench.write(&name, &format!("pcall(function() {body} end) while true do end"));
        let mut command = bench.command(&["run", &name]);
        let child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn();
        children.push((body, child.expect("a start")));
    }
    sleep(Duration::from_millis(300));
    for (_, child) in &children {
        let id = child.id().to_string();
        std::process::Command::new("kill").args(["-INT", &id]).status().expect("kill runs");
    }
    let start = Instant::now();
    for (body, mut child) in children {
        while child.try_wait().expect("a status").is_none() {
            if start.elapsed() > Duration::from_secs(15) {
                child.kill().expect("SIGKILL");
                panic!("{body}: goes on after Ctrl-C");
            }
            sleep(Duration::from_millis(20));
        }
        let output = child.wait_with_output().expect("an end");
        assert_eq!(output.status.code(), Some(130), "{body}: {}", text(&output.stderr));
        assert_eq!(text(&output.stderr), "interrupted\n", "{body}");
    }
}

/// What Lua offers to get at values that are not the script's own.
#[test]
fn the_state_is_closed() {
    let bench = Bench::new();
    bench.write("outside.lua", "return 1");
    bench.write("inner/.hidden.lua", "return 1");
    bench.write("inner/data.csv", "380,1\n780,1\n");
    bench.write(
        "inner/script.lua",
        r##"
        local L = require "lampyris"
        local function refused(f, ...)
          local ok, message = pcall(f, ...)
          assert(not ok, "went through")
          return tostring(message)
        end
        -- Bytecode, also from a reader function, also where "b" asks for it.
        local bytes = "\27Lua\x54\0\x19\x93\r\n\x1a\n"
        for _, mode in ipairs { "b", "bt", "t" } do
          local pieces = { bytes }
          local f, message = load(function() return table.remove(pieces) end, "x", mode)
          assert(f == nil and message:find "binary", message)
        end
        assert(string.dump == nil and debug == nil and package == nil)
        -- Names of modules that are paths.
        for _, name in ipairs {
          "../outside", "..outside", ".hidden", "a/b", "/etc/passwd", "a\\b", "a\0b", "", ".", "..",
          "outside\0", "%2e%2e/outside",
        } do refused(require, name) end
        refused(require, 3)
        refused(require, {})
        -- Paths of inputs.
        for _, path in ipairs { "../outside.lua", "/etc/passwd", "/proc/self/environ", "./../outside.lua",
          "data.csv/../../outside.lua", "data.csv\0.png", "" } do
          refused(L.read, path)
        end
        -- Handles and modules keep their metatables to themselves.
        for _, value in ipairs { L.spectrum.constant(1), L.display.srgb, L, L.mesh } do
          local meta = getmetatable(value)
          assert(type(meta) ~= "table", "a metatable can be had")
          refused(setmetatable, value, {})
        end
        -- Standard output can be written, not read, moved or closed.
        local file = io.write(""):write("")
        for _, name in ipairs { "close", "flush", "lines", "read", "seek", "setvbuf" } do
          assert(file[name] == nil, name)
        end
        assert(getmetatable(file) == false)
        -- What strings share is the script's own: to spoil it spoils nothing of ours.
        getmetatable("").__index = function() return nil end
        getmetatable("").__add = function() return 7 end
        assert("a" + 1 == 7)
        refused(L.view, { fov_deg = 3 })
        assert(pcall(L.spectrum.load, "data.csv"))
        -- Nor does it help to replace what our functions were made from.
        rawset(_G, "pcall", nil)
        rawset(_G, "error", nil)
        tostring = nil
        assert(L.spectrum.load("data.csv"):at(500) == 1)
        -- Coroutines: the same world.
        local c = coroutine.wrap(function() return io.open, os.execute end)
        assert(select("#", c()) == 2 and c == c)
        "##,
    );
    let mut command = bench.command(&["run", "script.lua"]);
    let output = command.current_dir(bench.path("inner")).output().expect("a start");
    assert!(output.status.success(), "{}", text(&output.stderr));
}

#[test]
fn random_numbers_repeat() {
    let bench = Bench::new();
    bench.write("script.lua", "print(math.random(1e9), math.random())");
    assert_eq!(bench.succeed(&["run", "script.lua"]), bench.succeed(&["run", "script.lua"]));
}
