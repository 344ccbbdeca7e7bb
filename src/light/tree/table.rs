//! Emission tables: what a cell of samples sends into each direction, with moments.
//!
//! For a direction x, with w_i = Φ_i max(0, x·Q_i), δ_i a sample's place in the cell, H_i = 1 where
//! x·Q_i > 0, and τ_i = δ_i·Q_i.

use rayon::prelude::*;

use super::octahedron::Grid;
use crate::light::sum::block::{LANES, SampleGroup};

/// Σ w.
pub(super) const EMISSION: usize = 0;
/// Σ w δ.
pub(super) const MEAN: usize = 1;
/// Σ w δ δᵀ: xx, yy, zz, xy, xz, yz.
pub(super) const SPREAD: usize = 4;
/// Σ Φ H Q, the gradient of Σ w.
pub(super) const GRADIENT: usize = 10;
/// Σ Φ H τ: how Σ w changes as the hit comes near.
pub(super) const PARALLAX: usize = 13;
/// Σ Φ H τ².
pub(super) const PARALLAX2: usize = 14;
pub(super) const CHANNELS: usize = 15;

/// A cell's samples, as far as a table needs them.
pub(super) struct CellSamples<'a> {
    /// (groups, their block's center − the cell's center).
    pub blocks: Vec<(&'a [SampleGroup], [f32; 3])>,
}

/// Values of a cell: [vertex][channel].
pub(super) fn build_table(cell: &CellSamples, grid: Grid) -> Vec<f32> {
    let mut sums = vec![0.0f64; grid.vertices() * CHANNELS];
    let vertices: Vec<[f32; 3]> = (0..grid.vertices()).map(|i| grid.vertex(i)).collect();
    for (groups, shift) in &cell.blocks {
        let terms: Vec<Terms> = groups.iter().map(|group| Terms::new(group, *shift)).collect();
        add_block(&terms, &vertices, &mut sums);
    }
    sums.iter().map(|sum| *sum as f32).collect()
}

/// [octet][vertex][channel][lane] of cells in order, eight an octet.
pub(super) fn build_tables(cells: &[CellSamples], grid: Grid) -> Vec<f32> {
    let built: Vec<Vec<f32>> = cells.par_iter().map(|cell| build_table(cell, grid)).collect();
    let stride = grid.vertices() * CHANNELS;
    let mut tables = vec![0.0f32; cells.len().div_ceil(8) * stride * 8];
    tables.par_chunks_mut(stride * 8).zip(built.par_chunks(8)).for_each(|(octet, lanes)| {
        for (lane, values) in lanes.iter().enumerate() {
            for (i, value) in values.iter().enumerate() {
                octet[i * 8 + lane] = *value;
            }
        }
    });
    tables
}

type Lanes = [f32; LANES];

/// What sixteen samples bring into every direction.
#[repr(align(64))]
struct Terms {
    flux: [Lanes; 3],
    offset: [Lanes; 3],
    spread: [Lanes; 6],
    /// Φ τ and Φ τ².
    parallax: [Lanes; 2],
}

impl Terms {
    fn new(group: &SampleGroup, shift: [f32; 3]) -> Terms {
        let offset: [Lanes; 3] =
            std::array::from_fn(|axis| group.offset[axis].map(|v| v + shift[axis]));
        let product = |a: &Lanes, b: &Lanes| std::array::from_fn(|i| a[i] * b[i]);
        let [x, y, z] = &offset;
        let pairs = [(x, x), (y, y), (z, z), (x, y), (x, z), (y, z)];
        let [qx, qy, qz] = &group.flux;
        let parallax: Lanes = std::array::from_fn(|i| x[i] * qx[i] + y[i] * qy[i] + z[i] * qz[i]);
        let squared: Lanes = std::array::from_fn(|i| {
            let flux = (qx[i] * qx[i] + qy[i] * qy[i] + qz[i] * qz[i]).sqrt();
            if flux > 0.0 { parallax[i] * (parallax[i] / flux) } else { 0.0 }
        });
        let spread = pairs.map(|(a, b)| product(a, b));
        Terms { flux: group.flux, offset, spread, parallax: [parallax, squared] }
    }
}

fn add_block(terms: &[Terms], vertices: &[[f32; 3]], sums: &mut [f64]) {
    #[cfg(target_arch = "x86_64")]
    {
        use crate::light::sum::isa::{Isa, detected};
        #[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw")]
        fn with_avx512(terms: &[Terms], vertices: &[[f32; 3]], sums: &mut [f64]) {
            kernel(terms, vertices, sums);
        }
        #[target_feature(enable = "avx2")]
        fn with_avx2(terms: &[Terms], vertices: &[[f32; 3]], sums: &mut [f64]) {
            kernel(terms, vertices, sums);
        }
        // SAFETY: each is called only after the processor has said that it has the features.
        match detected() {
            Isa::Avx512 => return unsafe { with_avx512(terms, vertices, sums) },
            Isa::Avx2 => return unsafe { with_avx2(terms, vertices, sums) },
            Isa::Plain => {}
        }
    }
    kernel(terms, vertices, sums);
}

#[inline(always)]
fn kernel(terms: &[Terms], vertices: &[[f32; 3]], sums: &mut [f64]) {
    for (x, sums) in vertices.iter().zip(sums.chunks_exact_mut(CHANNELS)) {
        let mut lanes = [[0.0f32; LANES]; CHANNELS];
        for term in terms {
            add_group(term, *x, &mut lanes);
        }
        for (sum, lanes) in sums.iter_mut().zip(&lanes) {
            *sum += f64::from(fold(lanes));
        }
    }
}

#[inline(always)]
fn add_group(term: &Terms, x: [f32; 3], lanes: &mut [Lanes; CHANNELS]) {
    for i in 0..LANES {
        let [qx, qy, qz] = [term.flux[0][i], term.flux[1][i], term.flux[2][i]];
        let toward = x[0] * qx + x[1] * qy + x[2] * qz;
        let emits = toward > 0.0;
        let w = if emits { toward } else { 0.0 };
        lanes[EMISSION][i] += w;
        for axis in 0..3 {
            lanes[MEAN + axis][i] += w * term.offset[axis][i];
        }
        for pair in 0..6 {
            lanes[SPREAD + pair][i] += w * term.spread[pair][i];
        }
        lanes[GRADIENT][i] += if emits { qx } else { 0.0 };
        lanes[GRADIENT + 1][i] += if emits { qy } else { 0.0 };
        lanes[GRADIENT + 2][i] += if emits { qz } else { 0.0 };
        lanes[PARALLAX][i] += if emits { term.parallax[0][i] } else { 0.0 };
        lanes[PARALLAX2][i] += if emits { term.parallax[1][i] } else { 0.0 };
    }
}

/// Pairwise, so that it takes four steps.
#[inline(always)]
fn fold(lanes: &Lanes) -> f32 {
    let eight: [f32; 8] = std::array::from_fn(|i| lanes[i] + lanes[i + 8]);
    let four: [f32; 4] = std::array::from_fn(|i| eight[i] + eight[i + 4]);
    (four[0] + four[2]) + (four[1] + four[3])
}
