//! What is wrong with a triangle surface, in words.

use std::collections::HashMap;
use std::fmt;

use super::TriMesh;
use crate::math::Vec3;

/// A triangle is without area below this share of the squared diagonal (rounding leaves less).
const ZERO_AREA: f64 = 1e-14;
/// So many examples are named in a finding.
const EXAMPLES: usize = 5;

/// One kind of fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// No triangles.
    Empty,
    /// Vertices at exactly the same place as an earlier one.
    DuplicateVertices,
    /// Vertices that no triangle uses.
    UnusedVertices,
    /// Triangles without area.
    ZeroAreaTriangles,
    /// Triangles with the same corners as an earlier one.
    DuplicateTriangles,
    /// Edges with one triangle: holes, or an open surface.
    BoundaryEdges,
    /// Edges with more than two triangles.
    NonManifoldEdges,
    /// Neighbours that disagree on what is outside.
    FlippedTriangles,
    /// All normals point inwards.
    InsideOut,
    /// Parts that are not connected.
    SeveralParts,
}

/// One fault with its extent; `Display` gives a sentence.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// What it is.
    pub fault: Fault,
    /// How many vertices, triangles, edges or parts have it.
    pub count: usize,
    /// The first of them: vertices, triangles, one vertex pair per edge, or a triangle per part.
    pub examples: Vec<Vec<u32>>,
}

/// Looks for all kinds of [`Fault`]. Vertices at the same place count as one for edges and parts,
/// because seams of texture coordinates are no holes.
pub fn check(mesh: &TriMesh) -> Vec<Finding> {
    if mesh.triangles.is_empty() {
        return vec![Finding { fault: Fault::Empty, count: 0, examples: Vec::new() }];
    }
    let place = places(&mesh.points);
    let welded: Vec<[u32; 3]> =
        mesh.triangles.iter().map(|t| t.map(|v| place[v as usize])).collect();
    let edges = edges(&welded);
    let by_count = |wanted: fn(usize) -> bool| {
        edges.iter().filter(move |(_, uses)| wanted(uses.len())).map(|(edge, _)| edge.to_vec())
    };
    let mut findings = Vec::new();
    let mut add = |fault: Fault, places: Vec<Vec<u32>>| {
        if !places.is_empty() {
            let examples = places.iter().take(EXAMPLES).cloned().collect();
            findings.push(Finding { fault, count: places.len(), examples });
        }
    };
    add(Fault::DuplicateVertices, numbers(&place, |v, &first| v != first));
    add(Fault::UnusedVertices, unused(mesh));
    add(Fault::ZeroAreaTriangles, zero_area(mesh));
    add(Fault::DuplicateTriangles, duplicate_triangles(&welded));
    add(Fault::BoundaryEdges, by_count(|uses| uses == 1).collect());
    add(Fault::NonManifoldEdges, by_count(|uses| uses > 2).collect());
    let (parts, flipped) = parts_and_flips(&welded, &edges);
    let closed = edges.iter().all(|(_, uses)| uses.len() == 2);
    if flipped.is_empty() && closed && mesh.volume() < 0.0 {
        add(Fault::InsideOut, numbers(&mesh.triangles, |_, _| true));
    }
    add(Fault::FlippedTriangles, flipped);
    if parts.len() > 1 {
        add(Fault::SeveralParts, parts);
    }
    findings
}

/// The indices of the items for which `wanted` holds.
fn numbers<T>(items: &[T], wanted: impl Fn(u32, &T) -> bool) -> Vec<Vec<u32>> {
    let numbered = items.iter().enumerate().map(|(i, item)| (i as u32, item));
    numbered.filter(|(i, item)| wanted(*i, item)).map(|(i, _)| vec![i]).collect()
}

/// For each vertex the first one at the same place.
fn places(points: &[Vec3]) -> Vec<u32> {
    let mut first = HashMap::with_capacity(points.len());
    let ids = 0..points.len() as u32;
    // Adding zero makes -0 and 0 the same bits.
    ids.zip(points)
        .map(|(v, p)| *first.entry([p.x, p.y, p.z].map(|c| (c + 0.0).to_bits())).or_insert(v))
        .collect()
}

