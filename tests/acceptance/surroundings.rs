//! Balls under a picture, against f64 integration over what their surface sees.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use lampyris::color::{Photometry, Xyz};
use lampyris::environment::{Daylight, Dome, Environment, Picture, SkyKind, SunPlace, toward};
use lampyris::geometry::{DVec3, Mesh};
use lampyris::image::SpectralImage;
use lampyris::material::{
    Fresnel, LobeShape, Lobes, Material, OpticalConstants, metal_reflectance,
};
use lampyris::render::{Quality, Samples, Unwatched, render};
use lampyris::scene::{Background, Scene, Shadows};
use lampyris::shading::{Layers, TraceLimits};
use lampyris::spectrum::{Spectrum, WavelengthGrid};
use lampyris::view::View;

use crate::stage::*;

const RADIUS_MM: f64 = 10.0;
const PIXELS: usize = 32;
/// 32′ across.
const SUN_RADIUS_DEG: f64 = 16.0 / 60.0;

/// Front outward, its seam behind.
fn ball() -> Mesh {
    let (columns, rows) = (240, 120);
    let point = |k: usize| {
        let along = (k % (columns + 1)) as f64 / columns as f64;
        let up = (k / (columns + 1)) as f64 / rows as f64;
        Some(toward(along * 360.0 - 180.0, up * 180.0 - 90.0) * RADIUS_MM)
    };
    let points: Vec<_> = (0..(columns + 1) * (rows + 1)).map(point).collect();
    Mesh::from_grid("ball", columns, rows, &points).expect("a good grid")
}

/// A blue sky with a bright spot over a brown ground, as a picture of 128 × 64 pixels.
fn landscape() -> Environment {
    let (width, height) = (128, 64);
    let color = |at: usize| {
        let (x, y) = ((at % width) as f64, (at / width) as f64);
        let spot = 30.0 * (-((x - 80.0).powi(2) + (y - 12.0).powi(2)) / 8.0).exp();
        let cloud = 1.0 + 0.4 * (x * 0.2).sin() * (y * 0.3).sin();
        let sky = Xyz::new(0.8 * cloud + spot, 0.9 * cloud + spot, 1.3 * cloud + spot);
        if y < 32.0 { sky } else { Xyz::new(0.22, 0.2, 0.1) }
    };
    let colors = (0..width * height).map(color);
    let (picture, upsampling, paled) = Picture::from_colors(width, height, colors).unwrap();
    assert_eq!(paled, 0.0);
    Environment::new(Dome::Picture(picture), upsampling.spectra.to_vec()).unwrap().turned(25.0)
}

fn under(environment: Environment, object: (Mesh, Material), shadows: Shadows) -> Scene {
    Scene {
        background: Background::Environment(Arc::new(environment)),
        photometry: Photometry::Absolute,
        shadows,
        ..scene(vec![object], Vec::new())
    }
}

fn view() -> View {
    View {
        fov_deg: 2.0 * (RADIUS_MM / 1e4f64).atan().to_degrees(),
        width: PIXELS,
        height: PIXELS,
        elevation_deg: 20.0,
        ..pixel_view(30.0, 1e4)
    }
}

fn quality(max_depth: u32) -> Quality {
    Quality {
        samples: Samples::Fixed(1),
        limits: TraceLimits { max_depth, min_throughput: 1e-6, ..TraceLimits::default() },
        ..exact(max_depth)
    }
}

/// Of a pixel, counted row by row.
fn luminance_at(image: &SpectralImage, at: usize) -> f64 {
    let bands = image.grid.bands();
    let pixel = &image.bands[at * bands..(at + 1) * bands];
    let pixel: Vec<f64> = pixel.iter().map(|v| f64::from(*v)).collect();
    Xyz::from_bands(image.grid, &pixel).y
}

/// Mean luminance over pixels well within the ball: of the picture, and as `expected` says for a
/// place on the ball (unit) and the direction toward the eye.
fn means(image: &SpectralImage, expected: impl Fn(DVec3, DVec3) -> f64) -> [f64; 2] {
    let camera = view().camera();
    let (mut sums, mut count) = ([0.0; 2], 0.0);
    for at in 0..PIXELS * PIXELS {
        let ray = camera.ray((at % PIXELS) as f64 + 0.5, (at / PIXELS) as f64 + 0.5);
        let nearest = ray.origin - ray.direction * ray.origin.dot(ray.direction);
        let across2 = nearest.length_squared() / RADIUS_MM.powi(2);
        if across2 < 0.95f64.powi(2) {
            let place = nearest / RADIUS_MM - ray.direction * (1.0 - across2).sqrt();
            sums[0] += luminance_at(image, at);
            sums[1] += expected(place, -ray.direction);
            count += 1.0;
        }
    }
    sums.map(|sum| sum / count)
}

