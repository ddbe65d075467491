//! Images with the bones in them, and starts that are off.

use std::path::Path;

use moulage::Run;
use moulage::TriMesh;
use moulage::io::{read_surface, read_volume};
use moulage::job::read_skeleton;
use moulage::locate::ClosestPoints;
use moulage::math::{Mat3, Vec3};
use moulage::register::elastic::whole_motion;
use moulage::register::rotation::turned_about;
use moulage::register::{Bone, Options, Skeleton, Target, register};
use moulage::volume::{Volume, label_surface};
use nalgebra::{Isometry3, Translation3, UnitQuaternion};

use super::damaged;
use super::hands::{self, damage};
use super::person::Person;
use super::synthetic::Looks;

pub enum Truth {
    /// The place of every vertex of each bone that the person has.
    Vertices(Vec<Option<Vec<Vec3>>>),
    /// The surface of each bone, as a label map has it.
    Surfaces(Vec<TriMesh>),
}

pub struct Case {
    pub name: String,
    /// The template on its bones in its own image.
    pub reference: Skeleton,
    pub reference_image: Volume,
    /// The template where the run begins, and the person's image.
    pub start: Skeleton,
    pub image: Volume,
    pub truth: Truth,
}

impl Case {
    /// How far each bone is off: root mean square of its vertices, or mean distance from the label's surface to
    /// the bone; none of a bone that the person does not have.
    pub fn errors(&self, found: &Skeleton) -> Vec<Option<f64>> {
        let bone = |b: usize| found.bone_surface(b, &found.points);
        match &self.truth {
            Truth::Vertices(truth) => truth
                .iter()
                .enumerate()
                .map(|(b, truth)| Some(hands::vertex_error(&bone(b).points, truth.as_ref()?)))
                .collect(),
            Truth::Surfaces(surfaces) => surfaces
                .iter()
                .enumerate()
                .map(|(b, surface)| {
                    let bone = bone(b);
                    let search = ClosestPoints::new(&bone.points, &bone.triangles);
                    let distances = search.closest_many(&surface.points);
                    let sum: f64 = distances.iter().flatten().map(|hit| hit.distance).sum();
                    Some(sum / surface.points.len() as f64)
                })
                .collect(),
        }
    }
}

pub fn all(data: &Path, chosen: impl Fn(&str) -> bool) -> Vec<Case> {
    let mut cases = hand(data, &chosen);
    cases.extend(damaged::all(&chosen));
    cases.extend(pelvis(data, &chosen));
    cases
}

/// The places of the vertices of each bone.
pub fn vertices(person: &Skeleton) -> Truth {
    let of = |b: &Bone| Some(person.points[b.vertices.clone()].to_vec());
    Truth::Vertices(person.bones.iter().map(of).collect())
}

/// A turn about the axis (1, 1, 1) about the skeleton's middle and a way along (1, -1, 1).
pub fn moved(skeleton: &Skeleton, millimetres: f64, degrees: f64) -> Skeleton {
    let middle = skeleton.points.iter().sum::<Vec3>() / skeleton.points.len() as f64;
    let turn =
        UnitQuaternion::from_scaled_axis(Vec3::repeat(1.0).normalize() * degrees.to_radians());
    let way = Vec3::new(1.0, -1.0, 1.0).normalize() * millimetres;
    let motion = Translation3::from(way) * turned_about(&Isometry3::identity(), &middle, turn);
    let mut other = skeleton.clone();
    other.move_bones(&vec![motion; skeleton.bones.len()]);
    other
}

/// Computed tomography: bright bone with a brighter cortex.
pub const CT: Looks = Looks {
    cortex: 900.0,
    cortex_depth: 0.9,
    marrow: 350.0,
    tissue: 60.0,
    texture: 0.3,
    air: -1000.0,
    coil: 0.0,
    noise: 25.0,
    edge: 0.9,
};

/// Voxels of the hands' images, mm.
pub const VOXELS: [f64; 3] = [0.8; 3];

fn hand(data: &Path, chosen: &impl Fn(&str) -> bool) -> Vec<Case> {
    let folder = data.join("hand_skeleton");
    let template = hands::template();
    // The same bones on another person, with that person's image.
    let mut person = template.clone();
    person.points =
        read_surface(&folder.join("target_surface.ply")).unwrap().mesh().unwrap().points;
    let own = read_volume(&folder.join("volume.nii.gz")).unwrap().volume;
    let mut cases = Vec::new();
    for (millimetres, degrees) in [(0.0, 0.0), (3.0, 3.0), (6.0, 6.0), (12.0, 10.0)] {
        let name = format!("hand, the same image {millimetres} mm and {degrees} degrees off");
        if chosen(&name) {
            cases.push(Case {
                name,
                reference: person.clone(),
                reference_image: own.clone(),
                start: moved(&person, millimetres, degrees),
                image: own.clone(),
                truth: vertices(&person),
            });
        }
    }
    for seed in [1, 2] {
        let name = format!("hand, another person {seed}");
        if chosen(&name) {
            let person = Person::new(seed, 0.15);
            let seen = person.seen(&person.bones, VOXELS, &CT);
            cases.push(person.case(&name, &person.start(), seen));
        }
    }
    cases
}

