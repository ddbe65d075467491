//! Markers that the image itself gives: where the user marked nothing, the result's vertices look
//! along their normals for the kind of border that the image shows at marked places.
//!
//! Beyond both papers, off by default. What it finds is weaker evidence than the user's markers: it
//! only speaks where they are silent, counts less, and is reported on its own.

use serde::Serialize;

use super::problem::Marker;
use crate::error::{Error, Result};
use crate::locate::NearestPoints;
use crate::math::{Vec3, median};
use crate::measure::Spread;
use crate::mesh::adjacency::vertex_neighbours;
use crate::mesh::{TriMesh, adjacency};
use crate::volume::{Profiles, Volume};

/// Profiles reach so many of the image's smallest voxel sizes to each side.
const PROFILE_VOXELS: f64 = 4.0;
/// Samples of a profile, in smallest voxel sizes.
const STEP_VOXELS: f64 = 0.5;
/// Borders are searched so far to each side, in smallest voxel sizes.
const RANGE_VOXELS: f64 = 2.0;
/// The border at a place is compared with that of so many marked places near by.
const MODELS: usize = 8;
/// Correlations below this say nothing; 1 says all.
const LEAST_SCORE: f64 = 0.7;
/// A find that differs by more than this from the middle one of its neighbours (in voxel sizes) is
/// noise.
const DISAGREEMENT: f64 = 0.75;
/// Weight of a find with full confidence, beside 1 for a user's marker.
const WEIGHT: f64 = 0.5;
/// Fewer marked places than this are no model.
const LEAST_MODELS: usize = 20;

/// What the image added.
#[derive(Clone, Debug, Serialize)]
pub struct Refinement {
    /// Markers added.
    pub added: usize,
    /// Vertices without a user's marker near by.
    pub looked: usize,
    /// Their confidence, 0 to 1.
    pub confidence: Spread,
    /// How far the image's border was from the result of the user's markers alone.
    pub shift: Spread,
    /// The user's markers with the result before the image was asked.
    pub marker_distance_before: Spread,
}

/// Looks for the organ's border around `result`. Returns markers with their weights, and what was
/// found in figures.
pub fn find_borders(
    volume: &Volume,
    result: &TriMesh,
    users: &[Vec3],
    before: Spread,
) -> Result<(Vec<Marker>, Refinement)> {
    let voxel = volume.spacing().min();
    let normals = result.vertex_normals();
    let own = Profiles::new(
        volume,
        &result.points,
        &normals,
        PROFILE_VOXELS * voxel,
        STEP_VOXELS * voxel,
    )?;
    let nearest = NearestPoints::new(users);
    let to_user: Vec<f64> =
        result.points.iter().map(|p| nearest.nearest(p).map_or(f64::MAX, |(_, d)| d)).collect();
    let near = voxel.max(mean_edge(result));
    let complete = |v: &usize| own.of(*v).iter().all(|value| value.is_finite());
    let models: Vec<usize> =
        (0..to_user.len()).filter(|&v| to_user[v] <= near).filter(complete).collect();
    if models.len() < LEAST_MODELS {
        return Err(Error::invalid(format!(
            "only {} vertices lie at a marker within the image; to refine by the image {LEAST_MODELS} are needed",
            models.len()
        )));
    }
    let wanted = Profiles::from_values(own.step(), own.half(), expected(&own, result, &models))?;
    let found = wanted.find(volume, &result.points, &normals, RANGE_VOXELS * voxel);
    let shifts: Vec<Option<f64>> = found.iter().map(|m| m.map(|m| m.shift)).collect();
    let around = vertex_neighbours(result.points.len(), &result.triangles);
    let spacing = 2.0 * near;
    let mut taken: Vec<Vec3> = Vec::new();
    let (mut markers, mut confidences, mut moves) = (Vec::new(), Vec::new(), Vec::new());
    for (v, seen) in found.iter().enumerate() {
        let Some(seen) = seen else { continue };
        let agrees = middle(&shifts, around.of(v))
            .is_some_and(|middle| (middle - seen.shift).abs() <= DISAGREEMENT * voxel);
        let at_end = seen.shift.abs() >= (RANGE_VOXELS - STEP_VOXELS) * voxel;
        let confidence = (seen.score - LEAST_SCORE) / (1.0 - LEAST_SCORE);
        let place = result.points[v] + normals[v] * seen.shift;
        let crowded = taken.iter().any(|p| (p - place).norm() < spacing);
        if to_user[v] <= spacing || !agrees || at_end || confidence <= 0.0 || crowded {
            continue;
        }
        taken.push(place);
        markers.push(Marker { weight: WEIGHT * confidence, ..Marker::at(place) });
        confidences.push(confidence);
        moves.push(seen.shift.abs());
    }
    let refinement = Refinement {
        added: markers.len(),
        looked: to_user.iter().filter(|d| **d > spacing).count(),
        confidence: Spread::of(&confidences),
        shift: Spread::of(&moves),
        marker_distance_before: before,
    };
    Ok((markers, refinement))
}

/// The profile each vertex should show: the mean of those at the nearest marked vertices.
fn expected(own: &Profiles, result: &TriMesh, models: &[usize]) -> Vec<f32> {
    let length = 2 * own.half() + 1;
    let mut values = Vec::with_capacity(result.points.len() * length);
    for p in &result.points {
        let mut order: Vec<(f64, usize)> =
            models.iter().map(|&m| ((result.points[m] - p).norm_squared(), m)).collect();
        let count = MODELS.min(order.len());
        order.select_nth_unstable_by(count - 1, |a, b| a.0.total_cmp(&b.0));
        for s in 0..length {
            let sum: f32 = order[..count].iter().map(|&(_, m)| own.of(m)[s]).sum();
            values.push(sum / count as f32);
        }
    }
    values
}

/// The middle one of the neighbours' shifts; none where fewer than half of them have one.
fn middle(shifts: &[Option<f64>], around: &[u32]) -> Option<f64> {
    let known: Vec<f64> = around.iter().filter_map(|&v| shifts[v as usize]).collect();
    if 2 * known.len() < around.len() { None } else { median(known) }
}

fn mean_edge(mesh: &TriMesh) -> f64 {
    let edges = adjacency::edges(&mesh.triangles);
    let length = |e: &[u32; 2]| (mesh.points[e[0] as usize] - mesh.points[e[1] as usize]).norm();
    edges.iter().map(length).sum::<f64>() / edges.len().max(1) as f64
}
