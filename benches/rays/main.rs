//! Rays a second through a lamp of 35 thousand, 350 thousand and 3.5 million triangles.
//!
//! `cargo bench --bench rays` (`-- 35000 350000` for some sizes only). Rates are of one thread, from
//! the fastest of several passes over each block of rays, so that what else the machine does
//! disturbs them little; a pass goes through all rays, so that no block finds its own way in the
//! caches. Ratios within one run say more than rates. Where Embree is installed it runs in turns
//! with ours, on the same triangles and rays in f32.

mod embree;

use std::hint::black_box;
use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

use embree::{Embree, EmbreeRay};
use lampyris::geometry::mesh::Shading;
use lampyris::geometry::{Bvh, DVec3, Hit, Mesh, Ray, TriangleId};
use lampyris::simd::Simd;

const SIZES: [usize; 3] = [35_000, 350_000, 3_500_000];
const RAYS: usize = 1 << 17;
const BLOCK: usize = 1 << 11;
const PASSES: usize = 9;
/// Where Embree's mirrored rays begin: it has no name for the triangle that they leave.
const NEAR_MM: f32 = 1e-2;

fn main() {
    // Cargo itself passes "--bench".
    let asked: Vec<usize> = std::env::args().filter_map(|a| a.parse().ok()).collect();
    let sizes = if asked.is_empty() { SIZES.to_vec() } else { asked };
    let mut first: Option<Vec<(&str, f64)>> = None;
    for size in sizes {
        let costs = measure(size);
        match &first {
            None => first = Some(costs),
            Some(small) => {
                for ((name, cost), (_, least)) in costs.iter().zip(small) {
                    println!("  {name:8} {:.2} times the cost at the first size", cost / least);
                }
            }
        }
    }
}

/// What finds the closest hits of a block of rays, and the seconds that it took at best.
struct Contender<'a> {
    name: String,
    trace: Box<dyn Fn(Range<usize>) -> usize + 'a>,
    fastest: Vec<f64>,
    hits: usize,
}

impl<'a> Contender<'a> {
    fn new(name: impl Into<String>, trace: impl Fn(Range<usize>) -> usize + 'a) -> Self {
        Contender { name: name.into(), trace: Box::new(trace), fastest: Vec::new(), hits: 0 }
    }

    fn pass(&mut self, rays: usize) {
        let blocks = rays.div_ceil(BLOCK);
        self.fastest.resize(blocks, f64::INFINITY);
        self.hits = 0;
        for (block, fastest) in self.fastest.iter_mut().enumerate() {
            let first = block * BLOCK;
            let start = Instant::now();
            self.hits += (self.trace)(first..rays.min(first + BLOCK));
            *fastest = fastest.min(start.elapsed().as_secs_f64());
        }
    }

    fn ns_a_ray(&self, rays: usize) -> f64 {
        1e9 * self.fastest.iter().sum::<f64>() / rays as f64
    }
}

/// Prints all figures of one size; returns ns a ray by set.
fn measure(size: usize) -> Vec<(&'static str, f64)> {
    let meshes = lamp(size);
    let triangles: usize = meshes.iter().map(|mesh| mesh.triangles.len()).sum();
    let (seconds, bvh) = fastest(3, || Bvh::build(&meshes));
    let mesh_bytes: usize = meshes
        .iter()
        .map(|mesh| size_of_val(&mesh.positions[..]) + size_of_val(&mesh.triangles[..]))
        .sum();
    println!(
        "{triangles} triangles: build {:.0} ms, {:.1} bytes a triangle in the tree, {:.1} with the \
         mesh",
        1e3 * seconds,
        bvh.memory_bytes() as f64 / triangles as f64,
        (bvh.memory_bytes() + mesh_bytes) as f64 / triangles as f64
    );
    let primary = primary_rays();
    let mirrored = mirrored_rays(&bvh, &primary);
    let random = random_rays(&bvh);
    let embree = Embree::build(&meshes);
    [("primary", primary), ("mirrored", mirrored), ("random", random)]
        .map(|(name, rays)| (name, measure_set(&bvh, embree.as_ref(), name, &rays)))
        .to_vec()
}

