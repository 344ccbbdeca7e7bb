//! The nodes of the tree: every level halves the one above three times, eight children a node.

use glam::DVec3;
use rayon::prelude::*;

use super::blocks::Blocks;
use super::eight::{Eight, Vectors};
use super::interpolation::measured_error;
use super::moments::Channels;
use super::octahedron::Grid;
use super::table::{CellSamples, RawTable, finish_tables};
use crate::light::sum::block::Block;

/// Sets of fewer blocks (about 2000 samples) are summed as fast without tables.
const FEWEST_BLOCKS_DEPTH: u32 = 3;

/// Levels of more nodes have no tables: memory grows by 5 kB a node.
const MOST_NODES: usize = 4096;

/// Up to this many nodes the grid is fine, since most hits end there.
const MOST_FINE_NODES: usize = 512;

const FINE: Grid = Grid { cells: 24 };
const COARSE: Grid = Grid { cells: 16 };

/// Eight siblings. A lane without a node has flux 0.
#[derive(Debug, Clone, Copy)]
pub(super) struct Octet {
    /// Relative to the tree's center.
    pub center: Vectors,
    /// Of spheres about the centers that hold the samples.
    pub radius: Eight,
    pub flux: Eight,
    /// Of the table, see [`measured_error`].
    pub interpolation: Eight,
}

/// Nodes of equal depth.
#[derive(Debug, Clone)]
pub(super) struct Level {
    pub octets: Vec<Octet>,
    pub grid: Grid,
    /// [node][vertex].
    tables: Vec<Channels>,
    /// Consecutive blocks that a node holds.
    pub blocks_per_node: usize,
}

impl Level {
    /// Of an octet's nodes, one after the other.
    pub fn tables(&self, octet: usize) -> &[Channels] {
        let stride = self.grid.vertices() * 8;
        &self.tables[octet * stride..self.tables.len().min((octet + 1) * stride)]
    }
}

/// From the root's children down.
#[derive(Debug, Clone)]
pub(super) struct Levels {
    pub levels: Vec<Level>,
    pub center: DVec3,
    /// Of a sphere about `center` that holds the samples.
    pub radius: f64,
    /// Σ flux.
    pub flux: f64,
}

impl Levels {
    /// None for a set too small to gain from it.
    pub fn build(blocks: &Blocks, depth: u32) -> Option<Levels> {
        if depth < FEWEST_BLOCKS_DEPTH {
            return None;
        }
        let center = super::blocks::box_center(blocks.blocks.iter().map(|block| block.center));
        // The first level takes what is left over, so that all others are whole octets.
        let first = if depth.is_multiple_of(3) { 3 } else { depth % 3 };
        let bits: Vec<u32> =
            (first..=depth).step_by(3).filter(|bits| 1usize << bits <= MOST_NODES).collect();
        let mut below: Option<Nodes> = None;
        let mut levels = Vec::new();
        for bits in bits.into_iter().rev() {
            let nodes = Nodes::build(blocks, 1 << bits, below.take());
            levels.push(nodes.to_level(blocks, center));
            below = Some(nodes);
        }
        levels.reverse();
        let flux =
            levels.first()?.octets.iter().flat_map(|octet| octet.flux.0).map(f64::from).sum();
        let reach = |block: &Block| block.center.distance(center) + block.radius;
        let radius = blocks.blocks.iter().map(reach).fold(0.0, f64::max);
        Some(Levels { levels, center, radius, flux })
    }

    pub fn memory_bytes(&self) -> usize {
        let of_level = |level: &Level| size_of_val(&*level.octets) + size_of_val(&*level.tables);
        self.levels.iter().map(of_level).sum()
    }
}

/// A level while the one above may still need it.
struct Nodes {
    grid: Grid,
    places: Vec<Place>,
    raw: Vec<RawTable>,
    blocks_per_node: usize,
}

