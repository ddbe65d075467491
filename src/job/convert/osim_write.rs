//! A person's skeleton written back into the OpenSim model that its template came from.
//!
//! Bodies keep their axes, joints their coordinates. The model at its default values lies as the person,
//! and stands where the template stood. Points, masses and lengths along muscles follow the bones.

use std::collections::HashMap;
use std::path::Path;

use nalgebra::{Point3, Translation3};

use super::osim_person::OsimPerson;
use super::osim_read::OsimFiles;
use crate::error::{Error, Result, Shown};
use crate::io::osim::edit::{OsimChanges, edit_osim};
use crate::io::osim::joint::{OsimJoint, Values};
use crate::io::osim::model::{OsimBody, OsimModel};
use crate::io::osim::pose::{Places, places};
use crate::io::skeleton::SkeletonDocument;
use crate::io::{file_name, stem, write_beside, write_surface};
use crate::job::register::scene::metres_per_unit;
use crate::job::register::skeleton_build::build_skeleton;
use crate::math::Vec3;
use crate::register::Skeleton;

/// Writes `person` with its file, whose template is the OpenSim model `original`, as a model with its meshes in
/// a folder of its name in `Geometry/` beside it. `mass` is the person's, kilograms; without it bodies keep the
/// template's density. Returns notes on what was not carried over.
pub fn write_osim(
    original: &Path,
    person: &Skeleton,
    document: &SkeletonDocument,
    mass: Option<f64>,
    to: &Path,
) -> Result<Vec<String>> {
    if mass.is_some_and(|kg| !(kg.is_finite() && kg > 0.0)) {
        return Err(Error::invalid("the mass must be a positive number of kilograms"));
    }
    let files = OsimFiles::read(original)?;
    let (own_document, bones, mut notes) = files.skeleton();
    let template = build_skeleton(&own_document, bones)?;
    let person = in_metres(person, metres_per_unit(document.units.as_deref()));
    check_same(&template, &person, original)?;
    let mut changes = Changes::new(&files.model, &template, &person, &stem(to));
    let total = changes.set_masses(&files.model.bodies, mass);
    if total <= 0.0 && mass.is_some() {
        return Err(Error::invalid(format!("no body of {} has a mass", original.shown())));
    }
    let edited = edit_osim(&files.text, original, &changes)?;
    changes.write_meshes(&person, files, to.parent().unwrap_or(Path::new("")))?;
    write_beside(to, |out| out.write_all(edited.as_bytes()))?;
    notes.append(&mut changes.person.notes);
    if mass.is_none() && total > 0.0 {
        notes.push(format!(
            "the bodies keep the template's density, {total:.1} kg in all; give the person's mass where it is known"
        ));
    }
    Ok(notes)
}

/// What changes, and the template's default pose.
struct Changes {
    person: OsimPerson,
    masses: HashMap<String, f64>,
    meshes: HashMap<String, Vec<String>>,
    template_values: Values,
    /// World from body in the template's default pose: the template, and the person in the same pose.
    same_pose: [Places; 2],
}

impl Changes {
    fn new(model: &OsimModel, template: &Skeleton, person: &Skeleton, name: &str) -> Self {
        let template_values = model.default_values();
        let before = places(&model.joints, &template_values);
        let person = OsimPerson::new(model, &before, template, person);
        let after = places(&person.joints, &template_values);
        let same_pose = [before, after];
        let files = |body: &OsimBody| {
            let mesh = |k: usize| {
                let own = Path::new(&body.meshes[k].file);
                let own = own.file_stem().unwrap_or_default().to_string_lossy();
                format!(
                    "{}/{}_{}_{}.obj",
                    file_name(name),
                    file_name(&body.name),
                    k + 1,
                    file_name(&own)
                )
            };
            (body.name.clone(), (0..body.meshes.len()).map(mesh).collect())
        };
        let meshes = model.bodies.iter().map(files).collect();
        Self { person, masses: HashMap::new(), meshes, template_values, same_pose }
    }