fn unused(mesh: &TriMesh) -> Vec<Vec<u32>> {
    let mut used = vec![false; mesh.points.len()];
    for &v in mesh.triangles.iter().flatten() {
        used[v as usize] = true;
    }
    numbers(&used, |_, used| !used)
}

fn zero_area(mesh: &TriMesh) -> Vec<Vec<u32>> {
    let limit = ZERO_AREA * mesh.diagonal().powi(2);
    numbers(&mesh.triangles, |t, _| {
        let [a, b, c] = mesh.corners(t as usize);
        (b - a).cross(&(c - a)).norm() <= limit
    })
}

fn duplicate_triangles(welded: &[[u32; 3]]) -> Vec<Vec<u32>> {
    let mut seen = HashMap::with_capacity(welded.len());
    numbers(welded, |_, _| true)
        .into_iter()
        .zip(welded)
        .filter(|(number, corners)| {
            let mut key = **corners;
            key.sort_unstable();
            *seen.entry(key).or_insert(number[0]) != number[0]
        })
        .map(|(number, _)| number)
        .collect()
}

/// A triangle at an edge, and whether it runs along the edge from the lower vertex to the higher.
type Use = (u32, bool);

/// All edges by their vertices (lower first), in order of those, with their triangles.
fn edges(welded: &[[u32; 3]]) -> Vec<([u32; 2], Vec<Use>)> {
    let mut uses = Vec::with_capacity(3 * welded.len());
    for (t, &[a, b, c]) in welded.iter().enumerate() {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            if from != to {
                uses.push(([from.min(to), from.max(to)], (t as u32, from < to)));
            }
        }
    }
    uses.sort_unstable();
    uses.chunk_by(|a, b| a.0 == b.0)
        .map(|group| (group[0].0, group.iter().map(|(_, side)| *side).collect()))
        .collect()
}

/// One triangle of each part (connected over edges), and the triangles of each part that are
/// turned the other way than most of it.
fn parts_and_flips(
    welded: &[[u32; 3]],
    edges: &[([u32; 2], Vec<Use>)],
) -> (Vec<Vec<u32>>, Vec<Vec<u32>>) {
    let mut neighbours = vec![Vec::new(); welded.len()];
    for (_, uses) in edges {
        for pair in uses.windows(2) {
            let ((a, along_a), (b, along_b)) = (pair[0], pair[1]);
            // Over a fold of three or more triangles there is no right side.
            let differs = (uses.len() == 2).then_some(along_a == along_b);
            neighbours[a as usize].push((b, differs));
            neighbours[b as usize].push((a, differs));
        }
    }
    let mut turned: Vec<Option<bool>> = vec![None; welded.len()];
    let (mut parts, mut flipped) = (Vec::new(), Vec::new());
    for start in 0..welded.len() as u32 {
        if turned[start as usize].is_some() {
            continue;
        }
        parts.push(vec![start]);
        turned[start as usize] = Some(false);
        let mut members = vec![start];
        let mut next = 0;
        while let Some(&t) = members.get(next) {
            next += 1;
            let own = turned[t as usize] == Some(true);
            for &(neighbour, differs) in &neighbours[t as usize] {
                if turned[neighbour as usize].is_none() {
                    turned[neighbour as usize] = Some(own ^ differs.unwrap_or(false));
                    members.push(neighbour);
                }
            }
        }
        let count = members.iter().filter(|&&t| turned[t as usize] == Some(true)).count();
        let minority = 2 * count <= members.len();
        members.retain(|&t| turned[t as usize] == Some(minority));
        members.sort_unstable();
        flipped.extend(members.into_iter().map(|t| vec![t]));
    }
    (parts, flipped)
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (count, list) = (self.count, self.list());
        match self.fault {
            Fault::Empty => write!(f, "the surface has no triangles"),
            Fault::DuplicateVertices => write!(
                f,
                "{count} vertices lie exactly on an earlier one ({list}); merge them, unless they are a texture seam"
            ),
            Fault::UnusedVertices => {
                write!(f, "{count} vertices belong to no triangle ({list}); they will not move well, remove them")
            }
            Fault::ZeroAreaTriangles => {
                write!(f, "{count} triangles have no area ({list}); collapse or remove them")
            }
            Fault::DuplicateTriangles => {
                write!(f, "{count} triangles have the same corners as an earlier one ({list}); remove them")
            }
            Fault::BoundaryEdges => write!(
                f,
                "{count} edges have a triangle on one side only ({list}): the surface is open or has holes; close them for TetGen, the lattice bears them"
            ),
            Fault::NonManifoldEdges => write!(
                f,
                "{count} edges have more than two triangles ({list}); separate the sheets for TetGen, the lattice bears them"
            ),
            Fault::FlippedTriangles => write!(
                f,
                "{count} triangles are turned the other way than their neighbours ({list}); recalculate the normals"
            ),
            Fault::InsideOut => {
                write!(f, "the surface is inside out: all normals point inwards; flip them")
            }
            Fault::SeveralParts => write!(
                f,
                "the surface has {count} parts that are not connected (triangles {list} are one of each); only parts with markers near them will follow the person"
            ),
        }
    }
}