fn luminance(environment: &Environment, direction: DVec3) -> f64 {
    environment.seen(direction).0.iter().sum()
}

#[test]
fn a_mirror_ball_shows_its_surroundings() {
    let mirror = Material { k_rg: 1.0, ..material() };
    let image = shoot(under(landscape(), (ball(), mirror), Shadows::On), &view(), &quality(4));
    let environment = landscape();
    let [found, expected] = means(&image, |n, v| luminance(&environment, 2.0 * n.dot(v) * n - v));
    assert_close(found, expected, 5e-3, "mirror ball");
}

#[test]
fn a_glass_ball_shows_its_surroundings() {
    let glass = Material {
        transmittance: Some(Spectrum::constant(1.0)),
        ior: Some(Spectrum::constant(1.5)),
        k_tg: 1.0,
        ..material()
    };
    let image = shoot(under(landscape(), (ball(), glass), Shadows::On), &view(), &quality(4));
    let environment = landscape();
    let refract = |d: DVec3, n: DVec3, eta: f64| {
        let cos = -d.dot(n);
        let out = (1.0 - eta * eta * (1.0 - cos * cos)).sqrt();
        eta * d + (eta * cos - out) * n
    };
    let [found, expected] = means(&image, |n, v| {
        let inside = refract(-v, n, 1.0 / 1.5);
        let far = n - 2.0 * n.dot(inside) * inside;
        luminance(&environment, refract(inside, -far, 1.5))
    });
    assert_close(found, expected, 5e-3, "glass ball");
}

#[test]
fn a_white_ball_is_lit_by_its_surroundings() {
    let environment = landscape();
    let (rows, columns) = (180, 360);
    let looks = (0..rows * columns).map(|at| {
        let theta = PI * ((at / columns) as f64 + 0.5) / rows as f64;
        let phi = TAU * ((at % columns) as f64 + 0.5) / columns as f64;
        let direction = toward(phi.to_degrees(), 90.0 - theta.to_degrees());
        let solid_angle = theta.sin() * (PI / rows as f64) * (TAU / columns as f64);
        (direction, luminance(&environment, direction) * solid_angle)
    });
    let looks: Vec<(DVec3, f64)> = looks.collect();
    let irradiance =
        |n: DVec3| looks.iter().map(|(l, light)| light * l.dot(n).max(0.0)).sum::<f64>();
    for shadows in [Shadows::Off, Shadows::On] {
        let white = Material { lobes: diffuse(1.0, 1.0), ..material() };
        let image = shoot(under(landscape(), (ball(), white), shadows), &view(), &quality(1));
        let [found, expected] = means(&image, |n, _| irradiance(n) / PI);
        assert_close(found, expected, 5e-3, "white ball");
    }
}

/// Luminance 1 from everywhere.
fn furnace(width: usize, height: usize) -> Environment {
    let picture = Picture::new(width, height, vec![[1.0, 0.0, 0.0]; width * height]).unwrap();
    Environment::new(Dome::Picture(picture), vec![Spectrum::constant(1.0)]).unwrap()
}

/// At the default quality and in a picture, with shadow rays and without: a white Lambertian
/// surface within 1e-4, a lobe of exponent n, which returns (n + 2)/(n + 1), within 1e-3.
#[test]
fn a_white_furnace_is_seen_as_one() {
    let lobes = [
        (diffuse(1.0, 1.0), 1.0, 1e-4),
        (specular(1.0, 20.0), 22.0 / 21.0, 1e-3),
        (specular(1.0, 1500.0), 1502.0 / 1501.0, 1e-3),
    ];
    for (width, height) in [(1, 1), (7, 5), (64, 32), (1000, 500)] {
        let environment = furnace(width, height);
        for shadows in [Shadows::Off, Shadows::On] {
            for (lobes, expected, allowed) in &lobes {
                let white = Material { lobes: lobes.clone(), ..material() };
                let scene = under(environment.clone(), (square(0.0, 50.0), white), shadows);
                let image = shoot(scene, &pixel_view(10.0, 100.0), &Quality::default());
                let what = format!("{width} × {height}, {shadows:?}, {lobes:?}");
                assert_close(luminance_at(&image, 0), *expected, *allowed, &what);
            }
        }
    }
}

