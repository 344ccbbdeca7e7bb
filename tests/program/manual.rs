//! Every Lua example of the manual runs, in a tiny mode.

use std::fs;
use std::path::Path;

use crate::bench::{Bench, text};

/// The files that examples read.
const FILES: &[[&str; 2]] = &[
    ["lens.obj", "v -20 -20 30\nv 20 -20 30\nv 20 20 30\nv -20 20 30\nf 1 2 3 4\n"],
    ["reflector.obj", "v -20 -20 0\nv 20 -20 0\nv 20 20 0\nv -20 20 0\nf 1 2 3 4\n"],
    ["aluminium.csv", "380,0.92\n780,0.88\n"],
    ["red.csv", "nm,transmittance\n380,0\n580,0\n620,0.9\n780,0.95\n"],
    ["p21w.tm25ray", RAYS],
    ["bulb.csv", RAYS],
    ["lobe.csv", "0,1\n1,0.9\n2,0.7\n3,0.45\n4,0.25\n5,0.12\n"],
];

/// Of a bulb; what a ray file is shows in its content.
const RAYS: &str =
    "x,y,z,dx,dy,dz,flux,wavelength\n0,0,20,0,0,-1,5,550\n0,0,20,1,0,0,5,600\n1,0,20,0,1,0,5,500\n";

/// Makes pictures tiny: what an example asks for in pixels, samples and surface cells is divided.
const TINY: &str = r#"
local real = require "lampyris"
local function smaller(make, limits)
  return function(...)
    local arguments = { ... }
    local options = arguments[#arguments]
    if type(options) == "table" then
      for key, most in pairs(limits) do
        options[key] = math.min(options[key] or most, most)
      end
    end
    return make(table.unpack(arguments))
  end
end
local mesh = setmetatable({ surface = smaller(real.mesh.surface, { nu = 16, nv = 16 }) },
  { __index = real.mesh })
local photometry = { grid = smaller(real.photometry.grid, { width = 12, height = 9 }) }
local tiny = setmetatable({
  view = smaller(real.view, { width = 16, height = 12 }),
  mesh = mesh,
  photometry = photometry,
  bulb = function(category, options)
    options = options or {}
    options.samples = 20
    return real.bulb(category, options)
  end,
}, { __index = real })
local real_require = require
function require(name) return name == "lampyris" and tiny or real_require(name) end
"#;

/// Code between "```lua" and "```".
fn examples(page: &str) -> Vec<String> {
    let blocks = page.split("```lua\n").skip(1);
    blocks.filter_map(|block| block.split_once("```")).map(|(code, _)| code.to_owned()).collect()
}

#[test]
fn every_example_runs() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut count = 0;
    let docs = fs::read_dir(root.join("docs")).expect("the manual");
    let docs = docs.map(|entry| entry.expect("an entry").path());
    let docs = docs.filter(|path| path.extension().is_some_and(|kind| kind == "md"));
    for path in docs.chain([root.join("README.md")]) {
        let page = fs::read_to_string(&path).expect("a page");
        for (at, example) in (1..).zip(examples(&page)) {
            let bench = Bench::new();
            FILES.iter().for_each(|[name, content]| bench.write(name, content));
            bench.write("example.lua", &format!("{TINY}{example}"));
            let output = bench.run(&["run", "example.lua", "--quiet"]);
            let message = crate::bench::text(&output.stderr);
            assert!(output.status.success(), "{} example {at}: {message}", path.display());
            count += 1;
        }
    }
    assert!(count >= 12, "{count} examples");
}

#[test]
fn the_starter_script_runs_as_it_is() {
    let bench = Bench::new();
    assert_eq!(
        bench.succeed(&["new", "first"]),
        "first.lua: run it with: lampyris run first.lua\n"
    );
    let message = bench.fail(&["new", "first"]);
    assert_eq!(message, "new: name is \"first.lua\", allowed: names that are not taken\n");
    // A newcomer's first picture is shown without a warning.
    let output = bench.run(&["run", "first.lua", "--quiet", "--", "64"]);
    assert_eq!(text(&output.stdout), "4 views rendered, 0 kept, in out/first\n");
    assert_eq!(text(&output.stderr), "");
}

#[test]
fn info_tells_what_files_hold() {
    let bench = Bench::new();
    FILES.iter().for_each(|[name, content]| bench.write(name, content));
    let info = |name: &str| bench.succeed(&["info", name]);
    assert!(info("lens.obj").starts_with("lens.obj: OBJ mesh, 2 triangles\n"));
    assert!(info("red.csv").starts_with("red.csv: table\n"));
    assert!(info("bulb.csv").starts_with("bulb.csv: ray file (CSV), 3 rays\n"));
    let message = bench.fail(&["info", "missing.exr", "lens.obj"]);
    assert!(message.starts_with("missing.exr: No such file"), "{message}");
    bench.write("empty", "");
    assert_eq!(bench.fail(&["info", "empty"]), "empty: is empty\n");
}

#[test]
fn the_prompt_evaluates_and_goes_on_after_faults() {
    use std::io::Write;
    use std::process::Stdio;
    let bench = Bench::new();
    let mut command = bench.command(&["repl"]);
    command.env("HOME", bench.path(""));
    let command = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("a start");
    let input = b"1 + 1\nfor i = 7, 7 do\nprint(i)\nend\nlampyris.veiw\nlampyris.view {}\n";
    child.stdin.take().expect("a pipe").write_all(input).expect("a written line");
    let output = child.wait_with_output().expect("an end");
    assert!(output.status.success());
    let lines = crate::bench::text(&output.stdout);
    let lines: Vec<&str> = lines.lines().skip(1).collect();
    assert_eq!(lines[..2], ["2", "7"]);
    assert!(lines[2].starts_with("view: azimuth 0°"), "{lines:?}");
    assert!(crate::bench::text(&output.stderr).contains("did you mean \"view\"?"));
}
