//! Random stacks of touching, nested and overlapping boxes against an oracle that sorts their faces.

use glam::{DQuat, DVec3};
use lampyris::geometry::Mesh;
use lampyris::material::Material;
use lampyris::scene::{Background, Scene};
use lampyris::spectrum::Spectrum;
use lampyris::view::View;

use crate::stage::*;

/// splitmix64.
struct Random(u64);

impl Random {
    /// 0 to below `count`.
    fn below(&mut self, count: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % count as u64) as usize
    }

    fn pick<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.below(of.len())]
    }

    fn shuffle<T>(&mut self, items: &mut [T]) {
        for last in (1..items.len()).rev() {
            items.swap(last, self.below(last + 1));
        }
    }
}

/// A box far wider than a ray goes aside.
#[derive(Debug, Clone, Copy)]
struct Body {
    low: f64,
    high: f64,
    half_width: f64,
    aside: DVec3,
    ior: f64,
    /// Internal, of 10 mm.
    transmittance: f64,
    priority: i32,
}

#[derive(Debug, Clone)]
struct Stack {
    bodies: Vec<Body>,
    /// Height of an opaque plate, which mirrors 0.9.
    plate: Option<f64>,
    angle_deg: f64,
}

impl Stack {
    /// Faces on a grid of whole mm, so that many touch.
    fn random(random: &mut Random) -> Stack {
        let body = |random: &mut Random| {
            let low = -1.0 - random.below(12) as f64;
            Body {
                low,
                high: (low + 1.0 + random.below(6) as f64).min(0.0),
                half_width: 500.0 + random.below(500) as f64 + random.below(1000) as f64 * 1e-3,
                // Rays through a face's middle meet the edge between its two triangles.
                aside: DVec3::new(random.pick(&[0.0, 3.7, -11.3]), random.pick(&[0.0, 1.9]), 0.0),
                ior: random.pick(&[1.0, 1.33, 1.49, 1.49, 1.6, 2.4]),
                transmittance: random.pick(&[0.3, 0.7, 1.0]),
                priority: random.pick(&[0, 0, 0, 1, -1]),
            }
        };
        Stack {
            bodies: (0..1 + random.below(6)).map(|_| body(random)).collect(),
            plate: (random.below(3) == 0).then(|| -(random.below(13) as f64)),
            angle_deg: random.pick(&[0.0, 7.3, 40.0, 61.7, 80.1]),
        }
    }

    /// What is left of a ray from above: every place settled at once, n sin θ the same throughout.
    fn left(&self) -> f64 {
        let mut heights: Vec<f64> =
            self.bodies.iter().flat_map(|body| [body.low, body.high]).collect();
        heights.sort_by(f64::total_cmp);
        heights.dedup();
        let mut inside = Vec::new();
        let bottom = self.plate.unwrap_or(f64::NEG_INFINITY);
        heights.retain(|height| *height > bottom);
        let down = heights.iter().rev().copied();
        let mut left =
            self.passed(&mut inside, down.chain(self.plate), |body| [body.high, body.low]);
        if let Some(plate) = self.plate {
            left *= 0.9;
            let up = std::iter::once(plate).chain(heights.iter().copied());
            left *= self.passed(&mut inside, up, |body| [body.low, body.high]);
        }
        left
    }

    /// On the way from the first height to the last; the plate's changes nothing.
    fn passed(
        &self,
        inside: &mut Vec<usize>,
        heights: impl Iterator<Item = f64>,
        faces: impl Fn(&Body) -> [f64; 2],
    ) -> f64 {
        let sin = self.angle_deg.to_radians().sin();
        let (mut left, mut before): (f64, Option<f64>) = (1.0, None);
        for height in heights {
            let medium = inside.iter().max_by_key(|at| self.bodies[**at].priority);
            if let (Some(at), Some(before)) = (medium, before) {
                let Body { ior, transmittance, .. } = self.bodies[*at];
                let cos = (1.0 - (sin / ior).powi(2)).sqrt();
                left *= transmittance.powf((height - before).abs() / cos / 10.0);
            }
            before = Some(height);
            if Some(height) == self.plate {
                continue;
            }
            inside.retain(|at| faces(&self.bodies[*at])[1] != height);
            let entered =
                |at: &usize| faces(&self.bodies[*at])[0] == height && !inside.contains(at);
            let mut entered: Vec<usize> = (0..self.bodies.len()).filter(entered).collect();
            let volume = |at: &usize| {
                let Body { low, high, half_width, .. } = self.bodies[*at];
                (high - low) * half_width * half_width
            };
            entered.sort_by(|a, b| volume(b).total_cmp(&volume(a)));
            inside.extend(entered);
        }
        left
    }

