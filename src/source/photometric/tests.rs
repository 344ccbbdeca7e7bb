//! Files by hand, and their fluxes and directions against closed forms.

use std::f64::consts::PI;

use super::*;
use crate::input::mutation;

fn read(text: &str) -> Result<PhotometricFile> {
    from_bytes(Path::new("lamp"), text.as_bytes().to_vec())
}

fn message(text: &str) -> String {
    read(text).unwrap_err().to_string()
}

/// An LM-63 file of a type, with angles and the intensity of each plane by tilt.
fn lm63(code: u32, planes: &[f64], tilts: &[f64], cd: impl Fn(f64, f64) -> f64) -> String {
    let list = |values: &[f64]| -> String {
        values.iter().map(|v| v.to_string()).collect::<Vec<_>>().join(" ")
    };
    let rows = planes.iter().map(|&p| list(&tilts.iter().map(|&t| cd(p, t)).collect::<Vec<_>>()));
    let rows: Vec<String> = rows.collect();
    format!(
        "IESNA:LM-63-2002\r\n[TEST] t\r\n[LUMINAIRE] a lamp\r\nTILT=NONE\r\n1 1000 2 {} {} {code} 2 0.1 0.05 0\r\n\
         0.5 1 60\r\n{}\r\n{}\r\n{}\r\n",
        tilts.len(),
        planes.len(),
        list(tilts),
        list(planes),
        rows.join("\r\n")
    )
}

fn even(from: f64, to: f64, step: f64) -> Vec<f64> {
    (0..=((to - from) / step).round() as usize).map(|k| from + step * k as f64).collect()
}

/// I = cos γ has π lm per cd; linear between 5°, the sum of middles errs by 1e-3.
#[test]
fn fluxes_are_integrals() {
    let lambert = |_: f64, tilt: f64| 100.0 * tilt.to_radians().cos().max(0.0);
    let down = even(0.0, 90.0, 5.0);
    for planes in [vec![0.0], even(0.0, 90.0, 22.5), even(0.0, 180.0, 30.0), even(0.0, 360.0, 30.0)]
    {
        let file = read(&lm63(1, &planes, &down, lambert)).unwrap();
        assert!((file.solid.flux_lm() / (100.0 * PI) - 1.0).abs() < 2e-3, "{planes:?}");
        assert_eq!((file.lamp_flux_lm, file.opening_mm), (Some(1000.0), 100.0));
        let ahead = file.solid.intensity_cd(DVec3::Z);
        assert!((ahead - 100.0).abs() < 1e-9, "{ahead}");
        assert_eq!(file.solid.intensity_cd(DVec3::NEG_Z), 0.0);
    }
    // The same solid by angles of types A and B: cos H cos V.
    let ahead = even(-90.0, 90.0, 5.0);
    for code in [2, 3] {
        let cosine =
            |p: f64, t: f64| 100.0 * (p.to_radians().cos() * t.to_radians().cos()).max(0.0);
        let file = read(&lm63(code, &ahead, &ahead, cosine)).unwrap();
        assert!((file.solid.flux_lm() / (100.0 * PI) - 1.0).abs() < 3e-3, "{code}");
        let half = read(&lm63(code, &even(0.0, 90.0, 5.0), &ahead, cosine)).unwrap();
        assert!((half.solid.flux_lm() / file.solid.flux_lm() - 1.0).abs() < 1e-9, "{code}");
    }
}

