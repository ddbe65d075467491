//! The bones and joints of an OpenSim model as the document of a skeleton.
//!
//! To a registration a joint's motion is an ellipsoid of rotation vectors and a shift, which is an
//! approximation of OpenSim's separate and coupled ranges.

use nalgebra::{Isometry3, Translation3};

use crate::io::osim::joint::{Axis, OsimCoordinate, OsimJoint, Values};
use crate::io::osim::model::OsimModel;
use crate::io::osim::pose::{GROUND, Places, places};
use crate::io::skeleton::{
    BoneEntry, CoordinateEntry, FORMAT, FollowsEntry, FrameEntry, JointEntry, LimitsEntry,
    SidesEntry, SkeletonDocument, StationEntry, VERSION,
};
use crate::math::Vec3;
use crate::register::rotation::rotation_vector;

/// A coordinate beyond this many radians or metres is free.
const FREE: f64 = 100.0;
/// Least rotation to each side of an axis, degrees: two persons' axes differ a little.
const LEAST_DEGREES: f64 = 3.0;
/// Values of a coordinate at which its joint's limits are looked up.
const SAMPLES: usize = 32;

/// The document of a model's bodies with meshes and the joints between them, with sentences on what is left
/// out. Joints lie as in the default pose. The `shift` of their limits is how far their coordinates carry
/// them; bones name no mesh file.
pub fn osim_document(model: &OsimModel) -> (SkeletonDocument, Vec<String>) {
    let values = model.default_values();
    let world = places(&model.joints, &values);
    let mut notes = model.notes.clone();
    let (with, without): (Vec<_>, Vec<_>) =
        model.bodies.iter().partition(|body| !body.meshes.is_empty());
    notes.extend(without.iter().map(|b| format!("body {} has no mesh and is left out", b.name)));
    let is_bone = |name: &String| with.iter().any(|body| body.name == *name);
    let (inside, outside): (Vec<_>, Vec<_>) =
        model.joints.iter().partition(|j| is_bone(&j.parent) && is_bone(&j.child));
    let connects = |j: &&OsimJoint| format!("joint {} connects a body without mesh", j.name);
    notes.extend(outside.iter().filter(|j| j.parent != GROUND).map(connects));
    let bone = |name: &String| BoneEntry { name: name.clone(), ..BoneEntry::default() };
    let document = SkeletonDocument {
        format: FORMAT.into(),
        version: VERSION,
        units: Some("m".into()),
        bones: with.iter().map(|body| bone(&body.name)).collect(),
        joints: inside.iter().map(|joint| entry(joint, model, &values, &world)).collect(),
        ..SkeletonDocument::default()
    };
    (document, notes)
}

fn entry(joint: &OsimJoint, model: &OsimModel, values: &Values, world: &Places) -> JointEntry {
    let placed = |body: &String, frame: &Isometry3<f64>| {
        FrameEntry::from(&(world.get(body).copied().unwrap_or_default() * frame))
    };
    // The two frames meet where the default pose has carried them.
    let met = joint.body_from_parent_frame * Translation3::from(joint.shift(values));
    let coordinates = own_angles(joint, model).map(|(coordinate, axis)| CoordinateEntry {
        name: coordinate.name.clone(),
        axis: axis.into(),
        range_deg: coordinate.range.map(|x| x.clamp(-FREE, FREE).to_degrees()),
    });
    JointEntry {
        name: joint.name.clone(),
        parent: joint.parent.clone(),
        child: joint.child.clone(),
        parent_frame: Some(placed(&joint.parent, &met)),
        child_frame: Some(placed(&joint.child, &joint.body_from_child_frame)),
        limits: limits(joint, model, values),
        tree: true,
        source: Some("osim".into()),
        coordinates: coordinates.collect(),
        follows: path(joint, model, values),
        ..JointEntry::default()
    }
}

/// The coordinates that are angles of the joint themselves and follow no other, each with its axis.
fn own_angles<'a>(
    joint: &'a OsimJoint,
    model: &'a OsimModel,
) -> impl Iterator<Item = (&'a OsimCoordinate, Vec3)> {
    joint.rotations.iter().filter_map(|axis| {
        let (name, direction) = axis.own_coordinate()?;
        let coordinate = joint.coordinates.iter().find(|c| c.name == name)?;
        model.leader(name).is_none().then_some((coordinate, direction))
    })
}

