//! A grid of numbers with its place in the world.

use crate::error::{Error, Result};
use crate::math::{Mat3, Vec3};

/// More voxels than this are refused: 4 GiB of values.
pub const MAX_VOXELS: usize = 1 << 30;

/// Points so far (in voxels) beyond the outermost voxel centres still get the border's value: the
/// voxels' own half width.
const HALF_VOXEL: f64 = 0.5;

/// A scalar image: intensities, or labels as whole numbers. Millimetres, RAS.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    size: [usize; 3],
    values: Vec<f32>,
    /// Columns: the step of one voxel along each index axis.
    world_from_voxel: Mat3,
    /// World position of voxel (0, 0, 0)'s centre.
    origin: Vec3,
    voxel_from_world: Mat3,
}

/// Of more labels, an error names only so many.
const MOST_NAMED: usize = 20;

impl Volume {
    /// Values with the first index fastest. `world_from_voxel`: its columns are the steps (mm, RAS)
    /// of one voxel along each index; `origin`: the centre of the first voxel.
    ///
    /// Fails where sizes do not fit, the map has no inverse, or a number of it is not finite. Values
    /// that are not finite become 0.
    pub fn new(
        size: [usize; 3],
        mut values: Vec<f32>,
        world_from_voxel: Mat3,
        origin: Vec3,
    ) -> Result<Self> {
        let count = voxel_count(size)?;
        if values.len() != count {
            return Err(Error::invalid(format!(
                "the image has {} values, but {} x {} x {} voxels",
                values.len(),
                size[0],
                size[1],
                size[2]
            )));
        }
        let steps: Vec<f64> = world_from_voxel.column_iter().map(|c| c.norm()).collect();
        let flatness = world_from_voxel.determinant().abs() / steps.iter().product::<f64>();
        let inverse = world_from_voxel.try_inverse().filter(|m| m.iter().all(|x| x.is_finite()));
        let usable =
            flatness.is_finite() && flatness > 1e-6 && origin.iter().all(|x| x.is_finite());
        let Some(voxel_from_world) = inverse.filter(|_| usable) else {
            return Err(Error::invalid(format!(
                "the image's axes {} do not span space; its orientation or spacing is wrong",
                columns_text(&world_from_voxel)
            )));
        };
        for value in &mut values {
            if !value.is_finite() {
                *value = 0.0;
            }
        }
        Ok(Self { size, values, world_from_voxel, origin, voxel_from_world })
    }

    /// Voxels along each index.
    pub fn size(&self) -> [usize; 3] {
        self.size
    }

    /// All values, the first index fastest.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// Columns: the step (mm, RAS) of one voxel along each index.
    pub fn world_from_voxel(&self) -> &Mat3 {
        &self.world_from_voxel
    }

    /// The inverse of [`Self::world_from_voxel`].
    pub fn voxel_from_world(&self) -> &Mat3 {
        &self.voxel_from_world
    }

    /// World position of the first voxel's centre.
    pub fn origin(&self) -> Vec3 {
        self.origin
    }

    /// Millimetres between neighbouring voxels along each index.
    pub fn spacing(&self) -> Vec3 {
        Vec3::from_fn(|axis, _| self.world_from_voxel.column(axis).norm())
    }

    /// World position of an index, which may lie between voxels.
    pub fn world(&self, voxel: &Vec3) -> Vec3 {
        self.world_from_voxel * voxel + self.origin
    }

    /// Index of a world position, between voxels in general.
    pub fn voxel(&self, world: &Vec3) -> Vec3 {
        self.voxel_from_world * (world - self.origin)
    }

    /// World positions of the eight outermost corners, half a voxel beyond the voxel centres.
    pub fn corners(&self) -> [Vec3; 8] {
        std::array::from_fn(|c| {
            let end = |axis: usize| {
                if c >> axis & 1 == 1 { self.size[axis] as f64 - HALF_VOXEL } else { -HALF_VOXEL }
            };
            self.world(&Vec3::new(end(0), end(1), end(2)))
        })
    }

    /// Value of the voxel with this index.
    pub fn at(&self, [i, j, k]: [usize; 3]) -> f32 {
        self.values[i + self.size[0] * (j + self.size[1] * k)]
    }