    /// Masses grow with the volume; then all of them alike, to the person's. Returns their sum.
    fn set_masses(&mut self, bodies: &[OsimBody], mass: Option<f64>) -> f64 {
        let growth =
            |body: &OsimBody| Some(self.person.shapes.get(&body.name)?.scale.product().abs());
        let known = || bodies.iter().filter_map(|b| Some((b.mass, growth(b)?)));
        let before: f64 = known().map(|(mass, _)| mass).sum();
        let middle = if before > 0.0 {
            known().map(|(mass, growth)| mass * growth).sum::<f64>() / before
        } else {
            1.0
        };
        let factors: Vec<f64> = bodies.iter().map(|b| growth(b).unwrap_or(middle)).collect();
        let total: f64 = bodies.iter().zip(&factors).map(|(body, f)| body.mass * f).sum();
        let to_wanted = mass.filter(|_| total > 0.0).map_or(1.0, |wanted| wanted / total);
        let named = bodies.iter().zip(factors).map(|(body, f)| (body.name.clone(), f * to_wanted));
        self.masses = named.collect();
        total * to_wanted
    }

    /// Each bone comes apart into its body's meshes.
    fn write_meshes(&self, person: &Skeleton, files: OsimFiles, folder: &Path) -> Result<()> {
        let bodies = files.model.bodies_with_meshes().zip(files.meshes);
        for (bone, (body, parts)) in person.bones.iter().zip(bodies) {
            let mut rest = &person.points[bone.vertices.clone()];
            for ((mesh, mut part), file) in
                body.meshes.iter().zip(parts).zip(&self.meshes[&body.name])
            {
                let world = self.person.world[&body.name] * mesh.body_from_mesh;
                let (own, others) = rest.split_at(part.points.len());
                let seen = |p: &Vec3| world.inverse_transform_point(&Point3::from(*p)).coords;
                part.points = own.iter().map(seen).collect();
                rest = others;
                write_surface(&folder.join("Geometry").join(file), &part)?;
            }
        }
        Ok(())
    }
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
                original.shown()
            )));
        }
    }
    Ok(())
}

impl OsimChanges for Changes {
    fn joint(&self, name: &str) -> Option<&OsimJoint> {
        self.person.joints.iter().find(|j| j.name == name)
    }

    fn default_value(&self, coordinate: &str) -> Option<f64> {
        self.person.values.get(coordinate).copied()
    }

    fn meshes(&self, body: &str) -> Vec<String> {
        self.meshes.get(body).cloned().unwrap_or_default()
    }

    fn mass(&self, body: &str) -> f64 {
        self.masses.get(body).copied().unwrap_or(1.0)
    }

    fn scale(&self, body: &str) -> Option<Vec3> {
        self.person.shapes.get(body).map(|shape| shape.scale)
    }

    fn point(&self, body: &str, location: &Vec3) -> Option<Vec3> {
        self.person.shapes.get(body).map(|shape| shape.point(location))
    }

    fn template_value(&self, coordinate: &str) -> f64 {
        self.template_values.get(coordinate).copied().unwrap_or(0.0)
    }

