//! Emission tables: moments of what a cell of samples sends into each direction of a grid.

use super::moments::{
    Channels, EMISSION, GRADIENT, LIT, MEAN, MOMENTS, Moments, PAIRS, PARALLAX, PARALLAX2, SKEW,
    SPREAD, TRIPLES, WIDE,
};
use super::octahedron::OctahedronGrid;
use crate::light::sum::block::{BLOCK_CAPACITY, LANES, SampleGroup};
use crate::simd::widest;

/// A cell's samples, as far as a table needs them.
pub(super) struct CellSamples<'a> {
    /// (groups, their block's center − the cell's center).
    pub blocks: Vec<(&'a [SampleGroup], [f32; 3])>,
}

/// Moments of a cell by vertex; f32, since there may be thousands of cells.
pub(super) struct RawTable(Vec<[f32; MOMENTS]>);

impl RawTable {
    pub fn from_samples(cell: &CellSamples, grid: OctahedronGrid) -> RawTable {
        let mut sums = vec![[0.0f64; MOMENTS]; grid.vertices()];
        let vertices: Vec<[f32; 3]> = (0..grid.vertices()).map(|i| grid.vertex(i)).collect();
        for (groups, shift) in &cell.blocks {
            add_block(&Terms::new(groups, *shift), &vertices, &mut sums);
        }
        RawTable(sums.iter().map(|sums| sums.map(|sum| sum as f32)).collect())
    }

    /// Table of a cell that holds others, each with its place less the cell's.
    pub fn from_children<'a>(children: impl Iterator<Item = (&'a RawTable, [f64; 3])>) -> RawTable {
        let mut sums = Vec::new();
        for (child, shift) in children {
            sums.resize(child.0.len(), Moments::ZERO);
            for (sum, moments) in sums.iter_mut().zip(&child.0) {
                sum.add(&Moments::from_f32(moments).shifted(shift));
            }
        }
        RawTable(sums.iter().map(|sum| sum.0.map(|value| value as f32)).collect())
    }

    /// On every k-th row and column of its grid, as many as `kept` has.
    pub fn finish(
        &self,
        grid: OctahedronGrid,
        kept: OctahedronGrid,
    ) -> impl Iterator<Item = Channels> {
        let step = grid.cells / kept.cells;
        let vertices = (0..kept.vertices()).map(move |i| {
            let (row, column) = (i / (kept.cells + 1), i % (kept.cells + 1));
            row * step * (grid.cells + 1) + column * step
        });
        vertices.map(|vertex| Moments::from_f32(&self.0[vertex]).channels())
    }
}

type RowLanes = [f32; LANES];

/// Aligned, so that no load crosses a cache line.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
struct CurveRow(RowLanes);

/// What a block's samples bring into every direction: for each moment, the factor that stands
/// beside w or ΦH. One array a moment, so that every sum is a plain dot product.
struct Terms {
    flux: [Vec<CurveRow>; 3],
    /// Without `EMISSION`, whose factor is 1.
    factors: Vec<Vec<CurveRow>>,
}

impl Terms {
    fn new(groups: &[SampleGroup], shift: [f32; 3]) -> Terms {
        let offsets: Vec<[RowLanes; 3]> = groups.iter().map(|group| moved(group, shift)).collect();
        let flux = [0, 1, 2].map(|axis| groups.iter().map(|g| CurveRow(g.flux[axis])).collect());
        let product = |places: &[usize]| -> Vec<CurveRow> {
            let at = |d: &[RowLanes; 3], i: usize| places.iter().map(|axis| d[*axis][i]).product();
            offsets.iter().map(|d| CurveRow(std::array::from_fn(|i| at(d, i)))).collect()
        };
        let mut factors = vec![Vec::new(); MOMENTS];
        for axis in 0..3 {
            factors[MEAN + axis] = product(&[axis]);
            factors[GRADIENT + axis] = groups.iter().map(|g| CurveRow(g.flux[axis])).collect();
        }
        for (i, (a, b)) in PAIRS.into_iter().enumerate() {
            factors[SPREAD + i] = product(&[a, b]);
        }
        for (i, (a, b, c)) in TRIPLES.into_iter().enumerate() {
            factors[SKEW + i] = product(&[a, b, c]);
        }
        let lit = groups.iter().zip(&offsets).map(|(group, d)| lit_factors(group, d));
        for [parallax, squared, flux] in lit {
            factors[PARALLAX].push(CurveRow(parallax));
            factors[PARALLAX2].push(CurveRow(squared));
            factors[LIT].push(CurveRow(flux));
        }
        Terms { flux, factors }
    }
}

