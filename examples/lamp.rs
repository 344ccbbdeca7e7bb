//! A lit reflector as a picture: the renderer without Lua.
//!
//!     cargo run --release --no-default-features --example lamp

use std::path::Path;
use std::sync::Arc;

use lampyris::color::Photometry;
use lampyris::display::Look;
use lampyris::geometry::DVec3;
use lampyris::geometry::import::{self, MeshReading};
use lampyris::material::{Lobes, Material, SpecularLobe};
use lampyris::render::{Quality, Unwatched, render};
use lampyris::scene::{Light, MaterialId, Object, Scene, Shadows};
use lampyris::source::rayfile::{self, LightOptions};
use lampyris::spectrum::Spectrum;
use lampyris::view::View;
use lampyris::{Result, output};

/// Writes `lamp.exr` and `lamp.png` into `folder`.
pub fn draw(data: &Path, folder: &Path) -> Result<()> {
    let mesh = Arc::new(import::load(&data.join("part0.obj"), &MeshReading::default())?.mesh);
    let spectrum = Some(Spectrum::blackbody(2856.0));
    let rays = rayfile::read(&data.join("rays0.csv"))?;
    let (rays, spectrum) = rays.into_light(LightOptions { spectrum, flux_lm: Some(440.0) })?;
    let aluminium = Material {
        name: "aluminium".to_owned(),
        reflectance: Spectrum::constant(0.87),
        lobes: Lobes {
            k_d: 0.1,
            n_d: 10.0,
            specular: vec![SpecularLobe { k_s: 0.9, n_s: 1500.0 }],
            ..Lobes::default()
        },
        k_rg: 0.95,
        ..Material::default()
    };
    let scene = Scene {
        objects: vec![Object { mesh, material: MaterialId(0) }],
        materials: vec![aluminium],
        lights: vec![Light::new(rays, spectrum)],
        photometry: Photometry::Absolute,
        shadows: Shadows::On,
        ..Scene::default()
    };
    let view = View {
        azimuth_deg: 6.0,
        elevation_deg: 0.0,
        distance_mm: 600.0,
        target: DVec3::ZERO,
        fov_deg: 12.0,
        width: 160,
        height: 120,
    };
    let (image, _) = render(&scene.prepare()?, &view, &Quality::default(), &Unwatched)?;
    output::write_exr(&folder.join("lamp.exr"), &image)?;
    output::develop_png(&folder.join("lamp.png"), &image, &Look::seen())?;
    Ok(())
}

fn main() -> Result<()> {
    draw(Path::new("tests/goldens/reflector"), Path::new("."))
}
