//! How well a surface meets a label of a label map.

use rayon::prelude::*;
use serde::Serialize;

use super::distances::{Spread, marker_distances};
use crate::error::{Error, Result};
use crate::locate::{NearestPoints, WindingNumber};
use crate::math::Vec3;
use crate::mesh::TriMesh;
use crate::volume::outline::is_label;
use crate::volume::{Clicks, View, Volume, label_markers};

/// A surface beside a label. Only what lies within the image counts: beyond it nothing is known.
#[derive(Clone, Debug, Serialize)]
pub struct LabelFit {
    /// The label.
    pub label: u32,
    /// Twice the common volume over the sum of both: 1 = the same.
    pub dice: f64,
    /// Volume of the label, ml.
    pub label_ml: f64,
    /// Volume of the surface within the image, ml.
    pub surface_ml: f64,
    /// Distance of the label's outlines (on slices of all three views) to the surface, mm.
    pub label_to_surface: Spread,
    /// Distance of the surface's vertices to the nearest point of the outlines, mm. The points are half
    /// a voxel apart, so that a perfect surface has some tenths of a voxel here.
    pub surface_to_label: Spread,
}

impl LabelFit {
    /// Compares `mesh` (RAS, mm) with `label`.
    pub fn new(mesh: &TriMesh, labels: &Volume, label: u32) -> Result<Self> {
        if mesh.triangles.is_empty() {
            return Err(Error::invalid("the surface has no triangles"));
        }
        let voxel = labels.spacing().min();
        let clicks = Clicks { every: voxel, spacing: voxel / 2.0, ..Clicks::default() };
        let views = [View::Axial, View::Coronal, View::Sagittal];
        let outline = label_markers(labels, label, &views, &clicks)?;
        let nearest = NearestPoints::new(&outline);
        let to_label: Vec<f64> = mesh
            .points
            .par_iter()
            .filter(|p| is_well_inside(labels, p))
            .filter_map(|p| nearest.nearest(p).map(|(_, distance)| distance))
            .collect();
        let [both, of_label, of_surface] = count_voxels(mesh, labels, label);
        let millilitres = labels.world_from_voxel().determinant().abs() / 1000.0;
        Ok(Self {
            label,
            dice: 2.0 * both as f64 / (of_label + of_surface).max(1) as f64,
            label_ml: of_label as f64 * millilitres,
            surface_ml: of_surface as f64 * millilitres,
            label_to_surface: Spread::of(&marker_distances(
                &mesh.points,
                &mesh.triangles,
                &outline,
            )),
            surface_to_label: Spread::of(&to_label),
        })
    }
}

/// Not within a voxel of the image's border, where outlines end.
fn is_well_inside(labels: &Volume, point: &Vec3) -> bool {
    let (voxel, size) = (labels.voxel(point), labels.size());
    (0..3).all(|axis| voxel[axis] >= 1.0 && voxel[axis] <= size[axis] as f64 - 2.0)
}

/// Voxels in both, of the label, inside the surface.
fn count_voxels(mesh: &TriMesh, labels: &Volume, label: u32) -> [usize; 3] {
    let size = labels.size();
    let winding = WindingNumber::new(&mesh.points, &mesh.triangles);
    let (low, high) = crate::mesh::bounding_box(&mesh.points).unwrap_or_default();
    let one = |v: usize| {
        let index = Vec3::new(
            (v % size[0]) as f64,
            (v / size[0] % size[1]) as f64,
            (v / (size[0] * size[1])) as f64,
        );
        let at = labels.world(&index);
        let near = (0..3).all(|axis| at[axis] >= low[axis] && at[axis] <= high[axis]);
        let inside = near && winding.is_inside(&at);
        let of_label = is_label(labels.values()[v], label);
        [inside && of_label, of_label, inside].map(usize::from)
    };
    let add = |a: [usize; 3], b: [usize; 3]| [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
    (0..labels.values().len()).into_par_iter().map(one).reduce(|| [0; 3], add)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Mat3;
    use crate::mesh::test_shapes::cube;

    #[test]
    fn a_box_beside_a_shifted_box() {
        // Label 1 from 10 to 30 mm on all axes, in voxels of 2 mm.
        let inside = |i: usize| (5..15).contains(&i);
        let value = |v: usize| inside(v % 20) && inside(v / 20 % 20) && inside(v / 400);
        let values = (0..8000).map(|v| f32::from(u8::from(value(v)))).collect();
        let labels =
            Volume::new([20; 3], values, Mat3::identity() * 2.0, Vec3::repeat(1.0)).unwrap();
        let at = |shift: f64| {
            let mut mesh = cube();
            for p in &mut mesh.points {
                *p = Vec3::repeat(10.0) + *p * 20.0 + Vec3::x() * shift;
            }
            mesh
        };
        let same = LabelFit::new(&at(0.0), &labels, 1).unwrap();
        assert!((same.dice - 1.0).abs() < 1e-12 && (same.label_ml - 8.0).abs() < 1e-9);
        assert!(same.label_to_surface.mean < 0.3, "{same:?}");
        let moved = LabelFit::new(&at(4.0), &labels, 1).unwrap();
        assert!((moved.dice - 0.8).abs() < 1e-12, "{moved:?}");
        assert!(moved.label_to_surface.max > 3.5);
    }
}
