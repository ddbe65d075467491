//! Which points of surfaces are too near to each other, and in which direction they part.
//!
//! Vertices against triangles say most. Surfaces can still cross where an edge cuts an edge while all
//! vertices are outside: for each pair of triangles that was found crossing, the axis along which
//! the two overlap least (of those along which both part outwards) gives one more contact.

use std::collections::{BTreeMap, BTreeSet};

use rayon::prelude::*;

use super::escape::{Shared, escape_directions};
use super::overlap::crossings;
use super::scene::{Body, Skin, near_pairs, surface_point};
use crate::fem::MaterialPoint;
use crate::locate::closest_on_triangle;
use crate::math::Vec3;
use crate::mesh::adjacency::Lists;

/// A vertex leaves through triangles whose normals lie within this cosine of its escape direction.
const FACING: f64 = 0.5;

/// A pair of triangles that crossed and no longer does counts down to this share of the margin inside.
const NEARLY_OUT: f64 = 0.3;

/// Distance of two points along a fixed normal; at least one of them moves.
pub(super) struct Contact {
    /// Vertices of the whole scene with their weights: the first point minus the second.
    pub weights: Vec<(u32, f64)>,
    /// Direction in which the first point leaves the second.
    pub normal: Vec3,
    /// What points that do not move add to the distance.
    pub constant: f64,
    /// Distance when it was found; below 0 inside.
    pub distance: f64,
}

impl Contact {
    /// Distance along the normal in the shape `x`.
    pub fn distance_at(&self, x: &[Vec3]) -> f64 {
        let apart: Vec3 = self.weights.iter().map(|&(v, w)| x[v as usize] * w).sum();
        self.normal.dot(&apart) + self.constant
    }
}

/// What one look at all surfaces found.
pub(super) struct Found {
    pub contacts: Vec<Contact>,
    /// Tet vertices of each body at its overlaps.
    pub seeds: Vec<Vec<u32>>,
}

impl Found {
    /// Sum of the depths of all contacts that overlap.
    pub fn overlap(&self) -> f64 {
        self.contacts.iter().map(|c| (-c.distance).max(0.0)).sum()
    }

    /// Whether nothing overlaps.
    pub fn is_clear(&self) -> bool {
        self.seeds.iter().all(Vec::is_empty)
    }
}

/// What is kept from look to look.
#[derive(Default)]
pub(super) struct Memory {
    /// Pairs of triangles that were found crossing.
    crossed: BTreeSet<TrianglePair>,
    /// What the first surface shares with the second, since their overlap was first seen.
    shared: BTreeMap<(usize, usize), Shared>,
}

/// Triangle `.1` of surface `.0` against triangle `.3` of surface `.2`.
type TrianglePair = (usize, u32, usize, u32);

/// A point of a surface.
struct Place {
    skin: usize,
    triangle: u32,
    barycentric: [f64; 3],
}

/// Looks at bodies whose tet vertices begin at `first_vertex` of the whole scene.
pub(super) struct Detector<'a> {
    pub bodies: &'a [Body],
    pub first_vertex: &'a [u32],
    /// Neighbours of each vertex of each surface.
    pub graphs: &'a [Lists],
    /// Points nearer than this are contacts.
    pub margin: f64,
}

