use proptest::prelude::*;

use super::super::Role;
use super::exact::any_mesh;
use super::*;

/// A hit of a random ray on the scene.
fn any_hit(random: &mut Random, bvh: &Bvh, size: f64) -> Option<Hit> {
    (0..40).find_map(|_| {
        let origin = random.in_cube() * (1.2 * size);
        bvh.closest_hit(&Ray { origin, direction: random.direction() }, None)
    })
}

/// A box of targets: anywhere, of any size, some flat, some about the hit.
fn any_box(random: &mut Random, near: DVec3, size: f64) -> (DVec3, DVec3) {
    let middle = if random.below(4) == 0 { near } else { random.in_cube() * size };
    let mut half = random.in_cube().abs() * (size * [0.0, 1e-6, 0.02, 0.5][random.below(4)]);
    if random.below(4) == 0 {
        half[random.below(3)] = 0.0;
    }
    (middle - half, middle + half)
}

fn target_in(random: &mut Random, (low, high): (DVec3, DVec3)) -> DVec3 {
    let at = DVec3::new(random.unit(), random.unit(), random.unit());
    // Corners and faces too.
    let at = if random.below(3) == 0 { at.round() } else { at };
    (low + (high - low) * at).clamp(low, high)
}

/// What a shaft's triangles say of segments, against all triangles; how many hits were compared.
fn compare(random: &mut Random, meshes: &[Arc<Mesh>], size: f64) -> usize {
    let all = on_each_kernel(meshes);
    let blocks: Vec<bool> = meshes.iter().map(|_| random.below(3) > 0).collect();
    let mut compared = 0;
    for _ in 0..12 {
        let Some(hit) = any_hit(random, &all[0], size) else { continue };
        let (from, leaving) = (all[0].departure(&hit), hit.triangle);
        let place = any_box(random, from.point, size);
        for bvh in &all {
            let role = |object: usize| if blocks[object] { Role::Blocks } else { Role::None };
            let Some(shaft) = bvh.shaft(&from, leaving, place, role) else { continue };
            let hides_all = shaft.hides_all();
            let ball = (target_in(random, place), random.unit() * place.0.distance(place.1));
            let hides_ball = shaft.hides_ball(ball.0, ball.1);
            for _ in 0..12 {
                let target = target_in(random, place);
                assert!(shaft.holds(target));
                let start = from.toward(target - from.point);
                let plain = bvh.is_occluded(start, target, Some(leaving), &blocks);
                assert_eq!(bvh.is_occluded_in(&shaft, (start, target), leaving), plain);
                assert!(!(plain && shaft.is_free()));
                assert!(plain || !hides_all);
                let is_in_ball = target.distance(ball.0) <= ball.1;
                assert!(!is_in_ball || hides_ball.is_none_or(|hides| hides == plain));
                let way = target - from.point;
                if way.length() > 0.0 {
                    let ray = Ray { origin: start, direction: way / way.length() };
                    let end_mm = way.length() - bvh.place_mm();
                    let mut plain = bvh.hits_up_to(&ray, Some(leaving), end_mm);
                    plain.retain(|hit| blocks[bvh.locate(hit.triangle).0]);
                    let quick = bvh.hits_among(&ray, Some(leaving), end_mm, Some(&shaft));
                    let blocked = |hit: &Hit| blocks[bvh.locate(hit.triangle).0];
                    assert_eq!(quick.into_iter().filter(blocked).collect::<Vec<_>>(), plain);
                }
                compared += 1;
            }
        }
    }
    compared
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]
    #[test]
    fn a_shaft_leaves_out_only_what_no_segment_meets(seed: u64, exponent in -3.0..6.0f64) {
        let mut random = Random(seed);
        let size = 10f64.powf(exponent);
        let meshes: Vec<_> =
            (0..1 + random.below(3)).map(|_| any_mesh(&mut random, DVec3::ZERO, size)).collect();
        compare(&mut random, &meshes, size);
    }
}

/// Hits next to edges of smooth meshes, where neighbors almost lie in the hit's plane.
#[test]
fn neighbors_are_left_out_and_nothing_else() {
    let mut random = Random(21);
    for scale in SCALES_MM {
        let inside = ball(DVec3::ZERO, scale, 40, &mut random);
        let floor = grid(DVec3::splat(-scale), [DVec3::X, DVec3::Y].map(|x| 2.0 * x * scale), 30);
        let lamp = [Arc::new(inside), floor];
        assert!((0..20).map(|_| compare(&mut random, &lamp, scale)).sum::<usize>() > 5000);
    }
}

#[test]
fn nothing_stands_between_a_hollow_balls_wall_and_its_middle() {
    let mut random = Random(22);
    let mesh = ball(DVec3::ZERO, 10.0, 60, &mut random);
    let bvh = Bvh::build(&[Arc::new(mesh)]);
    let place = (DVec3::splat(-0.3), DVec3::splat(0.3));
    let mut free = 0;
    for _ in 0..500 {
        let ray = Ray { origin: DVec3::ZERO, direction: random.direction() };
        let hit = bvh.closest_hit(&ray, None).expect("the ball is closed");
        let shaft = bvh.shaft(&bvh.departure(&hit), hit.triangle, place, |_| Role::Blocks);
        free += usize::from(shaft.expect("few nodes").is_free());
    }
    // The wall's bumps stand out by 2 % of its radius, steep enough to meet few of the segments.
    assert!(free >= 490, "{free} of 500");
}