/// A ray and the triangle that it leaves.
type Start = (Ray, Option<TriangleId>);

/// Prints the rates of each kernel and of Embree; returns ns a ray of the fastest kernel.
fn measure_set(bvh: &Bvh, embree: Option<&Embree>, name: &str, rays: &[Start]) -> f64 {
    let embree_rays: Vec<_> = rays.iter().map(embree_ray).collect();
    let mut contenders: Vec<_> = Simd::available()
        .into_iter()
        .filter(|simd| *simd <= Simd::Avx2) // no kernel is wider
        .map(|simd| {
            let bvh = bvh.clone().with_simd(simd);
            Contender::new(format!("{simd:?}"), move |block| trace(&bvh, &rays[block]))
        })
        .collect();
    let ours = contenders.len() - 1;
    contenders.extend(embree.map(|embree| {
        let embree_rays = &embree_rays;
        let hits = move |ray: &&EmbreeRay| embree.hits(black_box(ray));
        Contender::new("Embree", move |block| embree_rays[block].iter().filter(hits).count())
    }));
    for _ in 0..PASSES {
        contenders.iter_mut().for_each(|contender| contender.pass(rays.len()));
    }
    print!("  {name:8}");
    let cost = contenders[ours].ns_a_ray(rays.len());
    for contender in &contenders {
        let other = contender.ns_a_ray(rays.len());
        print!("  {} {:.2} Mrays/s (×{:.2})", contender.name, 1e3 / other, other / cost);
        // Rays in f32 may pass the rim of what rays in f64 meet.
        if contender.hits.abs_diff(contenders[ours].hits) > rays.len() / 1000 {
            print!(" with {} instead of {} hits", contender.hits, contenders[ours].hits);
        }
    }
    let (one, two) = (threads(bvh, rays, 1), threads(bvh, rays, 2));
    println!("  two threads ×{:.2}", one / two);
    cost
}

fn embree_ray((ray, leaving): &Start) -> EmbreeRay {
    EmbreeRay::new(ray, if leaving.is_some() { NEAR_MM } else { 0.0 })
}

fn trace(bvh: &Bvh, rays: &[Start]) -> usize {
    rays.iter().filter(|(ray, leaving)| bvh.closest_hit(black_box(ray), *leaving).is_some()).count()
}

/// Seconds for all rays, dealt out in blocks to that many threads.
fn threads(bvh: &Bvh, rays: &[Start], count: usize) -> f64 {
    use rayon::prelude::*;
    let Ok(pool) = rayon::ThreadPoolBuilder::new().num_threads(count).build() else {
        return f64::NAN;
    };
    let all = || pool.install(|| rays.par_chunks(BLOCK).map(|block| trace(bvh, block)).sum());
    fastest::<usize>(PASSES, all).0
}

fn fastest<T>(passes: usize, mut work: impl FnMut() -> T) -> (f64, T) {
    let mut best = (f64::INFINITY, None);
    for _ in 0..passes {
        let start = Instant::now();
        let result = work();
        best = (best.0.min(start.elapsed().as_secs_f64()), Some(result));
    }
    (best.0, best.1.expect("at least one pass"))
}

/// Reflector (two thirds of the triangles), lens and a rod for the filament, mm.
fn lamp(triangles: usize) -> Vec<Arc<Mesh>> {
    let reflector = sheet([200.0, 120.0], triangles * 2 / 3, |x, y| {
        (x * x + y * y) / 120.0 + pillow(x, y, 10.0)
    });
    let back = sheet([204.0, 124.0], triangles / 6, |x, y| 120.0 - pillow(x, y, 4.0));
    let front = sheet([204.0, 124.0], triangles / 6, |x, y| 127.8 - (x * x + y * y) / 3000.0);
    vec![reflector, back, front, rod()]
}

/// Height over a square cell of that width, 0 … 0.3.
fn pillow(x: f64, y: f64, width: f64) -> f64 {
    let across = |t: f64| 2.0 * (t / width).rem_euclid(1.0) - 1.0;
    0.15 * (across(x).powi(2) + across(y).powi(2))
}

