//! Which tets of a lattice are kept.

use std::collections::{HashMap, HashSet};

use rayon::prelude::*;

use super::cells::LatticeTet;
use super::overlap::triangle_overlaps_tet;
use crate::locate::WindingNumber;
use crate::math::Vec3;
use crate::mesh::adjacency::{DisjointSets, components};
use crate::mesh::{TriMesh, bounding_box};

/// Rounds of adding neighbours to loose tets; each round widens them by one tet.
const JOIN_ROUNDS: usize = 8;
/// Triangles are split until they are no longer than this, in cells.
const MAX_PART: f64 = 4.0;

/// Where the lattice stands.
#[derive(Clone, Copy, Debug)]
pub struct Grid {
    /// Position of the lattice's origin.
    pub origin: Vec3,
    /// Edge of a cube.
    pub edge: f64,
}

impl Grid {
    /// A lattice with a cube's centre in the middle of the surface's box, so that the same surface
    /// always gets the same lattice, wherever it stands.
    pub fn around(surface: &TriMesh, edge: f64) -> Self {
        let (low, high) = bounding_box(&surface.points).unwrap_or_default();
        Self { origin: (low + high) / 2.0 - Vec3::repeat(edge / 2.0), edge }
    }

    /// From space to cell edges.
    pub fn point_in_cells(&self, p: &Vec3) -> Vec3 {
        (p - self.origin) / self.edge
    }

    /// From cell edges to space.
    pub fn point_in_space(&self, p: &Vec3) -> Vec3 {
        p * self.edge + self.origin
    }

    /// Four corners at once.
    pub fn in_space(&self, corners: &[Vec3; 4]) -> [Vec3; 4] {
        corners.map(|p| self.point_in_space(&p))
    }
}

/// The kept tets, with parallel lists of what is known about each.
pub struct Selection {
    pub grid: Grid,
    pub tets: Vec<LatticeTet>,
    /// Share of each tet that is inside the surface.
    pub fraction: Vec<f64>,
    /// Number of separate inside pieces in each tet.
    pub pieces: Vec<usize>,
    /// The tet of each vertex that a triangle uses, as an index into `tets`.
    pub tet_of_vertex: Vec<Option<u32>>,
    /// Which connected parts of the surface meet which tets.
    parts: Vec<(LatticeTet, u32)>,
    index: HashMap<LatticeTet, u32>,
}

impl Selection {
    /// The tets that the surface cuts, and those that hold its vertices.
    pub fn cut_by(surface: &TriMesh, grid: Grid) -> Self {
        let points: Vec<Vec3> = surface.points.iter().map(|p| grid.point_in_cells(p)).collect();
        let mut used = vec![false; points.len()];
        surface.triangles.iter().flatten().for_each(|&v| used[v as usize] = true);
        let home: Vec<Option<LatticeTet>> =
            points.iter().zip(&used).map(|(p, &u)| u.then(|| LatticeTet::at(p))).collect();
        let part = components(points.len(), &surface.triangles);
        let mut parts: Vec<(LatticeTet, u32)> = surface
            .triangles
            .par_iter()
            .zip(&part)
            .flat_map_iter(|(t, &part)| {
                tets_cut_by(&t.map(|v| points[v as usize])).into_iter().map(move |tet| (tet, part))
            })
            .collect();
        for (triangle, &part) in surface.triangles.iter().zip(&part) {
            parts.extend(triangle.iter().filter_map(|&v| home[v as usize]).map(|t| (t, part)));
        }
        parts.par_sort_unstable();
        parts.dedup();
        let mut tets: Vec<LatticeTet> = parts.iter().map(|(tet, _)| *tet).collect();
        tets.dedup();
        let index = index_of(&tets);
        let tet_of_vertex = home.iter().map(|tet| tet.map(|t| index[&t])).collect();
        let (fraction, pieces) = (vec![0.0; tets.len()], vec![0; tets.len()]);
        Self { grid, tets, fraction, pieces, tet_of_vertex, parts, index }
    }

    /// Whether each tet holds a vertex of the surface.
    pub fn holds_vertex(&self) -> Vec<bool> {
        let mut holds = vec![false; self.tets.len()];
        self.tet_of_vertex.iter().flatten().for_each(|&t| holds[t as usize] = true);
        holds
    }

    /// Takes the measured inside fractions and pieces and drops the tets that are not `wanted`;
    /// those that hold a vertex must be.
    pub fn keep(&mut self, measured: Vec<(f64, usize)>, wanted: impl Fn(usize, f64) -> bool) {
        let old = std::mem::take(&mut self.tets);
        self.fraction.clear();
        self.pieces.clear();
        for (i, (tet, (fraction, pieces))) in old.iter().zip(measured).enumerate() {
            if wanted(i, fraction) {
                self.tets.push(*tet);
                self.fraction.push(fraction);
                self.pieces.push(pieces);
            }
        }
        self.index = index_of(&self.tets);
        for home in self.tet_of_vertex.iter_mut().flatten() {
            *home = self.index[&old[*home as usize]];
        }
    }

