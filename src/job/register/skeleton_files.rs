//! A skeleton file with its meshes.

use std::path::Path;

use super::skeleton_build::build_skeleton;
use crate::error::Result;
use crate::io::skeleton::SkeletonDocument;
use crate::io::{SurfaceFile, read_surface, read_text};
use crate::mesh::TriMesh;
use crate::register::Skeleton;

/// A template with its files.
#[derive(Clone, Debug)]
pub struct SkeletonFiles {
    /// The skeleton file.
    pub document: SkeletonDocument,
    /// The skeleton.
    pub skeleton: Skeleton,
    /// The bones' mesh files, in their order.
    pub surfaces: Vec<SurfaceFile>,
}

/// Reads a skeleton file and the meshes it names.
pub fn read_skeleton(path: &Path) -> Result<SkeletonFiles> {
    let document = SkeletonDocument::parse(&read_text(path)?, path)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let surfaces: Vec<SurfaceFile> = document
        .bones
        .iter()
        .map(|b| read_surface(&folder.join(&b.mesh)))
        .collect::<Result<_>>()?;
    let meshes = surfaces.iter().map(SurfaceFile::mesh).collect::<Result<Vec<TriMesh>>>()?;
    let skeleton = build_skeleton(&document, meshes)?;
    Ok(SkeletonFiles { document, skeleton, surfaces })
}
