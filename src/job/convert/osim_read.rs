//! An OpenSim model as a skeleton.

use std::path::{Path, PathBuf};

use nalgebra::Point3;

use super::osim_skeleton::osim_document;
use crate::error::{Error, Result};
use crate::io::osim::model::{OsimBody, OsimMesh, OsimModel};
use crate::io::osim::pose::places;
use crate::io::skeleton::SkeletonDocument;
use crate::io::vtp::read_vtp;
use crate::io::{file_name, has_extension, read_bytes, read_surface};
use crate::job::register::skeleton_build::default_shift;
use crate::mesh::{TriMesh, diagonal};

/// Reads an OpenSim model: its skeleton, the surface of each bone in the default pose, metres, and
/// notes on what was left out. A bone has all meshes of its body, one after the other.
pub fn read_osim_skeleton(path: &Path) -> Result<(SkeletonDocument, Vec<TriMesh>, Vec<String>)> {
    let text = String::from_utf8_lossy(&read_bytes(path)?).into_owned();
    let model = OsimModel::parse(&text, path)?;
    let (mut document, notes) = osim_document(&model);
    let meshes = body_meshes(&model, path)?;
    let bones: Vec<TriMesh> = meshes.iter().map(|(_, parts)| joined(parts)).collect();
    for bone in &mut document.bones {
        bone.mesh = format!("bones/{}.obj", file_name(&bone.name));
    }
    let points: Vec<_> = bones.iter().flat_map(|m| m.points.iter().copied()).collect();
    for joint in &mut document.joints {
        joint.limits.shift = joint.limits.shift.map(|far| far + default_shift(diagonal(&points)));
    }
    Ok((document, bones, notes))
}

/// A body and its meshes in the default pose.
pub type BodyMeshes<'a> = (&'a OsimBody, Vec<TriMesh>);

/// The bodies that have meshes.
pub fn body_meshes<'a>(model: &'a OsimModel, path: &Path) -> Result<Vec<BodyMeshes<'a>>> {
    let world = places(&model.joints, &model.default_values());
    let bodies = model.bodies.iter().filter(|body| !body.meshes.is_empty());
    bodies
        .map(|body| {
            let place = world.get(&body.name).copied().unwrap_or_default();
            let read = |mesh: &OsimMesh| {
                let mut read = read_mesh(&find_mesh(path, &mesh.file)?)?;
                for p in &mut read.points {
                    let scaled = Point3::from(p.component_mul(&mesh.scale));
                    *p = (place * mesh.body_from_mesh * scaled).coords;
                }
                Ok(read)
            };
            Ok((body, body.meshes.iter().map(read).collect::<Result<_>>()?))
        })
        .collect()
}

fn joined(parts: &[TriMesh]) -> TriMesh {
    let mut whole = TriMesh::default();
    for part in parts {
        whole.append(part);
    }
    whole
}

/// A mesh beside the model, or in `Geometry/` as OpenSim looks it up.
fn find_mesh(model: &Path, name: &str) -> Result<PathBuf> {
    let folder = model.parent().unwrap_or(Path::new(""));
    let places = [folder.join(name), folder.join("Geometry").join(name)];
    places.into_iter().find(|p| p.is_file()).ok_or_else(|| {
        Error::invalid(format!(
            "the mesh {name} of {} lies neither beside it nor in Geometry/",
            model.display()
        ))
    })
}

fn read_mesh(path: &Path) -> Result<TriMesh> {
    if has_extension(path, "vtp") {
        return read_vtp(path);
    }
    read_surface(path)?.mesh()
}