impl Nodes {
    /// From the level below where that has the same grid, else from the samples.
    fn build(blocks: &Blocks, count: usize, below: Option<Nodes>) -> Nodes {
        let blocks_per_node = blocks.blocks.len() / count;
        let grid = if count <= MOST_FINE_NODES { FINE } else { COARSE };
        let places: Vec<Place> =
            (0..count).into_par_iter().map(|i| Place::of(blocks, i, blocks_per_node)).collect();
        let raw = match below.filter(|below| below.grid == grid) {
            Some(below) => (0..count).into_par_iter().map(|i| below.merge(i, &places[i])).collect(),
            None => places
                .par_iter()
                .enumerate()
                .map(|(i, place)| cell_samples(blocks, i * blocks_per_node, blocks_per_node, place))
                .map(|cell| RawTable::from_samples(&cell, grid))
                .collect(),
        };
        Nodes { grid, places, raw, blocks_per_node }
    }

    /// Eight of these nodes as one at `place`.
    fn merge(&self, parent: usize, place: &Place) -> RawTable {
        let range = parent * 8..(parent + 1) * 8;
        let shift = |child: &Place| (child.center - place.center).into();
        let shifts: Vec<[f64; 3]> = self.places[range.clone()].iter().map(shift).collect();
        RawTable::from_children(&self.raw[range], &shifts)
    }

    fn to_level(&self, blocks: &Blocks, tree_center: DVec3) -> Level {
        let tables = finish_tables(&self.raw);
        let errors: Vec<f64> = tables
            .par_chunks(self.grid.vertices())
            .zip(&self.places)
            .enumerate()
            .map(|(node, (table, place))| {
                let range = node * self.blocks_per_node..(node + 1) * self.blocks_per_node;
                let groups: Vec<_> =
                    blocks.blocks[range].iter().map(|block| blocks.groups_of(block)).collect();
                measured_error(&groups, place.flux, table, self.grid)
            })
            .collect();
        let octets = self.places.chunks(8).zip(errors.chunks(8));
        Level {
            octets: octets.map(|(places, errors)| octet(places, errors, tree_center)).collect(),
            grid: self.grid,
            tables,
            blocks_per_node: self.blocks_per_node,
        }
    }
}

struct Place {
    center: DVec3,
    radius: f64,
    flux: f64,
}

impl Place {
    fn of(blocks: &Blocks, node: usize, blocks_per_node: usize) -> Place {
        let range = node * blocks_per_node..(node + 1) * blocks_per_node;
        let samples = || blocks.blocks[range.clone()].iter().flat_map(|b| blocks.samples_of(b));
        let positions = || samples().map(|s| DVec3::from(s.position.map(f64::from)));
        let center = super::blocks::box_center(positions());
        let radius = positions().map(|p| p.distance(center)).fold(0.0, f64::max);
        let flux = samples().map(|sample| f64::from(sample.flux)).sum();
        Place { center, radius, flux }
    }
}

fn cell_samples<'a>(
    blocks: &'a Blocks,
    first: usize,
    count: usize,
    place: &Place,
) -> CellSamples<'a> {
    let shifted = |block: &'a Block| {
        let shift = block.center - place.center;
        (blocks.groups_of(block), shift.as_vec3().into())
    };
    CellSamples { blocks: blocks.blocks[first..first + count].iter().map(shifted).collect() }
}

fn octet(places: &[Place], errors: &[f64], tree_center: DVec3) -> Octet {
    // Empty lanes lie where the first node is, whose table they read.
    let place = |lane: usize| places.get(lane).unwrap_or(&places[0]);
    let lanes = |f: &dyn Fn(&Place) -> f64| Eight(std::array::from_fn(|i| f(place(i)) as f32));
    let flux = Eight(std::array::from_fn(|i| places.get(i).map_or(0.0, |p| p.flux as f32)));
    Octet {
        center: [
            lanes(&|p| p.center.x - tree_center.x),
            lanes(&|p| p.center.y - tree_center.y),
            lanes(&|p| p.center.z - tree_center.z),
        ],
        // f32 rounds center and offsets: let the sphere hold the rounded ones.
        radius: lanes(&|p| p.radius * (1.0 + 1e-5) + 1e-7 * (p.center - tree_center).length()),
        flux,
        interpolation: Eight(std::array::from_fn(|i| errors.get(i).map_or(1.0, |e| *e as f32))),
    }
}