impl Finding {
    fn list(&self) -> String {
        let name = |ids: &Vec<u32>| ids.iter().map(u32::to_string).collect::<Vec<_>>().join("-");
        let names: Vec<String> = self.examples.iter().map(name).collect();
        let more = if self.count > names.len() { ", ..." } else { "" };
        format!("{}{more}", names.join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tetrahedron() -> TriMesh {
        let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let triangles = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        TriMesh::new(points.map(Vec3::from).to_vec(), triangles).unwrap()
    }

    fn found(change: impl Fn(&mut TriMesh)) -> Vec<(Fault, usize, String)> {
        let mut mesh = tetrahedron();
        change(&mut mesh);
        check(&mesh).iter().map(|f| (f.fault, f.count, f.to_string())).collect()
    }

    fn only(change: impl Fn(&mut TriMesh)) -> (Fault, usize, String) {
        let mut findings = found(change);
        assert_eq!(findings.len(), 1, "{findings:?}");
        findings.remove(0)
    }

    #[test]
    fn a_good_surface_has_no_findings() {
        assert_eq!(check(&tetrahedron()), []);
    }

    #[test]
    fn each_fault_is_found_alone() {
        let (fault, count, text) = only(|m| m.triangles[2].swap(0, 1));
        assert_eq!((fault, count), (Fault::FlippedTriangles, 1));
        assert!(text.contains("neighbours (2)"), "{text}");
        let (fault, count, _) = only(|m| m.triangles.iter_mut().for_each(|t| t.swap(0, 1)));
        assert_eq!((fault, count), (Fault::InsideOut, 4));
        let (fault, count, text) = only(|m| m.triangles.truncate(3));
        assert_eq!((fault, count), (Fault::BoundaryEdges, 3));
        assert!(text.contains("(0-2, 0-3, 2-3)"), "{text}");
        let (fault, count, _) = only(|m| m.points.push(Vec3::new(9.0, 9.0, 9.0)));
        assert_eq!((fault, count), (Fault::UnusedVertices, 1));
        assert_eq!(only(|m| m.triangles.clear()).0, Fault::Empty);
        let (fault, count, _) = only(|m| {
            let other: Vec<Vec3> = m.points.iter().map(|p| p.add_scalar(5.0)).collect();
            m.points.extend(other);
            let faces: Vec<_> = m.triangles.iter().map(|t| t.map(|v| v + 4)).collect();
            m.triangles.extend(faces);
        });
        assert_eq!((fault, count), (Fault::SeveralParts, 2));
    }

    #[test]
    fn a_texture_seam_is_named_but_is_no_hole() {
        let (fault, count, _) = only(|m| {
            m.points.push(m.points[3]);
            m.triangles[1][2] = 4;
        });
        assert_eq!((fault, count), (Fault::DuplicateVertices, 1));
    }

    #[test]
    fn folds_doubles_and_slivers_are_found() {
        let findings = found(|m| m.triangles.push([0, 1, 2]));
        let faults: Vec<_> = findings.iter().map(|f| (f.0, f.1)).collect();
        assert_eq!(faults, [(Fault::DuplicateTriangles, 1), (Fault::NonManifoldEdges, 3)]);
        let findings = found(|m| m.triangles.push([0, 1, 1]));
        assert_eq!(findings[0].0, Fault::ZeroAreaTriangles);
    }
}
