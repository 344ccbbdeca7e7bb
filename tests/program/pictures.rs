//! Pictures of files that were rendered before, and what is said of them.

use std::fs;

use crate::bench::{Bench, text};

/// A red screen of two lights before a dim sky, in parts.
const RENDER: &str = r#"
local lampyris = require "lampyris"
local red = lampyris.spectrum.new { { 600, 0 }, { 620, 0.8 }, { 780, 0.9 } }
local function light(x, seed)
  return lampyris.cylinder {
    center = { x, 0, 30 }, radius = 1, length = 5, flux = 20, samples = 50, seed = seed,
    spectrum = lampyris.spectrum.blackbody(2856),
  }
end
local scene = lampyris.scene {
  photometry = "absolute",
  background = 1e-5,
  objects = { {
    mesh = lampyris.mesh.surface {
      nu = 4, nv = 4, point = function(u, v) return 60 * u - 30, 60 * v - 30, 0 end,
    },
    material = lampyris.material { reflectance = red, k_d = 0.9, k_s = 0, k_rg = 0 },
  } },
  lights = { light(-10, 1), light(10, 2) },
}
local view = lampyris.view { distance = 500, fov = 8, width = 32, height = 24 }
local image = scene:render(view, { samples = 1, layers = "lights" })
"#;

fn bench(saves: &str) -> Bench {
    let bench = Bench::new();
    bench.write("render.lua", &format!("{RENDER}{saves}"));
    bench
}

const RUN: [&str; 3] = ["run", "render.lua", "--quiet"];

/// Everything that becomes of a picture, rendered or loaded.
const SAVES: &str = r#"
image:save("whole.exr")
for _, look in ipairs { "seen", "camera", "paper" } do
  image:save(look .. ".png", { look = look })
end
image:save("wide.png", { display = lampyris.display.p3_pq { peak = 600 } })
image.layers["light 2"]:save("light.png")
local relit = 0.3 * image.layers["light 1"] + image.layers["light 2"]
relit:save("relit.png")
"#;

#[test]
fn a_loaded_picture_is_the_rendered_one() {
    let bench = bench(SAVES);
    let load =
        "local lampyris = require 'lampyris'\nlocal image = lampyris.image.load 'out/whole.exr'";
    bench.write("load.lua", &format!("{load}\n{SAVES}"));
    bench.succeed(&RUN);
    bench.succeed(&["run", "load.lua", "--quiet", "--out", "again"]);
    let (first, again) = (bench.files("out"), bench.files("again"));
    assert_eq!(first.len(), 7);
    for (name, bytes) in &first {
        assert!(again[name] == *bytes, "{name} differs");
    }
}

#[test]
fn a_hundred_files_are_developed_at_once() {
    let bench = bench(
        r#"
        image:save("whole.exr")
        image:save("seen.png", { look = "seen" })
        image:save("wide.png", { display = lampyris.display.p3, exposure = { ev = -1 } })
        "#,
    );
    bench.succeed(&RUN);
    let names: Vec<String> = (0..100).map(|at| format!("in/view_{at:03}.exr")).collect();
    fs::create_dir(bench.path("in")).expect("a folder");
    for name in &names {
        fs::copy(bench.path("out/whole.exr"), bench.path(name)).expect("a copy");
    }
    for (picture, options) in
        [("seen", &["--look", "seen"][..]), ("wide", &["--display", "p3", "--exposure=-1"])]
    {
        let mut arguments = vec!["develop", "--out", picture];
        arguments.extend(options.iter().copied().chain(names.iter().map(String::as_str)));
        let said = bench.succeed(&arguments);
        // In the order of the files, whichever is done first.
        let named = said.lines().map(|line| line.split(':').next().unwrap_or_default());
        let expected = names
            .iter()
            .map(|name| name.replace("in/", &format!("{picture}/")).replace(".exr", ".png"));
        assert!(named.eq(expected), "{said}");
        let files = bench.files(picture);
        assert_eq!(files.len(), names.len());
        let first = fs::read(bench.path(&format!("out/{picture}.png"))).expect("a picture");
        assert!(files.values().all(|bytes| *bytes == first), "{picture}");
    }
}

/// One warning for all that a run shows, however many pictures, and with what helps.
#[test]
fn clipped_pictures_are_told_once_with_a_remedy() {
    let paper = r#"for k = 1, 3 do image:save("p" .. k .. ".png", { look = "paper" }) end"#;
    let seen = r#"for k = 1, 3 do image:save("s" .. k .. ".png", { look = "seen" }) end"#;
    let warnings = |saves: &str| {
        let output = bench(saves).run(&RUN);
        assert!(output.status.success(), "{}", text(&output.stderr));
        text(&output.stderr)
    };
    let told = warnings(paper);
    assert_eq!(told.lines().count(), 1, "{told}");
    assert!(told.starts_with("warning: 3 pictures are clipped"), "{told}");
    for remedy in ["look = \"seen\"", "lampyris.display.p3", "exposure = {ev = -1}"] {
        assert!(told.contains(remedy), "{told}");
    }
    assert_eq!(warnings(seen), "");
}

/// What a picture was saved as is compared with it, as a photograph of the lamp would be: within the
/// digits of 8 bits, of 16 bits of PQ, and of floats.
#[test]
fn pictures_of_colors_are_compared() {
    let bench = Bench::new();
    let saves = r#"
image:save("digits.png", { display = lampyris.display.rec2020, exposure = 80 / 500 })
image:save("float.tif", { samples = "float" })
image:save("colors.exr", { bands = "none" })
image:save("whole.exr")
image:save("absolute.png", { display = lampyris.display.p3_pq { peak = 1000 } })
local function told(file, options, rms)
  local difference = lampyris.image.load("out/" .. file, options):compare(image)
  assert(difference.relative_rms < rms, file .. ": " .. difference.relative_rms)
  assert(difference.mean_delta_e_2000 < 100 * rms, file .. ": " .. difference.mean_delta_e_2000)
end
told("digits.png", { luminance = 500 }, 0.01)
told("float.tif", nil, 1e-4)
told("colors.exr", nil, 1e-4)
told("absolute.png", nil, 1e-3)
local _, message = pcall(lampyris.image.load, "out/whole.exr", { luminance = 1 })
error(message)
"#;
    let gray = RENDER.replace("reflectance = red", "reflectance = 0.1");
    bench.write("render.lua", &format!("{gray}{saves}"));
    let output = bench.run(&RUN);
    let message = text(&output.stderr);
    assert!(message.contains("colors.exr: has colors and no bands: smooth spectra"), "{message}");
    let last = "\"luminance\" is for pictures of colors, and this file holds spectra\n";
    assert!(message.contains(last), "{message}");
}
