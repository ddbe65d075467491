//! Points of the template with known targets: landmarks, attachments, fixed points.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use super::anchor::{Anchor, AnchorColumns};
use super::marker::Marker;
use super::markers::read_markers;
use super::read_bytes;
use super::table::Table;
use crate::error::{Error, Result, Shown};
use crate::math::Vec3;

/// A place on the template and where it is on the person.
#[derive(Clone, Debug, PartialEq)]
pub struct Landmark {
    /// Its name, where the file gives one.
    pub label: Option<String>,
    /// The place on the template.
    pub anchor: Anchor,
    /// Where it is on the person.
    pub target: Vec3,
    /// Relative weight, zero or more.
    pub weight: Option<f64>,
    /// How far it may end from its target whatever the markers say, zero or more.
    pub within: Option<f64>,
}

/// A place where the template is attached to something else, such as a muscle to a bone.
#[derive(Clone, Debug, PartialEq)]
pub struct Attachment {
    /// Its label, else its type and bone, where the file gives them.
    pub label: Option<String>,
    /// The place on the template.
    pub anchor: Anchor,
    /// Where the attachment is on the person: the point on the bone, if the file is about bones.
    pub target: Vec3,
    /// Template point minus the template's bone point, where the file gives both: tendons and
    /// label noise keep a muscle's surface off the bone.
    pub gap: Option<Vec3>,
    /// Relative weight, zero or more.
    pub weight: Option<f64>,
}

/// What [`pair_by_label`] found.
#[derive(Clone, Debug, PartialEq)]
pub struct PairedLandmarks {
    /// One landmark per label that both files have, in the template file's order.
    pub landmarks: Vec<Landmark>,
    /// Labels that only one file has.
    pub unpaired: Vec<String>,
}

/// Reads landmarks from a CSV file, see [`parse_landmarks`].
pub fn read_landmarks(path: &Path) -> Result<Vec<Landmark>> {
    parse_landmarks(&read_bytes(path)?, path)
}

/// Reads columns `template_x,template_y,template_z` or `vertex` (from 0), and
/// `target_x,target_y,target_z`; `label`, `weight` and `within` where they are there. Lines whose target is
/// empty are left out.
pub fn parse_landmarks(bytes: &[u8], path: &Path) -> Result<Vec<Landmark>> {
    let table = Table::parse(bytes, path)?;
    let anchor = AnchorColumns::find(&table, &["template_", "source_"])?;
    let target = table
        .point_columns(&["target_"])
        .ok_or_else(|| table.missing("target_x, target_y and target_z"))?;
    let label = table.column(&["label", "name", "id"]);
    let weight = table.column(&["weight"]);
    let within = table.column(&["within"]);
    table
        .rows()
        .filter(|row| target.iter().any(|&c| row.text(c).is_some()))
        .map(|row| {
            Ok(Landmark {
                label: row.label(label),
                anchor: anchor.read(row, path)?,
                target: row.point(target)?,
                weight: row.size(weight)?,
                within: row.size(within)?,
            })
        })
        .collect()
}

/// The landmarks of one file of pairs, or of two marker files (template, person) whose points are paired
/// by label. Comes with a sentence if labels were left out.
pub fn read_landmark_files(files: &[PathBuf]) -> Result<(Vec<Landmark>, Option<String>)> {
    match files {
        [] => Ok((Vec::new(), None)),
        [pairs] => Ok((read_landmarks(pairs)?, None)),
        [template, person] => {
            let paired = pair_by_label(template, person)?;
            let warning = (!paired.unpaired.is_empty()).then(|| {
                format!(
                    "landmarks that only one of the two files has are left out: {}",
                    paired.unpaired.join(", ")
                )
            });
            Ok((paired.landmarks, warning))
        }
        more => Err(Error::invalid(format!(
            "{} landmark files are given; one file of pairs or two files paired by label are needed",
            more.len()
        ))),
    }
}

/// Reads attachments from a CSV file, see [`parse_attachments`].
pub fn read_attachments(path: &Path) -> Result<Vec<Attachment>> {
    parse_attachments(&read_bytes(path)?, path)
}

