//! The files of a job, read.

use std::path::{Path, PathBuf};

use super::attach::{AttachmentPair, attachments};
use super::spec::ReshapeJob;
use crate::error::{Error, Result};
use crate::io::{self, Anchor, Marker, SurfaceFile};
use crate::math::Vec3;
use crate::mesh::TriMesh;

/// A paired point with its place on the template.
#[derive(Clone, Debug, PartialEq)]
pub struct Pair {
    /// Its name, else its number.
    pub label: String,
    /// Where it is on the template.
    pub position: Vec3,
    /// The template's vertex there, if the file names one.
    pub vertex: Option<u32>,
    /// Where it is on the person.
    pub target: Vec3,
    /// Relative weight.
    pub weight: f64,
}

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
    pub attachments: Vec<AttachmentPair>,
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
        let landmarks = landmarks(job, &surface, &mut warnings)?;
        let attachments = attachments(job, &surface)?;
        let fixed = fixed(job, &surface)?;
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
            fixed,
            warnings,
        })
    }
}

fn landmarks(job: &ReshapeJob, surface: &TriMesh, warnings: &mut Vec<String>) -> Result<Vec<Pair>> {
    let list = match job.landmarks.as_deref() {
        None | Some([]) => return Ok(Vec::new()),
        Some([pairs]) => io::read_landmarks(pairs)?,
        Some([template, person]) => {
            let paired = io::pair_by_label(template, person)?;
            if !paired.unpaired.is_empty() {
                warnings.push(format!(
                    "landmarks that only one of the two files has are left out: {}",
                    paired.unpaired.join(", ")
                ));
            }
            paired.landmarks
        }
        Some(more) => {
            return Err(Error::invalid(format!(
                "{} landmark files are given; one file of pairs or two files paired by label are needed",
                more.len()
            )));
        }
    };
    list.into_iter()
        .enumerate()
        .map(|(l, landmark)| {
            let place = landmark.anchor.resolve(surface)?;
            Ok(Pair {
                label: landmark.label.unwrap_or_else(|| l.to_string()),
                position: place.position,
                vertex: place.vertex,
                target: landmark.target,
                weight: landmark.weight.unwrap_or(1.0),
            })
        })
        .collect()
}

/// The vertices that fixed points name, or the nearest ones: the solver holds vertices.
fn fixed(job: &ReshapeJob, surface: &TriMesh) -> Result<Vec<u32>> {
    let Some(path) = &job.fixed else { return Ok(Vec::new()) };
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
