//! Attachments: from CSV pairs, or from bones near the template.

use std::collections::BTreeMap;
use std::path::Path;

use super::spec::{Gap, ReshapeJob};
use crate::align::{Rigid, best_rigid};
use crate::error::{Error, Result};
use crate::io;
use crate::locate::ClosestPoints;
use crate::math::Vec3;
use crate::mesh::TriMesh;

use super::inputs::Pair;

/// Fewer points of a bone do not tell how it is turned.
const POINTS_FOR_ROTATION: usize = 3;

/// An attachment, ready for the solver.
pub type AttachmentPair = Pair;

/// Reads all attachment files of a job: CSV pairs, or bones.
pub(crate) fn attachments(job: &ReshapeJob, surface: &TriMesh) -> Result<Vec<AttachmentPair>> {
    let mut pairs = Vec::new();
    let mut targets = job.attachment_targets.iter().flatten();
    for path in job.attachments.iter().flatten() {
        if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("csv")) {
            let gap = job.attachment_gap.unwrap_or_default();
            pairs.extend(read_attachment_pairs(path, surface, gap)?);
        } else {
            let distance = job.attachment_distance.ok_or_else(|| {
                Error::invalid(format!(
                    "{} is a bone; say with attachment_distance how near its vertices must be to the template to be attached",
                    path.display()
                ))
            })?;
            pairs.extend(from_bone(path, targets.next().unwrap_or(path), surface, distance)?);
        }
    }
    if let Some(left) = targets.next() {
        let message = "is an attachment target without a bone among the attachments";
        return Err(Error::invalid(format!("{} {message}", left.display())));
    }
    Ok(pairs)
}

/// Reads the attachments of a CSV file, found on `surface`.
pub fn read_attachment_pairs(
    path: &Path,
    surface: &TriMesh,
    gap: Gap,
) -> Result<Vec<AttachmentPair>> {
    let rows = io::read_attachments(path)?;
    let mut pairs = Vec::new();
    for (r, row) in rows.iter().enumerate() {
        let place = row.anchor.resolve(surface)?;
        pairs.push(Pair {
            label: row.label.clone().unwrap_or_else(|| r.to_string()),
            position: place.position,
            vertex: place.vertex,
            target: row.target,
            weight: row.weight.unwrap_or(1.0),
        });
    }
    if gap == Gap::Keep {
        let gaps: Vec<Option<Vec3>> = rows.iter().map(|row| row.gap).collect();
        keep_gaps(&mut pairs, &gaps)?;
    }
    Ok(pairs)
}

/// Adds to each target the template's gap, turned as the bone (all attachments of one label) is
/// turned. Bones with too few points are turned as all of them are.
fn keep_gaps(pairs: &mut [AttachmentPair], gaps: &[Option<Vec3>]) -> Result<()> {
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

fn bone_motion(pairs: &[AttachmentPair], basis: &[(usize, Vec3)]) -> Result<Rigid> {
    if basis.len() < POINTS_FOR_ROTATION {
        return Ok(Rigid::identity());
    }
    let from: Vec<Vec3> = basis.iter().map(|&(a, gap)| pairs[a].position - gap).collect();
    let to: Vec<Vec3> = basis.iter().map(|&(a, _)| pairs[a].target).collect();
    best_rigid(&from, &to, None)
}

fn from_bone(
    bone: &Path,
    target: &Path,
    surface: &TriMesh,
    distance: f64,
) -> Result<Vec<AttachmentPair>> {
    let (rest, person) = (io::read_surface(bone)?.mesh()?, io::read_surface(target)?.mesh()?);
    let name = bone.file_stem().unwrap_or_default().to_string_lossy();
    attach_to_bone(&name, &rest.points, &person.points, surface, distance)
        .map_err(|e| Error::invalid(format!("{} and {}: {e}", bone.display(), target.display())))
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
) -> Result<Vec<AttachmentPair>> {
    if rest.len() != person.len() {
        return Err(Error::invalid(format!(
            "the bone has {} vertices and its target {}; they need the same vertices",
            rest.len(),
            person.len()
        )));
    }
    let motion = best_rigid(rest, person, None)?;
    let closest = ClosestPoints::new(&surface.points, &surface.triangles);
    let pairs: Vec<AttachmentPair> = rest
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gap_turns_with_the_bone() {
        let bone =
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]].map(Vec3::from);
        let gap = Vec3::new(0.0, 0.0, 0.5);
        let turn = |p: Vec3| Vec3::new(p.x + 5.0, -p.z, p.y);
        let mut pairs: Vec<AttachmentPair> = bone
            .iter()
            .map(|&p| Pair {
                label: "origin hip".into(),
                position: p + gap,
                vertex: None,
                target: turn(p),
                weight: 1.0,
            })
            .collect();
        keep_gaps(&mut pairs, &[Some(gap); 4]).unwrap();
        for (pair, p) in pairs.iter().zip(bone) {
            assert!((pair.target - turn(p + gap)).norm() < 1e-12);
        }
    }
}
