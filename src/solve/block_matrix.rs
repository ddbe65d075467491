//! Symmetric sparse matrices of B x B blocks on a vertex graph, lower triangle by columns.

use nalgebra::SMatrix;
use rayon::prelude::*;

use crate::math::Vec3;

use super::ordering::nested_dissection;

/// Rows and columns of a block of tets at most.
const MAX_BLOCK: usize = 3;

/// Where the blocks of a symmetric matrix on the vertices of a tet mesh stand.
#[derive(Clone, Debug)]
pub struct BlockPattern {
    /// Rows and columns of a block.
    pub block: usize,
    /// For each vertex the higher-numbered vertices it is coupled with, ascending.
    pub higher: Vec<Vec<u32>>,
    /// For each scalar column the start of its entries; one more at the end.
    pub col_ptr: Vec<usize>,
    /// Scalar row of each entry, ascending in a column, first the diagonal.
    pub row_idx: Vec<usize>,
    /// Elimination order of the scalar rows, unless it is their own.
    pub order: Option<Vec<usize>>,
    /// For each block column its blocks' contributions: first in `sources`.
    source_ptr: Vec<Vec<u32>>,
    /// For each vertex and each of its blocks (diagonal first): element * 16 + 4 a + b.
    sources: Vec<Vec<u64>>,
}

/// The entries of a symmetric block matrix.
#[derive(Clone, Debug)]
pub struct BlockMatrix {
    /// One value per entry of the pattern.
    pub values: Vec<f64>,
}

impl BlockPattern {
    /// The pattern of matrices that couple the four vertices of each tet, in blocks of `block`.
    /// Vertices are eliminated by number: number the mesh by [`super::nested_dissection`] first.
    pub fn of_tets(n: usize, tets: &[[u32; 4]], block: usize) -> Self {
        let mut pairs: Vec<(u32, u32, u64)> = Vec::with_capacity(10 * tets.len());
        for (t, tet) in tets.iter().enumerate() {
            for a in 0..4 {
                for b in 0..4 {
                    if tet[a] >= tet[b] {
                        pairs.push((tet[b], tet[a], (t as u64) << 4 | (4 * a + b) as u64));
                    }
                }
            }
        }
        pairs.par_sort_unstable();
        let mut higher = vec![Vec::new(); n];
        let mut source_ptr = vec![vec![0]; n];
        let mut sources = vec![Vec::new(); n];
        for v in 0..n as u32 {
            let start = pairs.partition_point(|p| p.0 < v);
            let column = pairs[start..].iter().take_while(|p| p.0 == v);
            let mut last = v;
            for &(_, row, source) in column {
                if row != last {
                    source_ptr[v as usize].push(sources[v as usize].len() as u32);
                    higher[v as usize].push(row);
                    last = row;
                }
                sources[v as usize].push(source);
            }
            let end = sources[v as usize].len() as u32;
            source_ptr[v as usize].push(end);
        }
        Self::build(higher, source_ptr, sources, block, None)
    }

    /// The pattern of matrices that couple the linked nodes at `points`, in blocks of `block`;
    /// entries are set by hand.
    pub fn of_links(points: &[Vec3], links: &[(u32, u32)], block: usize) -> Self {
        let mut higher = vec![Vec::new(); points.len()];
        for &(a, b) in links {
            higher[a.min(b) as usize].push(a.max(b));
        }
        for row in &mut higher {
            row.sort_unstable();
            row.dedup();
        }
        let graph = symmetric_graph(&higher);
        let order = expand(&nested_dissection(points, |v| &graph[v]), block);
        Self::build(higher, Vec::new(), Vec::new(), block, Some(order))
    }

    fn build(
        higher: Vec<Vec<u32>>,
        source_ptr: Vec<Vec<u32>>,
        sources: Vec<Vec<u64>>,
        block: usize,
        order: Option<Vec<usize>>,
    ) -> Self {
        let (col_ptr, row_idx) = scalar_pattern(&higher, block);
        Self { block, higher, col_ptr, row_idx, order, source_ptr, sources }
    }

    /// Number of scalar rows.
    pub fn size(&self) -> usize {
        self.col_ptr.len() - 1
    }

    /// Sums element matrices: `element(t, a, b)[r][c]` couples row r of corner a with column c of
    /// corner b. Each block is gathered in element order, so the bits do not depend on threads.
    pub fn assemble(
        &self,
        element: impl Fn(usize, usize, usize, usize, usize) -> f64 + Sync,
    ) -> BlockMatrix {
        let mut values = vec![0.0; self.row_idx.len()];
        self.columns(&mut values).into_par_iter().enumerate().for_each(|(v, column)| {
            for k in 0..self.source_ptr[v].len() - 1 {
                let range = self.source_ptr[v][k] as usize..self.source_ptr[v][k + 1] as usize;
                let mut sums = [[0.0; MAX_BLOCK]; MAX_BLOCK];
                for &source in &self.sources[v][range] {
                    let (t, a, b) =
                        ((source >> 4) as usize, (source >> 2 & 3) as usize, (source & 3) as usize);
                    for (c, sums) in sums.iter_mut().enumerate().take(self.block) {
                        for (r, sum) in sums.iter_mut().enumerate().take(self.block) {
                            *sum += element(t, a, b, r, c);
                        }
                    }
                }
                for (c, sums) in sums.iter().enumerate().take(self.block) {
                    let first = if k == 0 { c } else { 0 };
                    let start = self.offset(v, k, first, c);
                    column[start..start + self.block - first]
                        .copy_from_slice(&sums[first..self.block]);
                }
            }
        });
        BlockMatrix { values }
    }

