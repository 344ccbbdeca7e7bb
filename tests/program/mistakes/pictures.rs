//! Mistakes from rendering on: quality, images, displays, photometry, sweeps, and Lua itself: what was done, the line that does it, and the message that ends the script.

#[rustfmt::skip]
pub const FAULTS: &[[&str; 3]] = &[
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
        "scene:render: unknown key \"spp\" (keys: dispersion, layers, light_error, max_depth, min_throughput, samples, target_error, wavelength_step)",
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
        "scene:render(view):save 'v.bmp'",
        "image:save: path is \"v.bmp\", allowed: names ending in .exr, .hdr, .jpg, .png or .tif",
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
        "image: unknown key \"luminence\", did you mean \"luminance\"? (keys: compare, false_color, height, homogeneity, intensity, layers, luminance, luminances, save, spectrum, stats, uncertainty, width, xyz)",
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
        "L.scene { objects = { { mesh = triangle, material = L.material { reflectance = 1, k_a = 1 } } }, ambient = 1 }:render(L.view { width = 8, height = 8, distance = 40 }):intensity()",
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
        "image:save: \"exposure\" is \"bright\", allowed: \"auto\", a factor above 0, {ev = stops}, {adaptation = cd/m²}",
    ],
    [
        "look by a name that is nearly right",
        "scene:render(view):save('v.png', { look = 'sen' })",
        "image:save: \"look\" is \"sen\", did you mean \"seen\"?, allowed: \"camera\", \"paper\", \"seen\"",
    ],
    [
        "JPEG of 16 bits",
        "scene:render(view):save('v.jpg', { bits = 16 })",
        "JPEG: holds 8 bits a channel: give a display of 8",
    ],
    [
        "peak beyond PQ",
        "L.display.p3_pq { peak = 20000 }",
        "display.p3_pq: \"peak\" is 20000, allowed: between 0 and 10000 cd/m²",
    ],
    [
        "image that is not there",
        "L.image.load 'no.exr'",
        "no.exr: No such file or directory (os error 2)",
    ],
    [
        "sum of no images",
        "L.image.sum {}",
        "image sum: has no images",
    ],
    [
        "camera of two channels",
        "L.camera { red = L.spectrum.constant(1), green = L.spectrum.constant(1) }",
        "camera: missing \"blue\", expected a spectrum",
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
