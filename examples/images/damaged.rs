//! Images in which a hand is hard to find, or is not there at all.

use moulage::register::{Bone, Skeleton};
use moulage::volume::Volume;

use super::cases::{CT, Case, Truth, VOXELS, mirror, moved, vertices};
use super::hands;
use super::person::Person;
use super::synthetic::Looks;

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

pub fn all(chosen: &impl Fn(&str) -> bool) -> Vec<Case> {
    let person = Person::new(1, 0.15);
    let start = person.start();
    let seen = person.seen(&person.bones, VOXELS, &CT);
    let mut cases = Vec::new();
    for (millimetres, degrees) in [(20.0, 0.0), (0.0, 30.0), (30.0, 20.0), (60.0, 0.0)] {
        let name = format!("hand, begun {millimetres} mm and {degrees} degrees off");
        cases.push(person.case(&name, &moved(&start, millimetres, degrees), seen.clone()));
    }
    for (name, voxels, looks) in [
        ("hand, noise of 250", VOXELS, NOISY),
        ("hand, noise of 900", VOXELS, BURIED),
        ("hand, bones not to be seen", VOXELS, UNSEEN),
        ("hand, another kind of image", VOXELS, MAGNETIC),
        ("hand, slices of 4 mm", THICK, CT),
    ] {
        cases.push(person.case(name, &start, person.seen(&person.bones, voxels, &looks)));
    }
    cases.push(bent());
    cases.push(without_a_finger(&person, &start));
    cases.push(cut(&person, &start, &seen));
    cases.push(other_side(&person, &start, &seen));
    cases.retain(|case| chosen(&case.name));
    cases
}

fn bent() -> Case {
    let person = Person::new(1, 0.6);
    let seen = person.seen(&person.bones, VOXELS, &CT);
    person.case("hand, far more bent than the template", &person.start(), seen)
}

/// The case without a truth for the bones that are `absent` from the image.
fn without(mut case: Case, absent: &[bool]) -> Case {
    if let Truth::Vertices(places) = &mut case.truth {
        for (place, _) in places.iter_mut().zip(absent).filter(|(_, absent)| **absent) {
            *place = None;
        }
    }
    case
}

fn without_a_finger(person: &Person, start: &Skeleton) -> Case {
    let names = || person.bones.bones.iter().map(|bone| bone.name.as_str());
    let absent: Vec<bool> = names().map(|name| FINGER.contains(&name)).collect();
    let kept: Vec<&str> = names().filter(|name| !FINGER.contains(name)).collect();
    let seen = person.seen(&hands::only(&person.bones, &kept), VOXELS, &CT);
    without(person.case("hand, a finger less", start, seen), &absent)
}

/// The image ends within the hand.
fn cut(person: &Person, start: &Skeleton, seen: &Volume) -> Case {
    let size = seen.size();
    let along = (0..3).max_by_key(|&k| size[k]).unwrap_or(0);
    let mut left = size;
    left[along] = (LEFT * size[along] as f64) as usize;
    let values = (0..left.iter().product::<usize>())
        .map(|v| seen.at([v % left[0], v / left[0] % left[1], v / (left[0] * left[1])]))
        .collect();
    let image = Volume::new(left, values, *seen.world_from_voxel(), seen.origin()).unwrap();
    let bones = &person.bones;
    let outside =
        |bone: &Bone| bones.points[bone.vertices.clone()].iter().all(|p| image.sample(p).is_none());
    let absent: Vec<bool> = bones.bones.iter().map(outside).collect();
    without(person.case("hand, the image ends within it", start, image), &absent)
}

/// The image of the person's other hand.
fn other_side(person: &Person, start: &Skeleton, seen: &Volume) -> Case {
    let points = &person.bones.points;
    let middle = points.iter().map(|p| p.x).sum::<f64>() / points.len() as f64;
    let mut other = person.bones.clone();
    for p in &mut other.points {
        p.x = 2.0 * middle - p.x;
    }
    let case = person.case("hand, the other hand's image", start, mirror(seen, middle));
    Case { truth: vertices(&other), ..case }
}
