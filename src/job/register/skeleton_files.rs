//! A skeleton file with its meshes.

use std::path::{Path, PathBuf};

use super::scene::Tissue;
use super::skeleton_build::build_skeleton;
use crate::error::Result;
use crate::io::skeleton::SkeletonDocument;
use crate::io::{SurfaceFile, read_surface, read_text, stem};
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

/// A soft tissue with its file.
#[derive(Clone, Debug)]
pub struct TissueFile {
    /// Its name.
    pub name: String,
    /// Its surface.
    pub file: SurfaceFile,
}

impl TissueFile {
    /// Its surface in the skeleton's pose.
    pub(super) fn tissue(&self) -> Result<Tissue> {
        Ok(Tissue { name: self.name.clone(), mesh: self.file.mesh()? })
    }
}

/// Reads the soft tissues that a skeleton file names, `path` being the skeleton file.
pub fn read_tissues(path: &Path, document: &SkeletonDocument) -> Result<Vec<Tissue>> {
    read_tissue_files(path, document, &[])?.iter().map(TissueFile::tissue).collect()
}

/// The same with the files, and with `more` surfaces.
pub(crate) fn read_tissue_files(
    path: &Path,
    document: &SkeletonDocument,
    more: &[PathBuf],
) -> Result<Vec<TissueFile>> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let own = document.soft.iter().map(|s| (s.name.clone(), folder.join(&s.mesh)));
    let more = more.iter().map(|path| (stem(path), path.clone()));
    own.chain(more)
        .map(|(name, path)| Ok(TissueFile { name, file: read_surface(&path)? }))
        .collect()
}
