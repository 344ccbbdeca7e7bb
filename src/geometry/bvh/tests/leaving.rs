use super::watertight::cube;
use super::*;

/// Directions on the side of `normal`, half of them within 1° … 0.001° of the surface.
fn leaving_direction(normal: DVec3, random: &mut Random) -> DVec3 {
    let aside = random.direction().cross(normal).normalize();
    let elevation = if random.below(2) == 0 {
        random.unit().max(1e-4) * std::f64::consts::FRAC_PI_2
    } else {
        (0.001 * 1000f64.powf(random.unit())).to_radians()
    };
    (aside * elevation.cos() + normal * elevation.sin()).normalize()
}

/// A skewed frame, so that planes are not exact in f64.
fn tilted() -> [DVec3; 3] {
    let x = DVec3::new(0.8, 0.36, -0.48).normalize();
    let y = DVec3::Z.cross(x).normalize();
    [x, y, x.cross(y)]
}

#[test]
fn rays_from_a_flat_grid_never_meet_it() {
    let mut random = Random(21);
    for (scale, center) in scenes() {
        for [x, y, z] in [[DVec3::X, DVec3::Y, DVec3::Z], tilted()] {
            let floor = grid(center, [x * scale, y * scale], 40);
            for bvh in on_each_kernel(&[floor]) {
                for _ in 0..20_000 {
                    // Grid lines and corners too.
                    let mut lattice = || {
                        let t = 0.01 + 0.98 * random.unit();
                        if random.below(3) == 0 { (t * 40.0).round() / 40.0 } else { t }
                    };
                    let target = center + (x * lattice() + y * lattice()) * scale;
                    let up = if random.below(2) == 0 { z } else { -z };
                    let eye = target + leaving_direction(up, &mut random) * (2.0 * scale);
                    let Some(hit) = bvh.closest_hit(&aimed(eye, target), None) else { continue };
                    let departure = bvh.departure(&hit);
                    let direction = leaving_direction(up, &mut random);
                    for direction in [direction, -direction] {
                        let ray = Ray { origin: departure.toward(direction), direction };
                        assert_eq!(bvh.closest_hit(&ray, Some(hit.triangle)), None, "{scale}");
                    }
                }
            }
        }
    }
}

/// Sizes and places: at the origin, and at 20 m (of small scenes) or 3 sizes away.
fn scenes() -> Vec<(f64, DVec3)> {
    let at = |scale: f64| {
        [DVec3::ZERO, DVec3::new(1.0, -3.0, 2.0) * scale, DVec3::new(100.0, 20.0, -70.0) * scale]
            .map(|center| (scale, center))
    };
    SCALES_MM.into_iter().flat_map(at).collect()
}

#[test]
fn rays_between_close_plates_meet_the_other_plate() {
    let mut random = Random(22);
    for scale in SCALES_MM {
        for [x, y, z] in [[DVec3::X, DVec3::Y, DVec3::Z], tilted()] {
            let gap = z * (1e-6 * scale);
            let sides = [x * scale, y * scale];
            let plates = [grid(DVec3::ZERO, sides, 20), grid(gap, sides, 23)];
            for bvh in on_each_kernel(&plates) {
                for _ in 0..20_000 {
                    let target = (x * random.unit() + y * random.unit()) * (0.9 * scale) + 0.05;
                    let eye = target - z * scale * (0.1 + random.unit());
                    let Some(below) = bvh.closest_hit(&aimed(eye, target), None) else { continue };
                    assert_eq!(bvh.locate(below.triangle).0, 0);
                    let departure = bvh.departure(&below);
                    let tilt = random.direction() * 0.9;
                    let direction = (z + tilt - z * tilt.dot(z)).normalize();
                    let up = Ray { origin: departure.toward(direction), direction };
                    let Some(above) = bvh.closest_hit(&up, Some(below.triangle)) else {
                        // Only where the plates end.
                        let out = departure.point + direction * (1e-5 * scale);
                        let within = [x, y].map(|a| out.dot(a) / scale);
                        assert!(within.iter().any(|t| !(1e-4..1.0 - 1e-4).contains(t)));
                        continue;
                    };
                    assert_eq!(bvh.locate(above.triangle).0, 1);
                    let expected = 1e-6 * scale / direction.dot(z);
                    // The start is 64 · 2⁻⁵³ · 3 scales off the plate, 2·10⁻⁸ of the gap.
                    assert!((above.distance_mm / expected - 1.0).abs() < 1e-7);
                }
            }
        }
    }
}

