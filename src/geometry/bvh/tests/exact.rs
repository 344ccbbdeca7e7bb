use proptest::prelude::*;

use super::*;

#[test]
fn a_ray_meets_the_nearer_of_two_triangles() {
    let at = |z: f64| {
        mesh(
            vec![DVec3::new(0.0, 0.0, z), DVec3::new(1.0, 0.0, z), DVec3::new(0.0, 1.0, z)],
            vec![[0, 1, 2]],
        )
    };
    let ray = Ray { origin: DVec3::new(0.25, 0.5, 3.0), direction: DVec3::NEG_Z };
    let below = ray.origin - 2.5 * DVec3::Z;
    for bvh in on_each_kernel(&[at(0.0), at(1.0)]) {
        let hit = bvh.closest_hit(&ray, None);
        assert_eq!(hit, Some(Hit { distance_mm: 2.0, u: 0.25, v: 0.5, triangle: TriangleId(1) }));
        let behind = bvh.closest_hit(&ray, Some(TriangleId(1)));
        assert_eq!(behind.map(|hit| hit.triangle), Some(TriangleId(0)));
        assert!(bvh.is_occluded(ray.origin, below, None, &[true, true]));
        assert!(!bvh.is_occluded(ray.origin, below, None, &[true, false]));
        assert!(!bvh.is_occluded(ray.origin, below, Some(TriangleId(1)), &[true, true]));
        assert_eq!(bvh.locate(TriangleId(1)), (1, 0));
    }
}

#[test]
fn equal_distances_go_to_the_lower_number() {
    let one = grid(DVec3::ZERO, [DVec3::X, DVec3::Y], 1);
    let ray = Ray { origin: DVec3::new(0.75, 0.25, 1.0), direction: DVec3::NEG_Z };
    for bvh in on_each_kernel(&vec![one; 40]) {
        assert_eq!(bvh.closest_hit(&ray, None).map(|hit| hit.triangle), Some(TriangleId(0)));
        let second = bvh.closest_hit(&ray, Some(TriangleId(0)));
        assert_eq!(second.map(|hit| hit.triangle), Some(TriangleId(2)));
    }
}

#[test]
fn weights_are_those_of_moller_and_trumbore() {
    let mut random = Random(7);
    for _ in 0..2000 {
        let [a, b, c] = [(); 3].map(|()| random.in_cube());
        let (u, v) = (0.8 * random.unit(), 0.2 * random.unit());
        let target = a + (b - a) * u + (c - a) * v;
        let ray = aimed(3.0 * random.direction(), target);
        let bvh = Bvh::build(&[mesh(vec![a, b, c], vec![[0, 1, 2]])]);
        let (e1, e2) = (b - a, c - a);
        let p = ray.direction.cross(e2);
        let det = e1.dot(p);
        if det.abs() < 1e-3 {
            continue;
        }
        let from_a = ray.origin - a;
        let q = from_a.cross(e1);
        let hit = bvh.closest_hit(&ray, None).expect("aimed inside");
        // Both round products of size 10 to f64 and divide by at least 10⁻³.
        let close = |x: f64, y: f64| (x - y).abs() < 1e-11;
        assert!(close(hit.u, from_a.dot(p) / det) && close(hit.u, u));
        assert!(close(hit.v, ray.direction.dot(q) / det) && close(hit.v, v));
        assert!(close(hit.distance_mm, e2.dot(q) / det));
    }
}