impl Detector<'_> {
    /// Finds all contacts.
    pub fn look(&self, skins: &[Skin], memory: &mut Memory) -> Found {
        let mut found = Found { contacts: Vec::new(), seeds: vec![Vec::new(); self.bodies.len()] };
        let mut crossing = BTreeSet::new();
        for (i, j) in near_pairs(skins, self.margin) {
            let inside =
                [vertices_inside(&skins[i], &skins[j]), vertices_inside(&skins[j], &skins[i])];
            for (s, o, own, others) in [(i, j, 0, 1), (j, i, 1, 0)] {
                let marks = (&inside[own][..], &inside[others][..]);
                if !inside.iter().flatten().any(|&is_inside| is_inside) {
                    memory.shared.remove(&(s, o));
                }
                let shared = memory
                    .shared
                    .entry((s, o))
                    .or_insert_with(|| Shared::new(&skins[s], &skins[o], marks));
                self.vertices(skins, (s, o), marks.0, shared, &mut found);
            }
            for (t, u) in crossings(&skins[i], &skins[j]) {
                crossing.insert((i, t, j, u));
                self.seed(skins, i, t, &mut found);
                self.seed(skins, j, u, &mut found);
            }
        }
        memory.crossed.extend(&crossing);
        for pair in &memory.crossed {
            let &(i, t, j, u) = pair;
            // A pair that no longer crosses lies apart, along some axis. Where that is far from the way
            // outwards (walls behind each other, say), it would draw walls through each other; there the
            // vertices know the way. Near it, the pair would cross again in the next round.
            let counts =
                |c: &Contact| crossing.contains(pair) || c.distance > -NEARLY_OUT * self.margin;
            let contact = self.triangles(skins, (i, t), (j, u));
            found.contacts.extend(contact.filter(|c| c.distance < self.margin && counts(c)));
        }
        found
    }

    /// Vertices of surface `s`, of which `inside` marks those in `o`, against the triangles of `o`.
    fn vertices(
        &self,
        skins: &[Skin],
        (s, o): (usize, usize),
        inside: &[bool],
        shared: &Shared,
        found: &mut Found,
    ) {
        let (skin, other) = (&skins[s], &skins[o]);
        let first_triangle = first_triangles(skin);
        let ways = escape_directions(skin, other, inside, shared, &self.graphs[s]);
        let hits: Vec<_> = (0..skin.points.len())
            .into_par_iter()
            .with_min_len(64)
            .filter(|&v| first_triangle[v] != u32::MAX)
            .filter_map(|v| {
                let way = inside[v].then_some(&ways[v]);
                self.vertex(&skin.points[v], other, way).map(|hit| (v, hit))
            })
            .collect();
        for (v, (triangle, barycentric, normal, distance)) in hits {
            let t = first_triangle[v];
            if distance < 0.0 {
                self.seed(skins, s, t, found);
                self.seed(skins, o, triangle, found);
            }
            let corner = skin.triangles[t as usize].map(|w| f64::from(u8::from(w as usize == v)));
            let from = Place { skin: s, triangle: t, barycentric: corner };
            let to = Place { skin: o, triangle, barycentric };
            found.contacts.push(self.contact(skins, &from, &to, normal));
        }
    }

    /// Triangle, place in it, normal and signed distance of what the vertex at `p` is in contact
    /// with; `way`: the escape direction of a vertex inside.
    fn vertex(
        &self,
        p: &Vec3,
        other: &Skin,
        way: Option<&Vec3>,
    ) -> Option<(u32, [f64; 3], Vec3, f64)> {
        if !other.solid.box_holds(p, self.margin) {
            return None;
        }
        let is_inside = way.is_some();
        let hit = match way {
            Some(way) => {
                let facing = other.solid.closest.closest_against(p, &-way, FACING);
                facing.or_else(|| other.solid.closest.closest(p))?
            }
            None => other.solid.closest.closest_within(p, self.margin)?,
        };
        let outwards = if is_inside { hit.position - p } else { p - hit.position };
        // On the surface itself the direction is lost to rounding.
        let normal = if hit.distance > 1e-6 * self.margin {
            outwards / hit.distance
        } else {
            other.normal(hit.triangle)
        };
        let distance = if is_inside { -hit.distance } else { hit.distance };
        Some((hit.triangle, hit.barycentric, normal, distance))
    }

    /// Two triangles: the axis of least overlap, of those along which both part outwards.
    fn triangles(&self, skins: &[Skin], a: (usize, u32), b: (usize, u32)) -> Option<Contact> {
        let (p, q) = (skins[a.0].corners(a.1), skins[b.0].corners(b.1));
        let (n, m) = (skins[a.0].normal(a.1), skins[b.0].normal(b.1));
        let apart = m - n;
        let edges = |c: &[Vec3; 3]| [c[1] - c[0], c[2] - c[1], c[0] - c[2]];
        let across = edges(&p)
            .into_iter()
            .flat_map(|e| edges(&q).map(|f| e.cross(&f).try_normalize(1e-9).unwrap_or_default()));
        let separation = |axis: &Vec3| {
            let least = p.iter().map(|x| x.dot(axis)).fold(f64::INFINITY, f64::min);
            least - q.iter().map(|x| x.dot(axis)).fold(f64::NEG_INFINITY, f64::max)
        };
        let (axis, _) = [-n, m]
            .into_iter()
            .chain(across)
            .filter(|axis| *axis != Vec3::zeros())
            .map(|axis| if axis.dot(&apart) < 0.0 { -axis } else { axis })
            .map(|axis| (axis, separation(&axis)))
            .max_by(|x, y| x.1.total_cmp(&y.1))?;
        // The corners that stick out farthest, and the points of both triangles nearest to each
        // other among them.
        let (from, to) = nearest_features(&extreme(&p, &-axis), &extreme(&q, &axis), &p, &q);
        let from = Place { skin: a.0, triangle: a.1, barycentric: from };
        let to = Place { skin: b.0, triangle: b.1, barycentric: to };
        Some(self.contact(skins, &from, &to, axis))
    }

    fn contact(&self, skins: &[Skin], from: &Place, to: &Place, normal: Vec3) -> Contact {
        let mut weights: Vec<(u32, f64)> = Vec::with_capacity(8);
        let mut constant = 0.0;
        let mut distance = 0.0;
        for (place, sign) in [(from, 1.0), (to, -1.0)] {
            let corners = skins[place.skin].corners(place.triangle);
            let position: Vec3 = (0..3).map(|k| corners[k] * place.barycentric[k]).sum();
            distance += sign * normal.dot(&position);
            match skins[place.skin].body {
                Some(b) => {
                    let MaterialPoint(entries) =
                        surface_point(&self.bodies[b], place.triangle, &place.barycentric);
                    let first = self.first_vertex[b];
                    weights.extend(entries.into_iter().map(|(v, w)| (first + v, sign * w)));
                }
                None => constant += sign * normal.dot(&position),
            }
        }
        Contact { weights, normal, constant, distance }
    }

    /// Frees the neighbourhood of a triangle.
    fn seed(&self, skins: &[Skin], s: usize, triangle: u32, found: &mut Found) {
        if let Some(b) = skins[s].body {
            let corners = skins[s].triangles[triangle as usize];
            let embedding = &self.bodies[b].embedding;
            found.seeds[b].extend(corners.iter().flat_map(|&v| embedding.vertices[v as usize]));
        }
    }
}

