//! Other persons' hands, made from the example's template: sizes, bumps and joint angles are known. What happens to scans of them.
#![allow(dead_code, clippy::unwrap_used)]

pub mod damage;

use std::path::Path;

use moulage::TriMesh;
use moulage::job::read_skeleton;
use moulage::locate::ClosestPoints;
use moulage::math::{Mat3, Vec3};
use moulage::mesh::bounding_box;
use moulage::register::Skeleton;
use moulage::register::animation::posed;
use moulage::register::rotation::turned_about;
use moulage::volume::{Volume, label_surface};
use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use rayon::prelude::*;

/// Voxels of the scan that bones are seen in, mm.
const VOXEL: [f64; 3] = [0.5, 1.0, 0.5];
/// Thickness added to all bones, so that they fuse at their joints, mm.
const DILATION: f64 = 0.2;
/// Root mean square of the scan's noise, mm, and its wave length.
const NOISE: [f64; 2] = [0.25, 3.0];
/// Root mean square of the bumps on bones, mm.
pub const BUMPS: f64 = 0.35;

/// Numbers between -1 and 1, the same on every run.
pub struct Noise(pub u64);

impl Noise {
    pub fn next(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    pub fn vector(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next())
    }
}

pub fn template() -> Skeleton {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/hand/skeleton.json");
    read_skeleton(&path).unwrap().skeleton
}

/// Some of the bones, with the joints between them.
pub fn only(skeleton: &Skeleton, names: &[&str]) -> Skeleton {
    let bones: Vec<usize> = names.iter().map(|name| skeleton.bone_index(name).unwrap()).collect();
    let place = |b: usize| bones.iter().position(|own| *own == b);
    let joints = skeleton.joints.iter().filter_map(|joint| {
        let mut joint = joint.clone();
        (joint.parent, joint.child) = (place(joint.parent)?, place(joint.child)?);
        Some(joint)
    });
    let surface =
        |b: &usize| (skeleton.bones[*b].name.clone(), skeleton.bone_surface(*b, &skeleton.points));
    Skeleton::new(bones.iter().map(surface).collect(), joints.collect()).unwrap()
}

/// A hand whose bones have other sizes and bumps (their root mean square in mm), in the template's joint
/// angles. One size for the hand, others for each bone's length and width, of which the share `alike`
/// is that of all bones; bones stay joined.
pub fn person(template: &Skeleton, seed: u64, alike: f64, bumps: f64) -> Skeleton {
    let mut noise = Noise(seed);
    let whole = Vec3::repeat(1.0 + 0.06 * noise.next());
    let of_all = noise.vector();
    let mut size = || whole + 0.05 * (alike * of_all + (1.0 - alike) * noise.vector());
    let sizes: Vec<Vec3> = template.bones.iter().map(|_| size()).collect();
    let mut other = template.clone();
    // Each bone is stretched about the joint it hangs on, which lies where its neighbour's end is.
    let mut pivots = vec![(Vec3::zeros(), Vec3::zeros()); sizes.len()];
    let place = |pivots: &[(Vec3, Vec3)], b: usize, p: &Vec3| {
        pivots[b].1 + (p - pivots[b].0).component_mul(&sizes[b])
    };
    for (j, to_child) in template.spanning_forest(0) {
        let joint = &template.joints[j];
        let (near, far) =
            if to_child { (joint.parent, joint.child) } else { (joint.child, joint.parent) };
        let point = joint.parent_frame.translation.vector;
        pivots[far] = (point, place(&pivots, near, &point));
    }
    for (joint, old) in other.joints.iter_mut().zip(&template.joints) {
        let at = |b: usize, frame: &Isometry3<f64>| place(&pivots, b, &frame.translation.vector);
        joint.parent_frame.translation.vector = at(old.parent, &old.parent_frame);
        joint.child_frame.translation.vector = at(old.child, &old.child_frame);
    }
    for (b, bone) in template.bones.iter().enumerate() {
        let points = &template.points[bone.vertices.clone()];
        let (low, high) = bounding_box(points).unwrap();
        let waves: Vec<(Vec3, f64)> = (0..3)
            .map(|_| (noise.vector() * 10.0 / (high - low).norm(), noise.next() * 6.0))
            .collect();
        let normals = template.bone_surface(b, &template.points).vertex_normals();
        for ((i, p), normal) in bone.vertices.clone().zip(points).zip(normals) {
            let bump: f64 = waves.iter().map(|(k, phase)| libm::sin(k.dot(p) + phase)).sum();
            let bump = bumps * (2.0_f64 / 3.0).sqrt() * bump;
            other.points[i] = place(&pivots, b, p) + bump * normal;
        }
    }
    other
}

/// Turns the joints to `bend` of the way to the end of their ranges, a little more or less, and the
/// whole by 12 degrees.
pub fn in_a_pose(person: &Skeleton, seed: u64, bend: f64) -> Skeleton {
    let mut noise = Noise(seed);
    let shares: Vec<f64> =
        person.joints.iter().map(|_| bend * (1.0 + 0.8 * noise.next())).collect();
    let mut other = person.clone();
    let motions = posed(person, 0, |name| {
        let of = |k: usize| {
            let own = person.joints[k].coordinates.iter().find(|c| c.name == name)?;
            let far = if own.range[1] > -own.range[0] { own.range[1] } else { own.range[0] };
            Some(shares[k] * far.clamp(-1.6, 1.6))
        };
        (0..shares.len()).find_map(of)
    });
    other.move_bones(&motions);
    let turn = UnitQuaternion::from_scaled_axis(noise.vector().normalize() * 12_f64.to_radians());
    let middle = other.points.iter().sum::<Vec3>() / other.points.len() as f64;
    let away = Translation3::from(noise.vector() * 5.0)
        * turned_about(&Isometry3::identity(), &middle, turn);
    other.move_bones(&vec![away; other.bones.len()]);
    other
}

