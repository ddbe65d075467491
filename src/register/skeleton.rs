//! The template: bones as one concatenated surface, joints as a graph with loops.

use std::ops::Range;

use nalgebra::{Isometry3, Point3, UnitQuaternion};

use super::joint_limits::JointLimits;
use super::joint_path::JointPath;
use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::mesh::TriMesh;

/// One bone: a part of the skeleton's surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Bone {
    /// Unique name.
    pub name: String,
    /// Value of this bone in label maps, where the template gives one.
    pub label: Option<u32>,
    /// Its vertices in [`Skeleton::points`].
    pub vertices: Range<usize>,
    /// Its triangles in [`Skeleton::triangles`].
    pub triangles: Range<usize>,
}

/// One named angle of a joint, for motions and reports.
#[derive(Clone, Debug, PartialEq)]
pub struct Coordinate {
    /// Name as in motion files.
    pub name: String,
    /// Unit axis in the joint's parent frame. The rotations of a joint's coordinates are
    /// multiplied in their order (intrinsic).
    pub axis: Vec3,
    /// Lowest and highest angle, radians.
    pub range: [f64; 2],
}

/// A joint between two bones. Frames are given in the template's pose and follow their bones.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Unique name.
    pub name: String,
    /// Index of the parent bone.
    pub parent: usize,
    /// Index of the child bone.
    pub child: usize,
    /// Joint frame carried by the parent: world from joint, template pose.
    pub parent_frame: Isometry3<f64>,
    /// Joint frame carried by the child: world from joint, template pose.
    pub child_frame: Isometry3<f64>,
    /// Limits of the rotation and shift of the child frame seen from the parent frame.
    pub limits: JointLimits,
    /// False for a joint that only closes a loop; such joints are left out of animations.
    pub in_tree: bool,
    /// Named angles; may be empty.
    pub coordinates: Vec<Coordinate>,
    /// How it goes in a motion, if an angle leads it: its only own one, or one of another joint.
    pub path: Option<JointPath>,
}

impl Joint {
    /// The bone at its other end, seen from `bone`; none if it is not a joint of that bone.
    pub fn neighbour(&self, bone: usize) -> Option<usize> {
        match bone {
            _ if self.parent == bone => Some(self.child),
            _ if self.child == bone => Some(self.parent),
            _ => None,
        }
    }

    /// Its bones in the order of a step of [`Skeleton::spanning_forest`]: the one reached before, and the one
    /// that this joint leads to.
    pub fn ends(&self, to_child: bool) -> (usize, usize) {
        if to_child { (self.parent, self.child) } else { (self.child, self.parent) }
    }

    /// The child frame seen from the parent frame after the bones moved by `parent` and `child`.
    pub fn transform(&self, parent: &Isometry3<f64>, child: &Isometry3<f64>) -> Isometry3<f64> {
        (parent * self.parent_frame).inv_mul(&(child * self.child_frame))
    }
}

/// A template skeleton. Indices are in range, points finite, every bone has triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Skeleton {
    /// Bones in the order given.
    pub bones: Vec<Bone>,
    /// Joints in the order given.
    pub joints: Vec<Joint>,
    /// Vertices of all bones, one bone after the other.
    pub points: Vec<Vec3>,
    /// Triangles of all bones; indices into `points`.
    pub triangles: Vec<[u32; 3]>,
}

impl Skeleton {
    /// Joins bone surfaces and checks names, joints and frames.
    pub fn new(surfaces: Vec<(String, TriMesh)>, joints: Vec<Joint>) -> Result<Self> {
        let mut skeleton = Self::default();
        for (name, mesh) in surfaces {
            skeleton.push_bone(name, &mesh)?;
        }
        for joint in joints {
            skeleton.push_joint(joint)?;
        }
        if skeleton.bones.is_empty() {
            return Err(Error::invalid(
                "the skeleton has no bone; list at least one under \"bones\"",
            ));
        }
        Ok(skeleton)
    }

