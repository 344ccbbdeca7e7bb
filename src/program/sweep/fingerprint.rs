//! What a scene holds, as one digest: equal scenes give equal pictures.

use super::digest::{Digest, Hasher};
use crate::geometry::mesh::Shading;
use crate::geometry::{DVec3, Mesh};
use crate::light::RaySet;
use crate::material::Material;
use crate::scene::{Background, Light, Object, Scene};
use crate::source::Emitter;

/// Digest of all that rendering reads from `scene`.
///
/// The fields are named one by one, so that a new one cannot be forgotten here.
pub fn of_scene(scene: &Scene) -> Digest {
    let Scene {
        objects,
        materials,
        lights,
        background,
        ambient,
        photometry,
        shadows,
        interreflection,
        contact_mm,
    } = scene;
    let mut hasher = Hasher::new();
    // Debug shows every field, and numbers with all their digits.
    let background = match background {
        Background::Even(spectrum) => format!("{spectrum:?}"),
        Background::Environment(environment) => format!("{:?}", environment.parts()),
    };
    // A name is for messages.
    let unnamed = |m: &Material| Material { name: String::new(), ..m.clone() };
    let materials: Vec<Material> = materials.iter().map(unnamed).collect();
    hasher.text(&format!("{materials:?} {background} {ambient:?} {photometry:?} {shadows:?}"));
    hasher.floats([*contact_mm].into_iter());
    if let Some(interreflection) = interreflection {
        hasher.text(&format!("{interreflection:?}"));
    }
    for Object { mesh, material } in objects {
        hasher.text(&format!("object {material:?}"));
        add_mesh(&mut hasher, mesh);
    }
    for Light { rays, spectrum, surface } in lights {
        hasher.text(&format!("light {spectrum:?}"));
        add_rays(&mut hasher, rays);
        if let Some(Emitter { mesh, radiance }) = surface {
            hasher.text(&format!("surface {radiance:?}"));
            add_mesh(&mut hasher, mesh);
        }
    }
    hasher.finish()
}

fn add_mesh(hasher: &mut Hasher, mesh: &Mesh) {
    let Mesh { positions, triangles, shading } = mesh;
    add_points(hasher, positions);
    add_triangles(hasher, triangles);
    match shading {
        Shading::Flat => hasher.text("flat"),
        Shading::PerPosition(normals) => {
            hasher.text("per position");
            add_points(hasher, normals);
        }
        Shading::PerCorner { normals, triangles } => {
            hasher.text("per corner");
            add_points(hasher, normals);
            add_triangles(hasher, triangles);
        }
    }
}

fn add_points(hasher: &mut Hasher, points: &[DVec3]) {
    hasher.bytes(&(points.len() as u64).to_le_bytes());
    for point in points {
        hasher.floats(point.to_array().into_iter());
    }
}

fn add_triangles(hasher: &mut Hasher, triangles: &[[u32; 3]]) {
    hasher.bytes(&(triangles.len() as u64).to_le_bytes());
    for index in triangles.iter().flatten() {
        hasher.bytes(&index.to_le_bytes());
    }
}

fn add_rays(hasher: &mut Hasher, rays: &RaySet) {
    // Where a far field is good changes no light.
    let RaySet { samples, world_from_local, flux_lm, exponent, good_beyond_mm: _ } = rays;
    hasher.floats(world_from_local.to_cols_array().into_iter());
    hasher.floats([*flux_lm].into_iter());
    if *exponent != 1.0 {
        hasher.text(&format!("directions {exponent}"));
    }
    hasher.samples(samples);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::RaySample;
    use crate::material::Lobes;
    use crate::scene::{MaterialId, Shadows};
    use crate::spectrum::Spectrum;
    use std::sync::Arc;

    fn scene() -> Scene {
        let positions = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
        let material = Material {
            reflectance: Spectrum::constant(0.5),
            lobes: Lobes { k_d: 1.0, ..Lobes::default() },
            ..Material::default()
        };
        let sample = RaySample { position: [0.0; 3], direction: [0.0, 0.0, 1.0], flux: 1.0 };
        Scene {
            objects: vec![Object {
                mesh: Arc::new(Mesh::flat("t", positions, vec![[0, 1, 2]]).unwrap()),
                material: MaterialId(0),
            }],
            materials: vec![material],
            lights: vec![Light {
                surface: None,
                rays: RaySet::new([sample].into(), 10.0),
                spectrum: Spectrum::blackbody(2856.0),
            }],
            ..Scene::default()
        }
    }

    #[test]
    fn every_change_changes_the_digest() {
        let base = of_scene(&scene());
        assert_eq!(base, of_scene(&scene()));
        let mut renamed = scene();
        renamed.materials[0].name = "another".to_owned();
        assert_eq!(base, of_scene(&renamed), "a name is no light");
        let changes: [fn(&mut Scene); 7] = [
            |s| s.materials[0].k_rg = 1e-300,
            |s| s.background = Background::Even(Spectrum::constant(1e-30)),
            |s| s.shadows = Shadows::On,
            |s| s.lights[0].rays.flux_lm = 10.000000000000002,
            |s| s.lights[0].rays.world_from_local.translation.z = 1e-12,
            |s| Arc::make_mut(&mut s.objects[0].mesh).positions[2].z = -0.0,
            |s| s.objects.clear(),
        ];
        for (at, change) in changes.into_iter().enumerate() {
            let mut scene = scene();
            change(&mut scene);
            assert_ne!(base, of_scene(&scene), "change {at}");
        }
    }
}
