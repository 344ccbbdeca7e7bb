//! Light is linear: the layers of a picture add up to it, and weigh like dimmed lamps.

use lampyris::color::Photometry;
use lampyris::geometry::DVec3;
use lampyris::image::{SpectralImage, weighted_sum};
use lampyris::material::Material;
use lampyris::render::{Quality, Samples};
use lampyris::scene::{Interreflection, Scene};
use lampyris::shading::Layers;
use lampyris::spectrum::{Spectrum, WavelengthGrid};
use lampyris::view::View;

use crate::stage::{
    busy_scene, diffuse, exact, material, pixel_view, point_light, shoot, shoot_prepared, square,
};

/// A lamp of two lights behind a clear pane, before a background.
fn lamp(flux_lm: [f64; 2]) -> Scene {
    let mut scene = busy_scene();
    let place = DVec3::new(5.0, 0.0, 40.0);
    let mut second = point_light(place, DVec3::new(0.0, 0.0, -1.0), flux_lm[1]);
    second.spectrum = Spectrum::blackbody(4000.0);
    scene.lights[0].rays.flux_lm = flux_lm[0];
    scene.lights.push(second);
    let pane = Material {
        reflectance: Spectrum::constant(0.3),
        transmittance: Some(Spectrum::constant(0.9)),
        lobes: diffuse(0.1, 1.0),
        k_rg: 0.1,
        k_tg: 0.9,
        ..material()
    };
    scene.objects.push(lampyris::scene::Object {
        mesh: std::sync::Arc::new(square(60.0, 30.0)),
        material: lampyris::scene::MaterialId(scene.materials.len()),
    });
    scene.materials.push(pane);
    scene
}

fn shot(flux_lm: [f64; 2], layers: Layers) -> SpectralImage {
    let view = View { fov_deg: 8.0, width: 24, height: 18, ..pixel_view(5.0, 600.0) };
    let quality =
        Quality { samples: Samples::Fixed(2), layers, grid: WavelengthGrid::Step20, ..exact(4) };
    shoot(lamp(flux_lm), &view, &quality)
}

/// Sums of f32 values, each rounded once: relative to the brightest band.
fn assert_same(image: &SpectralImage, expected: &SpectralImage, what: &str) {
    let largest = expected.bands.iter().copied().fold(0.0, f32::max);
    for (value, expected) in image.bands.iter().zip(&expected.bands) {
        let error = (value - expected).abs();
        assert!(error <= 1e-6 * expected.max(largest * 1e-3), "{what}: {value} {expected}");
    }
}

#[test]
fn layers_add_up_to_the_whole() {
    let whole = shot([440.0, 30.0], Layers::None);
    for (layers, names) in [
        (Layers::Lights, vec!["light 1", "light 2", "surroundings"]),
        (Layers::Paths, vec!["direct", "mirrored", "transmitted"]),
    ] {
        let image = shot([440.0, 30.0], layers);
        assert!(image.bands == whole.bands, "layers change nothing");
        let found: Vec<&str> = image.layers.iter().map(|layer| layer.name.as_str()).collect();
        assert_eq!(found, names);
        let parts: Vec<SpectralImage> = image.layers.iter().map(|l| image.layer(l)).collect();
        assert!(parts.iter().all(|part| part.bands.iter().any(|&value| value > 0.0)));
        let terms: Vec<_> = parts.iter().map(|part| (1.0, part)).collect();
        assert_same(&weighted_sum(&terms).expect("of one kind"), &whole, "sum");
    }
}

#[test]
fn weighted_layers_are_dimmed_lamps() {
    let image = shot([440.0, 30.0], Layers::Lights);
    let parts: Vec<SpectralImage> = image.layers.iter().map(|l| image.layer(l)).collect();
    let relit =
        weighted_sum(&[(0.1, &parts[0]), (2.5, &parts[1]), (1.0, &parts[2])]).expect("of one kind");
    assert_same(&relit, &shot([44.0, 75.0], Layers::None), "relit");
}

/// What surfaces pass on belongs to its light where it is kept apart, and else to a layer of its own.
#[test]
fn light_passed_on_has_its_layer() {
    let quality = |layers| Quality { layers, grid: WavelengthGrid::Step20, ..exact(4) };
    let view = View { fov_deg: 8.0, width: 12, height: 9, ..pixel_view(5.0, 600.0) };
    let light = |image: &SpectralImage| image.bands.iter().map(|&v| f64::from(v)).sum::<f64>();
    let apart = ["light 1", "light 2", "surroundings"];
    let together = ["light 1", "light 2", "bounced", "surroundings"];
    let paths = ["direct", "mirrored", "transmitted", "bounced"];
    for (by_light, layers, names) in [
        (true, Layers::Lights, &apart[..]),
        (false, Layers::Lights, &together[..]),
        (false, Layers::Paths, &paths[..]),
    ] {
        let mut scene = lamp([440.0, 30.0]);
        scene.photometry = Photometry::Absolute;
        scene.lights[1].spectrum = scene.lights[0].spectrum.clone();
        let first = shoot(scene.clone(), &view, &quality(layers));
        scene.interreflection =
            Some(Interreflection { bounces: 3, samples: 2000, seed: 1, by_light });
        let prepared = lampyris::shading::prepare(scene, &[]).expect("a good scene");
        let image = shoot_prepared(&prepared, &view, &quality(layers));
        let found: Vec<&str> = image.layers.iter().map(|layer| layer.name.as_str()).collect();
        assert_eq!(found, names);
        let parts: Vec<SpectralImage> = image.layers.iter().map(|l| image.layer(l)).collect();
        let terms: Vec<_> = parts.iter().map(|part| (1.0, part)).collect();
        assert_same(&weighted_sum(&terms).expect("of one kind"), &image, "sum");
        let gain = light(&parts[0]) / light(&first.layer(&first.layers[0]));
        assert!(if by_light { gain > 1.0001 } else { gain == 1.0 }, "{by_light}: {gain}");
    }
}
