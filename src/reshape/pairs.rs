//! Landmarks and attachments with their places on the template; attachments of a bone.

use std::collections::BTreeMap;

use super::problem::{Landmark, TemplatePoint};
use crate::align::{Rigid, best_rigid};
use crate::error::{Error, Result};
use crate::locate::{ClosestPoints, NearestPoints};
use crate::math::Vec3;
use crate::mesh::TriMesh;

/// Fewer points of a bone do not tell how it is turned.
const POINTS_FOR_ROTATION: usize = 3;

/// A paired point with its place on the template.
#[derive(Clone, Debug, PartialEq)]
pub struct Pair {
    /// Its name, else its number.
    pub label: String,
    /// Where it is on the template.
    pub position: Vec3,
    /// The template's vertex there, if the file names one.
    pub vertex: Option<u32>,
    /// Where it is on the person.
    pub target: Vec3,
    /// Relative weight.
    pub weight: f64,
    /// Of a pin: how far it may end from its target.
    pub within: Option<f64>,
}

impl Pair {
    /// A landmark with its place on `surface`.
    pub fn of(landmark: &Landmark, surface: &TriMesh) -> Self {
        let position = landmark.template.position(&surface.points);
        let vertex = match landmark.template {
            TemplatePoint::Vertex(v) => Some(v),
            TemplatePoint::Position(_) => None,
        };
        let Landmark { label, target, weight, within, .. } = landmark.clone();
        Self { label, position, vertex, target, weight, within }
    }

    /// As the solver takes it.
    pub fn landmark(&self) -> Landmark {
        Landmark {
            label: self.label.clone(),
            template: self
                .vertex
                .map_or(TemplatePoint::Position(self.position), TemplatePoint::Vertex),
            target: self.target,
            weight: self.weight,
            within: self.within,
        }
    }
}

/// \[W\] 4.1.2: every vertex of a bone within `distance` of the template is linked to the template's
/// point nearest to it. The gap is kept: the nearest point goes where the bone's vertex goes, plus
/// the gap. `rest` and `person`: the bone's vertices beside the template and on the person.
pub fn attach_to_bone(
    name: &str,
    rest: &[Vec3],
    person: &[Vec3],
    surface: &TriMesh,
    distance: f64,
) -> Result<Vec<Pair>> {
    let motion = motion_of_bone(rest, person)?;
    let closest = ClosestPoints::new(&surface.points, &surface.triangles);
    let pairs: Vec<Pair> = rest
        .iter()
        .zip(person)
        .filter_map(|(own, there)| {
            let place = closest.closest_within(own, distance)?;
            Some(Pair {
                label: name.to_owned(),
                position: place.position,
                vertex: None,
                target: there + motion.rotation * (place.position - own),
                weight: 1.0,
                within: None,
            })
        })
        .collect();
    if pairs.is_empty() {
        return Err(Error::invalid(format!(
            "no vertex of the bone is within {distance} of the template; is the distance in the template's unit?"
        )));
    }
    Ok(pairs)
}

/// Links chosen vertices of the template to a bone, each to the bone's vertex nearest to it, and keeps the gap as
/// [`attach_to_bone`] does.
pub fn attach_vertices(
    name: &str,
    vertices: &[u32],
    rest: &[Vec3],
    person: &[Vec3],
    surface: &TriMesh,
) -> Result<Vec<Pair>> {
    let motion = motion_of_bone(rest, person)?;
    let nearest = NearestPoints::new(rest);
    let pair = |&vertex: &u32| {
        let position = surface.points[vertex as usize];
        let (near, _) = nearest.nearest(&position)?;
        let (own, there) = (rest[near as usize], person[near as usize]);
        Some(Pair {
            label: name.to_owned(),
            position,
            vertex: Some(vertex),
            target: there + motion.rotation * (position - own),
            weight: 1.0,
            within: None,
        })
    };
    Ok(vertices.iter().filter_map(pair).collect())
}

