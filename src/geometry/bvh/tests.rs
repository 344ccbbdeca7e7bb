use super::*;
use crate::geometry::mesh::Shading;

fn mesh(positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Arc<Mesh> {
    Arc::new(Mesh { positions, triangles, shading: Shading::Flat })
}

#[test]
fn a_ray_meets_the_nearer_of_two_triangles() {
    let at = |z: f64| {
        mesh(
            vec![DVec3::new(0.0, 0.0, z), DVec3::new(1.0, 0.0, z), DVec3::new(0.0, 1.0, z)],
            vec![[0, 1, 2]],
        )
    };
    let bvh = Bvh::build(&[at(0.0), at(1.0)]);
    let ray = Ray { origin: DVec3::new(0.25, 0.5, 3.0), direction: DVec3::NEG_Z };
    let hit = bvh.closest_hit(&ray, None).expect("a hit");
    assert_eq!(hit, Hit { distance_mm: 2.0, u: 0.25, v: 0.5, triangle: TriangleId(1) });
    let behind = bvh.closest_hit(&ray, Some(TriangleId(1))).expect("a hit");
    assert_eq!(behind.triangle, TriangleId(0));
    assert!(bvh.is_occluded(ray.origin, ray.origin - 2.5 * DVec3::Z, None, &[true, true]));
    assert!(!bvh.is_occluded(ray.origin, ray.origin - 2.5 * DVec3::Z, None, &[true, false]));
}