    /// The value at a world position, interpolated linearly; none outside the image.
    pub fn sample(&self, world: &Vec3) -> Option<f32> {
        self.sample_voxel(&self.voxel(world), |value| value)
    }

    /// The same for an index, of values changed by `map` first (for labels: is it this one?).
    pub fn sample_voxel(&self, voxel: &Vec3, map: impl Fn(f32) -> f32) -> Option<f32> {
        // Offsets of the next voxel along each index, 0 beyond the last one.
        let (mut first, mut next, mut share) = (0, [0; 3], [0.0_f32; 3]);
        let mut stride = 1;
        for axis in 0..3 {
            let size = self.size[axis];
            let last = f64::from(size as u32 - 1);
            if !(voxel[axis] >= -HALF_VOXEL && voxel[axis] <= last + HALF_VOXEL) {
                return None;
            }
            let inside = voxel[axis].max(0.0).min(last);
            let low = inside as u32;
            share[axis] = (inside - f64::from(low)) as f32;
            first += low as usize * stride;
            next[axis] = if low as usize + 1 < size { stride } else { 0 };
            stride *= size;
        }
        let along = |at: usize| {
            let (a, b) = (map(self.values[at]), map(self.values[at + next[0]]));
            a + share[0] * (b - a)
        };
        let across = |at: usize| {
            let (a, b) = (along(at), along(at + next[1]));
            a + share[1] * (b - a)
        };
        let (a, b) = (across(first), across(first + next[2]));
        Some(a + share[2] * (b - a))
    }

    /// Change of the value per millimetre at a world position, by central differences half a voxel
    /// to each side; none within half a voxel of the border and beyond.
    pub fn gradient(&self, world: &Vec3) -> Option<Vec3> {
        let at = self.voxel(world);
        let mut per_voxel = Vec3::zeros();
        for axis in 0..3 {
            let mut step = Vec3::zeros();
            step[axis] = HALF_VOXEL;
            let ahead = self.sample_voxel(&(at + step), |v| v)?;
            let behind = self.sample_voxel(&(at - step), |v| v)?;
            per_voxel[axis] = f64::from(ahead - behind);
        }
        Some(self.voxel_from_world.transpose() * per_voxel)
    }

    /// Smallest and largest value.
    pub fn range(&self) -> [f32; 2] {
        self.values.iter().fold([f32::MAX, f32::MIN], |[l, h], &v| [l.min(v), h.max(v)])
    }

    /// Where the index axes point, as letters: "RAS" for a grid along the world's axes, "LPS",
    /// "ASR" and so on; the nearest directions for oblique grids.
    pub fn orientation(&self) -> String {
        (0..3)
            .map(|axis| {
                let step = self.world_from_voxel.column(axis);
                let world = step.iamax();
                let letters = [['R', 'L'], ['A', 'P'], ['S', 'I']][world];
                letters[usize::from(step[world] < 0.0)]
            })
            .collect()
    }

    /// Whole numbers above 0 with their voxel counts, ascending; none if the image is no label map
    /// (values that are no whole numbers, or more than 4096 different ones).
    pub fn labels(&self) -> Option<Vec<(u32, usize)>> {
        const MOST: usize = 4096;
        let mut counts = std::collections::BTreeMap::new();
        for &value in &self.values {
            if value < 0.0 || value.fract() != 0.0 || value > 16_777_216.0 {
                return None;
            }
            *counts.entry(value as u32).or_insert(0) += 1;
            if counts.len() > MOST {
                return None;
            }
        }
        counts.remove(&0);
        Some(counts.into_iter().collect())
    }

    /// The label of a map that has one.
    pub fn only_label(&self) -> Result<u32> {
        match self.labels().as_deref() {
            Some([(label, _)]) => Ok(*label),
            Some([]) => Err(Error::invalid("the image holds only zeros")),
            Some(many) => {
                let list: Vec<String> =
                    many.iter().take(MOST_NAMED).map(|(l, _)| l.to_string()).collect();
                Err(Error::invalid(format!(
                    "the image has {} labels; choose one with --label: {}",
                    many.len(),
                    list.join(", ")
                )))
            }
            None => Err(Error::invalid(
                "the image is not a label map: its values are not small whole numbers",
            )),
        }
    }
}

