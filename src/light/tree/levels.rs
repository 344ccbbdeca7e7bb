//! The nodes of the tree: every level halves the one above three times, eight children a node.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::blocks::Blocks;
use super::eight::{Eight, Vectors};
use super::interpolation::TableError;
use super::moments::Channels;
use super::octahedron::OctahedronGrid;
use super::table::{CellSamples, RawTable};
use crate::light::RaySample;
use crate::light::sum::block::Block;

/// Sets of fewer blocks (about 2000 samples) are summed as fast without tables.
const FEWEST_BLOCKS_DEPTH: u32 = 3;

/// Levels of more nodes have no tables: memory grows by 11 kB a node.
const MOST_NODES: usize = 4096;

/// Up to this many nodes tables keep all of their grid, since most hits end there; beyond, every
/// other vertex of a row and every other row.
const MOST_FINE_NODES: usize = 512;

const FINE: OctahedronGrid = OctahedronGrid { cells: 24 };

/// Eight siblings. A lane without a node has flux 0.
#[derive(Debug, Clone, Copy)]
pub(super) struct Octet {
    /// Relative to the tree's center.
    pub center: Vectors,
    /// Radii of spheres about the centers that hold the samples.
    pub radius: Eight,
    /// Half sizes of boxes about the centers that hold the samples.
    pub half_size: Vectors,
    pub flux: Eight,
    /// See [`TableError`].
    pub error_share: Eight,
    pub largest_error: Eight,
}

/// Nodes of equal depth.
#[derive(Debug, Clone)]
pub(super) struct Level {
    pub octets: Vec<Octet>,
    pub grid: OctahedronGrid,
    /// [node][vertex].
    tables: Vec<Channels>,
    /// Consecutive blocks that a node holds.
    pub blocks_per_node: usize,
}

impl Level {
    fn new(built: &[BuiltOctet], size: LevelSize, tree_center: DVec3) -> Level {
        Level {
            octets: built.iter().map(|octet| octet.octet(tree_center)).collect(),
            grid: size.grid(),
            tables: built.iter().flat_map(|octet| octet.tables.iter().copied()).collect(),
            blocks_per_node: size.blocks_per_node,
        }
    }

    /// Tables of an octet's nodes, one after the other.
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
    /// Radius of a sphere about `center` that holds the samples.
    pub radius: f64,
    /// Σ flux.
    pub flux: f64,
    /// Whether any node is a beam, see [`TableError::is_beam`].
    pub has_beams: bool,
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
        let depths = (first..=depth).step_by(3).filter(|bits| 1usize << bits <= MOST_NODES);
        let mut levels = Vec::new();
        let (mut cells, mut has_beams) = (None, false);
        for bits in depths.collect::<Vec<u32>>().into_iter().rev() {
            let size = LevelSize { nodes: 1 << bits, blocks_per_node: blocks.blocks.len() >> bits };
            let built = BuiltOctet::all(blocks, size, cells.as_deref());
            levels.push(Level::new(&built, size, center));
            has_beams |= built.iter().flat_map(|octet| &octet.errors).any(|error| error.is_beam);
            cells = Some(built.into_iter().map(|octet| octet.parent).collect::<Vec<NodeTable>>());
        }
        levels.reverse();
        let flux =
            levels.first()?.octets.iter().flat_map(|octet| octet.flux.0).map(f64::from).sum();
        let reach = |block: &Block| block.center.distance(center) + block.radius;
        let radius = blocks.blocks.iter().map(reach).fold(0.0, f64::max);
        Some(Levels { levels, center, radius, flux, has_beams })
    }

    pub fn memory_bytes(&self) -> usize {
        let of_level = |level: &Level| size_of_val(&*level.octets) + size_of_val(&*level.tables);
        self.levels.iter().map(of_level).sum()
    }
}

#[derive(Debug, Clone, Copy)]
struct LevelSize {
    nodes: usize,
    blocks_per_node: usize,
}

impl LevelSize {
    /// Grid of the tables that stay; all are built on [`FINE`].
    fn grid(self) -> OctahedronGrid {
        if self.nodes <= MOST_FINE_NODES { FINE } else { OctahedronGrid { cells: FINE.cells / 2 } }
    }

    fn blocks_of(self, blocks: &Blocks, nodes: Range<usize>) -> &[Block] {
        &blocks.blocks[nodes.start * self.blocks_per_node..nodes.end * self.blocks_per_node]
    }
}

/// A node while the tables above it are built.
struct NodeTable {
    place: SampleExtent,
    raw: RawTable,
}

impl NodeTable {
    fn from_samples(blocks: &Blocks, own: &[Block]) -> NodeTable {
        let place = SampleExtent::of(blocks, own);
        let shifted = |block: &Block| {
            (blocks.groups_of(block), (block.center - place.center).as_vec3().into())
        };
        let samples = CellSamples { blocks: own.iter().map(shifted).collect() };
        NodeTable { raw: RawTable::from_samples(&samples, FINE), place }
    }