/// Triangles of all kinds: soups, shared corners, slivers, flat ones, doubles, degenerate ones.
pub(super) fn any_mesh(random: &mut Random, center: DVec3, size: f64) -> Arc<Mesh> {
    let flat = random.below(4);
    let step = [0.0, 0.25][random.below(2)];
    let place = |random: &mut Random| {
        let mut p = random.in_cube();
        if step > 0.0 {
            // On a lattice: coplanar triangles, equal corners, rays along edges.
            p = (p / step).round() * step;
        }
        if flat < 3 && step == 0.0 && random.below(2) == 0 {
            p[flat] *= 1e-9;
        }
        center + size * p
    };
    let count = 3 + random.below(120);
    let mut positions: Vec<DVec3> = (0..count).map(|_| place(random)).collect();
    let near = positions[0] + (positions[1] - positions[0]) * 1e-7;
    positions.push(near);
    let triangles = (0..1 + random.below(200))
        .map(|_| [(); 3].map(|()| random.below(positions.len()) as u32))
        .collect();
    mesh(positions, triangles)
}

fn any_ray(random: &mut Random, meshes: &[Arc<Mesh>], center: DVec3, size: f64) -> Ray {
    let far = [0.3, 1.0, 20.0, 1e4][random.below(4)];
    let mut origin = center + random.in_cube() * (size * far);
    let positions = &meshes[random.below(meshes.len())].positions;
    let corner = positions[random.below(positions.len())];
    let other = positions[random.below(positions.len())];
    match random.below(5) {
        0 => Ray { origin, direction: random.direction() },
        1 => {
            // Along an axis, through a corner.
            let axis = random.below(3);
            let mut direction = DVec3::ZERO;
            direction[axis] = if random.below(2) == 0 { 1.0 } else { -1.0 };
            let distance = origin[axis];
            origin = corner;
            origin[axis] = distance;
            Ray { origin, direction }
        }
        2 => Ray { origin: corner, direction: random.direction() },
        3 if corner != origin => aimed(origin, corner),
        _ => aimed(origin, corner + (other - corner) * random.unit() + size * 1e-3),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]
    #[test]
    fn hits_are_those_of_brute_force(seed: u64, exponent in -3.0..6.0f64, away in 0usize..3) {
        let mut random = Random(seed);
        let size = 10f64.powf(exponent);
        let center = random.in_cube() * [0.0, 10.0 * size, 1e7][away];
        let meshes: Vec<_> =
            (0..1 + random.below(3)).map(|_| any_mesh(&mut random, center, size)).collect();
        let all = on_each_kernel(&meshes);
        for _ in 0..100 {
            let ray = any_ray(&mut random, &meshes, center, size);
            let expected = brute_force(&all[0], &ray, None);
            let leaving = expected.map(|hit| hit.triangle);
            let next = brute_force(&all[0], &ray, leaving);
            for bvh in &all {
                prop_assert_eq!(bvh.closest_hit(&ray, None), expected);
                prop_assert_eq!(bvh.closest_hit(&ray, leaving), next);
            }
        }
    }

    #[test]
    fn hidden_is_what_a_nearer_hit_hides(seed: u64, exponent in -3.0..6.0f64) {
        let mut random = Random(seed);
        let size = 10f64.powf(exponent);
        let meshes = [(); 3].map(|()| any_mesh(&mut random, DVec3::ZERO, size));
        let blocks = [0, 1, 2].map(|_| random.below(2) == 0);
        let blockers: Vec<_> = (0..3).filter(|&i| blocks[i]).map(|i| meshes[i].clone()).collect();
        let all = on_each_kernel(&meshes);
        let only_blockers = Bvh::build(&blockers);
        for _ in 0..100 {
            let [from, target] = [(); 2].map(|()| random.in_cube() * (1.5 * size));
            let distance = (target - from).length();
            let hit = only_blockers.closest_hit(&aimed(from, target), None);
            // A hit exactly at the target is decided by rounding.
            if hit.is_some_and(|hit| (hit.distance_mm / distance - 1.0).abs() < 1e-9) {
                continue;
            }
            let expected = hit.is_some_and(|hit| hit.distance_mm < distance);
            for bvh in &all {
                prop_assert_eq!(bvh.is_occluded(from, target, None, &blocks), expected);
            }
        }
    }
}

