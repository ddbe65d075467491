//! A person's skeleton written back into the OpenSim model that its template came from.
//!
//! Bodies keep their axes where their own joint is: the joint's frame on the child body stays, the frame
//! on the parent body takes up the change, so that the model at its default values lies as the person.
//! Muscle points and markers on a body follow the bone's shape around them.

use std::collections::HashMap;
use std::path::Path;

use nalgebra::{Isometry3, Point3, Translation3};

use super::osim_read::read_osim_skeleton;
use crate::error::{Error, Result};
use crate::io::osim::{OsimJoint, OsimModel, parse_osim};
use crate::io::osim_edit::{OsimChanges, edit_osim};
use crate::io::skeleton::SkeletonDocument;
use crate::io::{file_name, read_bytes, write_beside, write_surface};
use crate::job::register::scene::metres_per_unit;
use crate::job::register::skeleton_build::build_skeleton;
use crate::math::Vec3;
use crate::register::Skeleton;
use crate::register::animation::{joint_angles, joint_rotation};
use crate::register::areas::vertex_areas;
use crate::register::joint_frames::follow_shape;
use crate::register::pose::rigid_targets;

/// Names of joint and coordinate with what changes, and the bodies' places.
struct Changes {
    template: Skeleton,
    person: Skeleton,
    areas: Vec<f64>,
    /// World from body, template and person.
    bodies: HashMap<String, (usize, [Isometry3<f64>; 2])>,
    frames: HashMap<String, [Isometry3<f64>; 2]>,
    angles: HashMap<String, f64>,
}

/// Writes `person` with its file, whose template is the OpenSim model `original`, as a model with its meshes in
/// `Geometry/` beside it. Returns notes on what was not carried over.
pub fn write_osim(
    original: &Path,
    person: &Skeleton,
    document: &SkeletonDocument,
    to: &Path,
) -> Result<Vec<String>> {
    let text = String::from_utf8_lossy(&read_bytes(original)?).into_owned();
    let model = parse_osim(&text, original)?;
    let (own_document, meshes, mut notes) = read_osim_skeleton(original)?;
    let template = build_skeleton(&own_document, meshes)?;
    let person = in_metres(person, metres_per_unit(document.units.as_deref()));
    check_same(&template, &person, original)?;
    let mut changes = Changes::new(&model, template, person);
    notes.extend(changes.hold_on_bodies_without_mesh(&model.joints));
    let edited = edit_osim(&text, original, &changes)?;
    changes.write_meshes(&to.parent().unwrap_or(Path::new("")).join("Geometry"))?;
    write_beside(to, |out| out.write_all(edited.as_bytes()))?;
    notes.push("masses and inertias are those of the template".into());
    Ok(notes)
}

impl Changes {
    fn new(model: &OsimModel, template: Skeleton, person: Skeleton) -> Self {
        let areas = vertex_areas(&template.points, &template.triangles);
        let bodies = moved_bodies(model, &template, &person, &areas);
        let (mut frames, mut angles) = (HashMap::new(), HashMap::new());
        let still = Isometry3::identity();
        for joint in &person.joints {
            let Some(old) = model.joints.iter().find(|j| j.name == joint.name) else { continue };
            let present = joint_angles(joint, &joint.transform(&still, &still).rotation);
            let turn = joint_rotation(joint, &present);
            let world = |body: &str| bodies.get(body).map_or(still, |b| b.1[1]);
            let parent_frame = joint.child_frame * turn.inverse();
            let own = [
                world(&old.parent).inv_mul(&parent_frame),
                world(&old.child).inv_mul(&joint.child_frame),
            ];
            frames.insert(joint.name.clone(), own);
            angles.extend(joint.coordinates.iter().map(|c| c.name.clone()).zip(present));
        }
        Self { template, person, areas, bodies, frames, angles }
    }

    /// Joints to bodies without a mesh, such as the ground, hold the body where the person lies. Returns a
    /// sentence on each.
    fn hold_on_bodies_without_mesh(&mut self, joints: &[OsimJoint]) -> Vec<String> {
        let mut notes = Vec::new();
        for old in joints {
            if self.frames.contains_key(&old.name) {
                continue;
            }
            if let (Some((_, [before, after])), false) =
                (self.bodies.get(&old.child), self.bodies.contains_key(&old.parent))
            {
                let moved = after * before.inverse();
                notes.push(format!(
                    "joint {}: its frame on {} is moved with the bone",
                    old.name, old.parent
                ));
                let parent_frame = moved * old.body_from_parent_frame;
                self.frames.insert(old.name.clone(), [parent_frame, old.body_from_child_frame]);
            }
        }
        notes
    }

