//! Mistakes in views, spectra, materials, meshes, lights and scenes: what was done, the line that does it, and the message that ends the script.

#[rustfmt::skip]
pub const FAULTS: &[[&str; 3]] = &[
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
        "lampyris: unknown key \"veiw\", did you mean \"view\"? (keys: bulb, camera, cylinder, display, emitter, environment, figure, filament, fit_lobe, image, keep, material, mesh, optical, photometry, rayset, read, scene, spectrum, study, sweep, version, view, write)",
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
        "swapped.csv:1: wavelengths are 0.1 to 0.9: µm? then say so in the header (\"wavelength (µm)\"), or write nm",
    ],
    [
        "column of wavelengths",
        "L.spectrum.load('red.csv', { column = 1 })",
        "spectrum.load: \"column\" is 1, allowed: whole numbers, 2 to 1000",
    ],
    [
        "wavelengths that jump",
        "L.spectrum.load 'jumping.csv'",
        "jumping.csv:3: wavelength 380 nm beside 580 nm, neither ascending nor descending",
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
        "material: reflectance at 560 nm is 91, allowed: 0 to 1: percent? then say so in the file's header (\"%\"), or take s * 0.01",
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
        "material: unknown key \"K_D\", did you mean \"k_d\"? (keys: fresnel, ior, k, k_a, k_d, k_rg, k_s, k_tg, lobe, n, n_d, n_s, name, priority, reflectance, thickness, transmittance)",
    ],
    [
        "glossiness of another program",
        "L.material { shininess = 10 }",
        "material: unknown key \"shininess\", did you mean \"thickness\"? (keys: fresnel, ior, k, k_a, k_d, k_rg, k_s, k_tg, lobe, n, n_d, n_s, name, priority, reflectance, thickness, transmittance)",
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
        "triangle.obj: no faces in group \"lense\" (groups: lens; objects: none; materials: none)",
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
        "words.csv: not a ray file of a known format (IES TM-25, Zemax, LightTools, ASAP, Speos, CSV, or rows of seven or eight numbers)",
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
        "directions of a word",
        "L.rayset.load('rays.csv', { spectrum = white, directions = 'mesured' })",
        "rayset.load: \"directions\" is \"mesured\", did you mean \"measured\"?, allowed: \"lambert\", \"measured\"",
    ],
    [
        "directions too narrow",
        "L.rayset.load('rays.csv', { spectrum = white, directions = 1e6 })",
        "rayset.load: \"directions\" is 1000000, allowed: 1 to 30000",
    ],
    [
        "an emitter of one ray",
        "L.rayset.load('rays.csv', { spectrum = white, emitter = 'fit' })",
        "rayset: emitter: the rays come from one point, or from no surface that can be told: give one, such as { cylinder = { center, axis, radius, length } }",
    ],
    [
        "an emitter of two shapes",
        "L.rayset.load('rays.csv', { spectrum = white, emitter = { sphere = { radius = 1 }, disc = { radius = 1 } } })",
        "rayset: emitter: expected \"fit\", or one of cylinder, sphere, disc, plane",
    ],
    [
        "an emitter without flux",
        "L.emitter { mesh = triangle, spectrum = white }",
        "emitter: expected either \"flux\" or \"radiance\"",
    ],
    [
        "a visible light in relative photometry",
        "L.scene { objects = {}, lights = { L.emitter { mesh = triangle, flux = 1, spectrum = white } } }",
        "scene: a visible light has a radiance, which has no unit in relative photometry: set photometry = \"absolute\"",
    ],
    [
        "a table of luminance that is none",
        "lamp:plot_luminance()",
        "rayset: has no table of luminance: load it with emitter = \"fit\", or a surface",
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
];