/// The way of a joint that one angle leads and that is more than a turn by it.
fn path(joint: &OsimJoint, model: &OsimModel, values: &Values) -> Option<FollowsEntry> {
    let moving = joint.rotations.iter().chain(&joint.translations);
    let moving: Vec<&Axis> = moving.filter(|axis| !axis.function.is_constant()).collect();
    let mut leaders: Vec<&str> = moving
        .iter()
        .filter_map(|axis| axis.coordinate.as_deref())
        .map(|c| led_by(c, model))
        .collect();
    leaders.dedup();
    let [leader] = leaders[..] else { return None };
    let is_turn = moving.len() == 1 && own_angles(joint, model).next().is_some();
    let mut angles = model.joints.iter().flat_map(|joint| own_angles(joint, model));
    if is_turn || !angles.any(|(coordinate, _)| coordinate.name == leader) {
        return None;
    }
    let range = model.coordinates().find(|c| c.name == leader)?.range;
    let [low, high] = range.map(|x| x.clamp(-std::f64::consts::PI, std::f64::consts::PI));
    // The default pose may lie beyond the range.
    let default = values.get(leader)?;
    let (low, high) = (low.min(*default), high.max(*default));
    if low >= high {
        return None;
    }
    let still = Translation3::from(joint.shift(values)).inverse();
    let stations = spread([low, high]).map(|value| {
        let mut values = values.clone();
        values.insert(leader.to_string(), value);
        model.couple(&mut values);
        let FrameEntry { t, q } = (&(still * joint.transform(&values))).into();
        StationEntry { deg: value.to_degrees(), t, q }
    });
    Some(FollowsEntry { angle: leader.into(), path: stations.collect(), ..FollowsEntry::default() })
}

/// The coordinate that a coordinate follows in the end, or itself.
fn led_by<'a>(coordinate: &'a str, model: &'a OsimModel) -> &'a str {
    // As many steps as couplers: they may lead in a circle.
    let steps = 0..model.couplers.len();
    steps.fold(coordinate, |name, _| model.leader(name).map_or(name, |c| c.leading.as_str()))
}

/// What the joint does while each of its coordinates goes through its range, the others as they are.
fn limits(joint: &OsimJoint, model: &OsimModel, values: &Values) -> LimitsEntry {
    let (mut low, mut high) = (Vec3::zeros(), Vec3::zeros());
    let mut shift: f64 = 0.0;
    let still = joint.shift(values);
    for coordinate in &joint.coordinates {
        for value in values_within(&coordinate.name, coordinate.range, model) {
            let mut values = values.clone();
            values.insert(coordinate.name.clone(), value);
            let transform = joint.transform(&values);
            let turn = rotation_vector(&transform.rotation).map(f64::to_degrees);
            (low, high) = (low.inf(&turn), high.sup(&turn));
            shift = shift.max((transform.translation.vector - still).norm());
        }
    }
    let side = |x: &Vec3| std::array::from_fn(|k| Some(x[k].max(LEAST_DEGREES)));
    let mut sides = SidesEntry { neg: side(&-low), pos: side(&high) };
    // More than half a turn is free: rotation vectors end there.
    for (coordinate, axis) in own_angles(joint, model) {
        let k = axis.iamax();
        let beyond = coordinate.range.map(|x| x.abs() > std::f64::consts::PI);
        let [low, high] = if axis[k] < 0.0 { [beyond[1], beyond[0]] } else { beyond };
        sides.neg[k] = sides.neg[k].filter(|_| !low);
        sides.pos[k] = sides.pos[k].filter(|_| !high);
    }
    LimitsEntry {
        rot_deg: sides,
        shift: Some(shift),
        shape: "ellipsoid".into(),
        ..LimitsEntry::default()
    }
}

/// Values over the range of a coordinate, or of the one that leads it.
fn values_within(name: &str, range: [f64; 2], model: &OsimModel) -> Vec<f64> {
    let bounded = |range: [f64; 2]| spread(range.map(|x| x.clamp(-FREE, FREE)));
    let Some(coupler) = model.leader(name) else {
        return bounded(range).collect();
    };
    let leading = model.coordinates().find(|c| c.name == coupler.leading);
    bounded(leading.map_or([0.0; 2], |c| c.range)).map(|x| coupler.function.value(x)).collect()
}

