//! Skeletons with persons whose bones are known, and what is done to their scans.

use std::path::Path;

use moulage::TriMesh;
use moulage::error::Shown;
use moulage::io::{read_surface, read_volume};
use moulage::job::read_skeleton;
use moulage::locate::ClosestPoints;
use moulage::math::Vec3;
use moulage::register::{Skeleton, Target};
use moulage::volume::label_surface;
use nalgebra::{Isometry3, Point3, Unit, UnitQuaternion};

use super::hands;
use super::hands::damage::{self, ball, joined, mapped};

/// The made-up hands, by the seed of their sizes and angles.
const SCANS: [u64; 6] = [1, 2, 3, 4, 5, 6];

/// The person's bone, as far as it is known.
#[derive(Clone)]
pub enum Truth {
    /// The place of every vertex of the template.
    Vertices(Vec<Vec3>),
    /// Its surface.
    Surface(TriMesh),
    /// A part of its surface: it shows where the bone is wrong, not that the rest of it is right.
    Part(TriMesh),
}

pub struct Case {
    pub name: String,
    pub template: Skeleton,
    pub target: Target,
    /// The truth of each bone; none where the person has no such bone.
    pub truth: Vec<Option<Truth>>,
    /// The share of each bone that the target shows.
    pub shown: Vec<f64>,
    /// A bone further off than this is wrong.
    pub wrong: f64,
    /// What the program should say of the whole.
    pub refused: bool,
}

/// A template and a person without any damage.
struct Person {
    name: &'static str,
    template: Skeleton,
    scan: TriMesh,
    bones: Vec<TriMesh>,
    truth: Vec<Option<Truth>>,
    wrong: f64,
}

/// Target within this distance of a true place shows it, mm: more than the largest noise.
const SHOWN_WITHIN: f64 = 2.5;

impl Truth {
    /// The share of its places that a surface shows.
    fn shown_by(&self, surface: &ClosestPoints) -> f64 {
        let (Self::Vertices(points)
        | Self::Surface(TriMesh { points, .. })
        | Self::Part(TriMesh { points, .. })) = self;
        let shown = points.iter().filter(|p| surface.closest_within(p, SHOWN_WITHIN).is_some());
        shown.count() as f64 / points.len() as f64
    }
}

fn shown(truth: &[Option<Truth>], scan: &TriMesh) -> Vec<f64> {
    let search = ClosestPoints::new(&scan.points, &scan.triangles);
    truth.iter().map(|t| t.as_ref().map_or(0.0, |t| t.shown_by(&search))).collect()
}

fn mesh(path: &Path) -> TriMesh {
    read_surface(path).and_then(|file| file.mesh()).unwrap_or_else(|e| panic!("{e}"))
}

fn bone_file(folder: &Path, name: &str) -> TriMesh {
    let found = ["obj", "ply"].map(|e| folder.join(format!("{name}.{e}")));
    mesh(
        found
            .iter()
            .find(|p| p.is_file())
            .unwrap_or_else(|| panic!("{} has no {name}", folder.shown())),
    )
}

impl Person {
    fn read(
        name: &'static str,
        folder: &Path,
        person: &Path,
        same_vertices: bool,
        wrong: f64,
    ) -> Self {
        let template =
            read_skeleton(&folder.join("skeleton.json")).unwrap_or_else(|e| panic!("{e}")).skeleton;
        let bones: Vec<TriMesh> = template
            .bones
            .iter()
            .map(|b| bone_file(&person.join("target_bones"), &b.name))
            .collect();
        let truth = |b: &TriMesh| {
            Some(if same_vertices {
                Truth::Vertices(b.points.clone())
            } else {
                Truth::Surface(b.clone())
            })
        };
        let truth = bones.iter().map(truth).collect();
        let scan = mesh(&person.join("target_surface.ply"));
        Self { name, template, scan, bones, truth, wrong }
    }

    fn case(&self, what: &str, scan: TriMesh) -> Case {
        self.case_of(what, scan, self.truth.clone())
    }

    fn case_of(&self, what: &str, scan: TriMesh, truth: Vec<Option<Truth>>) -> Case {
        Case {
            name: format!("{}: {what}", self.name),
            template: self.template.clone(),
            shown: shown(&truth, &scan),
            target: Target::whole(scan).unwrap_or_else(|e| panic!("{e}")),
            truth,
            wrong: self.wrong,
            refused: false,
        }
    }

    /// The same with the truth moved along.
    fn moved(&self, what: &str, map: impl Fn(&Vec3) -> Vec3 + Copy) -> Case {
        let truth = self.truth.iter().map(|truth| {
            truth.as_ref().map(|truth| match truth {
                Truth::Vertices(points) => Truth::Vertices(points.iter().map(map).collect()),
                Truth::Surface(surface) => Truth::Surface(mapped(surface, map)),
                Truth::Part(surface) => Truth::Part(mapped(surface, map)),
            })
        });
        self.case_of(what, mapped(&self.scan, map), truth.collect())
    }