/// A rectangle of squares, lifted to `height`.
fn sheet(sides: [f64; 2], triangles: usize, height: impl Fn(f64, f64) -> f64) -> Arc<Mesh> {
    let rows = (triangles as f64 / 2.0 * sides[1] / sides[0]).sqrt().round().max(2.0) as u32;
    let columns = (f64::from(rows) * sides[0] / sides[1]).round() as u32;
    let at = |i: u32, n: u32, side: f64| (f64::from(i) / f64::from(n) - 0.5) * side;
    let mut positions = Vec::new();
    for j in 0..=rows {
        for i in 0..=columns {
            let (x, y) = (at(i, columns, sides[0]), at(j, rows, sides[1]));
            positions.push(DVec3::new(x, y, height(x, y)));
        }
    }
    let mut triangles = Vec::new();
    for j in 0..rows {
        for i in 0..columns {
            let a = j * (columns + 1) + i;
            let (b, c, d) = (a + 1, a + columns + 2, a + columns + 1);
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    Arc::new(Mesh { positions, triangles, shading: Shading::Flat })
}

/// 5.5 mm long and 1 mm thick, in the focus.
fn rod() -> Arc<Mesh> {
    const SIDES: u32 = 32;
    let mut positions = Vec::new();
    for i in 0..SIDES {
        let (s, c) = (std::f64::consts::TAU * f64::from(i) / f64::from(SIDES)).sin_cos();
        positions.push(DVec3::new(-2.75, 0.5 * c, 30.0 + 0.5 * s));
        positions.push(DVec3::new(2.75, 0.5 * c, 30.0 + 0.5 * s));
    }
    let triangles = (0..SIDES)
        .flat_map(|i| {
            let (a, b) = (2 * i, 2 * ((i + 1) % SIDES));
            [[a, a + 1, b + 1], [a, b + 1, b]]
        })
        .collect();
    Arc::new(Mesh { positions, triangles, shading: Shading::Flat })
}

/// From an eye at 3 m, row by row.
fn primary_rays() -> Vec<Start> {
    let width = 418;
    let rows = RAYS / width;
    let eye = DVec3::new(0.0, 0.0, 3120.0);
    let aim = |i: usize, j: usize| {
        let x = (i as f64 + 0.5) / width as f64 - 0.5;
        let y = (j as f64 + 0.5) / rows as f64 - 0.5;
        let target = DVec3::new(216.0 * x, 162.0 * y, 120.0);
        (Ray { origin: eye, direction: (target - eye).normalize() }, None)
    };
    (0..rows).flat_map(|j| (0..width).map(move |i| aim(i, j))).collect()
}

/// The primary rays, straight through both faces of the lens, mirrored by what lies behind.
fn mirrored_rays(bvh: &Bvh, primary: &[Start]) -> Vec<Start> {
    primary.iter().filter_map(|(ray, _)| mirrored(bvh, ray)).collect()
}

fn mirrored(bvh: &Bvh, ray: &Ray) -> Option<Start> {
    let mut ray = *ray;
    let mut hit: Hit = bvh.closest_hit(&ray, None)?;
    while bvh.locate(hit.triangle).0 > 0 {
        ray.origin = bvh.departure(&hit).toward(ray.direction);
        hit = bvh.closest_hit(&ray, Some(hit.triangle))?;
    }
    let departure = bvh.departure(&hit);
    let n = departure.n_geom;
    let direction = (ray.direction - 2.0 * ray.direction.dot(n) * n).normalize();
    Some((Ray { origin: departure.toward(direction), direction }, Some(hit.triangle)))
}

/// From anywhere in the lamp's box in any direction.
fn random_rays(bvh: &Bvh) -> Vec<Start> {
    let Some((low, high)) = bvh.bounds() else { return Vec::new() };
    let mut state = 1u64;
    let mut unit = move || {
        // A linear congruential generator; its high bits are random enough to aim rays.
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    (0..RAYS)
        .map(|_| {
            let origin = low + (high - low) * DVec3::new(unit(), unit(), unit());
            let z = 2.0 * unit() - 1.0;
            let (s, c) = (std::f64::consts::TAU * unit()).sin_cos();
            let r = (1.0 - z * z).sqrt();
            (Ray { origin, direction: DVec3::new(r * c, r * s, z) }, None)
        })
        .collect()
}