    fn push_bone(&mut self, name: String, mesh: &TriMesh) -> Result<()> {
        if mesh.triangles.is_empty() {
            return Err(Error::invalid(format!(
                "bone {name} has no triangles; give a closed surface mesh"
            )));
        }
        if self.bone_index(&name).is_some() {
            return Err(Error::invalid(format!("two bones are named {name}; rename one of them")));
        }
        let (first_vertex, first_triangle) = (self.points.len(), self.triangles.len());
        let offset =
            u32::try_from(first_vertex + mesh.points.len())
                .map(|_| first_vertex as u32)
                .map_err(|_| Error::invalid("the skeleton has more than 4 billion vertices"))?;
        self.points.extend_from_slice(&mesh.points);
        self.triangles.extend(mesh.triangles.iter().map(|t| t.map(|v| v + offset)));
        self.bones.push(Bone {
            name,
            label: None,
            vertices: first_vertex..self.points.len(),
            triangles: first_triangle..self.triangles.len(),
        });
        Ok(())
    }

    fn push_joint(&mut self, joint: Joint) -> Result<()> {
        let name = &joint.name;
        for bone in [joint.parent, joint.child] {
            if bone >= self.bones.len() {
                return Err(Error::invalid(format!(
                    "joint {name} refers to bone {bone}, but there are only {} (numbered from 0)",
                    self.bones.len()
                )));
            }
        }
        if joint.parent == joint.child {
            return Err(Error::invalid(format!(
                "joint {name} connects bone {} with itself",
                self.bones[joint.parent].name
            )));
        }
        let frames = [&joint.parent_frame, &joint.child_frame];
        if frames.iter().any(|f| !f.to_homogeneous().iter().all(|x| x.is_finite())) {
            return Err(Error::invalid(format!(
                "joint {name} has a frame with a number that is not finite"
            )));
        }
        if self.joints.iter().any(|j| j.name == *name) {
            return Err(Error::invalid(format!("two joints are named {name}; rename one of them")));
        }
        self.joints.push(joint);
        Ok(())
    }

    /// Index of a bone by its name.
    pub fn bone_index(&self, name: &str) -> Option<usize> {
        self.bones.iter().position(|b| b.name == name)
    }

    /// Bone of every vertex.
    pub fn bone_of_vertex(&self) -> Vec<u32> {
        let mut bone_of = vec![0; self.points.len()];
        for (b, bone) in self.bones.iter().enumerate() {
            bone_of[bone.vertices.clone()].fill(b as u32);
        }
        bone_of
    }

    /// The surface of all bones.
    pub fn surface(&self) -> TriMesh {
        TriMesh { points: self.points.clone(), triangles: self.triangles.clone() }
    }

    /// The surface of bone `b` at given vertex positions of the whole skeleton, in the vertex order
    /// of the template's bone.
    pub fn bone_surface(&self, b: usize, points: &[Vec3]) -> TriMesh {
        let bone = &self.bones[b];
        let first = bone.vertices.start as u32;
        TriMesh {
            points: points[bone.vertices.clone()].to_vec(),
            triangles: self.triangles[bone.triangles.clone()]
                .iter()
                .map(|t| t.map(|v| v - first))
                .collect(),
        }
    }

    /// Moves every bone and its joint frames by its rigid transform.
    pub fn move_bones(&mut self, transforms: &[Isometry3<f64>]) {
        for (bone, transform) in self.bones.iter().zip(transforms) {
            for point in &mut self.points[bone.vertices.clone()] {
                *point = (transform * Point3::from(*point)).coords;
            }
        }
        for joint in &mut self.joints {
            joint.parent_frame = renormalized(&(transforms[joint.parent] * joint.parent_frame));
            joint.child_frame = renormalized(&(transforms[joint.child] * joint.child_frame));
        }
    }

    /// Makes every bone larger by `factor` about its own centre, with its sides of the joints.
    pub(super) fn scale_bones(&mut self, centres: &[Vec3], factor: f64) {
        let scale = |b: usize, place: &mut Vec3| {
            *place = centres[b] + factor * (*place - centres[b]);
        };
        for (b, bone) in self.bones.iter().enumerate() {
            self.points[bone.vertices.clone()].iter_mut().for_each(|point| scale(b, point));
        }
        for joint in &mut self.joints {
            scale(joint.parent, &mut joint.parent_frame.translation.vector);
            scale(joint.child, &mut joint.child_frame.translation.vector);
            joint.path.iter_mut().for_each(|path| path.scale(factor));
        }
    }

