//! Which piece of the target shows which bone, found for all of them at once.
//!
//! A row of bones that lies one place off, rib on rib, looks right one by one: only at its ends two bones want one
//! piece, and another piece has none. The cheapest way to give each bone a piece of its own moves the whole row.

use nalgebra::SymmetricEigen;
use pathfinding::kuhn_munkres::kuhn_munkres_min;
use pathfinding::matrix::Matrix;

use super::owners::Pieces;
use super::skeleton::Skeleton;
use crate::math::{Mat3, Vec3};
use crate::mesh::adjacency::{components, first_at_place, renumbered};

/// How much a difference in size counts against the same distance.
const SIZE_WEIGHT: f64 = 4.0;
/// So many times as many pieces as the bones have are looked at, the largest ones.
const MOST_PIECES: usize = 4;
/// A template in more pieces than these is left as it lies: the time grows with the third power.
const MOST_OF_TEMPLATE: usize = 1_000;
/// A piece that is so many times larger or smaller than the bone's, by area, is not the bone's.
const OTHER_SIZE: f64 = 4.0;
/// Costs are whole numbers of this share of the largest one.
const STEPS: f64 = (1_u64 << 40) as f64;
/// Cost of no piece.
const NONE: i64 = 1 << 41;

/// Where a piece lies, and its size: standard deviations along its principal axes.
#[derive(Clone, Copy, Debug)]
struct Extent {
    area: f64,
    centre: Vec3,
    size: Vec3,
}

/// A piece of the target for each bone.
pub(super) struct Match {
    /// The bone of each piece of the target.
    pub(super) owners: Vec<Option<usize>>,
    /// Whether a bone gets another piece than the cheapest one for it alone.
    pub(super) contested: bool,
    /// From its middle to that of its pieces, for each bone that does not lie there: they are further off than it
    /// is large.
    pub(super) moves: Vec<Option<Vec3>>,
}

/// The template's pieces and the target's.
pub(super) struct PieceMatch<'a> {
    triangles: &'a [[u32; 3]],
    of_triangle: Vec<u32>,
    /// The bone of each piece of the template.
    bone_of: Vec<usize>,
    /// Extents of the target's pieces, with their numbers there.
    target: Vec<(usize, Extent)>,
    target_count: usize,
}

impl<'a> PieceMatch<'a> {
    /// None for a template in very many pieces.
    pub(super) fn new(template: &'a Skeleton, pieces: &Pieces) -> Option<Self> {
        let triangles = &template.triangles;
        let first = first_at_place(&template.points);
        let of_triangle = components(first.len(), &renumbered(triangles, &first));
        let mut bone_of = Vec::new();
        for (b, bone) in template.bones.iter().enumerate() {
            for &piece in &of_triangle[bone.triangles.clone()] {
                if piece as usize == bone_of.len() {
                    bone_of.push(b);
                }
            }
        }
        if bone_of.len() > MOST_OF_TEMPLATE {
            return None;
        }
        let mesh = &pieces.surface.mesh;
        let extents = extents(&mesh.points, &mesh.triangles, &pieces.of_triangle, pieces.count);
        let mut target: Vec<(usize, Extent)> = extents.into_iter().enumerate().collect();
        target.sort_by(|(_, a), (_, b)| b.area.total_cmp(&a.area));
        target.truncate(MOST_PIECES * bone_of.len());
        Some(Self { triangles, of_triangle, bone_of, target, target_count: pieces.count })
    }

    /// The cheapest way to give bones that lie at `points` a piece each.
    pub(super) fn at(&self, points: &[Vec3]) -> Match {
        let own = extents(points, self.triangles, &self.of_triangle, self.bone_of.len());
        let distance = |a: &Extent, b: &Extent| {
            (a.centre - b.centre).norm_squared() + SIZE_WEIGHT * (a.size - b.size).norm_squared()
        };
        let costs: Vec<f64> =
            own.iter().flat_map(|a| self.target.iter().map(|(_, b)| distance(a, b))).collect();
        let largest = costs.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        let [rows, real] = [own.len(), self.target.len()];
        let cost = |(row, column): (usize, usize)| {
            let Some((_, piece)) = self.target.get(column) else { return NONE };
            let ratio = own[row].area / piece.area;
            let comparable = (1.0 / OTHER_SIZE..OTHER_SIZE).contains(&ratio);
            let share = costs[row * real + column] / largest;
            if comparable { (share * STEPS) as i64 } else { NONE }
        };
        let matrix = Matrix::from_fn(rows, real.max(rows), cost);
        let (_, found) = kuhn_munkres_min(&matrix);
        let mut owners = vec![None; self.target_count];
        let bones = self.bone_of.last().map_or(0, |last| last + 1);
        let mut sums = vec![(Vec3::zeros(), 0.0, 0.0_f64); bones];
        let mut contested = false;
        for (row, column) in found.into_iter().enumerate().filter(|at| cost(*at) < NONE) {
            let (bone, here, (piece, there)) = (self.bone_of[row], own[row], self.target[column]);
            owners[piece] = Some(bone);
            contested |= (0..real).any(|other| cost((row, other)) < cost((row, column)));
            let (by, area, size) = &mut sums[bone];
            *by += here.area * (there.centre - here.centre);
            *area += here.area;
            *size = size.max(here.size.max());
        }
        let moved =
            |(by, area, size): (Vec3, f64, f64)| Some(by / area).filter(|by| by.norm() > size);
        Match { owners, contested, moves: sums.into_iter().map(moved).collect() }
    }
}