#[test]
fn a_shaft_through_a_crowd_is_given_up() {
    let mut random = Random(23);
    let crowd = grid(DVec3::new(-1.0, -1.0, 1.0), [DVec3::X, DVec3::Y].map(|x| 2.0 * x), 200);
    let floor = grid(DVec3::new(-1.0, -1.0, 0.0), [DVec3::X, DVec3::Y].map(|x| 2.0 * x), 1);
    let bvh = Bvh::build(&[crowd, floor]);
    let from = DVec3::new(random.unit() - 0.5, random.unit() - 0.5, 0.5);
    let hit = bvh.closest_hit(&Ray { origin: from, direction: DVec3::NEG_Z }, None);
    let hit = hit.expect("above the floor");
    let place = (DVec3::new(-0.9, -0.9, 2.0), DVec3::new(0.9, 0.9, 2.1));
    assert!(bvh.shaft(&bvh.departure(&hit), hit.triangle, place, |_| Role::Blocks).is_none());
}

/// The share of hits on a bumpy ball, from inside, that know of a box outside that it is hidden.
#[test]
fn a_closed_wall_hides_a_box_at_once() {
    let mut random = Random(24);
    let meshes = [Arc::new(ball(DVec3::ZERO, 10.0, 40, &mut random))];
    let all = on_each_kernel(&meshes);
    let (mut known, mut known_ball, mut asked) = (0, 0, 0);
    for _ in 0..500 {
        let ray = Ray { origin: DVec3::ZERO, direction: random.direction() };
        let hit = all[0].closest_hit(&ray, None).expect("the ball is closed");
        let from = all[0].departure(&hit);
        let middle = -30.0 * ray.direction + 5.0 * random.in_cube();
        let place = (middle - DVec3::splat(0.3), middle + DVec3::splat(0.3));
        for bvh in &all {
            let shaft = bvh.shaft(&from, hit.triangle, place, |_| Role::Blocks);
            let Some(shaft) = shaft else { continue };
            asked += 1;
            known += u32::from(shaft.hides_all());
            known_ball += u32::from(shaft.hides_ball(middle, 0.1) == Some(true));
            let target = target_in(&mut random, place);
            let start = from.toward(target - from.point);
            assert!(bvh.is_occluded(start, target, Some(hit.triangle), &[true]));
        }
    }
    // The others have a sliver of the bumps in their way.
    assert!(asked > 900 && 100 * known > 95 * asked, "{known} of {asked}");
    assert!(100 * known_ball > 95 * asked, "{known_ball} of {asked}");
}

/// Walls of small triangles between a floor and a box.
#[test]
fn a_wall_with_a_hole_does_not_hide_all() {
    let axes = [DVec3::X, DVec3::Y];
    let floor = || grid(DVec3::new(-5.0, -5.0, 0.0), axes.map(|x| 10.0 * x), 1);
    let wall = |height: f64| grid(DVec3::new(-5.0, -5.0, height), axes.map(|x| 10.0 * x), 10);
    let holed = |height: f64| {
        let whole = wall(height);
        let mut mesh = Mesh::clone(&whole);
        let middle = mesh.positions.len() as u32 / 2;
        mesh.triangles.retain(|triangle| !triangle.contains(&middle));
        assert!(mesh.triangles.len() < whole.triangles.len());
        Arc::new(mesh)
    };
    let narrow = grid(DVec3::new(-5.0, -5.0, 1.0), [10.0 * DVec3::X, 5.05 * DVec3::Y], 10);
    let shaft = |meshes: &[Arc<Mesh>], height: f64| {
        let bvh = Bvh::build(&[&[floor()], meshes].concat());
        let ray = Ray { origin: DVec3::new(0.01, 0.02, 0.5), direction: DVec3::NEG_Z };
        let hit = bvh.closest_hit(&ray, None).expect("the floor");
        let place = (DVec3::new(-0.4, -0.3, height), DVec3::new(0.3, 0.4, height + 0.1));
        let shaft = bvh.shaft(&bvh.departure(&hit), hit.triangle, place, |_| Role::Blocks);
        shaft.expect("few triangles")
    };
    let hides = |meshes: &[Arc<Mesh>], height: f64| shaft(meshes, height).hides_all();
    assert!(hides(&[wall(1.0)], 4.0));
    assert!(!hides(&[holed(1.0)], 4.0), "a hole");
    assert!(!hides(std::slice::from_ref(&narrow), 4.0), "an edge");
    // The wall ends at y = 0.05, z = 1; from the hit at y = 0.02 its shadow does at 0.14 where z = 4.05.
    let past_the_edge = shaft(&[narrow], 4.0);
    let at = |y: f64| past_the_edge.hides_ball(DVec3::new(0.0, y, 4.05), 0.02);
    assert_eq!([0.0, 0.14, 0.35].map(at), [Some(true), None, Some(false)]);
    assert!(hides(&[holed(1.0), wall(1.5)], 4.0), "a wall behind a hole");
    assert!(!hides(&[wall(1.0)], 0.5), "before the wall");
    assert!(!hides(&[wall(1.0)], 0.95), "through the wall");
}