/// Reads the template's point (`muscle_x..`, `material_x..`, `template_x..` or `vertex`) and its
/// target (`target_x..` or `target_bone_x..`), and where they are there `template_bone_x..`,
/// `label` (else `type`, `bone` or `end`) and `weight`. Lines with `in_fov` 0 (the target is
/// outside the scan) are left out.
pub fn parse_attachments(bytes: &[u8], path: &Path) -> Result<Vec<Attachment>> {
    let table = Table::parse(bytes, path)?;
    let prefixes = ["muscle_", "material_", "template_", "template_bone_"];
    let anchor = AnchorColumns::find(&table, &prefixes)?;
    let bone = table.point_columns(&["template_bone_"]);
    let target = table
        .point_columns(&["target_", "target_bone_"])
        .ok_or_else(|| table.missing("target_x or target_bone_x (with y and z)"))?;
    let (label, weight) = (table.column(&["label", "name", "id"]), table.column(&["weight"]));
    let parts = ["type", "bone", "end"].map(|name| table.column(&[name]));
    let in_fov = table.column(&["in_fov"]);
    let mut attachments = Vec::new();
    for row in table.rows() {
        if row.number(in_fov)? == Some(0.0) {
            continue;
        }
        let anchor = anchor.read(row, path)?;
        let bone = bone.map(|columns| row.point(columns)).transpose()?;
        let words: Vec<String> = parts.iter().filter_map(|&part| row.label(part)).collect();
        attachments.push(Attachment {
            label: row.label(label).or_else(|| (!words.is_empty()).then(|| words.join(" "))),
            gap: anchor.position.zip(bone).map(|(own, bone)| own - bone),
            anchor,
            target: row.point(target)?,
            weight: row.size(weight)?,
        });
    }
    Ok(attachments)
}

/// Reads fixed points from a CSV file, see [`parse_fixed`].
pub fn read_fixed(path: &Path) -> Result<Vec<Anchor>> {
    parse_fixed(&read_bytes(path)?, path)
}

/// Reads template points that stay where they are: `vertex` (from 0), or `x,y,z`, or both.
pub fn parse_fixed(bytes: &[u8], path: &Path) -> Result<Vec<Anchor>> {
    let table = Table::parse(bytes, path)?;
    let anchor = AnchorColumns::find(&table, &["", "template_"])?;
    table.rows().map(|row| anchor.read(row, path)).collect()
}

/// Pairs the points of two marker files (any format) by their labels. A label that one file has
/// twice, and files without a common label, are errors.
pub fn pair_by_label(template: &Path, target: &Path) -> Result<PairedLandmarks> {
    pair(&read_markers(template)?, template, &read_markers(target)?, target)
}

fn pair(
    template: &[Marker],
    template_path: &Path,
    target: &[Marker],
    target_path: &Path,
) -> Result<PairedLandmarks> {
    let on_template = by_label(template, template_path)?;
    let mut on_target = by_label(target, target_path)?;
    let mut paired = PairedLandmarks { landmarks: Vec::new(), unpaired: Vec::new() };
    for (label, marker) in &on_template {
        let Some(place) = on_target.iter().position(|(own, _)| own == label) else {
            paired.unpaired.push((*label).to_owned());
            continue;
        };
        let (_, target) = on_target.remove(place);
        paired.landmarks.push(Landmark {
            label: Some((*label).to_owned()),
            anchor: Anchor {
                vertex: None,
                position: Some(marker.position),
                source: (template_path.to_path_buf(), 1),
            },
            target: target.position,
            weight: target.weight.or(marker.weight),
            within: None,
        });
    }
    paired.unpaired.extend(on_target.iter().map(|(label, _)| (*label).to_owned()));
    if paired.landmarks.is_empty() {
        return Err(Error::invalid(format!(
            "{} and {} have no label in common; landmarks are paired by label",
            template_path.shown(),
            target_path.shown()
        )));
    }
    Ok(paired)
}

