//! The nodes of the tree: every level halves the one above three times, eight children a node.

use std::io::{self, Read, Write};
use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::blocks::Blocks;
use super::eight::{Eight, Vectors};
use super::interpolation::TableError;
use super::moments::{CHANNELS, Channels};
use super::octahedron::OctahedronGrid;
use super::table::{CellSamples, RawTable};
use crate::light::RaySample;
use crate::light::stored::{read_floats, write_floats};
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

impl Octet {
    const EMPTY: Octet = Octet {
        center: [Eight::ZERO; 3],
        radius: Eight::ZERO,
        half_size: [Eight::ZERO; 3],
        flux: Eight::ZERO,
        error_share: Eight::ZERO,
        largest_error: Eight::ZERO,
    };

    const FLOATS: usize = size_of::<Octet>() / size_of::<f32>();

    fn lanes(&self) -> impl Iterator<Item = &f32> {
        let Octet { center, radius, half_size, flux, error_share, largest_error } = self;
        let single = [radius, flux, error_share, largest_error];
        center.iter().chain(half_size).chain(single).flat_map(|eight| &eight.0)
    }

    fn lanes_mut(&mut self) -> impl Iterator<Item = &mut f32> {
        let Octet { center, radius, half_size, flux, error_share, largest_error } = self;
        let single = [radius, flux, error_share, largest_error];
        center.iter_mut().chain(half_size).chain(single).flat_map(|eight| &mut eight.0)
    }
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

    fn read(size: LevelSize, from: &mut dyn Read) -> io::Result<Level> {
        let grid = size.grid();
        let mut octets = vec![Octet::EMPTY; size.nodes.div_ceil(8)];
        let floats = octets.len() * Octet::FLOATS;
        read_floats(from, floats, octets.iter_mut().flat_map(Octet::lanes_mut))?;
        let mut tables = vec![Channels([0.0; CHANNELS]); size.nodes * grid.vertices()];
        let floats = tables.len() * CHANNELS;
        read_floats(from, floats, tables.iter_mut().flat_map(|vertex| &mut vertex.0))?;
        Ok(Level { octets, grid, tables, blocks_per_node: size.blocks_per_node })
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
        let center = tree_center(blocks);
        let mut levels = Vec::new();
        let (mut cells, mut has_beams) = (None, false);
        for size in LevelSize::all(depth).into_iter().rev() {
            let built = BuiltOctet::all(blocks, size, cells.as_deref());
            levels.push(Level::new(&built, size, center));
            has_beams |= built.iter().flat_map(|octet| &octet.errors).any(|error| error.is_beam);
            cells = Some(built.into_iter().map(|octet| octet.parent).collect::<Vec<NodeTable>>());
        }
        levels.reverse();
        Levels::of(blocks, levels, has_beams)
    }

    /// None without levels.
    fn of(blocks: &Blocks, levels: Vec<Level>, has_beams: bool) -> Option<Levels> {
        let center = tree_center(blocks);
        let flux =
            levels.first()?.octets.iter().flat_map(|octet| octet.flux.0).map(f64::from).sum();
        let reach = |block: &Block| block.center.distance(center) + block.radius;
        let radius = blocks.blocks.iter().map(reach).fold(0.0, f64::max);
        Some(Levels { levels, center, radius, flux, has_beams })
    }

    /// Octets and tables of all levels, as [`Levels::read`] takes them.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        out.write_all(&[u8::from(self.has_beams)])?;
        for level in &self.levels {
            write_floats(out, level.octets.iter().flat_map(Octet::lanes).copied())?;
            write_floats(out, level.tables.iter().flat_map(|vertex| vertex.0))?;
        }
        Ok(())
    }

    /// What [`Levels::write`] wrote for the same blocks; none for sets that are too small.
    pub fn read(blocks: &Blocks, depth: u32, from: &mut dyn Read) -> io::Result<Option<Levels>> {
        if depth < FEWEST_BLOCKS_DEPTH {
            return Ok(None);
        }
        let mut has_beams = [0];
        from.read_exact(&mut has_beams)?;
        let levels = LevelSize::all(depth).into_iter().map(|size| Level::read(size, from));
        let levels = levels.collect::<io::Result<Vec<Level>>>()?;
        Ok(Levels::of(blocks, levels, has_beams != [0]))
    }

    pub fn memory_bytes(&self) -> usize {
        let of_level = |level: &Level| size_of_val(&*level.octets) + size_of_val(&*level.tables);
        self.levels.iter().map(of_level).sum()
    }
}

fn tree_center(blocks: &Blocks) -> DVec3 {
    super::blocks::box_center(blocks.blocks.iter().map(|block| block.center))
}

#[derive(Debug, Clone, Copy)]
struct LevelSize {
    nodes: usize,
    blocks_per_node: usize,
}

impl LevelSize {
    /// Of all levels of a tree of 2^`depth` blocks, from the root's children down.
    fn all(depth: u32) -> Vec<LevelSize> {
        // The first level takes what is left over, so that all others are whole octets.
        let first = if depth.is_multiple_of(3) { 3 } else { depth % 3 };
        let depths = (first..=depth).step_by(3).filter(|bits| 1usize << bits <= MOST_NODES);
        depths
            .map(|bits| LevelSize { nodes: 1 << bits, blocks_per_node: 1 << (depth - bits) })
            .collect()
    }

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
