//! `image:uncertainty` and `image:homogeneity`, as a user calls them.

use crate::bench::{Bench, text};

/// A plate under two lamps; a study of the same inputs draws what the budget derives.
const SCRIPT: &str = r#"
local lampyris = require "lampyris"
local plate = lampyris.mesh.new {
  positions = { { -50, -50, 0 }, { 50, -50, 0 }, { 50, 50, 0 }, { -50, 50, 0 } },
  triangles = { { 1, 2, 3 }, { 1, 3, 4 } },
}
local function lamp(x, flux, kelvin)
  return lampyris.cylinder { center = { x, 0, 40 }, radius = 1, length = 5, flux = flux, samples = 20,
    spectrum = lampyris.spectrum.blackbody(kelvin) }
end
local view = lampyris.view { distance = 500, fov = 8, width = 8, height = 6 }
local red = lampyris.spectrum.new { { 380, 0.1 }, { 780, 0.9 } }
local function scene(n_s, factor, first, second)
  return lampyris.scene {
    photometry = "absolute", shadows = false,
    objects = { { mesh = plate, material = lampyris.material {
      reflectance = red * (factor or 1), k_d = 0.3, k_s = 0.7, n_s = n_s or 20 } } },
    lights = { lamp(-20, 100 * (first or 1), 2856), lamp(20, 60 * (second or 1), 6500) },
  }
end
local quality = { samples = 4, wavelength_step = 20, light_error = 0 }
local region = { x = 2, y = 2, width = 4, height = 2 }
local function options(more)
  local all = {}
  for k, v in pairs(quality) do all[k] = v end
  for k, v in pairs(more) do all[k] = v end
  return all
end
local image = scene():render(view, options { layers = "lights" })
local inputs = {
  first = { light = 1, u = 0.04 },
  second = { light = 2, u = 0.08 },
  n_s = { value = 20, u = 4, scene = scene },
}
local found = image:uncertainty { region = region, inputs = inputs, quality = quality }
local study = lampyris.study {
  parameters = { first = { normal = { 1, 0.04 } }, second = { normal = { 1, 0.08 } }, n_s = { normal = { 20, 4 } } },
  samples = 256, output = "s",
  run = function(p)
    local drawn = scene(p.n_s, 1, p.first, p.second):render(view, quality)
    local X, Y, Z = drawn:xyz(region)
    return { Y = Y, x = X / (X + Y + Z), y = Y / (X + Y + Z), I = drawn:intensity() }
  end,
}
for _, name in ipairs { "Y", "x", "y", "I" } do
  print(name, found["u_" .. name] / study.sd[name])
end
print(found.budget[1].input, #found.budget)
-- A reflectance that is wrong by 1 % at all wavelengths alike is luminance wrong by 1 %.
local paint = image:uncertainty { region = region, quality = quality, inputs = {
  paint = { u = 0.01, correlation = 1e6, scene = function(factor) return scene(20, factor) end } } }
print(("%.4f %.1e"):format(paint.u_Y / paint.Y / 0.01, paint.u_x))
"#;

/// 256 even draws know a standard deviation within 1 %; the rest is what inputs do to each other's
/// effect, which the budget leaves out.
#[test]
fn budgets_are_those_of_draws() {
    let bench = Bench::new();
    bench.write("budget.lua", SCRIPT);
    let printed = bench.succeed(&["run", "budget.lua", "--quiet"]);
    let lines: Vec<&str> = printed.lines().collect();
    for line in &lines[..4] {
        let ratio: f64 = line.split('\t').nth(1).unwrap().parse().unwrap();
        assert!((ratio - 1.0).abs() < 0.05, "{printed}");
    }
    assert!(lines[4].ends_with("\t3"), "{printed}");
    let [paint, hue]: [f64; 2] = lines[5]
        .split(' ')
        .map(|cell| cell.parse().unwrap())
        .collect::<Vec<_>>()
        .try_into()
        .unwrap();
    // The derivative's step, and the correlation that ends at 10⁶ nm.
    assert!((paint - 1.0).abs() < 2e-3 && hue < 5e-5, "{printed}");
}

#[test]
fn mistakes_have_their_messages() {
    const START: &str = r#"
local lampyris = require "lampyris"
local scene = lampyris.scene { objects = {}, background = 1 }
local image = scene:render(lampyris.view { width = 4, height = 3 }, { samples = 1 })
"#;
    let bench = Bench::new();
    for (call, message) in [
        ("uncertainty {}", "missing \"inputs\""),
        (
            "uncertainty { inputs = { f = { light = 1, u = 0.1 } } }",
            "render it with layers = \"lights\"",
        ),
        ("uncertainty { inputs = { f = { u = 0.1 } } }", "expected one of {light, u}"),
        (
            "uncertainty { inputs = { f = { u = -0.1, light = 1 } } }",
            "\"u\" is -0.1, allowed: 0 or more",
        ),
        (
            "uncertainty { inputs = { f = { value = 1, u = 1, scene = print } } }",
            "\"scene\"'s result is nil",
        ),
        ("uncertainty { inputs = {}, correlation = { { \"a\", \"b\", 2 } } }", "allowed: -1 to 1"),
        ("uncertainty { inputs = {}, correlation = { { \"a\", \"b\", 1 } } }", "input is \"a\""),
        (
            "homogeneity { grid = { 5, 1 } }",
            "grid is {5, 1}, allowed: {1, 1} to the region's {4, 3}",
        ),
        ("homogeneity { grid = { 2 } }", "\"grid\" has 1 entries, expected {columns, rows}"),
        ("homogeneity { halves = { image } }", "an odd number of halves"),
        ("homogeneity { region = { x = 9 } }", "region: x is 9"),
        ("homogeneity { cells = 3 }", "unknown"),
    ] {
        bench.write("wrong.lua", &format!("{START}image:{call}\n"));
        let printed = text(&bench.run(&["run", "wrong.lua"]).stderr);
        assert!(printed.contains(message) && printed.contains("wrong.lua:5"), "{call}: {printed}");
    }
}