    /// In a uniform surround of 1; objects and triangles in any order, the whole turned.
    fn scene(&self, random: &mut Random, turn: DQuat) -> Scene {
        let glass = |body: &Body| Material {
            transmittance: Some(Spectrum::constant(body.transmittance)),
            thickness_mm: Some(10.0),
            ior: Some(Spectrum::constant(body.ior)),
            priority: body.priority,
            k_tg: 1.0,
            ..material()
        };
        let bodies = self.bodies.iter().map(|body| {
            let half = DVec3::new(body.half_width, body.half_width, 0.0);
            let (low, high) = (DVec3::Z * body.low, DVec3::Z * body.high);
            ((low - half + body.aside, high + half + body.aside), glass(body))
        });
        let mirror = Material { k_rg: 1.0, reflectance: Spectrum::constant(0.9), ..material() };
        let half = DVec3::new(900.0, 900.0, 0.0);
        let plate = self
            .plate
            .map(|height| (((height - 0.25) * DVec3::Z - half, height * DVec3::Z + half), mirror));
        let mut objects: Vec<(Mesh, Material)> = bodies
            .chain(plate)
            .map(|((low, high), material)| (turned_box([low, high], turn, random), material))
            .collect();
        random.shuffle(&mut objects);
        Scene { background: Background::Even(Spectrum::constant(1.0)), ..scene(objects, vec![]) }
    }
}

/// Fronts outward; triangles in any order, each from any corner.
fn turned_box([low, high]: [DVec3; 2], turn: DQuat, random: &mut Random) -> Mesh {
    let corner = |i: usize| {
        let pick = |bit: usize, axis: usize| if i >> bit & 1 == 1 { high[axis] } else { low[axis] };
        turn * DVec3::new(pick(0, 0), pick(1, 1), pick(2, 2))
    };
    let faces =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut triangles: Vec<[u32; 3]> =
        faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    random.shuffle(&mut triangles);
    triangles.iter_mut().for_each(|triangle| triangle.rotate_left(random.below(3)));
    Mesh::flat("box", (0..8).map(corner).collect(), triangles).expect("a good mesh")
}

fn seen(scene: Scene, view: &View) -> f64 {
    f64::from(shoot(scene, view, &exact(64)).pixel(0, 0)[40])
}

#[test]
fn a_thousand_stacks_are_as_if_their_faces_were_sorted() {
    let mut random = Random(13);
    for round in 0..1000 {
        let stack = Stack::random(&mut random);
        let expected = stack.left();
        let view = pixel_view(stack.angle_deg, 300.0);
        let plain = seen(stack.scene(&mut random, DQuat::IDENTITY), &view);
        // f32 images; the scene's own rounding at 80° over 1000 mm is far below.
        let what = |how: &str| format!("{how}, stack {round}: {stack:?}");
        assert_close(plain, expected, 1e-6, &what("as it is"));
        let turned = View { azimuth_deg: 37.3, elevation_deg: 23.7, ..view };
        let from = |view: &View| {
            let (sin, cos) = view.azimuth_deg.to_radians().sin_cos();
            let (up, along) = view.elevation_deg.to_radians().sin_cos();
            DVec3::new(sin * along, up, cos * along)
        };
        let turn = DQuat::from_axis_angle(from(&turned), 0.3)
            * DQuat::from_rotation_arc(from(&view), from(&turned));
        assert_close(
            seen(stack.scene(&mut random, turn), &turned),
            expected,
            1e-6,
            &what("turned"),
        );
    }
}
