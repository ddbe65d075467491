//! The files a registration writes.

use std::path::{Path, PathBuf};

use serde_json::json;

use super::scene::scene;
use super::skeleton_build::skeleton_document;
use super::skeleton_files::SkeletonFiles;
use super::spec::RegisterJob;
use crate::error::Result;
use crate::io::gltf::write_glb;
use crate::io::skeleton::{ReferenceImage, SkeletonDocument, SoftEntry};
use crate::io::{SurfaceFile, file_name, read_surface, read_volume, write_beside, write_profiles};
use crate::register::animation::{Motion, present_angles};
use crate::register::transfer::carry_soft_tissue;
use crate::register::{Appearance, Registered};

/// A soft tissue surface to carry.
pub(crate) struct Carried {
    name: String,
    file: SurfaceFile,
}

/// The soft tissues of the skeleton file and those named in the job.
pub(crate) fn read_carried(job: &RegisterJob, files: &SkeletonFiles) -> Result<Vec<Carried>> {
    let folder = job.skeleton.parent().unwrap_or(Path::new(""));
    let own = files.document.soft.iter().map(|s| (s.name.clone(), folder.join(&s.mesh)));
    let more = job.carry.iter().flatten().map(|path| {
        let stem = path.file_stem().map_or_else(|| "soft".into(), |s| s.to_string_lossy());
        (stem.into_owned(), path.clone())
    });
    own.chain(more).map(|(name, path)| Ok(Carried { name, file: read_surface(&path)? })).collect()
}

/// Writes bones, skeleton file, scene and carried tissues; returns the files.
pub(crate) fn write(
    folder: &Path,
    job: &RegisterJob,
    files: &SkeletonFiles,
    found: &Registered,
    carried: &[Carried],
    motion: Option<&Motion>,
) -> Result<Vec<PathBuf>> {
    let mut written = Vec::new();
    let mut document = result_document(&files.document, found);
    for ((bone, entry), file) in
        found.skeleton.bones.iter().zip(&document.bones).zip(&files.surfaces)
    {
        let path = folder.join(&entry.mesh);
        file.write_with_points(&path, &found.skeleton.points[bone.vertices.clone()])?;
        written.push(path);
    }
    for Carried { name, file } in carried {
        let points = carry_soft_tissue(&files.skeleton, &found.skeleton.points, &file.mesh()?)?;
        let mesh = format!("soft/{}.obj", file_name(name));
        file.write_with_points(&folder.join(&mesh), &points)?;
        written.push(folder.join(&mesh));
        document.soft.push(SoftEntry { name: name.clone(), mesh });
    }
    if let Some(volume) = &job.volume {
        // What the person's bones look like there, for following them through other images.
        let looks = Appearance::profiles(&found.skeleton, &read_volume(volume)?.volume, None)?;
        if let Appearance::Profiles(profiles) = looks {
            let name = "result.profiles.json";
            write_profiles(&folder.join(name), &profiles)?;
            written.push(folder.join(name));
            document.reference_image =
                Some(ReferenceImage { volume: None, profiles: Some(name.to_owned()) });
        }
    }
    let path = folder.join("result.skeleton.json");
    let text = document.to_text()?;
    write_beside(&path, |out| out.write_all(text.as_bytes()))?;
    written.push(path);
    let path = folder.join("skeleton.glb");
    let scene = scene(&found.skeleton, motion, job.metres_per_unit.unwrap_or(0.001))?;
    write_glb(&path, &scene)?;
    written.push(path);
    Ok(written)
}

/// The person's skeleton file, with all that the template's says and the figures of the result; bones
/// in `bones/`, no soft tissue yet.
pub fn result_document(template: &SkeletonDocument, found: &Registered) -> SkeletonDocument {
    let mut document = skeleton_document(&found.skeleton);
    document.units.clone_from(&template.units);
    document.frame.clone_from(&template.frame);
    for bone in &mut document.bones {
        bone.mesh = format!("bones/{}.obj", file_name(&bone.name));
    }
    for (entry, old) in document.joints.iter_mut().zip(&template.joints) {
        entry.axes.clone_from(&old.axes);
        entry.source.clone_from(&old.source);
    }
    document.result = Some(result_value(found));
    document
}

fn result_value(found: &Registered) -> serde_json::Value {
    let angles: serde_json::Map<String, serde_json::Value> = present_angles(&found.skeleton)
        .into_iter()
        .map(|(name, angle)| (name, angle.to_degrees().into()))
        .collect();
    json!({
        "verdict": found.judgement.verdict, "reasons": found.judgement.reasons, "notes": found.notes,
        "bones": found.bones, "joints": found.joints, "angles_deg": angles,
        "scales": found.scales, "shape_coefficients": found.coefficients, "levels": found.levels, "cancelled": found.cancelled
    })
}
