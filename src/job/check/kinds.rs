//! What a file holds and what is wrong with it, in words, by its kind.

use std::path::Path;

use serde_json::Value;

use super::file_check::{FileCheck, extent};
use super::skeleton::{osim_file, skeleton_file};
use crate::error::{Error, Result, Shown};
use crate::io;
use crate::io::bvh::read_bvh;
use crate::io::mot::read_motion;
use crate::io::skeleton::FORMAT;
use crate::job::reshape::inputs::Inputs;
use crate::job::reshape::spec::ReshapeJob;
use crate::math::Vec3;
use crate::mesh::{SurfaceCheck, TetQuality};

/// Looks at a surface, markers, a tet mesh, pairs, an image, a skeleton, a motion or a job. Files that cannot be
/// read are errors.
pub fn check_file(path: &Path) -> Result<FileCheck> {
    if io::is_volume(path) {
        return volume(path);
    }
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    match extension.as_deref() {
        Some("obj" | "stl") => surface(path),
        Some("ply") => surface(path).or_else(|_| markers(path)),
        Some("node" | "ele" | "vtu" | "veg" | "msh") => tets(path),
        Some("csv") => table(path),
        Some("toml") => job(path),
        Some("osim") => osim_file(path),
        Some("mot" | "sto" | "bvh") => motion(path),
        Some("json") if is_skeleton(path) => skeleton_file(path),
        Some("json" | "fcsv" | "pp" | "txt" | "xyz" | "pts" | "tsv") => markers(path),
        _ => Err(Error::Unsupported(format!(
            "{}: this kind of file is not known; surfaces, markers, tet meshes, images, skeletons, motions and job files are",
            path.shown()
        ))),
    }
}

fn surface(path: &Path) -> Result<FileCheck> {
    let mesh = io::read_surface(path)?.mesh()?;
    let check = SurfaceCheck::new(&mesh);
    let mut findings = check.sentences(&mesh);
    if check.is_closed() && mesh.volume() < 0.0 {
        findings.push("the surface is inside out: its normals point inwards; flip them".to_owned());
    }
    let closed = if check.is_closed() { "closed" } else { "not closed" };
    Ok(FileCheck {
        content: format!(
            "a surface of {} vertices and {} triangles, {closed}, {}",
            mesh.points.len(),
            mesh.triangles.len(),
            extent(&mesh.points)
        ),
        findings,
    })
}

fn markers(path: &Path) -> Result<FileCheck> {
    let markers = io::read_markers(path)?;
    let points: Vec<Vec3> = markers.iter().map(|m| m.position).collect();
    let mut sorted: Vec<[u64; 3]> =
        points.iter().map(|p| [p.x, p.y, p.z].map(|c| (c + 0.0).to_bits())).collect();
    sorted.sort_unstable();
    let doubles = sorted.windows(2).filter(|pair| pair[0] == pair[1]).count();
    let mut findings = Vec::new();
    if doubles > 0 {
        findings.push(format!("{doubles} markers are exactly where another one is; remove them"));
    }
    if markers.len() < 3 {
        findings.push("fewer than three markers do not determine a shape".to_owned());
    }
    let content = format!("{} markers, {}", markers.len(), extent(&points));
    Ok(FileCheck { content, findings })
}

fn volume(path: &Path) -> Result<FileCheck> {
    const MOST_LABELS: usize = 200;
    let io::VolumeFile { volume, format, notes, label_names } = io::read_volume(path)?;
    let [i, j, k] = volume.size();
    let spacing = volume.spacing();
    let [low, high] = volume.range();
    let corners = volume.corners();
    let labels = volume.labels().filter(|l| !l.is_empty() && l.len() <= MOST_LABELS);
    let values = labels.map_or(format!("values {low} to {high}"), |labels| {
        let name = |l| label_names.get(l).map_or(String::new(), |name| format!("{name}, "));
        let list: Vec<String> =
            labels.iter().map(|(l, n)| format!("{l} ({}{n} voxels)", name(l))).collect();
        format!("labels {}", list.join(", "))
    });
    Ok(FileCheck {
        content: format!(
            "a {format} image of {i} x {j} x {k} voxels of {:.3} x {:.3} x {:.3} mm, indices along {}, {}, {values}",
            spacing.x,
            spacing.y,
            spacing.z,
            volume.orientation(),
            extent(&corners)
        ),
        findings: notes,
    })
}

fn tets(path: &Path) -> Result<FileCheck> {
    let mesh = io::read_tets(path)?;
    let content = format!("{}, {}", TetQuality::of_mesh(&mesh), extent(&mesh.points));
    Ok(FileCheck { content: content.replace('\n', ", "), findings: Vec::new() })
}

/// Whether a `.json` file lists bones or says that it is a skeleton file.
fn is_skeleton(path: &Path) -> bool {
    let value = io::read_bytes(path).ok().and_then(|b| serde_json::from_slice::<Value>(&b).ok());
    value.is_some_and(|v| v.get("bones").is_some() || v["format"] == FORMAT)
}

fn motion(path: &Path) -> Result<FileCheck> {
    let (count, what, frames, seconds) = if io::has_extension(path, "bvh") {
        let bvh = read_bvh(path)?;
        let last = bvh.frames.len().saturating_sub(1) as f64;
        (bvh.nodes.len(), "nodes", bvh.frames.len(), [0.0, last * bvh.frame_seconds])
    } else {
        let table = read_motion(path)?;
        let ends =
            [table.times.first(), table.times.last()].map(|t| t.copied().unwrap_or_default());
        (table.names.len(), "columns", table.times.len(), ends)
    };
    let [first, last] = seconds;
    let content = format!("a motion of {count} {what} in {frames} frames, {first} to {last} s");
    Ok(FileCheck { content, findings: Vec::new() })
}

/// A CSV file is what its columns make it.
fn table(path: &Path) -> Result<FileCheck> {
    let counted = |count: usize, what: &str| FileCheck {
        content: format!("{count} {what}"),
        findings: Vec::new(),
    };
    if let Ok(list) = io::read_landmarks(path) {
        return Ok(counted(list.len(), "landmarks"));
    }
    if let Ok(list) = io::read_attachments(path) {
        return Ok(counted(list.len(), "attachments"));
    }
    match markers(path) {
        Err(error) => {
            io::read_fixed(path).map(|list| counted(list.len(), "fixed points")).map_err(|_| error)
        }
        found => found,
    }
}

/// All files of a job, and whether they fit each other.
fn job(path: &Path) -> Result<FileCheck> {
    let job = ReshapeJob::read(path)?;
    let inputs = Inputs::read(&job)?;
    let mut findings = inputs.warnings.clone();
    findings.extend(inputs.inspect(job.align.unwrap_or_default().freedom())?);
    Ok(FileCheck {
        content: format!(
            "a job: template of {} vertices, {} markers, {} landmarks, {} attachments, {} fixed vertices",
            inputs.surface.points.len(),
            inputs.markers.len(),
            inputs.landmarks.len(),
            inputs.attachments.len(),
            inputs.fixed.len()
        ),
        findings,
    })
}
