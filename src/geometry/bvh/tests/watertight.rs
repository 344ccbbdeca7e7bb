use super::*;

/// A point of the mesh where triangles meet: a corner, or somewhere on an edge.
fn seam(mesh: &Mesh, random: &mut Random) -> DVec3 {
    let triangle = mesh.triangles[random.below(mesh.triangles.len())];
    let [a, b] = [0, 1].map(|i| mesh.positions[triangle[i] as usize]);
    match random.below(4) {
        0 => a,
        1 => 0.5 * (a + b),
        _ => a + (b - a) * random.unit(),
    }
}

#[test]
fn no_ray_leaves_a_closed_mesh() {
    let mut random = Random(1);
    for scale in SCALES_MM {
        for center in [DVec3::ZERO, DVec3::new(0.3, -7.0, 1e3) * scale] {
            let ball = Arc::new(ball(center, scale, 24, &mut random));
            for bvh in on_each_kernel(std::slice::from_ref(&ball)) {
                for i in 0..100_000 {
                    let inside = [0.0, 0.5][i % 2] * scale * random.in_cube();
                    let ray = aimed(center + inside, seam(&ball, &mut random));
                    assert!(bvh.closest_hit(&ray, None).is_some(), "{ray:?}");
                }
            }
        }
    }
}

#[test]
fn no_ray_leaves_a_cube_along_its_axes_and_diagonals() {
    let mut random = Random(2);
    for scale in SCALES_MM {
        let cube = cube(scale, 4);
        for bvh in on_each_kernel(&cube) {
            for _ in 0..20_000 {
                let mut lattice = || f64::from(random.below(17) as u32) / 8.0 - 1.0;
                let origin = DVec3::new(lattice(), lattice(), lattice()) * (0.45 * scale);
                let direction = DVec3::new(lattice().round(), lattice().round(), lattice().round());
                if direction == DVec3::ZERO {
                    continue;
                }
                let ray = Ray { origin, direction: direction.normalize() };
                assert!(bvh.closest_hit(&ray, None).is_some(), "{ray:?}");
            }
        }
    }
}

/// Six sides of a cube around the origin, each a mesh of its own.
pub(super) fn cube(scale: f64, cells: u32) -> Vec<Arc<Mesh>> {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| axis * scale);
    (0..6)
        .map(|side| {
            let (i, j, k) = (side % 3, (side + 1) % 3, (side + 2) % 3);
            let low = -0.5 * (axes[0] + axes[1] + axes[2]);
            let corner = if side < 3 { low } else { low + axes[i] };
            grid(corner, [axes[j], axes[k]], cells)
        })
        .collect()
}

#[test]
fn a_camera_10_km_away_sees_every_seam_of_a_small_ball() {
    let mut random = Random(4);
    for scale in [1e-3, 1.0] {
        let ball = Arc::new(ball(DVec3::ZERO, scale, 24, &mut random));
        for bvh in on_each_kernel(std::slice::from_ref(&ball)) {
            for _ in 0..50_000 {
                let eye = 1e7 * random.direction();
                // Away from the outline, where a ray may rightly pass by: 10⁻⁹ mm is what f64
                // leaves of a position at 10 km.
                let target = 0.7 * seam(&ball, &mut random);
                let hit =
                    bvh.closest_hit(&aimed(eye, target), None).expect("inside of the outline");
                let point = bvh.hit_point(&hit);
                // Radius 1 to 1.02, chords 1 % lower.
                let radius = point.length() / scale;
                assert!((0.98..1.021).contains(&radius), "{radius}");
                let along = (target - eye).normalize();
                let beside = (point - eye) - along * (point - eye).dot(along);
                // In units of 2⁻⁵³ of 10⁷ mm, 1.1·10⁻⁹ mm: the length of the direction is off by 2,
                // the dot product by 3, its multiple of the direction, the difference and the start
                // of the probe by 1 along each axis.
                assert!(beside.length() < 1.2e-8, "{}", beside.length());
                assert!((hit.distance_mm - (point - eye).length()).abs() < 1.2e-8);
                assert!(hit.distance_mm < 1e7);
            }
        }
    }
}
