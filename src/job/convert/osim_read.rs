//! An OpenSim model as a skeleton.

use std::path::{Path, PathBuf};

use nalgebra::Point3;

use crate::error::{Error, Result};
use crate::io::osim::{OsimModel, parse_osim};
use crate::io::skeleton::SkeletonDocument;
use crate::io::vtp::read_vtp;
use crate::io::{file_name, has_extension, read_bytes, read_surface};
use crate::math::Vec3;
use crate::mesh::TriMesh;

/// Reads an OpenSim model: its skeleton, the surface of each bone in the default pose, metres, and
/// notes on what was left out.
pub fn read_osim_skeleton(path: &Path) -> Result<(SkeletonDocument, Vec<TriMesh>, Vec<String>)> {
    let bytes = read_bytes(path)?;
    let model = parse_osim(&String::from_utf8_lossy(&bytes), path)?;
    let OsimModel { mut document, world_from_body, mesh_scale, notes, .. } = model;
    let mut meshes = Vec::new();
    for (k, bone) in document.bones.iter_mut().enumerate() {
        let mut mesh = read_mesh(&find_mesh(path, &bone.mesh)?)?;
        let scale = Vec3::from(mesh_scale[k]);
        for p in &mut mesh.points {
            *p = (world_from_body[k] * Point3::from(p.component_mul(&scale))).coords;
        }
        bone.mesh = format!("bones/{}.obj", file_name(&bone.name));
        meshes.push(mesh);
    }
    Ok((document, meshes, notes))
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
