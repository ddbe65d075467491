//! A body-centred-cubic lattice around a surface: needs nothing, takes any surface.
//!
//! Tets that the surface cuts or that lie inside are kept; the surface is embedded in them. Inside
//! and outside are told by the generalized winding number, so that open, self-intersecting and
//! non-manifold surfaces work as well.

mod cells;
mod inside;
mod overlap;
mod selection;

use std::collections::BTreeMap;

use rayon::prelude::*;

use self::cells::{LatticeTet, LatticeVertex, TET_VOLUME, position};
use self::inside::Samples;
use self::selection::{Grid, Selection};
use super::{Tetrahedralization, Used};
use crate::error::{Error, Result};
use crate::locate::{Embedding, WindingNumber};
use crate::math::Vec3;
use crate::mesh::{SurfaceCheck, TetMesh, TriMesh};
use crate::run::Run;

/// The wish for a tet count counts as met within this share.
const COUNT_TOLERANCE: f64 = 0.08;
/// Sizes tried at most.
const MAX_SIZES: usize = 6;

/// Builds the lattice with about `tet_count` tets.
pub fn build(surface: &TriMesh, tet_count: usize, run: &Run) -> Result<Tetrahedralization> {
    if surface.area() == 0.0 {
        return Err(Error::invalid(
            "the surface has no triangle with an area, so there is nothing to fill with tets",
        ));
    }
    let winding = WindingNumber::new(&surface.points, &surface.triangles);
    let check = SurfaceCheck::new(surface);
    let selection = select_about(surface, &winding, &check, tet_count, run)?;
    let mut result = assemble(surface, &selection)?;
    result.warnings.extend(warnings(&check, surface, &selection));
    Ok(result)
}

/// Changes the cell size until the number of tets fits.
fn select_about(
    surface: &TriMesh,
    winding: &WindingNumber,
    check: &SurfaceCheck,
    tet_count: usize,
    run: &Run,
) -> Result<Selection> {
    let wish = tet_count as f64;
    // A connected shape cannot need smaller cells; a sliver far from the rest must not ask for them.
    let smallest = surface.diagonal() / wish;
    let mut edge = first_guess(surface, wish).max(smallest);
    let mut best: Option<Selection> = None;
    let miss = |s: &Selection| libm::log(s.tets.len() as f64 / wish).abs();
    for _ in 0..MAX_SIZES {
        let selection = select(surface, winding, check, Grid::around(surface, edge), run)?;
        let ratio = selection.tets.len() as f64 / wish;
        if best.as_ref().is_none_or(|b| miss(&selection) < miss(b)) {
            best = Some(selection);
        }
        if (ratio - 1.0).abs() < COUNT_TOLERANCE {
            break;
        }
        // Between a volume (3) and a surface (2); large jumps are not trusted.
        edge = (edge * libm::pow(ratio, 1.0 / 2.7).clamp(0.3, 3.0)).max(smallest);
    }
    best.ok_or_else(|| Error::invalid("no lattice fits around the surface"))
}

/// Cell edge for which volume and surface together should give `wish` tets.
fn first_guess(surface: &TriMesh, wish: f64) -> f64 {
    let (area, volume) = (surface.area(), surface.volume().abs());
    // Outside the surface, the cut tets fill a layer of about a quarter of the cell edge.
    let count = |edge: f64| (volume + 0.25 * edge * area) / (TET_VOLUME * edge.powi(3));
    let (mut low, mut high) = (1e-6 * surface.diagonal(), 10.0 * surface.diagonal());
    for _ in 0..60 {
        let middle = (low * high).sqrt();
        if count(middle) > wish { low = middle } else { high = middle }
    }
    low
}

/// Tets of one lattice: cut ones that hold anything, inside ones, joined to as few pieces as the
/// surface has.
fn select(
    surface: &TriMesh,
    winding: &WindingNumber,
    check: &SurfaceCheck,
    grid: Grid,
    run: &Run,
) -> Result<Selection> {
    let mut selection = Selection::cut_by(surface, grid);
    let samples = Samples::new();
    let measure = |tet: &LatticeTet| {
        let corners = selection.grid.in_space(&tet.corners());
        (!run.is_cancelled()).then(|| samples.measure(winding, &corners))
    };
    let measured: Option<Vec<(f64, usize)>> = selection.tets.par_iter().map(measure).collect();
    let measured = measured.ok_or(Error::Cancelled)?;
    let holds_vertex = selection.holds_vertex();
    let closed = check.open_edges.is_empty();
    // A tet cut so slightly that no sample is inside is of use only to carry a vertex; around an
    // open surface it may be all there is.
    selection.keep(measured, |i, fraction| fraction > 0.0 || holds_vertex[i] || !closed);
    selection.fill_inside(winding);
    selection.join_pieces();
    Ok(selection)
}

/// Numbers the lattice's vertices and embeds the surface.
fn assemble(surface: &TriMesh, selection: &Selection) -> Result<Tetrahedralization> {
    let mut number: BTreeMap<LatticeVertex, u32> = BTreeMap::new();
    for vertex in selection.tets.iter().flat_map(LatticeTet::vertices) {
        number.insert(vertex, 0);
    }
    for (n, value) in number.values_mut().enumerate() {
        *value = n as u32;
    }
    let points: Vec<Vec3> =
        number.keys().map(|&v| selection.grid.point_in_space(&position(v))).collect();
    let tets = selection.tets.iter().map(|tet| tet.vertices().map(|v| number[&v])).collect();
    let mesh = TetMesh::new(points, tets)?;
    let embedding = Embedding::in_known_tets(&mesh, &surface.points, &selection.tet_of_vertex)?;
    Ok(Tetrahedralization {
        mesh,
        embedding,
        inside_fraction: selection.fraction.clone(),
        boundary_kept: false,
        used: Used::Lattice,
        warnings: Vec::new(),
    })
}

