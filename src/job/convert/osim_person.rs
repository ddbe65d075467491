//! A person's bodies, joints and default pose, in the terms of the OpenSim model of the template.

use std::collections::HashMap;

use nalgebra::{Isometry3, Translation3};

use super::osim_pose::fit_coordinates;
use super::osim_shape::BodyShape;
use crate::io::osim::joint::{OsimCoordinate, OsimJoint, Values};
use crate::io::osim::model::OsimModel;
use crate::io::osim::pose::Places;
use crate::math::Vec3;
use crate::register::Skeleton;
use crate::register::areas::vertex_areas;
use crate::register::pose::rigid_targets;

/// Beyond its range by less than this, a coordinate is not worth a sentence, radians.
const SMALL_ANGLE: f64 = 0.01;

/// The person in the model's terms.
pub struct OsimPerson {
    /// World from body where the person lies.
    pub world: Places,
    /// How the bodies with bones change.
    pub shapes: HashMap<String, BodyShape>,
    /// The model's joints with the person's frames and shifts.
    pub joints: Vec<OsimJoint>,
    /// The coordinates' default values.
    pub values: Values,
    /// Coordinates that the person has beyond their range, in sentences.
    pub notes: Vec<String>,
}

impl OsimPerson {
    /// The person whose bones and joints are `person`, metres; `template` is the model's own skeleton, whose
    /// bodies are at `before`.
    pub fn new(model: &OsimModel, before: &Places, template: &Skeleton, person: &Skeleton) -> Self {
        let areas = vertex_areas(&template.points, &template.triangles);
        let mut new = Self {
            world: person_places(model, before, [template, person], &areas),
            shapes: HashMap::new(),
            joints: model.joints.clone(),
            values: model.default_values(),
            notes: Vec::new(),
        };
        for bone in &template.bones {
            let (Some(before), Some(after)) = (before.get(&bone.name), new.world.get(&bone.name))
            else {
                continue;
            };
            let seen = |body: &Isometry3<f64>, points: &[Vec3]| -> Vec<Vec3> {
                let points = points[bone.vertices.clone()].iter();
                points.map(|p| body.inverse_transform_point(&(*p).into()).coords).collect()
            };
            let shape = BodyShape::new(
                &seen(before, &template.points),
                &seen(after, &person.points),
                &areas[bone.vertices.clone()],
            );
            new.shapes.insert(bone.name.clone(), shape);
        }
        new.take_pose(model, person);
        new.stretch_joints();
        new.take_frames(person);
        new
    }

    /// Coordinates go where the person lies, as far as their ranges let them.
    fn take_pose(&mut self, model: &OsimModel, person: &Skeleton) {
        for joint in &person.joints {
            let Some(own) = model.joints.iter().find(|j| j.name == joint.name) else { continue };
            let wanted = joint.parent_frame.rotation.inverse() * joint.child_frame.rotation;
            let free: Vec<&OsimCoordinate> =
                own.coordinates.iter().filter(|c| model.leader(&c.name).is_none()).collect();
            let mut beyond = self.values.clone();
            fit_coordinates(own, &free, &wanted, false, &mut beyond);
            fit_coordinates(own, &free, &wanted, true, &mut self.values);
            for c in free {
                let wish = beyond[&c.name];
                let over = wish - wish.clamp(c.range[0], c.range[1]);
                if over.abs() > SMALL_ANGLE {
                    self.notes.push(format!(
                        "coordinate {}: the person lies {:.1} degrees beyond its range; the frame of joint {} \
                         takes that up",
                        c.name,
                        over.abs().to_degrees(),
                        own.name
                    ));
                }
            }
        }
        model.couple(&mut self.values);
    }

    /// Shifts of a joint grow with the parent's bone, except those that are a coordinate themselves.
    fn stretch_joints(&mut self) {
        for joint in &mut self.joints {
            let Some(shape) = self.shapes.get(&joint.parent) else { continue };
            for axis in joint.translations.iter_mut().filter(|a| a.own_coordinate().is_none()) {
                let direction = joint.body_from_parent_frame.rotation * axis.direction;
                axis.stretch = shape.along(&direction);
            }
        }
    }

    /// Frames on the bodies, so that the default pose is the person's. Where both bodies of a joint have a
    /// place, its frame on the parent takes up the rest; a body without a bone gets its place from its joint,
    /// and so does the ground: the first bone that is joined to it stands where the template's stood.
    fn take_frames(&mut self, person: &Skeleton) {
        for joint in &mut self.joints {
            if let (Some(found), Some(body)) =
                (person.joints.iter().find(|j| j.name == joint.name), self.world.get(&joint.child))
            {
                joint.body_from_child_frame = body.inv_mul(&found.child_frame);
            } else if let Some(shape) = self.shapes.get(&joint.child) {
                joint.body_from_child_frame = moved(&joint.body_from_child_frame, shape);
            }
            if let Some(shape) = self.shapes.get(&joint.parent) {
                joint.body_from_parent_frame = moved(&joint.body_from_parent_frame, shape);
            }
        }
        let mut open: Vec<usize> = (0..self.joints.len()).collect();
        let mut waiting = usize::MAX;
        while open.len() < waiting {
            waiting = open.len();
            open.retain(|&j| !self.place(j));
        }
    }

    /// Settles a joint of which at least one body has a place.
    fn place(&mut self, j: usize) -> bool {
        let joint = &mut self.joints[j];
        let ends = [&joint.parent, &joint.child].map(|body| self.world.get(body).copied());
        let across = joint.transform(&self.values);
        let child_frame = |child: Isometry3<f64>| child * joint.body_from_child_frame;
        match ends {
            [None, None] => return false,
            [Some(parent), Some(child)] => {
                let frame = child_frame(child) * across.inverse();
                joint.body_from_parent_frame = parent.inv_mul(&frame);
            }
            [Some(parent), None] => {
                let frame = parent * joint.body_from_parent_frame * across;
                let child = frame * joint.body_from_child_frame.inverse();
                self.world.insert(joint.child.clone(), child);
            }
            [None, Some(child)] => {
                let frame = child_frame(child) * across.inverse();
                let parent = frame * joint.body_from_parent_frame.inverse();
                self.world.insert(joint.parent.clone(), parent);
            }
        }
        true
    }
}

fn moved(frame: &Isometry3<f64>, shape: &BodyShape) -> Isometry3<f64> {
    let place = shape.point(&frame.translation.vector);
    Isometry3::from_parts(Translation3::from(place), frame.rotation)
}

/// World from body of the person's bones. It follows from the first joint that has the body as its child,
/// else from the bone.
fn person_places(
    model: &OsimModel,
    before: &Places,
    [template, person]: [&Skeleton; 2],
    areas: &[f64],
) -> Places {
    let motions = rigid_targets(template, &template.points, &person.points, areas);
    let mut after = Places::new();
    for (bone, motion) in template.bones.iter().zip(motions) {
        let joint = person.joints.iter().find(|j| person.bones[j.child].name == bone.name);
        let own = joint.and_then(|joint| {
            let own = model.joints.iter().find(|j| j.name == joint.name)?;
            Some(joint.child_frame * own.body_from_child_frame.inverse())
        });
        let from_bone = || Some(motion? * before.get(&bone.name)?);
        after.insert(bone.name.clone(), own.or_else(from_bone).unwrap_or_default());
    }
    after
}