    /// Index of entry (r, c) of the block (i, j) in the values; i >= j must be coupled.
    pub fn entry(&self, i: u32, j: u32, r: usize, c: usize) -> usize {
        let k = if i == j {
            0
        } else {
            1 + self.higher[j as usize].binary_search(&i).expect("the two vertices share a tet")
        };
        self.col_ptr[self.block * j as usize] + self.offset(j as usize, k, r, c)
    }

    /// Adds to block (i, j), i >= j; of a block on the diagonal the lower triangle is read.
    pub fn add<const B: usize>(
        &self,
        matrix: &mut BlockMatrix,
        [i, j]: [usize; 2],
        block: &SMatrix<f64, B, B>,
    ) {
        for column in 0..B {
            for row in if i == j { column } else { 0 }..B {
                matrix.values[self.entry(i as u32, j as u32, row, column)] += block[(row, column)];
            }
        }
    }

    /// Offset inside the values of vertex v's columns of entry (r, c) of its k-th block.
    fn offset(&self, v: usize, k: usize, r: usize, c: usize) -> usize {
        let start = self.col_ptr[self.block * v + c] - self.col_ptr[self.block * v];
        if k == 0 { start + r - c } else { start + (self.block - c) + self.block * (k - 1) + r }
    }

    /// The values of each vertex' columns.
    fn columns<'a>(&self, mut values: &'a mut [f64]) -> Vec<&'a mut [f64]> {
        let mut parts = Vec::with_capacity(self.higher.len());
        for v in 0..self.higher.len() {
            let length = self.col_ptr[self.block * (v + 1)] - self.col_ptr[self.block * v];
            let (part, rest) = values.split_at_mut(length);
            parts.push(part);
            values = rest;
        }
        parts
    }

    /// Mean of the diagonal.
    pub fn mean_diagonal(&self, matrix: &BlockMatrix) -> f64 {
        let n = self.size();
        self.col_ptr[..n].iter().map(|&p| matrix.values[p]).sum::<f64>() / n as f64
    }

    /// Adds a number to the whole diagonal.
    pub fn shift_diagonal(&self, matrix: &mut BlockMatrix, shift: f64) {
        for &p in &self.col_ptr[..self.size()] {
            matrix.values[p] += shift;
        }
    }

    /// y = A x.
    pub fn multiply(&self, matrix: &BlockMatrix, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; self.size()];
        let mut values = &matrix.values[..];
        for (v, higher) in self.higher.iter().enumerate() {
            for c in 0..self.block {
                let column = self.block * v + c;
                let (diagonal, rest) = values.split_at(self.block - c);
                let (below, next) = rest.split_at(self.block * higher.len());
                values = next;
                let mut sum = diagonal[0] * x[column];
                for (r, value) in (column + 1..).zip(&diagonal[1..]) {
                    y[r] += value * x[column];
                    sum += value * x[r];
                }
                for (&w, entries) in higher.iter().zip(below.chunks_exact(self.block)) {
                    let rows = self.block * w as usize..self.block * (w as usize + 1);
                    for ((y, x_row), value) in y[rows.clone()].iter_mut().zip(&x[rows]).zip(entries)
                    {
                        *y += value * x[column];
                        sum += value * x_row;
                    }
                }
                y[column] += sum;
            }
        }
        y
    }
}

/// Neighbours in both directions.
fn symmetric_graph(higher: &[Vec<u32>]) -> Vec<Vec<u32>> {
    let mut graph = higher.to_vec();
    for (v, neighbours) in higher.iter().enumerate() {
        for &w in neighbours {
            graph[w as usize].push(v as u32);
        }
    }
    graph
}

fn expand(order: &[usize], block: usize) -> Vec<usize> {
    order.iter().flat_map(|&v| (0..block).map(move |c| block * v + c)).collect()
}

fn scalar_pattern(higher: &[Vec<u32>], block: usize) -> (Vec<usize>, Vec<usize>) {
    let (mut col_ptr, mut row_idx) = (vec![0], Vec::new());
    for (v, neighbours) in higher.iter().enumerate() {
        for c in 0..block {
            row_idx.extend((c..block).map(|r| block * v + r));
            for &w in neighbours {
                row_idx.extend((0..block).map(|r| block * w as usize + r));
            }
            col_ptr.push(row_idx.len());
        }
    }
    (col_ptr, row_idx)
}
