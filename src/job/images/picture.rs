//! A slice of an image with lines and dots over it, as PNG.

use crate::job::report::png_file::png;
use crate::math::Vec3;
use crate::math::polyline::Polyline;
use crate::volume::{SlicePlane, Volume, Window};

/// Red, green, blue.
pub type Rgb = [u8; 3];

/// Half the width of lines, in pixels.
const HALF_LINE: f64 = 0.9;
/// Radius of dots, in pixels.
const DOT: f64 = 3.2;
/// Colour of the letters that tell the sides.
const LETTERS: Rgb = [255, 220, 120];
/// Size of one dot of a letter, in pixels.
const LETTER_DOT: usize = 2;

/// What is drawn over a slice.
#[derive(Clone, Debug, Default)]
pub struct Overlay {
    /// Lines with their colour.
    pub lines: Vec<(Polyline, Rgb)>,
    /// Points with their colour.
    pub dots: Vec<(Vec3, Rgb)>,
}

/// Draws `plane` of `volume` with `overlay`, and letters for the person's sides. Returns a PNG file.
pub fn slice_picture(
    volume: &Volume,
    plane: &SlicePlane,
    window: &Window,
    overlay: &Overlay,
) -> Vec<u8> {
    let grey = plane.sample(volume);
    let pixels = grey.iter().flat_map(|v| [window.grey(*v); 3]).collect();
    let mut canvas = Canvas { width: plane.width, height: plane.height, pixels };
    for (line, colour) in &overlay.lines {
        let mut points: Vec<Vec3> = line.points.iter().map(|p| plane.pixel(p)).collect();
        if line.closed {
            points.extend(points.first().copied());
        }
        canvas.line(&points, *colour);
    }
    for (point, colour) in &overlay.dots {
        let at = plane.pixel(point);
        canvas.spot(&at, &at, DOT + 1.0, [0, 0, 0]);
        canvas.spot(&at, &at, DOT, *colour);
    }
    canvas.sides(plane);
    png(canvas.width, canvas.height, &canvas.pixels)
}

struct Canvas {
    width: usize,
    height: usize,
    pixels: Vec<u8>,
}

impl Canvas {
    fn line(&mut self, points: &[Vec3], colour: Rgb) {
        for ends in points.windows(2) {
            self.spot(&ends[0], &ends[1], HALF_LINE, colour);
        }
    }

    /// Everything within `radius` of the piece from `a` to `b`, with soft edges.
    fn spot(&mut self, a: &Vec3, b: &Vec3, radius: f64, colour: Rgb) {
        let reach = radius + 1.0;
        let range = |a: f64, b: f64, size: usize| {
            let low = (a.min(b) - reach).max(0.0) as usize;
            low..((a.max(b) + reach + 1.0).max(0.0) as usize).min(size)
        };
        let along = (b - a).xy();
        let squared = along.norm_squared();
        for row in range(a.y, b.y, self.height) {
            for column in range(a.x, b.x, self.width) {
                let from = nalgebra::Vector2::new(column as f64, row as f64) - a.xy();
                let share =
                    if squared > 0.0 { (from.dot(&along) / squared).clamp(0.0, 1.0) } else { 0.0 };
                let cover = (radius + 0.5 - (from - along * share).norm()).clamp(0.0, 1.0);
                self.blend(column, row, cover, colour);
            }
        }
    }

    fn blend(&mut self, column: usize, row: usize, cover: f64, colour: Rgb) {
        let at = 3 * (row * self.width + column);
        for (channel, new) in colour.into_iter().enumerate() {
            let old = f64::from(self.pixels[at + channel]);
            self.pixels[at + channel] = (old + cover * (f64::from(new) - old)).round() as u8;
        }
    }

    /// The letter of the person's side (R, L, A, P, S, I) at each edge.
    fn sides(&mut self, plane: &SlicePlane) {
        let (w, h) = (self.width, self.height);
        let (letter_width, letter_height) = (5 * LETTER_DOT, 7 * LETTER_DOT);
        if w < 6 * letter_width || h < 4 * letter_height {
            return;
        }
        let gap = 2 * LETTER_DOT;
        let (middle_x, middle_y) = ((w - letter_width) / 2, (h - letter_height) / 2);
        self.letter(side(&-plane.right), gap, middle_y);
        self.letter(side(&plane.right), w - letter_width - gap, middle_y);
        self.letter(side(&-plane.down), middle_x, gap);
        self.letter(side(&plane.down), middle_x, h - letter_height - gap);
    }

    fn letter(&mut self, letter: usize, left: usize, top: usize) {
        for (row, bits) in GLYPHS[letter].into_iter().enumerate() {
            for column in (0..5).filter(|column| bits >> (4 - column) & 1 == 1) {
                for dot in 0..LETTER_DOT * LETTER_DOT {
                    let x = left + column * LETTER_DOT + dot % LETTER_DOT;
                    let y = top + row * LETTER_DOT + dot / LETTER_DOT;
                    self.blend(x, y, 1.0, LETTERS);
                }
            }
        }
    }
}

/// R, L, A, P, S, I: seven rows of five dots.
const GLYPHS: [[u8; 7]; 6] = [
    [0b11110, 0b10001, 0b10001, 0b11110, 0b10100, 0b10010, 0b10001],
    [0b10000, 0b10000, 0b10000, 0b10000, 0b10000, 0b10000, 0b11111],
    [0b01110, 0b10001, 0b10001, 0b11111, 0b10001, 0b10001, 0b10001],
    [0b11110, 0b10001, 0b10001, 0b11110, 0b10000, 0b10000, 0b10000],
    [0b01111, 0b10000, 0b10000, 0b01110, 0b00001, 0b00001, 0b11110],
    [0b01110, 0b00100, 0b00100, 0b00100, 0b00100, 0b00100, 0b01110],
];

/// The number of the letter of the side that a direction points to.
fn side(direction: &Vec3) -> usize {
    let axis = direction.iamax();
    2 * axis + usize::from(direction[axis] < 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Mat3;
    use crate::volume::View;

    #[test]
    fn lines_dots_and_letters_are_where_they_belong() {
        let volume =
            Volume::new([100, 100, 1], vec![0.0; 10_000], Mat3::identity(), Vec3::zeros()).unwrap();
        let plane = SlicePlane::of(&volume, View::Axial, 0.0, None).unwrap();
        let line = |x: f64| Polyline {
            points: vec![Vec3::new(x, 20.0, 0.0), Vec3::new(x, 40.0, 0.0)],
            closed: false,
        };
        let overlay = Overlay {
            lines: vec![(line(30.0), [255, 0, 0])],
            dots: vec![(Vec3::new(70.0, 60.0, 0.0), [0, 255, 0])],
        };
        let file = slice_picture(&volume, &plane, &Window { width: 2.0, level: 2.0 }, &overlay);
        let mut reader = png::Decoder::new(std::io::Cursor::new(file)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        // From the feet: x runs to the left, y up.
        let pixel = |x: usize, y: usize| {
            let at = 3 * ((99 - y) * 100 + 99 - x);
            [pixels[at], pixels[at + 1], pixels[at + 2]]
        };
        assert_eq!((pixel(30, 30), pixel(34, 30)), ([255, 0, 0], [0, 0, 0]));
        assert_eq!((pixel(70, 60), pixel(70, 68)), ([0, 255, 0], [0, 0, 0]));
        // R on the left of the picture, that is at large x.
        assert_eq!(pixel(99 - 4, 99 - 43), LETTERS);
        assert_eq!([side(&Vec3::x()), side(&-Vec3::x()), side(&-Vec3::z())], [0, 1, 5]);
    }
}
