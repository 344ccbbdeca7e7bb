//! The bounding volume hierarchy: which triangle a ray meets first, and whether any is in its way.
//!
//! Three steps build it: `binary` orders the triangles by the surface area heuristic, `forest`
//! chooses which binary nodes become nodes of eight children and packets of eight triangles,
//! `wide` lays these out. A ray goes through it (`walk`) with one of two kernels (`kernel`,
//! `avx2`), which leave out what it cannot meet: boxes in f32 with a pad, triangles where the sign
//! of an edge function is sure. Whether and where it meets the rest is decided in f64 (`probe`). So
//! hits are the same bits on any machine, and the same as without a tree.

#[cfg(target_arch = "x86_64")]
mod avx2;
mod binary;
mod bounds;
mod departure;
mod forest;
mod kernel;
mod probe;
mod query;
mod shaft;
#[cfg(test)]
mod tests;
mod umbra;
mod walk;
mod wide;

use std::sync::Arc;

use rayon::prelude::*;

use super::{DVec3, Mesh, TriangleId};
use crate::simd::Simd;
use binary::Primitive;
use bounds::Frame;
pub use departure::Departure;
pub use query::FirstHit;
pub use shaft::{Role, Shaft};
use wide::Tree;

/// All triangles of a scene, ordered for rays.
#[derive(Debug, Clone)]
pub struct Bvh {
    meshes: Vec<Arc<Mesh>>,
    /// Number of the first triangle of each mesh, and the count of all.
    first_triangles: Vec<u32>,
    low: DVec3,
    high: DVec3,
    frame: Frame,
    tree: Tree,
    /// Which kernel walks the tree; all give the same hits, and none is wider than AVX2.
    simd: Simd,
}

impl Bvh {
    /// Orders the triangles of all objects. The same meshes give the same tree on any number of
    /// threads. Degenerate triangles stay numbered and are never met.
    pub fn build(meshes: &[Arc<Mesh>]) -> Bvh {
        let mut first_triangles = vec![0u32];
        for mesh in meshes {
            let last = first_triangles[first_triangles.len() - 1];
            first_triangles.push(last + mesh.triangles.len() as u32);
        }
        let (low, high) = meshes.iter().map(|mesh| bounds_of(mesh)).fold(NOWHERE, join);
        let frame = Frame::new(low, high);
        let mut bvh = Bvh {
            meshes: meshes.to_vec(),
            first_triangles,
            low,
            high,
            frame,
            tree: Tree { nodes: Vec::new(), packets: Vec::new(), root: None },
            simd: Simd::widest(),
        };
        bvh.tree = bvh.build_tree();
        bvh
    }

    fn build_tree(&self) -> Tree {
        let mut primitives = Vec::new();
        for (mesh, &first) in self.meshes.iter().zip(&self.first_triangles) {
            primitives.par_extend(sound_triangles(mesh).map(|(index, corners)| Primitive {
                bounds: self.frame.box_of(corners),
                triangle: first + index,
            }));
        }
        let nodes = binary::build(&mut primitives);
        let triangle_at = |place: u32| {
            let triangle = primitives[place as usize].triangle;
            (triangle, self.corners(TriangleId(triangle)))
        };
        let forests = forest::plan(&nodes, |node| {
            let places = node.first..node.first + node.count;
            wide::fits_a_packet(places.map(|place| triangle_at(place).1))
        });
        Tree::new(&nodes, &forests, triangle_at)
    }

    /// The same tree with another kernel, to compare them; unchanged if the processor lacks it.
    pub fn with_simd(mut self, simd: Simd) -> Bvh {
        if Simd::available().contains(&simd) {
            self.simd = simd;
        }
        self
    }

    /// Object and index in its mesh of a triangle.
    #[inline]
    pub fn locate(&self, triangle: TriangleId) -> (usize, usize) {
        let object = self.first_triangles.partition_point(|&first| first <= triangle.0) - 1;
        (object, (triangle.0 - self.first_triangles[object]) as usize)
    }

    /// Corners of a triangle, mm.
    pub fn corners(&self, triangle: TriangleId) -> [DVec3; 3] {
        let (object, index) = self.locate(triangle);
        let mesh = &self.meshes[object];
        mesh.triangles[index].map(|position| mesh.positions[position as usize])
    }

    /// Lowest and highest corner of the scene, mm; `None` if no triangle has an area.
    pub fn bounds(&self) -> Option<(DVec3, DVec3)> {
        self.tree.root.map(|_| (self.low, self.high))
    }

    /// Memory of the tree, without the meshes.
    pub fn memory_bytes(&self) -> usize {
        self.tree.memory_bytes() + size_of_val(&self.first_triangles[..])
    }

    fn radius_mm(&self) -> f64 {
        self.frame.radius_mm
    }
}

/// Index and corners of the triangles that can be met.
fn sound_triangles(mesh: &Mesh) -> impl ParallelIterator<Item = (u32, [DVec3; 3])> {
    mesh.triangles.par_iter().enumerate().filter_map(|(index, triangle)| {
        let corners = triangle.map(|position| mesh.positions[position as usize]);
        (!probe::is_degenerate(corners)).then_some((index as u32, corners))
    })
}

const NOWHERE: (DVec3, DVec3) = (DVec3::INFINITY, DVec3::NEG_INFINITY);

fn join(a: (DVec3, DVec3), b: (DVec3, DVec3)) -> (DVec3, DVec3) {
    (a.0.min(b.0), a.1.max(b.1))
}

fn bounds_of(mesh: &Mesh) -> (DVec3, DVec3) {
    sound_triangles(mesh)
        .map(|(_, [a, b, c])| (a.min(b).min(c), a.max(b).max(c)))
        .reduce(|| NOWHERE, join)
}
