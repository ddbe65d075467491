//! Images in which a hand is hard to find, or is not there at all.

use moulage::math::{Mat3, Vec3};
use moulage::register::{Bone, Skeleton};
use moulage::volume::Volume;

use super::cases::{CT, Case, Truth, VOXELS, mirror, moved, placed, vertices};
use super::hands;
use super::synthetic::{Looks, image};

/// Noise that buries the tissues, not the cortex.
const NOISY: Looks = Looks { noise: 250.0, ..CT };
/// Noise in which bones can hardly be seen.
const BURIED: Looks = Looks { noise: 900.0, ..CT };
/// Bones that look like the tissue around them.
const UNSEEN: Looks = Looks { cortex: 60.0, marrow: 60.0, ..CT };
/// Dark cortex, bright marrow: magnetic resonance.
const MAGNETIC: Looks = Looks { cortex: 40.0, marrow: 700.0, tissue: 300.0, air: 0.0, ..CT };
/// Voxels of thick slices, mm.
const THICK: [f64; 3] = [0.8, 0.8, 4.0];
/// Share of the image, along its longest axis, that is left of a cut one.
const LEFT: f64 = 0.67;
/// A finger that the person does not have.
const FINGER: [&str; 3] = ["3proxph", "3midph", "3distph"];

/// A template's image, one person, what the person's image shows of it.
struct Scene {
    template: Skeleton,
    reference: Volume,
    person: Skeleton,
}

impl Scene {
    fn case(&self, name: &str, start: &Skeleton, image: Volume) -> Case {
        Case {
            name: name.into(),
            reference: self.template.clone(),
            reference_image: self.reference.clone(),
            start: start.clone(),
            image,
            truth: vertices(&self.person),
        }
    }

    fn seen(&self, voxels: [f64; 3], looks: &Looks) -> Volume {
        image(&self.person, voxels, looks, 78, 1.0)
    }
}

pub fn all(chosen: &impl Fn(&str) -> bool) -> Vec<Case> {
    let template = hands::template();
    let reference = image(&template, VOXELS, &CT, 5, 1.0);
    let person = hands::in_a_pose(&hands::person(&template, 1, 0.5, 0.3), 1, 0.15);
    let scene = Scene { template, reference, person };
    let start = placed(&scene.template, &scene.person);
    let seen = scene.seen(VOXELS, &CT);
    let mut cases = Vec::new();
    for (millimetres, degrees) in [(20.0, 0.0), (0.0, 30.0), (30.0, 20.0), (60.0, 0.0)] {
        let name = format!("hand, begun {millimetres} mm and {degrees} degrees off");
        cases.push(scene.case(&name, &moved(&start, millimetres, degrees), seen.clone()));
    }
    for (name, voxels, looks) in [
        ("hand, noise of 250", VOXELS, NOISY),
        ("hand, noise of 900", VOXELS, BURIED),
        ("hand, bones not to be seen", VOXELS, UNSEEN),
        ("hand, another kind of image", VOXELS, MAGNETIC),
        ("hand, slices of 4 mm", THICK, CT),
    ] {
        cases.push(scene.case(name, &start, scene.seen(voxels, &looks)));
    }
    cases.push(bent(&scene));
    cases.push(without_a_finger(&scene, &start));
    cases.push(cut(&scene, &start, &seen));
    cases.push(other_side(&scene, &start, &seen));
    cases.retain(|case| chosen(&case.name));
    cases
}

fn bent(scene: &Scene) -> Case {
    let person = hands::in_a_pose(&hands::person(&scene.template, 1, 0.5, 0.3), 1, 0.6);
    let scene =
        Scene { person, template: scene.template.clone(), reference: scene.reference.clone() };
    let start = placed(&scene.template, &scene.person);
    scene.case("hand, far more bent than the template", &start, scene.seen(VOXELS, &CT))
}

/// A bone of the list that the truth does not hold.
fn without(mut case: Case, absent: impl Fn(usize, &Bone) -> bool) -> Case {
    if let Truth::Vertices(places) = &mut case.truth {
        for (b, place) in places.iter_mut().enumerate() {
            if absent(b, &case.reference.bones[b]) {
                *place = None;
            }
        }
    }
    case
}

fn without_a_finger(scene: &Scene, start: &Skeleton) -> Case {
    let absent = |bone: &Bone| FINGER.contains(&bone.name.as_str());
    let kept: Vec<&str> =
        scene.person.bones.iter().filter(|b| !absent(b)).map(|b| b.name.as_str()).collect();
    let seen = image(&hands::only(&scene.person, &kept), VOXELS, &CT, 78, 1.0);
    without(scene.case("hand, a finger less", start, seen), |_, bone| absent(bone))
}

/// The image ends within the hand.
fn cut(scene: &Scene, start: &Skeleton, seen: &Volume) -> Case {
    let size = seen.size();
    let along = (0..3).max_by_key(|&k| size[k]).unwrap_or(0);
    let mut left = size;
    left[along] = (LEFT * size[along] as f64) as usize;
    let values = (0..left.iter().product::<usize>())
        .map(|v| seen.at([v % left[0], v / left[0] % left[1], v / (left[0] * left[1])]))
        .collect();
    let map: Mat3 = *seen.world_from_voxel();
    let image = Volume::new(left, values, map, seen.origin()).unwrap();
    let inside = |p: &Vec3| image.sample(p).is_some();
    let gone: Vec<bool> = scene
        .person
        .bones
        .iter()
        .map(|bone| !scene.person.points[bone.vertices.clone()].iter().any(inside))
        .collect();
    without(scene.case("hand, the image ends within it", start, image), |b, _| gone[b])
}

/// The image of the person's other hand.
fn other_side(scene: &Scene, start: &Skeleton, seen: &Volume) -> Case {
    let points = &scene.person.points;
    let middle = points.iter().map(|p| p.x).sum::<f64>() / points.len() as f64;
    let mut other = scene.person.clone();
    for p in &mut other.points {
        p.x = 2.0 * middle - p.x;
    }
    let case = scene.case("hand, the other hand's image", start, mirror(seen, middle));
    Case { truth: vertices(&other), ..case }
}
