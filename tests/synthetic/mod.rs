//! Images made of skeletons: bones with a cortex and marrow in textured soft tissue, air around, noise, a slow
//! change of brightness.

use moulage::locate::{ClosestPoints, WindingNumber};
use moulage::math::{Mat3, Vec3};
use moulage::mesh::bounding_box;
use moulage::register::Skeleton;
use moulage::volume::Volume;
use rayon::prelude::*;

/// What the tissues look like.
#[derive(Clone, Copy)]
pub struct Looks {
    pub cortex: f64,
    /// Thickness, mm.
    pub cortex_depth: f64,
    pub marrow: f64,
    pub tissue: f64,
    /// Texture of marrow and tissue.
    pub texture: f64,
    pub air: f64,
    /// Share of the brightness that changes slowly across the image.
    pub coil: f64,
    /// Standard deviation.
    pub noise: f64,
    /// Width of an edge, mm.
    pub edge: f64,
}

/// Thickness of the soft tissue, mm.
const SKIN: f64 = 7.0;
/// Beyond this distance from all bones nothing is inside one, mm.
const FAR: f64 = 12.0;
/// Image around the bones, mm.
const MARGIN: f64 = 11.0;

/// Even numbers from 0 to 1 that depend on the place only.
fn hashed(seed: u64) -> f64 {
    let mut z = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(0x1234_5678_9abc_def1);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

/// An image of the skeleton, multiplied by `gain`.
pub fn image(bones: &Skeleton, spacing: [f64; 3], looks: &Looks, seed: u64, gain: f64) -> Volume {
    let (low, high) = bounding_box(&bones.points).unwrap();
    let margin = Vec3::repeat(MARGIN);
    let (low, high) = (low - margin, high + margin);
    let size = [0, 1, 2].map(|k| ((high[k] - low[k]) / spacing[k]).ceil() as usize);
    let closest = ClosestPoints::new(&bones.points, &bones.triangles);
    let winding = WindingNumber::new(&bones.points, &bones.triangles);
    // A smooth step from 0 (below) to 1 (above): what a voxel sees of an edge.
    let step = |x: f64| (x / looks.edge + 0.5).clamp(0.0, 1.0);
    let value = |v: usize| {
        let index = [v % size[0], v / size[0] % size[1], v / (size[0] * size[1])];
        let p = low + Vec3::from_fn(|k, _| index[k] as f64 * spacing[k]);
        let distance = closest.closest(&p).unwrap().distance;
        let depth = if distance < FAR && winding.is_inside(&p) { -distance } else { distance };
        let wave =
            |k: f64| libm::sin(p.x / k) * libm::sin(p.y / k + 1.0) * libm::sin(p.z / k + 2.0);
        let tissue = looks.tissue + looks.texture * (70.0 * wave(1.7) + 50.0 * wave(4.1));
        let marrow = looks.marrow + looks.texture * 40.0 * wave(2.3);
        // From inside: marrow, cortex, tissue, and air beyond the skin.
        let mut seen = marrow + (looks.cortex - marrow) * step(depth + looks.cortex_depth);
        seen += (tissue - seen) * step(depth);
        seen += (looks.air - seen) * step(depth - SKIN);
        let coil = 1.0 + looks.coil * libm::sin((p.x + p.z) / 40.0);
        let pair = (hashed(2 * v as u64 + seed), hashed(2 * v as u64 + 1 + seed));
        let gauss =
            (-2.0 * libm::log(1.0 - pair.0)).sqrt() * libm::cos(std::f64::consts::TAU * pair.1);
        ((seen * coil + looks.noise * gauss) * gain) as f32
    };
    let values = (0..size.iter().product::<usize>()).into_par_iter().map(value).collect();
    Volume::new(size, values, Mat3::from_diagonal(&Vec3::from(spacing)), low).unwrap()
}