    /// Adds all tets inside the surface that it does not cut, from the cut ones inwards.
    pub fn fill_inside(&mut self, winding: &WindingNumber) {
        let mut frontier = self.missing_neighbours(0..self.tets.len());
        let mut outside = HashSet::new();
        while !frontier.is_empty() {
            let inside: Vec<bool> = frontier
                .par_iter()
                .with_min_len(64)
                .map(|tet| winding.is_inside(&self.grid.point_in_space(&tet.centroid())))
                .collect();
            let first = self.tets.len();
            for (&tet, inside) in frontier.iter().zip(inside) {
                if inside {
                    self.push(tet, 1.0, 1);
                } else {
                    outside.insert(tet);
                }
            }
            frontier = self.missing_neighbours(first..self.tets.len());
            frontier.retain(|tet| !outside.contains(tet));
        }
    }

    /// Widens loose pieces, which hang on the rest by an edge or a vertex only, until each
    /// connected part of the surface is held by one piece connected through faces.
    pub fn join_pieces(&mut self) {
        for _ in 0..JOIN_ROUNDS {
            let loose = self.loose_tets();
            if loose.is_empty() {
                return;
            }
            for tet in self.missing_neighbours(loose.into_iter()) {
                self.push(tet, 0.0, 0);
            }
        }
    }

    /// The tets of all pieces but the largest of each part of the surface.
    fn loose_tets(&self) -> Vec<usize> {
        let mut sets = DisjointSets::new(self.tets.len());
        for (i, tet) in self.tets.iter().enumerate() {
            for j in (0..4).filter_map(|k| self.index.get(&tet.neighbour(k))) {
                sets.join(i as u32, *j);
            }
        }
        let roots: Vec<u32> = (0..self.tets.len() as u32).map(|i| sets.root(i)).collect();
        let mut size = vec![0_usize; self.tets.len()];
        for &root in &roots {
            size[root as usize] += 1;
        }
        // Largest piece of each part, the first one among equals.
        let mut largest: HashMap<u32, u32> = HashMap::new();
        let homes = || {
            let kept = |(tet, part): &(LatticeTet, u32)| Some((*part, *self.index.get(tet)?));
            self.parts.iter().filter_map(kept).map(|(part, i)| (part, roots[i as usize]))
        };
        for (part, root) in homes() {
            let best = largest.entry(part).or_insert(root);
            let key = |r: u32| (size[r as usize], std::cmp::Reverse(r));
            if key(root) > key(*best) {
                *best = root;
            }
        }
        let mut is_loose = vec![false; self.tets.len()];
        for (part, root) in homes() {
            is_loose[root as usize] |= largest[&part] != root;
        }
        (0..self.tets.len()).filter(|&i| is_loose[roots[i] as usize]).collect()
    }

    /// Tets that are not kept but share a face with one of these; each once, ascending.
    fn missing_neighbours(&self, of: impl Iterator<Item = usize>) -> Vec<LatticeTet> {
        let mut missing: Vec<LatticeTet> = of
            .flat_map(|i| (0..4).map(move |k| (i, k)))
            .map(|(i, k)| self.tets[i].neighbour(k))
            .filter(|tet| !self.index.contains_key(tet))
            .collect();
        missing.sort_unstable();
        missing.dedup();
        missing
    }

    fn push(&mut self, tet: LatticeTet, fraction: f64, pieces: usize) {
        self.index.insert(tet, self.tets.len() as u32);
        self.tets.push(tet);
        self.fraction.push(fraction);
        self.pieces.push(pieces);
    }
}

fn index_of(tets: &[LatticeTet]) -> HashMap<LatticeTet, u32> {
    tets.iter().enumerate().map(|(i, &tet)| (tet, i as u32)).collect()
}

/// The tets that overlap a triangle given in cell edges, ascending, each once.
fn tets_cut_by(triangle: &[Vec3; 3]) -> Vec<LatticeTet> {
    let mut found = Vec::new();
    let mut open = vec![*triangle];
    while let Some(part) = open.pop() {
        // The box of a long triangle holds many more cells than the triangle meets.
        let (low, high) = bounding_box(&part).unwrap_or_default();
        if (high - low).max() > MAX_PART {
            open.extend(halves(part));
        } else {
            add_tets_in_box(&part, &low, &high, &mut found);
        }
    }
    found.sort_unstable();
    found.dedup();
    found
}

/// A triangle cut at the middle of its longest edge.
fn halves([a, b, c]: [Vec3; 3]) -> [[Vec3; 3]; 2] {
    let turned = [[a, b, c], [b, c, a], [c, a, b]];
    let length = |t: &[Vec3; 3]| (t[1] - t[0]).norm_squared();
    let [a, b, c] = turned.into_iter().max_by(|s, t| length(s).total_cmp(&length(t))).expect("3");
    let middle = (a + b) / 2.0;
    [[a, middle, c], [middle, b, c]]
}

fn add_tets_in_box(triangle: &[Vec3; 3], low: &Vec3, high: &Vec3, found: &mut Vec<LatticeTet>) {
    let (low, high) = (low.map(|c| c.floor() as i32), high.map(|c| c.floor() as i32));
    let normal = (triangle[1] - triangle[0]).cross(&(triangle[2] - triangle[0]));
    // The tets of a cell reach to the centres of its neighbours.
    let reach = normal.abs().max().max(normal.abs().sum() / 2.0);
    for i in low.x..=high.x {
        for j in low.y..=high.y {
            for k in low.z..=high.z {
                let centre = Vec3::new(f64::from(i), f64::from(j), f64::from(k)).add_scalar(0.5);
                if normal.dot(&(centre - triangle[0])).abs() <= reach {
                    found.extend(
                        LatticeTet::of_cell([i, j, k])
                            .filter(|tet| triangle_overlaps_tet(triangle, &tet.corners())),
                    );
                }
            }
        }
    }
}
