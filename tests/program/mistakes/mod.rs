//! Mistakes that people make in scripts, each with the whole message that it gets.

mod pictures;
mod scenes;

use crate::bench::{Bench, text};

/// Before the line with the mistake, which is the tenth.
const BEFORE: &str = r#"local L = require "lampyris"
local white = L.spectrum.blackbody(2856)
local triangle = L.mesh.load "triangle.obj"
local cube = L.mesh.load "cube.obj"
local paper = L.material { reflectance = 0.5, k_d = 1 }
local lamp = L.cylinder { radius = 0.1, length = 0.2, flux = 100, spectrum = white, samples = 10 }
local scene = L.scene { objects = { { mesh = triangle, material = paper } }, lights = { lamp }, background = 1e-6 }
local absolute = L.scene { objects = {}, lights = { lamp }, photometry = "absolute" }
local view = L.view { width = 8, height = 8 }
"#;

/// Beside the script.
const FILES: [(&str, &str); 13] = [
    ("triangle.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\ng lens\nf 1 2 3\n"),
    (
        "cube.obj",
        "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\nf 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 1 5 8 4\n",
    ),
    ("opposed.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 -1\nf 1//1 2//1 3//1\n"),
    ("points.obj", "v 0 0 0\nv 1 0 0\n"),
    ("wrong.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n"),
    ("letters.obj", "v 0 zero 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
    ("words.csv", "these are\nonly words\n"),
    ("red.csv", "nm,value\n380,0.1\n780,0.9\n"),
    ("swapped.csv", "0.1,380\n0.9,780\n"),
    ("jumping.csv", "480,0.9\n580,0.9\n380,0.1\n780,0.2\n"),
    ("hole.csv", "380,0.1\n580,\n780,0.9\n"),
    ("rays.csv", "x,y,z,dx,dy,dz,flux\n0,0,0,0,0,1,1\n"),
    ("still.csv", "x,y,z,dx,dy,dz,flux\n0,0,0,0,0,0,1\n"),
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
        "L.scene { objects = { { mesh = L.mesh.load('triangle.obj', { scale = 0.001 }), material = paper } }, background = 1 }:render(view)",
        "scene: all objects lie within 1.000e-3 mm: are their meshes in m? \"scale\" = 1000 makes them mm",
    ],
    [
        "one part in meters",
        "L.scene { objects = { { mesh = cube:transform { scale = 50 }, material = paper }, { mesh = cube:transform { scale = 0.05 }, material = paper } }, background = 1 }:render(L.view { distance = 3000, width = 8, height = 8 })",
        "scene: object 2 is 0.100 mm across among objects of 100 mm: is it in m? unit = \"m\" (factor 1000) makes it 100 mm",
    ],
    [
        "one part in inches",
        "L.scene { objects = { { mesh = cube:transform { scale = 50.8 }, material = paper }, { mesh = cube:transform { scale = 2, translate = { 9, 0, 0 } }, material = paper } }, background = 1 }:render(L.view { distance = 3000, width = 8, height = 8 })",
        "scene: object 2 is 4.000 mm across among objects of 102 mm: is it in inch? unit = \"inch\" (factor 25.4) makes it 102 mm",
    ],
    [
        "open body with a thickness",
        "L.scene { objects = { { mesh = triangle, material = L.material { transmittance = 0.9, k_tg = 1, thickness = 3 } } }, background = 1 }:render(view)",
        "object 1, material: \"thickness\" asks for a closed body, but 3 edges of the mesh bound a hole or join triangles that face opposite sides; each of its surfaces is taken by itself, with its front outside",
    ],
    [
        "normals of the other side",
        "L.scene { objects = { { mesh = L.mesh.load 'opposed.obj', material = paper } }, background = 1 }:render(view)",
        "object 1, material: vertex normals oppose the winding on 100 % of the area, which is shaded flat: turn over the faces or the normals where the mesh was made",
    ],
    [
        "eye inside a mesh",
        "L.scene { objects = { { mesh = cube, material = L.material { reflectance = 0.5, k_a = 1 } } }, ambient = 1 }:render(L.view { distance = 0.1, width = 8, height = 8 })",
        "view: the eye, 0.1 mm from its target, is inside a mesh: it sees only back sides",
    ],
    [
        "light inside a wall",
        "L.scene { objects = { { mesh = cube, material = paper } }, lights = { lamp }, shadows = true, background = 1 }:render(view)",
        "light 1: its center [-0.010, 0.000, -0.018] mm is inside an opaque mesh, behind back sides only",
    ],
    [
        "scene without light",
        "L.scene { objects = { { mesh = triangle, material = paper } } }:render(view)",
        "the picture is black: the scene has no lights, and no ambient light",
    ],
    [
        "objects smaller than a pixel",
        "L.scene { objects = { { mesh = triangle, material = paper } }, lights = { lamp } }:render(view)",
        "the picture is black: no ray meets a surface: the objects are 1.4 mm across, a pixel 39.3 mm there",
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
    let faults = [scenes::FAULTS, pictures::FAULTS].concat();
    assert!(faults.len() + WARNINGS.len() > 60);
    let bench = bench();
    let wrong = faults.iter().filter_map(|[mistake, line, message]| {
        let (expected, found) = ((Some(1), format!("s.lua:10: {message}\n")), run(&bench, line));
        (found != expected).then(|| format!("{mistake}: {found:?}\nexpected {expected:?}\n"))
    });
    let wrong: String = wrong.collect();
    assert!(wrong.is_empty(), "{wrong}");
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