    fn without(&self, names: &[&str]) -> Case {
        let left = self.template.bones.iter().zip(&self.bones);
        let left = left.filter(|(bone, _)| !names.iter().any(|n| bone.name.starts_with(n)));
        let scan = left.fold(TriMesh::default(), |all, (_, bone)| joined(&all, bone));
        self.case(&format!("without {}", names.join(", ")), scan)
    }

    fn labelled(&self, what: &str, change: impl Fn(&TriMesh) -> TriMesh) -> Case {
        let names = self.template.bones.iter().map(|b| b.name.clone());
        let surfaces: Vec<(String, TriMesh)> = names.zip(self.bones.iter().map(change)).collect();
        let of_bone = self.truth.iter().zip(&surfaces);
        let shown =
            of_bone.map(|(truth, (_, surface))| shown(std::slice::from_ref(truth), surface)[0]);
        let shown = shown.collect();
        let left = surfaces.into_iter().filter(|(_, s)| !s.triangles.is_empty()).collect();
        let target = Target::per_bone(&self.template, left).unwrap_or_else(|e| panic!("{e}"));
        Case { target, shown, ..self.case(what, self.scan.clone()) }
    }
}

pub fn all(data: &Path) -> Vec<Case> {
    let mut cases = hand(data);
    cases.extend(scans());
    cases.extend(leg(data));
    cases.extend(pelvis(data));
    cases.extend(dogs(data));
    cases
}

fn hand(data: &Path) -> Vec<Case> {
    let folder = data.join("hand_skeleton");
    let hand = Person::read("hand", &folder, &folder, true, 2.0);
    let scan = &hand.scan;
    let centre = damage::centroid(scan);
    let scaled = |s: f64| move |p: &Vec3| centre + s * (p - centre);
    let turn = Isometry3::new(Vec3::new(100.0, -50.0, 30.0), Vec3::new(0.0, 2.5, 0.5));
    let mut cases = vec![
        hand.case("as it is", scan.clone()),
        hand.moved("turned", move |p| (turn * Point3::from(*p)).coords),
        hand.moved("moved 17 m", |p| p + Vec3::repeat(1e4)),
        hand.labelled("a surface for each bone", TriMesh::clone),
        hand.without(&["5proxph", "5midph", "5distph"]),
        hand.without(&["lunate", "capitate", "3mc", "2midph"]),
        hand.case("third cut off at one end", damage::cut(scan, 0.33, true)),
        hand.case("third cut off at the other end", damage::cut(scan, 0.33, false)),
        hand.case("third cut off at one end, closed", damage::cut_and_closed(scan, 0.33, true)),
        hand.case("third cut off at the other, closed", damage::cut_and_closed(scan, 0.33, false)),
        hand.case("tenth cut off at one end", damage::cut(scan, 0.1, true)),
        hand.case("tenth cut off at the other end", damage::cut(scan, 0.1, false)),
        hand.case("holes, a third", damage::holes(scan, 0.33, 6.0)),
        hand.case("holes, a tenth", damage::holes(scan, 0.1, 6.0)),
        hand.case("one side", damage::one_side(scan)),
        hand.case("3 balls of 10 mm", damage::blobs(scan, 3, 10.0)),
        hand.case("10 balls of 8 mm", damage::blobs(scan, 10, 8.0)),
    ];
    for factor in [0.6, 0.8, 1.2, 1.5] {
        cases.push(hand.moved(&format!("x {factor}"), scaled(factor)));
    }
    for deviation in [0.25, 0.5, 1.0, 2.0] {
        cases.push(hand.case(&format!("noise of {deviation} mm"), damage::noisy(scan, deviation)));
    }
    for (k, way) in [Vec3::x(), Vec3::y(), Vec3::z()].into_iter().enumerate() {
        let far = ball(centre + 150.0 * way, 40.0, 32);
        cases.push(
            hand.case(&format!("a ball of 40 mm, 150 mm away ({})", k + 1), joined(scan, &far)),
        );
    }
    cases.push(hand.case("inside out", damage::inside_out(scan)));
    let mirrored = damage::inside_out(&mapped(scan, |p| Vec3::new(-p.x, p.y, p.z)));
    cases.push(Case { refused: true, ..hand.case("mirrored", mirrored) });
    cases.push(Case { refused: true, ..hand.case("in metres", mapped(scan, |p| p / 1000.0)) });
    cases
}

/// Made-up hands in scans in which bones are fused at their joints.
fn scans() -> Vec<Case> {
    let template = hands::template();
    let scan = |seed: u64| {
        let truth = hands::in_a_pose(&hands::person(&template, seed, 0.0, hands::BUMPS), seed, 0.3);
        let scan = hands::fused_scan(&truth, seed);
        let bones: Vec<TriMesh> =
            (0..truth.bones.len()).map(|b| truth.bone_surface(b, &truth.points)).collect();
        let points = bones.iter().map(|b| Some(Truth::Vertices(b.points.clone()))).collect();
        Person { name: "scan", template: template.clone(), scan, bones, truth: points, wrong: 2.0 }
    };
    let mut cases = Vec::new();
    for seed in SCANS {
        let person = scan(seed);
        cases.push(person.case(&format!("hand {seed}"), person.scan.clone()));
        cases.push(
            person.case(
                &format!("hand {seed}, a tenth cut off"),
                damage::cut(&person.scan, 0.1, true),
            ),
        );
    }
    cases
}