fn by_label<'a>(markers: &'a [Marker], path: &Path) -> Result<Vec<(&'a str, &'a Marker)>> {
    let mut seen = HashMap::new();
    let mut labelled = Vec::new();
    for (m, marker) in markers.iter().enumerate() {
        let Some(label) = marker.label.as_deref() else { continue };
        if let Some(first) = seen.insert(label, m) {
            return Err(Error::invalid(format!(
                "{}: points {first} and {m} have the same label '{label}'; rename one",
                path.shown()
            )));
        }
        labelled.push((label, marker));
    }
    Ok(labelled)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::TriMesh;

    fn path() -> &'static Path {
        Path::new("a.csv")
    }

    fn triangle() -> TriMesh {
        let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(Vec3::from).to_vec();
        TriMesh::new(points, vec![[0, 1, 2]]).unwrap()
    }

    #[test]
    fn landmarks_are_given_by_position_or_vertex() {
        let text = "label,template_x,template_y,template_z,target_x,target_y,target_z,how\n\
                    tip,1,0,0,2,0,0,\"by eye, twice\"\nlost,0,1,0,,,,\n";
        let landmarks = parse_landmarks(text.as_bytes(), path()).unwrap();
        assert_eq!(landmarks.len(), 1);
        assert_eq!(landmarks[0].label.as_deref(), Some("tip"));
        assert_eq!(landmarks[0].target, Vec3::new(2.0, 0.0, 0.0));
        let text = "vertex,target_x,target_y,target_z\n1,5,0,0\n3,0,0,0\n";
        let landmarks = parse_landmarks(text.as_bytes(), path()).unwrap();
        let place = landmarks[0].anchor.resolve(&triangle()).unwrap();
        assert_eq!((place.position.x, place.vertex), (1.0, Some(1)));
        let error = landmarks[1].anchor.resolve(&triangle()).unwrap_err().to_string();
        assert!(error.starts_with("a.csv, line 3: vertex 3 is not on the template"), "{error}");
    }

    #[test]
    fn a_vertex_number_made_for_another_mesh_is_not_believed() {
        let fixed =
            parse_fixed(b"vertex,x,y,z\n1,1.00001,0,0\n2,1,0,0\n9,1,0,0\n", path()).unwrap();
        let vertices: Vec<_> =
            fixed.iter().map(|f| f.resolve(&triangle()).unwrap().vertex).collect();
        assert_eq!(vertices, [Some(1), None, None]);
    }

    #[test]
    fn attachments_keep_the_gap_and_skip_what_the_scan_does_not_show() {
        let text = "type,bone,muscle_x,muscle_y,muscle_z,template_bone_x,template_bone_y,\
                    template_bone_z,target_bone_x,target_bone_y,target_bone_z,in_fov\n\
                    origin,hip,1,0,0,0.5,0,0,7,8,9,1\norigin,hip,1,0,0,0,0,0,7,8,9,0\n";
        let attachments = parse_attachments(text.as_bytes(), path()).unwrap();
        assert_eq!(attachments.len(), 1);
        assert_eq!(attachments[0].label.as_deref(), Some("origin hip"));
        assert_eq!(attachments[0].gap, Some(Vec3::new(0.5, 0.0, 0.0)));
        assert_eq!(attachments[0].target, Vec3::new(7.0, 8.0, 9.0));
        let text = "end,vertex,material_x,material_y,material_z,target_x,target_y,target_z\n\
                    fixed,0,1,0,0,1,0,0\n";
        let attachments = parse_attachments(text.as_bytes(), path()).unwrap();
        assert_eq!((attachments[0].anchor.vertex, attachments[0].gap), (Some(0), None));
    }

    #[test]
    fn missing_columns_are_named() {
        let error = parse_landmarks(b"a,b\n", path()).unwrap_err().to_string();
        assert!(error.contains("columns vertex or template_x"), "{error}");
        let error = parse_attachments(b"vertex,x\n", path()).unwrap_err().to_string();
        assert!(error.contains("target_x or target_bone_x"), "{error}");
        let error = parse_fixed(b"vertex\n-1\n", path()).unwrap_err().to_string();
        assert!(error.contains("line 2: vertex is '-1', not a whole number"), "{error}");
    }

    #[test]
    fn points_are_paired_by_label() {
        let marker = |label: &str, x: f64| Marker {
            label: Some(label.to_owned()),
            ..Marker::at(Vec3::new(x, 0.0, 0.0))
        };
        let template = [marker("a", 1.0), marker("b", 2.0), marker("c", 3.0)];
        let target = [marker("c", 30.0), marker("d", 40.0), marker("a", 10.0)];
        let paired = pair(&template, path(), &target, path()).unwrap();
        let moves: Vec<f64> = paired.landmarks.iter().map(|l| l.target.x).collect();
        assert_eq!(moves, [10.0, 30.0]);
        assert_eq!(paired.unpaired, ["b", "d"]);
        let error = pair(&template[..2], path(), &target[..2], path()).unwrap_err().to_string();
        assert!(error.contains("no label in common"), "{error}");
        let twice = [marker("a", 1.0), marker("a", 2.0)];
        let error = pair(&twice, path(), &target, path()).unwrap_err().to_string();
        assert!(error.contains("points 0 and 1 have the same label 'a'"), "{error}");
    }
}
