//! Small pictures of a surface with markers: a z-buffer, written as PNG.

use super::png_file::png;
use super::ramp::Colour;
use crate::math::Vec3;
use crate::mesh::{TriMesh, bounding_box};

/// Width and height in pixels.
const SIZE: usize = 420;
/// Each pixel is the mean of this many squared samples.
const SAMPLES: usize = 2;
/// Free share on each side.
const MARGIN: f64 = 0.06;
/// Radius of a marker's dot, in pixels.
const DOT: f64 = 3.0;
/// Light that comes from everywhere.
const AMBIENT: f64 = 0.35;

/// From where a picture is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum View {
    /// From the front, against the y axis; x runs to the left, z up.
    Front,
    /// From the right side, along the negative x axis; y runs to the right, z up.
    Side,
}

impl View {
    /// Right, up and towards the viewer.
    fn axes(self) -> [Vec3; 3] {
        match self {
            Self::Front => [-Vec3::x(), Vec3::z(), Vec3::y()],
            Self::Side => [Vec3::y(), Vec3::z(), Vec3::x()],
        }
    }
}

/// A coloured point.
#[derive(Clone, Copy, Debug)]
pub struct Dot {
    /// Where it is.
    pub position: Vec3,
    /// Its colour.
    pub colour: Colour,
}

/// Draws `mesh` with one colour per vertex, and `dots`; `frame` points are all inside the picture.
/// Dots behind the surface are faint. Returns a PNG file.
pub fn draw(
    mesh: &TriMesh,
    colours: &[Colour],
    dots: &[Dot],
    frame: &[Vec3],
    view: View,
) -> Vec<u8> {
    let mut canvas = Canvas::new(frame, view);
    let normals = mesh.vertex_normals();
    for triangle in &mesh.triangles {
        canvas.fill(
            triangle.map(|v| canvas.project(&mesh.points[v as usize])),
            triangle.map(|v| normals[v as usize].dot(&canvas.axes[2])),
            triangle.map(|v| colours[v as usize]),
        );
    }
    for dot in dots {
        canvas.dot(dot);
    }
    png(SIZE, SIZE, &canvas.shrink())
}

struct Canvas {
    axes: [Vec3; 3],
    centre: Vec3,
    scale: f64,
    side: usize,
    depth: Vec<f64>,
    colour: Vec<Colour>,
}

impl Canvas {
    fn new(frame: &[Vec3], view: View) -> Self {
        let axes = view.axes();
        let along: Vec<Vec3> = frame
            .iter()
            .map(|p| Vec3::new(p.dot(&axes[0]), p.dot(&axes[1]), p.dot(&axes[2])))
            .collect();
        let (low, high) = bounding_box(&along).unwrap_or_default();
        let side = SIZE * SAMPLES;
        let extent = (high - low).xy().max().max(f64::MIN_POSITIVE);
        Self {
            axes,
            centre: (low + high) / 2.0,
            scale: side as f64 * (1.0 - 2.0 * MARGIN) / extent,
            side,
            depth: vec![f64::NEG_INFINITY; side * side],
            colour: vec![[1.0; 3]; side * side],
        }
    }

    /// Column, row and depth (larger is nearer), in samples.
    fn project(&self, p: &Vec3) -> Vec3 {
        let along = Vec3::new(p.dot(&self.axes[0]), p.dot(&self.axes[1]), p.dot(&self.axes[2]));
        let q = (along - self.centre) * self.scale;
        let half = self.side as f64 / 2.0;
        Vec3::new(half + q.x, half - q.y, q.z)
    }