    fn write_meshes(&self, folder: &Path) -> Result<()> {
        for (b, bone) in self.person.bones.iter().enumerate() {
            let (_, [_, world]) = self.bodies[&bone.name];
            let mut mesh = self.person.bone_surface(b, &self.person.points);
            for p in &mut mesh.points {
                *p = world.inverse_transform_point(&Point3::from(*p)).coords;
            }
            write_surface(&folder.join(mesh_name(&bone.name)), &mesh)?;
        }
        Ok(())
    }
}

/// Each body's number and its places, template and person. The person's follows from the first joint that
/// has the body as its child, else from the bone.
fn moved_bodies(
    model: &OsimModel,
    template: &Skeleton,
    person: &Skeleton,
    areas: &[f64],
) -> HashMap<String, (usize, [Isometry3<f64>; 2])> {
    let motions = rigid_targets(template, &template.points, &person.points, areas);
    let mut bodies = HashMap::new();
    for (b, bone) in template.bones.iter().enumerate() {
        let before = model.world_from_body[b];
        let after = motions[b].unwrap_or_else(Isometry3::identity) * before;
        bodies.insert(bone.name.clone(), (b, [before, after]));
    }
    let mut placed = vec![false; template.bones.len()];
    for joint in &person.joints {
        if let Some(old) = model.joints.iter().find(|j| j.name == joint.name)
            && !std::mem::replace(&mut placed[joint.child], true)
            && let Some(body) = bodies.get_mut(&old.child)
        {
            body.1[1] = joint.child_frame * old.body_from_child_frame.inverse();
        }
    }
    bodies
}

fn mesh_name(body: &str) -> String {
    format!("{}_person.obj", file_name(body))
}

fn in_metres(skeleton: &Skeleton, scale: f64) -> Skeleton {
    let mut scaled = skeleton.clone();
    for p in &mut scaled.points {
        *p *= scale;
    }
    for joint in &mut scaled.joints {
        for frame in [&mut joint.parent_frame, &mut joint.child_frame] {
            frame.translation = Translation3::from(frame.translation.vector * scale);
        }
        joint.limits.shift *= scale;
    }
    scaled
}

fn check_same(template: &Skeleton, person: &Skeleton, original: &Path) -> Result<()> {
    for bone in &template.bones {
        let found = person.bone_index(&bone.name).map(|b| &person.bones[b]);
        if found.map(|f| f.vertices.clone()) != Some(bone.vertices.clone()) {
            return Err(Error::invalid(format!(
                "bone {} is not the one of {}; give the model that the skeleton was converted from",
                bone.name,
                original.display()
            )));
        }
    }
    Ok(())
}

impl OsimChanges for Changes {
    fn frames(&self, joint: &str) -> Option<[Isometry3<f64>; 2]> {
        self.frames.get(joint).copied()
    }

    fn default_value(&self, coordinate: &str) -> Option<f64> {
        self.angles.get(coordinate).copied()
    }

    fn mesh(&self, body: &str) -> Option<String> {
        self.bodies.contains_key(body).then(|| mesh_name(body))
    }