#[test]
fn a_surface_at_the_target_does_not_hide_it() {
    let mut random = Random(3);
    for scale in SCALES_MM {
        let floor = grid(DVec3::splat(-0.3 * scale), [DVec3::X * scale, DVec3::Y * scale], 9);
        let positions = floor.positions.clone();
        for bvh in on_each_kernel(&[floor]) {
            for _ in 0..2000 {
                let [a, b] = [(); 2].map(|()| positions[random.below(positions.len())]);
                // Not on the border, beside which a longer ray may pass.
                let center = scale * DVec3::new(0.2, 0.2, -0.3);
                let target = center + 0.99 * (a + (b - a) * random.unit() - center);
                let mut from = random.in_cube() * scale;
                from.z = target.z + scale * (0.01 + random.unit());
                assert!(!bvh.is_occluded(from, target, None, &[true]));
                assert!(bvh.is_occluded(from, target + (target - from) * 1e-9, None, &[true]));
            }
        }
    }
}

#[test]
fn nothing_and_degenerate_triangles_are_never_met() {
    let mut random = Random(5);
    let line = |a: DVec3, d: DVec3| mesh(vec![a, a + d, a + 2.0 * d], vec![[0, 1, 2], [0, 0, 1]]);
    let slanted = line(DVec3::splat(0.1), DVec3::new(0.1, 0.3, 0.7));
    let broken = mesh(vec![DVec3::NAN, DVec3::X, DVec3::Y], vec![[0, 1, 2]]);
    let far = mesh(vec![DVec3::splat(1e300), DVec3::X, DVec3::Y], vec![[0, 1, 2]]);
    let empty = mesh(vec![], vec![]);
    let scenes = [vec![], vec![empty], vec![slanted.clone()], vec![broken, slanted, far]];
    for bvh in scenes.iter().flat_map(|meshes| on_each_kernel(meshes)) {
        assert_eq!(bvh.bounds(), None);
        for _ in 0..200 {
            let target = DVec3::splat(0.1) + DVec3::new(0.1, 0.3, 0.7) * (2.0 * random.unit());
            let ray = aimed(3.0 * random.in_cube(), target);
            assert_eq!(bvh.closest_hit(&ray, None), None);
            assert!(!bvh.is_occluded(ray.origin, target + ray.direction, None, &[true; 3]));
        }
    }
}

#[test]
fn rays_that_are_not_finite_meet_nothing() {
    let floor = grid(DVec3::ZERO, [DVec3::X, DVec3::Y], 8);
    for bvh in on_each_kernel(&[floor]) {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for axis in 0..3 {
                let mut ray = Ray { origin: DVec3::splat(0.5), direction: DVec3::NEG_Z };
                ray.origin[axis] = bad;
                assert_eq!(bvh.closest_hit(&ray, None), None);
                assert!(!bvh.is_occluded(ray.origin, DVec3::ZERO, None, &[true]));
                let mut ray = Ray { origin: DVec3::splat(0.5), direction: DVec3::NEG_Z };
                ray.direction[axis] = bad;
                assert_eq!(bvh.closest_hit(&ray, None), None);
            }
        }
    }
}

#[test]
fn the_tree_is_the_same_on_any_number_of_threads() {
    let mut random = Random(11);
    let ball = Arc::new(ball(DVec3::ZERO, 1.0, 60, &mut random));
    let floor = grid(DVec3::splat(-1.0), [2.0 * DVec3::X, 2.0 * DVec3::Y], 50);
    let build = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| Bvh::build(&[ball.clone(), floor.clone()]).tree)
    };
    assert!(build(1) == build(3));
}

#[test]
fn many_equal_triangles_make_a_shallow_tree() {
    let floor = grid(DVec3::ZERO, [DVec3::X, DVec3::Y], 1);
    let bvh = Bvh::build(&vec![floor; 20_000]);
    let ray = Ray { origin: DVec3::new(0.75, 0.25, 1.0), direction: DVec3::NEG_Z };
    assert_eq!(bvh.closest_hit(&ray, None).map(|hit| hit.triangle), Some(TriangleId(0)));
}