fn extents(
    points: &[Vec3],
    triangles: &[[u32; 3]],
    of_triangle: &[u32],
    count: usize,
) -> Vec<Extent> {
    let mut sums = vec![(0.0, Vec3::zeros(), Mat3::zeros()); count];
    let Some(&origin) = points.first() else { return Vec::new() };
    for (triangle, &piece) in triangles.iter().zip(of_triangle) {
        let corners = triangle.map(|v| points[v as usize] - origin);
        let area = (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).norm() / 2.0;
        let (whole, first, second) = &mut sums[piece as usize];
        *whole += area;
        for corner in corners {
            *first += corner * (area / 3.0);
            *second += corner * corner.transpose() * (area / 3.0);
        }
    }
    let extent = |(area, first, second): (f64, Vec3, Mat3)| {
        let centre = first / area.max(f64::MIN_POSITIVE);
        let spread = second / area.max(f64::MIN_POSITIVE) - centre * centre.transpose();
        let mut size = SymmetricEigen::new(spread).eigenvalues.map(|e| e.max(0.0).sqrt());
        size.as_mut_slice().sort_by(f64::total_cmp);
        Extent { area, centre: centre + origin, size }
    };
    sums.into_iter().map(extent).collect()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::register::skeleton::tests::block;
    use crate::register::target::Target;

    /// Five blocks in a row, each a little longer than the one before it; with the block at 0 in two parts.
    pub(in crate::register) fn row() -> Skeleton {
        let bone = |k: u32| {
            let half = Vec3::new(3.0 + 0.2 * f64::from(k), 2.0, 1.0);
            (format!("bone {k}"), block(Vec3::new(10.0 * f64::from(k), 0.0, 0.0), half, 3))
        };
        let mut bones: Vec<_> = (0..5).map(bone).collect();
        bones[0].1.append(&block(Vec3::new(0.0, 5.0, 0.0), Vec3::repeat(1.0), 2));
        Skeleton::new(bones, Vec::new()).unwrap()
    }

    fn matched(target: &Skeleton, shift: f64) -> Match {
        let row = row();
        let target = Target::whole(target.surface()).unwrap();
        let pieces = Pieces::new(&target, row.bones.len()).unwrap();
        let points: Vec<Vec3> = row.points.iter().map(|p| p + Vec3::new(shift, 0.0, 0.0)).collect();
        PieceMatch::new(&row, &pieces).unwrap().at(&points)
    }

    #[test]
    fn a_row_that_lies_one_place_off_is_moved_as_a_whole() {
        let whole = row();
        let each = [0, 0, 1, 2, 3, 4].map(Some).to_vec();
        let [there, one_off] = [0.0, 10.0].map(|shift| matched(&whole, shift));
        assert!(there.owners == each && !there.contested);
        assert!(there.moves.iter().all(Option::is_none));
        assert!(one_off.owners == each && one_off.contested);
        let back = |by: &Option<Vec3>| by.is_some_and(|by| (by.x + 10.0).abs() < 1e-9);
        assert!(one_off.moves.iter().all(back), "{:?}", one_off.moves);
        // A crumb takes nothing from anybody.
        let crumb = block(Vec3::new(14.0, 0.0, 0.0), Vec3::repeat(0.3), 1);
        let bones = whole.bones.iter().enumerate();
        let bones =
            bones.map(|(b, bone)| (bone.name.clone(), whole.bone_surface(b, &whole.points)));
        let with_crumb: Vec<_> = bones.chain([("crumb".into(), crumb)]).collect();
        let with_crumb = Skeleton::new(with_crumb, Vec::new()).unwrap();
        let expected: Vec<_> = each.into_iter().chain([None]).collect();
        assert_eq!(matched(&with_crumb, 10.0).owners, expected);
    }

    #[test]
    fn a_bone_whose_piece_is_missing_takes_nobody_elses() {
        let whole = row();
        let left = [0, 1, 3, 4].map(|b| (format!("{b}"), whole.bone_surface(b, &whole.points)));
        let without = Skeleton::new(left.to_vec(), Vec::new()).unwrap();
        let matched = matched(&without, 0.0);
        assert_eq!(matched.owners, [0, 0, 1, 3, 4].map(Some));
        assert!(!matched.contested);
    }
}