    fn point(&self, body: &str, location: [f64; 3]) -> Option<[f64; 3]> {
        let (b, [before, after]) = self.bodies.get(body)?;
        let world: Vec3 = (before * Point3::from(Vec3::from(location))).coords;
        let frame = Isometry3::translation(world.x, world.y, world.z);
        let shapes = [self.template.points.as_slice(), self.person.points.as_slice()];
        let moved = follow_shape(&self.template, *b, &frame, shapes, &self.areas);
        let place = after.inverse_transform_point(&Point3::from(moved.translation.vector));
        Some(place.coords.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::convert::conversion::{Conversion, convert};
    use crate::job::register::skeleton_files::read_skeleton;
    use crate::register::rotation::turned_about;
    use nalgebra::UnitQuaternion;

    const MODEL: &str = r#"<?xml version="1.0"?>
<OpenSimDocument Version="40000"><Model name="arm"><!-- a comment --><BodySet><objects>
 <Body name="a"><attached_geometry><Mesh><mesh_file>bone.obj</mesh_file><scale_factors>1 2 1</scale_factors></Mesh></attached_geometry><mass>3</mass></Body>
 <Body name="b"><attached_geometry><Mesh><mesh_file>bone.obj</mesh_file></Mesh></attached_geometry></Body></objects></BodySet>
<JointSet><objects>
 <WeldJoint name="base"><socket_parent_frame>/ground</socket_parent_frame><socket_child_frame>/bodyset/a</socket_child_frame></WeldJoint>
 <PinJoint name="ab"><socket_parent_frame>f</socket_parent_frame><socket_child_frame>/bodyset/b</socket_child_frame>
  <coordinates><Coordinate name="bend"><default_value>0.2</default_value><range>-2 2</range></Coordinate></coordinates>
  <frames><PhysicalOffsetFrame name="f"><socket_parent>/bodyset/a</socket_parent><translation>2 0 0</translation><orientation>0.1 0.2 0.3</orientation></PhysicalOffsetFrame></frames></PinJoint>
 </objects></JointSet>
<ForceSet><Strange wish="kept"><PathPoint name="p"><socket_parent_frame>/bodyset/b</socket_parent_frame><location>0.5 0.25 0</location></PathPoint></Strange></ForceSet>
</Model></OpenSimDocument>"#;

    #[test]
    fn a_person_is_written_into_the_model_and_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("arm.osim"), MODEL).unwrap();
        let bone = "v 0 0 0\nv 1 0 0\nv 0 0.5 0\nv 0 0 0.3\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
        std::fs::write(at("bone.obj"), bone).unwrap();
        let to_skeleton = Conversion {
            from: at("arm.osim"),
            to: at("arm.skeleton.json"),
            ..Conversion::default()
        };
        convert(&to_skeleton).unwrap();

        // A larger person, the elbow bent, somewhere else.
        let mut person = read_skeleton(&at("arm.skeleton.json")).unwrap();
        person.skeleton = in_metres(&person.skeleton, 1.1);
        let frame = person.skeleton.joints[0].child_frame;
        let turn = frame.rotation * UnitQuaternion::from_scaled_axis(Vec3::z() * 0.7);
        let turn = turn * frame.rotation.inverse();
        let bend = turned_about(&Isometry3::identity(), &frame.translation.vector, turn);
        let away = Isometry3::new(Vec3::new(3.0, 1.0, -2.0), Vec3::new(0.3, 1.0, 0.2));
        person.skeleton.move_bones(&[away, away * bend]);
        std::fs::create_dir(at("out")).unwrap();
        let notes =
            write_osim(&at("arm.osim"), &person.skeleton, &person.document, &at("out/person.osim"))
                .unwrap();
        assert!(notes.iter().any(|n| n.contains("base")), "{notes:?}");

        let text = std::fs::read_to_string(at("out/person.osim")).unwrap();
        for kept in ["<!-- a comment -->", "wish=\"kept\"", "<mass>3</mass>"] {
            assert!(text.contains(kept), "{kept}");
        }
        let (document, meshes, _) = read_osim_skeleton(&at("out/person.osim")).unwrap();
        let again = build_skeleton(&document, meshes).unwrap();
        let far = again.points.iter().zip(&person.skeleton.points).map(|(p, q)| (p - q).norm());
        assert!(far.fold(0.0, f64::max) < 1e-6);
        let (a, b) = (&again.joints[0], &person.skeleton.joints[0]);
        let apart = a.child_frame.inv_mul(&b.child_frame);
        assert!(apart.translation.vector.norm() < 1e-9 && apart.rotation.angle() < 1e-9);
        let angle = |s: &Skeleton| crate::register::animation::present_angles(s)[0].1;
        assert!((angle(&again) - angle(&person.skeleton)).abs() < 1e-9);
        assert!((angle(&again) - 0.9).abs() < 1e-9);
        // The point on the muscle's path grows with its bone.
        let place = text.split("<location>").nth(1).unwrap().split("</location>").next().unwrap();
        let place: Vec<f64> = place.split(' ').map(|x| x.parse().unwrap()).collect();
        let before = Vec3::new(0.5, 0.25, 0.0);
        assert!((Vec3::from_column_slice(&place) - before * 1.1).norm() < 0.05, "{place:?}");
    }

    #[test]
    fn another_model_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("arm.osim"), MODEL).unwrap();
        let bone = "v 0 0 0\nv 1 0 0\nv 0 0.5 0\nv 0 0 0.3\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
        std::fs::write(at("bone.obj"), bone).unwrap();
        let (document, meshes, _) = read_osim_skeleton(&at("arm.osim")).unwrap();
        let mut person = build_skeleton(&document, meshes).unwrap();
        person.bones[1].name = "c".into();
        let error = write_osim(&at("arm.osim"), &person, &document, &at("p.osim"));
        let error = error.unwrap_err().to_string();
        assert!(error.contains("bone b"), "{error}");
    }
}
