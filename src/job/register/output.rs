//! The files a registration writes.

use std::path::{Path, PathBuf};

use nalgebra::Isometry3;
use serde_json::json;

use super::run::{RegisterJob, SkeletonFiles};
use super::skeleton_build::skeleton_document;
use crate::error::Result;
use crate::io::gltf::{GltfNode, GltfScene, write_glb};
use crate::io::skeleton::{ReferenceImage, SkeletonDocument, SoftEntry};
use crate::io::{SurfaceFile, read_surface, read_volume, write_beside, write_profiles};
use crate::register::animation::{Motion, animate, present_angles};
use crate::register::transfer::carry_soft_tissue;
use crate::register::{Appearance, Registered, Skeleton};

/// A soft tissue surface to carry.
pub(crate) struct Carried {
    name: String,
    file: SurfaceFile,
}

/// A name without anything that means something in a path.
pub fn file_name(name: &str) -> String {
    let safe = |c: char| if c.is_alphanumeric() || "_-.".contains(c) { c } else { '_' };
    let cleaned: String = name.chars().map(safe).collect();
    cleaned.trim_start_matches('.').to_string()
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

/// The skeleton as a tree of nodes, each in the frame of the joint it hangs on.
pub fn scene(
    skeleton: &Skeleton,
    motion: Option<&Motion>,
    metres_per_unit: f64,
) -> Result<GltfScene> {
    let forest = skeleton.spanning_forest(0);
    let mut frame = vec![Isometry3::identity(); skeleton.bones.len()];
    let mut hangs: Vec<Option<(usize, usize)>> = vec![None; skeleton.bones.len()];
    let mut order: Vec<usize> = Vec::new();
    for &(j, to_child) in &forest {
        let joint = &skeleton.joints[j];
        let (near, far, own) = if to_child {
            (joint.parent, joint.child, joint.child_frame)
        } else {
            (joint.child, joint.parent, joint.parent_frame)
        };
        frame[far] = own;
        hangs[far] = Some((near, j));
        order.push(far);
    }
    let roots: Vec<usize> = (0..skeleton.bones.len()).filter(|&b| hangs[b].is_none()).collect();
    let order: Vec<usize> = roots.into_iter().chain(order).collect();
    let node_of = |bone: usize| order.iter().position(|&b| b == bone);
    let poses = motion.map(|m| animate(skeleton, 0, m)).transpose()?.unwrap_or_default();
    let nodes = order.iter().map(|&b| {
        let local = |motions: Option<&Vec<Isometry3<f64>>>| {
            let world = |b: usize| motions.map_or(frame[b], |m| m[b] * frame[b]);
            hangs[b].map_or_else(|| world(b), |(near, _)| world(near).inv_mul(&world(b)))
        };
        let mut mesh = skeleton.bone_surface(b, &skeleton.points);
        for p in &mut mesh.points {
            *p = frame[b].inverse_transform_point(&(*p).into()).coords;
        }
        GltfNode {
            name: skeleton.bones[b].name.clone(),
            parent: hangs[b].and_then(|(near, _)| node_of(near)),
            local: local(None),
            mesh,
            extras: hangs[b].map_or(serde_json::Value::Null, |(_, j)| limits_value(skeleton, j)),
            track: poses.iter().map(|p| local(Some(p))).collect(),
        }
    });
    let times = motion.map(|m| m.times.clone()).unwrap_or_default();
    Ok(GltfScene { nodes: nodes.collect(), times, metres_per_unit })
}

fn limits_value(skeleton: &Skeleton, j: usize) -> serde_json::Value {
    let joint = &skeleton.joints[j];
    let degrees = |v: &crate::math::Vec3| {
        v.iter().map(|x| x.is_finite().then(|| x.to_degrees())).collect::<Vec<_>>()
    };
    json!({"joint": joint.name, "limits": {
        "neg_deg": degrees(&joint.limits.negative), "pos_deg": degrees(&joint.limits.positive),
        "shift": joint.limits.shift, "shape": "ellipsoid"
    }})
}
