//! The files of a job, read.

use std::path::{Path, PathBuf};

use super::attach::attachments;
use super::spec::ReshapeJob;
use crate::align::Freedom;
use crate::error::{Error, Result, Shown};
use crate::io::{self, Anchor, Marker, SurfaceFile};
use crate::math::Vec3;
use crate::mesh::TriMesh;
use crate::reshape::{Data, Pair, inspect_data};

/// All that a job reads.
#[derive(Clone, Debug)]
pub struct Inputs {
    /// Where the template is from.
    pub template_path: PathBuf,
    /// The template's file, for writing it back.
    pub template: SurfaceFile,
    /// Its surface.
    pub surface: TriMesh,
    /// Points on the person's surface.
    pub markers: Vec<Marker>,
    /// Paired points.
    pub landmarks: Vec<Pair>,
    /// Attachments.
    pub attachments: Vec<Pair>,
    /// Vertices that stay.
    pub fixed: Vec<u32>,
    /// Meshes to carry along: path, file, vertices.
    pub carried: Vec<(PathBuf, SurfaceFile, Vec<Vec3>)>,
    /// What the user should know, one sentence each.
    pub warnings: Vec<String>,
}

impl Inputs {
    /// Reads all files that `job` names.
    pub fn read(job: &ReshapeJob) -> Result<Self> {
        let path = job.template.as_ref().ok_or_else(|| {
            Error::invalid(
                "no template is given; name a surface file with --template or in the job",
            )
        })?;
        let template = io::read_surface(path)?;
        let surface = template.mesh()?;
        let mut warnings = Vec::new();
        let mut markers = Vec::new();
        for path in job.markers.iter().flatten() {
            markers.extend(io::read_markers(path)?);
        }
        let files = job.landmarks.as_deref().unwrap_or_default();
        let (landmarks, unpaired) = read_landmark_pairs(files, &surface)?;
        warnings.extend(unpaired);
        let attachments = attachments(job, &surface)?;
        let fixed = job.fixed.as_deref().map(|path| read_fixed_vertices(path, &surface));
        let carried = job.carry.iter().flatten();
        let carried = carried.map(|path| {
            let file = io::read_surface(path)?;
            let points = file.mesh()?.points;
            Ok((path.clone(), file, points))
        });
        Ok(Self {
            template_path: path.clone(),
            carried: carried.collect::<Result<_>>()?,
            template,
            surface,
            markers,
            landmarks,
            attachments,
            fixed: fixed.transpose()?.unwrap_or_default(),
            warnings,
        })
    }

    /// Checks the inputs against each other, see [`inspect_data`].
    pub fn inspect(&self, align: Option<Freedom>) -> Result<Vec<String>> {
        let counted = self.markers.iter().filter(|m| m.weight.is_none_or(|w| w > 0.0));
        let data = Data {
            surface: (&self.surface, &self.template_path.shown()),
            markers: &counted.map(|m| m.position).collect::<Vec<_>>(),
            landmarks: &self.landmarks,
            attachments: &self.attachments,
            fixed: &self.fixed,
        };
        inspect_data(&data, align)
    }
}

/// Reads landmarks from one file of pairs, or from two marker files (template, person) whose points
/// are paired by label; found on `surface`. Comes with a sentence if labels were left out.
pub fn read_landmark_pairs(
    files: &[PathBuf],
    surface: &TriMesh,
) -> Result<(Vec<Pair>, Option<String>)> {
    let (list, warning) = io::read_landmark_files(files)?;
    let pair = |(l, landmark): (usize, io::Landmark)| {
        let place = landmark.anchor.resolve(surface)?;
        Ok(Pair {
            label: landmark.label.unwrap_or_else(|| l.to_string()),
            position: place.position,
            vertex: place.vertex,
            target: landmark.target,
            weight: landmark.weight.unwrap_or(1.0),
            within: landmark.within,
        })
    };
    Ok((list.into_iter().enumerate().map(pair).collect::<Result<_>>()?, warning))
}

/// Reads fixed points: the vertices of `surface` that the file names, or the nearest ones, because
/// the solver holds vertices. Sorted, each once.
pub fn read_fixed_vertices(path: &Path, surface: &TriMesh) -> Result<Vec<u32>> {
    let mut vertices = Vec::new();
    for anchor in io::read_fixed(path)? {
        vertices.push(nearest_vertex(&anchor, surface, path)?);
    }
    vertices.sort_unstable();
    vertices.dedup();
    Ok(vertices)
}

fn nearest_vertex(anchor: &Anchor, surface: &TriMesh, path: &Path) -> Result<u32> {
    let place = anchor.resolve(surface)?;
    if let Some(vertex) = place.vertex {
        return Ok(vertex);
    }
    let distance = |v: usize| (surface.points[v] - place.position).norm();
    let nearest = (0..surface.points.len()).min_by(|&a, &b| distance(a).total_cmp(&distance(b)));
    let nearest =
        nearest.ok_or_else(|| Error::parse(path, None, "the template has no vertices"))?;
    if distance(nearest) > FIXED_REACH * surface.diagonal() {
        let p = place.position;
        return Err(Error::parse(
            path,
            anchor.source.1,
            format!(
                "the fixed point ({}, {}, {}) is {:.3} from the nearest vertex; fixed points must lie on the template",
                p.x,
                p.y,
                p.z,
                distance(nearest)
            ),
        ));
    }
    Ok(nearest as u32)
}

/// A fixed point farther than this share of the template's diagonal from every vertex is a mistake.
const FIXED_REACH: f64 = 0.05;