/// Values from one to the other in even steps.
fn spread([low, high]: [f64; 2]) -> impl Iterator<Item = f64> {
    (0..=SAMPLES).map(move |k| low + (high - low) * k as f64 / SAMPLES as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::osim::model::tests::LEG;
    use crate::job::register::skeleton_build::build_skeleton;
    use crate::mesh::TriMesh;
    use crate::register::animation::posed;
    use std::path::Path;

    #[test]
    fn joints_meet_in_the_default_pose_and_have_the_limits_of_their_motion() {
        let model = OsimModel::parse(LEG, Path::new("leg.osim")).unwrap();
        let (document, notes) = osim_document(&model);
        assert_eq!(document.bones.len(), 3);
        assert_eq!(notes.len(), 3, "{notes:?}");
        let knee = &document.joints[0];
        let [parent, child] = [knee.parent_frame.unwrap(), knee.child_frame.unwrap()];
        assert!((Vec3::from(parent.t) - Vec3::new(0.005, -0.4, 0.0)).norm() < 1e-12);
        assert!((Vec3::from(parent.t) - Vec3::from(child.t)).norm() < 1e-12);
        assert!((knee.coordinates[0].axis[2] - 1.0).abs() < 1e-12);
        assert!((knee.coordinates[0].range_deg[0] + 2_f64.to_degrees()).abs() < 1e-9);
        let sides = &knee.limits.rot_deg;
        assert!((sides.neg[2].unwrap() - 2_f64.to_degrees()).abs() < 1e-9);
        assert!((sides.pos[2].unwrap() - 0.1_f64.to_degrees()).abs() < 1e-9);
        assert_eq!((sides.neg[0], sides.pos[1]), (Some(LEAST_DEGREES), Some(LEAST_DEGREES)));
        // From 0.5 to -2 along a hundredth of the angle.
        assert!((knee.limits.shift.unwrap() - 0.025).abs() < 1e-12);
        // What is led by another coordinate has no angle of its own, but its leader's range.
        let groove = &document.joints[1];
        assert!(groove.coordinates.is_empty());
        assert!((groove.limits.rot_deg.pos[0].unwrap() - 1_f64.to_degrees()).abs() < 1e-9);
        assert_eq!(groove.limits.rot_deg.neg[0], Some(LEAST_DEGREES));
    }

    #[test]
    fn bodies_go_as_the_model_says_when_an_angle_leads_them() {
        let text = LEG.replace(
            "<LinearFunction><coefficients>0.01 0</coefficients></LinearFunction>",
            "<SimmSpline><x>-2 -1 0 0.5</x><y>0.006 0.01 0 0.001</y></SimmSpline>",
        );
        let model = OsimModel::parse(&text, Path::new("leg.osim")).unwrap();
        let (document, _) = osim_document(&model);
        let triangle =
            TriMesh::new(vec![Vec3::x(), Vec3::y(), Vec3::z()], vec![[0, 1, 2]]).unwrap();
        let skeleton = build_skeleton(&document, vec![triangle; 3]).unwrap();
        let start = places(&model.joints, &model.default_values());
        for angle in [-1.95, -1.7, -0.3, 0.05, 0.4] {
            let motions = posed(&skeleton, 0, |name| (name == "knee_angle").then_some(angle));
            let mut values = model.default_values();
            values.insert("knee_angle".into(), angle);
            model.couple(&mut values);
            let there = places(&model.joints, &values);
            for (bone, motion) in skeleton.bones.iter().zip(&motions) {
                let rest = (motion * start[&bone.name]).inv_mul(&there[&bone.name]);
                let (far, turn) = (rest.translation.vector.norm(), rest.rotation.angle());
                assert!(far < 5e-5 && turn < 1e-9, "{} at {angle}: {far} {turn}", bone.name);
            }
        }
    }

    #[test]
    fn more_than_half_a_turn_is_free() {
        let wide = LEG.replace("<range>-2 0.1</range>", "<range>-4 0.1</range>");
        let model = OsimModel::parse(&wide, Path::new("leg.osim")).unwrap();
        let sides = osim_document(&model).0.joints[0].limits.rot_deg.clone();
        assert_eq!(sides.neg[2], None);
        assert!(sides.pos[2].is_some());
    }
}
