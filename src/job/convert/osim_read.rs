//! An OpenSim model as a skeleton.

use std::path::{Path, PathBuf};

use nalgebra::{Isometry3, Point3};

use super::osim_skeleton::osim_document;
use crate::error::{Error, Result, Shown};
use crate::io::osim::model::{OsimBody, OsimMesh, OsimModel};
use crate::io::osim::pose::places;
use crate::io::skeleton::SkeletonDocument;
use crate::io::vtp::read_vtp;
use crate::io::{has_extension, read_bytes, read_surface};
use crate::job::register::skeleton_build::default_shift;
use crate::mesh::{TriMesh, diagonal};

/// A model with all that it names.
pub struct OsimFiles {
    /// Text of the file.
    pub text: String,
    /// What it says.
    pub model: OsimModel,
    /// The meshes of each body that has some, in the default pose, metres.
    pub meshes: Vec<Vec<TriMesh>>,
}

impl OsimFiles {
    /// Reads a model and its meshes.
    pub fn read(path: &Path) -> Result<Self> {
        let text = String::from_utf8_lossy(&read_bytes(path)?).into_owned();
        let model = OsimModel::parse(&text, path)?;
        let world = places(&model.joints, &model.default_values());
        let placed = |body: &OsimBody| {
            let place = world.get(&body.name).copied().unwrap_or_default();
            let meshes = body.meshes.iter();
            meshes.map(|mesh| read_mesh(path, mesh, &(place * mesh.body_from_mesh))).collect()
        };
        let meshes = model.bodies_with_meshes().map(placed).collect::<Result<_>>()?;
        Ok(Self { text, model, meshes })
    }

    /// The skeleton, the surface of each bone, and notes on what was left out. A bone has all meshes of its
    /// body, one after the other.
    pub fn skeleton(&self) -> (SkeletonDocument, Vec<TriMesh>, Vec<String>) {
        let (mut document, notes) = osim_document(&self.model);
        let bones: Vec<TriMesh> = self.meshes.iter().map(|parts| joined(parts)).collect();
        let points: Vec<_> = bones.iter().flat_map(|m| m.points.iter().copied()).collect();
        let more = default_shift(diagonal(&points));
        for joint in &mut document.joints {
            joint.limits.shift = joint.limits.shift.map(|far| far + more);
        }
        (document, bones, notes)
    }
}

/// Reads an OpenSim model as a skeleton, metres: see [`OsimFiles::skeleton`].
pub fn read_osim_skeleton(path: &Path) -> Result<(SkeletonDocument, Vec<TriMesh>, Vec<String>)> {
    Ok(OsimFiles::read(path)?.skeleton())
}

fn read_mesh(model: &Path, mesh: &OsimMesh, place: &Isometry3<f64>) -> Result<TriMesh> {
    let path = find_mesh(model, &mesh.file)?;
    let vtp = has_extension(&path, "vtp");
    let mut read = if vtp { read_vtp(&path)? } else { read_surface(&path)?.mesh()? };
    for p in &mut read.points {
        *p = (place * Point3::from(p.component_mul(&mesh.scale))).coords;
    }
    Ok(read)
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
            model.shown()
        ))
    })
}
