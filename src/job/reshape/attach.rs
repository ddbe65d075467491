//! Attachments: from CSV pairs, or from bones near the template.

use std::path::Path;

use super::spec::{Gap, ReshapeJob};
use crate::error::{Error, Result, Shown};
use crate::io;
use crate::math::Vec3;
use crate::mesh::TriMesh;
use crate::reshape::{Pair, attach_to_bone, keep_gaps};

/// Reads all attachment files of a job: CSV pairs, or bones.
pub(crate) fn attachments(job: &ReshapeJob, surface: &TriMesh) -> Result<Vec<Pair>> {
    let mut pairs = Vec::new();
    let mut targets = job.attachment_targets.iter().flatten();
    for path in job.attachments.iter().flatten() {
        if io::has_extension(path, "csv") {
            let gap = job.attachment_gap.unwrap_or_default();
            pairs.extend(read_attachment_pairs(path, surface, gap)?);
        } else {
            let distance = job.attachment_distance.ok_or_else(|| {
                Error::invalid(format!(
                    "{} is a bone; say with attachment_distance how near its vertices must be to the template to be attached",
                    path.shown()
                ))
            })?;
            pairs.extend(from_bone(path, targets.next().unwrap_or(path), surface, distance)?);
        }
    }
    if let Some(left) = targets.next() {
        let message = "is an attachment target without a bone among the attachments";
        return Err(Error::invalid(format!("{} {message}", left.shown())));
    }
    Ok(pairs)
}

/// Reads the attachments of a CSV file, found on `surface`.
pub fn read_attachment_pairs(path: &Path, surface: &TriMesh, gap: Gap) -> Result<Vec<Pair>> {
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
            within: None,
        });
    }
    if gap == Gap::Keep {
        let gaps: Vec<Option<Vec3>> = rows.iter().map(|row| row.gap).collect();
        keep_gaps(&mut pairs, &gaps)?;
    }
    Ok(pairs)
}

fn from_bone(bone: &Path, target: &Path, surface: &TriMesh, distance: f64) -> Result<Vec<Pair>> {
    let (rest, person) = (io::read_surface(bone)?.mesh()?, io::read_surface(target)?.mesh()?);
    attach_to_bone(&io::stem(bone), &rest.points, &person.points, surface, distance)
        .map_err(|e| Error::invalid(format!("{} and {}: {e}", bone.shown(), target.shown())))
}
