//! The annotations for the Lua language server know what the program knows.

use std::collections::{BTreeMap, BTreeSet};

use crate::bench::Bench;

const LIBRARY: &str = include_str!("../../scripts/library/lampyris.lua");

/// Option tables by their class, and a call that is given the key that nothing knows.
const OPTIONS: &[[&str; 2]] = &[
    ["SpectrumLoadOptions", "L.spectrum.load('x.csv', X)"],
    ["MeshLoadOptions", "L.mesh.load('x.obj', X)"],
    ["MeshNewOptions", "L.mesh.new(X)"],
    ["MeshSurfaceOptions", "L.mesh.surface(X)"],
    ["SectionOptions", "mesh:section(X)"],
    ["Transform", "mesh:transform(X)"],
    ["Rotation", "mesh:transform { rotate = X }"],
    ["MaterialOptions", "L.material(X)"],
    ["LobeFitOptions", "L.fit_lobe(X)"],
    ["RaysetLoadOptions", "L.rayset.load('x.csv', X)"],
    ["RaysetNewOptions", "L.rayset.new(X)"],
    ["RaysetHalvesOptions", "rays:halves(X)"],
    ["RaysetNoiseOptions", "rays:noise(X)"],
    ["StartOptions", "rays:starting_at(X)"],
    ["CylinderOptions", "L.cylinder(X)"],
    ["FilamentOptions", "L.filament(X)"],
    ["BulbOptions", "L.bulb('P21W', X)"],
    ["SceneOptions", "L.scene(X)"],
    ["SceneObject", "L.scene { objects = { X } }"],
    ["ViewOptions", "L.view(X)"],
    ["QualityOptions", "scene:render(view, X)"],
    ["AdaptiveSamples", "scene:render(view, { samples = X })"],
    ["LightErrorOptions", "scene:check_light_error(view, X)"],
    ["PathOptions", "scene:paths(view, X)"],
    ["RegionOptions", "image:xyz(X)"],
    ["FalseColorOptions", "image:false_color(X)"],
    ["PngOptions", "image:save('x.png', X)"],
    ["LookOptions", "image:save('x.png', { look = X })"],
    ["TiffOptions", "image:save('x.tif', X)"],
    ["JpegOptions", "image:save('x.jpg', X)"],
    ["HdrOptions", "image:save('x.hdr', X)"],
    ["ExrOptions", "image:save('x.exr', X)"],
    ["CameraOptions", "L.camera(X)"],
    ["PqOptions", "L.display.p3_pq(X)"],
    ["ExposureOptions", "image:save('x.png', { exposure = X })"],
    ["GlareOptions", "image:save('x.png', { glare = X })"],
    ["DisplayNewOptions", "L.display.new(X)"],
    ["DisplayFitOptions", "L.display.fit(X)"],
    ["DisplayLoadOptions", "L.display.load('x.icc', X)"],
    ["DisplayRampsOptions", "L.display.ramps('x.csv', X)"],
    ["FigureAxis", "L.figure { series = {}, x = X }"],
    ["FigureSeries", "L.figure { series = { X } }"],
    ["ChartPanel", "L.figure { panels = { X } }"],
    ["PicturePanel", "L.figure { panels = { { image = image, nobody_knows = 1 } } }"],
    ["SegmentsPanel", "L.figure { panels = { { segments = {}, nobody_knows = 1 } } }"],
    ["FigureOptions", "L.figure { panels = {}, nobody_knows = 1 }"],
    ["SweepOptions", "L.sweep(X)"],
    ["SweepView", "L.sweep { output = 's', views = { X } }"],
    ["GridOptions", "L.photometry.grid(X)"],
    ["GridCheckOptions", "grid:check(X)"],
    ["GridSaveOptions", "grid:save('x.csv', X)"],
];

/// Classes of handles and tables, and one of each.
const HANDLES: &[[&str; 2]] = &[
    ["lampyris", "L"],
    ["lampyris.spectrum", "L.spectrum"],
    ["lampyris.mesh", "L.mesh"],
    ["lampyris.rayset", "L.rayset"],
    ["lampyris.camera", "L.camera"],
    ["lampyris.display", "L.display"],
    ["lampyris.image", "L.image"],
    ["lampyris.photometry", "L.photometry"],
    ["Spectrum", "L.spectrum.constant(1)"],
    ["Mesh", "mesh"],
    ["Rayset", "rays"],
    ["Scene", "scene"],
    ["Image", "image"],
    ["Display", "L.display.srgb"],
    ["Grid", "grid"],
    ["Figure", "L.figure { series = {} }"],
];

