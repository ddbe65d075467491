//! Flat pictures out of a volume: any plane, grey by window and level.

use rayon::prelude::*;

use super::Volume;
use crate::error::{Error, Result};
use crate::math::Vec3;

/// A picture may not have more pixels on a side.
const MOST_PIXELS: usize = 8192;

/// Where a picture is looked at from. The first three are the radiologist's: axial from the feet,
/// coronal from the front, sagittal from the person's left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum View {
    /// Across the body's axis; positions are z.
    Axial,
    /// From side to side; positions are y.
    Coronal,
    /// From front to back; positions are x.
    Sagittal,
    /// Looking along any direction (not zero); positions are millimetres along it.
    Along(Vec3),
}

impl View {
    /// The direction along which positions are counted, unit length.
    pub fn axis(&self) -> Vec3 {
        match self {
            Self::Axial => Vec3::z(),
            Self::Coronal => Vec3::y(),
            Self::Sagittal => Vec3::x(),
            Self::Along(direction) => direction.normalize(),
        }
    }

    /// What is right and down in the picture, unit length.
    pub fn right_and_down(&self) -> [Vec3; 2] {
        match self {
            Self::Axial => [-Vec3::x(), -Vec3::y()],
            Self::Coronal => [-Vec3::x(), -Vec3::z()],
            Self::Sagittal => [-Vec3::y(), -Vec3::z()],
            Self::Along(_) => {
                let ahead = self.axis();
                // The head is up; where one looks along the body, the front is.
                let up = if ahead.z.abs() < 0.9 { Vec3::z() } else { Vec3::y() };
                let down = -(up - ahead * ahead.dot(&up)).normalize();
                [down.cross(&ahead), down]
            }
        }
    }
}

impl std::str::FromStr for View {
    type Err = String;

    /// "axial", "coronal", "sagittal", or a direction "x,y,z".
    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "axial" => return Ok(Self::Axial),
            "coronal" => return Ok(Self::Coronal),
            "sagittal" => return Ok(Self::Sagittal),
            _ => {}
        }
        let numbers: Vec<f64> = text.split(',').filter_map(|n| n.trim().parse().ok()).collect();
        let usable = numbers.iter().all(|n| n.is_finite()) && numbers.iter().any(|n| *n != 0.0);
        match numbers[..] {
            [x, y, z] if usable => Ok(Self::Along(Vec3::new(x, y, z))),
            _ => Err(format!(
                "'{text}' is not a plane: axial, coronal, sagittal or a direction such as 0,1,1"
            )),
        }
    }
}

/// A rectangle of pixels in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlicePlane {
    /// World position of the first pixel's centre (top left).
    pub corner: Vec3,
    /// The step to the next pixel in a row, mm.
    pub right: Vec3,
    /// The step to the next row, mm.
    pub down: Vec3,
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

impl SlicePlane {
    /// The plane of `view` at `position` (mm along the view's axis), as large as the volume needs,
    /// with square pixels of `pixel` mm [none: the volume's smallest spacing].
    pub fn of(volume: &Volume, view: View, position: f64, pixel: Option<f64>) -> Result<Self> {
        let [low, high] = Self::reach(volume, view);
        if position < low || position > high {
            return Err(Error::invalid(format!(
                "the slice at {position} misses the image, which reaches from {low:.1} to {high:.1}"
            )));
        }
        let pixel = pixel.unwrap_or_else(|| volume.spacing().min());
        Self::covering(&volume.corners(), view, position, pixel)
    }

