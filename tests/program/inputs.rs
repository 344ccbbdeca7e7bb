//! Files as CAD systems and instruments write them, read by scripts: the values that are right, and
//! what is said of the rest.

use crate::bench::{Bench, text};

/// A file, an expression of a script that reads it, and what it shows.
type Case = (&'static [u8], &'static str, &'static str);

const MESH: &str = "L.mesh.load('f.obj').area";
const SPECTRUM: &str = "L.spectrum.load('f.csv'):at(380)";
const REFLECTANCE: &str = "L.material { reflectance = L.spectrum.load 'f.csv' }";

const CASES: [Case; 33] = [
    (b"v 0 0 0\nv 50 0 0\nv 50 40 0\nv 40 40 0\nv 40 10 0\nv 10 10 0\nv 10 40 0\nv 0 40 0\nf 3 4 5 6 7 8 1 2\n", MESH, "1100.0"),
    (b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n# not continued \\\nf 1 2 \\\r\n 3 4\r\n", MESH, "1.0"),
    (b"\xef\xbb\xbfv 0 0 0 nan 0 0\nv 1 0 0 nan nan nan\nv 0 1 0 1 1 1\nf 1 2 3\n", MESH, "0.5"),
    (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//2 3//3\n", MESH, "0.5\nwarning: f.obj: 2 corners name a normal that is not there: their faces' normals are made"),
    (b"v 0 0 0\nv 1 0 0\nv 0 1 0\ng \xb7\xbb\xc1\xee\nf 1 2 3\n", "L.mesh.load('f.obj').groups[1]", "렌즈"),
    (b"v 0 0 0\nv 1 0 0\nv 0 1 0\no lens\ng default\nusemtl red\nf 1 2 3\n", "L.mesh.load('f.obj', { group = 'glass' })", "f.obj: no faces in group \"glass\" (groups: default; objects: lens; materials: red)"),
    (b"v 0 0 0\nv 1 0 0\nv 0 1 0\no lens\ng default\nusemtl red\nf 1 2 3\n", "L.mesh.load('f.obj', { material = 'red' }).area", "0.5"),
    (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "L.mesh.load('f.obj', { unit = 'inch' }):transform { mirror = 'x' }.bounds[1][1]", "-25.4"),
    (b"ISO-10303-21;\nHEADER;\n", "L.mesh.load('f.stp')", "f.stp: is a STEP file: exact surfaces: export a mesh from the CAD system as OBJ or STL, in mm, with a chord tolerance of 0.01 mm or less and an angle of 5° or less"),
    (b"                                                                        S      1\n", "L.mesh.load('f.igs')", "f.igs: is an IGES file: exact surfaces: export a mesh from the CAD system as OBJ or STL, in mm, with a chord tolerance of 0.01 mm or less and an angle of 5° or less"),
    (b"380;0,850\n400;0,84\n780;4,1168E-01\n", "L.spectrum.load('f.csv'):at(780)", "0.41168"),
    (b"380,0,850\n400,0,840\n780,0,5\n", SPECTRUM, "f.csv:1: a column too many (\"380,0,850\"): decimal commas? then write semicolons between the columns, or points in the numbers"),
    (b"\xef\xbb\xbf380,0.1\n780,0.9\n", SPECTRUM, "0.1"),
    (b"\xff\xfe3\x008\x000\x00\t\x000\x00.\x001\x00\n\x007\x008\x000\x00\t\x000\x00.\x009\x00\n\x00", SPECTRUM, "0.1"),
    (b"[Header]\nDate: 2020\n>>>>>Begin Spectral Data<<<<<\n380\t0.1\n780\t0.2\n>>>>>End Spectral Data<<<<<\n", SPECTRUM, "0.1"),
    (b"\"nm\" \"value\"\n\"380\" \"0.1\"\n\"780\" \"0.2\"\n", SPECTRUM, "0.1"),
    (b"780,1\n380,0.5\n", SPECTRUM, "0.5"),
    (b"380,1\n380,2\n780,1\n", SPECTRUM, "f.csv:2: wavelength 380 nm is twice there, see line 1"),
    (b"0.38,1\n0.5,2\n0.78,1\n", SPECTRUM, "f.csv:1: wavelengths are 0.38 to 0.78: µm? then say so in the header (\"wavelength (µm)\"), or write nm"),
    (b"3800,1\n5000,1\n7800,1\n", SPECTRUM, "f.csv:1: wavelengths are 3800 to 7800: Å? then say so in the header (\"wavelength (Å)\"), or write nm"),
    (b"12821,1\n20000,1\n26316,1\n", SPECTRUM, "f.csv:1: wavelengths are 12821 to 26316: cm⁻¹? then say so in the header (\"wavelength (cm⁻¹)\"), or write nm"),
    (b"wavelength (um),v\n0.38,1\n0.78,2\n", SPECTRUM, "1.0"),
    (b"450,1\n650,1\n", SPECTRUM, "1.0\nwarning: f.csv: covers 450 to 650 nm only: beyond, a light is 0 and a material constant"),
    (b"380,91\n780,85\n", REFLECTANCE, "material: reflectance at 380 nm is 91, allowed: 0 to 1: percent? then say so in the file's header (\"%\"), or take s * 0.01"),
    (b"380,1.0004\n780,0.5\n", REFLECTANCE, "material: reflectance at 380 nm is 1.0004, allowed: 0 to 1: noise? then load it with clamp = true, or take s:clamped(0, 1)"),
    (b"380,-0.0004\n780,0.5\n", REFLECTANCE, "material: reflectance at 380 nm is -0.0004, allowed: 0 to 1: noise? then load it with clamp = true, or take s:clamped(0, 1)"),
    (b"380,1.0004\n780,0.5\n", "L.spectrum.load('f.csv', { clamp = true }):at(380)", "1.0"),
    (b"33,0.012047\n35,0.046805\n37,0.141434\n39,0.333326\n41,0.613985\n43,0.885262\n45,1.000000\n47,0.885262\n49,0.613985\n51,0.333326\n53,0.141434\n55,0.046805\n57,0.012047\n", "L.fit_lobe { file = 'f.csv' }", "lobe fit: the largest value is at 45°, not near 0°: angles from the normal? give peak = 45, or peak = \"auto\""),
    (b"33,0.012047\n35,0.046805\n37,0.141434\n39,0.333326\n41,0.613985\n43,0.885262\n45,1.000000\n47,0.885262\n49,0.613985\n51,0.333326\n53,0.141434\n55,0.046805\n57,0.012047\n", "('%.1f'):format(L.fit_lobe { file = 'f.csv', peak = 'auto' }.n)", "200.0"),
    (b"angle,log10(BRDF)\n0,0.698970\n1,0.685740\n2,0.646042\n3,0.579851\n4,0.487128\n5,0.367815\n6,0.221840\n7,0.049112\n8,-0.150475\n", "('%.1f'):format(L.fit_lobe { file = 'f.csv' }.n)", "200.0"),
    (b"Red;0;0.00000\nRed;51;0.81466\nRed;102;5.24497\nRed;153;14.48731\nRed;204;18.91763\nRed;255;19.73229\nGreen;0;0.00000\nGreen;51;2.85131\nGreen;102;18.35740\nGreen;153;50.70560\nGreen;204;66.21169\nGreen;255;69.06300\nBlue;0;0.00000\nBlue;51;0.32586\nBlue;102;2.09799\nBlue;153;5.79493\nBlue;204;7.56705\nBlue;255;7.89291\n", "L.display.fit { file = 'f.csv', matrix = { { 41, 35, 18 }, { 21, 71, 7 }, { 2, 12, 95 } } }.verdict", "not described by gain-offset-gamma: it makes green 24.1 L* too dark at digit 51: curves = \"measured\" goes through the measured levels instead\nwarning: display.fit: display is not described by gain-offset-gamma: it makes green 24.1 L* too dark at digit 51: curves = \"measured\" goes through the measured levels instead"),
    (b"\x1f\x8b\x08\x00abc", "L.rayset.load('f.gz', { spectrum = 1 })", "f.gz: is compressed (gzip): unpack it first"),
    (b"version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 1\n", "L.rayset.load('f.csv', { spectrum = 1 })", "f.csv: is a pointer of Git LFS, not the file: run \"git lfs pull\" first"),
];

fn show(bench: &Bench, content: &[u8], expression: &str) -> String {
    let name = expression.split('\'').find(|part| part.starts_with("f.")).expect("a file's name");
    std::fs::write(bench.path(name), content).expect("a written file");
    let script = format!("local L = require 'lampyris' print({expression})");
    bench.write("script.lua", &script);
    let output = bench.run(&["run", "script.lua"]);
    let all = text(&output.stdout) + &text(&output.stderr);
    all.replace("script.lua:1: ", "").trim_end().to_owned()
}

#[test]
fn files_are_read_as_they_are_meant() {
    let bench = Bench::new();
    for (content, expression, shown) in CASES {
        let found = show(&bench, content, expression);
        assert_eq!(found, shown, "{}", String::from_utf8_lossy(content));
    }
}

/// Lambert's lamp of 100 cd with an opening of 100 mm, half a meter above a white plate: I cos²/(π r²),
/// to the noise of 10,000 rays and the width of their lobes (3 % too low here). Nearer than a meter it
/// is warned of.
#[test]
fn photometric_files_light_scenes() {
    let bench = Bench::new();
    let list = |values: &dyn Fn(f64) -> f64| -> String {
        (0..=18).map(|k| format!("{:.4} ", values(5.0 * f64::from(k)))).collect()
    };
    let (angles, candela) = (list(&|tilt| tilt), list(&|tilt| 100.0 * tilt.to_radians().cos()));
    let header = "IESNA:LM-63-2002\r\nTILT=NONE\r\n1 1000 1 19 1 1 2 0.1 0.1 0\r\n1 1 0\r\n";
    bench.write("lamp.ies", &format!("{header}{angles}\r\n0\r\n{candela}\r\n"));
    let script = "local L = require 'lampyris'
        local x, z = tonumber(arg[1]), tonumber(arg[2])
        local plate = L.mesh.surface { nu = 1, nv = 1,
            point = function(u, v) return 2 * u - 1, 2 * v - 1, 0 end }
        local white = L.material { reflectance = 1, k_d = 1, n_d = 1 }
        local lamp = L.rayset.load('lamp.ies', { spectrum = 1, samples = 10000,
            transform = { rotate = { axis = { 1, 0, 0 }, angle = 180 }, translate = { x, 0, z } } })
        local scene = L.scene { photometry = 'absolute', lights = { lamp },
            objects = { { mesh = plate, material = white } } }
        local view = L.view { distance = 500, fov = 0.1, width = 1, height = 1 }
        local _, luminance = scene:render(view, { light_error = 0 }):xyz { x = 0, y = 0 }
        print(luminance)";
    bench.write("script.lua", script);
    for (tilt, distance_m) in [(0.0f64, 0.5), (30.0, 0.5), (60.0, 1.5)] {
        let (sin, cos) = tilt.to_radians().sin_cos();
        let place = [sin, cos].map(|part| (1000.0 * distance_m * part).to_string());
        let output = bench.run(&["run", "script.lua", "--", &place[0], &place[1]]);
        let found: f64 = text(&output.stdout).trim().parse().expect("a luminance");
        let expected = 100.0 * cos * cos / (std::f64::consts::PI * distance_m * distance_m);
        assert!((found / expected - 1.0).abs() < 0.05, "{tilt}: {found}, {expected}");
        let warning =
            format!("warning: light 1: a surface is {:.0} mm away, ", 1000.0 * distance_m);
        let is_near = distance_m < 1.0;
        assert_eq!(text(&output.stderr).starts_with(&warning), is_near, "{}", text(&output.stderr));
    }
}