    fn path_length(&self, points: &[(String, Vec3)]) -> Option<f64> {
        let [template, person] = &self.same_pose;
        let place = |world: &Places, body: &String, point: Vec3| {
            world.get(body).map(|body| body * Point3::from(point))
        };
        let before = points.iter().map(|(body, point)| place(template, body, *point));
        let after = points
            .iter()
            .map(|(body, point)| place(person, body, self.point(body, point).unwrap_or(*point)));
        let length = |points: Vec<Point3<f64>>| -> f64 {
            points.windows(2).map(|ends| (ends[1] - ends[0]).norm()).sum()
        };
        let before = length(before.collect::<Option<_>>()?);
        let after = length(after.collect::<Option<_>>()?);
        (before > 0.0 && after > 0.0).then(|| after / before)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::convert::conversion::{Conversion, convert};
    use crate::job::convert::osim_read::read_osim_skeleton;
    use crate::job::register::skeleton_files::read_skeleton;
    use crate::register::animation::present_angles;
    use crate::register::areas::vertex_areas;
    use crate::register::pose::rigid_targets;
    use crate::register::rotation::turned_about;
    use nalgebra::{Isometry3, UnitQuaternion};
    use std::path::PathBuf;

    const MODEL: &str = r#"<?xml version="1.0"?>
<OpenSimDocument Version="40000"><Model name="arm"><!-- a comment --><BodySet><objects>
 <Body name="a"><attached_geometry><Mesh><mesh_file>bone.obj</mesh_file><scale_factors>1 2 1</scale_factors></Mesh></attached_geometry>
  <mass>3</mass><inertia>2 3 4 0 0 0.5</inertia></Body>
 <Body name="b"><attached_geometry><Mesh><mesh_file>bone.obj</mesh_file></Mesh><Mesh><mesh_file>bone.obj</mesh_file><scale_factors>2 1 1</scale_factors></Mesh></attached_geometry>
  <WrapObjectSet><objects><WrapCylinder name="w"><xyz_body_rotation>0.1 0.2 0.3</xyz_body_rotation><translation>0.1 0.2 0.1</translation><radius>0.2</radius><length>2</length></WrapCylinder></objects></WrapObjectSet>
  <mass>1</mass></Body>
 <Body name="c"><mass>1</mass></Body></objects></BodySet>
<JointSet><objects>
 <WeldJoint name="base"><socket_parent_frame>/ground</socket_parent_frame><socket_child_frame>/bodyset/a</socket_child_frame></WeldJoint>
 <CustomJoint name="ab"><socket_parent_frame>f</socket_parent_frame><socket_child_frame>/bodyset/b</socket_child_frame>
  <coordinates><Coordinate name="bend"><default_value>0.2</default_value><range>-2 2</range></Coordinate></coordinates>
  <frames><PhysicalOffsetFrame name="f"><socket_parent>/bodyset/a</socket_parent><translation>2 0 0</translation><orientation>0.1 0.2 0.3</orientation></PhysicalOffsetFrame></frames>
  <SpatialTransform><TransformAxis name="rotation1"><coordinates>bend</coordinates><axis>0 0 1</axis><LinearFunction><coefficients>1 0</coefficients></LinearFunction></TransformAxis>
  <TransformAxis name="translation1"><coordinates>bend</coordinates><axis>1 0 0</axis><MultiplierFunction><function><SimmSpline><x>-2 0 1 2</x><y>0.1 0 0.1 0.3</y></SimmSpline></function><scale>2</scale></MultiplierFunction></TransformAxis>
  </SpatialTransform></CustomJoint>
 <WeldJoint name="bc"><socket_parent_frame>/bodyset/b</socket_parent_frame><socket_child_frame>/bodyset/c</socket_child_frame></WeldJoint>
 </objects></JointSet>
<ForceSet><Strange wish="kept"><GeometryPath><PathPoint name="p"><socket_parent_frame>/bodyset/a</socket_parent_frame><location>0.5 0.25 0</location></PathPoint>
 <ConditionalPathPoint name="never"><socket_parent_frame>/bodyset/a</socket_parent_frame><location>9 9 9</location><socket_coordinate>/jointset/ab/bend</socket_coordinate><range>1 2</range></ConditionalPathPoint>
 <MovingPathPoint name="m"><socket_parent_frame>/bodyset/b</socket_parent_frame><socket_x_coordinate>/jointset/ab/bend</socket_x_coordinate>
  <x_location><SimmSpline><x>-1 0 1 2</x><y>0.1 0.2 0.3 0.4</y></SimmSpline></x_location><y_location><Constant><value>0.3</value></Constant></y_location></MovingPathPoint>
 </GeometryPath><tendon_slack_length>2</tendon_slack_length></Strange></ForceSet>
</Model></OpenSimDocument>"#;

    const BONE: &str =
        "v 0 0 0\nv 1 0 0\nv 0 0.5 0\nv 0 0 0.3\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";

    /// The model in a folder of its own, and a file in it by name.
    fn arm(model: &str) -> (tempfile::TempDir, impl Fn(&str) -> PathBuf + use<>) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().to_path_buf();
        let at = move |name: &str| path.join(name);
        std::fs::write(at("arm.osim"), model).unwrap();
        std::fs::write(at("bone.obj"), BONE).unwrap();
        (folder, at)
    }

