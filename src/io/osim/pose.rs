//! Where the bodies of a model are at given values of its coordinates.

use std::collections::HashMap;

use nalgebra::Isometry3;

use super::joint::{OsimJoint, Values};

/// World from body, by name.
pub type Places = HashMap<String, Isometry3<f64>>;

/// Name of the body that never moves.
pub const GROUND: &str = "ground";

/// World from body, from the ground outwards; bodies that no joint leads to are missing.
pub fn places(joints: &[OsimJoint], values: &Values) -> Places {
    let mut world = Places::from([(GROUND.to_string(), Isometry3::identity())]);
    for _ in 0..joints.len() {
        for joint in joints {
            if let Some(parent) = world.get(&joint.parent).copied()
                && !world.contains_key(&joint.child)
            {
                let parent_frame = parent * joint.body_from_parent_frame;
                let child_frame = parent_frame * joint.transform(values);
                let child = child_frame * joint.body_from_child_frame.inverse();
                world.insert(joint.child.clone(), child);
            }
        }
    }
    world
}