/// The right side of a CT, found from its mirrored left side.
fn pelvis(data: &Path, chosen: &impl Fn(&str) -> bool) -> Vec<Case> {
    const BONES: [&str; 3] = ["sacrum", "hip_r", "femur_r"];
    const LEFT: [u32; 3] = [25, 77, 75];
    const RIGHT: [u32; 3] = [25, 78, 76];
    let wanted: Vec<bool> =
        [true, false].into_iter().filter(|cut| chosen(pelvis_name(*cut))).collect();
    if wanted.is_empty() {
        return Vec::new();
    }
    let read = |name: &str| read_volume(&data.join("ct_whole").join(name)).unwrap().volume;
    let (image, labels) = (read("volume.nii.gz"), read("labels.nii.gz"));
    let surfaces = |map: &Volume, labels: [u32; 3]| -> Vec<TriMesh> {
        let surface = |label| {
            let (points, triangles) = label_surface(map, label).unwrap();
            TriMesh::new(points, triangles).unwrap()
        };
        labels.map(surface).to_vec()
    };
    let right = surfaces(&labels, RIGHT);
    let middle = right[0].points.iter().map(|p| p.x).sum::<f64>() / right[0].points.len() as f64;
    let mirrored = [&image, &labels].map(|volume| mirror(volume, middle));
    let left = surfaces(&mirrored[1], LEFT);
    let leg = read_skeleton(&data.join("lowerlimb_vhm/skeleton.json")).unwrap().skeleton;
    let template = hands::only(&leg, &BONES);
    // The template lies near enough; from a start of its own the left side is not found.
    let near = Options { align: false, ..Options::default() };
    let placed = on_labels(&template, &left, &near);
    let case = |cut: bool| {
        let start = if cut {
            on_labels(&inside(&template, &placed, &mirrored[0]), &left, &Options::default())
        } else {
            placed.clone()
        };
        Case {
            name: pelvis_name(cut).into(),
            reference: start.clone(),
            reference_image: mirrored[0].clone(),
            start,
            image: image.clone(),
            truth: Truth::Surfaces(right.clone()),
        }
    };
    wanted.into_iter().map(case).collect()
}

fn pelvis_name(cut: bool) -> &'static str {
    if cut {
        "CT, the mirrored other side, bones cut"
    } else {
        "CT, the mirrored other side, whole bones"
    }
}

/// The image mirrored about the plane x = `middle`.
pub fn mirror(volume: &Volume, middle: f64) -> Volume {
    let flip = Mat3::from_diagonal(&Vec3::new(-1.0, 1.0, 1.0));
    let origin = flip * volume.origin() + Vec3::new(2.0 * middle, 0.0, 0.0);
    let map = flip * volume.world_from_voxel();
    Volume::new(volume.size(), volume.values().to_vec(), map, origin).unwrap()
}

/// The triangles of the template that an image shows where the sacrum and the hip lie as in `placed`.
fn inside(template: &Skeleton, placed: &Skeleton, image: &Volume) -> Skeleton {
    let femur = &template.bones[2].vertices;
    let seen: Vec<f64> =
        (0..template.points.len()).map(|v| f64::from(!femur.contains(&v))).collect();
    let motion = whole_motion(&template.points, &placed.points, &seen);
    let cut = |b: usize| {
        let bone = template.bone_surface(b, &template.points);
        let shown =
            |p: &Vec3| image.sample(&(motion * nalgebra::Point3::from(*p)).coords).is_some();
        let shown: Vec<bool> = bone.points.iter().map(shown).collect();
        let piece = damage::kept(&bone, |t| bone.triangles[t].iter().all(|v| shown[*v as usize]));
        (template.bones[b].name.clone(), piece)
    };
    Skeleton::new((0..template.bones.len()).map(cut).collect(), template.joints.clone()).unwrap()
}

/// The bones registered to surfaces of their own.
fn on_labels(bones: &Skeleton, surfaces: &[TriMesh], options: &Options) -> Skeleton {
    let named = bones.bones.iter().map(|b| b.name.clone()).zip(surfaces.to_vec()).collect();
    let target = Target::per_bone(bones, named).unwrap();
    register(bones, &target, options, &Run::new()).unwrap().skeleton
}