/// Rays and lobes see the same light: together they return no more than arrives.
#[test]
fn the_papers_reflector_is_no_source() {
    let mut reflector = Material { k_rg: 0.95, lobes: specular(0.92, 1500.0), ..material() };
    (reflector.lobes.k_d, reflector.lobes.n_d) = (0.08, 10.0);
    let image =
        shoot(under(furnace(8, 4), (ball(), reflector), Shadows::Off), &view(), &quality(4));
    let [found, _] = means(&image, |_, _| 0.0);
    assert!((0.95..1.0).contains(&found), "{found}");
}

/// A rough metal's lobes follow Fresnel's law at V's angle, as its mirrored ray would.
#[test]
fn a_rough_metal_returns_its_reflectance_at_every_angle() {
    let OpticalConstants { n, k } = OpticalConstants::aluminium();
    let lobes = Lobes { shape: LobeShape::Half, ..specular(1.0, 1500.0) };
    let white = Material { lobes, ..material() };
    let fresnel = Fresnel::Metal { n: n.clone(), k: k.clone() };
    let metal = Material { fresnel, ..white.clone() };
    for angle_deg in [0.0f64, 45.0, 80.0] {
        let [metal, white] = [&metal, &white].map(|material| {
            let object = (square(0.0, 10.0), material.clone());
            shoot(
                under(furnace(8, 4), object, Shadows::Off),
                &pixel_view(angle_deg, 100.0),
                &exact(0),
            )
        });
        for (band, lambda_nm) in WavelengthGrid::Step5.wavelengths_nm().enumerate() {
            let [metal, white] = [&metal, &white].map(|image| f64::from(image.pixel(0, 0)[band]));
            let index = [n.at(lambda_nm), k.at(lambda_nm)];
            let expected = metal_reflectance(angle_deg.to_radians().cos(), 1.0, index);
            assert_close(metal / white, expected, 1e-6, &format!("{angle_deg}° {lambda_nm} nm"));
        }
    }
}

/// Nothing but a sun of 10⁵ lx at azimuth 0; its sky is too dark to count.
fn sun_alone(elevation_deg: f64) -> Environment {
    let illuminance_lx = Some(1e5);
    let sun = SunPlace { azimuth_deg: 0.0, elevation_deg, illuminance_lx, cct_k: None };
    let day = Daylight {
        kind: SkyKind::standard(5).unwrap(),
        sun: Some(sun),
        turbidity: 2.0,
        cct_k: None,
        ground: Spectrum::constant(0.0),
        illuminance_lx: Some(1e5 * elevation_deg.to_radians().sin() + 1.0),
    };
    day.environment().unwrap()
}

/// Share of the sun's light on a floor that passes an upright edge's top: the disc's points higher
/// than `lowest_deg`, by the midpoint rule over the disc.
fn seen_of_sun(elevation_deg: f64, lowest_deg: f64) -> f64 {
    const STEPS: usize = 4000;
    let (mut seen, mut all) = (0.0, 0.0);
    for step in 0..STEPS {
        let t = 2.0 * (step as f64 + 0.5) / STEPS as f64 - 1.0;
        let at_deg = elevation_deg + t * SUN_RADIUS_DEG;
        let light = (1.0 - t * t).sqrt() * at_deg.to_radians().sin();
        all += light;
        seen += if at_deg > lowest_deg { light } else { 0.0 };
    }
    seen / all
}

/// From where a falling row of values passes `high` to where it passes `low`, in steps of the row.
fn fall(row: &[f64], [high, low]: [f64; 2]) -> f64 {
    let passes = |level: f64| {
        let at = row.windows(2).position(|pair| pair[0] >= level && pair[1] < level).unwrap();
        at as f64 + (row[at] - level) / (row[at] - row[at + 1])
    };
    passes(low) - passes(high)
}