/// The number of voxels of a grid; an error for empty and enormous ones.
pub(crate) fn voxel_count(size: [usize; 3]) -> Result<usize> {
    let [a, b, c] = size;
    let count = a.checked_mul(b).and_then(|ab| ab.checked_mul(c));
    match count {
        Some(0) => Err(Error::invalid(format!("the image has {a} x {b} x {c} voxels: none"))),
        Some(count) if count <= MAX_VOXELS => Ok(count),
        _ => Err(Error::invalid(format!(
            "the image has {a} x {b} x {c} voxels, more than {MAX_VOXELS}; crop or resample it"
        ))),
    }
}

fn columns_text(map: &Mat3) -> String {
    let column = |c: usize| format!("({}, {}, {})", map[(0, c)], map[(1, c)], map[(2, c)]);
    format!("{} {} {}", column(0), column(1), column(2))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Oblique, anisotropic and left-handed; its values are a linear function of the world.
    pub(crate) fn oblique(value: impl Fn(&Vec3) -> f64) -> Volume {
        let turn = nalgebra::Rotation3::from_euler_angles(0.3, -0.5, 0.9).into_inner();
        let steps = Mat3::from_diagonal(&Vec3::new(0.7, -1.1, 2.5));
        let (map, origin) = (turn * steps, Vec3::new(-40.0, 120.0, 900.0));
        let size = [12, 9, 7];
        let mut values = Vec::new();
        for k in 0..size[2] {
            for j in 0..size[1] {
                for i in 0..size[0] {
                    let world = map * Vec3::new(i as f64, j as f64, k as f64) + origin;
                    values.push(value(&world) as f32);
                }
            }
        }
        Volume::new(size, values, map, origin).unwrap()
    }

    #[test]
    fn a_linear_field_is_sampled_and_differentiated_exactly_in_an_oblique_grid() {
        let slope = Vec3::new(0.3, -0.2, 0.5);
        let volume = oblique(|p| slope.dot(p) - 400.0);
        assert!(volume.world_from_voxel().determinant() < 0.0, "left-handed");
        let inside = volume.world(&Vec3::new(4.3, 5.9, 2.2));
        let value = f64::from(volume.sample(&inside).unwrap());
        assert!((value - (slope.dot(&inside) - 400.0)).abs() < 1e-4, "{value}");
        assert!((volume.gradient(&inside).unwrap() - slope).norm() < 1e-4);
        assert!((volume.voxel(&inside) - Vec3::new(4.3, 5.9, 2.2)).norm() < 1e-12);
        assert!((volume.spacing() - Vec3::new(0.7, 1.1, 2.5)).norm() < 1e-12);
        assert!(volume.sample(&volume.world(&Vec3::new(-0.6, 0.0, 0.0))).is_none());
        assert!(volume.sample(&volume.world(&Vec3::new(-0.4, 0.0, 0.0))).is_some());
        assert!(volume.gradient(&volume.world(&Vec3::new(11.2, 4.0, 3.0))).is_none());
    }

    #[test]
    fn bad_grids_are_refused_in_words() {
        let build = |size, count, map| Volume::new(size, vec![0.0; count], map, Vec3::zeros());
        let flat = Mat3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0);
        for (result, text) in [
            (build([2, 2, 2], 7, Mat3::identity()), "7 values, but 2 x 2 x 2"),
            (build([2, 0, 2], 0, Mat3::identity()), "none"),
            (build([usize::MAX, 2, 2], 0, Mat3::identity()), "crop or resample"),
            (build([1, 1, 1], 1, flat), "do not span space"),
            (build([1, 1, 1], 1, Mat3::identity() * f64::NAN), "do not span space"),
        ] {
            let message = result.unwrap_err().to_string();
            assert!(message.contains(text), "{message}");
        }
    }

    #[test]
    fn labels_and_letters() {
        let map = Mat3::from_columns(&[-Vec3::x(), Vec3::z() * 2.0, -Vec3::y()]);
        let volume = Volume::new([2, 2, 1], vec![0.0, 3.0, 3.0, 1.0], map, Vec3::zeros()).unwrap();
        assert_eq!(volume.orientation(), "LSP");
        assert_eq!(volume.labels(), Some(vec![(1, 1), (3, 2)]));
        assert_eq!(volume.range().map(f32::to_bits), [0.0, 3.0].map(f32::to_bits));
        assert_eq!(oblique(|p| p.x).labels(), None);
    }
}