fn leg(data: &Path) -> Vec<Case> {
    let folder = data.join("lowerlimb_vhm");
    let leg = Person::read("leg", &folder, &folder, false, 5.0);
    let mut cases = vec![
        leg.case("as it is", leg.scan.clone()),
        leg.labelled("a surface for each bone", TriMesh::clone),
    ];
    for bone in &leg.template.bones {
        cases.push(leg.without(&[&bone.name]));
    }
    cases.push(leg.case("tenth cut off at one end", damage::cut(&leg.scan, 0.1, true)));
    cases.push(leg.case("tenth cut off at the other end", damage::cut(&leg.scan, 0.1, false)));
    for (name, share) in [("twelfth", 0.08), ("sixth", 0.16), ("quarter", 0.25)] {
        cases.push(
            leg.case(&format!("{name} cut off at one end"), damage::cut(&leg.scan, share, true)),
        );
    }
    let closed = damage::cut_and_closed(&leg.scan, 0.1, true);
    cases.push(leg.case("tenth cut off at one end, closed", closed));
    cases.push(straighter_knee(&leg));
    let mirrored = damage::inside_out(&mapped(&leg.scan, |p| Vec3::new(-p.x, p.y, p.z)));
    cases.push(Case { refused: true, ..leg.case("mirrored", mirrored) });
    cases.push(Case { refused: true, ..leg.case("in metres", mapped(&leg.scan, |p| p / 1000.0)) });
    cases
}

/// The person's knee (centre and axis from the case's ground truth) 5 degrees straighter than the
/// template's range begins, and the fibula 3 % longer.
fn straighter_knee(leg: &Person) -> Case {
    let centre = Vec3::new(132.09, -32.85, -403.21);
    let axis = Unit::new_normalize(Vec3::new(-0.97323, -0.09643, -0.20865));
    let turn = UnitQuaternion::from_axis_angle(&axis, -5_f64.to_radians());
    let turned = |p: &Vec3| centre + turn * (p - centre);
    let bones =
        leg.template.bones.iter().zip(&leg.bones).map(|(bone, surface)| match bone.name.as_str() {
            "tibia_r" => mapped(surface, turned),
            "fibula_r" => {
                let low = surface.points.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
                let longer = |p: &Vec3| Vec3::new(p.x, p.y, low + 1.03 * (p.z - low));
                mapped(surface, |p| turned(&longer(p)))
            }
            _ => surface.clone(),
        });
    let bones: Vec<TriMesh> = bones.collect();
    let scan = bones.iter().fold(TriMesh::default(), |all, bone| joined(&all, bone));
    let truth = bones.into_iter().map(|bone| Some(Truth::Surface(bone))).collect();
    leg.case_of("knee 5 degrees beyond its limit, fibula 3 % longer", scan, truth)
}

/// Whole template bones on a CT whose border cuts pelvis and femur.
fn pelvis(data: &Path) -> Vec<Case> {
    let template = read_skeleton(&data.join("lowerlimb_vhm/skeleton.json"))
        .unwrap_or_else(|e| panic!("{e}"))
        .skeleton;
    let labels =
        read_volume(&data.join("ct_whole/labels.nii.gz")).unwrap_or_else(|e| panic!("{e}")).volume;
    let wanted = [("sacrum", 25), ("hip_r", 78), ("femur_r", 76)];
    let template = hands::only(&template, &wanted.map(|(name, _)| name));
    let seen = wanted.map(|(name, label)| {
        let (points, triangles) =
            label_surface(&labels, label).unwrap_or_else(|| panic!("no {name}"));
        (name.to_owned(), TriMesh { points, triangles })
    });
    let target = Target::per_bone(&template, seen.to_vec()).unwrap_or_else(|e| panic!("{e}"));
    let truth = seen.iter().map(|(_, surface)| Some(Truth::Part(surface.clone()))).collect();
    let name = "pelvis: CT that cuts the bones".into();
    let shown = vec![1.0; seen.len()];
    vec![Case { name, template, target, truth, shown, wrong: 5.0, refused: false }]
}

fn dogs(data: &Path) -> Vec<Case> {
    let folder = data.join("dog_skeleton");
    let mut cases = Vec::new();
    for (name, part) in [("dog .1", "strength_0.1"), ("dog .25", "strength_0.25"), ("dog", "")] {
        let dog = Person::read(name, &folder, &folder.join(part), true, 5.0);
        cases.push(dog.case("as it is", dog.scan.clone()));
        cases.push(dog.labelled("a surface for each bone", TriMesh::clone));
    }
    cases
}