/// Horizontal angles of type A turn clockwise as seen from above: to the right of one who looks out
/// of the lamp, who sees +X on the left. Vertical angles are up.
#[test]
fn directions_are_where_the_standard_has_them() {
    let right_up = |h: f64, v: f64| if h > 0.0 && v > 0.0 { 1.0 } else { 0.0 };
    let a = read(&lm63(3, &even(-90.0, 90.0, 10.0), &even(-90.0, 90.0, 10.0), right_up)).unwrap();
    let toward = |x: f64, y: f64, z: f64| a.solid.intensity_cd(DVec3::new(x, y, z).normalize());
    assert_eq!(toward(-0.3, 0.3, 1.0), 1.0);
    assert_eq!([toward(0.3, 0.3, 1.0), toward(-0.3, -0.3, 1.0), toward(0.3, -0.3, 1.0)], [0.0; 3]);
    let side = |plane: f64, _: f64| if (45.0..=135.0).contains(&plane) { 1.0 } else { 0.0 };
    let c = read(&lm63(1, &even(0.0, 360.0, 45.0), &even(0.0, 90.0, 10.0), side)).unwrap();
    let toward = |x: f64, y: f64| c.solid.intensity_cd(DVec3::new(x, y, 1.0).normalize());
    assert!(toward(0.0, 0.5) > 0.99 && toward(0.0, -0.5) == 0.0, "C 90° is +Y");
    assert!((toward(-0.5, 0.5) - 1.0).abs() < 1e-9 && toward(-0.5, -0.5) == 0.0, "C 45°, C 315°");
    // As `ies2rad` turns them about nadir, −Z: C 0° toward +X, C 90° toward +Y; H 90° of type B toward
    // −Y, V 90° toward +X. Here all of it is turned by 180° about Y.
    for (kind, [plane, tilt], expected) in [
        (AngleType::A, [90.0, 0.0], DVec3::NEG_X),
        (AngleType::A, [0.0, 90.0], DVec3::Y),
        (AngleType::B, [90.0, 0.0], DVec3::NEG_Y),
        (AngleType::B, [0.0, 90.0], DVec3::NEG_X),
        (AngleType::C, [0.0, 90.0], DVec3::NEG_X),
        (AngleType::C, [90.0, 90.0], DVec3::Y),
    ] {
        assert!(solid::direction(kind, plane, tilt).distance(expected) < 1e-12, "{kind}");
    }
    for kind in [AngleType::A, AngleType::B, AngleType::C] {
        let [plane, tilt] = [20.0, 35.0];
        let direction = solid::direction(kind, plane, tilt);
        assert!((direction.length() - 1.0).abs() < 1e-12, "{kind}");
        let [p, t] = solid::angles_of(kind, direction);
        assert!((p - plane).abs() < 1e-9 && (t - tilt).abs() < 1e-9, "{kind}: {p} {t}");
    }
}

/// An EULUMDAT file of a symmetry, 24 planes and γ to 90°.
fn eulumdat(code: u32, cd_per_klm: impl Fn(f64, f64) -> f64) -> String {
    let mut lines: Vec<String> =
        ["maker", "1", &code.to_string(), "24", "15", "19", "5", "", "lamp", "", "", ""]
            .map(str::to_owned)
            .into();
    lines.extend(
        ["100", "0", "50", "80", "0", "0", "0", "0", "0", "100", "100", "1,0", "0", "1"]
            .map(str::to_owned),
    );
    lines.extend(["1", "LED", "500", "3000", "80", "6"].map(str::to_owned));
    lines.extend((0..10).map(|_| "0".to_owned()));
    let planes: Vec<f64> = (0..24).map(|k| 15.0 * f64::from(k)).collect();
    let tilts = even(0.0, 90.0, 5.0);
    lines.extend(planes.iter().chain(&tilts).map(f64::to_string));
    let stored: Vec<f64> = match code {
        0 => planes.clone(),
        1 => vec![0.0],
        2 => planes[..13].to_vec(),
        3 => planes[18..].iter().chain(&planes[..7]).copied().collect(),
        _ => planes[..7].to_vec(),
    };
    for plane in stored {
        lines.extend(
            tilts.iter().map(|&tilt| format!("{:.6}", cd_per_klm(plane, tilt)).replace('.', ",")),
        );
    }
    lines.join("\r\n") + "\r\n"
}

#[test]
fn symmetries_of_eulumdat_are_one_lamp() {
    // Even about both planes, so that every symmetry can hold it.
    let shape = |plane: f64, tilt: f64| {
        let (sin, cos) = plane.to_radians().sin_cos();
        tilt.to_radians().cos() * (200.0 + 50.0 * cos * cos + 20.0 * sin * sin)
    };
    let files: Vec<PhotometricFile> =
        [0, 2, 3, 4].map(|code| read(&eulumdat(code, shape)).unwrap()).into();
    for file in &files {
        assert_eq!((file.format, file.opening_mm), (PhotometricFormat::Eulumdat, 80.0));
        assert!((file.solid.flux_lm() / files[0].solid.flux_lm() - 1.0).abs() < 1e-9);
        for (x, y) in [(0.5, 0.1), (-0.4, 0.3), (-0.2, -0.6), (0.3, -0.3), (0.5, -0.02), (0.0, 0.0)]
        {
            let direction = DVec3::new(x, y, 1.0).normalize();
            let [here, there] = [file, &files[0]].map(|f| f.solid.intensity_cd(direction));
            assert!((here / there - 1.0).abs() < 1e-9, "{x} {y}: {here} {there}");
        }
    }
    let round = read(&eulumdat(1, |_, tilt| 200.0 * tilt.to_radians().cos())).unwrap();
    // 200 cd/klm of 500 lm.
    assert!((round.solid.intensity_cd(DVec3::Z) - 100.0).abs() < 1e-9);
    assert!((round.solid.flux_lm() / (100.0 * PI) - 1.0).abs() < 2e-3);
}