/// Places relative to the cell's center.
fn moved(group: &SampleGroup, shift: [f32; 3]) -> [RowLanes; 3] {
    std::array::from_fn(|axis| group.offset[axis].map(|v| v + shift[axis]))
}

/// Φ τ, Φ τ², Φ.
fn lit_factors(group: &SampleGroup, offset: &[RowLanes; 3]) -> [RowLanes; 3] {
    let mut factors = [[0.0; LANES]; 3];
    for i in 0..LANES {
        let q: [f32; 3] = std::array::from_fn(|axis| group.flux[axis][i]);
        let flux = (q[0] * q[0] + q[1] * q[1] + q[2] * q[2]).sqrt();
        let parallax = offset[0][i] * q[0] + offset[1][i] * q[1] + offset[2][i] * q[2];
        let squared = if flux > 0.0 { parallax * (parallax / flux) } else { 0.0 };
        for (factor, value) in factors.iter_mut().zip([parallax, squared, flux]) {
            factor[i] = value;
        }
    }
    factors
}

fn add_block(terms: &Terms, vertices: &[[f32; 3]], sums: &mut [[f64; MOMENTS]]) {
    widest!(kernel(terms: &Terms, vertices: &[[f32; 3]], sums: &mut [[f64; MOMENTS]]));
}

const GROUPS: usize = BLOCK_CAPACITY / LANES;

#[inline(always)]
fn kernel(terms: &Terms, vertices: &[[f32; 3]], sums: &mut [[f64; MOMENTS]]) {
    let count = terms.flux[0].len().min(GROUPS);
    let [qx, qy, qz] = &terms.flux;
    let (qx, qy, qz) = (&qx[..count], &qy[..count], &qz[..count]);
    let mut weight = [CurveRow([0.0; LANES]); GROUPS];
    let flux = &terms.factors[LIT][..count];
    let mut wide = [CurveRow([0.0; LANES]); GROUPS];
    let mut lit = [CurveRow([0.0; LANES]); GROUPS];
    for (x, sums) in vertices.iter().zip(sums) {
        let mut emission = [0.0f32; LANES];
        let turned_away = -WIDE * (x[0] * x[0] + x[1] * x[1] + x[2] * x[2]).sqrt();
        for g in 0..count {
            for (i, emission) in emission.iter_mut().enumerate() {
                let toward = x[0] * qx[g].0[i] + x[1] * qy[g].0[i] + x[2] * qz[g].0[i];
                weight[g].0[i] = if toward > 0.0 { toward } else { 0.0 };
                lit[g].0[i] = if toward > 0.0 { 1.0 } else { 0.0 };
                wide[g].0[i] = if toward > turned_away * flux[g].0[i] { 1.0 } else { 0.0 };
                *emission += weight[g].0[i];
            }
        }
        sums[EMISSION] += f64::from(fold(&emission));
        let (weight, lit, wide) = (&weight[..count], &lit[..count], &wide[..count]);
        add_dots::<9>(weight, &terms.factors[MEAN..], &mut sums[MEAN..]);
        add_dots::<4>(lit, &terms.factors[GRADIENT..], &mut sums[GRADIENT..]);
        add_dots::<2>(wide, &terms.factors[PARALLAX2..], &mut sums[PARALLAX2..]);
        add_dots::<10>(weight, &terms.factors[SKEW..], &mut sums[SKEW..]);
    }
}

/// The first `COUNT` moments' dot products, together so that the weights are read once.
#[inline(always)]
fn add_dots<const COUNT: usize>(weights: &[CurveRow], factors: &[Vec<CurveRow>], sums: &mut [f64]) {
    let mut lanes = [[0.0f32; LANES]; COUNT];
    let mut rows = [&weights[..0]; COUNT];
    for (row, factors) in rows.iter_mut().zip(factors) {
        *row = &factors[..weights.len()];
    }
    for (g, CurveRow(w)) in weights.iter().enumerate() {
        for (sums, row) in lanes.iter_mut().zip(&rows) {
            for i in 0..LANES {
                sums[i] += w[i] * row[g].0[i];
            }
        }
    }
    for (sum, lanes) in sums.iter_mut().zip(&lanes) {
        *sum += f64::from(fold(lanes));
    }
}

/// Pairwise, so that it takes four steps.
#[inline(always)]
fn fold(lanes: &RowLanes) -> f32 {
    let mut sums = *lanes;
    for half in [8, 4, 2, 1] {
        for i in 0..half {
            sums[i] += sums[i + half];
        }
    }
    sums[0]
}