/// A roof's shadow on the floor, in 81 pixels across its edge from light to dark: each within 1 % of
/// the full light, and the width from 90 % to 10 % within 1 %. Steps of 0.1 % of the disc and
/// lines between pixels leave less than half of that.
#[test]
fn the_suns_shadow_has_its_soft_edge() {
    let white = Material { lobes: diffuse(1.0, 1.0), ..material() };
    let height = 1000.0;
    for elevation_deg in [90.0f64, 30.0, 10.0] {
        // The floor's eye looks at where the disc's middle is cut.
        let (sin, cos) = elevation_deg.to_radians().sin_cos();
        let edge_z = height * cos / sin;
        let pixel_mm = 0.14 * height * SUN_RADIUS_DEG.to_radians() / (sin * sin) / 5.0;
        let floor = rectangle(DVec3::ZERO, DVec3::Z * 900.0, DVec3::X * 900.0);
        let half = 20.0 * height;
        let roof =
            rectangle(DVec3::new(0.0, height, edge_z + half), DVec3::Z * half, DVec3::X * half);
        let all = Scene {
            background: Background::Environment(Arc::new(sun_alone(elevation_deg))),
            photometry: Photometry::Absolute,
            shadows: Shadows::On,
            ..scene(vec![(floor, white.clone()), (roof, material())], Vec::new())
        };
        let view = View {
            elevation_deg: 89.999,
            fov_deg: 2.0 * (0.5 * pixel_mm / 500.0).atan().to_degrees(),
            width: 81,
            height: 1,
            ..pixel_view(90.0, 500.0)
        };
        let image = shoot(all, &view, &Quality { samples: Samples::Fixed(1), ..quality(1) });
        let level_lx = 1e5 * sin;
        let found: Vec<f64> =
            (0..81).map(|x| luminance_at(&image, x) * PI / level_lx).rev().collect();
        let expected: Vec<f64> = (0..81)
            .map(|x| {
                let z = (f64::from(x) - 40.0) * pixel_mm;
                seen_of_sun(elevation_deg, height.atan2(edge_z - z).to_degrees())
            })
            .collect();
        for (x, (found, expected)) in found.iter().zip(&expected).enumerate() {
            let error = (found - expected).abs();
            assert!(error < 0.01, "{elevation_deg}°, {x}: {found}, expected {expected}");
        }
        let [found, expected] = [&found, &expected].map(|row| fall(row, [0.9, 0.1]));
        assert_close(found, expected, 0.01, &format!("width of the edge at {elevation_deg}°"));
    }
}

/// A white ball on a floor under a picture and a sun, lit by a lamp of its own.
fn ball_by_day(flux_lm: f64, environment: Option<Environment>) -> Scene {
    let glossy = Material { k_rg: 0.05, lobes: specular(0.3, 300.0), ..material() };
    let white = Material { lobes: diffuse(1.0, 1.0), ..material() };
    let floor = rectangle(DVec3::Y * -10.0, DVec3::Z * 40.0, DVec3::X * 40.0);
    let lamp = point_light(DVec3::new(0.0, 20.0, 20.0), DVec3::NEG_Y, flux_lm);
    let dark = Background::Even(Spectrum::constant(0.0));
    Scene {
        background: environment.map_or(dark, |sky| Background::Environment(Arc::new(sky))),
        photometry: Photometry::Absolute,
        shadows: Shadows::On,
        ..scene(vec![(ball(), glossy), (floor, white)], vec![lamp])
    }
}

fn a_day() -> Environment {
    let sun =
        SunPlace { azimuth_deg: 40.0, elevation_deg: 20.0, illuminance_lx: None, cct_k: None };
    let day = Daylight {
        kind: SkyKind::standard(12).unwrap(),
        sun: Some(sun),
        turbidity: 3.0,
        cct_k: None,
        ground: Spectrum::constant(0.2),
        illuminance_lx: None,
    };
    day.environment().unwrap()
}

fn small_view() -> View {
    View { width: 12, height: 9, fov_deg: 16.0, elevation_deg: 15.0, ..pixel_view(20.0, 120.0) }
}

#[test]
fn any_number_of_threads_gives_the_same_bits_by_day() {
    let prepared = ball_by_day(1000.0, Some(a_day())).prepare().unwrap();
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| shoot_prepared(&prepared, &small_view(), &Quality::default()))
    };
    let one = with(1);
    assert!(one.bands.iter().any(|&value| value > 0.0));
    for threads in [2, 5] {
        assert!(with(threads) == one, "{threads} threads");
    }
}