/// Mirrors a ray through a closed room; it must meet a wall every time.
fn bounce(bvh: &Bvh, mut ray: Ray, bounces: usize, inside: impl Fn(DVec3) -> bool) {
    let mut leaving = None;
    for _ in 0..bounces {
        let hit = bvh.closest_hit(&ray, leaving).expect("the room is closed");
        let departure = bvh.departure(&hit);
        assert!(inside(departure.point), "{ray:?} {hit:?}");
        let n = departure.n_geom;
        let direction = (ray.direction - 2.0 * ray.direction.dot(n) * n).normalize();
        ray = Ray { origin: departure.toward(direction), direction };
        leaving = Some(hit.triangle);
    }
}

#[test]
fn mirrored_rays_stay_in_a_cube_even_from_its_corners() {
    let mut random = Random(23);
    for scale in SCALES_MM {
        for bvh in on_each_kernel(&cube(scale, 3)) {
            let limit = 0.5 * scale * (1.0 + 1e-12);
            let inside = |p: DVec3| p.abs().max_element() <= limit;
            for i in 0..6000 {
                // Into corners and edges, and 10⁻⁶ … 10⁻¹⁵ beside them.
                let signs = random.in_cube().signum();
                let beside = random.in_cube() * 10f64.powi(-6 - (i % 10));
                let mut corner = 0.5 * (signs + beside * f64::from(i % 3));
                if i % 2 == 0 {
                    corner[random.below(3)] = 0.4 * random.unit();
                }
                let ray = aimed(0.4 * scale * random.in_cube(), corner * scale);
                bounce(&bvh, ray, 12, inside);
            }
        }
    }
}

#[test]
fn rays_leave_a_ball_at_grazing_angles_and_meet_it_from_inside() {
    let mut random = Random(24);
    for scale in SCALES_MM {
        let ball = Arc::new(ball(DVec3::ZERO, scale, 40, &mut random));
        for bvh in on_each_kernel(&[ball]) {
            for _ in 0..20_000 {
                let from = 0.3 * scale * random.in_cube();
                let ray = Ray { origin: from, direction: random.direction() };
                let hit = bvh.closest_hit(&ray, None).expect("inside");
                let departure = bvh.departure(&hit);
                let inward = if departure.n_geom.dot(ray.direction) > 0.0 {
                    -departure.n_geom
                } else {
                    departure.n_geom
                };
                let direction = leaving_direction(inward, &mut random);
                let ray = Ray { origin: departure.toward(direction), direction };
                assert!(bvh.closest_hit(&ray, Some(hit.triangle)).is_some(), "{ray:?}");
            }
        }
    }
}

#[test]
fn departures_are_near_their_points_and_on_the_right_side() {
    let mut random = Random(25);
    for _ in 0..5000 {
        let scale = 10f64.powf(-3.0 + 9.0 * random.unit());
        let corners = [(); 3].map(|()| random.in_cube() * scale);
        let bvh = Bvh::build(&[mesh(corners.to_vec(), vec![[0, 1, 2]])]);
        let center = (corners[0] + corners[1] + corners[2]) / 3.0;
        let ray = aimed(center + random.direction() * scale, center);
        let Some(hit) = bvh.closest_hit(&ray, None) else { continue };
        let departure = bvh.departure(&hit);
        let back = departure.toward(-ray.direction) - departure.point;
        let on = departure.toward(ray.direction) - departure.point;
        // 64 · 2⁻⁵³ of the point and the scene's diameter (at most 1 + 2√3 scales here).
        assert!(back.length() < 64.0 * 1.2e-16 * 5.5 * scale && back.length() > 0.0);
        let facing = ray.direction.dot(departure.n_geom).signum();
        assert!(back.dot(departure.n_geom) * facing < 0.0);
        assert!(on.dot(departure.n_geom) * facing > 0.0);
    }
}
