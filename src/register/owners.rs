//! Which pieces of the target's surface belong to which bone.
//!
//! Where bones do not touch, the target's surface falls into pieces, and a piece shows one bone. Once a bone
//! has found pieces of its own it is sought on these alone, and no other bone is sought there: a bone that
//! lies partly on its neighbour's piece would keep what it holds of it.

use rayon::prelude::*;

use super::correspond::Correspond;
use super::pairs::PairRules;
use super::surface::SearchedSurface;
use super::target::{Part, Target};
use crate::math::Vec3;
use crate::mesh::adjacency::{components, first_at_place, renumbered};

/// A piece is a bone's own when so much of it lies nearest to the bone, and so much of the bone nearest to
/// its own pieces.
const OWN: f64 = 0.8;

/// The target's surface in pieces that do not touch.
pub(super) struct Pieces<'a> {
    pub(super) surface: &'a SearchedSurface,
    pub(super) of_triangle: Vec<u32>,
    of_vertex: Vec<u32>,
    pub(super) count: usize,
    bone_count: usize,
}

/// The surface of each bone that has pieces of its own, and what is left for the other bones.
pub(super) struct Owned {
    /// The bone that each piece belongs to.
    owner: Vec<Option<usize>>,
    of_bone: Vec<Option<SearchedSurface>>,
    rest: SearchedSurface,
}

impl<'a> Pieces<'a> {
    /// None where the target tells the bones apart already, or is in one piece.
    pub(super) fn new(target: &'a Target, bone_count: usize) -> Option<Self> {
        let surface = target.surfaces.first()?.as_ref().filter(|_| !target.labelled)?;
        let first = first_at_place(&surface.mesh.points);
        let joined = renumbered(&surface.mesh.triangles, &first);
        let of_triangle = components(first.len(), &joined);
        let count = of_triangle.iter().max().map_or(0, |&last| last as usize + 1);
        let mut of_vertex = vec![u32::MAX; surface.mesh.points.len()];
        for (triangle, &piece) in surface.mesh.triangles.iter().zip(&of_triangle) {
            for &v in triangle {
                of_vertex[v as usize] = piece;
            }
        }
        (count > 1).then_some(Self { surface, of_triangle, of_vertex, count, bone_count })
    }

    /// Shares the pieces out among bones that lie at `points`; `search` seeks all bones on the whole surface,
    /// `before` is what was shared out last.
    pub(super) fn shared_out(
        &self,
        search: &mut Correspond,
        points: &[Vec3],
        rules: &PairRules,
        before: Option<Owned>,
    ) -> Owned {
        search.at(points, rules);
        let mut by_bone = vec![Vec::new(); self.count];
        for (v, bone, area) in search.met_by_target() {
            if let Some(shares) = by_bone.get_mut(self.of_vertex[v as usize] as usize) {
                add(shares, bone, area);
            }
        }
        let most: Vec<Option<usize>> = by_bone.iter().map(|shares| most_of(shares)).collect();
        let mut areas = vec![[0.0; 2]; self.bone_count];
        for (bone, triangle, area) in search.met_by_bones() {
            let own = most[self.of_triangle[triangle as usize] as usize] == Some(bone as usize);
            areas[bone as usize][usize::from(own)] += area;
        }
        let has_own: Vec<bool> =
            areas.iter().map(|[other, own]| *own > 0.0 && *own >= OWN * (own + other)).collect();
        let owner: Vec<Option<usize>> =
            most.into_iter().map(|most| most.filter(|&bone| has_own[bone])).collect();
        if let Some(before) = before.filter(|before| before.owner == owner) {
            return before;
        }
        self.owned_by(owner)
    }

    /// The surfaces of bones with these pieces: the bone of each.
    pub(super) fn owned_by(&self, owner: Vec<Option<usize>>) -> Owned {
        let of_vertex = &self.of_vertex;
        let owner_at = |v: u32| owner.get(of_vertex[v as usize] as usize).copied().flatten();
        let of_bone = (0..self.bone_count)
            .into_par_iter()
            .map(|b| {
                let has_own = owner.contains(&Some(b));
                has_own.then(|| self.surface.part(|v| owner_at(v) == Some(b)))
            })
            .collect();
        let rest = self.surface.part(|v| owner_at(v).is_none());
        Owned { owner, of_bone, rest }
    }
}

fn add(shares: &mut Vec<(u32, f64)>, bone: u32, area: f64) {
    match shares.iter_mut().find(|(b, _)| *b == bone) {
        Some((_, sum)) => *sum += area,
        None => shares.push((bone, area)),
    }
}

/// The bone that holds most of a piece, if it holds enough.
fn most_of(shares: &[(u32, f64)]) -> Option<usize> {
    let whole: f64 = shares.iter().map(|(_, area)| area).sum();
    let &(bone, most) = shares.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
    (most >= OWN * whole).then_some(bone as usize)
}

impl Owned {
    /// The surfaces with the bones that are sought on each.
    pub(super) fn parts(&self) -> Vec<Part<'_>> {
        let mut parts = Vec::new();
        let mut others = Vec::new();
        for (b, surface) in self.of_bone.iter().enumerate() {
            match surface {
                Some(surface) => parts.push(Part { bones: vec![b], surface }),
                None => others.push(b),
            }
        }
        if !others.is_empty() && !self.rest.mesh.triangles.is_empty() {
            parts.push(Part { bones: others, surface: &self.rest });
        }
        parts
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::register::options::Options;
    use crate::register::registration::Registration;
    use crate::register::skeleton::Skeleton;
    use crate::register::skeleton::tests::block;

    #[test]
    fn a_bone_owns_the_piece_it_lies_on_and_the_others_share_the_rest() {
        let half = Vec3::new(5.0, 2.0, 1.0);
        let row = |k: f64, shift: f64| block(Vec3::new(11.0 * k + shift, 0.0, 0.0), half, 6);
        let bones = (0..3).map(|k| (format!("bone {k}"), row(f64::from(k), 0.0))).collect();
        let skeleton = Skeleton::new(bones, Vec::new()).unwrap();
        // The piece of the second bone lies half under the third one, and something is no bone.
        let mut seen = row(0.0, 0.5);
        seen.append(&row(1.5, 0.0));
        seen.append(&block(Vec3::new(-9.0, 0.0, 0.0), Vec3::repeat(1.0), 2));
        let target = Target::whole(seen).unwrap();
        let pieces = Pieces::new(&target, 3).unwrap();
        assert_eq!(pieces.count, 3);
        let registration = Registration::new(skeleton.clone(), Options::default()).unwrap();
        let rules = registration.rules(-1.0, None);
        let mut search = registration.search(&target, 0.0);
        let owned = pieces.shared_out(&mut search, &skeleton.points, &rules, None);
        let parts = owned.parts();
        let bones: Vec<_> = parts.iter().map(|part| part.bones.clone()).collect();
        assert_eq!(bones, [vec![0], vec![1, 2]]);
        let reach = |part: &Part| {
            let x = part.surface.mesh.points.iter().map(|p| p.x);
            x.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(x), b.max(x)])
        };
        // What lies before the first bone is nearest to it, and so a piece of its own as well.
        assert_eq!([reach(&parts[0]), reach(&parts[1])], [[-10.0, 5.5], [11.5, 21.5]]);
        assert!(Pieces::new(&Target::whole(row(0.0, 0.0)).unwrap(), 3).is_none());
    }
}
