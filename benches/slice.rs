//! Time of one 512 x 512 slice with interpolation, grey values included: `cargo bench --bench slice`.
#![allow(clippy::print_stdout, clippy::unwrap_used)]

use std::hint::black_box;
use std::time::Instant;

use moulage::math::{Mat3, Vec3};
use moulage::volume::{SlicePlane, View, Volume, Window};

const SIDE: usize = 256;
const PIXELS: usize = 512;
const REPEATS: usize = 50;

fn main() {
    let values = (0..SIDE.pow(3)).map(|v| (v % 1013) as f32).collect();
    let volume = Volume::new([SIDE; 3], values, Mat3::identity(), Vec3::zeros()).unwrap();
    let middle = Vec3::repeat(SIDE as f64 / 2.0);
    let window = Window { width: 1000.0, level: 500.0 };
    for (name, view) in [
        ("axial", View::Axial),
        ("sagittal", View::Sagittal),
        ("oblique", View::Along(Vec3::new(1.0, 2.0, 3.0))),
    ] {
        let [right, down] = view.right_and_down().map(|d| d * (SIDE as f64 / PIXELS as f64));
        let plane = SlicePlane {
            corner: middle - (right + down) * (PIXELS as f64 / 2.0),
            right,
            down,
            width: PIXELS,
            height: PIXELS,
        };
        let started = Instant::now();
        for _ in 0..REPEATS {
            let grey: Vec<u8> = plane.sample(&volume).iter().map(|v| window.grey(*v)).collect();
            black_box(grey);
        }
        let milliseconds = started.elapsed().as_secs_f64() * 1000.0 / REPEATS as f64;
        println!("{name}: {milliseconds:.2} ms for {PIXELS} x {PIXELS} pixels");
    }
}