/// The lamp's layer is the lamp in the dark, the surroundings' is the day without the lamp.
#[test]
fn lit_and_unlit_are_layers_of_one_picture() {
    let quality = |layers| Quality { layers, ..quality(2) };
    let shot = |scene, layers| shoot(scene, &small_view(), &quality(layers));
    let lit = shot(ball_by_day(1000.0, Some(a_day())), Layers::Lights);
    let unlit = shot(ball_by_day(1e-9, Some(a_day())), Layers::None);
    let dark = shot(ball_by_day(1000.0, None), Layers::None);
    let layers: Vec<SpectralImage> = lit.layers.iter().map(|layer| lit.layer(layer)).collect();
    let [lamp, day] = &layers[..] else { panic!("{} layers", layers.len()) };
    let largest = lit.bands.iter().copied().fold(0.0, f32::max);
    let is_near = |a: &f32, b: &f32| (a - b).abs() <= 1e-5 * largest;
    assert!(lamp.bands.iter().zip(&dark.bands).all(|(a, b)| is_near(a, b)), "lamp");
    assert!(day.bands.iter().zip(&unlit.bands).all(|(a, b)| is_near(a, b)), "day");
}

/// A white floor without a lamp asks nothing and sends no shadow ray, unless there are surroundings.
#[test]
fn a_scene_without_surroundings_pays_nothing() {
    let asked = |background: Background| {
        let white = Material { lobes: diffuse(1.0, 1.0), ..material() };
        let bare = scene(vec![(square(0.0, 50.0), white)], Vec::new());
        let bare =
            Scene { background, photometry: Photometry::Absolute, shadows: Shadows::On, ..bare };
        let prepared = bare.prepare().unwrap();
        let (_, stats) =
            render(&prepared, &pixel_view(10.0, 100.0), &Quality::default(), &Unwatched).unwrap();
        [stats.counts.light_nodes, stats.counts.shadow_rays]
    };
    assert_eq!(asked(Background::Even(Spectrum::constant(1.0))), [0, 0]);
    let by_day = asked(Background::Environment(Arc::new(a_day())));
    assert!(by_day.iter().all(|count| *count > 0), "{by_day:?}");
}

/// A picture that this program wrote is the surroundings that it was taken of.
#[test]
fn an_exr_of_a_script_becomes_surroundings() {
    let folder = scratch("environment_exr");
    std::fs::create_dir_all(&folder).unwrap();
    let script = folder.join("sky.lua");
    let text = r#"
        local lampyris = require "lampyris"
        local white = lampyris.spectrum.illuminant "D65"
        local _, Y = white:xyz()
        local empty = lampyris.scene {
          objects = {}, photometry = "absolute", background = white * (500 / Y),
        }
        local taken = empty:render(lampyris.view { width = 16, height = 8 }, { samples = 1 })
        taken:save("sky.exr")
        taken:save("sky.hdr")
        local function check(found, expected, what)
          assert(math.abs(found / expected - 1) < 2e-3, ("%s: %g, not %g"):format(what, found, expected))
        end
        local sky = lampyris.environment.load("sky.exr")
        check(sky:illuminance(), math.pi * 500, "level")
        check(sky:illuminance { 1, 0, 0 }, math.pi * 500, "upright")
        local bright = lampyris.environment.load("sky.exr", { illuminance = 20000, rotate = 90 })
        check(bright:illuminance(), 20000, "as asked")
        local seen = lampyris.scene { objects = {}, photometry = "absolute", background = bright }
        local image = seen:render(lampyris.view { width = 2, height = 2 }, { samples = 1 })
        check(image:luminance(), 20000 / math.pi, "seen")
        -- An RGBE pixel has 8 bits a channel: 1 part in 256 at worst; its file has no cd/m².
        local radiance = lampyris.environment.load("sky.hdr", { illuminance = 20000, scale = 0.5 })
        check(radiance:illuminance(), 10000, "of a Radiance picture")
        -- 179 lm/W makes cd/m² of a Radiance picture's 1, unless it is said otherwise.
        local plain = lampyris.environment.load("sky.hdr"):illuminance()
        assert(math.abs(plain / (math.pi * 500) - 1) < 1 / 128, plain)
        local dim = lampyris.environment.load("sky.hdr", { luminance = 17.9 })
        check(dim:illuminance(), plain / 10, "of a white that is given")
    "#;
    std::fs::write(&script, text).unwrap();
    run_script(&script, &folder, &[]);
}