/// Which vertices of `skin` lie inside `other`.
fn vertices_inside(skin: &Skin, other: &Skin) -> Vec<bool> {
    let first_triangle = first_triangles(skin);
    (0..skin.points.len())
        .into_par_iter()
        .with_min_len(64)
        .map(|v| first_triangle[v] != u32::MAX && other.solid.holds(&skin.points[v]))
        .collect()
}

/// A triangle of each vertex; `u32::MAX` without one.
fn first_triangles(skin: &Skin) -> Vec<u32> {
    let mut first = vec![u32::MAX; skin.points.len()];
    for (t, triangle) in skin.triangles.iter().enumerate().rev() {
        for &v in triangle {
            first[v as usize] = t as u32;
        }
    }
    first
}

/// Corners that reach farthest along an axis, to rounding.
fn extreme(corners: &[Vec3; 3], axis: &Vec3) -> Vec<usize> {
    let along = corners.map(|p| p.dot(axis));
    let most = along.into_iter().fold(f64::NEG_INFINITY, f64::max);
    let size = (corners[1] - corners[0]).norm() + (corners[2] - corners[0]).norm();
    (0..3).filter(|&k| along[k] >= most - 1e-9 * size).collect()
}

/// Barycentric coordinates of the nearest points of two corners, edges or triangles.
fn nearest_features(
    a: &[usize],
    b: &[usize],
    p: &[Vec3; 3],
    q: &[Vec3; 3],
) -> ([f64; 3], [f64; 3]) {
    let corner = |k: usize| [0, 1, 2].map(|i| f64::from(u8::from(i == k)));
    if let [k] = a {
        return (corner(*k), closest_on_triangle(&p[*k], q));
    }
    if let [k] = b {
        return (closest_on_triangle(&q[*k], p), corner(*k));
    }
    // Two edges: the points where their lines are nearest.
    let (i, j, k, l) = (a[0], a[1], b[0], b[1]);
    let (d, e, r) = (p[j] - p[i], q[l] - q[k], p[i] - q[k]);
    let (dd, ee, de) = (d.norm_squared(), e.norm_squared(), d.dot(&e));
    let below = dd * ee - de * de;
    let s = if below > 1e-12 * dd * ee {
        ((de * e.dot(&r) - ee * d.dot(&r)) / below).clamp(0.0, 1.0)
    } else {
        0.5
    };
    let t = ((e.dot(&r) + s * de) / ee).clamp(0.0, 1.0);
    let on = |from: usize, to: usize, share: f64| {
        let mut weights = [0.0; 3];
        weights[from] = 1.0 - share;
        weights[to] = share;
        weights
    };
    (on(i, j, s), on(k, l, t))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::TetMesh;
    use crate::mesh::adjacency::vertex_neighbours;

    #[test]
    fn triangles_that_crossed_on_the_way_in_push_nothing_once_inside() {
        let tet = |name: &str, size: f64, at: Vec3| {
            let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            let points = corners.map(|c| Vec3::from(c) * size + at).to_vec();
            Body::from_tets(name, TetMesh::new(points, vec![[0, 1, 2, 3]]).unwrap()).unwrap()
        };
        let large = tet("large", 10.0, Vec3::zeros());
        // Halfway through the large one's wall at z = 0, and wholly inside.
        let [crossing, inside] = [-0.3, 1.0].map(|z| tet("small", 1.0, Vec3::new(1.0, 1.0, z)));
        let bodies = [large, crossing];
        let graphs: Vec<Lists> =
            bodies.iter().map(|b| vertex_neighbours(4, &b.triangles)).collect();
        let detector =
            Detector { bodies: &bodies, first_vertex: &[0, 4], graphs: &graphs, margin: 0.1 };
        let skins_at = |points: &[Vec3]| {
            Skin::all(&bodies, &[bodies[0].tets.points.clone(), points.to_vec()], &[])
        };
        let mut memory = Memory::default();
        detector.look(&skins_at(&bodies[1].tets.points), &mut memory);
        assert!(!memory.crossed.is_empty());
        let arrived = detector.look(&skins_at(&inside.tets.points), &mut memory);
        // The four vertices of the small one, and nothing else, ask to be let out.
        let deep = arrived.contacts.iter().filter(|c| c.distance < 0.0).count();
        assert_eq!(deep, 4);
    }

    #[test]
    fn two_edges_that_cut_each_other_are_pushed_apart_where_they_cross() {
        // A ridge along x below, a ridge along y above, 0.2 too deep.
        let below = vec![[-1.0, 0.0, 0.2], [1.0, 0.0, 0.2], [0.0, 1.0, -1.0], [0.0, -1.0, -1.0]];
        let above = vec![[0.0, -1.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 1.0], [-1.0, 0.0, 1.0]];
        let vectors = |list: Vec<[f64; 3]>| list.into_iter().map(Vec3::from).collect::<Vec<_>>();
        let (lower, upper) = ([[0_u32, 1, 2], [1, 0, 3]], [[0_u32, 1, 2], [1, 0, 3]]);
        let skins =
            [Skin::new(vectors(below), &lower, None), Skin::new(vectors(above), &upper, None)];
        assert!(skins[0].normal(0).z > 0.0 && skins[1].normal(0).z < 0.0);
        let detector = Detector { bodies: &[], first_vertex: &[], graphs: &[], margin: 1.0 };
        let contact = detector.triangles(&skins, (0, 0), (1, 0)).unwrap();
        assert!((contact.distance + 0.2).abs() < 1e-12, "{}", contact.distance);
        assert!((contact.normal + Vec3::z()).norm() < 1e-12, "{}", contact.normal);
    }
}