    fn fill(&mut self, [a, b, c]: [Vec3; 3], facing: [f64; 3], colours: [Colour; 3]) {
        let area = (b - a).xy().perp(&(c - a).xy());
        if area == 0.0 {
            return;
        }
        let range = |k: usize| {
            let (low, high) = (a[k].min(b[k]).min(c[k]), a[k].max(b[k]).max(c[k]));
            (
                low.ceil().max(0.0) as usize,
                (high.floor().max(-1.0) + 1.0).min(self.side as f64) as usize,
            )
        };
        let ((left, right), (top, bottom)) = (range(0), range(1));
        for row in top..bottom {
            for column in left..right {
                let p = nalgebra::Vector2::new(column as f64, row as f64);
                let u = (c.xy() - b.xy()).perp(&(p - b.xy())) / area;
                let v = (a.xy() - c.xy()).perp(&(p - c.xy())) / area;
                let weights = [u, v, 1.0 - u - v];
                let depth = a.z * weights[0] + b.z * weights[1] + c.z * weights[2];
                let at = row * self.side + column;
                if weights.iter().any(|w| *w < 0.0) || depth <= self.depth[at] {
                    continue;
                }
                let mix =
                    |of: &dyn Fn(usize) -> f64| (0..3).map(|k| weights[k] * of(k)).sum::<f64>();
                // Open surfaces show their inside too.
                let light = AMBIENT + (1.0 - AMBIENT) * mix(&|k| facing[k]).abs().min(1.0);
                self.depth[at] = depth;
                self.colour[at] = [0, 1, 2].map(|channel| light * mix(&|k| colours[k][channel]));
            }
        }
    }

    fn dot(&mut self, dot: &Dot) {
        let radius = DOT * SAMPLES as f64;
        let p = self.project(&dot.position);
        let reach = radius.ceil() as i64;
        for row in -reach..=reach {
            for column in -reach..=reach {
                if ((row * row + column * column) as f64) > radius * radius {
                    continue;
                }
                let (x, y) = (p.x.round() as i64 + column, p.y.round() as i64 + row);
                if x < 0 || y < 0 || x >= self.side as i64 || y >= self.side as i64 {
                    continue;
                }
                let at = y as usize * self.side + x as usize;
                // Half of each dot on the surface lies behind it.
                let seen = p.z + 2.0 * radius >= self.depth[at];
                let share = if seen { 1.0 } else { 0.2 };
                for channel in 0..3 {
                    let under = &mut self.colour[at][channel];
                    *under += share * (dot.colour[channel] - *under);
                }
            }
        }
    }

    /// The mean of each pixel's samples, as bytes.
    fn shrink(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(SIZE * SIZE * 3);
        for row in 0..SIZE {
            for column in 0..SIZE {
                for channel in 0..3 {
                    let samples = (0..SAMPLES * SAMPLES).map(|s| {
                        let (y, x) = (row * SAMPLES + s / SAMPLES, column * SAMPLES + s % SAMPLES);
                        self.colour[y * self.side + x][channel]
                    });
                    let mean = samples.sum::<f64>() / (SAMPLES * SAMPLES) as f64;
                    bytes.push((mean * 255.0).round() as u8);
                }
            }
        }
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearer_triangle_hides_the_other_and_dots_behind_are_faint() {
        let square = |y: f64| [[0.0, y, 0.0], [4.0, y, 0.0], [4.0, y, 4.0], [0.0, y, 4.0]];
        let points: Vec<Vec3> =
            square(0.0).into_iter().chain(square(1.0)).map(Vec3::from).collect();
        let triangles = vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
        let mesh = TriMesh::new(points.clone(), triangles).unwrap();
        let mut colours = vec![[1.0, 0.0, 0.0]; 4];
        colours.extend([[0.0, 1.0, 0.0]; 4]);
        let blue = [0.0, 0.0, 1.0];
        let dots =
            [[1.0, -1.0, 1.0], [3.0, 2.0, 3.0]].map(|p| Dot { position: p.into(), colour: blue });
        let file = draw(&mesh, &colours, &dots, &points, View::Front);
        let mut reader = png::Decoder::new(std::io::Cursor::new(file)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        let pixel = |x: f64, z: f64| {
            let usable = SIZE as f64 * (1.0 - 2.0 * MARGIN);
            let column = SIZE as f64 / 2.0 - (x - 2.0) / 4.0 * usable;
            let row = SIZE as f64 / 2.0 - (z - 2.0) / 4.0 * usable;
            let at = 3 * (row as usize * SIZE + column as usize);
            [pixels[at], pixels[at + 1], pixels[at + 2]]
        };
        assert_eq!(pixel(2.5, 1.5), [0, 255, 0]);
        assert_eq!(pixel(3.0, 3.0), [0, 0, 255]);
        assert_eq!(pixel(1.0, 1.0), [0, 204, 51]);
        assert_eq!(pixels[0], 255);
    }
}