const BEFORE: &str = r#"
local L = require "lampyris"
local X = { nobody_knows = 1 }
local mesh = L.mesh.new { positions = { {0,0,0}, {1,0,0}, {0,1,0} }, triangles = { {1,2,3} } }
local rays = L.cylinder {
  radius = 1, length = 1, flux = 1, samples = 4, spectrum = L.spectrum.constant(1),
}
local scene = L.scene { objects = {}, lights = { rays }, photometry = "absolute" }
local view = L.view { width = 2, height = 2 }
local image = scene:render(view)
local grid = L.photometry.grid { scene = scene, h = { 0 }, v = { 0 }, width = 2, height = 2 }
"#;

/// Fields and functions of each class, as the library says.
fn annotated() -> BTreeMap<&'static str, BTreeSet<&'static str>> {
    let mut classes: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    let mut current = "";
    for line in LIBRARY.lines() {
        if let Some(class) = line.strip_prefix("---@class ") {
            current = class.split(':').next().unwrap_or(class).trim();
            classes.entry(current).or_default();
        } else if let Some(field) = line.strip_prefix("---@field ") {
            let name = field.split(' ').next().unwrap_or(field).trim_end_matches('?');
            classes.entry(current).or_default().insert(name);
        } else if let Some(function) = line.strip_prefix("function ") {
            let path = function.split('(').next().unwrap_or(function);
            if let Some(at) = path.rfind(['.', ':']) {
                classes.entry(&path[..at]).or_default().insert(&path[at + 1..]);
            }
        }
    }
    let nested: Vec<&str> = classes.keys().filter_map(|c| c.strip_prefix("lampyris.")).collect();
    classes.entry("lampyris").or_default().extend(nested);
    classes
}

/// The keys that the program names when it meets one that it does not know.
fn known(bench: &Bench, call: &str) -> String {
    let message = bench.fail_script(&format!("{BEFORE}{call}\n"));
    let keys = message.split_once("(keys: ").and_then(|(_, rest)| rest.rsplit_once(')'));
    keys.unwrap_or_else(|| panic!("{call}: {message}")).0.to_owned()
}

#[test]
fn annotations_are_in_step_with_the_program() {
    let bench = Bench::new();
    let classes = annotated();
    let calls = OPTIONS.iter().map(|[class, call]| (*class, (*call).to_owned()));
    let reads = HANDLES.iter().map(|[class, value]| (*class, format!("print(({value}).nobody)")));
    for (class, call) in calls.chain(reads) {
        let keys = known(&bench, &call);
        let of_program: BTreeSet<&str> = keys.split(", ").collect();
        assert_eq!(classes[class], of_program, "{class}");
    }
}

#[test]
fn the_library_is_lua() {
    let bench = Bench::new();
    bench.write("script.lua", LIBRARY);
    bench.succeed(&["run", "script.lua"]);
}

#[test]
fn messages_name_the_lines_that_led_there() {
    let bench = Bench::new();
    bench.write(
        "shared/part.lua",
        "local lampyris = require 'lampyris'\n\
         local function view(options)\n  local made = lampyris.view(options)\n  return made\nend\n\
         return { view = view }\n",
    );
    bench.write(
        "script.lua",
        "local part = require 'part'\n\
         local function make()\n  local made = part.view { fov_deg = 3 }\n  return made\nend\n\
         make()\n",
    );
    let message = bench.fail(&["run", "script.lua", "--read", "shared"]);
    assert!(message.starts_with("shared/part.lua:3: view: unknown key \"fov_deg\""), "{message}");
    let callers = "\n  from script.lua:3\n  from script.lua:6\n";
    assert!(message.ends_with(callers), "{message}");
    let message = bench.fail_script("local function f() error('no lens') end\nf()\n");
    assert_eq!(message, "script.lua:1: no lens\n  from script.lua:2\n");
}

#[test]
fn tables_that_are_thrown_are_shown() {
    let bench = Bench::new();
    let message = bench.fail_script("error { code = 3, list = { 1, 'a' } }");
    assert_eq!(message, "script.lua:1: {code = 3, list = {1, \"a\"}}\n");
    let message = bench
        .fail_script("error(setmetatable({}, { __tostring = function() return 'no lens' end }))");
    assert!(message == "script.lua:1: no lens\n", "{message}");
    assert!(bench.fail_script("error()").ends_with(": nil\n"));
}