fn warnings(check: &SurfaceCheck, surface: &TriMesh, selection: &Selection) -> Vec<String> {
    let mut warnings: Vec<String> = if check.is_closed() {
        Vec::new()
    } else {
        let faults = check.sentences(surface).join("; ");
        vec![format!(
            "the surface is not closed and even ({faults}); the lattice bridges such places"
        )]
    };
    let bridged = selection.pieces.iter().filter(|&&pieces| pieces > 1).count();
    if bridged > 0 {
        warnings.push(format!(
            "{bridged} tets hold two or more pieces of the inside: a cleft narrower than {:.3} is bridged there; more tets or an external tet mesh keep it apart",
            selection.grid.edge
        ));
    }
    warnings
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::locate::test_shapes::sphere;
    use crate::mesh::adjacency::{DisjointSets, tet_neighbours};

    fn ball(scale: Vec3) -> TriMesh {
        let (points, triangles) = sphere(24, 36);
        TriMesh::new(points.iter().map(|p| p.component_mul(&scale)).collect(), triangles).unwrap()
    }

    fn face_connected_pieces(mesh: &TetMesh) -> usize {
        let mut sets = DisjointSets::new(mesh.tets.len());
        for (t, across) in tet_neighbours(mesh).iter().enumerate() {
            across.iter().flatten().for_each(|&other| sets.join(t as u32, other));
        }
        (0..mesh.tets.len() as u32).filter(|&t| sets.root(t) == t).count()
    }

    #[test]
    fn meets_the_count_and_the_volume_and_carries_every_vertex() {
        let surface = ball(Vec3::new(30.0, 12.0, 5.0));
        for wish in [1500, 6000] {
            let result = build(&surface, wish, &Run::new()).unwrap();
            let count = result.mesh.tets.len() as f64;
            assert!((count / wish as f64 - 1.0).abs() < 0.1, "{count} instead of {wish}");
            assert!((result.inside_volume() / surface.volume() - 1.0).abs() < 1e-2);
            assert!(result.embedding.weights.iter().flatten().all(|&w| w > -1e-9));
            for (p, q) in surface.points.iter().zip(result.embedding.apply(&result.mesh.points)) {
                assert!((p - q).norm() < 1e-12);
            }
            assert_eq!(face_connected_pieces(&result.mesh), 1);
            assert!(result.warnings.is_empty(), "{:?}", result.warnings);
        }
    }

    #[test]
    fn open_crossing_and_turned_surfaces_work_as_well() {
        let mut surface = ball(Vec3::repeat(1.0));
        let volume = surface.volume();
        for triangle in &mut surface.triangles {
            triangle.swap(0, 1);
        }
        surface.triangles.drain(..40);
        // A second ball through the first one.
        let first = surface.points.len() as u32;
        let other = ball(Vec3::repeat(0.6));
        surface.points.extend(other.points.iter().map(|p| p + Vec3::y()));
        surface
            .triangles
            .extend(other.triangles.iter().map(|t| [t[1], t[0], t[2]].map(|v| v + first)));
        let result = build(&surface, 4000, &Run::new()).unwrap();
        let inside = result.inside_volume();
        assert!(inside > volume && inside < 1.3 * volume, "{inside} of {volume}");
        assert_eq!(face_connected_pieces(&result.mesh), 1);
        assert!(result.warnings[0].contains("hole"), "{:?}", result.warnings);
    }

    #[test]
    fn a_narrow_cleft_is_reported() {
        let mut surface = ball(Vec3::repeat(1.0));
        let first = surface.points.len() as u32;
        let other = ball(Vec3::repeat(1.0));
        surface.points.extend(other.points.iter().map(|p| p + Vec3::x() * 2.02));
        surface.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + first)));
        let result = build(&surface, 4000, &Run::new()).unwrap();
        assert!(result.warnings.iter().any(|w| w.contains("cleft")), "{:?}", result.warnings);
    }

    #[test]
    fn slivers_and_nothing_at_all_are_handled() {
        assert!(build(&TriMesh::default(), 1000, &Run::new()).is_err());
        let points = vec![Vec3::zeros(), Vec3::x() * 1e3, Vec3::new(5e2, 1e-7, 0.0)];
        let sliver = TriMesh::new(points, vec![[0, 1, 2]]).unwrap();
        let result = build(&sliver, 1000, &Run::new()).unwrap();
        assert_eq!(face_connected_pieces(&result.mesh), 1);
        let run = Run::new();
        run.cancel();
        assert!(matches!(build(&ball(Vec3::x()), 10, &run), Err(Error::InvalidInput(_))));
        assert!(matches!(build(&ball(Vec3::repeat(1.0)), 10, &run), Err(Error::Cancelled)));
    }

    #[test]
    fn one_and_two_threads_give_the_same_bits() {
        let surface = ball(Vec3::new(3.0, 2.0, 1.0));
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| build(&surface, 2000, &Run::new()).unwrap())
        };
        assert_eq!(on(1), on(2));
    }
}
