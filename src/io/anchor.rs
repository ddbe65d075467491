//! A place on the template as a file names it: a vertex number, a position, or both.

use std::path::{Path, PathBuf};

use super::table::{Row, Table};
use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::mesh::TriMesh;

/// A vertex is at a given position if it is nearer than this share of the template's diagonal:
/// files print positions with a few decimals.
const SAME_PLACE: f64 = 1e-4;

/// A place on the template; a vertex number (from 0), a position or both are there.
#[derive(Clone, Debug, PartialEq)]
pub struct Anchor {
    /// The vertex number the file gives.
    pub vertex: Option<u32>,
    /// The position the file gives.
    pub position: Option<Vec3>,
    /// The file and its 1-based line, for errors.
    pub source: (PathBuf, usize),
}

/// A place on a given template.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResolvedAnchor {
    /// Where it is.
    pub position: Vec3,
    /// The vertex there, if the file names one.
    pub vertex: Option<u32>,
}

impl Anchor {
    /// Finds the place on `template`. A file's position counts more than its vertex number: if both
    /// are there and disagree (the file was made for a mesh of other vertices), the number is left
    /// out. A lone vertex number that `template` does not have is an error.
    pub fn resolve(&self, template: &TriMesh) -> Result<ResolvedAnchor> {
        let at_vertex = self.vertex.and_then(|v| template.points.get(v as usize)).copied();
        match (self.position, at_vertex) {
            (Some(position), Some(point)) => {
                let same = (position - point).norm() <= SAME_PLACE * template.diagonal();
                Ok(ResolvedAnchor { position, vertex: self.vertex.filter(|_| same) })
            }
            (Some(position), None) => Ok(ResolvedAnchor { position, vertex: None }),
            (None, Some(position)) => Ok(ResolvedAnchor { position, vertex: self.vertex }),
            (None, None) => {
                let (path, line) = &self.source;
                let vertex = self.vertex.map_or_else(|| "none".to_owned(), |v| v.to_string());
                Err(Error::parse(
                    path,
                    *line,
                    format!(
                        "vertex {vertex} is not on the template, whose vertices are numbered 0 to {}",
                        template.points.len().saturating_sub(1)
                    ),
                ))
            }
        }
    }
}

/// The columns an [`Anchor`] is read from.
pub(super) struct AnchorColumns {
    vertex: Option<usize>,
    position: Option<[usize; 3]>,
}

impl AnchorColumns {
    /// Finds `vertex` and the position columns of the first prefix that is there; an error if
    /// neither is.
    pub fn find(table: &Table, prefixes: &[&str]) -> Result<Self> {
        let found = Self {
            vertex: table.column(&["vertex", "template_vertex"]),
            position: table.point_columns(prefixes),
        };
        if found.vertex.is_none() && found.position.is_none() {
            let names: Vec<String> = prefixes.iter().map(|p| format!("{p}x")).collect();
            return Err(table.missing(&format!("vertex or {} (with y and z)", names.join(" or "))));
        }
        Ok(found)
    }

    pub fn read(&self, row: Row, path: &Path) -> Result<Anchor> {
        Ok(Anchor {
            vertex: self.vertex.map(|column| row.vertex(column)).transpose()?,
            position: self.position.map(|columns| row.point(columns)).transpose()?,
            source: (path.to_path_buf(), row.place().line),
        })
    }
}