    /// The numbers in the first element of this name behind `start`.
    fn numbers_in(text: &str, start: &str, element: &str) -> Vec<f64> {
        let from = &text[text.find(start).unwrap()..];
        let inside = from.split(&format!("<{element}>")).nth(1).unwrap().split('<').next().unwrap();
        inside.split_whitespace().map(|x| x.parse().unwrap()).collect()
    }

    fn near(found: &[f64], wanted: &[f64]) -> bool {
        found.len() == wanted.len() && found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-9)
    }

    /// A person 1.1 times as large, the elbow bent, somewhere else.
    fn larger(template: &Skeleton, bend: f64) -> Skeleton {
        let mut person = in_metres(template, 1.1);
        let frame = person.joints[0].child_frame;
        let turn = frame.rotation * UnitQuaternion::from_scaled_axis(Vec3::z() * bend);
        let turn = turn * frame.rotation.inverse();
        let bend = turned_about(&Isometry3::identity(), &frame.translation.vector, turn);
        let away = Isometry3::new(Vec3::new(3.0, 1.0, -2.0), Vec3::new(0.3, 1.0, 0.2));
        person.move_bones(&[away, away * bend]);
        person
    }

    #[test]
    fn a_person_is_written_into_the_model_and_read_back() {
        let (_folder, at) = arm(MODEL);
        let to_skeleton = Conversion {
            from: at("arm.osim"),
            to: at("arm.skeleton.json"),
            ..Conversion::default()
        };
        convert(&to_skeleton).unwrap();
        let template = read_skeleton(&at("arm.skeleton.json")).unwrap();
        let person = larger(&template.skeleton, 0.7);
        std::fs::create_dir(at("out")).unwrap();
        let to = at("out/person.osim");
        write_osim(&at("arm.osim"), &person, &template.document, Some(10.0), &to).unwrap();

        let (document, meshes, _) = read_osim_skeleton(&to).unwrap();
        let again = build_skeleton(&document, meshes).unwrap();
        // The first bone stands where the template's stood; all else lies as the person.
        let areas = vertex_areas(&again.points, &again.triangles);
        let back = rigid_targets(&again, &person.points, &again.points, &areas)[0].unwrap();
        let far = again.points.iter().zip(&person.points);
        let far = far.map(|(p, q)| (p - (back * Point3::from(*q)).coords).norm());
        assert!(far.fold(0.0, f64::max) < 1e-6);
        let (a, b) = (&again.joints[0], back * person.joints[0].child_frame);
        let apart = a.child_frame.inv_mul(&b);
        assert!(apart.translation.vector.norm() < 1e-9 && apart.rotation.angle() < 1e-9);
        assert!((present_angles(&again)[0].1 - 0.9).abs() < 1e-9);
        let first = (0..4).map(|i| (again.points[i] - template.skeleton.points[i]).norm());
        assert!(first.fold(0.0, f64::max) < 0.2, "the ground does not move");
    }

    #[test]
    fn what_lies_on_the_bones_grows_with_them() {
        let (_folder, at) = arm(MODEL);
        let (document, meshes, _) = read_osim_skeleton(&at("arm.osim")).unwrap();
        let person = larger(&build_skeleton(&document, meshes).unwrap(), 0.0);
        let to = at("person.osim");
        let notes = write_osim(&at("arm.osim"), &person, &document, None, &to).unwrap();
        assert!(notes.iter().any(|n| n.contains("6.7 kg")), "{notes:?}");
        let text = std::fs::read_to_string(&to).unwrap();
        for kept in ["<!-- a comment -->", "wish=\"kept\"", "<range>1 2</range>"] {
            assert!(text.contains(kept), "{kept}");
        }
        let grown = 1.1_f64.powi(3);
        assert!(near(&numbers_in(&text, "\"a\"", "mass"), &[3.0 * grown]));
        assert!(near(&numbers_in(&text, "\"c\"", "mass"), &[grown]));
        let inertia = [2.0, 3.0, 4.0, 0.0, 0.0, 0.5].map(|x| x * 1.1_f64.powi(5));
        assert!(near(&numbers_in(&text, "\"a\"", "inertia"), &inertia));
        assert!(near(&numbers_in(&text, "\"w\"", "radius"), &[0.22]));
        assert!(near(&numbers_in(&text, "\"w\"", "length"), &[2.2]));
        assert!(near(&numbers_in(&text, "kept", "tendon_slack_length"), &[2.2]));
        assert!(near(&numbers_in(&text, "\"translation1\"", "y"), &[0.11, 0.0, 0.11, 0.33]));
        let x = numbers_in(&text, "<x_location>", "y");
        assert!(near(&x[1..].iter().zip(&x).map(|(a, b)| a - b).collect::<Vec<_>>(), &[0.11; 3]));

        write_osim(&at("arm.osim"), &person, &document, Some(10.0), &to).unwrap();
        let text = std::fs::read_to_string(&to).unwrap();
        let mass = |body| numbers_in(&text, body, "mass")[0];
        assert!((mass("\"a\"") - 6.0).abs() < 1e-9);
        assert!((mass("\"a\"") + mass("\"b\"") + mass("\"c\"") - 10.0).abs() < 1e-9);
        let nothing = write_osim(&at("arm.osim"), &person, &document, Some(0.0), &to);
        assert!(nothing.unwrap_err().to_string().contains("mass"));
    }

    #[test]
    fn a_coordinate_stays_within_its_range_and_the_frame_takes_up_the_rest() {
        let (_folder, at) = arm(&MODEL.replace("-2 2</range>", "-2 0.5</range>"));
        let (document, meshes, _) = read_osim_skeleton(&at("arm.osim")).unwrap();
        let person = larger(&build_skeleton(&document, meshes).unwrap(), 0.7);
        let to = at("person.osim");
        let notes = write_osim(&at("arm.osim"), &person, &document, None, &to).unwrap();
        assert!(
            notes.iter().any(|n| n.contains("bend") && n.contains("22.9 degrees")),
            "{notes:?}"
        );
        let text = std::fs::read_to_string(&to).unwrap();
        assert_eq!(numbers_in(&text, "\"bend\"", "default_value"), [0.5]);
        let (document, meshes, _) = read_osim_skeleton(&to).unwrap();
        let again = build_skeleton(&document, meshes).unwrap();
        let apart = |s: &Skeleton| (s.points[5] - s.points[0]).norm();
        assert!((apart(&again) - apart(&person)).abs() < 1e-9);
    }

    #[test]
    fn another_model_is_refused() {
        let (_folder, at) = arm(MODEL);
        let (document, meshes, _) = read_osim_skeleton(&at("arm.osim")).unwrap();
        let mut person = build_skeleton(&document, meshes).unwrap();
        person.bones[1].name = "c".into();
        let error = write_osim(&at("arm.osim"), &person, &document, None, &at("p.osim"));
        let error = error.unwrap_err().to_string();
        assert!(error.contains("bone b"), "{error}");
    }
}