    /// The plane of `view` at `position`, as large as `points` (at least one) need.
    pub fn covering(points: &[Vec3], view: View, position: f64, pixel: f64) -> Result<Self> {
        if !(pixel.is_finite() && pixel > 0.0 && position.is_finite()) {
            return Err(Error::invalid(format!(
                "a slice at {position} with pixels of {pixel} mm cannot be made"
            )));
        }
        let (axis, [right, down]) = (view.axis(), view.right_and_down());
        let reach = |direction: &Vec3| {
            let along = points.iter().map(|p| p.dot(direction));
            along.fold([f64::MAX, f64::MIN], |[low, high], a| [low.min(a), high.max(a)])
        };
        let ([left, right_end], [top, bottom]) = (reach(&right), reach(&down));
        let count = |length: f64| ((length / pixel).round() as usize).max(1);
        let (width, height) = (count(right_end - left), count(bottom - top));
        if width > MOST_PIXELS || height > MOST_PIXELS {
            return Err(Error::invalid(format!(
                "the slice would have {width} x {height} pixels; make them larger than {pixel} mm"
            )));
        }
        let first = |low: f64| low + pixel / 2.0;
        Ok(Self {
            corner: right * first(left) + down * first(top) + axis * position,
            right: right * pixel,
            down: down * pixel,
            width,
            height,
        })
    }

    /// The positions along `view` at which a volume can be cut, lowest and highest.
    pub fn reach(volume: &Volume, view: View) -> [f64; 2] {
        let along = volume.corners().map(|c| c.dot(&view.axis()));
        along.iter().fold([f64::MAX, f64::MIN], |[l, h], &a| [l.min(a), h.max(a)])
    }

    /// Unit normal: the direction one looks along.
    pub fn normal(&self) -> Vec3 {
        self.right.cross(&self.down).normalize()
    }

    /// World position of a pixel (column, row), which may lie between pixels.
    pub fn world(&self, column: f64, row: f64) -> Vec3 {
        self.corner + self.right * column + self.down * row
    }

    /// Column and row of a world position's foot on the plane, between pixels in general, and its
    /// signed distance from the plane, mm.
    pub fn pixel(&self, world: &Vec3) -> Vec3 {
        let from = world - self.corner;
        let along = |step: &Vec3| from.dot(step) / step.norm_squared();
        Vec3::new(along(&self.right), along(&self.down), from.dot(&self.normal()))
    }

    /// Interpolated values, row by row; NaN outside the image.
    pub fn sample(&self, volume: &Volume) -> Vec<f32> {
        self.sample_mapped(volume, |value| value)
    }

    /// The same of values changed by `map` first.
    pub fn sample_mapped(&self, volume: &Volume, map: impl Fn(f32) -> f32 + Sync) -> Vec<f32> {
        let mut values = vec![f32::NAN; self.width * self.height];
        let step = volume.voxel_from_world() * self.right;
        values.par_chunks_mut(self.width.max(1)).enumerate().for_each(|(row, line)| {
            let start = volume.voxel(&self.world(0.0, row as f64));
            for (column, value) in line.iter_mut().enumerate() {
                let voxel = start + step * column as f64;
                if let Some(found) = volume.sample_voxel(&voxel, &map) {
                    *value = found;
                }
            }
        });
        values
    }

    /// Values of the nearest voxels (for labels), row by row; NaN outside the image.
    pub fn nearest(&self, volume: &Volume) -> Vec<f32> {
        let size = volume.size();
        let at = |p: usize| {
            let world = self.world((p % self.width) as f64, (p / self.width) as f64);
            let voxel = volume.voxel(&world).map(f64::round);
            let inside = (0..3).all(|a| voxel[a] >= 0.0 && voxel[a] < size[a] as f64);
            if inside { volume.at([0, 1, 2].map(|a| voxel[a] as usize)) } else { f32::NAN }
        };
        (0..self.width * self.height).into_par_iter().map(at).collect()
    }
}

/// Which values are shown between black and white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Width: from black to white. Above 0.
    pub width: f64,
    /// Level: middle grey.
    pub level: f64,
}