/// Binned into rings, rays carry the flux of the rings to the noise of an even sequence.
#[test]
fn rays_have_the_distribution() {
    let narrow = |_: f64, tilt: f64| 1000.0 * tilt.to_radians().cos().max(0.0).powi(20);
    let file = read(&lm63(1, &[0.0], &even(0.0, 90.0, 1.0), narrow)).unwrap();
    let set = file.rays(FarField { radius_mm: 4.0, samples: 1 << 14, seed: 3 }).unwrap();
    let sum: f64 = set.samples.iter().map(|ray| f64::from(ray.flux)).sum();
    for edge in [5.0f64, 10.0, 20.0, 30.0] {
        let cos = edge.to_radians().cos();
        let inside = set.samples.iter().filter(|ray| f64::from(ray.direction[2]) >= cos);
        let share = inside.map(|ray| f64::from(ray.flux)).sum::<f64>() / sum;
        let expected = 1.0 - cos.powi(21);
        assert!((share - expected).abs() < 2e-3, "{edge}: {share} {expected}");
    }
    let radius = |ray: &RaySample| f64::from(ray.position[0]).hypot(f64::from(ray.position[1]));
    let mean_square: f64 = set.samples.iter().map(|ray| radius(ray).powi(2)).sum::<f64>();
    assert!((mean_square / f64::from(1 << 14) / 8.0 - 1.0).abs() < 1e-2, "an even disc");
    assert!(set.samples.iter().all(|ray| ray.position[2] == 0.0));
    let again = file.rays(FarField { radius_mm: 4.0, samples: 1 << 14, seed: 3 }).unwrap();
    assert_eq!(set.samples, again.samples);
}

#[test]
fn bad_files_are_refused_with_their_line() {
    let good = lm63(1, &[0.0], &[0.0, 45.0, 90.0], |_, _| 10.0);
    for (change, expected) in [
        (good.replace("10 10 10", "10 x 10"), "lamp:9: an intensity is \"x\", expected a number"),
        (good.replace("10 10 10", "10 10"), "lamp:9: the file ends before an intensity"),
        (
            good.replace("10 10 10", "10 -1 10"),
            "lamp:8: an intensity is -1, allowed: finite and not negative",
        ),
        (
            good.replace("3 1 1 2", "3 1 4 2"),
            "lamp:5: photometric type 4, allowed: 1 (C), 2 (B) and 3 (A)",
        ),
        (
            good.replace("3 1 1 2", "3000000000 1 1 2"),
            "lamp:5: the number of vertical angles is 3000000000, allowed: whole numbers from 1 on",
        ),
        (good.replace("0 45 90", "0 90 45"), "lamp:8: vertical angle 45 follows 90, must ascend"),
        (good.replace("10 10 10", "0 0 0"), "lamp: the lamp gives no light in any direction"),
        ("x".to_owned(), "lamp: neither an IES LM-63 nor a EULUMDAT file"),
    ] {
        assert_eq!(message(&change), expected);
    }
    let good = eulumdat(0, |_, _| 1.0);
    assert_eq!(message(&good[..good.len() - 40]), "lamp:537: the file ends before an intensity");
    let tilted = lm63(1, &[0.0], &[0.0, 90.0], |_, _| 10.0).replace("TILT=NONE", "TILT=lamp.tlt");
    let warnings = read(&tilted).unwrap().warnings;
    assert_eq!(warnings, ["TILT=lamp.tlt is not applied: intensities as measured"]);
}

#[test]
fn mutated_files_neither_panic_nor_hang() {
    let seeds = [
        lm63(1, &[0.0, 90.0], &[0.0, 45.0, 90.0], |_, _| 10.0),
        lm63(3, &[-5.0, 0.0, 5.0], &[-5.0, 5.0], |_, _| 10.0),
        eulumdat(3, |_, _| 1.0)[..900].to_owned(),
    ];
    let seeds = seeds.map(String::into_bytes);
    for bytes in mutation::broken(&seeds, 10_000, b"0123456789 .,-eE\r\n") {
        if let Ok(file) = from_bytes(Path::new("lamp"), bytes) {
            let rays = file.rays(FarField { radius_mm: 0.0, samples: 8, seed: 1 });
            assert!(rays.unwrap().samples.iter().all(|ray| ray.flux.is_finite()));
        }
    }
}
