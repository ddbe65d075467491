//! The files a registration writes.

use std::path::{Path, PathBuf};

use serde_json::json;

use super::scene::{Tissue, metres_per_unit, scene};
use super::skeleton_build::document_of;
use super::skeleton_files::{SkeletonFiles, TissueFile};
use super::skeleton_paths::settle_paths;
use super::spec::RegisterJob;
use crate::error::{Error, Result};
use crate::io::gltf::write_glb;
use crate::io::skeleton::{ReferenceImage, SkeletonDocument, SoftEntry};
use crate::io::{
    check_output, check_writable, file_names, read_volume, write_beside, write_ply, write_profiles,
};
use crate::register::animation::{Motion, present_angles};
use crate::register::transfer::carry_soft_tissue;
use crate::register::{Appearance, Registered};

/// What was written.
pub(crate) struct Written {
    /// The files.
    pub files: Vec<PathBuf>,
    /// What is not as the template has it, one sentence each.
    pub notes: Vec<String>,
}

/// Refuses outputs that would come to nothing, before anything is computed.
pub(crate) fn check_places(job: &RegisterJob) -> Result<()> {
    if job.out.is_none() && job.report.is_none() && job.ply_out.is_none() {
        return Err(Error::invalid("no output is named; give the result's folder with -o"));
    }
    if let Some(path) = &job.ply_out {
        check_output(path, &["ply"], "--ply-out")?;
    }
    let inside = [(&job.out, "result.skeleton.json"), (&job.report, "report.json")];
    for (folder, name) in inside {
        folder.as_ref().map_or(Ok(()), |folder| check_writable(&folder.join(name)))?;
    }
    Ok(())
}

/// Writes bones, skeleton file, scene and carried tissues.
pub(crate) fn write(
    folder: &Path,
    job: &RegisterJob,
    files: &SkeletonFiles,
    found: &Registered,
    tissues: &[TissueFile],
    motion: Option<&Motion>,
) -> Result<Written> {
    let mut written = Vec::new();
    let mut document = result_document(&files.document, found);
    let mut skeleton = found.skeleton.clone();
    let notes = settle_paths(&mut skeleton, &mut document);
    for ((bone, entry), file) in
        found.skeleton.bones.iter().zip(&document.bones).zip(&files.surfaces)
    {
        let path = folder.join(&entry.mesh);
        file.write_with_points(&path, &found.skeleton.points[bone.vertices.clone()])?;
        written.push(path);
    }
    let mut carried = Vec::new();
    let names = file_names(tissues.iter().map(|tissue| tissue.name.as_str()));
    for (tissue, own) in tissues.iter().zip(names) {
        let Tissue { name, mut mesh } = tissue.tissue()?;
        mesh.points = carry_soft_tissue(&files.skeleton, &found.skeleton.points, &mesh)?;
        let path = format!("soft/{own}.obj");
        tissue.file.write_with_points(&folder.join(&path), &mesh.points)?;
        written.push(folder.join(&path));
        document.soft.push(SoftEntry { name: name.clone(), mesh: path });
        carried.push(Tissue { name, mesh });
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
    let unit = job.metres_per_unit.unwrap_or(metres_per_unit(document.units.as_deref()));
    let scene = scene(&skeleton, &carried, motion, unit)?;
    write_glb(&path, &scene)?;
    written.push(path);
    Ok(Written { files: written, notes })
}

/// All bones with what is known at each vertex: the number of its bone and the verdict on it (0 good, 1
/// doubtful, 2 failed), whether the target shows it, and its distance to the target (not for images).
pub(crate) fn write_seen(path: &Path, distances: &[f64], found: &Registered) -> Result<()> {
    let bone_of = found.skeleton.bone_of_vertex();
    let bones: Vec<f64> = bone_of.iter().map(|&b| f64::from(b)).collect();
    let verdict = |&b: &u32| f64::from(found.bones[b as usize].verdict as u8);
    let verdicts: Vec<f64> = bone_of.iter().map(verdict).collect();
    let mut scalars: Vec<(&str, &[f64])> =
        vec![("bone", &bones), ("verdict", &verdicts), ("seen", &found.seen)];
    if distances.iter().any(|d| !d.is_nan()) {
        scalars.push(("distance", distances));
    }
    write_ply(path, &found.skeleton.surface(), &scalars)
}

/// The person's skeleton file, with all that the template's says and the figures of the result; bones
/// in `bones/`, no soft tissue yet.
pub fn result_document(template: &SkeletonDocument, found: &Registered) -> SkeletonDocument {
    let mut document = document_of(&found.skeleton, template);
    document.name_surfaces("bones");
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