impl Window {
    /// A window for an image whose kind is not known: the usual one for soft tissue where values
    /// look like Hounsfield units of a CT, otherwise all but the outermost hundredths.
    pub fn fitting(volume: &Volume) -> Self {
        let values = volume.values();
        let step = (values.len() / 100_000).max(1);
        let mut some: Vec<f32> = values.iter().step_by(step).copied().collect();
        some.sort_by(f32::total_cmp);
        let share = |s: f64| f64::from(some[((some.len() - 1) as f64 * s).round() as usize]);
        if share(0.0) < -500.0 && share(0.99) > 0.0 {
            return Self { width: 400.0, level: 40.0 };
        }
        let (low, high) = (share(0.01), share(0.99));
        Self { width: (high - low).max(1e-6), level: f64::midpoint(low, high) }
    }

    /// 0 (black) to 255 (white); NaN is black.
    pub fn grey(&self, value: f32) -> u8 {
        let low = self.level - self.width / 2.0;
        // The cast keeps to 0..=255 and makes 0 of NaN; rounding by a half is much faster than round().
        ((f64::from(value) - low) / self.width * 255.0 + 0.5) as u8
    }
}

impl std::str::FromStr for Window {
    type Err = String;

    /// "WIDTH,LEVEL".
    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Vec<f64> = text.split(',').filter_map(|n| n.trim().parse().ok()).collect();
        match numbers[..] {
            [width, level] if width.is_finite() && width > 0.0 && level.is_finite() => {
                Ok(Self { width, level })
            }
            _ => Err(format!("'{text}' is not a window; give width and level, such as 400,40")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::grid::tests::oblique;
    use super::*;

    #[test]
    fn views_are_the_radiologists() {
        for (view, ahead) in [
            (View::Axial, Vec3::z()),
            (View::Coronal, -Vec3::y()),
            (View::Sagittal, Vec3::x()),
            (View::Along(Vec3::new(0.0, 3.0, 4.0)), Vec3::new(0.0, 0.6, 0.8)),
        ] {
            let [right, down] = view.right_and_down();
            assert!((right.cross(&down) - ahead).norm() < 1e-12, "{view:?}");
        }
        assert_eq!("0,1,0".parse(), Ok(View::Along(Vec3::y())));
        assert!("0,0,0".parse::<View>().is_err() && "front".parse::<View>().is_err());
    }

    #[test]
    fn a_slice_shows_the_world_wherever_it_is_cut() {
        let slope = Vec3::new(0.3, -0.2, 0.5);
        let volume = oblique(|p| slope.dot(p));
        let middle = volume.world(&Vec3::new(5.5, 4.0, 3.0));
        for view in [View::Axial, View::Coronal, View::Along(Vec3::new(1.0, 2.0, -1.0))] {
            let plane = SlicePlane::of(&volume, view, middle.dot(&view.axis()), None).unwrap();
            let values = plane.sample(&volume);
            let seen = values.iter().filter(|v| !v.is_nan()).count();
            assert!(seen * 10 > values.len(), "{view:?}: {seen} of {}", values.len());
            let at = plane.pixel(&middle);
            assert!(at.z.abs() < 1e-9);
            let (column, row) = (at.x.round() as usize, at.y.round() as usize);
            let here = plane.world(column as f64, row as f64);
            let value = f64::from(values[row * plane.width + column]);
            assert!((value - slope.dot(&here)).abs() < 1e-3);
            assert!(
                (plane.pixel(&here).xy() - nalgebra::Vector2::new(column as f64, row as f64))
                    .norm()
                    < 1e-9
            );
        }
        let error = SlicePlane::of(&volume, View::Axial, 0.0, None).unwrap_err().to_string();
        assert!(error.contains("misses the image, which reaches from 8"), "{error}");
        assert!(SlicePlane::of(&volume, View::Axial, middle.z, Some(1e-5)).is_err());
    }

    #[test]
    fn windows() {
        let window: Window = "400,40".parse().unwrap();
        let greys = [-200.0, -160.0, 40.0, 240.0, f32::NAN].map(|v| window.grey(v));
        assert_eq!(greys, [0, 0, 128, 255, 0]);
        assert!("0,40".parse::<Window>().is_err() && "400".parse::<Window>().is_err());
    }
}
