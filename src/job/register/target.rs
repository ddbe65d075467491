//! The person's bones as a target: surfaces, label maps, an image.

use std::path::Path;

use super::image_target::{appearance, image_target};
use super::skeleton_files::SkeletonFiles;
use super::spec::RegisterJob;
use crate::error::{Error, Result, Shown};
use crate::io::{file_names, is_volume, read_surface, read_volume};
use crate::mesh::TriMesh;
use crate::register::{Skeleton, Target};
use crate::volume::label_surface;

/// The target, and what its reader noticed.
pub fn read_target(job: &RegisterJob, files: &SkeletonFiles) -> Result<(Target, Vec<String>)> {
    if let (None, None, Some(volume)) = (&job.target, &job.labels, &job.volume) {
        let measure = job.measure.unwrap_or_default();
        let looks = appearance(&job.skeleton, files, job.reference.as_deref(), measure)?;
        return image_target(&files.skeleton, volume, looks);
    }
    surface_target(job, &files.skeleton).map(|target| (target, Vec::new()))
}

fn surface_target(job: &RegisterJob, skeleton: &Skeleton) -> Result<Target> {
    match (&job.target, &job.labels) {
        (Some(map), None) if job.volume.is_none() && is_volume(map) => {
            bone_label_target(map, job.label)
        }
        (Some(path), None) if job.volume.is_none() => Target::whole(read_surface(path)?.mesh()?),
        (None, Some(map)) if job.volume.is_none() && map.is_file() => {
            labelled_target(map, skeleton)
        }
        (None, Some(folder)) if job.volume.is_none() => {
            let mut surfaces = Vec::new();
            let names = file_names(skeleton.bones.iter().map(|bone| bone.name.as_str()));
            for (bone, name) in skeleton.bones.iter().zip(names) {
                let file = ["ply", "obj", "stl"]
                    .map(|e| folder.join(format!("{name}.{e}")))
                    .into_iter()
                    .find(|p| p.is_file());
                if let Some(path) = file {
                    surfaces.push((bone.name.clone(), read_surface(&path)?.mesh()?));
                }
            }
            if surfaces.is_empty() {
                return Err(Error::invalid(format!(
                    "{} holds no surface named after a bone, such as {}.ply",
                    folder.shown(),
                    skeleton.bones[0].name
                )));
            }
            Target::per_bone(skeleton, surfaces)
        }
        _ => Err(Error::invalid(
            "give the person's bones as one surface with --target, a folder with --labels, or an image with --volume: one of them",
        )),
    }
}

/// One surface of one label of a map, the only one where none is named: all bones together.
fn bone_label_target(path: &Path, label: Option<u32>) -> Result<Target> {
    let labels = read_volume(path)?.volume;
    let wrong = |e: Error| Error::parse(path, None, e.to_string());
    let label = label.map_or_else(|| labels.only_label(), Ok).map_err(wrong)?;
    let (points, triangles) = label_surface(&labels, label).ok_or_else(|| {
        wrong(Error::invalid(format!("label {label} is nowhere in the image, or all of it")))
    })?;
    Target::whole(TriMesh::new(points, triangles)?)
}

/// A surface for each bone whose label the map holds.
fn labelled_target(path: &Path, skeleton: &Skeleton) -> Result<Target> {
    let labels = read_volume(path)?.volume;
    let mut surfaces = Vec::new();
    for bone in &skeleton.bones {
        let found = bone.label.and_then(|label| label_surface(&labels, label));
        if let Some((points, triangles)) = found {
            surfaces.push((bone.name.clone(), TriMesh::new(points, triangles)?));
        }
    }
    if surfaces.is_empty() {
        return Err(Error::parse(
            path,
            None,
            "the label map holds no bone's label; give each bone its \"label\" in the skeleton file",
        ));
    }
    Target::per_bone(skeleton, surfaces)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_label_of_a_map_is_the_bone_and_has_to_be_named_if_there_are_more() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("labels.nrrd");
        let mut file =
            b"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 9 9 9\nencoding: raw\nspace: RAS\n\
            space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\n\n"
                .to_vec();
        let label_at = |i: usize| match (i % 9, i / 9 % 9, i / 81) {
            (1..=2, 1..=7, 1..=7) => 3,
            (5..=7, 1..=7, 1..=7) => 8,
            _ => 0,
        };
        file.extend((0..729).map(label_at));
        std::fs::write(&path, file).unwrap();
        let error = bone_label_target(&path, None).unwrap_err().to_string();
        assert!(error.contains("labels.nrrd") && error.contains("--label: 3, 8"), "{error}");
        assert!(bone_label_target(&path, Some(8)).is_ok());
        let error = bone_label_target(&path, Some(4)).unwrap_err().to_string();
        assert!(error.contains("label 4 is nowhere"), "{error}");
    }
}