/// All bones as one noisy scan shows them: voxels longer one way, thickened so that neighbours fuse,
/// their surface with steps.
pub fn fused_scan(skeleton: &Skeleton, seed: u64) -> TriMesh {
    let (low, high) = bounding_box(&skeleton.points).unwrap();
    let spacing = Vec3::from(VOXEL);
    let origin = low - Vec3::repeat(3.0);
    let size = ((high - origin) + Vec3::repeat(3.0)).component_div(&spacing).map(f64::ceil);
    let size: [usize; 3] = size.map(|x| x as usize).into();
    let inside = filled(skeleton, size, &origin, &spacing);
    let search = ClosestPoints::new(&skeleton.points, &skeleton.triangles);
    let mut noise = Noise(seed);
    let waves: Vec<(Vec3, f64)> = (0..8)
        .map(|_| {
            (
                noise.vector().normalize() * std::f64::consts::TAU / NOISE[1],
                noise.next() * std::f64::consts::PI,
            )
        })
        .collect();
    let at = |i: usize, step: [isize; 3]| {
        let index = [i % size[0], i / size[0] % size[1], i / size[0] / size[1]];
        let moved: [usize; 3] =
            std::array::from_fn(|k| index[k].saturating_add_signed(step[k]).min(size[k] - 1));
        inside[moved[0] + size[0] * (moved[1] + size[1] * moved[2])]
    };
    let values: Vec<f32> = (0..inside.len())
        .into_par_iter()
        .map(|i| {
            let near_border = (-2..=2_isize).any(|s| {
                [[s, 0, 0], [0, s.signum(), 0], [0, 0, s]]
                    .iter()
                    .any(|step| at(i, *step) != inside[i])
            });
            if !near_border {
                return f32::from(u8::from(inside[i]));
            }
            let index = [i % size[0], i / size[0] % size[1], i / size[0] / size[1]];
            let p = origin + Vec3::from(index.map(|x| x as f64)).component_mul(&spacing);
            let distance = search.closest(&p).unwrap().distance;
            let distance = if inside[i] { -distance } else { distance };
            let wave: f64 = waves.iter().map(|(k, phase)| libm::sin(k.dot(&p) + phase)).sum();
            // Eight waves have a root mean square of 2.
            f32::from(u8::from(distance < DILATION + NOISE[0] * wave / 2.0))
        })
        .collect();
    let volume = Volume::new(size, values, Mat3::from_diagonal(&spacing), origin).unwrap();
    let (points, triangles) = label_surface(&volume, 1).unwrap();
    TriMesh::new(points, triangles).unwrap()
}

/// Voxels inside a bone: crossings of each row of voxels with the bone's triangles.
fn filled(skeleton: &Skeleton, size: [usize; 3], origin: &Vec3, spacing: &Vec3) -> Vec<bool> {
    let mut inside = vec![false; size[0] * size[1] * size[2]];
    for bone in &skeleton.bones {
        let mut crossings = std::collections::BTreeMap::<usize, Vec<f64>>::new();
        for t in &skeleton.triangles[bone.triangles.clone()] {
            let [a, b, c] =
                t.map(|v| (skeleton.points[v as usize] - origin).component_div(spacing));
            let area = (b.y - a.y) * (c.z - a.z) - (c.y - a.y) * (b.z - a.z);
            let range = |k: usize| {
                let (low, high) = (a[k].min(b[k]).min(c[k]), a[k].max(b[k]).max(c[k]));
                low.ceil() as usize..=high.floor() as usize
            };
            for z in range(2) {
                for y in range(1) {
                    // A row never runs exactly through a vertex.
                    let (py, pz) = (y as f64 + 1.3e-7, z as f64 + 1.7e-7);
                    let side = |p: &Vec3, q: &Vec3| {
                        ((q.y - p.y) * (pz - p.z) - (py - p.y) * (q.z - p.z)) / area
                    };
                    let (u, v, w) = (side(&b, &c), side(&c, &a), side(&a, &b));
                    if u >= 0.0 && v >= 0.0 && w >= 0.0 {
                        let x = u * a.x + v * b.x + w * c.x;
                        crossings.entry(y + size[1] * z).or_default().push(x);
                    }
                }
            }
        }
        for (row, mut xs) in crossings {
            xs.sort_by(f64::total_cmp);
            for pair in xs.chunks_exact(2) {
                for x in pair[0].ceil() as usize..=pair[1].floor() as usize {
                    inside[x + size[0] * row] = true;
                }
            }
        }
    }
    inside
}

/// Root mean square distance of corresponding vertices.
pub fn vertex_error(found: &[Vec3], truth: &[Vec3]) -> f64 {
    let squares: f64 = found.iter().zip(truth).map(|(p, q)| (p - q).norm_squared()).sum();
    (squares / truth.len() as f64).sqrt()
}

/// Mean distance between the surfaces of each bone and the true one, both ways.
pub fn surface_error(found: &Skeleton, truth: &Skeleton) -> f64 {
    let one_way = |from: &Skeleton, to: &Skeleton, b: usize| {
        let surface = to.bone_surface(b, &to.points);
        let search = ClosestPoints::new(&surface.points, &surface.triangles);
        let points = &from.points[from.bones[b].vertices.clone()];
        points.iter().map(|p| search.closest(p).unwrap().distance).sum::<f64>()
            / points.len() as f64
    };
    let bones = found.bones.len();
    let both = |b: usize| f64::midpoint(one_way(found, truth, b), one_way(truth, found, b));
    (0..bones).into_par_iter().map(both).sum::<f64>() / bones as f64
}