    fn from_children(blocks: &Blocks, own: &[Block], children: &[NodeTable]) -> NodeTable {
        let place = SampleExtent::of(blocks, own);
        let shift = |child: &NodeTable| (child.place.center - place.center).into();
        let shifted = children.iter().map(|child| (&child.raw, shift(child)));
        NodeTable { raw: RawTable::from_children(shifted), place }
    }
}

/// Eight siblings, and what the level above needs of them.
struct BuiltOctet {
    places: Vec<SampleExtent>,
    errors: Vec<TableError>,
    tables: Vec<Channels>,
    parent: NodeTable,
}

impl BuiltOctet {
    /// A level, from `cells` if those below made them.
    fn all(blocks: &Blocks, size: LevelSize, cells: Option<&[NodeTable]>) -> Vec<BuiltOctet> {
        let build = |octet: usize| {
            let nodes = octet * 8..size.nodes.min(octet * 8 + 8);
            match cells {
                Some(cells) => BuiltOctet::new(blocks, size, nodes.clone(), &cells[nodes]),
                None => {
                    let own = |node| size.blocks_of(blocks, node..node + 1);
                    let cells: Vec<NodeTable> = nodes
                        .clone()
                        .map(|node| NodeTable::from_samples(blocks, own(node)))
                        .collect();
                    BuiltOctet::new(blocks, size, nodes, &cells)
                }
            }
        };
        (0..size.nodes.div_ceil(8)).into_par_iter().map(build).collect()
    }

    fn new(
        blocks: &Blocks,
        size: LevelSize,
        nodes: Range<usize>,
        cells: &[NodeTable],
    ) -> BuiltOctet {
        let grid = size.grid();
        let tables: Vec<Channels> =
            cells.iter().flat_map(|cell| cell.raw.finish(FINE, grid)).collect();
        let error = |((node, cell), table): ((usize, &NodeTable), &[Channels])| {
            let own = size.blocks_of(blocks, node..node + 1).iter();
            let groups: Vec<_> = own.map(|block| blocks.groups_of(block)).collect();
            TableError::measure(&groups, cell.place.flux, table, grid)
        };
        let with_tables = nodes.clone().zip(cells).zip(tables.chunks(grid.vertices()));
        BuiltOctet {
            places: cells.iter().map(|cell| cell.place).collect(),
            errors: with_tables.map(error).collect(),
            tables,
            parent: NodeTable::from_children(blocks, size.blocks_of(blocks, nodes), cells),
        }
    }

    fn octet(&self, tree_center: DVec3) -> Octet {
        // Empty lanes lie where the first node is, whose table they read.
        let places = &self.places;
        let place = |lane: usize| places.get(lane).unwrap_or(&places[0]);
        let lanes =
            |f: &dyn Fn(&SampleExtent) -> f64| Eight(std::array::from_fn(|i| f(place(i)) as f32));
        let errors = |f: &dyn Fn(&TableError) -> f64| {
            Eight(std::array::from_fn(|i| self.errors.get(i).map_or(1.0, f) as f32))
        };
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        // f32 rounds center and offsets: let sphere and box hold the rounded ones.
        let grown = |size: f64, p: &SampleExtent| {
            size * (1.0 + 1e-5) + 1e-7 * p.center.distance(tree_center)
        };
        Octet {
            center: axes.map(|axis| lanes(&|p| (p.center - tree_center).dot(axis))),
            radius: lanes(&|p| grown(p.radius, p)),
            half_size: axes.map(|axis| lanes(&|p| grown(p.half_size.dot(axis), p))),
            flux: Eight(std::array::from_fn(|i| places.get(i).map_or(0.0, |p| p.flux as f32))),
            error_share: errors(&|e| e.share),
            largest_error: errors(&|e| e.largest),
        }
    }
}

#[derive(Debug, Clone, Copy)]
struct SampleExtent {
    center: DVec3,
    half_size: DVec3,
    radius: f64,
    flux: f64,
}

impl SampleExtent {
    fn of(blocks: &Blocks, own: &[Block]) -> SampleExtent {
        let samples = || own.iter().flat_map(|block| blocks.samples_of(block));
        let positions = || samples().map(RaySample::origin);
        let center = super::blocks::box_center(positions());
        let radius = positions().map(|p| p.distance(center)).fold(0.0, f64::max);
        let flux = samples().map(|sample| f64::from(sample.flux)).sum();
        let half_size = positions().map(|p| (p - center).abs()).fold(DVec3::ZERO, DVec3::max);
        SampleExtent { center, half_size, radius, flux }
    }
}