fn motion_of_bone(rest: &[Vec3], person: &[Vec3]) -> Result<Rigid> {
    if rest.is_empty() {
        return Err(Error::invalid("the bone has no vertices"));
    }
    if rest.len() != person.len() {
        return Err(Error::invalid(format!(
            "the bone has {} vertices and its target {}; they need the same vertices",
            rest.len(),
            person.len()
        )));
    }
    best_rigid(rest, person, None)
}

/// Adds to each target the template's gap, turned as the bone (all attachments of one label) is
/// turned. Bones with too few points are turned as all of them are. `gaps`: one for each pair.
pub fn keep_gaps(pairs: &mut [Pair], gaps: &[Option<Vec3>]) -> Result<()> {
    let mut bones: BTreeMap<String, Vec<usize>> = BTreeMap::new();
    for (a, pair) in pairs.iter().enumerate() {
        bones.entry(pair.label.clone()).or_default().push(a);
    }
    let all: Vec<usize> = (0..pairs.len()).collect();
    let mut moved = Vec::new();
    for members in bones.values() {
        let with_gap = |list: &[usize]| -> Vec<(usize, Vec3)> {
            list.iter().filter_map(|&a| Some((a, gaps[a]?))).collect()
        };
        let own = with_gap(members);
        let enough = own.len() >= POINTS_FOR_ROTATION;
        let basis = if enough { own.clone() } else { with_gap(&all) };
        let motion = bone_motion(pairs, &basis)?;
        moved.extend(own.into_iter().map(|(a, gap)| (a, motion.rotation * gap)));
    }
    for (a, gap) in moved {
        pairs[a].target += gap;
    }
    Ok(())
}

fn bone_motion(pairs: &[Pair], basis: &[(usize, Vec3)]) -> Result<Rigid> {
    if basis.len() < POINTS_FOR_ROTATION {
        return Ok(Rigid::identity());
    }
    let from: Vec<Vec3> = basis.iter().map(|&(a, gap)| pairs[a].position - gap).collect();
    let to: Vec<Vec3> = basis.iter().map(|&(a, _)| pairs[a].target).collect();
    best_rigid(&from, &to, None)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chosen_vertices_keep_their_gap_to_the_nearest_vertex_of_the_bone() {
        let bone = [[0.0, 0.0, 0.0], [9.0, 0.0, 0.0], [0.0, 9.0, 0.0]].map(Vec3::from);
        let turn = |p: Vec3| Vec3::new(-p.y + 5.0, p.x, p.z);
        let surface =
            TriMesh { points: vec![Vec3::zeros(), Vec3::new(8.0, 0.0, 1.0)], ..TriMesh::default() };
        let held = attach_vertices("origin", &[1], &bone, &bone.map(turn), &surface).unwrap();
        assert_eq!((held.len(), held[0].vertex), (1, Some(1)));
        assert!((held[0].target - turn(surface.points[1])).norm() < 1e-12);
        let error = attach_vertices("origin", &[1], &bone, &bone[..2], &surface).unwrap_err();
        assert!(error.to_string().contains("3 vertices and its target 2"), "{error}");
    }

    #[test]
    fn the_gap_turns_with_the_bone() {
        let bone =
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]].map(Vec3::from);
        let gap = Vec3::new(0.0, 0.0, 0.5);
        let turn = |p: Vec3| Vec3::new(p.x + 5.0, -p.z, p.y);
        let mut pairs: Vec<Pair> = bone
            .iter()
            .map(|&p| Pair {
                label: "origin hip".into(),
                position: p + gap,
                vertex: None,
                target: turn(p),
                weight: 1.0,
                within: None,
            })
            .collect();
        keep_gaps(&mut pairs, &[Some(gap); 4]).unwrap();
        for (pair, p) in pairs.iter().zip(bone) {
            assert!((pair.target - turn(p + gap)).norm() < 1e-12);
        }
    }
}
