//! Mistakes that people make in scripts, each with the whole message that it gets.

use crate::bench::{Bench, text};

/// Before the line with the mistake, which is the tenth.
const BEFORE: &str = r#"local L = require "lampyris"
local white = L.spectrum.blackbody(2856)
local triangle = L.mesh.load "triangle.obj"
local cube = L.mesh.load "cube.obj"
local paper = L.material { reflectance = 0.5, k_d = 1 }
local lamp = L.cylinder { radius = 0.1, length = 0.2, flux = 100, spectrum = white, samples = 10 }
local scene = L.scene { objects = { { mesh = triangle, material = paper } }, lights = { lamp } }
local absolute = L.scene { objects = {}, lights = { lamp }, photometry = "absolute" }
local view = L.view { width = 8, height = 8 }
"#;

/// Beside the script.
const FILES: [(&str, &str); 12] = [
    ("triangle.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\ng lens\nf 1 2 3\n"),
    (
        "cube.obj",
        "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\nf 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 1 5 8 4\n",
    ),
    ("points.obj", "v 0 0 0\nv 1 0 0\n"),
    ("wrong.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n"),
    ("letters.obj", "v 0 zero 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
    ("words.csv", "these are\nonly words\n"),
    ("red.csv", "nm,value\n380,0.1\n780,0.9\n"),
    ("swapped.csv", "0.1,380\n0.9,780\n"),
    ("descending.csv", "780,0.9\n380,0.1\n"),
    ("hole.csv", "380,0.1\n580,\n780,0.9\n"),
    ("rays.csv", "x,y,z,dx,dy,dz,flux\n0,0,0,0,0,1,1\n"),
    ("still.csv", "x,y,z,dx,dy,dz,flux\n0,0,0,0,0,0,1\n"),
];

/// What was done, the line that does it, and the message that ends the script.
#[rustfmt::skip]
const FAULTS: &[[&str; 3]] = &[
    [
        "misspelt option",
        "L.view { azimut = 3 }",
        "view: unknown key \"azimut\", did you mean \"azimuth\"? (keys: azimuth, distance, elevation, fov, height, target, width)",
    ],
    [
        "option of another renderer",
        "L.view { fov_deg = 3 }",
        "view: unknown key \"fov_deg\", did you mean \"fov\"? (keys: azimuth, distance, elevation, fov, height, target, width)",
    ],
    [
        "field of view of 180 degrees",
        "L.view { fov = 180 }",
        "view: \"fov\" is 180, allowed: between 0 and 180 degrees",
    ],
    [
        "field of view in the wrong sign",
        "L.view { fov = -6 }",
        "view: \"fov\" is -6, allowed: between 0 and 180 degrees",
    ],
    [
        "elevation beyond the pole",
        "L.view { elevation = 91 }",
        "view: \"elevation\" is 91, allowed: -90 to 90 degrees",
    ],
    [
        "distance of zero",
        "L.view { distance = 0 }",
        "view: \"distance\" is 0, allowed: above 0 mm",
    ],
    [
        "distance that is no number",
        "L.view { distance = 'far' }",
        "view: \"distance\" is the string \"far\", expected a number",
    ],
    [
        "distance that is not finite",
        "L.view { distance = 1 / 0 }",
        "view: \"distance\" is inf, allowed: above 0 mm",
    ],
    [
        "half a pixel",
        "L.view { width = 640.5 }",
        "view: \"width\" is 640.5, allowed: whole numbers, 1 to 65536",
    ],
    [
        "no pixels",
        "L.view { height = 0 }",
        "view: \"height\" is 0, allowed: whole numbers, 1 to 65536",
    ],
    [
        "target of two numbers",
        "L.view { target = { 0, 0 } }",
        "view: \"target\" has 2 entries, expected {x, y, z}",
    ],
    [
        "target by names",
        "L.view { target = { x = 0, y = 0, z = 0 } }",
        "view: \"target\" has the key \"x\", expected a vector {x, y, z}",
    ],
    [
        "a view of two tables",
        "L.view({}, {})",
        "view: 2 arguments, expected at most 1",
    ],
    [
        "a view of a number",
        "L.view(3)",
        "view: argument is the number 3, expected a table of options",
    ],
    [
        "misspelt function",
        "L.veiw {}",
        "lampyris: unknown key \"veiw\", did you mean \"view\"? (keys: bulb, cylinder, display, figure, filament, fit_lobe, material, mesh, photometry, rayset, read, scene, spectrum, sweep, version, view, write)",
    ],
    [
        "misspelt function of a table",
        "L.spectrum.blackbdy(2856)",
        "lampyris.spectrum: unknown key \"blackbdy\", did you mean \"blackbody\"? (keys: blackbody, constant, illuminant, load, new)",
    ],
    [
        "missing file",
        "L.spectrum.load 'missing.csv'",
        "missing.csv: No such file or directory (os error 2)",
    ],
    [
        "spectrum without numbers",
        "L.spectrum.load 'words.csv'",
        "words.csv: no rows, expected wavelength in nm and value",
    ],
    [
        "spectrum in the wrong column",
        "L.spectrum.load('red.csv', { column = 3 })",
        "red.csv:2: no column 3, the row has 2 (\"380,0.1\")",
    ],
    [
        "wavelengths in the value column",
        "L.material { reflectance = L.spectrum.load('swapped.csv') }",
        "material: reflectance at 0.1 nm is 380, allowed: 0 to 1",
    ],
    [
        "column of wavelengths",
        "L.spectrum.load('red.csv', { column = 1 })",
        "spectrum.load: \"column\" is 1, allowed: whole numbers, 2 to 1000",
    ],
    [
        "wavelengths that descend",
        "L.spectrum.load 'descending.csv'",
        "descending.csv:2: wavelength 380 nm follows 780 nm, must ascend",
    ],
    [
        "spectrum with a hole",
        "L.spectrum.load 'hole.csv'",
        "hole.csv:2: column 2 is \"\", expected a number",
    ],
    [
        "spectrum without rows",
        "L.spectrum.new {}",
        "spectrum.new: no rows, expected wavelength in nm and value",
    ],
    [
        "spectrum of single numbers",
        "L.spectrum.new { 380, 0.9 }",
        "spectrum.new: row 1 is the number 380, expected {nm, value}",
    ],
    [
        "spectrum that descends",
        "L.spectrum.new { {780, 1}, {380, 1} }",
        "spectrum.new: wavelength 380 nm follows 780 nm, must ascend",
    ],
    [
        "temperature of zero",
        "L.spectrum.blackbody(0)",
        "spectrum.blackbody: temperature is 0, allowed: 100 to 1000000000 K",
    ],
    [
        "unknown illuminant",
        "L.spectrum.illuminant 'D50'",
        "spectrum.illuminant: name is \"D50\", allowed: \"A\", \"D65\", \"E\"",
    ],
    [
        "step of 1 nm",
        "L.spectrum.constant(1):values(1)",
        "spectrum:values: step is 1, allowed: 5, 10 or 20 nm",
    ],
    [
        "spectrum times a string",
        "local s = L.spectrum.constant(1) * 'x'",
        "spectrum *: operand is the string \"x\", expected a spectrum or a number",
    ],
    [
        "reflectance below zero",
        "L.material { reflectance = -0.1 }",
        "material: reflectance at 560 nm is -0.1, allowed: 0 to 1",
    ],
    [
        "reflectance in percent",
        "L.material { reflectance = 91 }",
        "material: reflectance at 560 nm is 91, allowed: 0 to 1",
    ],
    [
        "reflectance as text",
        "L.material { reflectance = 'aluminium' }",
        "material: \"reflectance\" is the string \"aluminium\", expected a spectrum or a number",
    ],
    [
        "reflectance as a file's name",
        "L.material { reflectance = 'aluminium.csv' }",
        "material: \"reflectance\" is the string \"aluminium.csv\", expected a spectrum or a number",
    ],
    [
        "proportion over one",
        "L.material { k_d = 1.5 }",
        "material: \"k_d\" is 1.5, allowed: 0 to 1",
    ],
    [
        "exponent of zero",
        "L.material { k_s = 1, n_s = 0 }",
        "material: \"n_s\" is 0, allowed: 1 to 1000000",
    ],
    [
        "exponent beyond a million",
        "L.material { k_s = 1, n_s = 1e7 }",
        "material: \"n_s\" is 10000000, allowed: 1 to 1000000",
    ],
    [
        "index below one",
        "L.material { ior = 0.9 }",
        "material: \"ior\" is 0.9, allowed: 1 to 4",
    ],
    [
        "thickness of zero",
        "L.material { transmittance = 1, thickness = 0 }",
        "material: \"thickness\" is 0, allowed: above 0 mm",
    ],
    [
        "capital letters",
        "L.material { K_D = 1 }",
        "material: unknown key \"K_D\", did you mean \"k_d\"? (keys: ior, k_a, k_d, k_rg, k_s, k_tg, n_d, n_s, name, reflectance, thickness, transmittance)",
    ],
    [
        "glossiness of another program",
        "L.material { shininess = 10 }",
        "material: unknown key \"shininess\", did you mean \"thickness\"? (keys: ior, k_a, k_d, k_rg, k_s, k_tg, n_d, n_s, name, reflectance, thickness, transmittance)",
    ],
    [
        "mesh file that is missing",
        "L.mesh.load 'missing.obj'",
        "missing.obj: No such file or directory (os error 2)",
    ],
    [
        "mesh without faces",
        "L.mesh.load 'points.obj'",
        "points.obj: no faces",
    ],
    [
        "face of a missing vertex",
        "L.mesh.load 'wrong.obj'",
        "wrong.obj:4: position index is 4, allowed: 1 to 3 above this line, or −3 to −1",
    ],
    [
        "vertex that is no number",
        "L.mesh.load 'letters.obj'",
        "letters.obj:1: position has \"zero\", expected a number",
    ],
    [
        "unknown group of a mesh",
        "L.mesh.load('triangle.obj', { group = 'lense' })",
        "triangle.obj: no faces in group \"lense\" (groups: lens)",
    ],
    [
        "negative scale",
        "L.mesh.load('triangle.obj', { scale = -1 })",
        "mesh.load: \"scale\" is -1, allowed: above 0",
    ],
    [
        "mesh without positions",
        "L.mesh.new { triangles = { {1, 2, 3} } }",
        "mesh.new: missing \"positions\", expected a list of {x, y, z}",
    ],
    [
        "triangles counted from zero",
        "L.mesh.new { positions = { {0,0,0}, {1,0,0}, {0,1,0} }, triangles = { {0, 1, 2} } }",
        "mesh.new: \"triangles\" entry 1 is 0, allowed: whole numbers, 1 to 3",
    ],
    [
        "triangle of four corners",
        "L.mesh.new { positions = { {0,0,0}, {1,0,0}, {0,1,0}, {1,1,0} }, triangles = { {1, 2, 3, 4} } }",
        "mesh.new: \"triangles\" entry 1 has 4 entries, expected {i, j, k}",
    ],
    [
        "normals of another number",
        "L.mesh.new { positions = { {0,0,0}, {1,0,0}, {0,1,0} }, triangles = { {1, 2, 3} }, normals = { {0, 0, 1} } }",
        "mesh.new: 1 normals for 3 positions, expected one each",
    ],
    [
        "surface without a function",
        "L.mesh.surface { nu = 3 }",
        "mesh.surface: missing \"point\", expected a function of u, v that returns x, y, z",
    ],
    [
        "surface of text",
        "L.mesh.surface { point = function(u, v) return 'x' end }",
        "mesh.surface: \"point\" at u = 0, v = 0 is the string \"x\", expected a number",
    ],
    [
        "surface that keeps nothing",
        "L.mesh.surface { point = function(u, v) return u, v, 0 end, keep = function() return false end }",
        "mesh.surface: no triangles",
    ],
    [
        "axis of no length",
        "triangle:transform { rotate = { axis = {0, 0, 0}, angle = 3 } }",
        "mesh:transform: rotate: \"axis\" is [0, 0, 0], allowed: any direction",
    ],
    [
        "ray file that is none",
        "L.rayset.load 'words.csv'",
        "words.csv: not a ray file of a known format (IES TM-25, Zemax, LightTools, ASAP, CSV, or rows of seven numbers)",
    ],
    [
        "ray file without a spectrum",
        "L.rayset.load 'rays.csv'",
        "rays.csv: the file has no spectrum, give \"spectrum\"",
    ],
    [
        "direction of no length",
        "L.rayset.load('still.csv', { spectrum = white })",
        "still.csv:2: direction is (0, 0, 0), allowed: unit length within 1 %",
    ],
    [
        "negative flux",
        "L.rayset.load('rays.csv', { spectrum = white, flux = -1 })",
        "rayset.load: \"flux\" is -1, allowed: above 0 lm",
    ],
    [
        "no rays to keep",
        "L.rayset.load('rays.csv', { spectrum = white, samples = 0 })",
        "rayset.load: \"samples\" is 0, allowed: whole numbers, 1 to 100000000",
    ],
    [
        "seed of one half",
        "L.rayset.load('rays.csv', { spectrum = white, samples = 1, seed = 0.5 })",
        "rayset.load: \"seed\" is 0.5, allowed: whole numbers, 0 to 9007199254740992",
    ],
    [
        "positions without directions",
        "L.rayset.new { positions = { {0,0,0} }, spectrum = white, flux = 1 }",
        "rayset.new: missing \"directions\", expected a list of {x, y, z}",
    ],
    [
        "flux without rays",
        "L.rayset.new { positions = { {0,0,0} }, directions = { {0,0,1} }, flux = { 1, 2 }, spectrum = white }",
        "rayset.new: 2 fluxes for 1 positions, expected one each",
    ],
    [
        "unknown bulb",
        "L.bulb 'P21X'",
        "bulb: category is \"P21X\", allowed: P21W, PY21W, P21/5W, PY21/5W, W5W",
    ],
    [
        "cylinder without a radius",
        "L.cylinder { length = 5, flux = 100, spectrum = white }",
        "cylinder: missing \"radius\", expected a number, above 0 mm",
    ],
    [
        "cylinder without a spectrum",
        "L.cylinder { radius = 1, length = 5, flux = 100 }",
        "cylinder: missing \"spectrum\", expected a spectrum, such as lampyris.spectrum.blackbody(2856)",
    ],
    [
        "scene without objects",
        "L.scene { lights = { lamp } }",
        "scene: missing \"objects\", expected a list of {mesh =, material =}",
    ],
    [
        "object without a material",
        "L.scene { objects = { { mesh = triangle } } }",
        "scene: object 1: missing \"material\", expected a material",
    ],
    [
        "mesh in the place of an object",
        "L.scene { objects = { triangle } }",
        "scene: object 1: argument is mesh: 1 triangles, [0, 0, 0] to [1, 1, 0] mm, expected a table of options",
    ],
    [
        "mesh in the place of a material",
        "L.scene { objects = { { mesh = triangle, material = triangle } } }",
        "scene: object 1: \"material\" is mesh: 1 triangles, [0, 0, 0] to [1, 1, 0] mm, expected a material",
    ],
    [
        "light as a single handle",
        "L.scene { objects = {}, lights = lamp }",
        "scene: \"lights\" is rayset: 10 samples, 100 lm, expected a list of raysets",
    ],
    [
        "spectrum in the place of a light",
        "L.scene { objects = {}, lights = { white } }",
        "scene: \"lights\" is spectrum: 380 to 780 nm, 81 rows, 0.09802469733058372 to 2.4156753281616425, expected a list of raysets",
    ],
    [
        "misspelt photometry",
        "L.scene { objects = {}, photometry = 'absolut' }",
        "scene: \"photometry\" is \"absolut\", did you mean \"absolute\"?, allowed: \"relative\", \"absolute\"",
    ],
    [
        "shadows as a number",
        "L.scene { objects = {}, shadows = 1 }",
        "scene: \"shadows\" is the number 1, expected true or false",
    ],
    [
        "light without visible flux",
        "L.scene { objects = {}, lights = { L.cylinder { radius = 1, length = 1, flux = 1, spectrum = L.spectrum.constant(0) } } }",
        "light: spectrum has no luminous flux at the bands of 5 nm, so that 1 lm cannot be shared out",
    ],
    [
        "background below zero",
        "L.scene { objects = {}, background = -1 }",
        "scene: background: value at 560 nm is -1, allowed: ≥ 0",
    ],
    [
        "render without a view",
        "scene:render()",
        "scene:render: argument 1 is nil, expected a view",
    ],
    [
        "render of options",
        "scene:render { azimuth = 3 }",
        "scene:render: argument 1 is a table, expected a view",
    ],
    [
        "no samples",
        "scene:render(view, { samples = 0 })",
        "scene:render: \"samples\" is 0, allowed: whole numbers, 1 to 1000000",
    ],
    [
        "samples from more to less",
        "scene:render(view, { samples = { min = 8, max = 4 } })",
        "scene:render: samples: \"max\" is 4, allowed: whole numbers, 8 to 1000000",
    ],
    [
        "step of 7 nm",
        "scene:render(view, { wavelength_step = 7 })",
        "scene:render: \"wavelength_step\" is 7, allowed: 5, 10 or 20 nm",
    ],
    [
        "error over one",
        "scene:render(view, { light_error = 2 })",
        "scene:render: \"light_error\" is 2, allowed: 0 to 1",
    ],
    [
        "target error of nothing",
        "scene:render(view, { target_error = 0 })",
        "scene:render: \"target_error\" is 0, allowed: between 0 and 1",
    ],
    [
        "target error and what it chooses",
        "scene:render(view, { target_error = 0.01, max_depth = 4 })",
        "scene:render: \"target_error\" chooses \"max_depth\": give one of the two",
    ],
    [
        "unknown quality",
        "scene:render(view, { spp = 4 })",
        "scene:render: unknown key \"spp\" (keys: light_error, max_depth, min_throughput, samples, target_error, wavelength_step)",
    ],
    [
        "region outside of the image",
        "scene:render(view):luminance { x = 8 }",
        "region: x is 8, allowed: 0 to 7 pixels",
    ],
    [
        "region that is too wide",
        "scene:render(view):xyz { x = 4, width = 5 }",
        "region: width is 5, allowed: 1 to 4 pixels from x = 4",
    ],
    [
        "image of another kind",
        "scene:render(view):save 'v.jpg'",
        "image:save: path is \"v.jpg\", allowed: names ending in .exr or .png",
    ],
    [
        "image outside of the output folder",
        "scene:render(view):save '../v.exr'",
        "output: path is \"../v.exr\", allowed: below out/",
    ],
    [
        "display by its name",
        "scene:render(view):save('v.png', { display = 'srgb' })",
        "image:save: \"display\" is the string \"srgb\", expected a display",
    ],
    [
        "unknown gamut mapping",
        "scene:render(view):save('v.png', { gamut = 'clamp' })",
        "image:save: \"gamut\" is \"clamp\", did you mean \"clip\"?, allowed: \"clip\", \"desaturate\"",
    ],
    [
        "exposure of zero",
        "scene:render(view):save('v.png', { exposure = 0 })",
        "image:save: \"exposure\" is 0, allowed: above 0",
    ],
    [
        "field of an image",
        "print(scene:render(view).luminence)",
        "image: unknown key \"luminence\", did you mean \"luminance\"? (keys: compare, false_color, height, intensity, luminance, luminances, save, spectrum, stats, width, xyz)",
    ],
    [
        "display without primaries",
        "L.display.new { gamma = 2.2 }",
        "display.new: \"gamma\" is the number 2.2, expected a list of 3 numbers",
    ],
    [
        "display with equal primaries",
        "L.display.new { matrix = { {1,1,1}, {1,1,1}, {1,1,1} } }",
        "display: matrix has no inverse: two primaries have the same chromaticity",
    ],
    [
        "relative intensity",
        "scene:render(view):intensity()",
        "intensity: needs a scene with photometry = \"absolute\": relative values have no unit",
    ],
    [
        "angles that descend",
        "L.photometry.grid { scene = absolute, h = { 5, 0 }, v = { 0 } }",
        "photometry.grid: \"h\" has to be ascending angles, one at least",
    ],
    [
        "lamp of no regulation",
        "L.photometry.grid { scene = absolute, h = { 0 }, v = { 0 }, width = 4, height = 4 }:check 'S9'",
        "limits: lamp is \"S9\", allowed: R1, R2, S1, S2, 2a, 2b, S3, S4",
    ],
    [
        "lamp that is never marked D",
        "L.photometry.grid { scene = absolute, h = { 0 }, v = { 0 }, width = 4, height = 4 }:check { lamp = '2b', marked_d = true }",
        "grid:check: \"marked_d\": UN R148, as far as it is known here, has no maximum for 2b",
    ],
    [
        "field of visibility beyond the grid",
        "L.photometry.grid { scene = absolute, h = { 0 }, v = { 0 }, width = 4, height = 4 }:check { lamp = 'S1', side = 'left' }",
        "grid:check: the grid has to reach over h from -45° to 45°, v from -15° to 15°",
    ],
    [
        "EULUMDAT of a single direction",
        "L.photometry.grid { scene = absolute, h = { 0 }, v = { 0 }, width = 4, height = 4 }:save 'g.ldt'",
        "grid:save: EULUMDAT goes around the axis: h and v have to reach from -1° to 1° at least",
    ],
    [
        "exposure by a word",
        "scene:render(view):save('v.png', { exposure = 'bright' })",
        "image:save: \"exposure\" is \"bright\", allowed: \"auto\", a factor above 0, {ev = stops}",
    ],
    [
        "tone curve that fails",
        "L.scene { objects = {}, background = 1 }:render(view):save('v.png', { tone = function() error('no tone') end })",
        "image:save: tone: s.lua:10: no tone",
    ],
    [
        "sweep without an output",
        "L.sweep { scene = scene, views = { view } }",
        "sweep: missing \"output\", expected a folder below the output folder",
    ],
    [
        "sweep without views",
        "L.sweep { scene = scene, output = 's' }",
        "sweep: \"views\" is nil, expected a list of views, or a function that returns them one by one",
    ],
    [
        "sweep without a scene",
        "L.sweep { views = { view }, output = 's' }",
        "sweep: missing \"scene\", expected a scene for all views, or one for view 1",
    ],
    [
        "sweep of numbers",
        "L.sweep { scene = scene, views = { 0, 15 }, output = 's' }",
        "sweep: view 1: entry is the number 0, expected a view, or {view =, scene =, name =}",
    ],
    [
        "sweep with two views of a name",
        "L.sweep { scene = scene, output = 's', views = { { view = view, name = 'a' }, { view = view, name = 'a' } } }",
        "sweep: views: two views are named \"a\"",
    ],
    [
        "view named like a path",
        "L.sweep { scene = scene, output = 's', views = { { view = view, name = 'a/b' } } }",
        "sweep: view 1: \"name\" is \"a/b\", allowed: letters, digits and _ - + ., not a dot first, no name of the sweep's own files",
    ],
    [
        "region of a sweep outside",
        "L.sweep { scene = scene, output = 's', views = { view }, regions = { lens = { x = 9 } } }",
        "region: x is 9, allowed: 0 to 7 pixels",
    ],
    [
        "gap in a list",
        "L.scene { objects = { [1] = { mesh = triangle, material = paper }, [3] = { mesh = triangle, material = paper } } }",
        "scene: \"objects\" has a gap after entry 1",
    ],
    [
        "dot in the place of a colon",
        "scene.render(view)",
        "render: is a method, to be called with a colon: object:render(…)",
    ],
    [
        "unknown module",
        "require 'lamps'",
        "lamps.lua: No such file or directory (os error 2)",
    ],
    [
        "module by its path",
        "require 'lib/lamp'",
        "require: name is \"lib/lamp\", allowed: names of letters, digits, _ and -, joined by dots",
    ],
    [
        "error of the script's own",
        "error('no lamp today')",
        "no lamp today",
    ],
    [
        "arithmetic on nothing",
        "local x = nil + 1",
        "attempt to perform arithmetic on a nil value",
    ],
    [
        "call of nothing",
        "undefined_function()",
        "attempt to call a nil value (global 'undefined_function')",
    ],
    [
        "syntax",
        "local = 3",
        "<name> expected near '='",
    ],
];

/// What was done, the line that does it, and the warning that it gets.
#[rustfmt::skip]
const WARNINGS: &[[&str; 3]] = &[
    [
        "more light than arrives",
        "L.scene { objects = { { mesh = triangle, material = L.material { reflectance = 1, k_d = 0.6, k_s = 0.6 } } }, photometry = 'absolute' }",
        "material: returns 1.200 times the light that arrives: (F_r + F_t)(k_d + k_s) should be at most 1 in an absolute scene",
    ],
    [
        "mirrors that amplify",
        "L.scene { objects = { { mesh = triangle, material = L.material { reflectance = 1, transmittance = 1, k_rg = 0.6, k_tg = 0.6 } } }, photometry = 'absolute' }",
        "material: passes on 1.200 times the light that arrives: k_rg F_r + k_tg F_t should be at most 1 in an absolute scene",
    ],
    [
        "meters for millimeters",
        "L.scene { objects = { { mesh = L.mesh.load('triangle.obj', { scale = 0.001 }), material = paper } } }:render(view)",
        "scene: all objects lie within 1.000e-3 mm: are their meshes in m? \"scale\" = 1000 makes them mm",
    ],
    [
        "open body with a thickness",
        "L.scene { objects = { { mesh = triangle, material = L.material { transmittance = 0.9, k_tg = 1, thickness = 3 } } } }:render(view)",
        "material: \"thickness\" asks for closed bodies, but 3 edges bound a hole",
    ],
    [
        "eye inside a mesh",
        "L.scene { objects = { { mesh = cube, material = paper } } }:render(L.view { distance = 0.1, width = 8, height = 8 })",
        "view: the eye, 0.1 mm from its target, is inside a mesh: it sees only back sides",
    ],
    [
        "light inside a wall",
        "L.scene { objects = { { mesh = cube, material = paper } }, lights = { lamp }, shadows = true }:render(view)",
        "light 1: its center [-0.010, 0.000, -0.018] mm is inside an opaque mesh, behind back sides only",
    ],
    [
        "lamp that is cut off",
        "L.scene { objects = { { mesh = triangle, material = paper } }, lights = { lamp }, background = 1, photometry = 'absolute' }:render(view):intensity()",
        "intensity: light reaches the border of the image (azimuth 0°, elevation 0°, 3000 mm from [0, 0, 0], fov 6°, 8 × 8)",
    ],
];

fn bench() -> Bench {
    let bench = Bench::new();
    FILES.iter().for_each(|(name, content)| bench.write(name, content));
    bench
}

/// Exit status and standard error.
fn run(bench: &Bench, line: &str) -> (Option<i32>, String) {
    bench.write("s.lua", &format!("{BEFORE}{line}\n"));
    let output = bench.run(&["run", "s.lua", "--threads=1"]);
    (output.status.code(), text(&output.stderr))
}

#[test]
fn every_mistake_has_its_message() {
    assert!(FAULTS.len() + WARNINGS.len() > 60);
    let bench = bench();
    for [mistake, line, message] in FAULTS {
        let expected = (Some(1), format!("s.lua:10: {message}\n"));
        assert_eq!(run(&bench, line), expected, "{mistake}");
    }
}

#[test]
fn what_was_hardly_meant_is_warned_of() {
    let bench = bench();
    for [mistake, line, warning] in WARNINGS {
        let expected = (Some(0), format!("warning: {warning}\n"));
        assert_eq!(run(&bench, line), expected, "{mistake}");
    }
}

#[test]
fn good_scripts_say_nothing() {
    let bench = bench();
    assert_eq!(run(&bench, "scene:render(view)"), (Some(0), String::new()));
}
