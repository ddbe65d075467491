//! Another person's hand, with a template's image and the person's own.

use moulage::register::Skeleton;
use moulage::register::elastic::whole_motion;
use moulage::volume::Volume;

use super::cases::{CT, Case, VOXELS, vertices};
use super::hands;
use super::synthetic::{Looks, image};

pub struct Person {
    pub template: Skeleton,
    pub reference: Volume,
    pub bones: Skeleton,
    seed: u64,
}

impl Person {
    /// With joints at `bend` of the way to the ends of their ranges.
    pub fn new(seed: u64, bend: f64) -> Self {
        let template = hands::template();
        let reference = image(&template, VOXELS, &CT, 5, 1.0);
        let bones = hands::in_a_pose(&hands::person(&template, seed, 0.5, 0.3), seed, bend);
        Self { template, reference, bones, seed }
    }

    /// The template laid on the person as one body.
    pub fn start(&self) -> Skeleton {
        let alike = vec![1.0; self.template.points.len()];
        let motion = whole_motion(&self.template.points, &self.bones.points, &alike);
        let mut start = self.template.clone();
        start.move_bones(&vec![motion; self.template.bones.len()]);
        start
    }

    /// An image of the person, or of these bones.
    pub fn seen(&self, bones: &Skeleton, voxels: [f64; 3], looks: &Looks) -> Volume {
        image(bones, voxels, looks, 77 + self.seed, 1.0)
    }

    pub fn case(&self, name: &str, start: &Skeleton, image: Volume) -> Case {
        Case {
            name: name.into(),
            reference: self.template.clone(),
            reference_image: self.reference.clone(),
            start: start.clone(),
            image,
            truth: vertices(&self.bones),
        }
    }
}