    /// Joints of a spanning forest in an order that starts at `root` (then at the first bone of
    /// every further part), each with a flag that tells whether the *child* is the bone reached.
    /// Joints that only close loops are used last.
    pub fn spanning_forest(&self, root: usize) -> Vec<(usize, bool)> {
        let mut reached = vec![false; self.bones.len()];
        let mut order = Vec::new();
        let seeds = std::iter::once(root).chain(0..self.bones.len());
        for seed in seeds {
            if std::mem::replace(&mut reached[seed], true) {
                continue;
            }
            while let Some((j, to_child)) = self.next_joint(&reached) {
                let joint = &self.joints[j];
                reached[joint.ends(to_child).1] = true;
                order.push((j, to_child));
            }
        }
        order
    }

    fn next_joint(&self, reached: &[bool]) -> Option<(usize, bool)> {
        let leads_out = |in_tree: bool| {
            self.joints.iter().enumerate().find_map(|(j, joint)| {
                let ends = (reached[joint.parent], reached[joint.child]);
                (joint.in_tree == in_tree && ends.0 != ends.1).then_some((j, ends.0))
            })
        };
        leads_out(true).or_else(|| leads_out(false))
    }
}

fn renormalized(frame: &Isometry3<f64>) -> Isometry3<f64> {
    let rotation = UnitQuaternion::new_normalize(frame.rotation.into_inner());
    Isometry3::from_parts(frame.translation, rotation)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A box of half sizes `half` around `centre` with `n` x `n` quads on each face.
    pub(crate) fn block(centre: Vec3, half: Vec3, n: u32) -> TriMesh {
        let mut mesh = TriMesh::default();
        for face in 0..6 {
            let (axis, side) = (face / 2, if face % 2 == 0 { 1.0 } else { -1.0 });
            let first = mesh.points.len() as u32;
            for i in 0..=n {
                for j in 0..=n {
                    let at = |k: u32| 2.0 * f64::from(k) / f64::from(n) - 1.0;
                    let mut unit = Vec3::zeros();
                    unit[axis] = side;
                    unit[(axis + 1) % 3] = at(i) * side;
                    unit[(axis + 2) % 3] = at(j);
                    mesh.points.push(centre + unit.component_mul(&half));
                }
            }
            for i in 0..n {
                for j in 0..n {
                    let a = first + i * (n + 1) + j;
                    mesh.triangles.push([a, a + n + 1, a + n + 2]);
                    mesh.triangles.push([a, a + n + 2, a + 1]);
                }
            }
        }
        mesh
    }

    /// A joint at `point` between two bones with the same frame on both sides.
    pub(crate) fn joint_at(
        name: &str,
        bones: [usize; 2],
        point: Vec3,
        limits: JointLimits,
    ) -> Joint {
        let frame = Isometry3::translation(point.x, point.y, point.z);
        Joint {
            name: name.into(),
            parent: bones[0],
            child: bones[1],
            parent_frame: frame,
            child_frame: frame,
            limits,
            in_tree: true,
            coordinates: Vec::new(),
            path: None,
        }
    }

    #[test]
    fn bones_are_joined_and_come_apart_again() {
        let limits = JointLimits::new(Vec3::zeros(), Vec3::zeros(), 1.0).unwrap();
        let a = block(Vec3::zeros(), Vec3::repeat(1.0), 2);
        let b = block(Vec3::new(3.0, 0.0, 0.0), Vec3::repeat(1.0), 1);
        let joint = joint_at("ab", [0, 1], Vec3::new(1.5, 0.0, 0.0), limits);
        let surfaces = vec![("a".to_string(), a.clone()), ("b".to_string(), b.clone())];
        let skeleton = Skeleton::new(surfaces.clone(), vec![joint.clone()]).unwrap();
        assert_eq!(skeleton.bone_surface(1, &skeleton.points), b);
        assert!(a.volume() > 7.99 && skeleton.spanning_forest(1) == vec![(0, false)]);

        let mut bad = joint.clone();
        bad.child = 2;
        assert!(Skeleton::new(surfaces.clone(), vec![bad]).is_err());
        assert!(Skeleton::new(surfaces, vec![joint.clone(), joint]).is_err());
        assert!(Skeleton::new(vec![("a".into(), a.clone()), ("a".into(), a)], vec![]).is_err());
        assert!(Skeleton::new(vec![], vec![]).is_err());
    }
}
